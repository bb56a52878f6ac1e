//! Lanes of roads, the pieces of a road between its cuts, and the arm of a road at an intersection.

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{End, Intersection, RoadEnd, RoadIx};
use crate::builder::streets::heights::Ground;
use crate::builder::tags::cross_section::{Arrows, StripKind};
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Vector};
use crate::lanelet::{Bound, LaneletId, PointId};

/// One lane of a road.
#[derive(Clone, Debug)]
pub struct RoadLane {
    /// The road.
    pub road: RoadIx,
    /// Its strip in the cross-section.
    pub strip: usize,
    /// Whether it runs against the road's line.
    pub backward: bool,
    /// Its lanelet.
    pub lanelet: LaneletId,
    /// Bounds, in its direction of travel.
    pub left: Bound,
    /// See [`RoadLane::left`].
    pub right: Bound,
}

/// A lane where it meets an intersection.
#[derive(Clone, Copy, Debug)]
pub struct ArmLane {
    /// Index in [`Lanes::lanes`].
    pub lane: usize,
    /// End nodes on the cut, left and right in its direction of travel.
    pub nodes: [PointId; 2],
    /// Their places.
    pub places: [Point; 2],
    /// Middle of the lane on the cut, in its direction of travel.
    pub pose: Pose,
    /// Width on the cut, metres.
    pub width: f64,
    /// What the strip is for.
    pub kind: StripKind,
    /// Arrows painted on it.
    pub arrows: Arrows,
    /// How far it goes straight on over a crosswalk inside the intersection, metres.
    pub straight: f64,
}

#[cfg(test)]
impl ArmLane {
    /// A lane for cars, 3 m wide, in the origin.
    pub fn plain() -> Self {
        Self {
            lane: 0,
            nodes: [PointId(1), PointId(2)],
            places: [Point::origin(); 2],
            pose: Pose { point: Point::origin(), heading: Vector::new(1.0, 0.0) },
            width: 3.0,
            kind: StripKind::Drive,
            arrows: Arrows::NONE,
            straight: 0.0,
        }
    }
}

impl ArmLane {
    /// The end of a lane of [`Lanes::lanes`] on these nodes, left and right, without arrows.
    pub fn new(assembly: &MapBuilder, lane: usize, nodes: [PointId; 2], heading: Vector, kind: StripKind) -> Self {
        let places = nodes.map(|id| assembly.position(id));
        let [left, right] = places;
        let pose = Pose { point: nalgebra::center(&left, &right), heading };
        Self { lane, nodes, places, pose, width: (left - right).norm(), kind, arrows: Arrows::NONE, straight: 0.0 }
    }
}

/// The end of a road at an intersection.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Which road, which end.
    pub at: RoadEnd,
    /// Unit direction from the road into the intersection.
    pub inward: Vector,
    /// Unit direction from the cut to the end of the road's line inside the intersection: it differs from `inward` where the
    /// cut lies before a bend or in it.
    pub aim: Vector,
    /// Lanes that lead in, from left to right in their direction of travel.
    pub into: Vec<ArmLane>,
    /// Lanes that lead out, from left to right in their direction of travel.
    pub out: Vec<ArmLane>,
    /// Every lane end node and both kerb ends on the cut, right to left looking into the intersection.
    pub cut: Vec<PointId>,
}

impl Arm {
    /// The ends of a road of which nothing is drawn yet.
    pub(super) fn undrawn(road: RoadIx) -> [Self; 2] {
        let nothing = Vector::zeros();
        let arm = |end| Self {
            at: RoadEnd { road, end },
            inward: nothing,
            aim: nothing,
            into: Vec::new(),
            out: Vec::new(),
            cut: Vec::new(),
        };
        End::BOTH.map(arm)
    }
}

/// All lanes and arms.
#[derive(Clone, Debug, Default)]
pub struct Lanes {
    /// In order of roads, of their pieces and of strips.
    pub lanes: Vec<RoadLane>,
    /// Per road: the arms at its start and its end.
    pub arms: Vec<[Arm; 2]>,
    /// Per road, along its line.
    pub(crate) pieces: Vec<Vec<RoadPiece>>,
}

/// A part of a road between two places where it is split, or between one and its end.
#[derive(Clone, Debug)]
pub struct RoadPiece {
    /// Why the road is split where the piece begins; `None` at the begin of the road.
    pub behind: Option<SplitReason>,
    /// The stations of the road's line between which it lies, metres.
    pub span: [f64; 2],
    /// By the edges of the cross-section, each along the road's line.
    pub borders: Vec<Option<Bound>>,
}

impl Lanes {
    /// The lanes of a road.
    pub fn of_road(&self, road: RoadIx) -> &[RoadLane] {
        &self.lanes[self.range_of(road)]
    }

    pub(super) fn range_of(&self, road: RoadIx) -> std::ops::Range<usize> {
        let first = self.lanes.partition_point(|l| l.road < road);
        let last = self.lanes.partition_point(|l| l.road <= road);
        first..last
    }

    /// The pieces of a road, along its line.
    pub fn pieces_of(&self, road: RoadIx) -> &[RoadPiece] {
        self.pieces.get(road.position()).map_or(&[][..], Vec::as_slice)
    }

    /// The piece of a road at a station, and its lanes.
    pub fn piece_at(&self, road: RoadIx, station: f64) -> Option<(&RoadPiece, &[RoadLane])> {
        let (pieces, lanes) = (self.pieces_of(road), self.of_road(road));
        let i = pieces.iter().position(|piece| station <= piece.span[1])?;
        let count = lanes.len() / pieces.len();
        Some((&pieces[i], lanes.get(i * count..(i + 1) * count)?))
    }

    /// The borders of the piece at an end of a road, see [`RoadPiece::borders`].
    pub fn borders_at(&self, at: RoadEnd) -> &[Option<Bound>] {
        let pieces = self.pieces_of(at.road);
        let piece = if at.end == End::Start { pieces.first() } else { pieces.last() };
        piece.map_or(&[][..], |piece| &piece.borders)
    }

    /// The ground between the cuts of an intersection.
    pub fn ground_of(&self, intersection: &Intersection, assembly: &MapBuilder) -> Ground {
        assembly.ground_between(intersection.arms.iter().flat_map(|&at| self.arm(at).cut.iter().copied()))
    }

    /// The arm at the end of a road.
    pub fn arm(&self, at: RoadEnd) -> &Arm {
        &self.arms[at.road][at.end]
    }
}

/// Why a road is split.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplitReason {
    /// The approach to the stop line at an end of the road begins.
    Stop(End),
    /// Vehicles toward an end stop before a crossing, an OpenStreetMap node.
    Line(i64, End),
    /// The approach to that stop line begins.
    Approach(i64, End),
}

impl SplitReason {
    /// Refines the key of a road's element to that of the piece behind the split.
    pub fn of(self, key: Key) -> Key {
        let (word, node, end) = match self {
            Self::Stop(end) => ("stop", 0, end),
            Self::Line(node, end) => ("line", node, end),
            Self::Approach(node, end) => ("approach", node, end),
        };
        key.word(word).number(node).number(end.index() as i64)
    }
}
