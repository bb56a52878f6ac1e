//! node: every point has a place and a height, and says the same place twice if it says it twice.

use std::collections::BTreeMap;

use rstar::RTree;
use rstar::primitives::GeomWithData;
use rustc_hash::{FxHashMap, FxHashSet};
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::number::leading_number;
use crate::lanelet::{Condition, LoadFault, Point, PointId, heights_by_other_names};

use super::crowd;
use super::load::name;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    far: f64,
    slope: f64,
    least_step: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let heights = neighbouring_heights(map);
    let is_known = !map.faults.iter().any(LoadFault::leaves_projector_open);
    let without: Vec<&LoadFault> = map.faults.iter().filter(|it| it.condition == Condition::NoElevation).collect();
    // Of hundreds one finding tells, so that all get their heights at once: with half of them at 0, lanelets would stand on edge.
    let is_told_once = without.len() > crowd::MOST;
    let faults = map.faults.iter().filter(|it| !is_told_once || it.condition != Condition::NoElevation);
    let mut findings: Vec<Finding> = faults
        .filter_map(|fault| {
            let mut finding = finding(map, params, fault, &heights)?.standing_at(fault.span.clone());
            // Metres of another projection than the other points have would be worse than none.
            finding.fix =
                finding.fix.filter(|_| is_known || !matches!(fault.condition, Condition::PartialLocal { .. }));
            Some(finding)
        })
        .collect();
    findings
        .extend(without.first().filter(|_| is_told_once).map(|first| without_heights(map, first, &without, &heights)));
    findings.extend(steps(map, params));
    findings
}

/// The finding that many points have no height.
fn without_heights(
    map: &MapIndex,
    first: &LoadFault,
    without: &[&LoadFault],
    heights: &BTreeMap<PointId, Guess>,
) -> Finding {
    let (count, all) = (without.len(), map.map.points.len());
    let message = format!("{count} of {all} points have no ele; {} is the first.", first.subject);
    let finding = Finding::new("no-ele", first.subject, message).standing_at(first.span.clone());
    let edits: Vec<Edit> = without.iter().filter_map(|fault| Some(height_set(fault.subject, heights)?.0)).collect();
    match edits.len() {
        0 => finding,
        edited => finding.fixed_by(
            format!("set ele of {edited} points: as another key of theirs, their neighbours or the nearest points say"),
            false,
            edits,
        ),
    }
}

/// A height for a point that has none.
#[derive(Clone, Copy)]
struct Guess {
    /// Metres.
    height: f64,
    reason: &'static str,
}

fn finding(map: &MapIndex, params: &Params, fault: &LoadFault, heights: &BTreeMap<PointId, Guess>) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let found = |slug, message: String| Finding::new(slug, subject, message);
    Some(match &fault.condition {
        Condition::Unprojectable => {
            found("coordinate", format!("{about} lies out of reach of the map's projection and loads at its origin."))
        }
        Condition::PartialLocal { x, y } => {
            let lacks = match (x, y) {
                (false, false) => "neither local_x nor local_y",
                (true, _) => "local_x but no local_y",
                (false, true) => "local_y but no local_x",
            };
            recomputed(map, found("local-partial", format!("{about} has {lacks}; other points have both.")))
        }
        Condition::LocalMismatch { distance } => {
            let message = format!("local_x, local_y of {subject} are {distance:.2} m from its latitude and longitude.");
            recomputed(map, mismatch(params, subject, *distance, message))
        }
        Condition::LocalShifted { east, north } => {
            let distance = east.hypot(*north);
            let message = format!(
                "local_x, local_y of all points are {distance:.2} m from their latitude and longitude ({east:.2} m east, {north:.2} m north)."
            );
            mismatch(params, subject, distance, message)
        }
        Condition::LocalUnexplained { nodes, most } => {
            let message = format!(
                "local_x, local_y of {nodes} points are up to {most:.2} m from their latitude and longitude, and no projector explains them."
            );
            mismatch(params, subject, *most, message)
        }
        Condition::OtherSquare { square, expected, nodes } => {
            let who = match nodes {
                1 => format!("{about} lies"),
                _ => format!("{nodes} points, {subject} the first, lie"),
            };
            let message = format!("{who} in MGRS square {square}, not in {expected}, and loads in the wrong place.");
            found("other-square", message)
        }
        _ => return place_or_height(map, fault, heights),
    })
}

