//! Numbered work for all threads, begun in the order of its numbers.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;

/// Lets the threads of the current rayon pool do the work 0 to `count` − 1, each the next that no
/// thread has begun, with a state of its own, until one of them says to break. What came of the
/// states is returned, in no order.
///
/// rayon's own iterators part a range in the middle, so that its second half is begun together with
/// its first: what is to be used in order would pile up.
pub(crate) fn in_turn<S: Send>(
    count: usize,
    state: impl Fn() -> S + Sync,
    work: impl Fn(&mut S, usize) -> ControlFlow<()> + Sync,
) -> Vec<S> {
    let next = AtomicUsize::new(0);
    let threads = 0..rayon::current_num_threads().min(count);
    let states = threads.into_par_iter().with_max_len(1).map(|_| {
        let mut state = state();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= count {
                break;
            }
            if work(&mut state, number).is_break() {
                next.store(count, Ordering::Relaxed);
                break;
            }
        }
        state
    });
    states.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_number_comes_once_and_none_after_a_break() {
        for threads in [1, 2, 5] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            let pool = pool.build().unwrap();
            let until = |last: usize| {
                let work = |done: &mut Vec<usize>, number| {
                    done.push(number);
                    if number == last {
                        ControlFlow::Break(())
                    } else {
                        ControlFlow::Continue(())
                    }
                };
                let states = pool.install(|| in_turn(1000, Vec::new, work));
                assert!(states.iter().all(|done| done.is_sorted()));
                let mut all = states.concat();
                all.sort_unstable();
                all
            };
            assert_eq!(until(usize::MAX), (0..1000).collect::<Vec<_>>());
            let some = until(10);
            // Those that were begun beside the last one may be there as well.
            assert!(some.starts_with(&(0..=10).collect::<Vec<_>>()));
            assert!(some.len() < 1000 || threads > 1);
            assert!(
                pool.install(|| in_turn(0, || (), |(), _| ControlFlow::Break(())))
                    .is_empty()
            );
        }
    }
}
