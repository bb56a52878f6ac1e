//! Lanes side by side as the existing validator judges them (vm-01-03, vm-01-04): by what a widened lanelet covers.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::{Issue, Params, issue};
use crate::diagnostic::Subject;
use crate::geometry::{Point as Place, Polyline, Vector, left_of, polygon};
use crate::lanelet::index::extent;
use crate::lanelet::index::view::{Seen, View, boxes_meet, covered_by};
use crate::lanelet::{LaneletId, Point};
use crate::parallel::Finely;
use crate::rules::graph::{Graph, Rules};

/// By this share of its width (1) a lanelet is widened to find what lies beside it.
const WIDENED: f64 = 0.05;

/// `border_sharing`.
pub fn border_sharing(view: &View, params: &Params) -> Vec<Issue> {
    let graph = Graph::new(view, Rules::AnyLane);
    let most = params.number("iou_threshold");
    let pairs: Vec<(usize, usize)> = (0..view.lanelets.len())
        .into_par_iter()
        .finely()
        .flat_map_iter(|at| covered(view, &graph, most, at).into_iter().map(move |other| (at, other)))
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
fn covered(view: &View, graph: &Graph, most: f64, at: usize) -> Vec<usize> {
    let seen = &view.lanelets[at];
    let Some(outline) = widened(seen) else { return Vec::new() };
    let reach = extent(&outline);
    let ring = polygon::to_geo(&outline);
    // Vertices and the middles between them: a widened outline may cross itself, which a test of whole lines would not bear.
    let holds = |points: &[&Point]| {
        let middles = points.windows(2).map(|pair| nalgebra::center(&pair[0].position, &pair[1].position));
        points.iter().map(|point| point.position).chain(middles).all(|p| covered_by(p, &ring))
    };
    let inside = |other: &Seen| boxes_meet(other.extent, reach) && (holds(&other.left) || holds(&other.right));
    let near = view.near(reach, 0.0).into_iter();
    near.filter(|&other| other != at && inside(&view.lanelets[other]) && strangers(view, graph, most, at, other))
        .collect()
}

/// Whether two lanelets have no relation; a conflict is one only if they overlap by more than this share of both.
fn strangers(view: &View, graph: &Graph, most: f64, x: usize, y: usize) -> bool {
    if graph.related(x, y) {
        return false;
    }
    let [a, b] = [x, y].map(|at| &view.lanelets[at]);
    let overlap = polygon::overlap(&a.outline, &b.outline);
    !graph.conflict(x, y) || overlap / (a.area + b.area - overlap) <= most
}

/// The outline of a lanelet moved outward by a share of its width, at the ends as well as at the sides.
fn widened(seen: &Seen) -> Option<Vec<Place>> {
    let width = |[a, b]: [&Point; 2]| (a.position - b.position).norm();
    let [start, end] = seen.ends()?;
    let by = WIDENED * f64::midpoint(width(start), width(end));
    let left = pushed(&seen.left, by)?;
    let right = pushed(&seen.right, -by)?;
    Some(left.into_iter().chain(right.into_iter().rev()).collect())
}

/// A bound with each vertex moved sideways (left positive), and made longer at both ends.
fn pushed(points: &[&Point], by: f64) -> Option<Vec<Place>> {
    let line = Polyline::new(points.iter().map(|point| point.position))?;
    let along: Vec<Vector> = line.segments().map(|(a, b)| (b - a).normalize()).collect();
    let (first, last) = (*along.first()?, *along.last()?);
    let count = line.points().len();
    let moved = line.points().iter().enumerate().map(|(i, p)| {
        let before = along[i.saturating_sub(1).min(along.len() - 1)];
        let behind = along[i.min(along.len() - 1)];
        let across = left_of(before + behind).try_normalize(Polyline::MERGE).unwrap_or_else(|| left_of(behind));
        let lengthwise = match i {
            0 => -first * by.abs(),
            _ if i + 1 == count => last * by.abs(),
            _ => Vector::zeros(),
        };
        p + across * by + lengthwise
    });
    Some(moved.collect())
}
