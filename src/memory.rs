//! Memory that is asked for before it is taken, so that a lack of it is an error with a figure.
//!
//! What Rust allocates without asking ends the process where there is no memory. So whatever has the
//! size of a file or of a number in one is reserved here first ([`reserve`]), and whatever is about to
//! be allocated in many pieces is looked for as a whole ([`look_for`]).

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt;

/// There is not so much memory.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("out of memory: {what} would take {}, more than there is", Size(*.bytes))]
pub struct OutOfMemory {
    /// What it was for.
    pub what: Cow<'static, str>,
    /// What was asked for.
    pub bytes: u64,
}

impl OutOfMemory {
    /// So many bytes, for whatever it was.
    const fn new(bytes: u64) -> Self {
        Self {
            what: Cow::Borrowed("this"),
            bytes,
        }
    }

    /// The same, and what it was for: "the shapes and trees".
    #[must_use]
    pub fn for_what(self, what: impl Into<Cow<'static, str>>) -> Self {
        Self {
            what: what.into(),
            ..self
        }
    }
}

/// Makes room for `additional` items in `items`; where these move, there is room for half as many
/// again as there are, as [`Vec::push`] would see to.
///
/// # Errors
/// If there is not so much memory; the items are as they were.
pub(crate) fn reserve<T>(items: &mut Vec<T>, additional: usize) -> Result<(), OutOfMemory> {
    items.try_reserve(additional).map_err(|_| {
        let count = (items.len() as u64).saturating_add(additional as u64);
        OutOfMemory::new(count.saturating_mul(size_of::<T>() as u64))
    })
}

/// Makes room for `additional` names in a map.
///
/// # Errors
/// If there is not so much memory.
pub(crate) fn reserve_names<T>(
    names: &mut HashMap<&str, T>,
    additional: usize,
) -> Result<(), OutOfMemory> {
    names.try_reserve(additional).map_err(|_| {
        // A map keeps an eighth of its places free, and a byte for each.
        let place = size_of::<(&str, T)>() as u64 + 1;
        let bytes = (additional as u64).saturating_mul(place) / 7 * 8;
        OutOfMemory::new(bytes).for_what("the names of the scene's entries")
    })
}

/// Whether the system would give so many bytes now. They are not kept: it is for what many
/// allocations will take together, shortly before they do.
///
/// # Errors
/// If it would not.
pub(crate) fn look_for(bytes: u64) -> Result<(), OutOfMemory> {
    let mut block: Vec<u8> = Vec::new();
    let fits = usize::try_from(bytes).is_ok_and(|count| block.try_reserve_exact(count).is_ok());
    if fits {
        Ok(())
    } else {
        Err(OutOfMemory::new(bytes))
    }
}

/// Whether the system would give the stacks of so many threads now. One that gets its stack, but then no more,
/// ends the process.
///
/// # Errors
/// If it would not.
pub fn look_for_threads(threads: usize) -> Result<(), OutOfMemory> {
    /// What the standard library takes for a stack, unless its variable says more.
    const STACK: u64 = 2 << 20;
    /// Of its guard pages, its second stack for signals, and what it allocates before it works.
    const BESIDE: u64 = 256 << 10;
    let said = std::env::var("RUST_MIN_STACK").ok();
    let stack = said.and_then(|said| said.parse().ok()).unwrap_or(STACK);
    look_for((stack.saturating_add(BESIDE)).saturating_mul(threads as u64))
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
        let written =
            [0, 999, 1000, 123_456, 48_000_000_000, u64::MAX].map(|n| Size(n).to_string());
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
        let error = Err(OutOfMemory::new(bytes));
        assert_eq!(reserve(&mut items, (1 << 58) - 1), error);
        assert_eq!(
            reserve(&mut items, usize::MAX),
            Err(OutOfMemory::new(u64::MAX))
        );
        assert_eq!(items, [1]);
        assert_eq!(look_for(1000), Ok(()));
        assert_eq!(look_for(bytes), error);
        let error = OutOfMemory::new(172_800_000_000).for_what("the table");
        assert_eq!(
            error.to_string(),
            "out of memory: the table would take 172.8 GB, more than there is"
        );
    }
}
