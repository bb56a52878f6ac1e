//! Turning lanelets: one for each movement of an intersection, smooth, with bounds that neighbours share.

mod bounds;

pub use bounds::SharedBounds;

use std::borrow::Cow;
use std::cell::RefCell;

use crate::builder::ids::Key;
use crate::builder::lanes::lanelet_validity::is_valid;
use crate::builder::lanes::road_lanes::{ADMITS_BICYCLES, road_attributes};
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::turn_angle::turned;
use crate::builder::network::{Intersection, RoadNetwork};
use crate::builder::tags::cross_section::StripKind;
use crate::builder::tags::marking::unpainted;
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::fillet::Rounding;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Polyline, Vector, angle_between, curve};
use crate::lanelet::index::{HEADING_REACH, center_line, tangent};
use crate::lanelet::{Attributes, Bound, LaneletId, LineStringId};

use super::movement::along_streets;
use super::movement_types::Movement;
use super::roundabout::CirculatingRing;
use super::shared_bounds::{PreferredBounds, SmoothBounds, keep_width, smooth_bounds};
use super::street_path::StreetPaths;
use super::turn_centerline::{MovementEnds, turn_centerlines};
use bounds::BoundLine;

/// The lanelet of a movement.
#[derive(Clone, Debug)]
pub struct TurningLanelet {
    /// The lanes that it joins.
    pub movement: Movement,
    /// Its lanelet.
    pub lanelet: LaneletId,
    /// Change of direction, degrees, left positive.
    pub turn: f64,
    /// Left bound, then the right bound backwards; empty once the intersection is drawn.
    pub outline: Vec<Point>,
    /// Its bounds, left and right.
    pub bounds: [LineStringId; 2],
    /// Unit direction over its first metres, as Autoware determines it.
    pub heading: Vector,
    /// The larger jump of direction between it and the lanes that it joins, degrees.
    pub corner: f64,
    /// The smallest radius of its middle, metres.
    pub radius: f64,
    /// By how much more than half as much again it bends in sum than it turns, degrees: a lanelet that bends one way and back wiggles.
    pub sway: f64,
    /// For all motor vehicles, for buses only, or for bicycles.
    pub kind: StripKind,
}

impl TurningLanelet {
    /// Frees the outline; the map has the places of its points.
    pub fn drop_outline(&mut self) {
        self.outline = Vec::new();
    }
}

/// How tightly a bound may bend, and how much wider a turning lane may become, metres.
const BENDS: Rounding = Rounding { min_radius: 1.25, easy_radius: 2.0, max_shift: 0.6 };

/// Steps in which the bends of a lanelet's middle are measured, metres.
const BEND_STEP: f64 = 2.0;

/// Bytes of the tags that only turning lanelets have.
const TURN_TAGS: usize = 64;

/// How the bounds of turning lanelets are tagged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum IntersectionPaint {
    /// `virtual`: nothing is painted across an intersection.
    None,
    /// As the bounds of the lane that leads in: only one road goes on.
    AsBefore,
}

/// How the bounds in an intersection are tagged.
pub fn paint(intersection: &Intersection) -> IntersectionPaint {
    if intersection.arms.len() == 2 { IntersectionPaint::AsBefore } else { IntersectionPaint::None }
}

/// The turning lanelets of an intersection.
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
    let ends = |m: &Movement| Some((*m, arms.get(m.from)?.into.get(m.in_lane)?, arms.get(m.to)?.out.get(m.out_lane)?));
    let ends: Vec<MovementEnds> = movements.iter().filter_map(ends).collect();
    let (ring, paths) = (CirculatingRing::of(intersection), StreetPaths { network, intersection });
    let around = |ends: &MovementEnds, direct: &[Pose]| {
        let (movement, from, to) = ends;
        let roads = [movement.from, movement.to].map(|arm| network.road(arms[arm].at.road).place(arms[arm].at.end));
        let island = ring.as_ref().and_then(|ring| ring.around(roads, [from.pose, to.pose], direct));
        island.or_else(|| along_streets(paths, &arms, ends, direct))
    };
    let centerlines = ends.iter().copied().zip(turn_centerlines(&ends, around));
    let tags = VehicleTags { network, lanes, arms: &arms, paint: paint(intersection), known: RefCell::default() };
    let mut drawn = DrawnMovements::default();
    drawn.add(assembly, network.side, intersection_key("path", intersection), centerlines.collect(), &tags);
    drawn
}

