//! vm-01-03: lanes side by side share their border.

use std::collections::{BTreeMap, BTreeSet};

use rayon::prelude::*;
use rustc_hash::FxHashSet;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, Polyline, Vector, polygon};
use crate::lanelet::index::view::boxes_meet;
use crate::lanelet::index::{Lane, MapIndex, declared_area};
use crate::lanelet::{Attributes, LaneletId, LineString, LineStringId, PointId, RoadType};
use crate::parallel::InSmallParts;

use super::parallel_bounds::{Border, on_two_levels};
use super::{crowd, divided_lanelets, merged_borders, vm_01_02};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    gap_most: f64,
    share_least: f64,
    iou_threshold: f64,
}

/// What divides carriageways rather than lanes.
const BARRIERS: [&str; 5] = ["road_border", "curbstone", "guard_rail", "wall", "fence"];
/// Distance between the places at which two bounds are compared, metres.
const COMPARED_EVERY: f64 = 0.5;
/// A stretch of a line holds at least as many of these places as fit into it, less this number.
const MISSED_AT_ENDS: f64 = 2.0;
/// An end no farther than this from a line, metres, lies on it: half the width of the paint.
const ON_LINE: f64 = 0.05;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let open = |lane| borders(map, lane, &FxHashSet::default());
    let mut borders_of: Vec<Vec<Border>> = map.lanes.par_iter().in_small_parts().map(open).collect();
    let found = |at: usize, borders_of: &[Vec<Border>]| {
        along(map, borders_of, params, at).into_iter().map(move |other| (at, other))
    };
    let all = (0..map.lanes.len()).into_par_iter().in_small_parts();
    let mut pairs: Vec<(usize, usize)> = all.flat_map_iter(|at| found(at, &borders_of)).collect();
    if !pairs.is_empty() {
        // Few maps have such lanes, so the points of barriers are collected only here.
        let (walls, first) = (walls(map), pairs.iter().flat_map(|&(at, other)| [at, other]));
        let lanes: BTreeSet<usize> = first.collect();
        lanes.iter().for_each(|&at| borders_of[at] = borders(map, &map.lanes[at], &walls));
        pairs = lanes.iter().flat_map(|&at| found(at, &borders_of)).collect();
    }
    let mut findings = Vec::new();
    let mut one_way: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for &(at, other) in &pairs {
        let (id, name) = (map.lanes[at].id, map.lanes[other].id);
        if pairs.binary_search(&(other, at)).is_err() {
            one_way.entry(at).or_default().push(other);
        } else if at < other {
            let message = format!("Lanelets {id} and {name} lie side by side but have borders of their own.");
            let finding = Finding::new("not-shared", Subject::Lanelet(id.0), message);
            let finding = finding.with(Subject::Lanelet(name.0), "neighbour");
            findings.push(match one_way_of(map, [at, other]) {
                Some((way, edits)) => finding.fixed_by(format!("use way {way} for both"), false, edits),
                None => finding,
            });
        }
    }
    findings.extend(one_way.into_iter().map(|(at, others)| partly(map, at, others)));
    findings
}

fn partly(map: &MapIndex, at: usize, mut others: Vec<usize>) -> Finding {
    others.sort_unstable_by_key(|&other| map.lanes[other].id);
    let (id, ids): (LaneletId, Vec<LaneletId>) =
        (map.lanes[at].id, others.iter().map(|&other| map.lanes[other].id).collect());
    let names: Vec<String> = ids.iter().map(ToString::to_string).collect();
    let message = format!("Lanelet {id} lies beside {} but is divided elsewhere.", names.join(", "));
    let finding = Finding::new("partly-shared", Subject::Lanelet(id.0), message);
    let finding = ids.iter().fold(finding, |finding, other| finding.with(Subject::Lanelet(other.0), "neighbour"));
    // The lane may end beside the other after all, although one border swings out farther than the other.
    if let Some((way, edits)) = others.iter().find_map(|&other| one_way_of(map, [at, other])) {
        return finding.fixed_by(format!("use way {way} for both"), false, edits);
    }
    divided_lanelets::beside(map, finding, at, &others)
}

