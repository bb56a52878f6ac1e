//! The positions of a layer's items by their ids.

use std::borrow::Cow;
use std::hash::{BuildHasher, Hash};

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rayon::prelude::*;
use rustc_hash::FxBuildHasher;

/// From this many items on that are added at once, the index is a sorted list.
const MANY: usize = 1 << 14;
/// The most ranges of ids that are sorted in parallel: each reads all ids, so more of them cost more than they save.
const RANGES_MOST: usize = 8;

/// Positions by id. The ids themselves are only in the items, to save memory and cache. Items that are added one
/// by one go into a hash table; many at once are sorted by id, the order in which a map is written.
#[derive(Clone, Debug, Default)]
pub(super) struct Index {
    order: Order,
    table: HashTable<u32>,
}

impl Index {
    /// The index of items with these ids, all different; all threads share the work where there are many.
    pub fn of(ids: &[i64]) -> Self {
        if ids.len() < MANY { Self::table(ids) } else { Self { order: Order::of(ids), table: HashTable::new() } }
    }

    /// As [`Index::of`], always as a hash table built by one thread.
    pub fn table(ids: &[i64]) -> Self {
        let mut table = HashTable::with_capacity(ids.len());
        for (at, id) in ids.iter().enumerate() {
            table.insert_unique(hash(id), at as u32, |&at| hash(ids[at as usize]));
        }
        Self { order: Order::default(), table }
    }

    pub fn find<T: Primitive>(&self, items: &[T], id: T::Id) -> Option<usize> {
        let found = self.order.find(items, id);
        found
            .or_else(|| self.table.find(hash(id.into()), |&at| items[at as usize].id() == id).copied())
            .map(|at| at as usize)
    }

    /// The position of an item; if there is none, the id gets the next position.
    pub fn find_or_add<T: Primitive>(&mut self, items: &[T], id: T::Id) -> Option<usize> {
        if let Some(at) = self.order.find(items, id) {
            return Some(at as usize);
        }
        let id_at = |at: u32| items[at as usize].id();
        match self.table.entry(hash(id.into()), |&at| id_at(at) == id, |&at| hash(id_at(at).into())) {
            Entry::Occupied(at) => Some(*at.get() as usize),
            Entry::Vacant(place) => {
                place.insert(items.len() as u32);
                None
            }
        }
    }

    /// The positions of all items, by ascending id.
    pub fn ascending<T: Primitive>(&self, items: &[T]) -> Cow<'_, [u32]> {
        if self.table.is_empty() {
            return Cow::Borrowed(&self.order.positions);
        }
        let mut keyed: Vec<(i64, u32)> = items.iter().zip(0..).map(|(item, at)| (item.id().into(), at)).collect();
        keyed.par_sort_unstable();
        keyed.into_iter().map(|(_, at)| at).collect()
    }
}

fn hash(id: impl Hash) -> u64 {
    FxBuildHasher.hash_one(id)
}

/// Positions sorted by id. Ids are usually hashes, hence evenly spread: a bucket holds about one.
#[derive(Clone, Debug, Default)]
struct Order {
    positions: Vec<u32>,
    /// The first position of each bucket, and the end of the last one.
    begins: Vec<u32>,
    buckets: Buckets,
}

impl Order {
    fn of(ids: &[i64]) -> Self {
        let buckets = Buckets::of(ids);
        let count = rayon::current_num_threads().min(RANGES_MOST) as u64;
        let each = buckets.count.div_ceil(count);
        let ranges: Vec<Self> = (0..count)
            .into_par_iter()
            .map(|range| Self::of_range(ids, buckets, range * each..buckets.count.min((range + 1) * each)))
            .collect();
        let mut all = Self { buckets, ..Self::default() };
        all.positions.reserve_exact(ids.len());
        all.begins.reserve_exact(buckets.count as usize + 1);
        for range in ranges {
            let before = all.positions.len() as u32;
            all.begins.pop();
            all.begins.extend(range.begins.iter().map(|begin| before + begin));
            all.positions.extend(range.positions);
        }
        all
    }

