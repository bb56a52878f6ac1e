//! Where a stop line crosses lanes.

use crate::geometry::{Point, Polyline, Vector, segment_crossing};
use crate::lanelet::LineStringId;
use crate::lanelet::index::thresholds;
use crate::lanelet::index::view::boxes_meet;
use crate::lanelet::index::{Lane, MapIndex, StopLine, extent};

/// A place where a stop line crosses the middle of a lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StopLineCrossing {
    /// The lane, by its position.
    pub lane: usize,
    /// Metres from where the lane starts: less than 0, or more than its length, where the line lies just outside.
    pub station: f64,
    /// Where.
    pub place: Point,
    /// Angle between the line and the straight across the lane, degrees, 0..=90.
    pub askew: f64,
    /// Share of the lane's width, from bound to bound, that the line spans (1).
    pub span: f64,
}

/// How far before or behind a lane a stop line still belongs to it, metres: people do not draw to the centimetre.
const SLACK: f64 = 0.5;

/// The lanes for cars that a stop line crosses when it is lengthened by `extra` metres at both ends; where lanes lie on
/// several levels, only those on the line's own level.
pub fn crossings(map: &MapIndex, line: &StopLine, extra: f64) -> Vec<StopLineCrossing> {
    let [low, high] = extent(&line.ends);
    let margin = Vector::new(extra + SLACK, extra + SLACK);
    let near = map.lanes_near(low - margin, high + margin).into_iter();
    let mut found: Vec<StopLineCrossing> = near
        .filter(|&lane| map.lanes[lane].is_for_cars())
        .filter_map(|lane| crossing(line, &map.lanes[lane], extra).map(|found| StopLineCrossing { lane, ..found }))
        .collect();
    // Most maps are flat: where all that may be asked for lies on one level, heights are not.
    let reaches = found.iter().map(|crossing| map.lanes[crossing.lane].heights);
    let [low, high] =
        reaches.fold([line.height; 2], |[low, high], [lowest, highest]| [low.min(lowest), high.max(highest)]);
    if found.len() > 1 && high - low > thresholds::GRADE_SEPARATION {
        // Lines are drawn without heights more often than lanes: the nearest level is theirs, however far it is.
        let height = |crossing: &StopLineCrossing| map.height(crossing.lane, crossing.place).unwrap_or(line.height);
        let heights: Vec<f64> = found.iter().map(height).collect();
        let off = |height: &f64| (height - line.height).abs();
        let own = heights.iter().copied().min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(line.height);
        let mut heights = heights.into_iter();
        found.retain(|_| heights.next().is_some_and(|height| (height - own).abs() <= thresholds::GRADE_SEPARATION));
    }
    found
}

fn crossing(line: &StopLine, lane: &Lane, extra: f64) -> Option<StopLineCrossing> {
    let center = lane.center.as_ref()?;
    let along = (line.ends[1] - line.ends[0]).try_normalize(Polyline::MERGE)?;
    let [a, b] = [line.ends[0] - along * extra, line.ends[1] + along * extra];
    let [low, high] = extent(&[a, b]);
    let margin = Vector::repeat(Polyline::MERGE);
    // Most segments are told apart by their boxes.
    let crossed = |c: Point, d: Point| {
        let near = boxes_meet(extent(&[c, d]), [low - margin, high + margin]);
        let (.., place) = near.then(|| segment_crossing(a, b, c, d))??;
        Some(((place - c).norm(), place))
    };
    let last = lane.length();
    let before = || {
        let (reached, place) = crossed(center.first() - center.direction(0.0) * SLACK, center.first())?;
        Some((reached - SLACK, place))
    };
    let on_lane = || {
        let (i, (reached, place)) = center.segments().enumerate().find_map(|(i, (c, d))| Some((i, crossed(c, d)?)))?;
        Some((center.stations()[i] + reached, place))
    };
    let behind = || {
        let (reached, place) = crossed(center.last(), center.last() + center.direction(last) * SLACK)?;
        Some((last + reached, place))
    };
    let (station, place) = before().or_else(on_lane).or_else(behind)?;
    let heading = center.direction(station.clamp(0.0, last));
    let askew = 90.0 - (along.dot(&heading)).abs().clamp(0.0, 1.0).acos().to_degrees();
    Some(StopLineCrossing { lane: 0, station, place, askew, span: span(line, lane, place, along)? })
}

