//! OpenEXR's ZIP compression: the bytes of a block, low ones before high ones, as differences to the
//! byte before, deflated.
//!
//! The `exr` crate does the same with deflate at level 4, which spends six times as long on light in
//! FLOAT as level 1: the low bytes of mantissas are noise, in which there is nothing to find. What
//! there is to save are long repeats, such as a background, full coverage, or a channel equal to
//! another, and level 1 finds these as well. Its files are 9 % larger (16.3 → 17.8 MB for
//! 1920 × 1080). HALF has less noise, and is worth level 3.

use exr::meta::attribute::Compression;
use miniz_oxide::DataFormat;
use miniz_oxide::deflate::core::{CompressorOxide, TDEFLFlush, TDEFLStatus, compress};

/// Compresses one block after the other, each by itself.
pub(super) struct Zip {
    deflate: CompressorOxide,
    parted: Vec<u8>,
    differences: Vec<u8>,
}

impl Zip {
    /// What compresses a file's blocks, if that is ZIP and done here, and not by the `exr` crate.
    pub(super) fn of(compression: Compression, is_float: bool) -> Option<Self> {
        match compression {
            // Elsewhere values have to be turned around, which the `exr` crate does.
            Compression::ZIP1 | Compression::ZIP16 if cfg!(target_endian = "little") => {
                Some(Self::new(is_float))
            }
            Compression::ZIP1
            | Compression::ZIP16
            | Compression::Uncompressed
            | Compression::RLE
            | Compression::PIZ
            | Compression::PXR24
            | Compression::B44
            | Compression::B44A
            | Compression::DWAA(_)
            | Compression::DWAB(_)
            | Compression::HTJ2K32
            | Compression::HTJ2K256 => None,
        }
    }

    /// For blocks that are mostly FLOAT or not.
    pub(super) fn new(is_float: bool) -> Self {
        let mut deflate = CompressorOxide::default();
        deflate.set_format_and_level(DataFormat::Zlib, if is_float { 1 } else { 3 });
        Self {
            deflate,
            parted: Vec::new(),
            differences: Vec::new(),
        }
    }

    /// Appends what the file has of a block of little-endian values: the block as it is where
    /// compression would not make it shorter.
    pub(super) fn compress(&mut self, block: &[u8], out: &mut Vec<u8>) {
        let (pairs, odd) = block.as_chunks::<2>();
        self.parted.clear();
        self.parted.extend(pairs.iter().map(|pair| pair[0]));
        self.parted.extend_from_slice(odd);
        self.parted.extend(pairs.iter().map(|pair| pair[1]));

        self.differences.clear();
        self.differences.extend(self.parted.first());
        let neighbors = self.parted.windows(2);
        // 128 stands for no difference.
        let differences = neighbors.map(|pair| pair[1].wrapping_sub(pair[0]).wrapping_add(128));
        self.differences.extend(differences);

        let start = out.len();
        // Readers take what is as long as the block for the block.
        out.resize(start + block.len().saturating_sub(1), 0);
        self.deflate.reset();
        let finish = TDEFLFlush::Finish;
        let (status, _, length) = compress(
            &mut self.deflate,
            &self.differences,
            &mut out[start..],
            finish,
        );
        match status {
            TDEFLStatus::Done => out.truncate(start + length),
            // There is no room for all of it.
            TDEFLStatus::Okay | TDEFLStatus::BadParam | TDEFLStatus::PutBufFailed => {
                out.truncate(start);
                out.extend_from_slice(block);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As OpenEXR's documentation has it: inflate, sum up, put low and high bytes side by side.
    fn decompress(file: &[u8], length: usize) -> Vec<u8> {
        if file.len() == length {
            return file.to_vec();
        }
        let mut bytes = miniz_oxide::inflate::decompress_to_vec_zlib(file).unwrap();
        for i in 1..bytes.len() {
            bytes[i] = bytes[i - 1].wrapping_add(bytes[i]).wrapping_sub(128);
        }
        let (low, high) = bytes.split_at(bytes.len().div_ceil(2));
        let mut block = vec![0; length];
        for (i, byte) in block.iter_mut().enumerate() {
            *byte = if i % 2 == 0 { low[i / 2] } else { high[i / 2] };
        }
        block
    }

    #[test]
    fn blocks_come_back() {
        let mut state = 1_u32;
        let mut noise = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 24) as u8
        };
        let noise: Vec<u8> = (0..70_001).map(|_| noise()).collect();
        let smooth: Vec<u8> = (0..40_000_u32)
            .flat_map(|i| ((i as f32).sqrt()).to_le_bytes())
            .collect();
        let flat = vec![0; 100_000];
        for is_float in [true, false] {
            let mut zip = Zip::new(is_float);
            // Long ones before short ones and again, so that what is left of one would show in another.
            for block in [&noise, &smooth, &flat, &noise, &flat] {
                for length in [block.len(), 1000, 17, 3, 2, 1, 0] {
                    let block = &block[..length];
                    let mut out = vec![7];
                    zip.compress(block, &mut out);
                    assert_eq!(out[0], 7);
                    assert!(out.len() <= 1 + length);
                    assert_eq!(decompress(&out[1..], length), block);
                }
            }
            let mut out = Vec::new();
            zip.compress(&noise, &mut out);
            assert_eq!(out, noise);
            out.clear();
            zip.compress(&flat, &mut out);
            assert!(out.len() < 1000, "{}", out.len());
        }
    }
}
