//! Walkways: where the sidewalk of a public road passes a way onto private ground, the piece of it that vehicles cross.

#[cfg(test)]
mod tests;

use crate::builder::ids::Key;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::lane_ends::sidewalk;
use crate::builder::lanes::types::Lanes;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::{from_cut, on_cut};
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{SIDEWALK, StripKind};
use crate::geometry::{Point, Vector, left_of, polygon};
use crate::lanelet::{Attributes, Bound, LaneletId, Target};

/// A walkway reaches so far, metres, beyond the lanes that cross it: 3 m are asked for.
const BEYOND: f64 = 3.1;
/// Nobody looks for the lanes that cross a sidewalk farther than this, metres, from where it begins.
const REACH: f64 = 40.0;
/// What is crossed so far, metres, beyond the rest is another road.
const APART: f64 = 6.0;
/// It keeps clear, metres, of the kerb: the lanes along the road end there.
const CLEAR: f64 = 0.2;
/// Least and largest width, metres.
const WIDTH: [f64; 2] = [1.0, 3.0];
/// Lanelets that share at least this area, square metres, with a walkway cross it.
const CROSSES: f64 = 0.005;

/// Where a sidewalk meets the end of its road.
struct SidewalkEnd {
    /// On the middle of the sidewalk.
    place: Point,
    /// Out of the road, along the sidewalk.
    ahead: Vector,
    width: f64,
}

/// A lanelet with its outline.
type Outlined = (LaneletId, Vec<Point>);

/// Adds the walkways of an intersection and their regulatory elements. There is no walkway where people cross a road end on a
/// crosswalk.
pub fn walkways(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lanes: &Lanes,
    intersection: &Intersection,
    crossed: impl Fn(RoadEnd) -> bool,
    paths: &[TurningLanelet],
) {
    let count = intersection.arms.len();
    let is_private = |arm: usize| !network.road(intersection.arms[arm].road).public;
    for (arm, &at) in intersection.arms.iter().enumerate().filter(|(arm, _)| is_private(*arm)) {
        if crossed(at) || count < 3 {
            continue;
        }
        // Arms are clockwise: the one before lies on the left of vehicles that leave private ground.
        let ends = [((arm + count - 1) % count, false), ((arm + 1) % count, true)].map(|(other, next)| {
            let public = (!is_private(other)).then_some(intersection.arms[other]);
            sidewalk_end(network, lanes, public?, !next)
        });
        let mapped = mapped(network.road(at.road), at.end).filter(|_| !(0..count).all(is_private));
        let leads = |path: &&TurningLanelet| path.movement.from == arm || path.movement.to == arm;
        let mut reached: Vec<Outlined> = paths.iter().filter(leads).map(|p| outlined(assembly, p.lanelet)).collect();
        let beside_arms = shape(&ends, &reached);
        if mapped.is_some() {
            reached.extend(lanes.of_road(at.road).iter().map(|lane| outlined(assembly, lane.lanelet)));
        }
        let shapes = [mapped.and_then(|end| shape(&[Some(end), None], &reached)), beside_arms];
        if shapes.iter().all(Option::is_none) {
            continue;
        }
        // The lanelets that do not lead onto private ground, which cross no walkway.
        let through = paths.iter().filter(|path| !leads(path)).map(|path| path.lanelet);
        let along = intersection.arms.iter().filter(|other| other.road != at.road);
        let along = along.flat_map(|other| lanes.of_road(other.road)).map(|lane| lane.lanelet);
        let others: Vec<Vec<Point>> = through.chain(along).map(|lanelet| assembly.outline(lanelet)).collect();
        let ring = |[left, right]: &[Vec<Point>; 2]| left.iter().chain(right.iter().rev()).copied().collect::<Vec<_>>();
        let clear = |ring: &[Point]| !others.iter().any(|lane| crosses(lane, ring));
        let found = shapes.into_iter().flatten().map(|shape| (ring(&shape), shape)).find(|(ring, _)| clear(ring));
        let Some((ring, shape)) = found else { continue };
        let carriers = reached.iter().filter(|(_, lane)| crosses(lane, &ring)).map(|(lanelet, _)| *lanelet);
        let key = network.road(at.road).key_of("walkway").number(at.end as i64);
        add(assembly, key, &shape, &carriers.collect::<Vec<LaneletId>>());
    }
}

fn outlined(assembly: &MapBuilder, lanelet: LaneletId) -> Outlined {
    (lanelet, assembly.outline(lanelet))
}

fn crosses(lane: &[Point], walkway: &[Point]) -> bool {
    polygon::common_area(lane, walkway) >= CROSSES
}

/// The sidewalk of a road on one side, where it reaches the intersection at its end; `last` tells whether on the side of
/// the arm that follows clockwise, or of the one before.
fn sidewalk_end(network: &RoadNetwork, lanes: &Lanes, at: RoadEnd, last: bool) -> Option<SidewalkEnd> {
    let road = network.road(at.road);
    // Looking into the intersection the next arm clockwise lies on the left.
    let left = last == (at.end == End::End);
    let (from, to) = strips(road, left)?;
    let [a, b] = [road.section.edge(from), road.section.edge(to)];
    let (station, ahead) = cut(road, lanes, at)?;
    let place = on_cut(road, at.end, station, f64::midpoint(a, b));
    Some(SidewalkEnd { place, ahead, width: (a - b).abs() })
}