/// What is wrong with latitude and longitude, or with the height.
fn place_or_height(map: &MapIndex, fault: &LoadFault, heights: &BTreeMap<PointId, Guess>) -> Option<Finding> {
    let subject = fault.subject;
    let about = name(subject);
    let found = |slug, message: String| Finding::new(slug, subject, message);
    Some(match &fault.condition {
        Condition::NoElevation => with_height(heights, found("no-ele", format!("{about} has no ele."))),
        Condition::BadElevation { found: value } => {
            let read = leading_number(value).unwrap_or(0.0);
            with_height(
                heights,
                found("no-ele", format!("ele={value} of {subject} is not a number and is read as {read}.")),
            )
        }
        Condition::MetresAsDegrees { first: [lat, lon] } => {
            let count = map.map.points.len();
            let message = format!(
                "lat and lon of the {count} points are metres, not degrees: lat={lat}, lon={lon} the first; they belong into local_x and local_y."
            );
            found("coordinate", message)
        }
        Condition::ExchangedDegrees { first: [lat, lon] } => {
            let count = map.map.points.len();
            let message =
                format!("Latitude and longitude of the {count} points are exchanged: lat={lat}, lon={lon} the first.");
            found("coordinate", message)
        }
        Condition::ElevationLeftOut { nodes } => left_out(map, *nodes),
        Condition::BadCoordinate { said, meant } => {
            let finding = match said {
                Some([lat, lon]) => {
                    let place = format!("latitude {lat}, longitude {lon}");
                    found("coordinate", format!("{about} lies at {place}, which is not on Earth, and loads as 0, 0."))
                }
                None => unusable_place(subject),
            };
            match (meant, subject) {
                (Some(place), Subject::Point(point)) => {
                    let edits = vec![Edit::SetPlace { point, place: *place }];
                    finding.fixed_by("take latitude and longitude from local_x and local_y", true, edits)
                }
                _ => finding,
            }
        }
        _ => return None,
    })
}

/// A point whose latitude or longitude is no number.
fn unusable_place(subject: Subject) -> Finding {
    let message = format!(
        "{} has no usable latitude and longitude; of what is no number, the digits at its start are read.",
        name(subject)
    );
    Finding::new("coordinate", subject, message)
}

/// Local coordinates that lie this far (m) from latitude and longitude.
fn mismatch(params: &Params, subject: Subject, distance: f64, message: String) -> Finding {
    let severity = if distance > params.far { Severity::Error } else { Severity::Warning };
    Finding::new("local-mismatch", subject, message).measured(distance, params.far, "m").graded(severity)
}

/// Points at height 0 of which no height is written.
fn left_out(map: &MapIndex, nodes: usize) -> Finding {
    let bad = map.faults.iter().filter(|fault| matches!(fault.condition, Condition::BadElevation { .. }));
    let bad: FxHashSet<Subject> = bad.map(|fault| fault.subject).collect();
    let points = map.map.points.iter().filter(|point| point.ele().is_none());
    let absent = points.map(|point| Subject::Point(point.id.0)).filter(|point| !bad.contains(point));
    let edits = absent.map(|on| Edit::SetTag { on, key: "ele".into(), value: "0".into() }).collect();
    let message = match map.map.points.len() {
        all if all == nodes => format!("None of the {all} points has ele: the whole map lies at height 0."),
        all => format!(
            "{nodes} of {all} points have no ele; they lie at height 0, where Lanelet2's own writer leaves it out."
        ),
    };
    Finding::new("ele-left-out", Subject::Map, message).fixed_by("write ele=0, as they load", true, edits)
}

/// Adds the fix that sets a point's height (m) from its neighbours.
fn with_height(heights: &BTreeMap<PointId, Guess>, finding: Finding) -> Finding {
    match height_set(finding.subject, heights) {
        Some((edit, Guess { height, reason })) => {
            finding.fixed_by(format!("set ele={height:.3}, {reason}"), false, vec![edit])
        }
        None => finding,
    }
}

