//! The last stretch before a stop line, on which lanes are not changed any more: the lines between them are solid there.
//!
//! A bound is one line with one marking. Where it changes, the road is cut across, all its lanes and what lies beside them
//! abreast: neighbours share their bounds on both sides of the cut, and what continues each other its end nodes. The rest
//! of the road keeps its ids.

#[cfg(test)]
mod tests;

use crate::geometry::{Point, Vector, cross};
use crate::lanelet::{Attributes, Bound, LineStringId, PointId};

use super::assembly::Assembly;
use super::beside::runs;
use super::connection::{ConnectionLines, at_depth, side};
use super::control::{Control, sign_at};
use super::draft::Ways;
use super::heights::Ground;
use super::lanes::{Arm, Lane, Lanes, road_key};
use super::marking::before_stop;
use super::road_network::{End, Intersection, Road, RoadEnd, RoadIx, RoadNetwork};
use super::sound::{aligned, simple, sound};

/// Length of the stretch, metres, where nobody says otherwise: so far before an intersection Japan's Road Traffic Act,
/// article 30, forbids to overtake, and about so far (100 ft) before lights many agencies paint solid lines.
const USUAL: f64 = 30.0;
/// Where the lines between lanes of one direction are dashed up to the stop line.
const DASHED: [&str; 1] = ["GB"];
/// Where there is only room for less than this, metres, there is none: two cars wait on as much.
const LEAST: f64 = 10.0;
/// No cut comes closer than this, metres, to another point of a border.
const CLEAR: f64 = 0.5;
/// A cut that cannot lie where it should is moved by this, metres, toward the stop line,
const STEP: f64 = 0.5;
/// at most so many times.
const STEPS: usize = 20;
/// A border crosses the cut no farther than this, metres, from where the cross-section has it.
const ASIDE: f64 = 1.0;

/// What is cut off a road before one of its ends.
struct Stretch {
    at: RoadEnd,
    /// By edges of the cross-section, along the road's line.
    borders: Vec<Option<Bound>>,
    /// A piece of each lane of the road, in their order.
    lanes: Vec<Lane>,
}

/// Where a cut meets each border, by edges of the cross-section: behind which of its points, and the place.
type Cut = Vec<Option<(usize, Point)>>;

/// Edges of a road's cross-section with what is painted there before the stop line.
type Painted = Vec<(usize, Attributes)>;

/// Cuts the roads before all stop lines where that changes what is painted.
pub fn cut_off(
    assembly: &mut Assembly,
    network: &RoadNetwork,
    lines: &ConnectionLines,
    ways: &[Option<Ways>],
    lanes: &mut Lanes,
) {
    let usual = || if network.country.as_deref().is_some_and(|it| DASHED.contains(&it)) { 0.0 } else { USUAL };
    let wanted = network.markings.before_stop.unwrap_or_else(usual);
    let mut found: Vec<Stretch> = Vec::new();
    for (at, painted) in approaches(network, ways, lanes) {
        let road = network.road(at.road);
        // A road may be cut before both of its ends: what was drawn last is what is cut.
        let borders = lanes.borders_of(at.road);
        let [from, to] = lines.kept[at.road.0 as usize];
        let most = wanted.min((to - from) / 2.0);
        let depths = (0..STEPS).map(|i| most - i as f64 * STEP).take_while(|&depth| depth >= LEAST.min(wanted));
        let stations = depths.filter(|depth| *depth > 0.0).map(|depth| at_depth([from, to], at.end, depth));
        if let Some(cut) = stations.filter_map(|station| cut(assembly, road, borders, station)).next() {
            assembly.stand_on(Ground::under(road));
            found.push(stretch(assembly, road, at, (borders, lanes.of_road(at.road)), &cut, &painted));
        }
    }
    assembly.stand_on(Ground::default());
    lanes.take_in(found);
}

/// The ends of roads with a stop line before which other lines are painted, in order.
fn approaches(network: &RoadNetwork, ways: &[Option<Ways>], lanes: &Lanes) -> Vec<(RoadEnd, Painted)> {
    let mut found = Vec::new();
    for (intersection, ways) in network.intersections.iter().zip(ways) {
        let Some(ways) = ways.as_ref().filter(|ways| ways.area.is_some()) else { continue };
        for (i, &at) in
            intersection.arms.iter().enumerate().filter(|(_, at)| has_stop_line(network, intersection, **at))
        {
            let leads_on = |lane: usize| {
                ways.drawn.paths.iter().any(|path| (path.movement.from, path.movement.in_lane) == (i, lane))
            };
            let painted = painted(network.road(at.road), lanes, lanes.arm(at), leads_on);
            if !painted.is_empty() {
                found.push((at, painted));
            }
        }
    }
    found.sort_by_key(|(at, _)| *at);
    found
}