/// The tags of the turning lanelets of an intersection.
pub trait TurningTags {
    /// Tags of a bound of a movement, by its side: 0 left, 1 right.
    fn bound(&self, assembly: &MapBuilder, ends: &MovementEnds, side: usize) -> Attributes;

    /// Tags of a lanelet.
    fn lanelet(&self, assembly: &MapBuilder, ends: &MovementEnds, kind: StripKind) -> Attributes;
}

/// The tags of turning lanelets for vehicles.
struct VehicleTags<'a> {
    network: &'a RoadNetwork,
    lanes: &'a Lanes,
    arms: &'a [&'a Arm],
    paint: IntersectionPaint,
    /// By lane and kind: all lanelets of one kind from a lane are tagged alike.
    known: RefCell<Vec<((usize, StripKind), Attributes)>>,
}

impl VehicleTags<'_> {
    fn attributes(&self, assembly: &MapBuilder, (movement, from, _): &MovementEnds, kind: StripKind) -> Attributes {
        let road = self.network.road(self.arms[movement.from].at.road);
        let before = assembly.lanelet_of(self.lanes.lanes[from.lane].lanelet).map(|lanelet| &lanelet.attributes);
        let speed = before.and_then(|before| before.get("speed_limit")?.parse().ok()).unwrap_or(road.speed[0]);
        let mut attributes = road_attributes(road, kind, speed);
        if kind == StripKind::Bus && before.is_some_and(|before| before.is(ADMITS_BICYCLES, "yes")) {
            attributes.push(ADMITS_BICYCLES, "yes");
        }
        attributes
    }
}

impl TurningTags for VehicleTags<'_> {
    fn bound(&self, assembly: &MapBuilder, (movement, from, _): &MovementEnds, side: usize) -> Attributes {
        if self.paint == IntersectionPaint::None {
            return unpainted();
        }
        let lane = &self.lanes.lanes[from.lane];
        let before = assembly.line_of([lane.left, lane.right][side].line).map(|line| line.attributes.clone());
        let outermost = [0, self.arms[movement.to].out.len() - 1][side];
        // Where one lane becomes several, only the outer ones go on along its border.
        before.filter(|it| movement.out_lane == outermost || !it.is("type", "road_border")).unwrap_or_else(unpainted)
    }

    fn lanelet(&self, assembly: &MapBuilder, ends: &MovementEnds, kind: StripKind) -> Attributes {
        let mut known = self.known.borrow_mut();
        let key = (ends.1.lane, kind);
        let i = known.iter().position(|(other, _)| *other == key).unwrap_or_else(|| {
            known.push((key, self.attributes(assembly, ends, kind)));
            known.len() - 1
        });
        known[i].1.with_more_room(TURN_TAGS)
    }
}

impl DrawnMovements {
    /// Frees what only drawing needs; it takes more memory than the lanelets.
    pub fn drop_outlines(&mut self) {
        self.bounds = SharedBounds::default();
        self.paths.iter_mut().for_each(TurningLanelet::drop_outline);
        self.paths.shrink_to_fit();
    }

    /// Draws movements along their centre lines, beside those that are drawn, with which they share bounds.
    pub fn add(
        &mut self,
        assembly: &mut MapBuilder,
        side: DrivingSide,
        key: Key,
        centerlines: Vec<(MovementEnds, Vec<Pose>)>,
        tags: &dyn TurningTags,
    ) {
        let radius = |(_, from, to): &MovementEnds| curve::join_radius(from.pose, to.pose).unwrap_or(f64::INFINITY);
        let mut order: Vec<_> = centerlines.into_iter().map(|(ends, poses)| (radius(&ends), ends, poses)).collect();
        order.sort_by(|(a, one, _), (b, other, _)| a.total_cmp(b).then(one.0.cmp(&other.0)));
        let smooth: Vec<SmoothBounds> =
            order.into_iter().map(|(_, ends, poses)| (ends, smooth_bounds(&ends, &poses))).collect();
        let preferred = PreferredBounds::new(&smooth);
        // Most bounds belong to two lanelets.
        assembly.reserve(smooth.iter().flat_map(|(_, sides)| sides).map(Vec::len).sum::<usize>() * 2 / 3);
        self.bounds.reserve(2 * smooth.len() * 2 / 3);
        self.paths.reserve(smooth.len());
        for ((_, from, to), _) in &smooth {
            (0..2).for_each(|side| self.bounds.plan([from.nodes[side], to.nodes[side]], side));
        }
        for one in &smooth {
            let (movement, from, to) = one.0;
            if (0..2).any(|side| from.nodes[side] == to.nodes[side]) {
                continue;
            }
            match self.draw_bounds(assembly, key, one, &preferred, tags) {
                Some(bounds) => self.paths.extend(self.lanelet(assembly, side, key, &one.0, bounds, tags)),
                None => self.dropped.push(movement),
            }
        }
        self.paths.sort_by_key(|p| p.movement);
        self.dropped.sort_unstable();
    }

