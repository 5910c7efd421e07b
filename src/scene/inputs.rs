//! What a picture depends on, as hashes: of the scene file, of the files that it names, and of the
//! content of scenes that no file has.

use std::collections::HashMap;
use std::fmt::{self, Write as _};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::PathBuf;
use std::sync::Arc;

use sha2::{Digest, Sha256};

use super::{MeshFile, Object, Scene};

/// A SHA-256 hash; displayed in hexadecimal digits, as `sha256sum` prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Hash([u8; 32]);

impl Hash {
    /// Of these bytes.
    pub fn of(bytes: &[u8]) -> Self {
        Self(Sha256::digest(bytes).into())
    }
}

impl fmt::Display for Hash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

/// A file that a scene names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Input {
    /// As written in the scene.
    pub name: String,
    /// Joined to the scene's folder.
    pub path: PathBuf,
    /// Of its bytes as they were read.
    pub hash: Hash,
}

impl Scene {
    /// SHA-256 of the scene file's text; of a scene made in code, whose text is empty, of all that
    /// it holds: it differs wherever a value differs, and is the same for the same values with
    /// one version of candela.
    pub fn hash(&self) -> Hash {
        if self.source.text.is_empty() {
            self.content_hash()
        } else {
            Hash::of(self.source.text.as_bytes())
        }
    }

    /// SHA-256 of all files that the picture depends on: of the lines that are the hash of the scene
    /// file, as `sha256sum` prints it, then of each file that the scene names, in the order of
    /// [`Scene::inputs`]. A scene that names no other file has one line. Names are no part of it: those
    /// of meshes and curves stand in the scene file. Of a scene made in code it is [`Scene::hash`], which
    /// covers its meshes and curves.
    pub fn inputs_hash(&self) -> Hash {
        let hash = self.hash();
        if self.source.text.is_empty() {
            return hash;
        }
        let mut lines = Hasher::default();
        for hash in std::iter::once(&hash).chain(self.inputs.iter().map(|input| &input.hash)) {
            lines.line(hash);
        }
        lines.finish()
    }

    fn content_hash(&self) -> Hash {
        let Self {
            source: _,
            image,
            camera,
            materials,
            lights,
            objects,
            inputs: _,
        } = self;
        let mut hasher = Hasher::default();
        let mut meshes: HashMap<*const MeshFile, usize> = HashMap::new();
        hasher.debug(image);
        hasher.debug(camera);
        hasher.debug(materials);
        hasher.debug(lights);
        for entry in objects {
            let mut entry = entry.clone();
            if let Object::Mesh { geometry, .. } = &mut entry.value {
                // Each mesh once, however many objects have it: where it comes first.
                let count = meshes.len();
                let number = *meshes.entry(Arc::as_ptr(geometry)).or_insert_with(|| {
                    hasher.debug(geometry);
                    count
                });
                hasher.debug(&number);
                *geometry = Arc::default();
            }
            hasher.debug(&entry);
        }
        hasher.finish()
    }
}

/// Hashes text as it is written.
#[derive(Default)]
struct Hasher(Sha256);

impl fmt::Write for Hasher {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.0.update(text.as_bytes());
        Ok(())
    }
}

impl Hasher {
    /// A hash on a line of its own.
    fn line(&mut self, hash: &Hash) {
        writeln!(self, "{hash}").expect("a hash takes any text");
    }

    /// A value with all its digits and names.
    fn debug(&mut self, value: &impl fmt::Debug) {
        writeln!(self, "{value:?}").expect("a hash takes any text");
    }

    fn finish(self) -> Hash {
        Hash(self.0.finalize().into())
    }
}

/// A file whose bytes are hashed as they are read, each once and in their order.
pub(super) struct Hashed<R> {
    input: R,
    hash: Sha256,
    /// How many bytes are hashed: all before this place.
    hashed: u64,
    /// Where the next read starts.
    position: u64,
}

impl<R: Read + Seek> Hashed<R> {
    /// Reads `input` from its start.
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            hash: Sha256::new(),
            hashed: 0,
            position: 0,
        }
    }

    /// The hash of the whole file; reads what was not read yet.
    pub(super) fn finish(mut self) -> io::Result<Hash> {
        self.seek(SeekFrom::Start(self.hashed))?;
        io::copy(&mut self, &mut io::sink())?;
        Ok(Hash(self.hash.finalize().into()))
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