/// Whether vehicles stop at a line where a road ends at an intersection.
fn has_stop_line(network: &RoadNetwork, intersection: &Intersection, at: RoadEnd) -> bool {
    let signed = || sign_at(network.road(at.road), at.end) == Control::Stop;
    intersection.signals || intersection.all_way_stop || signed()
}

/// What is painted between the lanes of an approach. Who came to a lane that does not lead on may leave it to the last.
fn painted(road: &Road, lanes: &Lanes, arm: &Arm, leads_on: impl Fn(usize) -> bool) -> Painted {
    let strip = |lane: usize| lanes.lanes[arm.into[lane].lane].strip;
    let pairs = (1..arm.into.len()).filter(|&lane| leads_on(lane - 1) && leads_on(lane));
    let edges = pairs.filter_map(|lane| {
        let (a, b) = (strip(lane - 1), strip(lane));
        (a.abs_diff(b) == 1).then_some(a.max(b))
    });
    let borders = lanes.borders_of(arm.at.road);
    let inverted = |edge: usize| borders[edge].map(|border| border.inverted);
    edges.filter_map(|edge| Some((edge, before_stop(&road.section, edge, &road.tags, inverted(edge)?)?))).collect()
}

/// Where the borders of a road are cut across at a station; `None` if they cannot be.
fn cut(assembly: &Assembly, road: &Road, borders: &[Option<Bound>], station: f64) -> Option<Cut> {
    let (middle, along) = (road.line.at(station), road.line.direction(station));
    let lines: Vec<Option<Vec<Point>>> = borders.iter().map(|it| it.map(|it| assembly.bound_line(it))).collect();
    let mut cut: Cut = Vec::with_capacity(lines.len());
    for (edge, line) in lines.iter().enumerate() {
        let wanted = middle + crate::geometry::left_of(along) * road.section.edge(edge);
        cut.push(match line {
            Some(line) => Some(crossing(line, wanted, along)?),
            None => None,
        });
    }
    let pair = |[a, b]: [usize; 2]| -> Option<[[Vec<Point>; 2]; 3]> {
        let (whole, at) = ([lines[a].clone()?, lines[b].clone()?], [cut[a]?, cut[b]?]);
        let parts = [0, 1].map(|i| halves(&whole[i], at[i]));
        let [[a, b], [c, d]] = parts;
        Some([whole, [a, c], [b, d]])
    };
    let mut lanes = road.section.driven().filter_map(|(i, _)| pair([i, i + 1]));
    let read_as_drawn = |it: &[Vec<Point>; 2]| simple(it) && aligned(it) && aligned(&turned(it));
    let width = |strips: std::ops::Range<usize>| road.section.strips[strips].iter().map(|s| s.width).sum::<f64>();
    let beside = runs(&road.section).into_iter();
    let mut beside = beside.filter_map(|run| Some((pair([run.strips.start, run.strips.end])?, width(run.strips))));
    let whole = lanes.all(|[_, a, b]| read_as_drawn(&a) && read_as_drawn(&b))
        && beside.all(|([whole, a, b], width)| !sound(&whole, width) || sound(&a, width) && sound(&b, width));
    whole.then_some(cut)
}

/// The same lane, run through the other way.
fn turned([left, right]: &[Vec<Point>; 2]) -> [Vec<Point>; 2] {
    [right, left].map(|line| line.iter().rev().copied().collect())
}

/// Where a line crosses the cut through a place, nearest to that place: behind which of its points. `None` where it does
/// not, or close to a point.
fn crossing(line: &[Point], wanted: Point, along: Vector) -> Option<(usize, Point)> {
    let across = |(i, pair): (usize, &[Point])| {
        let [before, behind] = [0, 1].map(|i| (pair[i] - wanted).dot(&along));
        (before < 0.0 && behind >= 0.0).then(|| (i, pair[0] + (pair[1] - pair[0]) * (before / (before - behind))))
    };
    let off = |(_, place): &(usize, Point)| cross(along, place - wanted).abs();
    let nearest = line.windows(2).enumerate().filter_map(across).min_by(|a, b| off(a).total_cmp(&off(b)));
    let (i, place) = nearest.filter(|found| off(found) <= ASIDE)?;
    [line[i], line[i + 1]].iter().all(|point| (point - place).norm() >= CLEAR).then_some((i, place))
}

