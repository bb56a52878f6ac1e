//! Primitives of one kind, in insertion order, found by id: a layer, as Lanelet2 calls it. `indexmap` would store key and hash
//! beside each item, 16 bytes more for each point of 40, and has no slice of the items for parallel work.

mod id_index;

pub use id_index::Primitive;

use id_index::Index;
use std::borrow::Cow;
use std::sync::OnceLock;

/// A list with an index by id. Iteration is in insertion order.
#[derive(Clone, Debug)]
pub struct PrimitiveLayer<T: Primitive> {
    items: Vec<T>,
    /// Built at the first lookup.
    index: OnceLock<Box<Index>>,
}

impl<T: Primitive> Default for PrimitiveLayer<T> {
    fn default() -> Self {
        Self { items: Vec::new(), index: OnceLock::new() }
    }
}

/// All items at once, in their order. No id may be there twice.
impl<T: Primitive> From<Vec<T>> for PrimitiveLayer<T> {
    fn from(items: Vec<T>) -> Self {
        let mut layer = Self { items, index: OnceLock::new() };
        layer.rebuild_index();
        layer
    }
}

impl<T: Primitive> PrimitiveLayer<T> {
    fn index(&self) -> &Index {
        // One thread builds it: a thread that waited for others here could be given work that needs the same index.
        self.index.get_or_init(|| Box::new(Index::table(&self.ids())))
    }

    /// Adds an item whose id no other has.
    pub fn push(&mut self, item: T) {
        if let Some(index) = self.index.get_mut() {
            index.find_or_add(&self.items, item.id());
        }
        self.items.push(item);
    }

    /// Adds an item. It replaces one of the same id, which is returned.
    pub fn insert(&mut self, item: T) -> Option<T> {
        self.index();
        let index = self.index.get_mut()?;
        match index.find_or_add(&self.items, item.id()) {
            Some(at) => Some(std::mem::replace(&mut self.items[at], item)),
            None => {
                self.items.push(item);
                None
            }
        }
    }

    /// Whether the index is built.
    pub fn is_indexed(&self) -> bool {
        self.index.get().is_some()
    }

    /// The item of this id.
    pub fn get(&self, id: T::Id) -> Option<&T> {
        self.position(id).map(|at| &self.items[at])
    }

    /// The items of these ids that exist. Fast for items that were inserted one after the other, in either direction.
    pub fn get_each<'s, I: Iterator<Item = T::Id>>(&'s self, ids: I) -> Each<'s, I, T> {
        Each { cursor: self.cursor(), ids }
    }

    /// Finds items fast that are next to one of those that it found last.
    pub fn cursor(&self) -> Cursor<'_, T> {
        Cursor { layer: self, last: [0; RECENT] }
    }

    /// The item of this id, to change; its id must stay.
    pub fn get_mut(&mut self, id: T::Id) -> Option<&mut T> {
        self.position(id).map(|at| &mut self.items[at])
    }

    /// Keeps the items for which `stays` holds, in their order.
    pub fn retain(&mut self, stays: impl FnMut(&T) -> bool) {
        let before = self.items.len();
        self.items.retain(stays);
        if self.items.len() < before {
            self.rebuild_index();
        }
    }

    /// Appends the items of other layers in their order. No id may be there twice.
    pub fn append(&mut self, others: Vec<Self>) {
        self.items.reserve_exact(others.iter().map(Self::len).sum());
        others.into_iter().for_each(|other| self.items.extend(other.items));
        self.rebuild_index();
    }

    /// Appends the items of another layer; the index is built at the next lookup. No id may be there twice.
    pub fn pile(&mut self, other: Self) {
        self.index = OnceLock::new();
        self.items.extend(other.items);
    }

    /// Puts the items of another layer before its own. No id may be there twice.
    pub fn prepend(&mut self, first: Self) {
        self.items.splice(0..0, first.items);
        self.rebuild_index();
    }

    fn ids(&self) -> Vec<i64> {
        self.items.iter().map(|item| item.id().into()).collect()
    }

    fn rebuild_index(&mut self) {
        self.index = Box::new(Index::of(&self.ids())).into();
    }

    /// The position of an item, for side tables.
    pub fn position(&self, id: T::Id) -> Option<usize> {
        self.index().find(&self.items, id)
    }

    /// The positions of all items, by ascending id.
    pub fn ascending(&self) -> Cow<'_, [u32]> {
        self.index().ascending(&self.items)
    }

    /// Whether there is an item of this id.
    pub fn contains(&self, id: T::Id) -> bool {
        self.position(id).is_some()
    }

    /// Reserves room for this many more items.
    pub fn reserve(&mut self, more: usize) {
        self.items.reserve(more);
    }

    /// Frees the spare memory, and the index until the next lookup.
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

    /// The number of items.
    pub fn len(&self) -> usize {
        self.items.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.items.is_empty()
    }
}

