//! vm-01-21: a lane is continued by lanes of its own kind, and a crossing by none.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::vocabulary::lanelet_subtypes;
use crate::lanelet::{LaneletId, RoadType};

use super::{NoParams, lane_kinds, walkway};
use crate::lanelet::index::routing_graph::{Graph, Rules};

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let view = map.view();
    let kinds = Kinds::of(view);
    let mut findings = Vec::new();
    for (at, seen) in view.lanelets.iter().enumerate() {
        let next = &kinds.next[at];
        let (id, kind) = (seen.id(), seen.tag("subtype").unwrap_or_default());
        let is_other = |next: &&Seen| next.tag("subtype").unwrap_or_default() != kind;
        let other = next.iter().map(|&next| &view.lanelets[next]).find(is_other);
        let first = next.first().map(|&next| &view.lanelets[next]);
        let (fault, next, message) = match (kind, first, other) {
            ("crosswalk" | "walkway", Some(next), _) => {
                ("follower", next, format!("The {kind} {id} is continued by lanelet {}.", next.id()))
            }
            (_, _, Some(next)) => {
                let [ours, theirs] = [kind, next.tag("subtype").unwrap_or_default()]
                    .map(|kind| if kind.is_empty() { "untyped" } else { kind });
                ("other-kind", next, format!("The {ours} lanelet {id} is continued by {theirs} lanelet {}.", next.id()))
            }
            _ => continue,
        };
        let finding = Finding::new(fault, Subject::Lanelet(id.0), message);
        let finding = finding.with(Subject::Lanelet(next.id().0), "follower");
        let [own, theirs] = [kind, next.tag("subtype").unwrap_or_default()].map(lane_kinds::for_autoware);
        if fault == "other-kind" && own == theirs {
            findings.push(lane_kinds::renamed(view, finding));
            continue;
        }
        let crosses = |id| crosses_a_road(map, id);
        let for_people = |kind: &str| ["crosswalk", "walkway"].contains(&kind);
        let is_path = fault == "follower" && for_people(next.tag("subtype").unwrap_or_default());
        // Only a crossing in pieces is one that vehicles stop for in the middle: a path up to it, or on from it, is none.
        let finding = match is_path && !(crosses(id) && crosses(next.id())) {
            true => finding.graded(Severity::Warning),
            false => finding,
        };
        let between = (fault == "other-kind").then(|| kinds.between(at, next.id()));
        findings.push(match between.flatten() {
            Some((lanelet, kind)) => {
                let edits = vec![Edit::SetTag { on: lanelet, key: "subtype".into(), value: kind.into() }];
                finding.fixed_by(format!("set subtype={kind} on {lanelet}, as the lanes around it"), false, edits)
            }
            // A path along the road that is drawn as walkways is a strip for people on foot.
            None if kind == "walkway" && fault == "follower" && !crosses(id) => {
                walkway::as_pedestrian_lane(map, finding, id)
            }
            None => finding,
        });
    }
    findings
}

/// Whether a walkway leads over an edge of a road lanelet.
fn crosses_a_road(map: &MapIndex, id: LaneletId) -> bool {
    let Some(walkway) = map.lane_of(id) else { return false };
    let near = map.lanes_near(walkway.extent[0], walkway.extent[1]).into_iter().map(|lane| &map.lanes[lane]);
    near.filter(|lane| lane.kind == RoadType::Road).any(|lane| walkway::leads_over(walkway, lane))
}

/// What kinds of lanes go before and after each.
struct Kinds<'v, 'm> {
    view: &'v View<'m>,
    next: Vec<BTreeSet<usize>>,
    before: Vec<BTreeSet<usize>>,
}

impl<'v, 'm> Kinds<'v, 'm> {
    fn of(view: &'v View<'m>) -> Self {
        let graphs = [Rules::AnyLane, Rules::Pedestrian].map(|rules| Graph::new(view, rules));
        let next: Vec<BTreeSet<usize>> =
            (0..view.lanelets.len()).map(|at| graphs.iter().flat_map(|graph| graph.following(at)).collect()).collect();
        let mut before = vec![BTreeSet::new(); next.len()];
        for (at, after) in next.iter().enumerate() {
            after.iter().for_each(|&follower| _ = before[follower].insert(at));
        }
        Self { view, next, before }
    }

    /// The one of a lane and its follower that alone is of another kind than all lanes before and behind it, and that kind, if it is
    /// one that somebody knows.
    fn between(&self, at: usize, follower: LaneletId) -> Option<(Subject, &'v str)> {
        let follower = self.view.position(follower)?;
        [at, follower].into_iter().find_map(|lane| {
            let around = || self.before[lane].iter().chain(&self.next[lane]);
            let kind = self.view.lanelets[*around().next()?].tag("subtype")?;
            let all = around().all(|&other| self.view.lanelets[other].is(kind));
            let all = all && lanelet_subtypes().any(|known| known == kind);
            let enclosed = !self.before[lane].is_empty() && !self.next[lane].is_empty();
            let seen = &self.view.lanelets[lane];
            (all && enclosed && !seen.is(kind)).then_some((Subject::Lanelet(seen.id().0), kind))
        })
    }
}