/// The edit that sets the height of a point, and why it is that one.
fn height_set(on: Subject, heights: &BTreeMap<PointId, Guess>) -> Option<(Edit, Guess)> {
    let guess = on.id().filter(|_| matches!(on, Subject::Point(_))).and_then(|id| heights.get(&PointId(id)))?;
    let value = format!("{:.3}", guess.height);
    Some((Edit::SetTag { on, key: "ele".into(), value: value.as_str().into() }, *guess))
}

/// Adds the fix that computes the local coordinates from latitude and longitude.
fn recomputed(map: &MapIndex, finding: Finding) -> Finding {
    let on = finding.subject;
    let point = on.id().and_then(|id| map.map.points.get(PointId(id)));
    let Some(place) = point.map(|point| point.position) else { return finding };
    let set = |key: &str, value: f64| Edit::SetTag { on, key: key.into(), value: format!("{value:.4}").into() };
    let edits = vec![set("local_x", place.x), set("local_y", place.y)];
    finding.fixed_by("recompute local_x and local_y from latitude and longitude", true, edits)
}

/// For points without height, the one that lies between those of their neighbours on a way.
fn neighbouring_heights(map: &MapIndex) -> BTreeMap<PointId, Guess> {
    let lacking = |condition: &Condition| matches!(condition, Condition::NoElevation | Condition::BadElevation { .. });
    let points = map.faults.iter().filter(|fault| lacking(&fault.condition));
    let wanted: FxHashSet<PointId> = points.filter_map(|fault| fault.subject.id().map(PointId)).collect();
    let mut heights = BTreeMap::new();
    if wanted.is_empty() {
        return heights;
    }
    for (id, height) in heights_by_other_names(&map.map.points, &wanted) {
        heights.insert(id, Guess { height, reason: "as another key of it says" });
    }
    let lines = map.map.linestrings.iter().map(|line| &line.points);
    for ids in lines.chain(map.map.polygons.iter().map(|polygon| &polygon.points)) {
        let mut station = 0.0;
        let mut known: Vec<(f64, f64)> = Vec::new();
        let mut open: FxHashMap<PointId, f64> = FxHashMap::default();
        let points: Vec<_> = map.map.points.get_each(ids.iter().copied()).collect();
        for (at, point) in points.iter().enumerate() {
            if let Some(before) = at.checked_sub(1).and_then(|before| points.get(before)) {
                station += (point.position - before.position).norm();
            }
            match point.ele() {
                Some(ele) => known.push((station, ele)),
                None if wanted.contains(&point.id) => drop(open.insert(point.id, station)),
                None => {}
            }
        }
        for (id, station) in open {
            if let Some(height) = between(&known, station) {
                heights.entry(id).or_insert(Guess { height, reason: "from its neighbours" });
            }
        }
    }
    fill_from_afar(map, &wanted, &mut heights);
    heights
}

/// For points on lines of which no point has a height, that of the nearest point that has one; 0, as it loads, where none has.
fn fill_from_afar(map: &MapIndex, wanted: &FxHashSet<PointId>, heights: &mut BTreeMap<PointId, Guess>) {
    let finite = |point: &&Point| point.position.x.is_finite() && point.position.y.is_finite();
    // Lanes lie as high as other lanes; lights and signs stand above them.
    let on_lanes = map.map.linestrings.iter().filter(|line| !map.users_of(line.id).is_empty());
    let on_lanes: FxHashSet<PointId> = on_lanes.flat_map(|line| line.points.iter().copied()).collect();
    let known = |is_asked: &dyn Fn(PointId) -> bool| -> Vec<GeomWithData<[f64; 2], f64>> {
        let points = map.map.points.iter().filter(finite).filter(|point| is_asked(point.id));
        let known =
            points.filter_map(|point| Some((point, point.ele().or_else(|| Some(heights.get(&point.id)?.height))?)));
        known.map(|(point, height)| GeomWithData::new([point.position.x, point.position.y], height)).collect()
    };
    let mut found = known(&|id| on_lanes.contains(&id));
    let mut stand_above_lanes = found.is_empty();
    if stand_above_lanes {
        found = known(&|_| true);
        stand_above_lanes = !found.is_empty();
    }
    let tree = RTree::bulk_load(found);
    let mut open: Vec<PointId> = wanted.iter().filter(|id| !heights.contains_key(id)).copied().collect();
    open.sort_unstable();
    // The height of a light is not that of the road below it.
    open.retain(|id| !(stand_above_lanes && on_lanes.contains(id)));
    for point in open.into_iter().filter_map(|id| map.map.points.get(id)).filter(finite) {
        let nearest = tree.nearest_neighbor(&[point.position.x, point.position.y]);
        let guess = nearest.map(|near| Guess { height: near.data, reason: "that of the nearest point with a height" });
        let flat = Guess { height: 0.0, reason: "as it loads: no point of the map has a height" };
        heights.insert(point.id, guess.unwrap_or(flat));
    }
}

