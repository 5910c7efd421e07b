//! The bound on what a mesh may take in memory, whatever its file says.

use super::error::Fault;
use super::limits::TIMES_FILE_SIZE;

/// The memory that loading may take whatever the file's size is, in bytes.
const BASE: usize = 48 << 20;

/// What loading may still allocate.
#[derive(Debug)]
pub(super) struct Memory {
    left: usize,
}

impl Memory {
    /// The allowance for a file of `size` bytes.
    pub(super) const fn for_file(size: usize) -> Self {
        Self {
            left: size.saturating_mul(TIMES_FILE_SIZE).saturating_add(BASE),
        }
    }

    /// Room for `additional` more items in `items`, named `what` in messages.
    ///
    /// Grows by half where it must move, and counts the old and the new place while it does.
    #[inline]
    pub(super) fn make_room<T>(
        &mut self,
        items: &mut Vec<T>,
        additional: usize,
        what: &'static str,
    ) -> Result<(), Box<Fault>> {
        if items.capacity() - items.len() >= additional {
            return Ok(());
        }
        self.grow(items, additional, what)
    }

    #[cold]
    fn grow<T>(
        &mut self,
        items: &mut Vec<T>,
        additional: usize,
        what: &'static str,
    ) -> Result<(), Box<Fault>> {
        const FIRST: usize = 64;
        let most = u32::MAX as usize;
        let needed = items.len().saturating_add(additional);
        if needed > most {
            return Err(Box::new(Fault::TooMany { what }));
        }
        let comfortable = needed
            .max(items.len() + items.len() / 2)
            .max(FIRST)
            .min(most);
        let old = items.capacity() * size_of::<T>();
        let capacity = [comfortable, needed]
            .into_iter()
            .find(|&capacity| capacity.saturating_mul(size_of::<T>()) <= self.left)
            .ok_or(Box::new(Fault::TooLarge))?;
        items
            .try_reserve_exact(capacity - items.len())
            .map_err(|_| Box::new(Fault::NoMemory))?;
        self.left = (self.left + old).saturating_sub(items.capacity() * size_of::<T>());
        Ok(())
    }

    /// Counts `bytes` that are allocated elsewhere.
    pub(super) fn take(&mut self, bytes: usize) -> Result<(), Box<Fault>> {
        self.left = self
            .left
            .checked_sub(bytes)
            .ok_or(Box::new(Fault::TooLarge))?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn never_more_than_the_allowance() {
        let mut memory = Memory { left: 1000 };
        let mut bytes: Vec<u8> = Vec::new();
        let mut most = 0;
        while memory.make_room(&mut bytes, 1, "bytes").is_ok() {
            bytes.push(0);
            most = bytes.capacity();
        }
        // It ends where the move itself (old and new place) would not fit any more.
        assert!((500..=1000).contains(&most), "{most}");
        assert!(memory.take(1001).is_err());
    }

    #[test]
    fn no_more_items_than_indices() {
        let mut memory = Memory { left: usize::MAX };
        let error = memory.make_room(&mut vec![0_u8], u32::MAX as usize, "vertices");
        assert_eq!(*error.unwrap_err(), Fault::TooMany { what: "vertices" });
    }
}