/// The edits by which two lanes share one border, and the way that stays. If both run in one direction, the way also gets
/// `lane_change`, which the edge of a single lane does not need.
fn one_way_of(map: &MapIndex, lanes: [usize; 2]) -> Option<(LineStringId, Vec<Edit>)> {
    let (way, mut edits) = merged_borders::between(map, lanes)?;
    let tags = &map.map.linestrings.get(way)?.attributes;
    let [one, other] = lanes.map(|lane| map.lanes[lane].heading_in());
    let is_asked = one.zip(other).is_some_and(|(one, other)| one.dot(&other) > 0.0) && !tags.is("type", "virtual");
    if is_asked {
        edits.extend(vm_01_02::said_as_painted(way, tags));
    }
    Some((way, edits))
}

/// From each point of a barrier to the next, the lower id first.
fn walls(map: &MapIndex) -> FxHashSet<[PointId; 2]> {
    let barriers = map.map.linestrings.iter().filter(|line| is_barrier(&line.attributes));
    barriers.flat_map(|line| line.points.windows(2).map(step)).collect()
}

fn is_barrier(attributes: &Attributes) -> bool {
    attributes.get("type").is_some_and(|kind| BARRIERS.contains(&kind))
}

fn step(pair: &[PointId]) -> [PointId; 2] {
    [pair[0].min(pair[1]), pair[0].max(pair[1])]
}

/// The bounds over which a lane may lie beside another. Left out are barriers and bounds on the points of a barrier, such as the
/// kerbs on virtual bounds of intersections. Bicycle lanes have a rule of their own, and lanelets for people on foot that cross
/// have no neighbours.
fn borders(map: &MapIndex, lane: &Lane, walls: &FxHashSet<[PointId; 2]>) -> Vec<Border> {
    if lane.bicycle || matches!(lane.kind, RoadType::Crosswalk | RoadType::Walkway) {
        return Vec::new();
    }
    let open = |way: LineStringId| {
        let walled = |line: &LineString| line.points.windows(2).all(|pair| walls.contains(&step(pair)));
        map.map.linestrings.get(way).is_none_or(|line| !is_barrier(&line.attributes) && !walled(line))
    };
    let sides = [(lane.bounds[0], &lane.left), (lane.bounds[1], &lane.right)];
    let open = sides.into_iter().filter(|(way, _)| open(*way));
    open.filter_map(|(_, points)| Polyline::new(points.iter().copied())).map(Border::of).collect()
}

/// Lanes beside one that have nothing to do with it, but of which a bound runs along one of its own.
fn along(map: &MapIndex, borders: &[Vec<Border>], params: &Params, at: usize) -> Vec<usize> {
    let lane = &map.lanes[at];
    if borders[at].is_empty() {
        return Vec::new();
    }
    let margin = Vector::repeat(params.gap_most);
    let near = map.lanes_near(lane.extent[0] - margin, lane.extent[1] + margin).into_iter();
    let candidates = near.filter(|&other| {
        other != at
            && !borders[other].is_empty()
            && !are_related(map, at, other)
            && run_along(map, borders, params, [at, other])
            && !parts_from_one_beside(map, at, other)
            && !parts_from_one_beside(map, other, at)
    });
    let (mut beside, mut on_it) = (Vec::new(), 0);
    for other in candidates {
        if lie_apart(params, lane, &map.lanes[other]) {
            beside.push(other);
        } else {
            on_it += 1;
        }
        // Where more lie on it, nothing lies beside it, and vm-07-08 says so.
        if on_it == crowd::MOST {
            break;
        }
    }
    beside
}

/// Whether two lanes share a bound, follow each other, lie on two levels, are a road and a strip at its side, or belong to one place
/// where streets meet: an intersection, as lanes of buses may, too, of which vm-03-07 judges lanes that cross, diverge or merge; or a
/// place of a roundabout.
fn are_related(map: &MapIndex, at: usize, other: usize) -> bool {
    let (a, b) = (&map.lanes[at], &map.lanes[other]);
    let area = declared_area(a);
    b.bounds.iter().any(|way| a.bounds.contains(way))
        || map.follows(at, other)
        || map.follows(other, at)
        || on_two_levels(a, b)
        || is_strip(a, b)
        || map.in_same_intersection(at, other).is_some()
        || area.is_some() && area == declared_area(b)
        || map.turns_at_unmarked(at)
        || map.turns_at_unmarked(other)
        || map.shared_unmarked(at, other).is_some()
        || is_led_across(map, at, other) && is_led_across(map, other, at)
}

/// Whether a lane leads from where one begins to where the other ends: who wants to change drives over that one.
fn is_led_across(map: &MapIndex, from: usize, to: usize) -> bool {
    let end = map.lanes[to].end.ids;
    map.siblings(from).any(|across| across != to && map.lanes[across].end.ids == end)
}

