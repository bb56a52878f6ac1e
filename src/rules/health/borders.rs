//! Borders between lanes: what the paint says against the tag, lanes on the wrong side of each other, lanes drawn twice.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::{DrivingSide, Lane, MapIndex};
use crate::lanelet::{Bound, LineStringId, RoadType};

use super::params::subject;

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    let mut findings = wrong_side(map);
    findings.extend(twice(map));
    findings.extend(against_paint(map));
    findings
}

/// Opposite lanes that share their outer bounds. Where many do, the map as a whole is at odds, and `side` says so.
fn wrong_side(map: &MapIndex) -> Vec<Finding> {
    let Some(side) = map.side.side else { return Vec::new() };
    let outer = match side {
        DrivingSide::Left => 0,
        DrivingSide::Right => 1,
    };
    let mut users: BTreeMap<LineStringId, usize> = BTreeMap::new();
    let mut pairs = Vec::new();
    for (at, lane) in map.lanes.iter().enumerate() {
        if lane.kind != RoadType::Road || !lane.is_for_cars() || lane.both_ways || lane.reverses() {
            continue;
        }
        let way = lane.bounds[outer];
        let other = *users.entry(way).or_insert(at);
        // If both start at the same point, they run side by side, or one lies on the other.
        if map.lanes[other].start.ids[outer] == lane.end.ids[outer] && other != at {
            pairs.push((other, at, way));
        }
    }
    let minority = map.side.left.min(map.side.right);
    if pairs.is_empty() || minority * 10 > map.side.left + map.side.right {
        return Vec::new();
    }
    let finding = |(other, at, way): (usize, usize, LineStringId)| {
        let [x, y] = [map.lanes[other].id, map.lanes[at].id];
        let message = format!("Opposite lanes {x} and {y} share their outer bounds: they drive on the wrong side.");
        Finding::new("wrong-side", subject(map, at), message)
            .with(subject(map, other), "opposite lane")
            .with(Subject::LineString(way.0), "common bound")
    };
    pairs.into_iter().map(finding).collect()
}

/// Lanelets with the same bounds, in the same direction, for the same traffic. Where vehicles reverse there is one for it and one to
/// drive on.
fn twice(map: &MapIndex) -> Vec<Finding> {
    let mut first: FxHashMap<(Bound, Bound, &str, bool), i64> = FxHashMap::default();
    let mut findings = Vec::new();
    for lanelet in &map.map.lanelets {
        let kind = lanelet.attributes.get("subtype").unwrap_or_default();
        let reverses = map.lane_of(lanelet.id).is_some_and(Lane::reverses);
        let known = *first.entry((lanelet.left, lanelet.right, kind, reverses)).or_insert(lanelet.id.0);
        if known == lanelet.id.0 {
            continue;
        }
        let (subject, message) =
            (Subject::Lanelet(lanelet.id.0), format!("Lanelets {known} and {} have the same bounds.", lanelet.id));
        findings.push(Finding::new("twice", subject, message).with(Subject::Lanelet(known), "the other").fixed_by(
            format!("remove lanelet {}", lanelet.id),
            false,
            vec![Edit::Remove { subject }],
        ));
    }
    findings
}

/// Lines between lanes of one direction that say something other than their paint does.
fn against_paint(map: &MapIndex) -> Vec<Finding> {
    let roads = || map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road"));
    let lefts: BTreeSet<(LineStringId, bool)> =
        roads().map(|lanelet| (lanelet.left.line, lanelet.left.inverted)).collect();
    let between: BTreeMap<LineStringId, i64> = roads()
        .filter(|lanelet| lefts.contains(&(lanelet.right.line, lanelet.right.inverted)))
        .map(|lanelet| (lanelet.right.line, lanelet.id.0))
        .collect();
    let finding = |(id, lanelet): (LineStringId, i64)| {
        let tags = &map.map.linestrings.get(id)?.attributes;
        let (change, paint) = (tags.get("lane_change")?, tags.get("subtype")?);
        let painted = matches!(tags.get("type"), Some("line_thin" | "line_thick"));
        if !painted || !matches!((change, paint), ("yes", "solid") | ("no", "dashed")) {
            return None;
        }
        let message = format!("Linestring {id} between two lanes is {paint} but has lane_change={change}.");
        let finding = Finding::new("lane-change-paint", Subject::LineString(id.0), message);
        Some(finding.with(Subject::Lanelet(lanelet), "lane"))
    };
    between.into_iter().filter_map(finding).collect()
}
