//! The lanelets of an intersection: one per movement, smooth, with bounds that neighbours share.

mod bounds;

pub use bounds::SharedBounds;

use std::borrow::Cow;
use std::cell::RefCell;

use crate::builder::ids::Key;
use crate::builder::lanes::lanelet_validity::is_valid;
use crate::builder::lanes::road_lanes::{ADMITS_BICYCLES, road_attributes};
use crate::builder::lanes::types::{Arm, ArmLane, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::turn::turned;
use crate::builder::network::{Intersection, RoadNetwork};
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::fillet::Rounding;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, Vector, angle_between, curve};
use crate::lanelet::index::{HEADING_REACH, center_line};
use crate::lanelet::{Attributes, Bound, LaneletId, LineStringId};

use super::movement_types::Movement;
use super::roundabout::CirculatingRing;
use super::shared_bounds::{PreferredBounds, Smooth, keep_width, smooth};
use super::turn_centerline::{MovementEnds, turn_centerlines};
use bounds::Line;

/// One movement, drawn.
#[derive(Clone, Debug)]
pub struct TurningLanelet {
    /// From where to where.
    pub movement: Movement,
    /// Its lanelet.
    pub lanelet: LaneletId,
    /// Change of direction in degrees, left positive.
    pub turn: f64,
    /// Left bound, then the right bound backwards; empty when nothing is drawn around it any more.
    pub outline: Vec<Point>,
    /// Its bounds, left and right.
    pub bounds: [LineStringId; 2],
    /// Where it heads over its first metres, as Autoware sees it.
    pub heading: Vector,
    /// For all motor vehicles, for buses only, or for bicycles.
    pub kind: StripKind,
}

impl TurningLanelet {
    /// Lets go what only the drawing asks for: where the points lie stands in the map.
    pub fn drop_outline(&mut self) {
        self.outline = Vec::new();
    }
}

/// How tightly a bound may bend, and how much wider a lane may become where it turns.
const BENDS: Rounding = Rounding { min_radius: 1.25, easy_radius: 2.0, max_shift: 0.6 };

/// Bytes that the tags take which only a way through an intersection has.
const TURN_TAGS: usize = 64;

/// How the bounds of paths are tagged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntersectionPaint {
    /// `virtual`: nothing is painted across an intersection.
    None,
    /// As the bounds of the lane that leads in: the road merely goes on.
    AsBefore,
}

/// How the bounds of the paths of an intersection are tagged.
pub fn paint(intersection: &Intersection) -> IntersectionPaint {
    if intersection.arms.len() == 2 { IntersectionPaint::AsBefore } else { IntersectionPaint::None }
}

/// What [`paths`] made.
#[derive(Clone, Debug, Default)]
pub struct DrawnMovements {
    /// Sorted by movement.
    pub paths: Vec<TurningLanelet>,
    /// The lines they share.
    pub bounds: SharedBounds,
    /// Movements for which there is no room: their lanes end too close together or side by side.
    pub dropped: Vec<Movement>,
}

/// Draws the movements of one intersection, the tightest turns first: where two share a bound, the tighter one needs it
/// exact.
pub fn turning_lanelets(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lanes: &Lanes,
    intersection: &Intersection,
    movements: &[Movement],
) -> DrawnMovements {
    let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
    let key = intersection_key("path", intersection);
    let ends = |m: &Movement| Some((arms.get(m.from)?.into.get(m.in_lane)?, arms.get(m.to)?.out.get(m.out_lane)?));
    let all: Vec<MovementEnds> = movements.iter().filter_map(|m| ends(m).map(|(from, to)| (*m, from, to))).collect();
    let ring = CirculatingRing::of(intersection);
    let mut all: Vec<(MovementEnds, Vec<Pose>)> = all.iter().copied().zip(turn_centerlines(&all)).collect();
    for ((movement, from, to), course) in &mut all {
        let roads = [movement.from, movement.to].map(|arm| network.road(arms[arm].at.road).place(arms[arm].at.end));
        let around = ring.as_ref().and_then(|ring| ring.around(roads, [from.pose, to.pose], course));
        *course = around.unwrap_or_else(|| std::mem::take(course));
    }
    let mut drawn = DrawnMovements::default();
    let attributes_from = |assembly: &MapBuilder, arm: usize, lane: usize, kind| {
        let road = network.road(arms[arm].at.road);
        let before = assembly.lanelet_of(lanes.lanes[lane].lanelet).map(|lanelet| &lanelet.attributes);
        let speed = before.and_then(|before| before.get("speed_limit")?.parse().ok()).unwrap_or(road.speed[0]);
        let mut attributes = road_attributes(road, kind, speed);
        if kind == StripKind::Bus && before.is_some_and(|before| before.is(ADMITS_BICYCLES, "yes")) {
            attributes.push(ADMITS_BICYCLES, "yes");
        }
        attributes
    };
    // All ways of one kind from a lane are tagged alike.
    let known: RefCell<Vec<(usize, StripKind, Attributes)>> = RefCell::default();
    let lanelet = |assembly: &MapBuilder, (movement, from, _): &MovementEnds, kind| {
        let mut known = known.borrow_mut();
        let at = known.iter().position(|one| (one.0, one.1) == (from.lane, kind)).unwrap_or_else(|| {
            known.push((from.lane, kind, attributes_from(assembly, movement.from, from.lane, kind)));
            known.len() - 1
        });
        known[at].2.with_more_room(TURN_TAGS)
    };
    let paint = paint(intersection);
    let bound = |assembly: &MapBuilder, from: &ArmLane, side| bound_attributes(assembly, lanes, from, side, paint);
    drawn.add(assembly, network.side, key, all, &LaneletTags { bound: &bound, lanelet: &lanelet });
    drawn
}

