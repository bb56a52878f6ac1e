//! The index of a map, and what it is made of: conflicts, intersections with their approaches and movements, the driving side.

use std::sync::OnceLock;

use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use rustc_hash::{FxHashMap, FxHashSet};

use super::filled_unions::{FILLED, FilledUnions};
use super::lane::{Edge, Lane};
use super::view::View;
use crate::geometry::{Point, Polyline, Vector, polygon, simple_ring};
use crate::lanelet::right_of_way::{RankedMovement, Relation, yields};
use crate::lanelet::{
    LaneletId, LaneletMap, LineStringId, LoadFault, PointId, PolygonId, RegulatoryElement, RegulatoryElementId, Target,
    TurnDirection,
};
use crate::settings::Settings;

/// A place this close (m) to the outline of an area lies on it.
const ON_BORDER: f64 = 0.01;

/// Rectangles of lanes, each with the lane's position.
pub(crate) type LaneTree = RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>;

/// Stop lines by place.
pub(super) type StopLineTree = RTree<GeomWithData<Rectangle<[f64; 2]>, LineStringId>>;

/// Built on the first request.
pub(super) type StopLines = OnceLock<StopLineTree>;

/// The middles of the edges with which lanes start, and of those with which they end. Built on the first request.
pub(super) type EdgeTrees = OnceLock<[RTree<GeomWithData<[f64; 2], usize>>; 2]>;

/// The elements of which a lanelet is a member. Built on the first request, because only fixes need it.
pub(super) type Naming = OnceLock<FxHashMap<LaneletId, Vec<RegulatoryElementId>>>;

/// An intersection without an `intersection_area`.
#[derive(Clone, Debug)]
pub struct Unmarked {
    /// Its lanes, by their position in `MapIndex::lanes`, sorted.
    pub lanes: Vec<usize>,
    /// Longer ones that cross these on their level: roads that were not cut there.
    pub uncut: Vec<usize>,
    /// Middle of the lanes' box.
    pub middle: Point,
    /// Whether all of it is private ground: the aisles of a car park, or a driveway.
    pub private: bool,
    /// Whether cars cross there on the way to different roads; else they only join.
    pub crossed: bool,
}

/// A map with everything that rules look up. Lanelets that did not load correctly are not in `lanes`: the geometric rules skip
/// them, so that one broken bound does not cause ten findings.
#[derive(Debug)]
pub struct MapIndex<'m> {
    /// The map.
    pub map: &'m LaneletMap,
    /// What was wrong with it on loading.
    pub faults: &'m [LoadFault],
    /// What the user or the builder knows in addition.
    pub settings: &'m Settings,
    /// The sound lanelets in the map's order.
    pub lanes: Vec<Lane<'m>>,
    /// For every lane those that its outline overlaps, without siblings, followers and neighbours.
    pub conflicts: Vec<Vec<Conflict>>,
    /// The intersections, those with an area first, in the map's order.
    pub intersections: Vec<Intersection>,
    /// On which side people drive.
    pub side: SideVotes,
    /// For every intersection its traffic; without movements where the driving side is unknown.
    pub traffic: Vec<Traffic>,
    pub(super) named: Vec<Vec<usize>>,
    pub(super) stop_lines: StopLines,
    /// For each lane whether it runs around a roundabout, once that was asked.
    pub(super) on_roundabout: Vec<OnceLock<bool>>,
    /// Whether each lane starts on a roundabout and whether it ends there, found when it is first asked for.
    pub(super) ends_on_roundabout: Vec<OnceLock<[bool; 2]>>,
    pub(super) tree: LaneTree,
    pub(super) edges: EdgeTrees,
    pub(super) by_id: FxHashMap<LaneletId, usize>,
    pub(super) starting: FxHashMap<[PointId; 2], Vec<usize>>,
    pub(super) ending: FxHashMap<[PointId; 2], Vec<usize>>,
    pub(super) way_users: FxHashMap<LineStringId, Vec<usize>>,
    pub(super) referrers: FxHashMap<RegulatoryElementId, Vec<LaneletId>>,
    pub(super) naming: Naming,
    /// Found when it is first asked for.
    pub(super) unmarked: OnceLock<(Vec<Unmarked>, FxHashMap<usize, usize>)>,
    /// The same.
    pub(super) unloaded: OnceLock<FxHashSet<PointId>>,
    pub(super) intersections_of: Vec<Vec<usize>>,
    pub(super) touching: Vec<Vec<usize>>,
    pub(super) view: View<'m>,
    pub(super) filled_unions: Option<&'m FilledUnions>,
}

