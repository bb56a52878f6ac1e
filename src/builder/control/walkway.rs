//! Walkways: the part of a public road's sidewalk that vehicles cross on their way onto private ground.

#[cfg(test)]
mod tests;

use crate::builder::ids::Key;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::lane_ends::sidewalk;
use crate::builder::lanes::types::Lanes;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::{at_depth, from_cut, on_cut};
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadNetwork};
use crate::builder::tags::cross_section::{SIDEWALK, StripKind};
use crate::geometry::{Point, Vector, left_of, polygon};
use crate::lanelet::{Attributes, Bound, LaneletId, Target};

use super::crosswalk::pedestrian_attributes;

/// A walkway reaches this far, metres, beyond the lanes that cross it: Autoware requires 3 m.
const BEYOND: f64 = 3.1;
/// Lanes that cross a sidewalk are sought up to this distance, metres, from its begin.
const LANES_WITHIN: f64 = 40.0;
/// Lanes farther than this, metres, from the others belong to another road.
const APART: f64 = 6.0;
/// Distance of a walkway from the kerb, metres: the lanes along the road end there.
const WALKWAY_FROM_KERB: f64 = 0.2;
/// Least and largest width of a walkway, metres.
const WIDTH: [f64; 2] = [1.0, 3.0];
/// Lanelets that share at least this area, square metres, with a walkway cross it.
const CROSSES: f64 = 0.005;

/// The end of a sidewalk at an intersection.
struct SidewalkEnd {
    /// In the middle of the sidewalk.
    place: Point,
    /// Unit direction along the sidewalk, out of the road.
    ahead: Vector,
    /// Metres.
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
        let ends = [((arm + count - 1) % count, true), ((arm + 1) % count, false)].map(|(other, next)| {
            let public = (!is_private(other)).then_some(intersection.arms[other]);
            sidewalk_end(network, lanes, public?, next)
        });
        let mapped = mapped(network, lanes, at).filter(|_| !(0..count).all(is_private));
        let leads = |path: &&TurningLanelet| path.movement.from == arm || path.movement.to == arm;
        let mut reached: Vec<Outlined> = paths.iter().filter(leads).map(|p| outlined(assembly, p.lanelet)).collect();
        let beside_arms = shape(&ends, &reached);
        reached.extend(lanes.of_road(at.road).iter().map(|lane| outlined(assembly, lane.lanelet)));
        let shapes = [mapped.and_then(|end| shape(&[Some(end), None], &reached)), beside_arms];
        if shapes.iter().all(Option::is_none) {
            continue;
        }
        // The lanelets that do not lead onto private ground, which cross no walkway.
        let through = paths.iter().filter(|path| !leads(path)).map(|path| path.lanelet);
        let along = intersection.arms.iter().filter(|other| other.road != at.road);
        let along = along.flat_map(|other| lanes.of_road(other.road)).map(|lane| lane.lanelet);
        let others: Vec<Vec<Point>> = through.chain(along).map(|lanelet| assembly.outline(lanelet)).collect();
        let mut found = shapes.into_iter().flatten().map(|shape| (ring(&shape), shape));
        let found = found.find(|(ring, _)| !others.iter().any(|lane| crosses(lane, ring)));
        let Some((ring, shape)) = found else { continue };
        let carriers = reached.iter().filter(|(_, lane)| crosses(lane, &ring)).map(|(lanelet, _)| *lanelet);
        let key = network.road(at.road).key_of("walkway").number(at.end as i64);
        add(assembly, key, shape, &carriers.collect::<Vec<LaneletId>>());
    }
}

fn outlined(assembly: &MapBuilder, lanelet: LaneletId) -> Outlined {
    (lanelet, assembly.outline(lanelet))
}

fn ring([left, right]: &[Vec<Point>; 2]) -> Vec<Point> {
    left.iter().chain(right.iter().rev()).copied().collect()
}

fn crosses(lane: &[Point], walkway: &[Point]) -> bool {
    polygon::common_area(lane, walkway) >= CROSSES
}

/// The end of a road's sidewalk at an intersection, on the side of the next arm clockwise or of the one before.
fn sidewalk_end(network: &RoadNetwork, lanes: &Lanes, at: RoadEnd, next: bool) -> Option<SidewalkEnd> {
    let road = network.road(at.road);
    let section = &road.section;
    let (first, last) = section.carriageway();
    let is_sidewalk = |i: &usize| section.strips.get(*i).is_some_and(|strip| strip.kind == StripKind::Sidewalk);
    // Looking into the intersection the next arm clockwise lies on the left.
    let strip = match next == (at.end == End::End) {
        true => (0..first).rev().find(is_sidewalk)?,
        false => (last..section.strips.len()).find(is_sidewalk)?,
    };
    let [a, b] = [section.edge(strip), section.edge(strip + 1)];
    let (station, ahead) = cut(road, lanes, at)?;
    let place = on_cut(road, at.end, station, f64::midpoint(a, b));
    Some(SidewalkEnd { place, ahead, width: (a - b).abs() })
}

