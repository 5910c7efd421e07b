//! Memory that is asked for before it is taken, so that a lack of it is an error with a figure.
//!
//! What Rust allocates without asking ends the process where there is no memory. So whatever has the
//! size of a file or of a number in one is reserved here first ([`reserve`]), and whatever is about to
//! be allocated in many pieces is looked for as a whole ([`look_for`]).

use std::fmt;

/// There is not so much memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{} of memory, more than there is", Size(*.bytes))]
pub struct OutOfMemory {
    /// What was asked for.
    pub bytes: u64,
}

/// Makes room for `additional` items in `items`; where these move, there is room for half as many
/// again as there are, as [`Vec::push`] would see to.
///
/// # Errors
/// If there is not so much memory; the items are as they were.
pub fn reserve<T>(items: &mut Vec<T>, additional: usize) -> Result<(), OutOfMemory> {
    items.try_reserve(additional).map_err(|_| OutOfMemory {
        bytes: (items.len() as u64)
            .saturating_add(additional as u64)
            .saturating_mul(size_of::<T>() as u64),
    })
}

/// Whether the system would give so many bytes now. They are not kept: it is for what many
/// allocations will take together, shortly before they do.
///
/// # Errors
/// If it would not.
pub fn look_for(bytes: u64) -> Result<(), OutOfMemory> {
    let mut block: Vec<u8> = Vec::new();
    let count = usize::try_from(bytes).map_err(|_| OutOfMemory { bytes })?;
    block
        .try_reserve_exact(count)
        .map_err(|_| OutOfMemory { bytes })
}

/// Bytes in the unit that fits them, of which each is 1000 times the one before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size(pub u64);

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        const UNITS: [&str; 4] = ["B", "kB", "MB", "GB"];
        let mut value = self.0 as f64;
        let mut unit = 0;
        while value >= 1000.0 && unit + 1 < UNITS.len() {
            value /= 1000.0;
            unit += 1;
        }
        let decimals = usize::from(unit > 0);
        write!(f, "{value:.decimals$} {}", UNITS[unit])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_have_units() {
        let written = [0, 999, 1000, 123_456, 48_000_000_000, u64::MAX].map(|n| Size(n).to_string());
        let expected = ["0 B", "999 B", "1.0 kB", "123.5 kB", "48.0 GB"];
        assert_eq!(written[..5], expected);
        assert_eq!(written[5], "18446744073.7 GB");
    }

    #[test]
    fn what_there_is_not_is_an_error() {
        let mut items = vec![1_u64];
        assert_eq!(reserve(&mut items, 1000), Ok(()));
        assert!(items.capacity() >= 1001);
        let bytes = 8 << 58;
        assert_eq!(reserve(&mut items, (1 << 58) - 1), Err(OutOfMemory { bytes }));
        assert_eq!(reserve(&mut items, usize::MAX), Err(OutOfMemory { bytes: u64::MAX }));
        assert_eq!(items, [1]);
        assert_eq!(look_for(1000), Ok(()));
        assert_eq!(look_for(bytes), Err(OutOfMemory { bytes }));
        assert_eq!(
            OutOfMemory { bytes: 172_800_000_000 }.to_string(),
            "172.8 GB of memory, more than there is"
        );
    }
}
