//! Files that hold the right text in a form that is not read.

/// A form that the first bytes of a file tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Foreign {
    /// Text in UTF-16, the low byte first.
    Utf16Le,
    /// Text in UTF-16, the high byte first.
    Utf16Be,
    /// Text in UTF-32.
    Utf32,
    /// Compressed by gzip.
    Gzip,
}

impl Foreign {
    /// What a file that starts with these bytes is, if it is one of these.
    pub(crate) fn of(start: &[u8]) -> Option<Self> {
        match start {
            [0xff, 0xfe, 0, 0, ..] | [0, 0, 0xfe, 0xff, ..] => Some(Self::Utf32),
            [0xff, 0xfe, ..] => Some(Self::Utf16Le),
            [0xfe, 0xff, ..] => Some(Self::Utf16Be),
            [0x1f, 0x8b, 8, ..] => Some(Self::Gzip),
            _ => Self::of_ascii_pairs(start),
        }
    }

    /// UTF-16 without a byte order mark: of ASCII characters, every second byte is 0.
    fn of_ascii_pairs(start: &[u8]) -> Option<Self> {
        /// Enough not to take a coincidence for text.
        const LEAST: usize = 4;
        const LOOKED_AT: usize = 32;
        let (pairs, _) = start.as_chunks::<2>();
        let pairs = &pairs[..pairs.len().min(LOOKED_AT)];
        let is_ascii = |byte: u8| byte != 0 && byte.is_ascii();
        if pairs.len() < LEAST {
            None
        } else if pairs.iter().all(|&[low, high]| is_ascii(low) && high == 0) {
            Some(Self::Utf16Le)
        } else if pairs.iter().all(|&[high, low]| is_ascii(low) && high == 0) {
            Some(Self::Utf16Be)
        } else {
            None
        }
    }

    /// What to do with it.
    pub const fn way_out(self) -> &'static str {
        match self {
            Self::Utf16Le | Self::Utf16Be | Self::Utf32 => "save it as UTF-8",
            Self::Gzip => "unpack it",
        }
    }
}

impl std::fmt::Display for Foreign {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Utf16Le => "text in UTF-16 (little endian)",
            Self::Utf16Be => "text in UTF-16 (big endian)",
            Self::Utf32 => "text in UTF-32",
            Self::Gzip => "compressed by gzip",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn encodings_with_and_without_a_mark() {
        let text = "v 0 0 0\n";
        let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
        let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
        assert_eq!(Foreign::of(&little), Some(Foreign::Utf16Le));
        assert_eq!(Foreign::of(&big), Some(Foreign::Utf16Be));
        assert_eq!(
            Foreign::of(&[&[0xff, 0xfe], &little[..]].concat()),
            Some(Foreign::Utf16Le)
        );
        assert_eq!(
            Foreign::of(&[&[0xfe, 0xff], &big[..]].concat()),
            Some(Foreign::Utf16Be)
        );
        assert_eq!(Foreign::of(b"\xff\xfe\0\0v\0\0\0"), Some(Foreign::Utf32));
        assert_eq!(Foreign::of(b"\x1f\x8b\x08\0"), Some(Foreign::Gzip));
        for usual in [
            &b""[..],
            b"v",
            b"ply\n",
            text.as_bytes(),
            b"\xef\xbb\xbfv 0 0",
            &[0; 64],
        ] {
            assert_eq!(Foreign::of(usual), None);
        }
    }
}