impl<'m> MapIndex<'m> {
    /// Every lanelet that loads, as Lanelet2 sees it.
    pub fn view(&self) -> &View<'m> {
        &self.view
    }

    /// The same, with the unions that an earlier version of the map needed.
    #[must_use]
    pub fn with_filled_unions(self, known: &'m FilledUnions) -> Self {
        Self { filled_unions: Some(known), ..self }
    }

    /// The outer edge of the union of rings after gaps are filled, clockwise, not closed; `None` if it is empty.
    pub(super) fn filled_union(&self, rings: &[Vec<Point>]) -> Option<Vec<Point>> {
        match self.filled_unions {
            Some(known) => known.of(rings),
            None => polygon::closed(rings, FILLED),
        }
    }

    /// Position of a lanelet in `lanes`; `None` if it is broken or not there.
    pub fn lane(&self, id: LaneletId) -> Option<usize> {
        self.by_id.get(&id).copied()
    }

    /// Lanes that start with the points with which this one ends, by position.
    pub fn followers(&self, lane: usize) -> &[usize] {
        self.starting_at(self.lanes[lane].end.ids)
    }

    /// Lanes that end with the points with which this one starts, by position.
    pub fn predecessors(&self, lane: usize) -> &[usize] {
        self.ending_at(self.lanes[lane].start.ids)
    }

    /// Lanes that start between two points, left and right, by position.
    pub fn starting_at(&self, ids: [PointId; 2]) -> &[usize] {
        self.starting.get(&ids).map_or(&[], Vec::as_slice)
    }

    /// Lanes that end between two points, left and right, by position.
    pub fn ending_at(&self, ids: [PointId; 2]) -> &[usize] {
        self.ending.get(&ids).map_or(&[], Vec::as_slice)
    }

    /// Whether a lane starts with the points with which another one ends.
    pub fn follows(&self, from: usize, to: usize) -> bool {
        self.lanes[from].end.ids == self.lanes[to].start.ids
    }

    /// Whether a single lane leads from the end of one to the start of another.
    pub fn are_linked(&self, from: usize, to: usize) -> bool {
        self.followers(from).iter().any(|&lane| self.follows(lane, to))
    }

    /// Other lanes that start with the same points.
    pub fn siblings(&self, lane: usize) -> impl Iterator<Item = usize> + '_ {
        let same = self.starting.get(&self.lanes[lane].start.ids).map_or(&[][..], Vec::as_slice);
        same.iter().copied().filter(move |&other| other != lane)
    }

    /// Lanes that have this way as a bound.
    pub fn users_of(&self, way: LineStringId) -> &[usize] {
        self.way_users.get(&way).map_or(&[], Vec::as_slice)
    }

    /// Lanelets that refer to this element.
    pub fn referrers(&self, element: RegulatoryElementId) -> &[LaneletId] {
        self.referrers.get(&element).map_or(&[], Vec::as_slice)
    }

    /// Elements of which this lanelet is a member, in the map's order.
    pub fn elements_naming(&self, lanelet: LaneletId) -> impl Iterator<Item = &'m RegulatoryElement> + '_ {
        let naming = self.naming.get_or_init(|| {
            let mut naming: FxHashMap<LaneletId, Vec<RegulatoryElementId>> = FxHashMap::default();
            for element in &self.map.regulatory_elements {
                for member in &element.members {
                    if let Target::Lanelet(id) = member.target {
                        naming.entry(id).or_default().push(element.id);
                    }
                }
            }
            naming.values_mut().for_each(Vec::dedup);
            naming
        });
        let elements = naming.get(&lanelet).into_iter().flatten();
        elements.filter_map(|id| self.map.regulatory_elements.get(*id))
    }

    /// Intersections that a lane is part of, by position: more than one where areas overlap.
    pub fn intersections_of(&self, lane: usize) -> &[usize] {
        &self.intersections_of[lane]
    }

    /// Lanes whose rectangle meets the one between two corners, by position.
    pub fn lanes_near(&self, low: Point, high: Point) -> Vec<usize> {
        let reach = rstar::AABB::from_corners([low.x, low.y], [high.x, high.y]);
        let mut found: Vec<usize> = self.tree.locate_in_envelope_intersecting(&reach).map(|one| one.data).collect();
        found.sort_unstable();
        found
    }
}

