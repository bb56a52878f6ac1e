//! Sections of virtual traffic lights as the existing validator judges them: the order of their lines along the way
//! (vm-03-16), and two sections on one way (vm-03-18).

use super::{Issue, Params, issue};
use crate::diagnostic::Subject;
use crate::geometry::{Point as Place, Polyline, polygon};
use crate::lanelet::index::extent;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, Spot, View, boxes_meet, covered_by, spot};
use crate::lanelet::{LineString, RegulatoryElement};

/// A start line farther than this (m, in space) from every lanelet lies on none.
const ON_LANELET: f64 = 1.0;
/// Least share (1) of the stop line that has to lie on the way.
const ON_WAY: f64 = 0.1;
/// Places closer than this (m) to an outline lie on it.
const TOUCH: f64 = 1e-6;

fn about(light: &RegulatoryElement) -> Subject {
    Subject::RegulatoryElement(light.id.0)
}

/// Share (1) of a line that lies inside an outline or on it.
fn share_inside(line: &[Place], outline: &[Place]) -> f64 {
    let ring = polygon::to_geo(outline);
    let edges = || outline.iter().zip(outline.iter().cycle().skip(1));
    let (mut inside, mut whole) = (0.0, 0.0);
    for pair in line.windows(2) {
        let (a, along) = (pair[0], pair[1] - pair[0]);
        whole += along.norm();
        let mut cuts: Vec<f64> = edges()
            .filter_map(|(c, d)| crate::geometry::segment_crossing(a, pair[1], *c, *d))
            .map(|(t, _, _)| t)
            .chain([0.0, 1.0])
            .collect();
        cuts.sort_by(f64::total_cmp);
        for piece in cuts.windows(2) {
            let middle = a + along * f64::midpoint(piece[0], piece[1]);
            let on_edge = || edges().any(|(c, d)| distance(middle, *c, *d) < TOUCH);
            if covered_by(middle, &ring) || on_edge() {
                inside += along.norm() * (piece[1] - piece[0]);
            }
        }
    }
    if whole > 0.0 { inside / whole } else { 0.0 }
}

fn distance(p: Place, a: Place, b: Place) -> f64 {
    Polyline::new([a, b]).map_or((p - a).norm(), |line| line.distance(p))
}

/// Whether a line meets an outline, even if only in a point.
fn touches(line: &[Place], outline: &[Place]) -> bool {
    let ring = polygon::to_geo(outline);
    let crosses = |a: Place, b: Place| {
        let mut edges = outline.iter().zip(outline.iter().cycle().skip(1));
        edges.any(|(c, d)| crate::geometry::segment_crossing(a, b, *c, *d).is_some())
    };
    line.iter().any(|&p| covered_by(p, &ring)) || line.windows(2).any(|pair| crosses(pair[0], pair[1]))
}

/// The place on a line in space that is nearest to another.
fn nearest(line: &[Spot], p: Spot) -> Option<Spot> {
    let on = |pair: &[Spot]| {
        let along = pair[1] - pair[0];
        let square = along.norm_squared();
        let t = if square > 0.0 { ((p - pair[0]).dot(&along) / square).clamp(0.0, 1.0) } else { 0.0 };
        pair[0] + along * t
    };
    let far = |q: &Spot| (p - q).norm();
    line.windows(2).map(on).min_by(|a, b| far(a).total_cmp(&far(b)))
}

/// Distance in space of a place from a lanelet: from the line across it, abreast of the place.
fn distance_in_space(seen: &Seen, p: Spot) -> Option<f64> {
    let bound = |points: &[&crate::lanelet::Point]| points.iter().map(|point| spot(point)).collect::<Vec<_>>();
    let across = [nearest(&bound(&seen.left), p)?, nearest(&bound(&seen.right), p)?];
    Some((nearest(&across, p)? - p).norm())
}

/// The lanelet on which a start line lies: the one that holds the largest part of it.
fn start_lanelet(view: &View, start: &LineString) -> Option<usize> {
    let points = view.points(start);
    let middle = nalgebra::center(&spot(points.first()?), &spot(points.last()?));
    let place = Place::new(middle.x, middle.y);
    let places = view.places(start);
    let near = view.near([place, place], ON_LANELET).into_iter();
    let held = near
        .filter(|&at| distance_in_space(&view.lanelets[at], middle).is_some_and(|found| found <= ON_LANELET))
        .map(|at| (at, share_inside(&places, &view.lanelets[at].outline)))
        .filter(|&(_, share)| share > 0.0);
    // Of equal shares the first lanelet has it.
    held.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(at, _)| at)
}

