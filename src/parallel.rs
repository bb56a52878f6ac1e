//! Work that all threads share evenly, and that can be called off.

use rayon::iter::plumbing::{Consumer, Producer, ProducerCallback, UnindexedConsumer, bridge};
use rayon::iter::{IndexedParallelIterator, MaxLen, ParallelIterator};

use crate::cancel;

/// So many parts a thread: the last one to be done keeps the others waiting for a thirtieth of their time at the most.
const PARTS: usize = 32;

/// Work in parts that are small enough to be passed on.
pub(crate) trait InSmallParts: IndexedParallelIterator {
    /// In many parts. By itself rayon makes four of the work of two threads, and halves what a thread takes from another: what costs
    /// more than the rest, as large intersections do, keeps one thread busy while the others have nothing to do. Before each part it
    /// is looked whether the work was called off.
    fn in_small_parts(self) -> MaxLen<Watched<Self>> {
        let most = self.len().div_ceil(PARTS * rayon::current_num_threads());
        Watched(self).with_max_len(most.max(1))
    }
}

impl<I: IndexedParallelIterator> InSmallParts for I {}

/// An iterator that begins no further part once the work was cancelled.
#[derive(Clone, Debug)]
pub(crate) struct Watched<I>(I);

impl<I: IndexedParallelIterator> ParallelIterator for Watched<I> {
    type Item = I::Item;

    fn drive_unindexed<C: UnindexedConsumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge(self, consumer)
    }

    fn opt_len(&self) -> Option<usize> {
        Some(self.0.len())
    }
}

impl<I: IndexedParallelIterator> IndexedParallelIterator for Watched<I> {
    fn len(&self) -> usize {
        self.0.len()
    }

    fn drive<C: Consumer<Self::Item>>(self, consumer: C) -> C::Result {
        bridge(self, consumer)
    }

    fn with_producer<CB: ProducerCallback<Self::Item>>(self, callback: CB) -> CB::Output {
        return self.0.with_producer(Callback(callback));

        struct Callback<CB>(CB);

        impl<T, CB: ProducerCallback<T>> ProducerCallback<T> for Callback<CB> {
            type Output = CB::Output;

            fn callback<P: Producer<Item = T>>(self, producer: P) -> CB::Output {
                self.0.callback(Part(producer))
            }
        }
    }
}

/// A part of the work.
struct Part<P>(P);

impl<P: Producer> Producer for Part<P> {
    type Item = P::Item;
    type IntoIter = P::IntoIter;

    fn into_iter(self) -> Self::IntoIter {
        cancel::look();
        self.0.into_iter()
    }

    fn min_len(&self) -> usize {
        self.0.min_len()
    }

    fn max_len(&self) -> usize {
        self.0.max_len()
    }

    fn split_at(self, index: usize) -> (Self, Self) {
        let (left, right) = self.0.split_at(index);
        (Self(left), Self(right))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayon::prelude::*;
    use std::sync::atomic::{AtomicUsize, Ordering};

    #[test]
    fn no_part_is_long_and_every_item_comes_in_its_place() {
        for count in [0_usize, 1, 7, 10_000] {
            let longest = AtomicUsize::new(0);
            let part = || 0_usize;
            let numbers: Vec<usize> = (0..count)
                .into_par_iter()
                .in_small_parts()
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