/// The begin of the crossing of a mapped sidewalk over a road; it runs straight across, as crosswalks do. On a short road it lies so far
/// from the other end that it keeps clear of the lanelets of the intersection there.
fn mapped(network: &RoadNetwork, lanes: &Lanes, at: RoadEnd) -> Option<SidewalkEnd> {
    let road = network.road(at.road);
    let mut station = sidewalk(road, at.end)?;
    let other = RoadEnd { end: at.end.other(), ..at };
    if let Some((cut, _)) = cut(road, lanes, other) {
        let depth = from_cut([cut; 2], other.end, station).max(SIDEWALK / 2.0);
        station = at_depth([cut; 2], other.end, depth).clamp(0.0, road.line.length());
    }
    Some(SidewalkEnd { place: road.line.at(station), ahead: left_of(road.line.direction(station)), width: SIDEWALK })
}

/// The station, metres, at which a road is cut, and the direction out of it there.
fn cut(road: &Road, lanes: &Lanes, at: RoadEnd) -> Option<(f64, Vector)> {
    let arm = lanes.arm(at);
    let pose = arm.into.iter().chain(&arm.out).map(|lane| lane.pose).next()?;
    let station = road.line.project(pose.point).station;
    let whole = [0.0, road.line.length()];
    (from_cut(whole, at.end, station) >= 0.0).then_some((station, arm.inward))
}

/// The bounds of a walkway over all lanelets that it crosses, left and right as one walks clockwise around the intersection.
fn shape(ends: &[Option<SidewalkEnd>; 2], crossing: &[Outlined]) -> Option<[Vec<Point>; 2]> {
    let (start, along, width, near) = match ends {
        [Some(a), Some(b)] => {
            let along = (b.place - a.place).try_normalize(1e-6)?;
            // Around a corner there is no straight line from one sidewalk to the other.
            let straight = along.dot(&a.ahead) > 0.5 && along.dot(&b.ahead) < -0.5;
            straight.then_some((a.place, along, a.width.min(b.width), [0.0, (b.place - a.place).norm()]))?
        }
        [Some(a), None] => (a.place, a.ahead, a.width, [0.0; 2]),
        [None, Some(b)] => (b.place + b.ahead * LANES_WITHIN, -b.ahead, b.width, [LANES_WITHIN; 2]),
        [None, None] => return None,
    };
    let half = (width.clamp(WIDTH[0], WIDTH[1]) / 2.0 - WALKWAY_FROM_KERB).max(WIDTH[0] / 2.0);
    let left = left_of(along);
    let bounds =
        |from: f64, to: f64| [half, -half].map(|offset| [from, to].map(|s| start + along * s + left * offset).to_vec());
    let band = ring(&bounds(-LANES_WITHIN, 2.0 * LANES_WITHIN));
    let crossed = crossing.iter().flat_map(|(_, lane)| polygon::intersection(lane, &band));
    let span = |part: geo::Polygon| {
        let stations = part.exterior().coords().map(|c| (Point::new(c.x, c.y) - start).dot(&along));
        stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], s| [a.min(s), b.max(s)])
    };
    let [from, to] = connected_span(crossed.map(span).collect(), near)?;
    Some(bounds(from - BEYOND, to + BEYOND))
}

/// The hull of the spans that overlap `near`, or of the nearest one, and of all that follow without a gap.
fn connected_span(mut spans: Vec<[f64; 2]>, near: [f64; 2]) -> Option<[f64; 2]> {
    let gap = |a: [f64; 2], b: [f64; 2]| (a[0] - b[1]).max(b[0] - a[1]).max(0.0);
    let mut hull = spans.iter().copied().min_by(|a, b| gap(*a, near).total_cmp(&gap(*b, near)))?;
    while let Some(next) = spans.iter().position(|&span| gap(span, hull) <= APART || gap(span, near) == 0.0) {
        let [from, to] = spans.swap_remove(next);
        hull = [hull[0].min(from), hull[1].max(to)];
    }
    Some(hull)
}

fn add(assembly: &mut MapBuilder, key: Key, bounds: [Vec<Point>; 2], carriers: &[LaneletId]) {
    let mut names = ["left", "right"].into_iter();
    let [left, right] = bounds.map(|places| {
        let key = key.word(names.next().unwrap_or_default());
        let points = places.iter().zip(0..).map(|(place, i)| assembly.point(key.number(i), *place, 0.0)).collect();
        Bound { line: assembly.line(key, points, Attributes::of(&[("type", "virtual")])), inverted: false }
    });
    let id = assembly.lanelet(key, left, right, pedestrian_attributes("walkway"));
    let key = Key::new("walkway element").number(id.0);
    assembly.element(key, "crosswalk", &[("refers", Target::Lanelet(id))], carriers);
}
