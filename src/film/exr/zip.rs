//! OpenEXR's ZIP compression: the bytes of a block, low ones before high ones, as differences to the byte
//! before, deflated.

/// Compresses one block after the other.
#[derive(Debug, Default)]
pub(super) struct Zip {
    parted: Vec<u8>,
    differences: Vec<u8>,
}

impl Zip {
    /// Appends what the file has of a block: the block itself, little-endian, where compression would not make
    /// it shorter.
    pub(super) fn compress(&mut self, block: &[u8], out: &mut Vec<u8>) {
        let (pairs, odd) = block.as_chunks::<2>();
        self.parted.clear();
        self.parted.extend(pairs.iter().map(|pair| pair[0]));
        self.parted.extend_from_slice(odd);
        self.parted.extend(pairs.iter().map(|pair| pair[1]));

        self.differences.clear();
        self.differences.extend(self.parted.first());
        let neighbors = self.parted.iter().zip(&self.parted[1..]);
        // 128 is no difference.
        let differences =
            neighbors.map(|(before, byte)| byte.wrapping_sub(*before).wrapping_add(128));
        self.differences.extend(differences);

        let deflated = miniz_oxide::deflate::compress_to_vec_zlib(&self.differences, 4);
        if deflated.len() < block.len() {
            out.extend_from_slice(&deflated);
        } else {
            out.extend_from_slice(block);
        }
    }
}
