//! Lanes that run through an intersection and far beyond it, and where they are to be cut.

use super::divided_lanelets::{self, Across};
use super::stop_line_crossings::crossings;
use crate::diagnostic::{Edit, Fix};
use crate::geometry::{Point, Polyline, left_of, polygon};
use crate::lanelet::index::{Edge, MapIndex, Unmarked};

/// A lane that starts or ends alone farther (m) than this from where others cross or join it is a road that was not cut. Where people
/// draw areas, none does so by more than 17 m: a wide median, a crosswalk, and the stop line before it.
const FAR: f64 = 25.0;
/// Without a stop line a lane is cut this far (m) from where others cross or join it: whoever waits there is out of their way.
const CUT_BEFORE_CROSSING: f64 = 2.0;
/// A lane of which an end corner lies this close (m) to a border of another lies beside it: so far end nodes that belong together are
/// joined.
const ON_BORDER: f64 = 0.5;
/// An end of a lane beside another is across that one, up to this sine of the angle between them.
const ACROSS: f64 = 0.5;

/// Whether one of the lanes of an intersection reaches far beyond the others: no area is drawn over it.
pub fn has_far(map: &MapIndex, lanes: &[usize]) -> bool {
    lanes.iter().any(|&lane| !cuts(map, lanes, lane).is_empty())
}

/// What cuts the first of the lanes of an intersection that reaches far beyond the others; `None` where none does, and no fix where
/// none of them can be cut.
pub fn division(map: &MapIndex, intersection: &Unmarked) -> Option<Option<Fix>> {
    let all = [&intersection.lanes[..], &intersection.uncut].concat();
    let far = |lane: &usize| Some((*lane, cuts(map, &all, *lane))).filter(|(_, lines)| !lines.is_empty());
    let mut far = all.iter().filter_map(far).peekable();
    far.peek()?;
    let fix = |(lane, lines): (usize, Vec<Across>)| {
        let edits: Vec<Edit> = divided_lanelets::edits(map, lane, &lines)?;
        let title = format!("cut lanelet {} where the intersection begins and ends", map.lanes[lane].id);
        Some(Fix { title, safe: false, edits })
    };
    Some(far.find_map(fix))
}

/// The lines on which a lane is to be cut, in its direction; none where it does not reach far.
fn cuts(map: &MapIndex, lanes: &[usize], lane: usize) -> Vec<Across> {
    let at = &map.lanes[lane];
    let Some(center) = at.center.as_ref().filter(|center| center.length() > FAR) else { return Vec::new() };
    let others = || lanes.iter().filter(|&&other| other != lane).map(|&other| &map.lanes[other]);
    let starts_alone = is_alone(&at.start, &others().map(|other| other.start).collect::<Vec<_>>());
    let ends_alone = is_alone(&at.end, &others().map(|other| other.end).collect::<Vec<_>>());
    let meeting = if starts_alone || ends_alone { met(map, lanes, lane) } else { None };
    let Some([first, last]) = meeting else { return Vec::new() };
    let across = |station: f64| Across { place: center.at(station), along: left_of(center.direction(station)) };
    let mut lines = Vec::new();
    // Its stop line is where the intersection begins, however wide it is.
    if starts_alone && first > FAR && !map.starts_at_stop_line(lane) {
        let beside = || ends_beside(map, lanes, lane).filter(|(station, _)| (first - FAR..=first).contains(station));
        let nearest = beside().max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, line)| line);
        let own = nearest.or_else(|| stop_line_before(map, lane, first));
        lines.push(own.unwrap_or_else(|| across(first - CUT_BEFORE_CROSSING)));
    }
    if ends_alone && center.length() - last > FAR {
        let beside = ends_beside(map, lanes, lane).filter(|(station, _)| (last..=last + FAR).contains(station));
        let nearest = beside.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, line)| line);
        lines.push(nearest.unwrap_or_else(|| across(last + CUT_BEFORE_CROSSING)));
    }
    lines
}

/// Where the other lanes of the intersection that lie beside a lane start and end, each with its station (m): lanes side by side are
/// cut alike, so that they can share their border.
fn ends_beside<'i>(map: &'i MapIndex, lanes: &'i [usize], lane: usize) -> impl Iterator<Item = (f64, Across)> + 'i {
    let borders: Vec<Polyline> = [0, 1].into_iter().filter_map(|side| map.lanes[lane].border(side)).collect();
    let center = map.lanes[lane].center.as_ref();
    let edges = lanes.iter().filter(move |&&other| other != lane).map(|&other| &map.lanes[other]);
    edges.flat_map(|other| [other.start, other.end]).filter_map(move |edge| {
        let on_border = |place: &&Point| borders.iter().any(|border| border.distance(**place) <= ON_BORDER);
        let place = *edge.points.iter().find(on_border)?;
        let station = center?.project(place).station;
        let along = edge.across();
        let slant = along.try_normalize(f64::EPSILON)?.dot(&center?.direction(station));
        (slant.abs() <= ACROSS).then_some((station, Across { place, along }))
    })
}

/// Whether no other lane starts, or ends, at the edge where one does, nor two of them beside it, on the same cut across their road.
fn is_alone(edge: &Edge, others: &[Edge]) -> bool {
    let count_at = |edge: &Edge| others.iter().filter(|other| other.ids == edge.ids).count();
    !others.iter().any(|other| other.ids == edge.ids || (other.touches(edge) && count_at(other) > 1))
}

/// Where others of the intersection first and last cross or join a lane, metres from its start.
fn met(map: &MapIndex, lanes: &[usize], lane: usize) -> Option<[f64; 2]> {
    let at = &map.lanes[lane];
    let center = at.center.as_ref()?;
    let conflicts = map.conflicts[lane].iter().filter(|one| one.real && lanes.contains(&one.other));
    let common = conflicts.flat_map(|one| polygon::intersection(&at.outline, &map.lanes[one.other].outline));
    let corners = common.flat_map(|part| part.into_inner().0.into_iter().map(|c| Point::new(c.x, c.y)));
    let stations = corners.map(|corner| center.project(corner).station);
    let reach = stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)]);
    (reach[0] <= reach[1]).then_some(reach)
}

/// The last stop line across a lane before others meet it.
fn stop_line_before(map: &MapIndex, lane: usize, met: f64) -> Option<Across> {
    let [low, high] = map.lanes[lane].extent;
    let near = map.stop_lines_near(low, high).into_iter();
    let on_lane = near.filter_map(|line| {
        let found = crossings(map, &line, 0.0).into_iter().find(|one| one.lane == lane && one.span > 0.5)?;
        let is_own = found.station <= met && met - found.station <= FAR;
        is_own.then(|| (found.station, Across { place: found.place, along: line.ends[1] - line.ends[0] }))
    });
    on_lane.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, line)| line)
}
