//! Parts of a map that are made in parallel on top of one map and put together in order, batch by batch: memory never holds all
//! parts and the whole map at once.

use rayon::prelude::*;

use crate::parallel::InSmallParts;

use super::{MapBuilder, MapPart};

/// The number of parts that are made before they are added.
const BATCH: usize = 128;

impl MapPart {
    /// An empty part with room for the elements of a map and of the parts on top of it, and for a few more.
    pub fn with_room<'p>(below: &'p MapBuilder, begun: impl Iterator<Item = &'p Self>) -> Self {
        /// One element in this number is added.
        const MORE: usize = 8;
        let (mut points, mut lines, mut lanelets) = (0, 0, 0);
        for part in begun.chain([&below.part]) {
            points += part.map.points.len();
            lines += part.map.linestrings.len();
            lanelets += part.map.lanelets.len();
        }
        let mut part = Self::default();
        part.map.points.reserve(points + points / MORE);
        part.map.linestrings.reserve(lines + lines / MORE);
        part.map.lanelets.reserve(lanelets + lanelets / MORE);
        part
    }

    /// Adds the parts that `make` makes of the inputs, in parallel; also gives its other output for each input.
    pub fn filled<T: Send, O: Send>(
        mut self,
        mut inputs: impl Iterator<Item = T>,
        make: impl Fn(T) -> (Self, O) + Sync,
    ) -> (Self, Vec<O>) {
        let mut outputs = Vec::with_capacity(inputs.size_hint().0);
        let mut ready: Vec<(Self, O)> = Vec::new();
        loop {
            let batch: Vec<T> = inputs.by_ref().take(BATCH).collect();
            let done = batch.is_empty();
            let add = |(part, output): (Self, O)| {
                self.map.pile(part.map);
                self.carried.extend(part.carried);
                outputs.push(output);
            };
            let (next, ()) = rayon::join(
                || batch.into_par_iter().in_small_parts().map(&make).collect(),
                || std::mem::take(&mut ready).into_iter().for_each(add),
            );
            ready = next;
            if done {
                return (self, outputs);
            }
        }
    }
}