    /// Draws the bounds of a movement, left and right; `None` if there is no room for it.
    fn draw_bounds(
        &mut self,
        assembly: &mut MapBuilder,
        key: Key,
        smooth: &SmoothBounds,
        preferred: &PreferredBounds,
        tags: &dyn TurningTags,
    ) -> Option<[Bound; 2]> {
        let (_, from, to) = smooth.0;
        let nodes = [0, 1].map(|side| [from.nodes[side], to.nodes[side]]);
        let known = nodes.map(|[a, b]| self.bounds.line(a, b));
        let sides = movement_sides(smooth, known, preferred)?;
        let mut i = 0..;
        Some(sides.map(|side| {
            let i = i.next().unwrap_or_default();
            let mut places = match side {
                Side::Shared(bound) => return bound,
                Side::Own(places) => self.bounds.beside_others(nodes[i], places),
            };
            // The curve ends at the nodes but for rounding; the nodes are exact.
            if let [first, .., last] = &mut places[..] {
                [*first, *last] = [from.places[i], to.places[i]];
            }
            self.bounds.draw(assembly, key, nodes[i], &places, tags.bound(assembly, &smooth.0, i))
        }))
    }

    /// Adds the lanelet of a movement between its bounds. Its turn and heading are those of the lanelet as it is read, not of
    /// the centre line for which it was drawn: shared bounds move its middle.
    fn lanelet(
        &self,
        assembly: &mut MapBuilder,
        side: DrivingSide,
        key: Key,
        ends: &MovementEnds,
        [left, right]: [Bound; 2],
        tags: &dyn TurningTags,
    ) -> Option<TurningLanelet> {
        let (movement, from, to) = *ends;
        let kind = if from.kind == to.kind { from.kind } else { StripKind::Bus };
        let key = from.nodes.into_iter().chain(to.nodes).fold(key, |key, node| key.number(node.0));
        let lanelet = assembly.lanelet(key, left, right, tags.lanelet(assembly, ends, kind));
        let places = |side: usize| Some(self.bounds.line(from.nodes[side], to.nodes[side])?.places(from.nodes[side]));
        let (left_line, right_line) = (places(0)?, places(1)?);
        let center = center_line(&left_line, &right_line);
        let bend = center.as_ref().and_then(|center| curve::tightest_bend(center, BEND_STEP));
        Some(TurningLanelet {
            movement,
            lanelet,
            bounds: [left.line, right.line],
            heading: center.as_ref().and_then(heading).unwrap_or(from.pose.heading),
            corner: center.as_ref().map_or(0.0, |center| corner([from.pose.heading, to.pose.heading], center)),
            radius: bend.map_or(f64::INFINITY, |(radius, _)| radius),
            sway: center.as_ref().map_or(0.0, sway),
            turn: center.map_or(0.0, |center| turned(side, &center)),
            outline: left_line.iter().chain(right_line.iter().rev()).copied().collect(),
            kind,
        })
    }
}

/// Unit direction of a lanelet over its first metres.
fn heading(center: &Polyline) -> Option<Vector> {
    (center.at(HEADING_REACH) - center.first()).try_normalize(f64::EPSILON)
}

/// See [`TurningLanelet::sway`].
fn sway(center: &Polyline) -> f64 {
    let line = center.resampled(BEND_STEP / 2.0);
    let headings: Vec<Vector> = line.points().windows(2).map(|pair| pair[1] - pair[0]).collect();
    let bends: Vec<f64> = headings.windows(2).map(|pair| angle_between(pair[0], pair[1]).to_degrees()).collect();
    bends.iter().map(|bend| bend.abs()).sum::<f64>() - 1.5 * bends.iter().sum::<f64>().abs()
}

/// The larger jump of direction where a lanelet begins and ends between lanes of these headings, degrees. An arc that begins at a
/// lane is no jump, though its first metres point elsewhere.
fn corner([into, out]: [Vector; 2], center: &Polyline) -> f64 {
    let jump = |lane: Vector, line: &Polyline| {
        let ahead = [heading(line), tangent(line)].into_iter().flatten();
        ahead.map(|ahead| angle_between(lane, ahead).abs().to_degrees()).fold(f64::INFINITY, f64::min)
    };
    let jumps = [jump(into, center), jump(-out, &center.reversed())];
    jumps.into_iter().filter(|jump| jump.is_finite()).fold(0.0, f64::max)
}

