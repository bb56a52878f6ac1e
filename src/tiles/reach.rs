//! Which data each tile needs: all that touches a square near it, or near a road that touches it.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use crate::cells::{Cell, CellSets, Grid, Lists, NOWHERE, SetId};
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
    /// The tiles that need what touches a square.
    needed_by: FxHashMap<Cell, SetId>,
    /// For each way the tiles that need one of the roads that it is part of, by their squares: roads are needed whole.
    roads_of_ways: Lists<u32>,
    needed_roads: Vec<SetId>,
    pub(super) sets: CellSets,
}

/// The squares that a road touches from one intersection to the next, over all ways that it is made of.
type Road = BTreeSet<Cell>;

impl Reach {
    /// Finds which tiles there are and what they need, by the places of all nodes in the plane.
    pub fn new(survey: &Survey, places: &[Point], size: TileSize) -> Self {
        let Roads { roads, of_ways } = Roads::of(survey, places);
        let needed = needed(&roads, size);
        let mut sets = CellSets::default();
        let mut needed_by: FxHashMap<Cell, SetId> = FxHashMap::default();
        needed_by.extend(needed.into_iter().map(|(square, tiles)| (square, sets.of(&Vec::from_iter(tiles)))));
        let of_road = |road: &Road| union(&mut sets, road.iter().filter_map(|square| needed_by.get(square).copied()));
        let needed_roads = roads.iter().map(of_road).collect();
        Self { needed_by, roads_of_ways: of_ways, needed_roads, sets }
    }

    /// The tiles that need a place.
    pub(super) fn of_node(&mut self, place: &[Point]) -> SetId {
        let touched = touched(place);
        union(&mut self.sets, touched.iter().filter_map(|square| self.needed_by.get(square).copied()))
    }

    /// The tiles that need a way.
    pub(super) fn of_way(&mut self, way: usize, line: &[Point]) -> SetId {
        let set = self.of_node(line);
        let roads = self.roads_of_ways.at(way).iter();
        let roads = roads.filter_map(|road| self.needed_roads.get(*road as usize).copied());
        union(&mut self.sets, roads.chain([set]))
    }
}

fn union(sets: &mut CellSets, of: impl Iterator<Item = SetId>) -> SetId {
    of.fold(NOWHERE, |all, set| sets.union(all, set))
}

/// The tiles that need what touches a square, row by row. A tile is there where a road comes near.
fn needed(roads: &[Road], size: TileSize) -> BTreeMap<Cell, BTreeSet<Cell>> {
    let [beside, margin] = [REFERS, size.margin].map(|metres| (metres / SQUARES.size()).ceil() as i32);
    let tiles_near = |square: &Cell| {
        let corner = |by: i32| SQUARES.corner(Cell { row: square.row + by, column: square.column + by });
        covered([corner(-beside), corner(beside + 1)], size.tiles)
    };
    let tiles: BTreeSet<Cell> = roads.iter().flatten().flat_map(tiles_near).collect();
    let mut needed: BTreeMap<Cell, BTreeSet<Cell>> = BTreeMap::new();
    for tile in &tiles {
        let [low, high] = [0, 1].map(|by| size.tiles.corner(Cell { row: tile.row + by, column: tile.column + by }));
        for square in covered([low, high], SQUARES).flat_map(|square| around(square, beside + margin)) {
            needed.entry(square).or_default().insert(*tile);
        }
    }
    for road in roads {
        let near: BTreeSet<Cell> = road.iter().flat_map(tiles_near).collect();
        for tile in near {
            let beyond = road.iter().filter(|square| !tiles_near(square).any(|near| near == tile));
            for square in beyond.flat_map(|square| around(*square, margin)) {
                needed.entry(square).or_default().insert(tile);
            }
        }
    }
    needed
}

/// The squares that a line touches. One around half the Earth has a misplaced node: it is where its nodes are.
fn touched(line: &[Point]) -> Vec<Cell> {
    let mut touched = Vec::new();
    if SQUARES.along(line, &mut touched).is_err() {
        touched.clear();
        for place in line {
            let _ = SQUARES.along(&[*place], &mut touched);
        }
    }
    touched
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

/// All roads from one intersection to the next.
struct Roads {
    roads: Vec<Road>,
    /// For each way the roads that it is part of.
    of_ways: Lists<u32>,
}

impl Roads {
    fn of(survey: &Survey, places: &[Point]) -> Self {
        let mut pieces = Pieces { survey, meeting: meeting(survey), joined: Vec::new(), ending: FxHashMap::default() };
        let (mut squares, mut of_ways) = (Vec::new(), Lists::default());
        for (way, of) in survey.ways.iter().enumerate() {
            let first = squares.len() as u32;
            let of_way = if *of == WayUse::Driven { pieces.of(way) } else { Vec::new() };
            for piece in of_way {
                pieces.add(piece);
                squares.push(touched(&line(piece, places)));
            }
            of_ways.push(first..squares.len() as u32);
        }
        let mut roads: Vec<Road> = vec![Road::new(); squares.len()];
        let first: Vec<usize> = (0..squares.len()).map(|piece| pieces.first(piece)).collect();
        for (squares, first) in squares.into_iter().zip(&first) {
            roads.get_mut(*first).into_iter().for_each(|road| road.extend(&squares));
        }
        // Of a road that is made of several pieces the first stands for all.
        for piece in of_ways.items_mut() {
            *piece = first.get(*piece as usize).map_or(*piece, |first| *first as u32);
        }
        Self { roads, of_ways }
    }
}

/// How many pieces of driven ways meet at each node, up to 3.
fn meeting(survey: &Survey) -> Vec<u8> {
    let mut meeting = vec![0_u8; survey.places.len()];
    for (way, _) in survey.ways.iter().enumerate().filter(|(_, of)| **of == WayUse::Driven) {
        let nodes = survey.way_nodes.at(way);
        for (i, node) in nodes.iter().enumerate() {
            let sides = if i == 0 || i + 1 == nodes.len() { 1 } else { 2 };
            if let Some(meeting) = meeting.get_mut(*node as usize) {
                *meeting = (*meeting + sides).min(3);
            }
        }
    }
    meeting
}

/// Pieces of driven ways that end where roads meet, and which of them are one road.
struct Pieces<'a> {
    survey: &'a Survey,
    meeting: Vec<u8>,
    /// By piece: another of the same road, or itself.
    joined: Vec<usize>,
    /// The first piece that ends at a node where two end.
    ending: FxHashMap<u32, usize>,
}

impl<'a> Pieces<'a> {
    /// A way in pieces that end where roads meet.
    fn of(&self, way: usize) -> Vec<&'a [u32]> {
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
