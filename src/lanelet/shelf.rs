//! Primitives of one kind, in insertion order, found by id.

use std::hash::{BuildHasher, Hash};

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
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
    /// Positions by id. The ids themselves stand in the items: a map has many, and they fill the caches.
    index: HashTable<u32>,
}

impl<T: Shelved> Default for Shelf<T> {
    fn default() -> Self {
        Self { items: Vec::new(), index: HashTable::new() }
    }
}

impl<T: Shelved> Shelf<T> {
    /// Puts an item on the shelf; one of the same id gives up its place and is returned.
    pub fn insert(&mut self, item: T) -> Option<T> {
        let Self { items, index } = self;
        let id = item.id();
        match index.entry(hash(id), |&at| items[at as usize].id() == id, |&at| hash(items[at as usize].id())) {
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
            index.clear();
            for (at, item) in items.iter().enumerate() {
                index.insert_unique(hash(item.id()), at as u32, |&at| hash(items[at as usize].id()));
            }
        }
    }

    /// Position on the shelf, for side tables.
    pub fn position(&self, id: T::Id) -> Option<usize> {
        self.index.find(hash(id), |&at| self.items[at as usize].id() == id).map(|&at| at as usize)
    }

    /// Whether there is an item of this id.
    pub fn contains(&self, id: T::Id) -> bool {
        self.position(id).is_some()
    }

    /// Gives back the memory that more items would need.
    pub fn shrink(&mut self) {
        self.items.shrink_to_fit();
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
        let least = items.size_hint().0;
        self.items.reserve(least);
        let stand = &self.items;
        self.index.reserve(least, |&at| hash(stand[at as usize].id()));
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