/// The height at a station between known ones, or that of the nearer end.
fn between(known: &[(f64, f64)], station: f64) -> Option<f64> {
    let at = known.partition_point(|(s, _)| *s <= station);
    match (at.checked_sub(1).and_then(|before| known.get(before)), known.get(at)) {
        (Some((a, low)), Some((b, high))) if b > a => Some(low + (high - low) * (station - a) / (b - a)),
        (Some((_, height)), _) | (None, Some((_, height))) => Some(*height),
        (None, None) => None,
    }
}

/// Steps in the height of lane bounds and areas that no vehicle could drive over.
fn steps(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let bounds = map.map.linestrings.iter().filter(|line| !map.users_of(line.id).is_empty());
    let bounds = bounds.map(|line| (Subject::LineString(line.id.0), &line.points));
    let mut findings = Vec::new();
    for (subject, ids) in bounds {
        let points: Vec<_> = map.map.points.get_each(ids.iter().copied()).collect();
        for (at, pair) in points.windows(2).enumerate() {
            let (Some(low), Some(high)) = (pair[0].ele(), pair[1].ele()) else { continue };
            let (step, length) = ((high - low).abs(), (pair[1].position - pair[0].position).norm());
            if step <= params.least_step || step <= params.slope * length {
                continue;
            }
            let message = format!(
                "{} rises by {step:.2} m over {length:.2} m between points {} and {}.",
                name(subject),
                pair[0].id,
                pair[1].id
            );
            let finding = Finding::new("ele-step", subject, message)
                .with(Subject::Point(pair[0].id.0), "point")
                .with(Subject::Point(pair[1].id.0), "point")
                .measured(step, params.slope * length, "m")
                .at(Place::Line(vec![pair[0].position, pair[1].position]));
            let around = |at: usize| at.checked_sub(1).and_then(|before| points.get(before..=at + 1));
            findings.push(match [at, at + 1].into_iter().filter_map(around).find_map(|three| spike(three, params)) {
                Some((point, height)) => {
                    let value = format!("{height:.3}");
                    let on = Subject::Point(point.0);
                    let edits = vec![Edit::SetTag { on, key: "ele".into(), value: value.as_str().into() }];
                    finding.fixed_by(format!("set ele={value} on {on}, between its neighbours"), false, edits)
                }
                None => finding,
            });
        }
    }
    findings
}

/// The middle one of three points, and the height between its neighbours, where it alone stands out: both steps are too large, and
/// without it there is none.
fn spike(three: &[&Point], params: &Params) -> Option<(PointId, f64)> {
    let [before, at, behind] = three else { return None };
    let [a, b, c] = [before.ele()?, at.ele()?, behind.ele()?];
    let [first, second] = [before, behind].map(|one| (one.position - at.position).norm());
    let too_large = |step: f64, length: f64| step.abs() > params.least_step && step.abs() > params.slope * length;
    let alone = too_large(b - a, first) && too_large(c - b, second) && !too_large(c - a, first + second);
    (alone && first + second > 0.0).then(|| (at.id, a + (c - a) * first / (first + second)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heights_are_taken_from_the_neighbours() {
        let known = [(0.0, 10.0), (4.0, 12.0)];
        assert_eq!(between(&known, 1.0), Some(10.5));
        assert_eq!(between(&known, 9.0), Some(12.0));
        assert_eq!(between(&known[1..], 1.0), Some(12.0));
        assert_eq!(between(&[], 1.0), None);
    }
}
