//! Primitives of one kind, in insertion order, found by id.

use std::hash::{BuildHasher, Hash};
use std::sync::OnceLock;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rayon::prelude::*;
use rustc_hash::FxBuildHasher;

/// What can stand on a [`Shelf`].
pub trait Shelved {
    /// The type of its id.
    type Id: Copy + Eq + Hash + Ord;

    /// Its id.
    fn id(&self) -> Self::Id;
}

/// A list with an index. Iteration is in insertion order, so it is the same for the same input.
#[derive(Clone, Debug)]
pub struct Shelf<T: Shelved> {
    items: Vec<T>,
    /// Made when an item is first looked up.
    index: OnceLock<Index>,
}

impl<T: Shelved> Default for Shelf<T> {
    fn default() -> Self {
        Self { items: Vec::new(), index: OnceLock::new() }
    }
}

/// Positions by id. The ids themselves stand in the items: a map has many, and they fill the caches. Many shelves have
/// few items and one table; where many items come at once, each thread fills tables of its own.
#[derive(Clone, Debug, Default)]
struct Index {
    one: HashTable<u32>,
    /// Instead of the one: none or [`TABLES`].
    many: Vec<HashTable<u32>>,
}

/// Tables of a large shelf: enough for the threads of most machines.
const TABLES: usize = 32;
/// A shelf of more items is indexed by all threads.
const LARGE: usize = 1 << 14;

impl Index {
    /// Which of [`TABLES`] holds a hash: by bits that the tables themselves do not go by.
    fn table_of(hash: u64) -> usize {
        (hash >> 40) as usize % TABLES
    }

    fn table(&self, hash: u64) -> &HashTable<u32> {
        self.many.get(Self::table_of(hash)).unwrap_or(&self.one)
    }

    fn table_mut(&mut self, hash: u64) -> &mut HashTable<u32> {
        self.many.get_mut(Self::table_of(hash)).unwrap_or(&mut self.one)
    }

    /// The index of items with these hashes, all of different ids.
    fn of(hashes: &[u64]) -> Self {
        let fill = |positions: &[u32]| {
            let mut table = HashTable::with_capacity(positions.len());
            for &at in positions {
                table.insert_unique(hashes[at as usize], at, |&at| hashes[at as usize]);
            }
            table
        };
        if hashes.len() < LARGE {
            let all: Vec<u32> = (0..hashes.len() as u32).collect();
            return Self { one: fill(&all), many: Vec::new() };
        }
        let mut own: [Vec<u32>; TABLES] = std::array::from_fn(|_| Vec::with_capacity(hashes.len() / TABLES * 9 / 8));
        for (at, &hash) in hashes.iter().enumerate() {
            own[Self::table_of(hash)].push(at as u32);
        }
        Self { one: HashTable::new(), many: own.par_iter().map(|own| fill(own)).collect() }
    }
}

impl<T: Shelved> Shelf<T> {
    fn index(&self) -> &Index {
        self.index.get_or_init(|| Index::of(&self.items.iter().map(|item| hash(item.id())).collect::<Vec<u64>>()))
    }

    /// Puts an item on the shelf whose id no other has.
    pub fn push(&mut self, item: T) {
        if let Some(index) = self.index.get_mut() {
            let (items, id) = (&self.items, hash(item.id()));
            index.table_mut(id).insert_unique(id, items.len() as u32, |&at| hash(items[at as usize].id()));
        }
        self.items.push(item);
    }

    /// Puts an item on the shelf; one of the same id gives up its place and is returned.
    pub fn insert(&mut self, item: T) -> Option<T> {
        self.index();
        let Self { items, index } = self;
        let Some(index) = index.get_mut() else { return None };
        let id = item.id();
        let table = index.table_mut(hash(id));
        match table.entry(hash(id), |&at| items[at as usize].id() == id, |&at| hash(items[at as usize].id())) {
            Entry::Occupied(at) => Some(std::mem::replace(&mut items[*at.get() as usize], item)),
            Entry::Vacant(place) => {
                place.insert(items.len() as u32);
                items.push(item);
                None
            }
        }
    }

    /// The item of this id.
    pub fn get(&self, id: T::Id) -> Option<&T> {
        self.position(id).map(|at| &self.items[at])
    }

