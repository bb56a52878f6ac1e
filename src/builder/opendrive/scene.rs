//! A file, cut up into stretches, and the lanelets that are drawn for its lanes.

use std::collections::{BTreeMap, BTreeSet};

use crate::builder::ids::Key;
use crate::diagnostic::{Finding, Subject};
use crate::lanelet::{Bound, LaneletId, PointId};
use crate::xodr::{OpenDrive, Place, Road, Section, Validity};

use super::contacts::LaneEnd;
use super::lane_use::LaneUse;
use super::plane::Plane;
use super::stretches::{CutRoad, Stretch, section_at};

/// The least width of a lane, metres, where it begins or ends without one: its bounds must not meet, nor cross where they are sampled.
const HAIR: f64 = 0.01;

/// A lane of a stretch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Piece {
    /// Index of the stretch.
    pub stretch: usize,
    /// The lane.
    pub lane: i64,
}

/// Where a lanelet stands in the file that it was built from.
#[derive(Clone, Debug)]
pub struct FileLane {
    /// The lanelet.
    pub lanelet: LaneletId,
    /// The line of the road.
    pub line: usize,
    /// The road's id.
    pub road: String,
    /// The lane's id where the lanelet begins along the road.
    pub lane: i64,
}

/// A lanelet of a lane.
#[derive(Clone, Debug)]
pub struct DrawnLane {
    /// What it leads along, in order along the road: one piece, but for connecting roads.
    pub pieces: Vec<Piece>,
    /// 1 along the road, -1 against it.
    pub direction: i8,
    /// What it is for.
    pub used: LaneUse,
    /// Its lanelet.
    pub lanelet: LaneletId,
    /// Left and right bound, in its direction of travel.
    pub bounds: [Bound; 2],
    /// Left and right node where it begins, and where it ends.
    pub nodes: [[PointId; 2]; 2],
}

impl DrawnLane {
    /// The end of the lane at which vehicles leave it.
    pub fn exit(&self) -> LaneEnd {
        self.at(self.direction > 0)
    }

    /// The end of the lane at which vehicles enter it.
    pub fn entry(&self) -> LaneEnd {
        self.at(self.direction < 0)
    }

    /// Its end at the larger station, or at the smaller one.
    fn at(&self, far: bool) -> LaneEnd {
        let piece = if far { self.pieces.last() } else { self.pieces.first() };
        let Piece { stretch, lane } = piece.copied().unwrap_or_default();
        LaneEnd { stretch, far, lane }
    }

    /// Its first stretch along the road.
    pub fn stretch(&self) -> usize {
        self.at(false).stretch
    }

    /// Its piece on a stretch.
    pub fn piece_on(&self, stretch: usize) -> Option<Piece> {
        self.pieces.iter().copied().find(|piece| piece.stretch == stretch)
    }
}

/// A file, cut up.
pub struct Scene<'a> {
    /// The file.
    pub file: &'a OpenDrive,
    /// Its plane.
    pub plane: &'a Plane,
    /// Its roads, cut.
    pub cut: &'a [CutRoad],
    /// For each road the index of its first stretch.
    pub first: &'a [usize],
    /// The stretches of all roads.
    pub stretches: Vec<&'a Stretch>,
    /// For each road whether it is a connecting road of a junction with an area of its own.
    pub connecting: &'a [bool],
}