/// Whether a lane lies on another from which it parts, or into which it merges, and that one shares the border beside it: a ramp that
/// leaves its road little by little.
fn parts_from_one_beside(map: &MapIndex, lane: usize, beside: usize) -> bool {
    /// The most lanes that follow each other along a lane that parts.
    const PIECES: usize = 16;
    let is_on = |other: usize| polygon::overlap(&map.lanes[lane].outline, &map.lanes[other].outline) > 0.0;
    let reaches = |from: usize, ahead: bool| {
        let end = |at: usize| if ahead { &map.lanes[at].end.ids } else { &map.lanes[at].start.ids };
        let mut at = from;
        for _ in 0..PIECES {
            if end(at) == end(lane) {
                return true;
            }
            let next = if ahead { map.followers(at) } else { map.predecessors(at) };
            let Some(&next) = next.iter().find(|&&next| next != lane && is_on(next)) else { return false };
            at = next;
        }
        false
    };
    let sharing = map.lanes[beside].bounds.iter().flat_map(|way| map.users_of(*way)).copied();
    let mut between = sharing.filter(|&it| it != beside && it != lane && is_on(it));
    between.any(|it| reaches(it, false) || reaches(it, true))
}

/// Whether a bound of one lane runs along a bound of the other, between streets in the same direction.
fn run_along(map: &MapIndex, borders: &[Vec<Border>], params: &Params, [at, other]: [usize; 2]) -> bool {
    let streets = is_street(map, at) && is_street(map, other);
    let beside = |line: &Border, own: &Border| {
        let around = own.around(params.gap_most);
        let is_near = boxes_meet(line.extent, around) && !part(&line.line, &own.line);
        is_near && runs_along(&line.line, own, around, params) && !(streets && against(&line.line, &own.line))
    };
    borders[other].iter().any(|line| borders[at].iter().any(|own| beside(line, own)))
}

/// Whether two lanes overlap by no more than the allowed share of their common area.
fn lie_apart(params: &Params, a: &Lane, b: &Lane) -> bool {
    let overlap = polygon::overlap(&a.outline, &b.outline);
    overlap <= params.iou_threshold * (a.area + b.area - overlap)
}

/// Whether one is a road and the other a strip at its side: vm-01-16 and vm-01-18 say what is between them.
fn is_strip(a: &Lane, b: &Lane) -> bool {
    let strip = |kind| matches!(kind, RoadType::Shoulder | RoadType::PedestrianLane);
    let pair = |x: &Lane, y: &Lane| x.kind == RoadType::Road && strip(y.kind);
    pair(a, b) || pair(b, a)
}

/// A lane that vm-01-04 holds against those of the opposite direction.
fn is_street(map: &MapIndex, at: usize) -> bool {
    map.lanes[at].is_for_cars() && map.intersections_of(at).is_empty()
}

/// Whether a bound runs against another beside it.
fn against(line: &Polyline, other: &Polyline) -> bool {
    let middle = line.length() / 2.0;
    line.direction(middle).dot(&other.direction(other.project(line.at(middle)).station)) < 0.0
}

/// Whether a line shares one end with another and then leaves it, as the borders of lanes that diverge or merge do, which cannot
/// be one line. If only the line is divided at another place, its shorter piece ends on the longer line.
fn part(line: &Polyline, other: &Polyline) -> bool {
    let ends = [other.first(), other.last()];
    let leaves = |common: Point, far: Point| ends.contains(&common) && other.distance(far) > ON_LINE;
    leaves(line.first(), line.last()) || leaves(line.last(), line.first())
}

/// Whether enough of a line lies close to another, around which this is the box of what is close.
fn runs_along(line: &Polyline, other: &Border, around: [Point; 2], params: &Params) -> bool {
    let mut places = line.places(COMPARED_EVERY);
    let mut may_miss = ((1.0 - params.share_least) * places.len() as f64) as usize;
    // Of most lines that only cross, the middle tells how much of them lies too far away.
    let (count, half) = (places.len(), line.length() / 2.0);
    let beyond = (other.line.distance(line.at(half)) - params.gap_most).min(half);
    if 2.0 * beyond * (count - 1) as f64 / line.length() > may_miss as f64 + MISSED_AT_ENDS {
        return false;
    }
    let mut hint = 0;
    places.all(|place| {
        let close = boxes_meet([place; 2], around) && other.line.reaches(place, params.gap_most, &mut hint);
        let missed = !close && may_miss > 0;
        may_miss -= usize::from(missed);
        close || missed
    })
}
