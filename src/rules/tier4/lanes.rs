//! Lanes side by side as the existing validator judges them (vm-01-03, vm-01-04): by what a widened lanelet covers.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::super::crowd;
use super::{Issue, Params, issue, layer};
use crate::diagnostic::Subject;
use crate::geometry::extended::Extended;
use crate::geometry::simple_ring::crosses_itself;
use crate::geometry::{Point as Place, cross, left_of, orientation, overlay, polygon, segment_crossing};
use crate::lanelet::index::extent;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, View, covered_by};
use crate::lanelet::placed::{ExactPlaces, SAME_PLACE};
use crate::lanelet::{Bound, LaneletId, LineStringId};
use crate::parallel::InSmallParts;

/// By this share of its width (1) a lanelet is widened to find what lies beside it.
const WIDENED: f64 = 0.05;

/// `border_sharing`.
pub fn border_sharing(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::AnyLane);
    let rank = layer::ranks(view);
    let most = params.number("iou_threshold");
    let exact = ExactPlaces::default();
    let drawn: Vec<[Vec<Place>; 2]> = view
        .lanelets
        .par_iter()
        .map(|seen| [&seen.left, &seen.right].map(|bound| bound.iter().map(|point| exact.place(point)).collect()))
        .collect();
    let lanes = Lanes { view, graph: &graph, rank: &rank, drawn: &drawn, most };
    let all = (0..view.lanelets.len()).into_par_iter().in_small_parts();
    let covered: Vec<(Vec<usize>, bool)> = all.map(|at| lanes.covered(at)).collect();
    let mut issues = Vec::new();
    for (seen, _) in view.lanelets.iter().zip(&covered).filter(|(_, (_, is_crowded))| *is_crowded) {
        let (id, most) = (seen.id(), crowd::MOST);
        let message = format!("Lanelet {id}: too many lanelets lie in it to compare; the first {most} were.");
        issues.push(issue(2, Subject::Lanelet(id.0), message));
    }
    let of_lane = |(at, (others, _)): (usize, (Vec<usize>, bool))| others.into_iter().map(move |other| (at, other));
    let pairs: Vec<(usize, usize)> = covered.into_iter().enumerate().flat_map(of_lane).collect();
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

/// The lanelets with what decides which of them lie side by side.
struct Lanes<'a, 'v, 'm> {
    view: &'a View<'m>,
    graph: &'a Graph<'v, 'm>,
    /// The order in which they come there.
    rank: &'a [usize],
    /// Their bounds, left and right.
    drawn: &'a [[Vec<Place>; 2]],
    /// Lanelets whose likeness is larger than this lie on each other on purpose.
    most: f64,
}

impl Lanes<'_, '_, '_> {
    /// Unrelated lanelets that have a whole bound inside this lanelet after it is widened, and whether there are more than are compared.
    fn covered(&self, at: usize) -> (Vec<usize>, bool) {
        let (view, seen) = (self.view, &self.view.lanelets[at]);
        let Some(outline) = widened(&self.drawn[at]) else { return (Vec::new(), false) };
        let reach = extent(&outline);
        let ring = polygon::to_geo(&outline);
        // Many lanelets may have one way as bound.
        let mut known: FxHashMap<LineStringId, bool> = FxHashMap::default();
        let mut inside = |other: usize| {
            let lanelet = view.lanelets[other].lanelet;
            let mut bounds = [lanelet.left.line, lanelet.right.line].into_iter().zip(&self.drawn[other]);
            bounds.any(|(way, bound)| {
                let lies_inside = || bound.windows(2).all(|pair| lies_in([pair[0], pair[1]], &outline, &ring));
                *known.entry(way).or_insert_with(lies_inside)
            })
        };
        let strange = |other: usize| {
            let opposite = opposite(seen, &view.lanelets[other]);
            !opposite && !self.graph.linked_to(at, other, self.rank) && {
                let likeness = || likeness(&outline, &view.lanelets[other].outline);
                let meant = self.graph.conflict(at, other) && likeness() > self.most;
                !meant
            }
        };
        let near = view.near(reach, SAME_PLACE).into_iter();
        let covered = near.filter(|&other| other != at && inside(other));
        let covered: Vec<usize> = covered.take(crowd::MOST + 1).collect();
        let is_crowded = covered.len() > crowd::MOST;
        (covered.into_iter().take(crowd::MOST).filter(|&other| strange(other)).collect(), is_crowded)
    }
}

