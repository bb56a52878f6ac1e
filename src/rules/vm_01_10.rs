//! vm-01-10: a centre line runs from edge to edge inside its lanelet.

use rustc_hash::FxHashMap;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Subject};
use crate::geometry::{Polyline, polygon};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, Spot, View, covered_by, spot};
use crate::lanelet::{Condition, LineStringId, Point};

use super::centerline_ends::moved_onto;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    dimension_mode: String,
    planar_threshold: f64,
    height_threshold: f64,
}

/// The share (1) of a map that is mirrored for which this is told once, and how many centre lines it takes.
const NEARLY_ALL: f64 = 0.9;
const FEWEST: usize = 5;
/// An end of a centre line that is no farther from an edge of its lanelet than this, metres, is meant for that edge.
const NEARLY: f64 = 0.5;

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    if map.map.lanelets.iter().all(|lanelet| lanelet.centerline.is_none()) {
        return Vec::new();
    }
    let view = map.view();
    let mut users: FxHashMap<LineStringId, usize> = FxHashMap::default();
    view.map.lanelets.iter().filter_map(|lanelet| lanelet.centerline).for_each(|id| *users.entry(id).or_default() += 1);
    let findings: Vec<Finding> = view.lanelets.iter().flat_map(|seen| judge(view, params, seen, &users)).collect();
    match mirrored(map, &findings, users.len()) {
        Some(finding) => {
            let others = findings.into_iter().filter(|one| one.fault != "backwards");
            std::iter::once(finding).chain(others).collect()
        }
        None => findings,
    }
}

/// One finding in place of hundreds where nearly all lanelets run against their centre lines and against both their bounds: so looks a
/// map of which one axis was not turned around, such as CARLA's, or of which left and right were exchanged.
fn mirrored(map: &MapIndex, findings: &[Finding], all: usize) -> Option<Finding> {
    let backwards: Vec<&Finding> = findings.iter().filter(|one| one.fault == "backwards").collect();
    let lanelets = map.map.lanelets.len();
    let turned =
        map.faults.iter().filter(|fault| matches!(fault.condition, Condition::BothBoundsTurned { .. })).count();
    let nearly = |count: usize, all: usize| count as f64 > NEARLY_ALL * all as f64;
    if backwards.len() < FEWEST || !nearly(backwards.len(), all) || !nearly(turned, lanelets) {
        return None;
    }
    let message = format!(
        "{} of {all} centre lines and the bounds of {turned} of {lanelets} lanelets run against them: the map is a mirror image, \
         or left and right are exchanged.",
        backwards.len()
    );
    let finding = Finding::new("mirrored", Subject::Map, message);
    Some(finding.with(backwards.first()?.subject, "first"))
}

/// Judges the centre line of a lanelet; `users` counts the lanelets of each such line.
fn judge(view: &View, params: &Params, seen: &Seen, users: &FxHashMap<LineStringId, usize>) -> Vec<Finding> {
    let line = seen.lanelet.centerline.and_then(|id| view.map.linestrings.get(id));
    let (Some(line), Some([start, end])) = (line, seen.ends()) else { return Vec::new() };
    let points = view.points(line);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let (id, name) = (line.id, seen.id());
    let finding = |fault, message| {
        Finding::new(fault, Subject::LineString(id.0), message).with(Subject::Lanelet(name.0), "lanelet")
    };
    let mut findings = Vec::new();
    let off = [(first, start), (last, end)].map(|(point, edge)| distance(point, edge));
    let far = off[0].max(off[1]);
    let turned = distance(first, end).max(distance(last, start));
    // A line that only runs the other way has its ends where they belong, or nearly so.
    if far > params.planar_threshold && turned <= params.planar_threshold.max(NEARLY).min(far / 2.0) {
        let message = format!("Centre line {id} of lanelet {name} runs against it: it begins where the lanelet ends.");
        let finding = finding("backwards", message).measured(far, params.planar_threshold, "m");
        let edits = vec![Edit::ReverseWay { way: Subject::LineString(id.0) }];
        findings.push(match users.get(&id) == Some(&1) {
            true => finding.fixed_by("turn it around", false, edits),
            false => finding,
        });
    } else if far > params.planar_threshold {
        let message = format!("Centre line {id} of lanelet {name} ends {far:.2} m from the lanelet's edge.");
        let finding = finding("end-off", message).measured(far, params.planar_threshold, "m");
        let ends = [(0, first.id, start.map(|point| point.id)), (1, last.id, end.map(|point| point.id))]
            .into_iter()
            .filter(|(at, ..)| off[*at] > params.planar_threshold);
        let edits: Option<Vec<Edit>> = ends.map(|(_, end, edge)| moved_onto(view.map, id, end, edge)).collect();
        findings.push(match edits {
            Some(edits) => finding.fixed_by("move its ends onto the lanelet's edges", false, edits),
            None => finding,
        });
    }
    let ring = polygon::to_geo(&seen.outline);
    let inner = points.get(1..points.len() - 1).unwrap_or_default();
    if let Some(outside) = inner.iter().find(|point| !covered_by(point.position, &ring)) {
        let message = format!("Centre line {id} leaves lanelet {name} at point {}.", outside.id);
        findings.push(finding("outside", message).at(Place::Point(outside.position)));
    }
    if params.dimension_mode.eq_ignore_ascii_case("3d") {
        let spots: Vec<Spot> = seen.left.iter().chain(&seen.right).map(|point| spot(point)).collect();
        let away = points.iter().filter_map(|point| off_plane(&spots, spot(point))).fold(0.0, f64::max);
        if away > params.height_threshold {
            let message = format!("Centre line {id} lies {away:.2} m above or below lanelet {name}.");
            findings.push(finding("off-surface", message).measured(away, params.height_threshold, "m"));
        }
    }
    findings
}

/// Distance of a point from an edge, in the plane.
pub fn distance(point: &Point, edge: [&Point; 2]) -> f64 {
    let [a, b] = edge.map(|end| end.position);
    Polyline::new([a, b]).map_or((point.position - a).norm(), |line| line.distance(point.position))
}

/// Distance of a spot from the plane that fits others best.
pub fn off_plane(spots: &[Spot], p: Spot) -> Option<f64> {
    if !spots.iter().all(|spot| spot.iter().all(|value| value.is_finite())) {
        return None;
    }
    let middle = spots.iter().fold(nalgebra::Vector3::zeros(), |sum, spot| sum + spot.coords) / spots.len() as f64;
    let spread = spots
        .iter()
        .map(|spot| spot.coords - middle)
        .fold(nalgebra::Matrix3::zeros(), |sum, d| sum + d * d.transpose());
    let eigen = spread.symmetric_eigen();
    let least = eigen.eigenvalues.imin();
    let normal = eigen.eigenvectors.column(least);
    Some((p.coords - middle).dot(&normal).abs()).filter(|away| away.is_finite())
}