/// Whether the first thing that a light refers to is one that is asked for.
fn is_target(view: &View, light: &RegulatoryElement, targets: &[String]) -> bool {
    let first = view.lines(light, "refers").next();
    first.and_then(|line| line.attributes.get("type")).is_some_and(|kind| targets.iter().any(|one| one == kind))
}

/// `virtual_traffic_light_line_order`.
pub fn line_order(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let targets = params.words("validation_target_refers");
    let lights = view.elements("virtual_traffic_light").filter(|light| is_target(view, light, &targets));
    lights.flat_map(|light| order(view, &graph, light)).collect()
}

fn order(view: &View, graph: &Graph, light: &RegulatoryElement) -> Vec<Issue> {
    let id = light.id;
    let (Some(start), Some(stop)) = (view.lines(light, "start_line").next(), view.lines(light, "ref_line").next())
    else {
        return Vec::new();
    };
    let start_subject = Subject::LineString(start.id.0);
    let Some(from) = start_lanelet(view, start) else {
        let message = format!("start_line {} of virtual_traffic_light {id} lies on no lanelet.", start.id);
        return vec![issue(1, start_subject, message)];
    };
    let mut issues = Vec::new();
    let mut pairs: Vec<(&LineString, usize)> = Vec::new();
    for &at in view.referrers(id) {
        let seen = &view.lanelets[at];
        let ends = view.lines(light, "end_line").map(|end| (end, share_inside(&view.places(end), &seen.outline)));
        match ends.filter(|(_, share)| *share > 0.0).reduce(|best, next| if next.1 > best.1 { next } else { best }) {
            Some((end, _)) => pairs.push((end, at)),
            None => {
                let message = format!("virtual_traffic_light {id} has no end_line on lanelet {}.", seen.id());
                issues.push(issue(2, about(light), message));
            }
        }
    }
    let start_places = view.places(start);
    if pairs.iter().any(|&(_, at)| touches(&start_places, &view.lanelets[at].outline)) {
        let message =
            format!("start_line {} of virtual_traffic_light {id} touches a lanelet behind the stop line.", start.id);
        issues.push(issue(3, start_subject, message));
        return issues;
    }
    issues.extend(pairs.into_iter().flat_map(|(end, to)| along_way(view, graph, light, [start, stop, end], from, to)));
    issues
}

/// The lines of one section along its way.
fn along_way(
    view: &View,
    graph: &Graph,
    light: &RegulatoryElement,
    lines: [&LineString; 3],
    from: usize,
    to: usize,
) -> Vec<Issue> {
    let (id, [_, stop, end]) = (light.id, lines);
    let Some(path) = graph.path(from, to) else {
        let message =
            format!("No way leads from the start_line of virtual_traffic_light {id} to its end_line {}.", end.id);
        return vec![issue(4, about(light), message)];
    };
    let Some(way) = Way::along(view, &path) else { return Vec::new() };
    let mut issues = Vec::new();
    if share_inside(&view.places(stop), &way.outline()) < ON_WAY {
        let message =
            format!("ref_line {} of virtual_traffic_light {id} does not lie on the way to {}.", stop.id, end.id);
        issues.push(issue(5, Subject::LineString(stop.id.0), message));
    }
    let stations = lines.map(|line| way.stations(&view.places(line)));
    let [Some(first), Some(second), Some(third)] = stations else { return issues };
    let ordered = (0..2).all(|side| first[side] < second[side] && second[side] < third[side]);
    if !ordered {
        let message = format!(
            "On the way to {} the lines of virtual_traffic_light {id} do not stand in the order start, stop, end.",
            end.id
        );
        issues.push(issue(6, about(light), message));
    }
    issues
}

/// The bounds of lanelets that follow each other, joined.
struct Way {
    left: Polyline,
    right: Polyline,
}

impl Way {
    fn along(view: &View, path: &[usize]) -> Option<Self> {
        let joined =
            |side: fn(&Seen) -> Vec<Place>| Polyline::new(path.iter().flat_map(|&at| side(&view.lanelets[at])));
        Some(Self {
            left: joined(|seen| seen.left.iter().map(|point| point.position).collect())?,
            right: joined(|seen| seen.right.iter().map(|point| point.position).collect())?,
        })
    }

