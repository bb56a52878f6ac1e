//! Elements by their ids, in as little memory as it takes.

use std::hash::BuildHasher;

use hashbrown::HashTable;
use hashbrown::hash_table::Entry;
use rustc_hash::FxBuildHasher;

/// Ids in the order in which elements came, and the position of the first of each.
#[derive(Debug, Default)]
pub struct Ids {
    ids: Vec<i64>,
    /// The positions by id. As long as the ids ascend, as most programs write them, there is none.
    table: Option<HashTable<u32>>,
}

impl Ids {
    /// Room for this many, so that the list does not move while it grows: what is not used takes no memory.
    pub fn reserve(&mut self, elements: usize) {
        self.ids.reserve(elements);
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.ids.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ids.is_empty()
    }

    /// The id at a position.
    pub fn at(&self, position: usize) -> i64 {
        self.ids.get(position).copied().unwrap_or_default()
    }

    /// The position of the first element of this id.
    pub fn find(&self, id: i64) -> Option<u32> {
        match &self.table {
            Some(table) => table.find(hash(id), |&at| self.at(at as usize) == id).copied(),
            None => self.ids.binary_search(&id).ok().map(|at| at as u32),
        }
    }

    /// Adds an element. The position of the first of its id is returned where there is one already.
    pub fn push(&mut self, id: i64) -> Option<u32> {
        let position = self.ids.len() as u32;
        if self.table.is_none() && self.ids.last().is_some_and(|last| *last >= id) {
            self.table = Some(table(&self.ids));
        }
        let (ids, id_at) = (&self.ids, |at: u32| self.ids.get(at as usize).copied().unwrap_or_default());
        let first = self.table.as_mut().and_then(|table| {
            match table.entry(
                hash(id),
                |&at| id_at(at) == id,
                |&at| hash(ids.get(at as usize).copied().unwrap_or_default()),
            ) {
                Entry::Occupied(first) => Some(*first.get()),
                Entry::Vacant(place) => {
                    place.insert(position);
                    None
                }
            }
        });
        self.ids.push(id);
        first
    }
}

/// The positions of ids that are all different.
fn table(ids: &[i64]) -> HashTable<u32> {
    let mut table = HashTable::with_capacity(2 * ids.len());
    for (id, at) in ids.iter().zip(0_u32..) {
        table.insert_unique(hash(*id), at, |&at| hash(ids[at as usize]));
    }
    table
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

    /// All items, whatever list they are in.
    pub fn items_mut(&mut self) -> &mut [T] {
        &mut self.items
    }

    /// How many lists there are.
    pub fn count(&self) -> usize {
        self.ends.len()
    }

    /// How many items there are in all lists.
    pub fn items(&self) -> usize {
        self.items.len()
    }

    /// The list at a position.
    pub fn at(&self, position: usize) -> &[T] {
        let begin = position.checked_sub(1).and_then(|before| self.ends.get(before)).copied().unwrap_or(0);
        self.ends.get(position).and_then(|end| self.items.get(begin..*end)).unwrap_or(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_of_an_id_is_found_in_whatever_order_ids_come() {
        for ids in [&[1, 5, 9][..], &[5, 1, 9, 5], &[1, 5, 9, 9, -3], &[]] {
            let mut all = Ids::default();
            for (at, id) in ids.iter().enumerate() {
                let known = ids[..at].iter().position(|other| other == id);
                assert_eq!(all.push(*id), known.map(|at| at as u32), "{ids:?}");
            }
            for id in -4..11 {
                assert_eq!(all.find(id), ids.iter().position(|other| *other == id).map(|at| at as u32), "{ids:?} {id}");
            }
        }
    }
}