/// Another lanelet whose outline overlaps that of this one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conflict {
    /// The other, by its position in `MapIndex::lanes`.
    pub other: usize,
    /// Area of the overlap, square metres.
    pub area: f64,
    /// Middle of the overlap.
    pub place: Point,
    /// Whether it is large enough for the rules, and on one level. Autoware checks neither and always reacts.
    pub real: bool,
    /// Whether one passes over the other.
    pub grade_separated: bool,
}

/// A lanelet that is part of an intersection: one movement from one approach to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IntersectionMember {
    /// By its position in `MapIndex::lanes`.
    pub lane: usize,
    /// Whether its tag `intersection_area` names the area.
    pub declared: bool,
    /// Share of its area inside the intersection area, 0..=1; 1 where the intersection has none.
    pub cover: f64,
}

impl IntersectionMember {
    /// Whether the greater part of it lies inside; one that only names the area was tagged by mistake.
    pub fn is_inside(&self) -> bool {
        self.cover > 0.5
    }
}

/// One crossing or junction.
#[derive(Clone, Debug)]
pub struct Intersection {
    /// Its `intersection_area`; `None` where lanelets with `turn_direction` conflict outside every area.
    pub area: Option<PolygonId>,
    /// The outline of the area, as the file has it, without a repeated last point; empty if there is no area.
    pub ring: Vec<Point>,
    /// Middle of the area, or of its lanelets.
    pub middle: Point,
    /// Mean height of the area's points, metres.
    pub height: f64,
    /// Its lanelets, by their position.
    pub members: Vec<IntersectionMember>,
    /// Other lanelets that its area touches, with the share of their area inside, by their position.
    pub touched: Vec<(usize, f64)>,
    /// Its approaches, clockwise from north as seen from the middle.
    pub arms: Vec<Arm>,
}

/// One road leg of an intersection.
#[derive(Clone, Debug)]
pub struct Arm {
    /// Where lanelets of the intersection start or end.
    pub edges: Vec<ArmEdge>,
    /// Mean heading of the lanelets that start here; `None` if none does.
    pub heading_in: Option<Vector>,
    /// The side of the intersection from which it comes: `N`, `NE`, ...
    pub compass: &'static str,
    /// The same in degrees, clockwise from north.
    pub bearing: f64,
    /// The approach opposite, by its position in `Intersection::arms`.
    pub opposite: Option<usize>,
}

/// One lane of an approach at the intersection's border.
#[derive(Clone, Debug)]
pub struct ArmEdge {
    /// The border, left and right in the direction of travel.
    pub edge: Edge,
    /// Whether lanelets of the intersection start here; else they end here.
    pub inward: bool,
    /// Those lanelets, by their position in `MapIndex::lanes`.
    pub lanes: Vec<usize>,
}

impl Intersection {
    /// Whether its area is a simple polygon.
    pub fn is_simple(&self) -> bool {
        simple_ring::is_simple(&self.ring)
    }

    /// Whether its area holds a place; its border is part of it.
    pub fn holds(&self, place: Point) -> bool {
        let on_border = || {
            let border = Polyline::new(self.ring.iter().chain(self.ring.first()).copied());
            border.is_some_and(|border| border.distance(place) <= ON_BORDER)
        };
        polygon::contains(&self.ring, place) || on_border()
    }
}

/// The side of the road on which people drive.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DrivingSide {
    /// As in Japan: the near turn is the left turn.
    Left,
    /// As in Germany: the near turn is the right turn.
    Right,
}

impl DrivingSide {
    /// The turn across oncoming traffic.
    pub fn far_turn(self) -> TurnDirection {
        match self {
            Self::Left => TurnDirection::Right,
            Self::Right => TurnDirection::Left,
        }
    }

    /// The turn toward the own kerb.
    pub fn near_turn(self) -> TurnDirection {
        match self {
            Self::Left => TurnDirection::Left,
            Self::Right => TurnDirection::Right,
        }
    }
}