impl Scene<'_> {
    /// The stations between which a lanelet lies, metres.
    pub fn span(&self, lane: &DrawnLane) -> [f64; 2] {
        [false, true].map(|far| self.stretches[lane.at(far).stretch].span[usize::from(far)])
    }

    /// The piece of a lanelet at a station of its road.
    pub fn piece_at(&self, lane: &DrawnLane, station: f64) -> Piece {
        let begins = |piece: &&Piece| self.stretches[piece.stretch].span[0] <= station;
        lane.pieces.iter().rev().find(begins).or(lane.pieces.first()).copied().unwrap_or_default()
    }

    /// The piece in the middle of a lanelet.
    pub fn middle_piece(&self, lane: &DrawnLane) -> Piece {
        let [from, to] = self.span(lane);
        self.piece_at(lane, f64::midpoint(from, to))
    }

    /// The index of the road of a lanelet.
    pub fn road_of(&self, lane: &DrawnLane) -> usize {
        self.stretches[lane.stretch()].road
    }

    /// The road of a stretch.
    pub fn road(&self, stretch: usize) -> &Road {
        &self.file.roads[self.stretches[stretch].road]
    }

    /// The sections of a stretch, in order.
    pub fn sections(&self, stretch: usize) -> Vec<&Section> {
        let it = self.stretches[stretch];
        let road = self.road(stretch);
        self.cut[it.road].kept[it.sections.clone()].iter().map(|&section| &road.sections[section]).collect()
    }

    /// The section of a stretch in the middle.
    pub fn section(&self, stretch: usize) -> &Section {
        let middle = self.middle(stretch);
        let sections = self.sections(stretch);
        section_at(&sections, middle).unwrap_or(&self.road(stretch).sections[0])
    }

    /// The section of a stretch at a station.
    pub fn section_near(&self, stretch: usize, station: f64) -> &Section {
        section_at(&self.sections(stretch), station).unwrap_or_else(|| self.section(stretch))
    }

    /// The station in the middle of a stretch, metres.
    pub fn middle(&self, stretch: usize) -> f64 {
        let [from, to] = self.stretches[stretch].span;
        f64::midpoint(from, to)
    }

    /// The key of a part of a stretch.
    pub fn key(&self, part: &str, stretch: usize) -> Key {
        let it = self.stretches[stretch];
        let key = Key::new("opendrive").word(part).word(&self.road(stretch).id).number(it.first_section as i64);
        if it.part == 0 { key } else { key.word("part").number(it.part as i64) }
    }

    /// The place of the outer border of a lane at an end of a stretch.
    pub fn border_at(&self, stretch: usize, far: bool, border: i64) -> Place {
        let sections = self.sections(stretch);
        let [from, to] = self.stretches[stretch].span;
        let station = if far { to } else { from };
        let section = if far { sections.last() } else { sections.first() };
        section.map_or([0.0; 3], |section| self.border_place(stretch, section, border, station))
    }

    /// The place of the outer border of a lane in a section of a stretch.
    pub fn border_place(&self, stretch: usize, section: &Section, border: i64, station: f64) -> Place {
        let driven = &self.stretches[stretch].driven;
        let [x, y, z] = self.road(stretch).place(station, self.offset(stretch, section, border, station));
        [x, y, z + section.lift(border, station, |lane| driven.contains(&lane))]
    }

    /// The offset of the outer border of a lane in a section of a stretch, metres to the left, with a hair of width for each lane that
    /// becomes a lanelet.
    pub fn offset(&self, stretch: usize, section: &Section, border: i64, station: f64) -> f64 {
        let drawn = &self.stretches[stretch].driven;
        let least = |lane: i64| if drawn.contains(&lane) { HAIR } else { f64::NEG_INFINITY };
        section.offset_of_wide(self.road(stretch), border, station, least)
    }
}

/// The lanelets of a map.
#[derive(Default)]
pub struct Drawn {
    /// In order of stretches, of lanes from left to right, and of directions.
    pub lanes: Vec<DrawnLane>,
    /// For each stretch its lanelets, in order.
    pub on_stretch: BTreeMap<usize, Vec<usize>>,
    /// For each lane those that follow it by the links of the file and by their nodes.
    pub next: Vec<Vec<usize>>,
    /// For each lane those that it follows.
    pub back: Vec<Vec<usize>>,
    /// The ends of lanes that the file links to others.
    pub linked: BTreeSet<LaneEnd>,
    /// What could not be drawn as it should.
    pub notes: Vec<Finding>,
}

