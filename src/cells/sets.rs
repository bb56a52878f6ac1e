//! Sets of cells: neighbours have the same, so each is stored once and known by a number.

use std::sync::Arc;

use rustc_hash::FxHashMap;

use super::grid::Cell;

/// The number of a set.
pub type SetId = u32;

/// The set of no cell.
pub const NOWHERE: SetId = 0;

/// All sets together may name this many cells. A map that needs more has chains of references from end to end.
const MOST_STORED: usize = 1 << 27;

/// Sets of cells by number.
#[derive(Debug)]
pub struct CellSets {
    cells: Vec<Cell>,
    number_of: FxHashMap<Cell, u32>,
    sets: Vec<Arc<[u32]>>,
    known: FxHashMap<Arc<[u32]>, SetId>,
    unions: FxHashMap<(SetId, SetId), SetId>,
    stored: usize,
}

impl Default for CellSets {
    fn default() -> Self {
        let mut sets = Self {
            cells: Vec::new(),
            number_of: FxHashMap::default(),
            sets: Vec::new(),
            known: FxHashMap::default(),
            unions: FxHashMap::default(),
            stored: 0,
        };
        sets.set(Vec::new());
        sets
    }
}

impl CellSets {
    /// All cells, in the order in which they were first named.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The cells of a set, by their place in [`CellSets::cells`], in ascending order.
    pub fn get(&self, set: SetId) -> &[u32] {
        self.sets.get(set as usize).map_or(&[], |set| set)
    }

    /// Whether there are more than can be handled.
    pub fn too_many(&self) -> bool {
        self.stored > MOST_STORED
    }

    /// The set of these cells.
    pub fn of(&mut self, cells: &[Cell]) -> SetId {
        let mut numbers: Vec<u32> = cells.iter().map(|cell| self.number(*cell)).collect();
        numbers.sort_unstable();
        numbers.dedup();
        self.set(numbers)
    }

    /// The set of what is in either.
    pub fn union(&mut self, a: SetId, b: SetId) -> SetId {
        let (a, b) = (a.min(b), a.max(b));
        if a == b || a == NOWHERE {
            return b;
        }
        if let Some(known) = self.unions.get(&(a, b)) {
            return *known;
        }
        let mut both = [self.get(a), self.get(b)].concat();
        both.sort_unstable();
        both.dedup();
        let union = self.set(both);
        self.unions.insert((a, b), union);
        union
    }

    fn number(&mut self, cell: Cell) -> u32 {
        *self.number_of.entry(cell).or_insert_with(|| {
            self.cells.push(cell);
            self.cells.len() as u32 - 1
        })
    }

    fn set(&mut self, numbers: Vec<u32>) -> SetId {
        if let Some(known) = self.known.get(numbers.as_slice()) {
            return *known;
        }
        self.stored += numbers.len();
        let (set, id): (Arc<[u32]>, SetId) = (numbers.into(), self.sets.len() as SetId);
        self.sets.push(set.clone());
        self.known.insert(set, id);
        id
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_sets_have_one_number() {
        let mut sets = CellSets::default();
        let [a, b] = [0, 1].map(|column| Cell { row: 0, column });
        let (first, second) = (sets.of(&[a]), sets.of(&[b, b]));
        let both = sets.of(&[b, a]);
        assert_eq!(sets.union(second, first), both);
        assert_eq!(sets.union(both, first), both);
        assert_eq!(sets.union(NOWHERE, first), first);
        assert_eq!((sets.of(&[]), sets.get(both)), (NOWHERE, &[0, 1][..]));
    }
}