/// One side of a turning lanelet.
enum Side {
    /// The bound of another lanelet.
    Shared(Bound),
    /// The places of a bound of its own.
    Own(Vec<Point>),
}

/// Whether a lanelet takes over the bounds of others between the same nodes.
#[derive(Clone, Copy, PartialEq)]
enum Share {
    /// If it keeps its width between them.
    Evenly,
    /// Those of others that lead the same way, if it keeps its width.
    Along,
    /// If it is valid between them.
    Anyhow,
    Not,
}

/// Both sides of a movement; `None` if there is no room for it. `known` are lines between the same nodes.
fn movement_sides(
    ((_, from, to), smooth): &SmoothBounds,
    known: [Option<&BoundLine>; 2],
    preferred: &PreferredBounds,
) -> Option<[Side; 2]> {
    let sides = [0, 1];
    let preferred =
        sides.map(|side| preferred.get(from.nodes[side], to.nodes[side]).map(|line| curve::untangled(&line)));
    let smooth = smooth.each_ref().map(Vec::as_slice);
    let midway = sides.map(|side| preferred[side].as_deref().unwrap_or(smooth[side]));
    let chords = sides.map(|side| [from.places[side], to.places[side]]);
    let straight = chords.each_ref().map(|line| &line[..]);
    // Where the turn is tighter than half the lane, its inner bound is a straight line.
    let left_turn = angle_between(from.pose.heading, to.pose.heading) > 0.0;
    let tight = if left_turn { [straight[0], smooth[1]] } else { [smooth[0], straight[1]] };
    let drawn = sides.map(|side| known[side].map(|line| line.places(from.nodes[side])));
    let known = sides.map(|side| known[side].map(|line| line.bound(from.nodes[side])));
    let (widths, narrow) = ([from.width, to.width], from.width.min(to.width));
    // Opposite lanelets side by side share their bound even where it squeezes them: they must not overlap.
    let with_opposite = known.iter().flatten().any(|bound| bound.inverted);
    // Bounds of its own are better than shared ones that squeeze it, and those better than a corner.
    let shapes = [
        (midway, Share::Evenly),
        (smooth, Share::Evenly),
        (midway, Share::Along),
        (smooth, Share::Along),
        (smooth, Share::Not),
        (midway, Share::Anyhow),
        (smooth, Share::Anyhow),
        (tight, Share::Anyhow),
        (tight, Share::Not),
        (straight, Share::Not),
    ];
    let mut invalid: Vec<[&[Point]; 2]> = Vec::new();
    for (shape, share) in shapes {
        let may = |bound: &Bound| match share {
            Share::Evenly | Share::Anyhow => true,
            Share::Along => !bound.inverted,
            Share::Not => false,
        };
        let known = known.map(|bound| bound.filter(may));
        let lines = sides.map(|side| drawn[side].as_deref().filter(|_| known[side].is_some()).unwrap_or(shape[side]));
        // Where no bound is known, several shapes have the same lines.
        if invalid.contains(&lines) {
            continue;
        }
        if !is_valid(&lines, narrow) {
            invalid.push(lines);
            continue;
        }
        let is_even = matches!(share, Share::Evenly | Share::Along);
        if !is_even || !with_opposite || keep_width(lines, widths) {
            let lines = rounded(lines, known, narrow);
            let mut known = known.into_iter();
            return Some(lines.map(|line| match known.next().flatten() {
                Some(bound) => Side::Shared(bound),
                None => Side::Own(line.into_owned()),
            }));
        }
    }
    None
}

/// The lines with the bends of those rounded that are not drawn yet, if the lane between them, as wide as this, metres, stays
/// valid.
fn rounded<'a>(lines: [&'a [Point]; 2], known: [Option<Bound>; 2], width: f64) -> [Cow<'a, [Point]>; 2] {
    let round = |side: usize| if known[side].is_some() { Cow::Borrowed(lines[side]) } else { BENDS.of(lines[side]) };
    let round = [round(0), round(1)];
    let changed = round.iter().any(|line| matches!(line, Cow::Owned(_)));
    if !changed || is_valid(&round, width) { round } else { lines.map(Cow::Borrowed) }
}

/// The key of a part of an intersection.
pub fn intersection_key(part: &str, intersection: &Intersection) -> Key {
    intersection.nodes.iter().fold(Key::new(part), |key, &node| key.number(node))
}
