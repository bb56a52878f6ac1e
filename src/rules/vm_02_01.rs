//! vm-02-01: a stop line is a straight one across its lane.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, Polyline, Vector, cross, segment_crossing};
use crate::lanelet::PointId;
use crate::lanelet::index::{Lane, MapIndex, StopLine, extent};

use super::stop_line_crossings;
use super::stop_line_crossings::StopLineCrossing;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    bent: f64,
    askew: f64,
    span: f64,
    extra: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    stop_line_crossings::stop_lines(map).filter_map(|line| judge(map, params, &line)).collect()
}

fn judge(map: &MapIndex, params: &Params, line: &StopLine) -> Option<Finding> {
    let on = Subject::LineString(line.way.0);
    if let Some((far, place)) = bend(map, line).filter(|(far, _)| *far > params.bent) {
        let message = match line.edge_of_outline.is_some() {
            true => format!(
                "Stop line {} is drawn as the outline of its paint; the planner takes its ends for a line.",
                line.way
            ),
            false => format!("Stop line {} leaves the straight between its ends by {far:.2} m.", line.way),
        };
        let finding = Finding::new("bent", on, message).measured(far, params.bent, "m").at(Place::Point(place));
        return Some(straightened(map, finding, line));
    }
    let crossed = stop_line_crossings::crossings(map, line, params.extra);
    // vm-03-09 judges the starts of lanelets in intersections, with smaller limits; a lanelet that turns is askew to every line.
    let turns = |lane: usize| map.has_area(lane) || map.turn_direction(lane).is_some();
    let plain = |crossing: &&StopLineCrossing| {
        !turns(crossing.lane) && !map.followers(crossing.lane).iter().any(|&next| map.has_area(next))
    };
    let finding = |fault, crossing: &StopLineCrossing, message| {
        let lane = Subject::Lanelet(map.lanes[crossing.lane].id.0);
        Finding::new(fault, on, message).with(lane, "lanelet").at(Place::Line(line.ends.to_vec()))
    };
    // A line across several lanes was drawn for the one to which it is straightest.
    let best = crossed.iter().filter(plain).min_by(|a, b| a.askew.total_cmp(&b.askew));
    if let Some(best) = best.filter(|one| one.askew > params.askew) {
        let id = map.lanes[best.lane].id;
        let message = format!("Stop line {} stands {:.0} degrees askew in lanelet {id}.", line.way, best.askew);
        return Some(finding("askew", best, message).measured(best.askew, params.askew, "deg"));
    }
    // The lane that it crosses most is the one that it is meant for.
    let beside;
    let crossed = match crossed.is_empty() {
        true => {
            beside = beside_its_lanes(map, line);
            &beside
        }
        false => &crossed,
    };
    let widest = crossed.iter().max_by(|a, b| a.span.total_cmp(&b.span)).filter(|one| one.span < params.span)?;
    let (id, percent) = (map.lanes[widest.lane].id, widest.span * 100.0);
    let message = format!("Stop line {} spans only {percent:.0} % of the width of lanelet {id}.", line.way);
    Some(lengthened(
        map,
        finding("short", widest, message).measured(percent, params.span * 100.0, "%"),
        line,
        widest.lane,
    ))
}

/// The lanes that would cross a line if it were longer, and of which elements name it.
fn beside_its_lanes(map: &MapIndex, line: &StopLine) -> Vec<StopLineCrossing> {
    let mut found = stop_line_crossings::crossings(map, line, BESIDE);
    found.retain(|one| stops_at(map, &map.lanes[one.lane], line));
    found
}

/// A line this near (m) to the middle of a lane that stops at it was drawn for it.
const BESIDE: f64 = 5.0;
/// A bound farther (m) along a line is not that of the lane which it crosses.
const BOUND_ALONG_LINE: f64 = 10.0;
/// An end this near (m) to a bound, or beyond it, stays where it is.
const AT_BOUND: f64 = 0.3;

/// A lane starts or ends at a line where both its corners lie this near (m) to it, or where it would be if it were longer.
const AT_LINE: f64 = 0.5;

/// Adds the edits that lengthen a line over the lanes that stop at it; else to the bounds of the lane that it crosses.
fn lengthened(map: &MapIndex, finding: Finding, line: &StopLine, lane: usize) -> Finding {
    if let Some(edits) = over_its_lanes(map, line) {
        return finding.fixed_by("lengthen it over the lanelets that stop there", false, edits);
    }
    match to_bounds(map, line, lane) {
        Some(edits) => finding.fixed_by("lengthen it to the bounds of the lanelet", false, edits),
        None => finding,
    }
}

