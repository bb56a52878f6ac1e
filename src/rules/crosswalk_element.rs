//! Edits on crosswalk elements: which lanelets a crosswalk's element belongs to, and which crosswalk an element is for.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, polygon};
use crate::lanelet::index::view::{Seen, boxes_meet};
use crate::lanelet::index::{MapIndex, extent};
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElement};
use crate::text::counted;

use super::stop_line_crossings::crossings;
use crate::lanelet::index::thresholds;

/// A lane that shares at least this area (m2) with a crosswalk runs over it.
const CROSSES: f64 = 0.1;
/// A stop line farther (m) before a crosswalk belongs to something else.
const BEFORE: f64 = 8.0;

/// Elements to be created.
pub struct Creation {
    /// What is done, in one line.
    pub title: String,
    /// The edits.
    pub edits: Vec<Edit>,
}

/// The elements of a crosswalk for the lanelets for cars across it: one for those that stop at one line, so that each direction has its
/// own, and one for those of a direction that have none; `None` where no lanelet crosses it.
pub fn creation(map: &MapIndex, crosswalk: &Seen) -> Option<Creation> {
    let across = lanes_across(map, crosswalk);
    if across.is_empty() {
        return None;
    }
    let mut groups: BTreeMap<(Option<LineStringId>, bool), Vec<usize>> = BTreeMap::new();
    let along = |lane: usize| {
        let first = across.first().and_then(|&(first, _)| map.lanes[first].heading_in());
        first.zip(map.lanes[lane].heading_in()).is_none_or(|(one, other)| one.dot(&other) >= 0.0)
    };
    let stops = stop_lines_before(map, &across);
    for &(lane, _) in &across {
        let line = stops.get(&lane).copied();
        groups.entry((line, line.is_none() && along(lane))).or_default().push(lane);
    }
    // Lanes without a line of their own join those of their direction that have one.
    for is_along in [false, true] {
        let with_line = groups
            .iter()
            .find(|((line, _), lanes)| line.is_some() && lanes.first().is_some_and(|&lane| along(lane) == is_along));
        let Some(key) = with_line.map(|(key, _)| *key) else { continue };
        let without = groups.remove(&(None, is_along)).unwrap_or_default();
        groups.entry(key).or_default().extend(without);
    }
    let edits = groups.iter().map(|((line, _), lanes)| {
        let mut members = vec![("refers".into(), Subject::Lanelet(crosswalk.id().0))];
        members.extend(line.map(|line| ("ref_line".into(), Subject::LineString(line.0))));
        let referrers = lanes.iter().map(|&lane| map.lanes[lane].id.0).collect();
        Edit::CreateRegulatoryElement { subtype: "crosswalk".into(), members, referrers }
    });
    let edits: Vec<Edit> = edits.collect();
    let lines: Vec<LineStringId> = groups.keys().filter_map(|(line, _)| *line).collect();
    let stop = match lines[..] {
        [] => String::new(),
        [line] => format!(", with stop line {line}"),
        _ => format!(", with {} stop lines", lines.len()),
    };
    let what = match edits.len() {
        1 => "the crosswalk element".to_owned(),
        count => format!("{count} crosswalk elements"),
    };
    Some(Creation { title: format!("create {what} for {} across it{stop}", counted(across.len(), "lanelet")), edits })
}

/// Adds the edits by which an element refers, in place of `wrong`, to the only crosswalk without an element that its lanelets
/// cross.
pub fn with_crosswalk(
    map: &MapIndex,
    finding: Finding,
    element: &RegulatoryElement,
    idle: &[&Seen],
    wrong: Option<LaneletId>,
) -> Finding {
    let referrers = map.referrers(element.id);
    let boxes: Vec<[Point; 2]> = referrers.iter().filter_map(|&id| Some(map.lane_of(id)?.extent)).collect();
    let is_near = |seen: &&&Seen| boxes.iter().any(|lane| boxes_meet(*lane, seen.extent));
    let is_crossed =
        |seen: &&&Seen| lanes_across(map, seen).iter().any(|&(lane, _)| referrers.contains(&map.lanes[lane].id));
    let mut meant = idle.iter().filter(is_near).filter(is_crossed).map(|seen| Subject::Lanelet(seen.id().0));
    let (Some(member), None) = (meant.next(), meant.next()) else { return finding };
    let on = Subject::RegulatoryElement(element.id.0);
    let (role, gone) = (|| "refers".into(), wrong.map(|id| Subject::Lanelet(id.0)));
    let removed = gone.map(|member| Edit::RemoveMember { on, role: role(), member });
    let edits = removed.into_iter().chain([Edit::AddMember { on, role: role(), member }]).collect();
    finding.with(member, "crosswalk").fixed_by(
        format!("let it refer to crosswalk {}", member.id().unwrap_or(0)),
        false,
        edits,
    )
}

