//! Lanes side by side as the existing validator judges them (vm-01-03, vm-01-04): by what a widened lanelet covers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{Issue, Params, issue, layer};
use crate::diagnostic::Subject;
use crate::geometry::{Point as Place, cross, left_of, polygon, segment_crossing};
use crate::lanelet::index::extent;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, View, covered_by};
use crate::lanelet::{Bound, LaneletId, Point};
use crate::parallel::Finely;

/// By this share of its width (1) a lanelet is widened to find what lies beside it.
const WIDENED: f64 = 0.05;

/// `border_sharing`.
pub fn border_sharing(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::AnyLane);
    let rank = layer::ranks(view);
    let most = params.number("iou_threshold");
    let pairs: Vec<(usize, usize)> = (0..view.lanelets.len())
        .into_par_iter()
        .finely()
        .flat_map_iter(|at| covered(view, &graph, most, at, &rank).into_iter().map(move |other| (at, other)))
        .collect();
    let mut issues = Vec::new();
    let mut one_way: BTreeMap<usize, Vec<LaneletId>> = BTreeMap::new();
    for &(at, other) in &pairs {
        let (id, name) = (view.lanelets[at].id(), view.lanelets[other].id());
        if pairs.binary_search(&(other, at)).is_ok() {
            let message = format!("Lanelets {id} and {name} lie side by side but have borders of their own.");
            issues.push(issue(1, Subject::Lanelet(id.0), message));
        } else {
            one_way.entry(at).or_default().push(name);
        }
    }
    issues.extend(one_way.into_iter().map(|(at, others)| partly(&view.lanelets[at], others)));
    issues
}

fn partly(seen: &Seen, mut others: Vec<LaneletId>) -> Issue {
    others.sort_unstable();
    let names: Vec<String> = others.iter().map(ToString::to_string).collect();
    let id = seen.id();
    let message = format!("Lanelet {id} lies beside {} but is divided elsewhere.", names.join(" "));
    issue(2, Subject::Lanelet(id.0), message)
}

/// Lanelets that have nothing to do with one, but of which a whole bound lies in it, were it a little wider.
fn covered(view: &View, graph: &Graph, most: f64, at: usize, rank: &[usize]) -> Vec<usize> {
    let seen = &view.lanelets[at];
    let Some(outline) = widened(seen) else { return Vec::new() };
    let reach = extent(&outline);
    let ring = polygon::to_geo(&outline);
    let holds = |points: &[&Point]| points.windows(2).all(|pair| lies_in(pair, &outline, &ring));
    let inside = |other: &Seen| holds(&other.left) || holds(&other.right);
    let strange = |other: usize| {
        let opposite = opposite(seen, &view.lanelets[other]);
        !opposite && !graph.linked_to(at, other, rank) && {
            let meant = graph.conflict(at, other) && likeness(&outline, &view.lanelets[other].outline) > most;
            !meant
        }
    };
    let near = view.near(reach, 0.0).into_iter();
    near.filter(|&other| other != at && inside(&view.lanelets[other]) && strange(other)).collect()
}

/// Whether a stretch of a bound lies in an outline: between two places where it meets an edge it lies on one side.
fn lies_in(pair: &[&Point], outline: &[Place], ring: &geo::Polygon<f64>) -> bool {
    let [a, b] = [pair[0].position, pair[1].position];
    if !covered_by(a, ring) || !covered_by(b, ring) {
        return false;
    }
    let edges = outline.iter().zip(outline.iter().cycle().skip(1));
    let cuts = edges.filter_map(|(&c, &d)| segment_crossing(a, b, c, d)).map(|(t, _, _)| t);
    let mut cuts: Vec<f64> = cuts.chain([0.0, 1.0]).collect();
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2).all(|cut| covered_by(a + (b - a) * f64::midpoint(cut[0], cut[1]), ring))
}

/// Whether two lanelets have a bound in common that they use in opposite directions.
fn opposite(a: &Seen, b: &Seen) -> bool {
    let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
    a.lanelet.left == turned(b.lanelet.left) || a.lanelet.right == turned(b.lanelet.right)
}