/// Share of the lane, measured along the stop line, that lies abreast of it.
fn span(line: &StopLine, lane: &Lane, place: Point, along: Vector) -> Option<f64> {
    let reach = lane.area / lane.length().max(1.0) * 4.0 + 1.0;
    let bound = |points: &[Point]| {
        let crossed = points
            .windows(2)
            .filter_map(|pair| segment_crossing(place - along * reach, place + along * reach, pair[0], pair[1]));
        let offsets = crossed.map(|(.., at)| (at - place).dot(&along));
        offsets.min_by(|a, b| a.abs().total_cmp(&b.abs()))
    };
    // Just outside of the lane, its edge replaces its bounds.
    let edge = |points: [Point; 2]| points.map(|p| (p - place).dot(&along));
    let near_start = (place - lane.start.middle()).norm() < (place - lane.end.middle()).norm();
    let outside = edge(if near_start { lane.start.points } else { lane.end.points });
    let [left, right] = [bound(&lane.left).unwrap_or(outside[0]), bound(&lane.right).unwrap_or(outside[1])];
    let width = (left - right).abs();
    let own = line.ends.map(|end| (end - place).dot(&along));
    let common = own[0].max(own[1]).min(left.max(right)) - own[0].min(own[1]).max(left.min(right));
    (width > Polyline::MERGE).then(|| (common / width).clamp(0.0, 1.0))
}

/// A stop line is that of lanes whose ends lie this near (m).
const AT_END: f64 = 8.0;

/// The stop line at which vehicles stop on these lanes: across where they start or end, or across the end of lanes that lead to
/// them; the nearest one to that place.
pub fn line_of_lanes(map: &MapIndex, lanes: &[usize]) -> Option<LineStringId> {
    let edges = lanes.iter().flat_map(|&lane| [&map.lanes[lane].start, &map.lanes[lane].end]);
    let corners: Vec<Point> = edges.flat_map(|edge| edge.points).collect();
    let [low, high] = extent(&corners);
    let reach = Vector::repeat(AT_END);
    let near = map.stop_lines_near(low - reach, high + reach).into_iter();
    let gaps = near.filter_map(|line| {
        let across = crossings(map, &line, 0.0).into_iter().filter(|one| one.span > 0.5);
        let gap = across.filter_map(|one| {
            let left = map.lanes[one.lane].length() - one.station;
            let leads = map.followers(one.lane).iter().any(|next| lanes.contains(next));
            let own = lanes.contains(&one.lane).then_some(one.station.min(left).abs());
            own.or(leads.then_some(left.abs()))
        });
        let gap = gap.min_by(f64::total_cmp).filter(|gap| *gap <= AT_END)?;
        Some((gap, line.way))
    });
    gaps.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1))).map(|(_, way)| way)
}

/// The lanes for cars that have to stop at a line: those of an intersection that start there, else those that it crosses.
pub fn lanes_that_stop(map: &MapIndex, way: LineStringId) -> Vec<usize> {
    let Some(line) = map.stop_line(way) else { return Vec::new() };
    let across = crossings(map, &line, 0.0).into_iter().filter(|one| one.span > 0.5);
    let mut lanes: Vec<usize> = across
        .flat_map(|one| {
            let at_end = map.lanes[one.lane].length() - one.station <= AT_END;
            let inside = map.followers(one.lane).iter().copied();
            let inside: Vec<usize> = inside.filter(|&next| at_end && map.movement(next).is_some()).collect();
            if inside.is_empty() { vec![one.lane] } else { inside }
        })
        .collect();
    lanes.sort_unstable();
    lanes.dedup();
    // Those behind it stop there, not the approaches that end at it.
    let inside: Vec<usize> = lanes.iter().copied().filter(|&lane| map.movement(lane).is_some()).collect();
    if inside.is_empty() { lanes } else { inside }
}

/// The stop lines of a map that have a length, in its order.
pub fn stop_lines<'a>(map: &'a MapIndex) -> impl Iterator<Item = StopLine> + 'a {
    let lines = map.map.linestrings.iter().filter(|line| line.attributes.is("type", "stop_line"));
    lines.filter_map(|line| StopLine::of(map, line))
}