    /// The items of these ids, where there are any. Quick where they stand on the shelf one behind the other, in either
    /// direction.
    pub fn get_each<'s, I: Iterator<Item = T::Id>>(&'s self, ids: I) -> Each<'s, I, T> {
        Each { shelf: self, ids, last: 0 }
    }

    /// The item of this id, to change; its id must stay.
    pub fn get_mut(&mut self, id: T::Id) -> Option<&mut T> {
        self.position(id).map(|at| &mut self.items[at])
    }

    /// Keeps the items for which `stays` holds, in their order.
    pub fn retain(&mut self, stays: impl FnMut(&T) -> bool) {
        let Self { items, index } = self;
        let before = items.len();
        items.retain(stays);
        if items.len() < before {
            *index = OnceLock::new();
        }
    }

    /// Puts the items of other shelves behind its own, in their order; they are found by all threads. No id may come twice.
    pub fn append<U: Shelved>(&mut self, others: Vec<Shelf<U>>)
    where
        T: From<U> + Sync,
    {
        self.items.reserve_exact(others.iter().map(Shelf::len).sum());
        others.into_iter().for_each(|other| self.items.extend(other.items.into_iter().map(T::from)));
        let hashes: Vec<u64> = self.items.par_iter().map(|item| hash(item.id())).collect();
        self.index = Index::of(&hashes).into();
    }

    /// Position on the shelf, for side tables.
    pub fn position(&self, id: T::Id) -> Option<usize> {
        self.index().table(hash(id)).find(hash(id), |&at| self.items[at as usize].id() == id).map(|&at| at as usize)
    }

    /// Whether there is an item of this id.
    pub fn contains(&self, id: T::Id) -> bool {
        self.position(id).is_some()
    }

    /// Makes room for so many more items.
    pub fn reserve(&mut self, more: usize) {
        self.items.reserve(more);
    }

    /// Gives back the memory that more items would need, and that of the index until it is asked for again.
    pub fn shrink(&mut self) {
        self.items.shrink_to_fit();
        self.index = OnceLock::new();
    }

    /// All items in insertion order.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.items.iter()
    }

    /// All items as a slice, for parallel work and side tables.
    pub fn as_slice(&self) -> &[T] {
        &self.items
    }

    /// All items as a slice, to change in parallel; their ids must stay.
    pub fn as_mut_slice(&mut self) -> &mut [T] {
        &mut self.items
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}

/// See [`Shelf::get_each`].
pub struct Each<'s, I, T: Shelved> {
    shelf: &'s Shelf<T>,
    ids: I,
    /// Where the last one stood.
    last: usize,
}

impl<'s, I, T: Shelved> Each<'s, I, T> {
    fn find(&mut self, id: T::Id) -> Option<&'s T> {
        let items = &self.shelf.items;
        let beside = [self.last + 1, self.last.wrapping_sub(1)];
        let guess = beside.into_iter().find(|&at| items.get(at).is_some_and(|item| item.id() == id));
        self.last = guess.or_else(|| self.shelf.position(id))?;
        Some(&items[self.last])
    }
}

impl<'s, I: Iterator<Item = T::Id>, T: Shelved> Iterator for Each<'s, I, T> {
    type Item = &'s T;

    fn next(&mut self) -> Option<&'s T> {
        loop {
            let id = self.ids.next()?;
            if let Some(item) = self.find(id) {
                return Some(item);
            }
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, self.ids.size_hint().1)
    }
}

impl<I: DoubleEndedIterator<Item = T::Id>, T: Shelved> DoubleEndedIterator for Each<'_, I, T> {
    fn next_back(&mut self) -> Option<Self::Item> {
        loop {
            let id = self.ids.next_back()?;
            if let Some(item) = self.find(id) {
                return Some(item);
            }
        }
    }
}

fn hash(id: impl Hash) -> u64 {
    FxBuildHasher.hash_one(id)
}

impl<T: Shelved> IntoIterator for Shelf<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.into_iter()
    }
}

impl<T: Shelved> Extend<T> for Shelf<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
        let items = items.into_iter();
        self.items.reserve(items.size_hint().0);
        for item in items {
            self.insert(item);
        }
    }
}

impl<'a, T: Shelved> IntoIterator for &'a Shelf<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Shelved for i64 {
        type Id = Self;

        fn id(&self) -> Self {
            *self
        }
    }

    #[test]
    fn each_item_is_found_in_any_order_from_either_end() {
        let mut shelf = Shelf::default();
        shelf.extend([7, 3, 9, 1, 4]);
        let asked = [7, 3, 9, 9, 3, 7, 5, 4, 1, 9, 8, 7];
        let there: Vec<i64> = asked.into_iter().filter(|id| shelf.contains(*id)).collect();
        assert_eq!(shelf.get_each(asked.into_iter()).copied().collect::<Vec<_>>(), there);
        let backwards: Vec<i64> = shelf.get_each(asked.into_iter()).rev().copied().collect();
        assert_eq!(backwards, there.into_iter().rev().collect::<Vec<_>>());
        let mut ends = shelf.get_each(asked.into_iter());
        assert_eq!(
            (ends.next(), ends.next_back(), ends.next(), ends.next_back()),
            (Some(&7), Some(&7), Some(&3), Some(&9))
        );
        assert_eq!(Shelf::<i64>::default().get_each([1].into_iter()).next(), None);
    }
}
