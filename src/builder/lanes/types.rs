//! Lanes of roads, the pieces of a road between its cuts, and a road's arm at an intersection.

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
    /// See [`Lane::left`].
    pub right: Bound,
    /// What the strip is for.
    pub kind: StripKind,
}

/// A lane where it meets an intersection.
#[derive(Clone, Copy, Debug)]
pub struct ArmLane {
    /// Index in [`Lanes::lanes`].
    pub lane: usize,
    /// End nodes on the cut, left and right in its direction of travel.
    pub nodes: [PointId; 2],
    /// Where they lie.
    pub places: [Point; 2],
    /// Middle of the cut, in the direction of travel.
    pub pose: Pose,
    /// Metres.
    pub width: f64,
    /// What the strip is for.
    pub kind: StripKind,
    /// Arrows painted on it.
    pub arrows: Arrows,
}

/// A road where it meets an intersection.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Which road, which end.
    pub at: RoadEnd,
    /// Unit direction from the road into the intersection.
    pub inward: Vector,
    /// Unit direction from the cut to the place where the road's line ends inside: where the road leads in the end, when
    /// the cut lies before or in a bend.
    pub aim: Vector,
    /// Lanes that lead in, from left to right in their direction of travel.
    pub into: Vec<ArmLane>,
    /// Lanes that lead out, from left to right in their direction of travel.
    pub out: Vec<ArmLane>,
    /// Every lane end node and both kerb ends on the cut, right to left looking into the intersection.
    pub cut: Vec<PointId>,
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

/// A road between its ends, or from one of the places where it was cut across to the next.
#[derive(Clone, Debug)]
pub struct RoadPiece {
    /// What begins or ends where it begins; `None` at the begin of the road.
    pub behind: Option<SplitReason>,
    /// Between which stations of the road's line it lies, metres.
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

    /// The borders of a road where it ends, by the edges of its cross-section, each along the road's line.
    pub fn borders_at(&self, at: RoadEnd) -> &[Option<Bound>] {
        let pieces = self.pieces_of(at.road);
        let piece = if at.end == End::Start { pieces.first() } else { pieces.last() };
        piece.map_or(&[][..], |piece| &piece.borders)
    }

    /// The ground between the ends of the lanes of an intersection.
    pub fn ground_of(&self, intersection: &Intersection, assembly: &MapBuilder) -> Ground {
        assembly.ground_between(intersection.arms.iter().flat_map(|&at| self.arm(at).cut.iter().copied()))
    }

    /// The arm at the end of a road.
    pub fn arm(&self, at: RoadEnd) -> &Arm {
        &self.arms[at.road][at.end]
    }
}

/// What begins or ends where a road is cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SplitReason {
    /// The stretch before the stop line at an end of the road.
    Stop(End),
    /// The place before a crossing, an OpenStreetMap node, where those who drive toward an end stop.
    Line(i64, End),
    /// The stretch before that.
    Approach(i64, End),
}

impl SplitReason {
    /// Refines the key of a road's element to that of the piece behind the cut.
    pub fn of(self, key: Key) -> Key {
        let (word, node, end) = match self {
            Self::Stop(end) => ("stop", 0, end),
            Self::Line(node, end) => ("line", node, end),
            Self::Approach(node, end) => ("approach", node, end),
        };
        key.word(word).number(node).number(end.index() as i64)
    }
}
