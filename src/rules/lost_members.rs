//! Lights and markings that do not load because they refer to nothing, and the fix that gives them what their lanelets obey; speed
//! limits without a sign, which their lanelets do not need.

use std::collections::{BTreeMap, BTreeSet};

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::{Lane, MapIndex};
use crate::lanelet::{Condition, LaneletId, LineStringId, PointId};
use crate::text::counted;

use super::stop_line_crossings::{lanes_that_stop, line_of_lanes};

/// An element that refers to nothing.
struct Lost {
    subtype: String,
    /// The lanelets that refer to it.
    lanelets: Vec<LaneletId>,
}

/// The elements of a map that refer to no light, to no marking or to no sign.
pub struct LostMembers<'i, 'm> {
    map: &'i MapIndex<'m>,
    elements: BTreeMap<i64, Lost>,
}

impl<'i, 'm> LostMembers<'i, 'm> {
    /// From the faults of the loader.
    pub fn of(map: &'i MapIndex<'m>) -> Self {
        let mut elements: BTreeMap<i64, Lost> = BTreeMap::new();
        for fault in map.faults {
            let subtype = match &fault.condition {
                Condition::MemberCount { subtype, limit, count: 0 } if limit.role == "refers" => subtype,
                Condition::WithoutMembers { subtype } => subtype,
                Condition::SignWithoutType { subtype, sign: None } => subtype,
                _ => continue,
            };
            if let Subject::RegulatoryElement(id) = fault.subject
                && ["traffic_light", "road_marking", "speed_limit"].contains(&subtype.as_str())
            {
                elements.insert(id, Lost { subtype: subtype.to_string(), lanelets: Vec::new() });
            }
        }
        for fault in map.faults {
            if let (Condition::MemberDropped { id, .. }, Subject::Lanelet(lanelet)) = (&fault.condition, fault.subject)
                && let Some(lost) = elements.get_mut(id)
            {
                lost.lanelets.push(LaneletId(lanelet));
            }
        }
        Self { map, elements }
    }

    /// Those of a subtype to which one of some lanelets refers.
    pub fn of_lanelets(&self, subtype: &str, lanelets: &BTreeSet<LaneletId>) -> impl Iterator<Item = i64> {
        let theirs = move |lost: &Lost| lost.subtype == subtype && lost.lanelets.iter().any(|id| lanelets.contains(id));
        self.elements.iter().filter(move |(_, lost)| theirs(lost)).map(|(&id, _)| id)
    }

    /// Adds the edits that let such an element refer to the stop line of its lanelets, or to the lights of that stop line.
    pub fn found_again(&self, finding: Finding) -> Finding {
        let Subject::RegulatoryElement(id) = finding.subject else { return finding };
        let Some(lost) = self.elements.get(&id).filter(|_| finding.fix.is_none()) else { return finding };
        if lost.subtype == "speed_limit" {
            return self.without_limit(finding, lost);
        }
        let lanes: Vec<usize> = lost.lanelets.iter().filter_map(|&id| self.map.lane(id)).collect();
        let Some(line) = line_of_lanes(self.map, &lanes) else { return finding };
        let finding = finding.with(Subject::LineString(line.0), "stop line of its lanelets");
        match lost.subtype.as_str() {
            "road_marking" => {
                let edits = vec![marking(id, line)];
                finding.fixed_by(format!("let it refer to stop line {line}"), false, edits)
            }
            _ => self.with_lights_beside(finding, line, &lanes),
        }
    }

    /// Adds the edit that removes a speed limit of which all lanelets say one themselves: the element does not load, so that no vehicle
    /// has ever kept to it.
    fn without_limit(&self, finding: Finding, lost: &Lost) -> Finding {
        let says_one = |id: &LaneletId| {
            let lanelet = self.map.map.lanelets.get(*id);
            lanelet.is_some_and(|lanelet| lanelet.attributes.has("speed_limit"))
        };
        if lost.lanelets.is_empty() || !lost.lanelets.iter().all(says_one) {
            return finding;
        }
        let edits = vec![Edit::Remove { subject: finding.subject }];
        finding.fixed_by("remove the element: its lanelets have speed limits of their own", false, edits)
    }

    /// Adds the edits that let an element refer to the lights of its stop line, or of the lanes that start beside its own.
    fn with_lights_beside(&self, finding: Finding, line: LineStringId, lanes: &[usize]) -> Finding {
        let map = self.map;
        let starts: BTreeSet<PointId> = lanes.iter().flat_map(|&lane| map.lanes[lane].start.ids).collect();
        let starts_beside = |other: &&Lane| other.start.ids.iter().any(|id| starts.contains(id));
        let near = lanes.iter().flat_map(|&lane| map.lanes_near(map.lanes[lane].extent[0], map.lanes[lane].extent[1]));
        let beside = near.map(|other| &map.lanes[other]).filter(starts_beside);
        let at_line = lanes_that_stop(map, line).into_iter().map(|other| &map.lanes[other]);
        let elements = at_line.chain(beside).flat_map(|other| map.elements(other.id, "traffic_light"));
        let lights: BTreeSet<LineStringId> = elements.flat_map(|element| element.linestrings("refers")).collect();
        if lights.is_empty() {
            return finding;
        }
        let (on, role) = (finding.subject, || "refers".into());
        let edits =
            lights.iter().map(|light| Edit::AddMember { on, role: role(), member: Subject::LineString(light.0) });
        let title = format!("let it refer to {} of its approach", counted(lights.len(), "light"));
        finding.fixed_by(title, false, edits.collect())
    }
}

/// The edit that lets a road marking refer to a stop line.
pub fn marking(element: i64, line: LineStringId) -> Edit {
    let on = Subject::RegulatoryElement(element);
    Edit::AddMember { on, role: "refers".into(), member: Subject::LineString(line.0) }
}