/// The edits that put the ends of a line onto the outermost corners of the lanes that start or end there and have elements that
/// name it; `None` where there are no such lanes, or where it reaches across them already.
fn over_its_lanes(map: &MapIndex, line: &StopLine) -> Option<Vec<Edit>> {
    let way = map.map.linestrings.get(line.way)?;
    let along = (line.ends[1] - line.ends[0]).try_normalize(Polyline::MERGE)?;
    let reach = Vector::repeat(BOUND_ALONG_LINE);
    let [low, high] = extent(&line.ends);
    let near = map.lanes_near(low - reach, high + reach).into_iter().map(|lane| &map.lanes[lane]);
    let edges = near.filter(|lane| stops_at(map, lane, line)).flat_map(|lane| [&lane.start, &lane.end]);
    let edges = edges.filter(|edge| edge.points.iter().all(|at| cross(along, at - line.ends[0]).abs() <= AT_LINE));
    let station = |place: Point| (place - line.ends[0]).dot(&along);
    let mut corners: Vec<(f64, PointId)> =
        edges.flat_map(|edge| edge.ids.into_iter().zip(edge.points)).map(|(id, place)| (station(place), id)).collect();
    corners.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let (&(first, from), &(last, to)) = (corners.first()?, corners.last()?);
    let placed = |point: PointId, share| Edit::PlaceBetween { point: point.0, from: from.0, to: to.0, share };
    let [start, end] = [*way.points.first()?, *way.points.last()?];
    let mut edits = Vec::new();
    edits.extend((first < -AT_BOUND).then(|| placed(start, 0.0)));
    edits.extend((last > station(line.ends[1]) + AT_BOUND).then(|| placed(end, 1.0)));
    (!edits.is_empty()).then_some(edits)
}

/// Whether an element of a lane names a line.
fn stops_at(map: &MapIndex, lane: &Lane, line: &StopLine) -> bool {
    let elements = lane.lanelet.regulatory_elements.iter().filter_map(|&id| map.map.regulatory_elements.get(id));
    let mut lines = elements.flat_map(|element| element.linestrings("ref_line").chain(element.linestrings("refers")));
    lines.any(|way| way == line.way)
}

/// The edits that lengthen a line to the bounds of a lane.
fn to_bounds(map: &MapIndex, line: &StopLine, lane: usize) -> Option<Vec<Edit>> {
    let way = map.map.linestrings.get(line.way)?;
    let lanelet = map.lanes[lane].lanelet;
    let along = (line.ends[1] - line.ends[0]).try_normalize(Polyline::MERGE)?;
    let [a, b] = [line.ends[0] - along * BOUND_ALONG_LINE, line.ends[1] + along * BOUND_ALONG_LINE];
    let ends = [(*way.points.first()?, line.ends[0], -along), (*way.points.last()?, line.ends[1], along)];
    let mut edits = Vec::new();
    for bound in [lanelet.left, lanelet.right] {
        let points: Vec<_> = map.map.bound_points(bound).collect();
        let crossed = points.windows(2).find_map(|pair| {
            let (.., place) = segment_crossing(a, b, pair[0].position, pair[1].position)?;
            let share = (place - pair[0].position).norm() / (pair[1].position - pair[0].position).norm();
            Some((place, [pair[0].id.0, pair[1].id.0], share))
        });
        let (place, [from, to], share) = crossed?;
        let (point, ..) = *ends.iter().max_by(|x, y| (place - x.1).dot(&x.2).total_cmp(&(place - y.1).dot(&y.2)))?;
        let beyond = ends.iter().any(|(_, end, out)| (place - end).dot(out) > AT_BOUND);
        edits.extend(beyond.then_some(Edit::PlaceBetween { point: point.0, from, to, share }));
    }
    (!edits.is_empty()).then_some(edits)
}

/// Adds the edits that put the inner vertices onto the straight between the ends, unless that would move another line, too; of an
/// outline, those that leave its longest edge.
fn straightened(map: &MapIndex, finding: Finding, line: &StopLine) -> Finding {
    let Some(way) = map.map.linestrings.get(line.way) else { return finding };
    if let Some(edge) = line.edge_of_outline {
        let edits = vec![Edit::SetVertices { way: finding.subject, points: edge.map(|point| point.0).to_vec() }];
        return finding.fixed_by("let it run along its longest edge alone", false, edits);
    }
    let [low, high] = extent(&line.ends);
    let margin = Vector::repeat(bend(map, line).map_or(0.0, |(far, _)| far) + Polyline::MERGE);
    let near = map.lanes_near(low - margin, high + margin);
    let mut bounds =
        near.iter().flat_map(|&lane| map.lanes[lane].bounds).filter_map(|way| map.map.linestrings.get(way));
    let inner = &way.points[1..way.points.len().max(2) - 1];
    if bounds.any(|bound| bound.points.iter().any(|point| inner.contains(point))) {
        return finding;
    }
    let ([from, inner @ .., to], Some(straight)) = (&way.points[..], Polyline::new(line.ends)) else { return finding };
    let places = inner.iter().filter_map(|&id| Some((id, map.map.points.get(id)?.position)));
    let edits = places.map(|(id, place)| {
        let share = straight.project(place).station / straight.length();
        Edit::PlaceBetween { point: id.0, from: from.0, to: to.0, share }
    });
    finding.fixed_by("put its inner points onto the straight between its ends", false, edits.collect())
}

/// The vertex that lies farthest from the straight between the ends.
fn bend(map: &MapIndex, line: &StopLine) -> Option<(f64, Point)> {
    let way = map.map.linestrings.get(line.way)?;
    let straight = Polyline::new(line.ends)?;
    let places = map.map.points.get_each(way.points.iter().copied()).map(|point| point.position);
    places.map(|p| (straight.distance(p), p)).max_by(|a, b| a.0.total_cmp(&b.0))
}
