//! Parts of a map that were made side by side over one assembly, put together in their order as they become ready: what they
//! were made from is let go meanwhile, and never stands beside the whole.

use rayon::prelude::*;

use crate::builder::ids::Ids;
use crate::lanelet::LaneletMap;
use crate::parallel::Finely;

use super::{MapBuilder, MapPart};

/// Parts that are made before they are added.
const BATCH: usize = 128;

/// Parts over an assembly.
#[derive(Default)]
pub struct PartialMaps {
    whole: MapPart,
    /// How much there was before each part.
    begins: Vec<Counts>,
}

/// How many elements there are of each kind, ids, and references from below.
#[derive(Clone, Copy)]
struct Counts {
    elements: [usize; 5],
    ids: usize,
    carried: usize,
}

impl PartialMaps {
    /// None yet, and room for what stands below and in the parts as far as they are begun; hardly more is added.
    pub fn over<'p>(below: &'p MapBuilder, begun: impl Iterator<Item = &'p MapPart>) -> Self {
        /// One element in so many is added.
        const MORE: usize = 8;
        let maps = begun.chain([&below.part]).map(|part| part.map.counts());
        let [points, lines, _, lanelets, _] = maps.fold([0; 5], |sum, more| [0, 1, 2, 3, 4].map(|i| sum[i] + more[i]));
        let mut parts = Self::default();
        let LaneletMap { points: all, linestrings, lanelets: lanes, .. } = &mut parts.whole.map;
        all.reserve(points + points / MORE);
        linestrings.reserve(lines + lines / MORE);
        lanes.reserve(lanelets + lanelets / MORE);
        parts
    }

    /// These with the parts that `make` makes of all inputs, many at once, and what else it gives of each.
    pub fn filled<T: Send, O: Send>(
        mut self,
        mut inputs: impl Iterator<Item = T>,
        make: impl Fn(T) -> (MapPart, O) + Sync,
    ) -> (Self, Vec<O>) {
        let mut outputs = Vec::with_capacity(inputs.size_hint().0);
        let mut ready: Vec<(MapPart, O)> = Vec::new();
        loop {
            let batch: Vec<T> = inputs.by_ref().take(BATCH).collect();
            let done = batch.is_empty();
            let add = |(part, output)| {
                self.add(part);
                outputs.push(output);
            };
            let (next, ()) = rayon::join(
                || batch.into_par_iter().finely().map(&make).collect(),
                || std::mem::take(&mut ready).into_iter().for_each(add),
            );
            ready = next;
            if done {
                return (self, outputs);
            }
        }
    }

    /// Adds a part.
    fn add(&mut self, part: MapPart) {
        let MapPart { map, ids, carried } = &mut self.whole;
        self.begins.push(Counts { elements: map.counts(), ids: ids.count(), carried: carried.len() });
        map.pile(part.map);
        ids.pile(&part.ids);
        carried.extend(part.carried);
    }

    /// Whether all their ids are different, and none is taken below.
    pub fn are_apart_from(&self, below: &MapBuilder) -> bool {
        Ids::are_apart([&below.part.ids, &self.whole.ids].into_iter())
    }

    /// All of them as one.
    pub fn into_part(self) -> MapPart {
        self.whole
    }

    /// Each by itself again.
    pub fn split(self) -> Vec<MapPart> {
        let Self { mut whole, begins } = self;
        let last = |Counts { elements, ids, carried }| MapPart {
            map: whole.map.split_off(elements),
            ids: whole.ids.split_off(ids),
            carried: whole.carried.split_off(carried),
        };
        let mut parts: Vec<MapPart> = begins.into_iter().rev().map(last).collect();
        parts.reverse();
        parts
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::ids::Key;
    use crate::geometry::Point;
    use crate::lanelet::Attributes;

    use super::*;

    #[test]
    fn parts_that_share_an_id_are_told_apart_again() {
        let point = |assembly: &mut MapBuilder, key| assembly.point(key, Point::new(1.0, 2.0), 0.0);
        let mut below = MapBuilder::default();
        point(&mut below, Key::new("below"));
        let made = |word| {
            let mut part = MapBuilder::over(&below);
            let points = [0, 1].map(|i| point(&mut part, Key::new(word).number(i)));
            part.line(Key::new(word), points.to_vec(), Attributes::of(&[("type", "virtual")]));
            part.into_part().shrunk()
        };
        let mut parts = PartialMaps::over(&below, std::iter::empty());
        ["one", "other"].into_iter().for_each(|word| parts.add(made(word)));
        assert!(parts.are_apart_from(&below));
        parts.add(made("one"));
        assert!(!parts.are_apart_from(&below));
        let split = parts.split();
        let added: Vec<bool> = split.into_iter().map(|part| below.add(part).is_ok()).collect();
        assert_eq!(added, [true, true, false]);
        assert_eq!(below.into_map().counts(), [5, 2, 0, 0, 0]);
    }
}