/// Whether a stretch of a bound lies in an outline: it crosses no edge, and between two places where it meets an edge it lies on
/// one side. A stretch that crosses an edge is outside before or behind it, even where an outline crosses itself and both sides
/// are inside.
fn lies_in([a, b]: [Place; 2], outline: &[Place], ring: &geo::Polygon<f64>) -> bool {
    if !covered_by(a, ring) || !covered_by(b, ring) {
        return false;
    }
    let mut cuts = vec![0.0, 1.0];
    for (&c, &d) in outline.iter().zip(outline.iter().cycle().skip(1)) {
        if crosses([a, b], [c, d]) {
            return false;
        }
        cuts.extend(segment_crossing(a, b, c, d).map(|(t, _, _)| t));
    }
    cuts.sort_by(f64::total_cmp);
    cuts.windows(2).all(|cut| covered_by(a + (b - a) * f64::midpoint(cut[0], cut[1]), ring))
}

/// Whether each of two segments has its ends on both sides of the other.
fn crosses([a, b]: [Place; 2], [c, d]: [Place; 2]) -> bool {
    orientation(a, b, c) * orientation(a, b, d) < 0.0 && orientation(c, d, a) * orientation(c, d, b) < 0.0
}

/// Whether two lanelets have a bound in common that they use in opposite directions.
fn opposite(a: &Seen, b: &Seen) -> bool {
    let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
    a.lanelet.left == turned(b.lanelet.left) || a.lanelet.right == turned(b.lanelet.right)
}

/// What two outlines have in common, as a share of what either covers. An outline that runs counter-clockwise covers less than nothing.
fn likeness(a: &[Place], b: &[Place]) -> f64 {
    let [own, other] = [a, b].map(|outline| -polygon::signed_area(outline));
    let plain = own >= 0.0 && other >= 0.0 && !crosses_itself(a) && !crosses_itself(b);
    let common = if plain { polygon::overlap_by_winding(a, b) } else { overlay::common_area(a, b) };
    common / (own + other - common)
}

/// The outline of a lanelet moved outward by a share of its width, at the ends as well as at the sides.
fn widened([left, right]: &[Vec<Place>; 2]) -> Option<Vec<Place>> {
    let [start, end] = [left.first()? - right.first()?, left.last()? - right.last()?];
    let by = (start.norm() + end.norm()) / 2.0 * WIDENED;
    let right: Vec<Place> = right.iter().rev().copied().collect();
    Some(pushed(left, by)?.into_iter().chain(pushed(&right, by)?).collect())
}

/// A bound with each vertex moved to the left, and made longer at both ends.
///
/// A vertex moves at right angles to one of the segments that meet in it, not halfway between them. Which one that is
/// hangs on the last digits of its station, which is why stations are summed and scaled here as they are there: lengths of lines have
/// more digits than stations.
fn pushed(line: &[Place], by: f64) -> Option<Vec<Place>> {
    if line.len() < 2 {
        return None;
    }
    let lengths: Vec<f64> = line.windows(2).map(|pair| (pair[1] - pair[0]).norm()).collect();
    let total = lengths.iter().fold(Extended::ZERO, |sum, &length| sum + Extended::from(length));
    let mut ends = Vec::with_capacity(lengths.len());
    let mut sum = 0.0;
    for &length in &lengths {
        sum += f64::from(Extended::from(length).over(total)?);
        ends.push(Extended::from(sum) * total);
    }
    let (first, last) = (*line.first()?, *line.last()?);
    let direction = |from: Place, to: Place| (to - from).try_normalize(0.0).unwrap_or_default();
    let moved = line.iter().map(|&p| {
        let (station, aside) = station(line, &lengths, p);
        let at = ends.iter().position(|&end| end > Extended::from(station)).unwrap_or(lengths.len() - 1);
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
    Some(moved.collect())
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
