//! vm-02-01: a stop line is a straight one across its lane.

use serde::Deserialize;

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Polyline};
use crate::lanelet::index::{MapIndex, StopLine};

use super::stop_line_crossings::StopLineCrossing;
use super::{Rule, stop_line_crossings};

/// See `rules/vm-02-01.md`.
pub struct StopLineAlignment;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    bent: f64,
    askew: f64,
    span: f64,
    extra: f64,
}

impl Rule for StopLineAlignment {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        stop_line_crossings::stop_lines(map).filter_map(|line| judge(map, params, &line)).collect()
    }
}

fn judge(map: &MapIndex, params: &Params, line: &StopLine) -> Option<Finding> {
    let on = Subject::LineString(line.way.0);
    if let Some((far, place)) = bend(map, line).filter(|(far, _)| *far > params.bent) {
        let message = format!("Stop line {} leaves the straight between its ends by {far:.2} m.", line.way);
        return Some(Finding::new("bent", on, message).measured(far, params.bent, "m").at(Place::Point(place)));
    }
    let crossed = stop_line_crossings::crossings(map, line, params.extra);
    // Where lanelets of an intersection start, vm-03-09 measures, and more closely; one that turns is askew to every line.
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
    Some(finding("short", widest, message).measured(percent, params.span * 100.0, "%"))
}

/// The vertex that lies farthest from the straight between the ends.
fn bend(map: &MapIndex, line: &StopLine) -> Option<(f64, Point)> {
    let way = map.map.linestrings.get(line.way)?;
    let straight = Polyline::new(line.ends)?;
    let places = way.points.iter().filter_map(|&id| map.map.points.get(id)).map(|point| point.position);
    places.map(|p| (straight.distance(p), p)).max_by(|a, b| a.0.total_cmp(&b.0))
}
