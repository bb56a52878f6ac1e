//! Which data each tile needs: all that touches a square near it, or near a road that touches it.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cells::{Cell, CellSets, Grid, NOWHERE, SetId};
use crate::geometry::Point;

use super::survey::{Survey, WayUse};

/// Squares by which is told what is near, with sides of 200 m.
const SQUARES: Grid = Grid::of_metres(200);
/// What an element of a cell refers to touches a square so near to the cell, metres: the lanelets of its intersection, which
/// reaches 90 m, and of those that it yields to.
const REFERS: f64 = 200.0;

/// The size of tiles, and how far their data reach beyond them.
#[derive(Clone, Copy, Debug)]
pub struct TileSize {
    /// The squares that are built one by one.
    pub tiles: Grid,
    /// How far around a tile and its roads data are needed, metres.
    pub margin: f64,
}

/// Which tiles need what touches a place.
#[derive(Debug)]
pub struct Reach {
    squares: Grid,
    /// The tiles that need what touches a square.
    needed_by: FxHashMap<Cell, SetId>,
    pub(super) sets: CellSets,
}

/// A piece of road between two places where more than two roads meet, or one ends; over all ways that it is made of.
type Chain = BTreeSet<Cell>;

impl Reach {
    /// Finds which tiles there are and what they need, by the places of all nodes in the plane.
    pub fn new(survey: &Survey, places: &[Point], size: TileSize) -> Self {
        let squares = SQUARES;
        let chains = Chains::of(survey, places, squares);
        let beside = (REFERS / squares.size()).ceil() as i32;
        let margin = (size.margin / squares.size()).ceil() as i32;
        let tiles_near = |square: Cell, reach: i32| {
            let corner = |by: i32| squares.corner(Cell { row: square.row + by, column: square.column + by });
            covered([corner(-reach), corner(reach + 1)], size.tiles)
        };
        let tiles: BTreeSet<Cell> = chains.iter().flatten().flat_map(|square| tiles_near(*square, beside)).collect();
        let mut needed: FxHashMap<Cell, BTreeSet<Cell>> = FxHashMap::default();
        for tile in &tiles {
            let [low, high] = [0, 1].map(|by| size.tiles.corner(Cell { row: tile.row + by, column: tile.column + by }));
            for square in covered([low, high], squares).flat_map(|square| around(square, beside + margin)) {
                needed.entry(square).or_default().insert(*tile);
            }
        }
        for chain in &chains {
            let near: FxHashSet<Cell> = chain.iter().flat_map(|square| tiles_near(*square, beside)).collect();
            for tile in near {
                let beyond = chain.iter().filter(|square| !tiles_near(**square, beside).any(|near| near == tile));
                for square in beyond.flat_map(|square| around(*square, margin)) {
                    needed.entry(square).or_default().insert(tile);
                }
            }
        }
        let mut sets = CellSets::default();
        let set = |(square, tiles): (Cell, BTreeSet<Cell>)| (square, tiles.into_iter().collect::<Vec<Cell>>());
        let mut needed: Vec<(Cell, Vec<Cell>)> = needed.into_iter().map(set).collect();
        needed.sort_unstable();
        let needed_by = needed.into_iter().map(|(square, tiles)| (square, sets.of(&tiles))).collect();
        Self { squares, needed_by, sets }
    }

    /// The tiles that need a line, or a place.
    pub(super) fn of(&mut self, line: &[Point]) -> SetId {
        let mut touched = Vec::new();
        // A line around half the Earth has a misplaced node: it is needed where its nodes lie.
        if self.squares.along(line, &mut touched).is_err() {
            touched.clear();
            for place in line {
                let _ = self.squares.along(&[*place], &mut touched);
            }
        }
        let sets = touched.into_iter().filter_map(|square| self.needed_by.get(&square).copied());
        sets.fold(NOWHERE, |all, set| self.sets.union(all, set))
    }
}

/// The cells of a grid that a box covers.
fn covered([[west, south], [east, north]]: [[f64; 2]; 2], grid: Grid) -> impl Iterator<Item = Cell> {
    let range = move |low: f64, high: f64| (low / grid.size()).floor() as i32..(high / grid.size()).ceil() as i32;
    range(south, north).flat_map(move |row| range(west, east).map(move |column| Cell { row, column }))
}