/// Adds the edits by which an element keeps the crosswalk that most of its lanelets cross, and by which each other crosswalk gets
/// an element of its own if it has none.
pub fn divided(map: &MapIndex, finding: Finding, element: &RegulatoryElement, refers: &[&Seen]) -> Finding {
    let referrers = map.referrers(element.id);
    let crossed = |seen: &&&Seen| {
        let across = lanes_across(map, seen);
        across.iter().filter(|(lane, _)| referrers.contains(&map.lanes[*lane].id)).count()
    };
    let Some(own) = refers.iter().rev().max_by_key(crossed) else { return finding };
    let on = Subject::RegulatoryElement(element.id.0);
    let elements = map.map.regulatory_elements.iter().filter(|one| one.subtype == "crosswalk" && one.id != element.id);
    let named: BTreeSet<LaneletId> = elements.flat_map(|one| one.lanelets("refers")).collect();
    let mut edits = Vec::new();
    for other in refers.iter().filter(|seen| seen.id() != own.id()) {
        let id = other.id();
        edits.push(Edit::RemoveMember { on, role: "refers".into(), member: Subject::Lanelet(id.0) });
        if !named.contains(&id) {
            let Some(creation) = creation(map, other) else { return finding };
            edits.extend(creation.edits);
        }
    }
    finding.fixed_by(format!("leave it crosswalk {} alone", own.id()), false, edits)
}

/// The lanes for cars that run over a crosswalk on its level, each with the station (m) where it comes to it.
fn lanes_across(map: &MapIndex, crosswalk: &Seen) -> Vec<(usize, f64)> {
    let [low, high] = crosswalk.extent;
    let near = map.lanes_near(low, high).into_iter().filter(|&lane| map.lanes[lane].is_for_cars());
    let height = |lane: usize, place: Point| map.height(lane, place);
    let own = map.lane(crosswalk.id());
    let over = near.filter_map(|lane| {
        let (_, place) =
            polygon::common_part(&map.lanes[lane].outline, &crosswalk.outline).filter(|one| one.0 >= CROSSES)?;
        let apart = own.and_then(|own| height(own, place)).zip(height(lane, place));
        if apart.is_some_and(|(a, b)| (a - b).abs() > thresholds::GRADE_SEPARATION) {
            return None;
        }
        let center = map.lanes[lane].center.as_ref()?;
        let stations = crosswalk.outline.iter().map(|&corner| center.project(corner).station);
        Some((lane, stations.fold(f64::INFINITY, f64::min)))
    });
    over.collect()
}

/// For each lane across a crosswalk the nearest stop line before it, on the lane itself or on one that leads to it.
fn stop_lines_before(map: &MapIndex, across: &[(usize, f64)]) -> FxHashMap<usize, LineStringId> {
    let mut nearest: FxHashMap<usize, (f64, LineStringId)> = FxHashMap::default();
    let corners: Vec<Point> = across.iter().flat_map(|&(lane, _)| map.lanes[lane].extent).collect();
    let [low, high] = extent(&corners);
    let reach = nalgebra::Vector2::repeat(BEFORE);
    for line in map.stop_lines_near(low - reach, high + reach) {
        for crossing in crossings(map, &line, 0.0) {
            for &(lane, entry) in across {
                let on_it = (lane == crossing.lane).then_some(entry - crossing.station);
                let before = map.follows(crossing.lane, lane);
                let length = map.lanes[crossing.lane].length();
                let gap = on_it.or(before.then_some(length - crossing.station + entry));
                let Some(gap) = gap.filter(|gap| (0.0..=BEFORE).contains(gap)) else { continue };
                let known = nearest.entry(lane).or_insert((gap, line.way));
                if (gap, line.way) < *known {
                    *known = (gap, line.way);
                }
            }
        }
    }
    nearest.into_iter().map(|(lane, (_, line))| (lane, line)).collect()
}
