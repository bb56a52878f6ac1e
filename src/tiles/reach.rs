//! Which data each tile needs: all that touches a square near it, or near a road that touches it.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cells::{Cell, CellSets, Grid, Lists, NOWHERE, SetId};
use crate::geometry::Point;

use super::survey::{Survey, WayUse};

/// Squares by which is told what is near, with sides of 100 m: no intersection reaches farther from the nodes of its roads.
const SQUARES: Grid = Grid::of_metres(100);

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

impl Reach {
    /// Finds which tiles there are and what they need, by the places of all nodes in the plane.
    pub fn new(survey: &Survey, places: &[Point], size: TileSize) -> Self {
        let Roads { roads, of_ways } = Roads::of(survey, places);
        let mut sets = CellSets::default();
        let needed_by = needed_by(&roads, size, &mut sets);
        let of_road =
            |road: &Road| union(&mut sets, road.squares.iter().filter_map(|square| needed_by.get(square).copied()));
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

/// The tiles that need what touches a square. A tile is there where a road comes near.
fn needed_by(roads: &[Road], size: TileSize, sets: &mut CellSets) -> FxHashMap<Cell, SetId> {
    let margin = (size.margin / SQUARES.size()).ceil() as i32;
    let mut at: FxHashMap<Cell, Vec<&Road>> = FxHashMap::default();
    for road in roads {
        road.squares.iter().for_each(|square| at.entry(*square).or_default().push(road));
    }
    let near: FxHashSet<Cell> = around(at.keys().copied(), 1);
    let tiles: FxHashSet<Cell> = near.into_iter().flat_map(|square| covered(square, SQUARES, size.tiles)).collect();
    let mut tiles = Vec::from_iter(tiles);
    tiles.sort_unstable();
    let mut needed_by: FxHashMap<Cell, SetId> = FxHashMap::default();
    for tile in tiles {
        let of_tile = sets.of(&[tile]);
        for square in around(looked_at(tile, size.tiles, &at).into_iter(), margin) {
            let set = needed_by.entry(square).or_insert(NOWHERE);
            *set = sets.union(*set, of_tile);
        }
    }
    needed_by
}

/// The squares of which a tile must be right: its own, those of the roads that come into it, and those of the roads with which
/// these meet, because the shape of an intersection depends on the direction of all of its roads, however far they run straight.
fn looked_at(tile: Cell, tiles: Grid, at: &FxHashMap<Cell, Vec<&Road>>) -> FxHashSet<Cell> {
    let mut looked_at = around(covered(tile, tiles, SQUARES), 1);
    let roads_at = |squares: &FxHashSet<Cell>| -> Vec<&Road> {
        squares.iter().filter_map(|square| at.get(square)).flatten().copied().collect()
    };
    let own = roads_at(&looked_at);
    let ends = around(own.iter().flat_map(|road| road.ends.iter().copied()), 1);
    for road in own.into_iter().chain(roads_at(&ends)) {
        looked_at.extend(&road.squares);
    }
    looked_at
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

/// The cells of one grid that touch a cell of another.
fn covered(cell: Cell, of: Grid, grid: Grid) -> impl Iterator<Item = Cell> {
    let [west, south] = of.corner(cell);
    let range = move |low: f64| (low / grid.size()).floor() as i32..((low + of.size()) / grid.size()).ceil() as i32;
    range(south).flat_map(move |row| range(west).map(move |column| Cell { row, column }))
}

/// The squares up to so many away, along rows and along columns.
fn around(squares: impl Iterator<Item = Cell>, reach: i32) -> FxHashSet<Cell> {
    let beside: FxHashSet<Cell> = squares
        .flat_map(|Cell { row, column }| (-reach..=reach).map(move |by| Cell { row, column: column + by }))
        .collect();
    beside
        .into_iter()
        .flat_map(|Cell { row, column }| (-reach..=reach).map(move |by| Cell { row: row + by, column }))
        .collect()
}

/// A road from one intersection to the next, over all ways that it is made of.
#[derive(Debug, Default)]
struct Road {
    /// What it touches.
    squares: Vec<Cell>,
    /// Those in which it ends.
    ends: Vec<Cell>,
}

/// All roads.
struct Roads {
    roads: Vec<Road>,
    /// For each way the roads that it is part of.
    of_ways: Lists<u32>,
}

impl Roads {
    fn of(survey: &Survey, places: &[Point]) -> Self {
        let mut pieces = Pieces { survey, meeting: meeting(survey), joined: Vec::new(), ending: FxHashMap::default() };
        let (mut roads, mut of_ways) = (Vec::new(), Lists::default());
        for (way, of) in survey.ways.iter().enumerate() {
            let first = roads.len() as u32;
            let of_way = if *of == WayUse::Driven { pieces.of(way) } else { Vec::new() };
            for piece in of_way {
                pieces.add(piece);
                let ends = [piece.first(), piece.last()].into_iter().flatten();
                let ends: Vec<u32> = ends.copied().filter(|node| pieces.meeting(*node) != 2).collect();
                let ends = ends.into_iter().flat_map(|node| touched(&line(&[node], places))).collect();
                roads.push(Road { squares: touched(&line(piece, places)), ends });
            }
            of_ways.push(first..roads.len() as u32);
        }
        let first: Vec<usize> = (0..roads.len()).map(|piece| pieces.first(piece)).collect();
        // Of a road that is made of several pieces the first stands for all.
        for (piece, first) in first.iter().enumerate().filter(|(piece, first)| piece != *first) {
            let Road { squares, ends } = roads.get_mut(piece).map(std::mem::take).unwrap_or_default();
            if let Some(road) = roads.get_mut(*first) {
                road.squares.extend(squares);
                road.ends.extend(ends);
            }
        }
        for Road { squares, ends } in &mut roads {
            for cells in [squares, ends] {
                cells.sort_unstable();
                cells.dedup();
            }
        }
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
