//! vm-01-01: a road lanelet says where it lies and which way it runs.

use std::collections::VecDeque;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::routing_pairs::may_pass;
use crate::lanelet::{Lanelet, LaneletId};

use super::NoParams;
use super::two_way::{TwoWay, is_two_way};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = Vec::new();
    let nearby = NearbyLocations::of(map);
    let mut two_way = None;
    for lanelet in map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road")) {
        let (id, on) = (lanelet.id, Subject::Lanelet(lanelet.id.0));
        let said = |key: &str| match lanelet.attributes.get(key) {
            Some(value) => format!("{key}={value}"),
            None => format!("no {key}"),
        };
        if location(lanelet).is_none() {
            let message = format!("Road lanelet {id} has {}; it must be urban or private.", said("location"));
            let (value, reason) = nearby.guess(lanelet);
            let edits = vec![Edit::SetTag { on, key: "location".into(), value: value.into() }];
            let title = format!("set location={value}, {reason}");
            findings.push(Finding::new("location", on, message).fixed_by(title, false, edits));
        }
        if !lanelet.attributes.is("one_way", "yes") {
            let message = format!("Road lanelet {id} has {}; it must be yes.", said("one_way"));
            let finding = Finding::new("one-way", on, message);
            let says_nothing = !lanelet.attributes.has("one_way");
            // A vehicle takes a lanelet that says nothing for one-way.
            let finding = if says_nothing { finding.graded(Severity::Warning) } else { finding };
            let (edits, draws) = two_way.get_or_insert_with(|| TwoWay::of(map)).edits(lanelet);
            let title = match (draws, is_two_way(lanelet)) {
                (true, _) => "set one_way=yes and draw the lanelet of the other direction between the same bounds",
                (false, true) => "set one_way=yes: nobody may drive back on it any more, and no lane leads on that way",
                (false, false) => "set one_way=yes",
            };
            let walked = may_pass(lanelet, "pedestrian") || lanelet.attributes.iter().any(|(key, _)| is_for_some(key));
            findings.push(finding.fixed_by(title, says_nothing && !walked, edits));
        }
    }
    findings
}

/// Whether a tag says for whom a lanelet is one-way.
fn is_for_some(key: &str) -> bool {
    key.starts_with("one_way:")
}

/// Where a lanelet says it lies, in one of the two words that count.
fn location(lanelet: &Lanelet) -> Option<&'static str> {
    match lanelet.attributes.get("location") {
        Some("urban") => Some("urban"),
        Some("private") => Some("private"),
        _ => None,
    }
}

/// For lanes that do not say where they lie, what the nearest lane along the road says.
struct NearbyLocations(FxHashMap<LaneletId, &'static str>);

impl NearbyLocations {
    fn of(map: &MapIndex) -> Self {
        let mut said: Vec<Option<&'static str>> = map.lanes.iter().map(|lane| location(lane.lanelet)).collect();
        let mut nearby = FxHashMap::default();
        if said.iter().all(Option::is_some) {
            return Self(nearby);
        }
        let mut open: VecDeque<usize> = (0..said.len()).filter(|&lane| said[lane].is_some()).collect();
        while let Some(lane) = open.pop_front() {
            let Some(value) = said[lane] else { continue };
            let beside = map.lanes[lane].bounds.into_iter().flat_map(|way| map.users_of(way));
            let along = map.followers(lane).iter().chain(map.predecessors(lane));
            for &next in along.chain(beside).filter(|&&next| map.lanes[next].kind == map.lanes[lane].kind) {
                if said[next].is_none() {
                    said[next] = Some(value);
                    nearby.insert(map.lanes[next].id, value);
                    open.push_back(next);
                }
            }
        }
        Self(nearby)
    }

    /// The value for a lanelet, and why. Lanelet2 knows a speed for urban lanes, and for those that do not say where they lie, but none
    /// for private ones: without a speed limit of its own, a lane would no longer be driven on.
    fn guess(&self, lanelet: &Lanelet) -> (&'static str, &'static str) {
        match self.0.get(&lanelet.id) {
            Some(&"private") if !lanelet.attributes.has("speed_limit") => {
                ("urban", "since a private lane without speed_limit has no speed")
            }
            Some(value) => (value, "as the nearest lane along the road"),
            None => ("urban", "since no lane along the road says otherwise"),
        }
    }
}