/// What two outlines have in common, as a share of what either covers.
fn likeness(a: &[Place], b: &[Place]) -> f64 {
    let [own, other] = [a, b].map(|outline| polygon::signed_area(outline).abs());
    let common = polygon::overlap(a, b);
    common / (own + other - common)
}

/// The outline of a lanelet moved outward by a share of its width, at the ends as well as at the sides.
fn widened(seen: &Seen) -> Option<Vec<Place>> {
    let width = |[a, b]: [&Point; 2]| (a.position - b.position).norm();
    let [start, end] = seen.ends()?;
    let by = (width(start) + width(end)) / 2.0 * WIDENED;
    let places = |points: &[&Point]| points.iter().map(|point| point.position).collect::<Vec<_>>();
    let (left, mut right) = (places(&seen.left), places(&seen.right));
    right.reverse();
    Some(pushed(&left, by)?.into_iter().chain(pushed(&right, by)?).collect())
}

/// A bound with each vertex moved to the left, and made longer at both ends.
///
/// A vertex moves at right angles to one of the segments that meet in it, not halfway between them. Which one that is
/// hangs on the last digits of its station, which is why stations are summed and scaled here as they are there.
fn pushed(line: &[Place], by: f64) -> Option<Vec<Place>> {
    let lengths: Vec<f64> = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
    let total: f64 = lengths.iter().sum();
    let mut sum = 0.0;
    let shares = lengths.iter().map(|length| {
        sum += length / total;
        sum
    });
    let ends: Vec<f64> = if lengths.len() == 1 { vec![total] } else { shares.map(|share| share * total).collect() };
    let (first, last) = (*line.first()?, *line.last()?);
    let direction = |from: Place, to: Place| (to - from).try_normalize(0.0).unwrap_or_default();
    let moved = line.iter().map(|&p| {
        let (station, aside) = station(line, &lengths, p);
        let at = ends.iter().position(|&end| end > station).unwrap_or(lengths.len() - 1);
        let across = left_of(line[at + 1] - line[at]).try_normalize(0.0).unwrap_or_default();
        let mut place = at_station(line, &lengths, station) + across * (aside + by);
        if p == first {
            place += direction(line[1], line[0]) * by;
        }
        if p == last {
            place += direction(line[line.len() - 2], line[line.len() - 1]) * by;
        }
        place
    });
    (line.len() > 1 && total > 0.0).then(|| moved.collect())
}

/// How far along a line one of its own vertices lies, and how far to the left: next to nothing.
fn station(line: &[Place], lengths: &[f64], p: Place) -> (f64, f64) {
    let mut nearest = (f64::INFINITY, 0, p);
    for (at, pair) in line.windows(2).enumerate() {
        let (along, to) = (pair[1] - pair[0], p - pair[0]);
        let (part, whole) = (to.dot(&along), along.dot(&along));
        let foot = match part {
            _ if part <= 0.0 => pair[0],
            _ if whole <= part => pair[1],
            _ => Place::from(along * (part / whole) + pair[0].coords),
        };
        let far = (foot - p).norm();
        if far < nearest.0 {
            nearest = (far, at, foot);
        }
        if far == 0.0 {
            break;
        }
    }
    let (far, at, foot) = nearest;
    // A segment is known again by where it starts.
    let at = line.iter().position(|start| *start == line[at]).unwrap_or(at);
    let before: f64 = lengths[..at].iter().sum();
    let left = cross(line[at + 1] - line[at], p - line[at]) > 0.0;
    (before + (foot - line[at]).norm(), if left { far } else { -far })
}

fn at_station(line: &[Place], lengths: &[f64], station: f64) -> Place {
    let mut passed = 0.0;
    for (at, length) in lengths.iter().enumerate() {
        passed += length;
        if passed >= station {
            let left = station - (passed - length);
            return if left < 1e-8 { line[at] } else { line[at] + (line[at + 1] - line[at]) * (left / length) };
        }
    }
    line[line.len() - 1]
}
