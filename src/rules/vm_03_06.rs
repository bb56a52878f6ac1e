//! vm-03-06: lanelets follow the guide lines that are painted inside an intersection.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Polyline, angle_between, polygon};
use crate::lanelet::index::{Intersection, Lane, MapIndex, Movement, Traffic};
use crate::lanelet::{LineString, LineStringId};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    start: f64,
    heading: f64,
    offset: f64,
    apart: f64,
    early: f64,
}

/// Distance between the places where a bound is compared with its guide line, metres.
const COMPARED_EVERY: f64 = 1.0;

/// A painted line, from where it leaves the stop line.
struct Guide {
    way: LineStringId,
    line: Polyline,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let painted: Vec<&LineString> = map.map.linestrings.iter().filter(|line| is_guide(map, line)).collect();
    let mut findings = Vec::new();
    for (intersection, traffic) in map.intersections.iter().zip(&map.traffic) {
        for guide in guides(map, intersection, traffic, &painted) {
            findings.extend(judge(map, params, traffic, &guide));
        }
    }
    findings
}

/// Dashed paint that bounds no lanelet, or a way that says it is a guide line.
fn is_guide(map: &MapIndex, line: &LineString) -> bool {
    let dashed = matches!(line.attributes.get("type"), Some("line_thin" | "line_thick"))
        && line.attributes.is("subtype", "dashed")
        && map.users_of(line.id).is_empty();
    dashed || line.attributes.is("type", "guide_line")
}

/// The guide lines inside one intersection: those the user names, and those that lie inside.
fn guides(map: &MapIndex, intersection: &Intersection, traffic: &Traffic, painted: &[&LineString]) -> Vec<Guide> {
    let of = |line: &LineString| {
        let places = map.map.points.get_each(line.points.iter().copied()).map(|point| point.position);
        let line_of = Polyline::new(places.filter(|p| p.x.is_finite() && p.y.is_finite()))?;
        Some(Guide { way: line.id, line: line_of })
    };
    let [low, high] = crate::lanelet::index::extent(&intersection.ring);
    let inside = |guide: &Guide| {
        let middle = guide.line.at(guide.line.length() / 2.0);
        let near = middle.x >= low.x && middle.y >= low.y && middle.x <= high.x && middle.y <= high.y;
        near && polygon::contains(&intersection.ring, middle)
    };
    let named = traffic.guide_lines.iter().filter_map(|&id| map.map.linestrings.get(id)).filter_map(of);
    let mut guides: Vec<Guide> = named.collect();
    for guide in painted.iter().filter_map(|line| of(line)).filter(inside) {
        if !guides.iter().any(|known| known.way == guide.way) {
            guides.push(guide);
        }
    }
    guides
}

/// One side of a lanelet that starts where a guide line starts.
struct Candidate<'a> {
    movement: &'a Movement,
    lane: &'a Lane<'a>,
    side: usize,
    bound: Polyline,
    /// The guide line, away from the stop line.
    guide: Polyline,
    /// How far the bound strays from it, and where.
    off: (f64, Point),
}

fn judge(map: &MapIndex, params: &Params, traffic: &Traffic, guide: &Guide) -> Vec<Finding> {
    let candidates: Vec<Candidate> =
        traffic.movements.iter().flat_map(|movement| candidates(map, params, movement, guide)).collect();
    // The guide line was painted for the lanelet that follows it best; the other lanelets of that turn go along.
    let Some(best) = candidates.iter().min_by(|a, b| a.off.0.total_cmp(&b.off.0)) else { return Vec::new() };
    let mut findings = Vec::new();
    if best.off.0 > params.offset {
        let way = best.lane.bounds[best.side];
        let message = format!("Bound {way} of {} is {:.2} m off guide line {}.", best.lane.id, best.off.0, guide.way);
        let finding = Finding::new("off-guide", Subject::Lanelet(best.lane.id.0), message)
            .with(Subject::LineString(way.0), "bound")
            .with(Subject::LineString(guide.way.0), "guide line")
            .measured(best.off.0, params.offset, "m");
        findings.push(finding.at(Place::Point(best.off.1)));
    }
    for other in &candidates {
        let same_turn = other.movement.ranked.turn == best.movement.ranked.turn && other.side == best.side;
        if same_turn && other.lane.start.ids == best.lane.start.ids && other.lane.id != best.lane.id {
            findings.extend(early_divergence(params, guide, best, other));
        }
    }
    findings
}

/// The sides of a lanelet along which the line may have been painted: it starts there, in the lanelet's direction.
fn candidates<'a>(map: &'a MapIndex, params: &Params, movement: &'a Movement, guide: &Guide) -> Vec<Candidate<'a>> {
    let lane = &map.lanes[movement.lane];
    let Some(heading) = lane.heading_in() else { return Vec::new() };
    let mut found = Vec::new();
    for line in [guide.line.clone(), guide.line.reversed()] {
        let distance = |side: usize| (line.first() - lane.start.points[side]).norm();
        let side = usize::from(distance(1) < distance(0));
        let along = (line.at(COMPARED_EVERY) - line.first()).normalize();
        let turned = angle_between(heading, along).abs().to_degrees();
        if distance(side) > params.start || turned > params.heading {
            continue;
        }
        let points = if side == 0 { &lane.left } else { &lane.right };
        let Some(bound) = Polyline::new(points.iter().copied()) else { continue };
        let samples = line.resampled(COMPARED_EVERY);
        let off = samples.points().iter().map(|&p| (bound.distance(p), p));
        let Some(off) = off.max_by(|a, b| a.0.total_cmp(&b.0)) else { continue };
        found.push(Candidate { movement, lane, side, bound, guide: line, off });
    }
    found
}

/// Two lanelets of one turn must part where the line ends, not before.
fn early_divergence(params: &Params, guide: &Guide, best: &Candidate, other: &Candidate) -> Option<Finding> {
    let samples = best.guide.resampled(COMPARED_EVERY);
    let count = samples.points().len() - 1;
    let length = best.guide.length();
    let apart = |p: Point| other.bound.distance(best.bound.project(p).point);
    let at = samples.points().iter().position(|&p| apart(p) > params.apart)?;
    let before = length * (1.0 - at as f64 / count as f64);
    if before <= params.early {
        return None;
    }
    let (a, b) = (best.lane.id, other.lane.id);
    let message = format!("{a},{b} separate {before:.1} m before guide line {} ends.", guide.way);
    let finding = Finding::new("early-divergence", Subject::Lanelet(b.0), message)
        .with(Subject::Lanelet(a.0), "follows the guide line")
        .with(Subject::LineString(guide.way.0), "guide line")
        .measured(before, params.early, "m");
    Some(finding.at(Place::Point(samples.points()[at])))
}
