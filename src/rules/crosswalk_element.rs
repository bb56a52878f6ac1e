//! Edits on crosswalk elements: which lanelets a crosswalk's element belongs to, and which crosswalk an element is for.

use std::collections::BTreeSet;

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

/// An element to be created.
pub struct Creation {
    /// What is done, in one line.
    pub title: String,
    /// The edit.
    pub edit: Edit,
}

/// The element of a crosswalk, with the stop lines before it, for the lanelets for cars across it; `None` where there are none.
pub fn creation(map: &MapIndex, crosswalk: &Seen) -> Option<Creation> {
    let across = lanes_across(map, crosswalk);
    if across.is_empty() {
        return None;
    }
    let mut members = vec![("refers".into(), Subject::Lanelet(crosswalk.id().0))];
    let lines = stop_lines_before(map, &across);
    members.extend(lines.iter().map(|line| ("ref_line".into(), Subject::LineString(line.0))));
    let referrers: Vec<i64> = across.iter().map(|&(lane, _)| map.lanes[lane].id.0).collect();
    let stop = match lines.len() {
        0 => String::new(),
        1 => format!(", with stop line {}", lines[0]),
        count => format!(", with {count} stop lines"),
    };
    let title = format!("create the crosswalk element for {} across it{stop}", counted(referrers.len(), "lanelet"));
    Some(Creation { title, edit: Edit::CreateRegulatoryElement { subtype: "crosswalk".into(), members, referrers } })
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
            edits.push(creation.edit);
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

/// The stop lines before a crosswalk on the lanes across it, or on those that lead to them.
fn stop_lines_before(map: &MapIndex, across: &[(usize, f64)]) -> Vec<LineStringId> {
    let mut lines = BTreeSet::new();
    let corners: Vec<Point> = across.iter().flat_map(|&(lane, _)| map.lanes[lane].extent).collect();
    let [low, high] = extent(&corners);
    let reach = nalgebra::Vector2::repeat(BEFORE);
    for line in map.stop_lines_near(low - reach, high + reach) {
        for crossing in crossings(map, &line, 0.0) {
            let gap = across.iter().filter_map(|&(lane, entry)| {
                let on_it = (lane == crossing.lane).then_some(entry - crossing.station);
                let before = map.follows(crossing.lane, lane);
                let length = map.lanes[crossing.lane].length();
                on_it.or(before.then_some(length - crossing.station + entry))
            });
            if gap.into_iter().any(|gap| (0.0..=BEFORE).contains(&gap)) {
                lines.insert(line.way);
            }
        }
    }
    lines.into_iter().collect()
}
