//! Which data each tile needs: all that touches a square near it, or near a road that touches it.

use std::collections::BTreeSet;

use rustc_hash::{FxHashMap, FxHashSet};

use crate::cells::{Cell, CellSets, Grid, Lists, NOWHERE, SetId};
use crate::geometry::Point;

use super::survey::{GONE, Survey, WayUse};

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
    needed_by: NeededBy,
    /// For each way the tiles that need one of the roads that it is part of, by their squares: roads are needed whole.
    roads_of_ways: Lists<u32>,
    needed_roads: Vec<SetId>,
    pub(super) sets: CellSets,
}

impl Reach {
    /// Finds which tiles there are and what they need, by the places of all nodes in the plane.
    pub fn new(survey: &Survey, places: &[Point], size: TileSize) -> Self {
        let roads = Roads::of(survey, places);
        let mut sets = CellSets::default();
        let needed_by = NeededBy::of(&roads, places, size, &mut sets);
        let of_road = |road| union(&mut sets, roads.squares(road).filter_map(|square| needed_by.get(*square)));
        let needed_roads = (0..roads.count() as u32).map(of_road).collect();
        Self { needed_by, roads_of_ways: roads.of_ways, needed_roads, sets }
    }

    /// The tiles that need a place.
    pub(super) fn of_node(&mut self, place: &[Point]) -> SetId {
        let touched = touched(place);
        union(&mut self.sets, touched.iter().filter_map(|square| self.needed_by.get(*square)))
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

/// The tiles that need what touches a square, by squares in order: half as much memory as a map by hashes takes.
#[derive(Debug)]
struct NeededBy(Vec<(Cell, SetId)>);

impl NeededBy {
    /// A tile is there where a road comes near.
    fn of(roads: &Roads, places: &[Point], size: TileSize, sets: &mut CellSets) -> Self {
        let margin = (size.margin / SQUARES.size()).ceil() as i32;
        let at = RoadsBySquare::of(roads);
        let mut tiles: BTreeSet<Cell> = BTreeSet::new();
        for square in at.squares() {
            let near = (-1..=1).flat_map(|row| (-1..=1).map(move |column| (row, column)));
            let near = near.map(|(row, column)| Cell { row: square.row + row, column: square.column + column });
            tiles.extend(near.flat_map(|square| covered(square, SQUARES, size.tiles)));
        }
        let mut needs: Vec<(Cell, SetId)> = Vec::new();
        for tile in tiles {
            let of_tile = sets.of(&[tile]);
            let looked_at = looked_at(tile, size.tiles, (roads, places), &at);
            needs.extend(around(looked_at.into_iter(), margin).into_iter().map(|square| (square, of_tile)));
        }
        needs.sort_unstable();
        needs.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 = sets.union(kept.1, next.1);
            }
            same
        });
        Self(needs)
    }

    fn get(&self, square: Cell) -> Option<SetId> {
        let at = self.0.binary_search_by_key(&square, |(square, _)| *square).ok()?;
        self.0.get(at).map(|(_, set)| *set)
    }
}

/// The squares of which a tile must be right: its own, those of the roads that come into it, and those of the roads with which
/// these meet, because the shape of an intersection depends on the direction of all of its roads, however far they run straight.
fn looked_at(tile: Cell, tiles: Grid, (roads, places): (&Roads, &[Point]), at: &RoadsBySquare) -> FxHashSet<Cell> {
    let mut looked_at = around(covered(tile, tiles, SQUARES), 1);
    let roads_at =
        |squares: &FxHashSet<Cell>| -> Vec<u32> { squares.iter().flat_map(|square| at.at(*square)).collect() };
    let own = roads_at(&looked_at);
    let ends = own.iter().flat_map(|road| roads.ends(*road)).flat_map(|node| touched(&line(&[node], places)));
    let ends = around(ends, 1);
    for road in own.into_iter().chain(roads_at(&ends)) {
        looked_at.extend(roads.squares(road));
    }
    looked_at
}

/// The roads that touch each square.
struct RoadsBySquare(Vec<(Cell, u32)>);

impl RoadsBySquare {
    fn of(roads: &Roads) -> Self {
        let mut all: Vec<(Cell, u32)> = Vec::with_capacity(roads.squares.items());
        for road in 0..roads.count() as u32 {
            all.extend(roads.squares(road).map(|square| (*square, road)));
        }
        all.sort_unstable();
        all.dedup();
        Self(all)
    }

