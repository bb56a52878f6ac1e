//! vm-02-01: a stop line is a straight one across its lane.

use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Point, Polyline, segment_crossing};
use crate::lanelet::index::{MapIndex, StopLine};

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
        let message = format!("Stop line {} leaves the straight between its ends by {far:.2} m.", line.way);
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

/// A bound farther (m) along a line is not that of the lane which it crosses.
const REACH: f64 = 10.0;
/// An end this near (m) to a bound, or beyond it, stays where it is.
const AT_BOUND: f64 = 0.3;

/// Adds the edits that lengthen a line to the bounds of a lane.
fn lengthened(map: &MapIndex, finding: Finding, line: &StopLine, lane: usize) -> Finding {
    let edits = || {
        let way = map.map.linestrings.get(line.way)?;
        let lanelet = map.lanes[lane].lanelet;
        let along = (line.ends[1] - line.ends[0]).try_normalize(Polyline::MERGE)?;
        let [a, b] = [line.ends[0] - along * REACH, line.ends[1] + along * REACH];
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
            let (point, ..) =
                *ends.iter().max_by(|x, y| (place - x.1).dot(&x.2).total_cmp(&(place - y.1).dot(&y.2)))?;
            let beyond = ends.iter().any(|(_, end, out)| (place - end).dot(out) > AT_BOUND);
            edits.extend(beyond.then_some(Edit::PlaceBetween { point: point.0, from, to, share }));
        }
        (!edits.is_empty()).then_some(edits)
    };
    match edits() {
        Some(edits) => finding.fixed_by("lengthen it to the bounds of the lanelet", false, edits),
        None => finding,
    }
}

/// Adds the edits that put the inner vertices onto the straight between the ends.
fn straightened(map: &MapIndex, finding: Finding, line: &StopLine) -> Finding {
    let Some(way) = map.map.linestrings.get(line.way) else { return finding };
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