    /// Sorts the ids of some buckets: counts them, then puts each into its bucket.
    fn of_range(ids: &[i64], buckets: Buckets, range: std::ops::Range<u64>) -> Self {
        let count = range.end.saturating_sub(range.start);
        let own = |id: &i64| Some(buckets.of_id(*id).wrapping_sub(range.start)).filter(|bucket| *bucket < count);
        let mut begins = vec![0_u32; count as usize + 1];
        ids.iter().filter_map(own).for_each(|bucket| begins[bucket as usize] += 1);
        let mut sum = 0;
        for begin in &mut begins {
            sum += *begin;
            *begin = sum;
        }
        // Each bucket is filled from its end, so `begin` ends at its start.
        let mut positions = vec![0; sum as usize];
        for (id, at) in ids.iter().zip(0..) {
            if let Some(bucket) = own(id) {
                let begin = &mut begins[bucket as usize];
                *begin -= 1;
                positions[*begin as usize] = at;
            }
        }
        for bucket in begins.windows(2) {
            positions[bucket[0] as usize..bucket[1] as usize].sort_unstable_by_key(|&at| ids[at as usize]);
        }
        Self { positions, begins, buckets }
    }

    fn find<T: Primitive>(&self, items: &[T], id: T::Id) -> Option<u32> {
        let bucket = usize::try_from(self.buckets.of_id(id.into())).ok()?;
        let [begin, end] = *self.begins.get(bucket..)?.first_chunk()?;
        let near = &self.positions[begin as usize..end as usize];
        near.binary_search_by_key(&id, |&at| items[at as usize].id()).ok().map(|found| near[found])
    }
}

/// Ranges of ids of equal width, about as many as there are ids.
#[derive(Clone, Copy, Debug, Default)]
struct Buckets {
    lowest: i64,
    /// The width, as a power of two.
    shift: u32,
    count: u64,
}

impl Buckets {
    fn of(ids: &[i64]) -> Self {
        let (Some(&lowest), Some(&highest)) = (ids.iter().min(), ids.iter().max()) else { return Self::default() };
        let width = highest.wrapping_sub(lowest) as u64;
        let shift = (u64::BITS - width.leading_zeros()).saturating_sub(ids.len().ilog2());
        Self { lowest, shift, count: (width >> shift) + 1 }
    }

    /// Ids out of range get a bucket beyond the last, or one that does not hold them.
    fn of_id(self, id: i64) -> u64 {
        (id.wrapping_sub(self.lowest) as u64) >> self.shift
    }
}

/// An item of a layer.
pub trait Primitive {
    /// The type of its id.
    type Id: Copy + Eq + Hash + Ord + Into<i64>;

    /// Its id.
    fn id(&self) -> Self::Id;
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustc_hash::FxHashSet;

    fn spread(count: i64) -> Vec<i64> {
        (0..count).map(|i| i.wrapping_mul(0x9e37_79b9_7f4a_7c15_u64 as i64)).collect()
    }

    #[test]
    fn few_and_many_are_found_however_their_ids_lie() {
        let dense: Vec<i64> = (0..40_000).map(|i| (i * 7919) % 40_000 - 5).collect();
        let uneven = spread(40_000).into_iter().map(|id| if id % 3 == 0 { id } else { id % 100_000_007 }).collect();
        for ids in [spread(10), spread(40_000), dense, uneven, vec![i64::MIN, i64::MAX, 0], Vec::new()] {
            let index = Index::of(&ids);
            for (at, id) in ids.iter().enumerate() {
                assert_eq!(index.find(&ids, *id), Some(at));
            }
            let known: FxHashSet<i64> = ids.iter().copied().collect();
            for id in ids.iter().flat_map(|id| [id.wrapping_add(1), id.wrapping_sub(0x1234_5678_9abc)]) {
                assert_eq!(index.find(&ids, id).is_some(), known.contains(&id));
            }
            let sorted: Vec<i64> = index.ascending(&ids).iter().map(|&at| ids[at as usize]).collect();
            assert!(sorted.is_sorted() && sorted.len() == ids.len());
        }
    }

    #[test]
    fn what_comes_later_is_found_too() {
        let mut ids = spread(20_000);
        let mut index = Index::of(&ids);
        for id in [1, 2, 3] {
            assert_eq!(index.find_or_add(&ids, id), None);
            ids.push(id);
        }
        assert_eq!(index.find_or_add(&ids, 2), Some(20_001));
        assert_eq!(index.find_or_add(&ids, ids[7]), Some(7));
        assert_eq!(index.ascending(&ids).len(), ids.len());
    }
}
