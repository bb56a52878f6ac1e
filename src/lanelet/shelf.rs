//! Primitives of one kind, in insertion order, found by id.

use rustc_hash::FxHashMap;
use std::hash::Hash;

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
    index: FxHashMap<T::Id, u32>,
}

impl<T: Shelved> Default for Shelf<T> {
    fn default() -> Self {
        Self { items: Vec::new(), index: FxHashMap::default() }
    }
}

impl<T: Shelved> Shelf<T> {
    /// Puts an item on the shelf; one of the same id gives up its place and is returned.
    pub fn insert(&mut self, item: T) -> Option<T> {
        let id = item.id();
        match self.index.get(&id) {
            Some(&at) => Some(std::mem::replace(&mut self.items[at as usize], item)),
            None => {
                self.index.insert(id, self.items.len() as u32);
                self.items.push(item);
                None
            }
        }
    }

    /// The item of this id.
    pub fn get(&self, id: T::Id) -> Option<&T> {
        self.index.get(&id).map(|&at| &self.items[at as usize])
    }

    /// The item of this id, to change; its id must stay.
    pub fn get_mut(&mut self, id: T::Id) -> Option<&mut T> {
        self.index.get(&id).map(|&at| &mut self.items[at as usize])
    }

    /// Position on the shelf, for side tables.
    pub fn position(&self, id: T::Id) -> Option<usize> {
        self.index.get(&id).map(|&at| at as usize)
    }

    /// Whether there is an item of this id.
    pub fn contains(&self, id: T::Id) -> bool {
        self.index.contains_key(&id)
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

impl<T: Shelved> IntoIterator for Shelf<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.into_iter()
    }
}

impl<T: Shelved> Extend<T> for Shelf<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
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
