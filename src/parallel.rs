//! Work that all threads share evenly.

use rayon::iter::MaxLen;
use rayon::prelude::*;

/// So many parts a thread: the last one to be done keeps the others waiting for a thirtieth of their time at the most.
const PARTS: usize = 32;

/// Work in parts that are small enough to be passed on.
pub(crate) trait Finely: IndexedParallelIterator {
    /// In many parts. By itself rayon makes four of the work of two threads, and halves what a thread takes from another: what costs
    /// more than the rest, as large intersections do, keeps one thread busy while the others have nothing to do.
    fn finely(self) -> MaxLen<Self> {
        let most = self.len().div_ceil(PARTS * rayon::current_num_threads());
        self.with_max_len(most.max(1))
    }
}

impl<I: IndexedParallelIterator> Finely for I {}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn no_part_is_long_and_every_item_comes_in_its_place() {
        for count in [0_usize, 1, 7, 10_000] {
            let longest = AtomicUsize::new(0);
            let part = || 0_usize;
            let numbers: Vec<usize> = (0..count)
                .into_par_iter()
                .finely()
                .map_init(part, |done, i| {
                    *done += 1;
                    longest.fetch_max(*done, Ordering::Relaxed);
                    i
                })
                .collect();
            assert!(numbers.into_iter().eq(0..count));
            assert!(longest.into_inner() <= count.div_ceil(PARTS * rayon::current_num_threads()));
        }
    }
}