/// Where a sidewalk that is mapped as a way of its own first leads across a road before its end; straight across, as
/// crosswalks do.
fn mapped(road: &Road, end: End) -> Option<SidewalkEnd> {
    let station = sidewalk(road, end)?;
    Some(SidewalkEnd { place: road.line.at(station), ahead: left_of(road.line.direction(station)), width: SIDEWALK })
}

/// The edges of the sidewalk beside the kerb on one side of a road.
fn strips(road: &Road, left: bool) -> Option<(usize, usize)> {
    let (first, last) = road.section.carriageway();
    let walk = |i: usize| road.section.strips.get(i).is_some_and(|strip| strip.kind == StripKind::Sidewalk);
    match left {
        true => (0..first).rev().find(|&i| walk(i)).map(|i| (i, i + 1)),
        false => (last..road.section.strips.len()).find(|&i| walk(i)).map(|i| (i, i + 1)),
    }
}

/// The station at which a road is cut, and the direction out of it there.
fn cut(road: &Road, lanes: &Lanes, at: RoadEnd) -> Option<(f64, Vector)> {
    let arm = lanes.arm(at);
    let pose = arm.into.iter().chain(&arm.out).map(|lane| lane.pose).next()?;
    let station = road.line.project(pose.point).station;
    let whole = [0.0, road.line.length()];
    (from_cut(whole, at.end, station) >= 0.0).then_some((station, arm.inward))
}

/// The two bounds of a walkway, left and right as one walks clockwise around the intersection, over all that crosses it.
fn shape(ends: &[Option<SidewalkEnd>; 2], crossing: &[(LaneletId, Vec<Point>)]) -> Option<[Vec<Point>; 2]> {
    let (start, along, width, sought) = match ends {
        [Some(a), Some(b)] => {
            let along = (b.place - a.place).try_normalize(1e-6)?;
            // Around a corner there is no straight line from one sidewalk to the other.
            let straight = along.dot(&a.ahead) > 0.5 && along.dot(&b.ahead) < -0.5;
            straight.then_some((a.place, along, a.width.min(b.width), (b.place - a.place).norm()))?
        }
        [Some(a), None] => (a.place, a.ahead, a.width, 0.0),
        [None, Some(b)] => (b.place + b.ahead * REACH, -b.ahead, b.width, 0.0),
        [None, None] => return None,
    };
    let sought = if ends[0].is_some() { [0.0, sought] } else { [REACH; 2] };
    let half = (width.clamp(WIDTH[0], WIDTH[1]) / 2.0 - CLEAR).max(WIDTH[0] / 2.0);
    let left = left_of(along);
    let bounds =
        |from: f64, to: f64| [half, -half].map(|offset| [from, to].map(|s| start + along * s + left * offset).to_vec());
    let [a, b] = bounds(-REACH, 2.0 * REACH);
    let band: Vec<Point> = a.iter().chain(b.iter().rev()).copied().collect();
    let crossed = crossing.iter().flat_map(|(_, lane)| polygon::intersection(lane, &band));
    let stations = |part: geo::Polygon| {
        let stations = part.exterior().coords().map(|c| (Point::new(c.x, c.y) - start).dot(&along));
        stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s), b.max(s)])
    };
    let [from, to] = together(crossed.map(stations).collect(), sought)?;
    Some(bounds(from - BEYOND, to + BEYOND))
}

/// The span of those that lie where one looks, or next to it, and of all that lie beside them without a gap.
fn together(mut spans: Vec<[f64; 2]>, sought: [f64; 2]) -> Option<[f64; 2]> {
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[1]).max(b[0] - a[1]).max(0.0);
    let nearest = spans.iter().copied().min_by(|a, b| gap(*a, sought).total_cmp(&gap(*b, sought)))?;
    let mut whole = nearest;
    while let Some(next) = spans.iter().position(|&span| gap(span, whole) <= APART || gap(span, sought) == 0.0) {
        let [from, to] = spans.swap_remove(next);
        whole = [whole[0].min(from), whole[1].max(to)];
    }
    Some(whole)
}

fn add(assembly: &mut MapBuilder, key: Key, shape: &[Vec<Point>; 2], carriers: &[LaneletId]) {
    let mut side = |name: &str, places: &[Point]| {
        let points = places.iter().zip(0..).map(|(place, i)| assembly.point(key.word(name).number(i), *place, 0.0));
        let points = points.collect();
        Bound { line: assembly.line(key.word(name), points, Attributes::of(&[("type", "virtual")])), inverted: false }
    };
    let (left, right) = (side("left", &shape[0]), side("right", &shape[1]));
    let attributes = Attributes::of(&[
        ("type", "lanelet"),
        ("subtype", "walkway"),
        ("location", "urban"),
        ("one_way", "no"),
        ("participant:pedestrian", "yes"),
    ]);
    let id = assembly.lanelet(key, left, right, attributes);
    let key = Key::new("walkway element").number(id.0);
    assembly.element(key, "crosswalk", &[("refers", Target::Lanelet(id))], carriers);
}