/// A line before and behind a cut.
fn halves(line: &[Point], (i, place): (usize, Point)) -> [Vec<Point>; 2] {
    let before = line[..=i].iter().copied().chain([place]);
    let behind = [place].into_iter().chain(line[i + 1..].iter().copied());
    [before.collect(), behind.collect()]
}

/// Cuts the borders of a road, and makes lanes of what lies before one of its ends.
fn stretch(
    assembly: &mut Assembly,
    road: &Road,
    at: RoadEnd,
    (borders, lanes): (&[Option<Bound>], &[Lane]),
    cut: &Cut,
    painted: &Painted,
) -> Stretch {
    let mut lines: Vec<(LineStringId, LineStringId)> = Vec::new();
    let mut cut_off = Vec::with_capacity(borders.len());
    for (edge, (border, place)) in borders.iter().zip(cut).enumerate() {
        let line = border.zip(*place).map(|(border, place)| {
            let marking = painted.iter().find(|(of, _)| *of == edge).map(|(_, marking)| marking);
            let line = border_before(assembly, road, at.end, (edge, border), place, marking);
            lines.push((border.line, line));
            Bound { line, ..border }
        });
        cut_off.push(line);
    }
    let beyond = |bound: Bound| {
        let line = lines.iter().find(|(rest, _)| *rest == bound.line).map_or(bound.line, |(_, line)| *line);
        Bound { line, ..bound }
    };
    let key = road_key("lane before stop", road).number(side(at.end) as i64);
    let piece = |lane: &Lane| {
        let (left, right) = (beyond(lane.left), beyond(lane.right));
        let attributes = assembly.lanelet_of(lane.lanelet).map(|it| it.attributes.clone()).unwrap_or_default();
        let key = key.number(lane.strip as i64).number(i64::from(lane.backward));
        Lane { lanelet: assembly.lanelet(key, left, right, attributes), left, right, ..lane.clone() }
    };
    Stretch { at, borders: cut_off, lanes: lanes.iter().map(piece).collect() }
}

/// Shortens a border to the rest of its road, and draws the part before an end anew, painted as it was or as told.
fn border_before(
    assembly: &mut Assembly,
    road: &Road,
    end: End,
    (edge, border): (usize, Bound),
    (i, place): (usize, Point),
    marking: Option<&Attributes>,
) -> LineStringId {
    let key = road_key("border before stop", road).number(side(end) as i64).number(edge as i64);
    let ids = assembly.bound_ids(border);
    let node = assembly.point(key.word("cut"), place, 0.0);
    let before = ids[..=i].iter().copied().chain([node]).collect();
    let behind = [node].into_iter().chain(ids[i + 1..].iter().copied()).collect();
    let [rest, part]: [Vec<PointId>; 2] = if end == End::End { [before, behind] } else { [behind, before] };
    let own = |mut points: Vec<PointId>| {
        if border.inverted {
            points.reverse();
        }
        points
    };
    let attributes = marking.or_else(|| Some(&assembly.line_of(border.line)?.attributes)).cloned().unwrap_or_default();
    assembly.reshape_line(border.line, own(rest));
    assembly.line(key, own(part), attributes)
}

impl Lanes {
    /// Takes in what was cut off the ends of roads, in the order of these ends.
    fn take_in(&mut self, found: Vec<Stretch>) {
        let mut known = std::mem::take(&mut self.lanes).into_iter().peekable();
        let mut found = found.into_iter().peekable();
        let mut first = 0;
        for (i, arms) in self.arms.iter_mut().enumerate() {
            let road = RoadIx(i as u32);
            let mut begin = [self.lanes.len(); 2];
            while let Some(lane) = known.next_if(|lane| lane.road == road) {
                self.lanes.push(lane);
            }
            let count = self.lanes.len() - begin[0];
            while let Some(stretch) = found.next_if(|stretch| stretch.at.road == road) {
                begin[side(stretch.at.end)] = self.lanes.len();
                self.lanes.extend(stretch.lanes);
                self.before_stop.insert(stretch.at, stretch.borders);
            }
            for (arm, begin) in arms.iter_mut().zip(begin) {
                arm.into.iter_mut().chain(&mut arm.out).for_each(|end| end.lane = end.lane - first + begin);
            }
            first += count;
        }
    }
}
