//! How much memory a function takes: an allocator that counts, thread by thread.

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

thread_local! {
    /// Bytes that this thread has allocated and not freed; below 0 where it freed another's.
    static LIVE: Cell<isize> = const { Cell::new(0) };
    /// The most that [`LIVE`] has been since it was last measured.
    static PEAK: Cell<isize> = const { Cell::new(0) };
}

/// The system's allocator, with its calls counted.
struct Counting;

/// Counts `bytes` more, or fewer.
fn count(bytes: isize) {
    // While a thread ends, its counters may be gone; nobody measures then.
    let _ = LIVE.try_with(|live| {
        live.set(live.get() + bytes);
        let _ = PEAK.try_with(|peak| peak.set(peak.get().max(live.get())));
    });
}

#[expect(
    unsafe_code,
    reason = "an allocator is unsafe by nature; this one passes everything on to the system's"
)]
// SAFETY: every call is passed on to `System` unchanged; counting neither allocates nor unwinds.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: the caller's promises are those that `System` asks for.
        unsafe { System.alloc(layout) }
    }

    unsafe fn alloc_zeroed(&self, layout: Layout) -> *mut u8 {
        count(layout.size() as isize);
        // SAFETY: as above.
        unsafe { System.alloc_zeroed(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        count(-(layout.size() as isize));
        // SAFETY: as above.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        // In the worst case the old and the new place are there at once.
        count(size as isize);
        count(-(layout.size() as isize));
        // SAFETY: as above.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

/// What `function` returns, and the most memory that this thread had allocated at once while it
/// ran, beyond what it had before, in bytes. Memory that other threads allocate is not counted.
pub(crate) fn peak<T>(function: impl FnOnce() -> T) -> (T, usize) {
    let before = LIVE.get();
    PEAK.set(before);
    let value = function();
    (value, usize::try_from(PEAK.get() - before).unwrap_or(0))
}

#[test]
fn peaks_are_counted() {
    let ((), nothing) = peak(|| ());
    assert_eq!(nothing, 0);
    let (_, kept) = peak(|| vec![0_u8; 1000]);
    assert_eq!(kept, 1000);
    let ((), freed) = peak(|| {
        drop(vec![0_u8; 3000]);
        drop(vec![0_u8; 2000]);
    });
    assert_eq!(freed, 3000);
    let (_, moved) = peak(|| {
        let mut bytes: Vec<u8> = Vec::with_capacity(1000);
        bytes.reserve_exact(1500);
        bytes
    });
    assert_eq!(moved, 2500);
}
