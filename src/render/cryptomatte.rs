//! Cryptomatte (Friedman and Jones 2015, specification 1.2.0 of Psyop): names as numbers in channels.
//!
//! A name is hashed by MurmurHash3 to 32 bits, which are taken as an f32. A layer such as `CryptoObject` has further
//! layers `CryptoObject00`, `CryptoObject01`, … with two names each, R and B the ids, G and A the part of the pixel that
//! each covers, the largest first. The header says which id is which name.

use std::fmt::Write;

/// What stands for a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Id(u32);

impl Id {
    /// Of a name, by its bytes in UTF-8. What would be infinite, not a number, 0 or subnormal as an f32 has bit 23
    /// flipped.
    pub(super) fn of(name: &str) -> Self {
        let hash = murmur_hash_3(name.as_bytes());
        let exponent = hash >> 23 & 0xff;
        let is_normal = (1..255).contains(&exponent);
        Self(if is_normal { hash } else { hash ^ 1 << 23 })
    }

    /// As channels have it.
    pub(super) fn value(self) -> f32 {
        f32::from_bits(self.0)
    }
}

/// What the header says of a layer, as names of attributes and texts.
pub(super) fn attributes<'n>(
    layer: &str,
    names: impl Iterator<Item = &'n str>,
) -> [(String, String); 4] {
    let mut manifest = String::from("{");
    for (number, name) in names.enumerate() {
        let comma = if number == 0 { "" } else { "," };
        let key = serde_json::to_string(name).expect("a text is JSON");
        write!(manifest, "{comma}{key}:\"{:08x}\"", Id::of(name).0)
            .expect("a String takes any text");
    }
    manifest.push('}');
    let hash = format!("{:08x}", murmur_hash_3(layer.as_bytes()));
    let attribute = |name: &str, text: String| (format!("cryptomatte/{}/{name}", &hash[..7]), text);
    [
        attribute("name", layer.to_owned()),
        attribute("hash", "MurmurHash3_32".to_owned()),
        attribute("conversion", "uint32_to_float32".to_owned()),
        attribute("manifest", manifest),
    ]
}

/// MurmurHash3_x86_32 with seed 0 (Appleby 2011, in the public domain).
fn murmur_hash_3(bytes: &[u8]) -> u32 {
    let mixed = |block: u32| {
        block
            .wrapping_mul(0xcc9e_2d51)
            .rotate_left(15)
            .wrapping_mul(0x1b87_3593)
    };
    let (blocks, rest) = bytes.as_chunks::<4>();
    let mut hash = blocks.iter().fold(0_u32, |hash, &block| {
        let hash = (hash ^ mixed(u32::from_le_bytes(block))).rotate_left(13);
        hash.wrapping_mul(5).wrapping_add(0xe654_6b64)
    });
    let mut last = [0; 4];
    last[..rest.len()].copy_from_slice(rest);
    hash ^= mixed(u32::from_le_bytes(last));
    hash ^= bytes.len() as u32;
    hash = (hash ^ hash >> 16).wrapping_mul(0x85eb_ca6b);
    hash = (hash ^ hash >> 13).wrapping_mul(0xc2b2_ae35);
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of the reference implementation, and of published Cryptomatte files.
    #[test]
    fn hashes_are_the_published_ones() {
        for (name, hash) in [
            ("", 0),
            ("hello", 0x248b_fa47),
            ("cube", 0xd968_2f08),
            ("CryptoObject", 0x3ae3_9a58),
            ("CryptoMaterial", 0xbe35_9d67),
        ] {
            assert_eq!(murmur_hash_3(name.as_bytes()), hash, "{name}");
        }
    }

    #[test]
    fn ids_are_normal_numbers() {
        for number in 0..100_000 {
            assert!(Id::of(&number.to_string()).value().is_normal());
        }
        // The hash of an empty name is 0.
        assert_eq!(Id::of("").0, 1 << 23);
    }

    #[test]
    fn a_manifest_is_json_of_any_names() {
        let names = ["cube", "mit \"Zeichen\"", "球.left arm"];
        let attributes = attributes("CryptoObject", names.into_iter());
        let keys = attributes.each_ref().map(|(key, _)| key.as_str());
        assert_eq!(
            keys,
            ["name", "hash", "conversion", "manifest"]
                .map(|key| format!("cryptomatte/3ae39a5/{key}"))
        );
        let manifest: serde_json::Value = serde_json::from_str(&attributes[3].1).unwrap();
        assert_eq!(manifest["cube"], "d9682f08");
        for name in names {
            assert_eq!(manifest[name], format!("{:08x}", Id::of(name).0));
        }
        assert_eq!(
            attributes[3].1.len() - attributes[3].1.replace(' ', "").len(),
            2
        );
    }
}
