//! Hashes of files, taken while they are read.

use std::fmt;
use std::io::{self, Read, Seek, SeekFrom};

use sha2::{Digest, Sha256};

/// A SHA-256 hash; displayed in hexadecimal digits, as `sha256sum` prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Hash([u8; 32]);

impl Hash {
    /// Of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }

    /// Of all that was hashed.
    pub(crate) fn finished(hash: Sha256) -> Self {
        Self(hash.finalize().into())
    }
}

impl fmt::Display for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// A file whose bytes are hashed as they are read, each once and in their order.
pub(crate) struct Hashed<R> {
    input: R,
    hash: Sha256,
    /// How many bytes are hashed: all before this place.
    hashed: u64,
    /// Where the next read starts.
    position: u64,
}

impl<R: Read + Seek> Hashed<R> {
    /// Reads `input` from its start.
    pub(crate) fn new(input: R) -> Self {
        Self {
            input,
            hash: Sha256::new(),
            hashed: 0,
            position: 0,
        }
    }

    /// The hash of the whole file; reads what was not read yet.
    pub(crate) fn finish(mut self) -> io::Result<Hash> {
        self.seek(SeekFrom::Start(self.hashed))?;
        io::copy(&mut self, &mut io::sink())?;
        Ok(Hash::finished(self.hash))
    }
}

impl<R: Read> Read for Hashed<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.input.read(buffer)?;
        let end = self.position + count as u64;
        if end > self.hashed {
            let known = (self.hashed - self.position) as usize;
            self.hash.update(&buffer[known..count]);
            self.hashed = end;
        }
        self.position = end;
        Ok(count)
    }
}

impl<R: Read + Seek> Seek for Hashed<R> {
    /// Reads what is passed over for the first time.
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let target = self.input.seek(to)?;
        if target > self.hashed {
            self.position = self.input.seek(SeekFrom::Start(self.hashed))?;
            let gap = target - self.hashed;
            io::copy(&mut self.by_ref().take(gap), &mut io::sink())?;
            self.input.seek(SeekFrom::Start(target))?;
        }
        self.position = target;
        Ok(target)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// What FIPS 180-4 gives as an example.
    const ABC: &str = "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad";

    #[test]
    fn hashes_are_those_of_the_standard() {
        assert_eq!(Hash::of(b"abc").to_string(), ABC);
    }

    /// However a file is read, its hash is that of its bytes in their order.
    #[test]
    fn a_file_is_hashed_once_whatever_is_read() {
        let bytes: Vec<u8> = (0..100_000_u32)
            .map(|i| (i.wrapping_mul(i) >> 3) as u8)
            .collect();
        let expected = Hash::of(&bytes);
        let open = || Hashed::new(Cursor::new(&bytes));
        assert_eq!(open().finish().unwrap(), expected);
        let mut some = [0; 1000];
        for places in [
            &[0][..],
            &[0, 0],
            &[5000, 200, 99_500],
            &[99_999, 0],
            &[70, 60, 1060],
        ] {
            let mut file = open();
            for &place in places {
                file.seek(SeekFrom::Start(place)).unwrap();
                let count = file.read(&mut some).unwrap();
                let place = place as usize;
                assert_eq!(some[..count], bytes[place..place + count]);
            }
            assert_eq!(file.finish().unwrap(), expected, "{places:?}");
        }
    }
}