    /// Each square that a road touches.
    fn squares(&self) -> impl Iterator<Item = Cell> {
        self.0.chunk_by(|a, b| a.0 == b.0).filter_map(|chunk| Some(chunk.first()?.0))
    }

    fn at(&self, square: Cell) -> impl Iterator<Item = u32> {
        let begin = self.0.partition_point(|(other, _)| *other < square);
        self.0.iter().skip(begin).take_while(move |(other, _)| *other == square).map(|(_, road)| *road)
    }
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

/// All roads, each from one intersection to the next over all ways that it is made of. A road of several pieces goes by the first
/// of them; the others are none by themselves. Some 40 bytes are held for each piece.
#[derive(Default)]
struct Roads {
    /// By piece: what it touches.
    squares: Lists<Cell>,
    /// By piece: the nodes at which its road ends, or [`GONE`].
    ends: Vec<[u32; 2]>,
    /// By the first piece of a road that has several: the others.
    others: FxHashMap<u32, Vec<u32>>,
    /// The pieces that are one of the others.
    parts: FxHashSet<u32>,
    /// For each way the roads that it is part of.
    of_ways: Lists<u32>,
}

impl Roads {
    fn of(survey: &Survey, places: &[Point]) -> Self {
        let mut pieces = Pieces { survey, meeting: meeting(survey), joined: Vec::new(), ending: FxHashMap::default() };
        let mut roads = Self::default();
        for (way, of) in survey.ways.iter().enumerate() {
            let first = pieces.joined.len() as u32;
            let of_way = if *of == WayUse::Driven { pieces.of(way) } else { Vec::new() };
            for piece in of_way {
                pieces.add(piece);
                let ends = [piece.first(), piece.last()].map(|node| node.copied().unwrap_or(GONE));
                roads.ends.push(ends.map(|node| if pieces.meeting(node) == 2 { GONE } else { node }));
                roads.squares.push(touched(&line(piece, places)));
            }
            roads.of_ways.push(first..pieces.joined.len() as u32);
        }
        for piece in 0..pieces.joined.len() as u32 {
            let first = pieces.first(piece);
            if first != piece {
                roads.others.entry(first).or_default().push(piece);
                roads.parts.insert(piece);
            }
        }
        for piece in roads.of_ways.items_mut() {
            *piece = pieces.first(*piece);
        }
        roads
    }

    /// How many pieces there are.
    fn count(&self) -> usize {
        self.squares.count()
    }

    /// What a road touches; nothing for a piece that is part of another.
    fn squares(&self, road: u32) -> impl Iterator<Item = &Cell> {
        self.pieces(road).flat_map(|piece| self.squares.at(piece as usize))
    }

    /// The nodes at which a road ends; some are [`GONE`].
    fn ends(&self, road: u32) -> impl Iterator<Item = u32> {
        self.pieces(road).filter_map(|piece| self.ends.get(piece as usize)).flatten().copied()
    }

    fn pieces(&self, road: u32) -> impl Iterator<Item = u32> {
        let whole = (!self.parts.contains(&road)).then_some(road);
        whole.into_iter().chain(self.others.get(&road).into_iter().flatten().copied())
    }
}

/// How many pieces of driven ways meet at each node, up to 3.
fn meeting(survey: &Survey) -> Vec<u8> {
    let mut meeting = vec![0_u8; survey.node_ids.len()];
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
    joined: Vec<u32>,
    /// The first piece that ends at a node where two end.
    ending: FxHashMap<u32, u32>,
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
        let index = self.joined.len() as u32;
        self.joined.push(index);
        for end in [piece.first(), piece.last()].into_iter().flatten() {
            if self.meeting(*end) == 2 {
                let other = *self.ending.entry(*end).or_insert(index);
                let (one, other) = (self.first(index), self.first(other));
                if let Some(joined) = self.joined.get_mut(one.max(other) as usize) {
                    *joined = one.min(other);
                }
            }
        }
    }

    /// The first piece of the road that a piece belongs to.
    fn first(&mut self, mut piece: u32) -> u32 {
        while let Some(before) = self.joined.get(piece as usize).copied().filter(|before| *before != piece) {
            let first = self.joined.get(before as usize).copied().unwrap_or(before);
            // So the way there is halved each time.
            if let Some(joined) = self.joined.get_mut(piece as usize) {
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
