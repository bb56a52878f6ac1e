//! A file, cut up into stretches, and the lanelets that are drawn for its lanes.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::diagnostic::{Finding, Subject};
use crate::lanelet::{Bound, LaneletId, PointId};
use crate::xodr::{OpenDrive, Place, Road, Section, inner};

use super::contacts::LaneEnd;
use super::lane_use::LaneUse;
use super::plane::Plane;
use super::stretches::{CutRoad, Stretch};

/// The width, metres, with which a lane begins or ends that has none there: its bounds must not meet.
const HAIR: f64 = 0.02;

/// A lanelet of a lane.
#[derive(Clone, Debug)]
pub struct DrawnLane {
    /// Index of the stretch.
    pub stretch: usize,
    /// The lane.
    pub lane: i64,
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
        LaneEnd { stretch: self.stretch, far: self.direction > 0, lane: self.lane }
    }

    /// The end of the lane at which vehicles enter it.
    pub fn entry(&self) -> LaneEnd {
        LaneEnd { stretch: self.stretch, far: self.direction < 0, lane: self.lane }
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
        let found = sections.iter().rev().find(|section| section.span[0] <= middle).or(sections.first());
        found.copied().unwrap_or(&self.road(stretch).sections[0])
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
        let road = self.road(stretch);
        let section = if far { sections.last() } else { sections.first() };
        section.map_or([0.0; 3], |section| {
            let (offset, side) = (section.offset(road, border, station), border.signum() as f64);
            let inside = section.offset(road, inner(border), station);
            let driven = section.lane(border).is_some_and(|lane| LaneUse::of(lane).is_driven());
            let pinched = driven && side * (offset - inside) < HAIR;
            road.place(station, if pinched { inside + side * HAIR } else { offset })
        })
    }
}

/// The lanelets of a map.
#[derive(Default)]
pub struct Drawn {
    /// In order of stretches, of lanes from left to right, and of directions.
    pub lanes: Vec<DrawnLane>,
    /// By lane and direction.
    pub of_lane: BTreeMap<(usize, i64, i8), usize>,
    /// For each lane those that follow it by the links of the file and by their nodes.
    pub next: Vec<Vec<usize>>,
    /// For each lane those that it follows.
    pub back: Vec<Vec<usize>>,
    /// What could not be drawn as it should.
    pub notes: Vec<Finding>,
}

impl Drawn {
    /// The lanelets of a stretch, with their indices, in order.
    pub fn on(&self, stretch: usize) -> impl Iterator<Item = (usize, &DrawnLane)> {
        let first = self.lanes.partition_point(|lane| lane.stretch < stretch);
        self.lanes.iter().enumerate().skip(first).take_while(move |(_, lane)| lane.stretch == stretch)
    }
}

/// A note about a line of the file.
pub fn note(fault: &'static str, line: usize, message: String) -> Finding {
    Finding::new(fault, Subject::Map, format!("line {line}: {message}"))
}
