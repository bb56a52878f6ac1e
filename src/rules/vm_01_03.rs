//! vm-01-03, vm-01-04: lanes side by side share their border.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Deserialize;

use super::Rule;
use super::graph::{Graph, Rules};
use super::view::{Seen, View, boxes_meet, covered_by};
use crate::diagnostic::{Finding, Subject};
use crate::geometry::{Point as Place, Polyline, Vector, left_of, polygon};
use crate::lanelet::index::{MapIndex, extent};
use crate::lanelet::{LaneletId, Point};

/// See `rules/vm-01-03.md`.
pub struct SharedBorders;

/// See the document.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    iou_threshold: f64,
    /// Share of the width by which a lanelet is widened.
    reach: f64,
}

impl Rule for SharedBorders {
    type Params = Params;

    fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
        let view = View::new(map.map);
        let graph = Graph::new(&view, Rules::AnyLane);
        let pairs: Vec<(usize, usize)> = (0..view.lanelets.len())
            .into_par_iter()
            .flat_map_iter(|at| covered(&view, &graph, params, at).into_iter().map(move |other| (at, other)))
            .collect();
        let mut findings = Vec::new();
        let mut one_way: BTreeMap<usize, Vec<LaneletId>> = BTreeMap::new();
        for &(at, other) in &pairs {
            let (id, name) = (view.lanelets[at].id(), view.lanelets[other].id());
            if pairs.binary_search(&(other, at)).is_ok() {
                let message = format!("Lanelets {id} and {name} lie side by side but have borders of their own.");
                findings.push(
                    Finding::new("not-shared", Subject::Lanelet(id.0), message)
                        .with(Subject::Lanelet(name.0), "neighbour"),
                );
            } else {
                one_way.entry(at).or_default().push(name);
            }
        }
        findings.extend(one_way.into_iter().map(|(at, others)| partly(&view.lanelets[at], others)));
        findings
    }
}

fn partly(seen: &Seen, mut others: Vec<LaneletId>) -> Finding {
    others.sort_unstable();
    let names: Vec<String> = others.iter().map(ToString::to_string).collect();
    let id = seen.id();
    let message = format!("Lanelet {id} lies beside {} but is divided elsewhere.", names.join(" "));
    let finding = Finding::new("partly-shared", Subject::Lanelet(id.0), message);
    others.into_iter().fold(finding, |finding, other| finding.with(Subject::Lanelet(other.0), "neighbour"))
}

/// Lanelets that have nothing to do with one, but of which a whole bound lies in it, were it a little wider.
fn covered(view: &View, graph: &Graph, params: &Params, at: usize) -> Vec<usize> {
    let seen = &view.lanelets[at];
    let Some(outline) = widened(seen, params.reach) else { return Vec::new() };
    let reach = extent(&outline);
    let ring = polygon::to_geo(&outline);
    // Vertices and the middles between them: a widened outline may cross itself, which a test of whole lines would not bear.
    let holds = |points: &[&Point]| {
        let middles = points.windows(2).map(|pair| nalgebra::center(&pair[0].position, &pair[1].position));
        points.iter().map(|point| point.position).chain(middles).all(|p| covered_by(p, &ring))
    };
    let inside = |other: &Seen| boxes_meet(other.extent, reach) && (holds(&other.left) || holds(&other.right));
    let near = view.near(reach, 0.0).into_iter();
    near.filter(|&other| other != at && inside(&view.lanelets[other]) && strangers(view, graph, params, at, other))
        .collect()
}

/// Whether two lanelets have no relation; a conflict is one only if they overlap by more than a strip.
fn strangers(view: &View, graph: &Graph, params: &Params, x: usize, y: usize) -> bool {
    if graph.related(x, y) {
        return false;
    }
    let [a, b] = [x, y].map(|at| &view.lanelets[at]);
    let overlap = polygon::overlap(&a.outline, &b.outline);
    !graph.conflict(x, y) || overlap / (a.area + b.area - overlap) <= params.iou_threshold
}

/// The outline of a lanelet moved outward by a share of its width, at the ends as well as at the sides.
fn widened(seen: &Seen, share: f64) -> Option<Vec<Place>> {
    let width = |[a, b]: [&Point; 2]| (a.position - b.position).norm();
    let [start, end] = seen.ends()?;
    let by = share * f64::midpoint(width(start), width(end));
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