    fn outline(&self) -> Vec<Place> {
        self.left.points().iter().chain(self.right.points().iter().rev()).copied().collect()
    }

    /// How far along the left bound a line's left end lies, and along the right bound its right end.
    fn stations(&self, line: &[Place]) -> Option<[f64; 2]> {
        let (mut left, mut right) = (*line.first()?, *line.last()?);
        if self.left.distance(right) < self.left.distance(left) {
            std::mem::swap(&mut left, &mut right);
        }
        Some([self.left.project(left).station, self.right.project(right).station])
    }
}

/// A section: the way from the lanelet of the start line to a lanelet that refers to the light.
struct LightSection<'m> {
    light: &'m RegulatoryElement,
    path: Vec<usize>,
}

/// `virtual_traffic_light_section_overlap`: of the first light of each lanelet.
pub fn section_overlap(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::Car);
    let targets = params.words("validation_target_refers");
    let section = |at: usize, light| {
        let start = view.lines(light, "start_line").next()?;
        let path = graph.path(start_lanelet(view, start)?, at)?;
        Some(LightSection { light, path })
    };
    let lights = |at: usize| view.elements_of(&view.lanelets[at], "virtual_traffic_light").next();
    let sections: Vec<LightSection> = (0..view.lanelets.len()).filter_map(|at| section(at, lights(at)?)).collect();
    let boxes: Vec<[Place; 2]> = sections.iter().map(|section| box_of(view, &section.path)).collect();
    let mut issues: Vec<Issue> = Vec::new();
    for (own, reach) in sections.iter().zip(&boxes) {
        let mut said: Vec<i64> = Vec::new();
        for other in &sections {
            let id = other.light.id.0;
            let last = other.path.last().map(|&at| view.lanelets[at].extent);
            let near = last.is_some_and(|last| boxes_meet(last, *reach));
            let met = own.light.id != other.light.id && near && is_target(view, other.light, &targets);
            if met && !said.contains(&id) && overlap(view, own, other) {
                said.push(id);
                let message =
                    format!("The sections of virtual_traffic_light {} and {id} overlap on one way.", own.light.id);
                issues.push(issue(1, about(own.light), message));
            }
        }
    }
    issues
}

fn box_of(view: &View, path: &[usize]) -> [Place; 2] {
    let corners: Vec<Place> = path.iter().flat_map(|&at| view.lanelets[at].extent).collect();
    extent(&corners)
}

/// Whether two sections share more of a way than they may.
fn overlap(view: &View, own: &LightSection, other: &LightSection) -> bool {
    match common(&own.path, &other.path)[..] {
        [] => false,
        [at] => meet_on(view, at, own, other),
        _ => true,
    }
}

/// What two ways have in common, if one holds the other or ends where the other begins.
fn common(a: &[usize], b: &[usize]) -> Vec<usize> {
    let holds =
        |long: &[usize], short: &[usize]| !short.is_empty() && long.windows(short.len()).any(|part| part == short);
    if holds(a, b) {
        return b.to_vec();
    }
    if holds(b, a) {
        return a.to_vec();
    }
    let tail_meets_head = |a: &[usize], b: &[usize]| {
        (1..=a.len().min(b.len()))
            .rev()
            .find(|&count| a[a.len() - count..] == b[..count])
            .map(|count| b[..count].to_vec())
    };
    tail_meets_head(a, b).or_else(|| tail_meets_head(b, a)).unwrap_or_default()
}

/// Whether, on the one lanelet that two sections share, one begins before the other ends.
fn meet_on(view: &View, at: usize, own: &LightSection, other: &LightSection) -> bool {
    let Some(lane) = Way::along(view, &[at]) else { return false };
    let (first, second) = if own.path.last() == Some(&at) { (own, other) } else { (other, own) };
    let seen = &view.lanelets[at];
    let ends = view.lines(first.light, "end_line").map(|end| (end, share_inside(&view.places(end), &seen.outline)));
    let end = ends.reduce(|best, next| if next.1 > best.1 { next } else { best }).map(|(end, _)| end);
    let start = view.lines(second.light, "start_line").next();
    let station = |line: Option<&LineString>| lane.stations(&view.places(line?));
    let (Some(end), Some(start)) = (station(end), station(start)) else { return false };
    (0..2).any(|side| end[side] > start[side])
}
