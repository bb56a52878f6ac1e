//! Elements by their ids, in as little memory as it takes.

use std::hash::BuildHasher;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rustc_hash::FxBuildHasher;

/// Ids in the order in which elements came, and the position of the first of each.
#[derive(Debug, Default)]
pub struct Ids {
    ids: Vec<i64>,
    table: HashTable<u32>,
}

impl Ids {
    /// Room for this many, so that a list does not move while it grows: what is not used takes no memory.
    pub fn reserve(&mut self, elements: usize) {
        self.ids.reserve(elements);
        let ids = &self.ids;
        self.table.reserve(elements, |&at| hash(ids.get(at as usize).copied().unwrap_or_default()));
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// The id at a position.
    pub fn at(&self, position: usize) -> i64 {
        self.ids.get(position).copied().unwrap_or_default()
    }

    /// The position of the first element of this id.
    pub fn find(&self, id: i64) -> Option<u32> {
        self.table.find(hash(id), |&at| self.at(at as usize) == id).copied()
    }

    /// Adds an element. The position of the first of its id is returned where there is one already.
    pub fn push(&mut self, id: i64) -> Option<u32> {
        let (ids, position) = (&self.ids, self.ids.len() as u32);
        let id_at = |at: u32| ids.get(at as usize).copied().unwrap_or_default();
        let first = match self.table.entry(hash(id), |&at| id_at(at) == id, |&at| hash(id_at(at))) {
            Entry::Occupied(first) => Some(*first.get()),
            Entry::Vacant(place) => {
                place.insert(position);
                None
            }
        };
        self.ids.push(id);
        first
    }
}

fn hash(id: i64) -> u64 {
    FxBuildHasher.hash_one(id)
}

/// Lists of different lengths, one after the other.
#[derive(Debug)]
pub struct Lists<T> {
    items: Vec<T>,
    ends: Vec<usize>,
}

impl<T> Default for Lists<T> {
    fn default() -> Self {
        Self { items: Vec::new(), ends: Vec::new() }
    }
}

impl<T> Lists<T> {
    /// Room for this many items in all lists.
    pub fn reserve(&mut self, items: usize) {
        self.items.reserve(items);
    }

    /// Adds a list.
    pub fn push(&mut self, list: impl IntoIterator<Item = T>) {
        self.items.extend(list);
        self.ends.push(self.items.len());
    }

    /// The list at a position.
    pub fn at(&self, position: usize) -> &[T] {
        let begin = position.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.ends.get(position).and_then(|end| self.items.get(begin..*end)).unwrap_or(&[])
    }
}