impl Drawn {
    /// A lane as the file names it, with its lanelets, by which `check` speaks of it.
    pub fn name(&self, scene: &Scene, piece: Piece) -> String {
        let ids: Vec<String> = self.lanelets(piece).map(|id| id.0.to_string()).collect();
        let lanelets = if ids.len() == 1 { "lanelet" } else { "lanelets" };
        format!("lane {} of road {} ({lanelets} {})", piece.lane, scene.road(piece.stretch).id, ids.join(", "))
    }

    /// A finding that is also about the lanelets of a lane.
    pub fn about(&self, finding: Finding, piece: Piece) -> Finding {
        self.lanelets(piece).fold(finding, |finding, id| finding.with(Subject::Lanelet(id.0), "lane"))
    }

    fn lanelets(&self, Piece { stretch, lane }: Piece) -> impl Iterator<Item = LaneletId> {
        let along =
            self.on(stretch).filter(move |(_, it)| it.piece_on(stretch).is_some_and(|piece| piece.lane == lane));
        along.map(|(_, it)| it.lanelet)
    }

    /// Where all lanelets stand in the file, in order of their ids.
    pub fn in_file(&self, scene: &Scene) -> Vec<FileLane> {
        let of = |drawn: &DrawnLane| {
            let piece = drawn.pieces.first()?;
            let road = scene.road(piece.stretch);
            Some(FileLane { lanelet: drawn.lanelet, line: road.line, road: road.id.to_string(), lane: piece.lane })
        };
        let mut lanes: Vec<FileLane> = self.lanes.iter().filter_map(of).collect();
        lanes.sort_by_key(|lane| lane.lanelet);
        lanes
    }

    /// The lanelets of a stretch, with their indices, in order.
    pub fn on(&self, stretch: usize) -> impl Iterator<Item = (usize, &DrawnLane)> {
        self.on_stretch.get(&stretch).into_iter().flatten().map(|&at| (at, &self.lanes[at]))
    }

    /// Adds a lanelet.
    pub fn push(&mut self, lane: DrawnLane) {
        for piece in &lane.pieces {
            self.on_stretch.entry(piece.stretch).or_default().push(self.lanes.len());
        }
        self.lanes.push(lane);
    }
}

/// A note about a line of the file.
pub fn note(fault: &'static str, line: usize, message: String) -> Finding {
    Finding::new(fault, Subject::Map, format!("line {line}: {message}"))
}

/// The lanelets at a station of a road for which something counts.
pub fn spoken_to(scene: &Scene, drawn: &Drawn, road: usize, station: f64, validity: &Validity) -> Vec<usize> {
    let Some(stretch) = stretch_at(scene, road, station) else { return Vec::new() };
    let here = drawn.on(stretch).filter(|(_, lane)| lane.used.is_driven());
    let named: Vec<(usize, i8)> = here
        .filter(|(_, lane)| lane.piece_on(stretch).is_some_and(|piece| validity.names(piece.lane)))
        .map(|(at, lane)| (at, lane.direction))
        .collect();
    let faces = |direction: i8| validity.facing == 0 || validity.facing == direction;
    let facing: Vec<usize> = named.iter().filter(|(_, direction)| faces(*direction)).map(|(at, _)| *at).collect();
    // Some exporters name lanes of the other direction than the one they state, or state the other one on a connecting road: the
    // lanes count.
    let stated_wrongly = !validity.lanes.is_empty() || scene.connecting[road];
    if facing.is_empty() && stated_wrongly { named.into_iter().map(|(at, _)| at).collect() } else { facing }
}

/// The stretch of a road in which a station lies, by its index among all.
pub fn stretch_at(scene: &Scene, road: usize, station: f64) -> Option<usize> {
    let stretches = &scene.cut[road].stretches;
    let at = stretches.iter().rposition(|stretch| stretch.span[0] <= station + 1e-9).unwrap_or(0);
    (!stretches.is_empty()).then_some(scene.first[road] + at)
}