/// How what is drawn is tagged.
pub struct LaneletTags<'a> {
    /// Tags of a bound, from the lane that leads in and its side: 0 left, 1 right.
    pub bound: &'a dyn Fn(&MapBuilder, &ArmLane, usize) -> Attributes,
    /// Tags of a lanelet.
    pub lanelet: &'a dyn Fn(&MapBuilder, &MovementEnds, StripKind) -> Attributes,
}

impl DrawnMovements {
    /// Lets go what only the drawing asks for: it takes more memory than the ways.
    pub fn done(&mut self) {
        self.bounds = SharedBounds::default();
        self.paths.iter_mut().for_each(TurningLanelet::drop_outline);
        self.paths.shrink_to_fit();
    }

    /// Draws ways, each with its middle, beside those that are there, with which they share bounds.
    pub fn add(
        &mut self,
        assembly: &mut MapBuilder,
        side: DrivingSide,
        key: Key,
        order: Vec<(MovementEnds, Vec<Pose>)>,
        tagged: &LaneletTags,
    ) {
        let Self { paths, bounds, dropped } = self;
        let radius = |(_, from, to): &MovementEnds| curve::join_radius(from.pose, to.pose).unwrap_or(f64::INFINITY);
        let mut order: Vec<_> = order.into_iter().map(|(ends, course)| (radius(&ends), ends, course)).collect();
        order.sort_by(|(a, one, _), (b, other, _)| a.total_cmp(b).then(one.0.cmp(&other.0)));
        let ways: Vec<Smooth> = order.into_iter().map(|(_, ends, course)| (ends, smooth(&ends, &course))).collect();
        let meant = PreferredBounds::new(&ways);
        // Most bounds are drawn once for two ways.
        assembly.reserve(ways.iter().flat_map(|(_, sides)| sides).map(Vec::len).sum::<usize>() * 2 / 3);
        bounds.reserve(2 * ways.len() * 2 / 3);
        paths.reserve(ways.len());
        for way in &ways {
            let (movement, from, to) = way.0;
            let nodes = [0, 1].map(|side| [from.nodes[side], to.nodes[side]]);
            if nodes.iter().any(|[a, b]| a == b) {
                continue;
            }
            let straight = [0, 1].map(|side| [from.places[side], to.places[side]]);
            let known = nodes.map(|[a, b]| bounds.line(a, b));
            let Some([left, right]) = shape(way, &straight, known, &meant) else {
                dropped.push(movement);
                continue;
            };
            let mut draw = |i: usize, side: Side| {
                let mut places = match side {
                    Side::Shared(bound) => return bound,
                    Side::Own(places) => bounds.beside_others(nodes[i], places),
                };
                // The curve ends at the nodes but for rounding; the nodes are the truth.
                if let [first, .., last] = &mut places[..] {
                    [*first, *last] = straight[i];
                }
                let attributes = (tagged.bound)(assembly, from, i);
                bounds.draw(assembly, key, nodes[i], &places, attributes)
            };
            let [left, right] = [draw(0, left), draw(1, right)];
            let kind = if from.kind == to.kind { from.kind } else { StripKind::Bus };
            let attributes = (tagged.lanelet)(assembly, &way.0, kind);
            let lanelet = assembly.lanelet(path_key(key, from, to), left, right, attributes);
            // As whoever reads the map sees it, not as it was meant: what bounds are shared moves the middle.
            let [left_line, right_line] = nodes.map(|[a, b]| bounds.line(a, b).map(|line| line.places(a)));
            let (Some(left_line), Some(right_line)) = (left_line, right_line) else { continue };
            let center = center_line(&left_line, &right_line);
            paths.push(TurningLanelet {
                movement,
                lanelet,
                bounds: [left.line, right.line],
                heading: center.as_ref().and_then(heading).unwrap_or(from.pose.heading),
                turn: center.map_or(0.0, |center| turned(side, &center)),
                outline: left_line.iter().chain(right_line.iter().rev()).copied().collect(),
                kind,
            });
        }
        paths.sort_by_key(|p| p.movement);
        dropped.sort_unstable();
    }
}