/// Positions that a [`Cursor`] remembers: a line shares its two ends with other lines, and the points between follow those of
/// the line before.
const RECENT: usize = 4;

/// See [`PrimitiveLayer::cursor`].
pub struct Cursor<'s, T: Primitive> {
    layer: &'s PrimitiveLayer<T>,
    /// Positions of the last items that were not next to each other, the latest first.
    last: [usize; RECENT],
}

impl<'s, T: Primitive> Cursor<'s, T> {
    /// The item of this id.
    pub fn get(&mut self, id: T::Id) -> Option<&'s T> {
        let items = &self.layer.items;
        for recent in 0..RECENT {
            let last = self.last[recent];
            let beside = [last + 1, last.wrapping_sub(1)];
            if let Some(at) = beside.into_iter().find(|&at| items.get(at).is_some_and(|item| item.id() == id)) {
                self.last[..=recent].rotate_right(1);
                self.last[0] = at;
                return Some(&items[at]);
            }
        }
        let at = self.layer.position(id)?;
        self.last.rotate_right(1);
        self.last[0] = at;
        Some(&items[at])
    }
}

/// See [`PrimitiveLayer::get_each`].
pub struct Each<'s, I, T: Primitive> {
    cursor: Cursor<'s, T>,
    ids: I,
}

impl<'s, I: Iterator<Item = T::Id>, T: Primitive> Iterator for Each<'s, I, T> {
    type Item = &'s T;

    fn next(&mut self) -> Option<&'s T> {
        loop {
            let id = self.ids.next()?;
            if let Some(item) = self.cursor.get(id) {
                return Some(item);
            }
        }
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (0, self.ids.size_hint().1)
    }
}

impl<I: DoubleEndedIterator<Item = T::Id>, T: Primitive> DoubleEndedIterator for Each<'_, I, T> {
    fn next_back(&mut self) -> Option<Self::Item> {
        loop {
            let id = self.ids.next_back()?;
            if let Some(item) = self.cursor.get(id) {
                return Some(item);
            }
        }
    }
}

impl<T: Primitive> IntoIterator for PrimitiveLayer<T> {
    type Item = T;
    type IntoIter = std::vec::IntoIter<T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.into_iter()
    }
}

impl<T: Primitive> Extend<T> for PrimitiveLayer<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, items: I) {
        let items = items.into_iter();
        self.items.reserve(items.size_hint().0);
        for item in items {
            self.insert(item);
        }
    }
}

impl<'a, T: Primitive> IntoIterator for &'a PrimitiveLayer<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.items.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl Primitive for i64 {
        type Id = Self;

        fn id(&self) -> Self {
            *self
        }
    }

    #[test]
    fn each_item_is_found_in_any_order_from_either_end() {
        let mut layer = PrimitiveLayer::default();
        layer.extend([7, 3, 9, 1, 4]);
        let asked = [7, 3, 9, 9, 3, 7, 5, 4, 1, 9, 8, 7];
        let there: Vec<i64> = asked.into_iter().filter(|id| layer.contains(*id)).collect();
        assert_eq!(layer.get_each(asked.into_iter()).copied().collect::<Vec<_>>(), there);
        let backwards: Vec<i64> = layer.get_each(asked.into_iter()).rev().copied().collect();
        assert_eq!(backwards, there.into_iter().rev().collect::<Vec<_>>());
        let mut ends = layer.get_each(asked.into_iter());
        assert_eq!(
            (ends.next(), ends.next_back(), ends.next(), ends.next_back()),
            (Some(&7), Some(&7), Some(&3), Some(&9))
        );
        assert_eq!(PrimitiveLayer::<i64>::default().get_each([1].into_iter()).next(), None);
    }
}