/// The squares up to so many away.
fn around(square: Cell, reach: i32) -> impl Iterator<Item = Cell> {
    let Cell { row, column } = square;
    (row - reach..=row + reach)
        .flat_map(move |row| (column - reach..=column + reach).map(move |column| Cell { row, column }))
}

/// Roads from one intersection to the next.
struct Chains<'a> {
    survey: &'a Survey,
    /// How many pieces of driven ways meet at each node, up to 3.
    meeting: Vec<u8>,
    /// By piece: another of the same road, or itself.
    joined: Vec<usize>,
    /// The first piece that ends at a node where two end.
    ending: FxHashMap<u32, usize>,
}

impl<'a> Chains<'a> {
    /// The squares of all roads.
    fn of(survey: &'a Survey, places: &[Point], squares: Grid) -> Vec<Chain> {
        let mut meeting = vec![0_u8; places.len()];
        for way in driven(survey) {
            let nodes = survey.way_nodes.at(way);
            for (i, node) in nodes.iter().enumerate() {
                let sides = if i == 0 || i + 1 == nodes.len() { 1 } else { 2 };
                if let Some(meeting) = meeting.get_mut(*node as usize) {
                    *meeting = (*meeting + sides).min(3);
                }
            }
        }
        let mut chains = Chains { survey, meeting, joined: Vec::new(), ending: FxHashMap::default() };
        let mut touched: Vec<Vec<Cell>> = Vec::new();
        for way in driven(survey) {
            for piece in chains.pieces(way) {
                let line = line(piece, places);
                let mut found = Vec::new();
                // A road around half the Earth has a misplaced node, and is left to those near its nodes.
                if squares.along(&line, &mut found).is_err() {
                    found.clear();
                }
                chains.add(piece);
                touched.push(found);
            }
        }
        let mut all: FxHashMap<usize, Chain> = FxHashMap::default();
        for (piece, squares) in touched.into_iter().enumerate() {
            all.entry(chains.first(piece)).or_default().extend(squares);
        }
        all.into_values().collect()
    }

    /// A way in pieces that end where roads meet.
    fn pieces(&self, way: usize) -> Vec<&'a [u32]> {
        let mut rest = self.survey.way_nodes.at(way);
        let mut pieces = Vec::new();
        while let Some(at) = rest.iter().skip(1).position(|node| self.meeting(*node) > 2) {
            let (piece, beyond) = (rest.get(..at + 2), rest.get(at + 1..));
            pieces.extend(piece);
            rest = beyond.unwrap_or_default();
        }
        pieces.extend((rest.len() > 1).then_some(rest));
        pieces
    }

    /// How many pieces of driven ways meet at a node, up to 3; none at one that is not there.
    fn meeting(&self, node: u32) -> u8 {
        self.meeting.get(node as usize).copied().unwrap_or_default()
    }

    /// Joins a piece with those that it continues.
    fn add(&mut self, piece: &[u32]) {
        let index = self.joined.len();
        self.joined.push(index);
        for end in [piece.first(), piece.last()].into_iter().flatten() {
            if self.meeting(*end) == 2 {
                let other = *self.ending.entry(*end).or_insert(index);
                let (one, other) = (self.first(index), self.first(other));
                if let Some(joined) = self.joined.get_mut(one.max(other)) {
                    *joined = one.min(other);
                }
            }
        }
    }

    /// The first piece of the road that a piece belongs to.
    fn first(&mut self, mut piece: usize) -> usize {
        while let Some(before) = self.joined.get(piece).copied().filter(|before| *before != piece) {
            let first = self.joined.get(before).copied().unwrap_or(before);
            // So the way there is halved each time.
            if let Some(joined) = self.joined.get_mut(piece) {
                *joined = first;
            }
            piece = first;
        }
        piece
    }
}

/// The places of nodes, of those that have one in the plane.
pub(super) fn line(nodes: &[u32], places: &[Point]) -> Vec<Point> {
    let known = nodes.iter().filter_map(|node| places.get(*node as usize).copied());
    known.filter(|place| place.x.is_finite() && place.y.is_finite()).collect()
}

fn driven(survey: &Survey) -> impl Iterator<Item = usize> {
    survey.ways.iter().enumerate().filter(|(_, of)| **of == WayUse::Driven).map(|(way, _)| way)
}