/// Where a lanelet heads over its first metres.
fn heading(center: &Polyline) -> Option<Vector> {
    (center.at(HEADING_REACH) - center.first()).try_normalize(f64::EPSILON)
}

/// One side of a way.
enum Side {
    /// A bound that another way has drawn.
    Shared(Bound),
    /// Places of a bound of its own.
    Own(Vec<Point>),
}

/// Whether a way takes the bounds that others have drawn between the same nodes.
#[derive(Clone, Copy, PartialEq)]
enum Share {
    /// Where it keeps its width between them.
    Evenly,
    /// Wherever it fits between them.
    Anyhow,
    Not,
}

/// Both sides of a lane between two ends; `None` if there is no room for one. `straight` joins the nodes at these on either
/// side, `known` are lines between the same nodes.
fn shape(
    ((_, from, to), smooth): &Smooth,
    straight: &[[Point; 2]; 2],
    known: [Option<&Line>; 2],
    meant: &PreferredBounds,
) -> Option<[Side; 2]> {
    let sides = [0, 1];
    let meant = sides.map(|side| meant.get(from.nodes[side], to.nodes[side]).map(|line| curve::untangled(&line)));
    let smooth = smooth.each_ref().map(Vec::as_slice);
    let midway = sides.map(|side| meant[side].as_deref().unwrap_or(smooth[side]));
    let straight = straight.each_ref().map(|line| &line[..]);
    // Where the turn is tighter than half the lane, its inner bound is a straight line.
    let left_turn = angle_between(from.pose.heading, to.pose.heading) > 0.0;
    let tight = if left_turn { [straight[0], smooth[1]] } else { [smooth[0], straight[1]] };
    let old = sides.map(|side| known[side].map(|line| line.places(from.nodes[side])));
    let known = sides.map(|side| known[side].map(|line| line.bound(from.nodes[side])));
    let (width, narrow) = ([from.width, to.width], from.width.min(to.width));
    // Rather a bound of its own than one shared that squeezes it, and rather that than a corner.
    let shapes = [
        (midway, Share::Evenly),
        (smooth, Share::Evenly),
        (smooth, Share::Not),
        (midway, Share::Anyhow),
        (smooth, Share::Anyhow),
        (tight, Share::Anyhow),
        (tight, Share::Not),
        (straight, Share::Not),
    ];
    let mut unsound: Vec<[&[Point]; 2]> = Vec::new();
    for (shape, share) in shapes {
        let known = if share == Share::Not { [None, None] } else { known };
        let lines = sides.map(|side| old[side].as_deref().filter(|_| known[side].is_some()).unwrap_or(shape[side]));
        // Where nothing is shared, several come to the same.
        if unsound.contains(&lines) {
            continue;
        }
        if !is_valid(&lines, narrow) {
            unsound.push(lines);
            continue;
        }
        // Ways side by side share whatever comes: they must not overlap.
        let with_opposite = known.iter().flatten().any(|bound| bound.inverted);
        if share != Share::Evenly || !with_opposite || keep_width(lines, width) {
            let round =
                |side: usize| if known[side].is_some() { Cow::Borrowed(lines[side]) } else { BENDS.of(lines[side]) };
            let round = sides.map(round);
            let rounded = round.iter().any(|line| matches!(line, Cow::Owned(_)));
            let serves = !rounded || is_valid(&round, narrow);
            let lines = if serves { round } else { lines.map(Cow::Borrowed) };
            let [left, right] = lines;
            let side = |known: Option<Bound>, line: Cow<[Point]>| {
                known.map_or_else(|| Side::Own(line.into_owned()), Side::Shared)
            };
            return Some([side(known[0], left), side(known[1], right)]);
        }
    }
    None
}

/// The key of an intersection.
pub fn intersection_key(part: &str, intersection: &Intersection) -> Key {
    intersection.nodes.iter().fold(Key::new(part), |key, &node| key.number(node))
}

fn path_key(key: Key, from: &ArmLane, to: &ArmLane) -> Key {
    [from.nodes[0], from.nodes[1], to.nodes[0], to.nodes[1]].into_iter().fold(key, |key, node| key.number(node.0))
}

fn bound_attributes(
    assembly: &MapBuilder,
    lanes: &Lanes,
    from: &ArmLane,
    side: usize,
    paint: IntersectionPaint,
) -> Attributes {
    match paint {
        IntersectionPaint::None => Attributes::of(&[("type", "virtual")]),
        IntersectionPaint::AsBefore => {
            let lane = &lanes.lanes[from.lane];
            let bound = [lane.left, lane.right][side];
            assembly.line_of(bound.line).map(|l| l.attributes.clone()).unwrap_or_default()
        }
    }
}