/// The driving side that places of the map show, and the one that is assumed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SideVotes {
    /// Places that show driving on the left.
    pub left: usize,
    /// Places that show driving on the right.
    pub right: usize,
    /// The assumed side: the user's setting, else the majority; `None` where nothing shows it.
    pub side: Option<DrivingSide>,
    /// What each place shows.
    pub places: Vec<SideVote>,
}

/// The side on which people drive at one place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SideVote {
    /// A lanelet at that place.
    pub lane: LaneletId,
    /// The side that it shows.
    pub side: DrivingSide,
    /// Whether both directions are on one road; two one-way roads beside each other show the side less surely.
    pub on_one_road: bool,
}

impl SideVotes {
    pub(super) fn add(&mut self, vote: SideVote) {
        match vote.side {
            DrivingSide::Left => self.left += 1,
            DrivingSide::Right => self.right += 1,
        }
        self.places.push(vote);
    }
}

/// One lanelet of an intersection, from approach to approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Movement {
    /// The lanelet, by its position in `MapIndex::lanes`.
    pub lane: usize,
    /// Where it starts, by its position in `Intersection::arms`.
    pub from: usize,
    /// Where it ends.
    pub to: usize,
    /// What decides who may go.
    pub ranked: RankedMovement,
}

/// How much is known about priority where there is no signal.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Rank {
    /// Some approaches have priority.
    Known,
    /// Every approach has to stop.
    Equal,
    /// Nothing shows it; equal priority is assumed.
    #[default]
    Unknown,
}

/// The traffic of one intersection.
#[derive(Clone, Debug, Default)]
pub struct Traffic {
    /// Its lanelets with the approaches that they join, by lane.
    pub movements: Vec<Movement>,
    /// Whether a signal rules at least one of them.
    pub signalised: bool,
    /// Who goes first.
    pub rank: Rank,
    /// Approaches between which there must be no movement, by their positions.
    pub prohibited: Vec<[usize; 2]>,
    /// Ways that are guide lines, by the user's word.
    pub guide_lines: Vec<LineStringId>,
    /// Whether two approaches are green together, row by row.
    pub(super) together: Vec<Vec<bool>>,
    /// For every movement the user's phases in which it is green; empty where the user says nothing of it.
    pub(super) phases: Vec<Vec<usize>>,
}

impl Traffic {
    /// The movement of a lane, by its position in `movements`.
    pub fn of_lane(&self, lane: usize) -> Option<usize> {
        self.movements.binary_search_by_key(&lane, |movement| movement.lane).ok()
    }

    /// Whether the user says in which phases a movement is green.
    pub fn has_phase(&self, x: usize) -> bool {
        !self.phases[x].is_empty()
    }

    /// How the signals of two movements change: as the user's phases say, else by their approaches. Where no signal
    /// rules: whether they come from the same, from opposite or from crossing approaches.
    pub fn relation(&self, x: usize, y: usize) -> Relation {
        let (a, b) = (self.movements[x].from, self.movements[y].from);
        let [mine, theirs] = [&self.phases[x], &self.phases[y]];
        if !mine.is_empty() && !theirs.is_empty() && !mine.iter().any(|phase| theirs.contains(phase)) {
            return Relation::AntiPhase;
        }
        let declared = !mine.is_empty() && !theirs.is_empty();
        match a == b {
            true => Relation::Same,
            false if declared || self.together[a][b] => Relation::InPhase,
            false => Relation::AntiPhase,
        }
    }

    /// The movements that really conflict with `x`; both by position.
    pub fn met(&self, map: &MapIndex, x: usize) -> Vec<usize> {
        let conflicts = map.conflicts[self.movements[x].lane].iter();
        // Autoware looks only at lanes that vehicles may drive on.
        let real = conflicts.filter(|conflict| conflict.real && map.lanes[conflict.other].vehicle);
        real.filter_map(|conflict| self.of_lane(conflict.other)).collect()
    }

    /// The movements that conflict with `x` and that it may ignore.
    pub fn yields(&self, map: &MapIndex, x: usize) -> Vec<usize> {
        let ranked: Vec<RankedMovement> = self.movements.iter().map(|movement| movement.ranked).collect();
        yields(x, &ranked, &self.met(map, x), |x, y| self.relation(x, y))
    }
}
