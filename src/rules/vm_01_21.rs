//! vm-01-21: a lane is continued by lanes of its own kind, and a crossing by none.

use std::collections::BTreeSet;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule};
use crate::lanelet::index::routing_graph::{Graph, Rules};

/// See `rules/vm-01-21.md`.
pub struct EndToEnd;

impl Rule for EndToEnd {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        let view = map.view();
        let graphs = [Rules::AnyLane, Rules::Pedestrian].map(|rules| Graph::new(view, rules));
        let mut findings = Vec::new();
        for (at, seen) in view.lanelets.iter().enumerate() {
            let next: BTreeSet<usize> = graphs.iter().flat_map(|graph| graph.following(at)).collect();
            let (id, kind) = (seen.id(), seen.tag("subtype").unwrap_or_default());
            let other = next.iter().map(|&next| &view.lanelets[next]).find(|next| !next.is(kind));
            let first = next.first().map(|&next| &view.lanelets[next]);
            let (fault, next, message) = match (kind, first, other) {
                ("crosswalk" | "walkway", Some(next), _) => {
                    ("follower", next, format!("The {kind} {id} is continued by lanelet {}.", next.id()))
                }
                (_, _, Some(next)) => {
                    let theirs = next.tag("subtype").unwrap_or_default();
                    (
                        "other-kind",
                        next,
                        format!("The {kind} lanelet {id} is continued by {theirs} lanelet {}.", next.id()),
                    )
                }
                _ => continue,
            };
            let finding = Finding::new(fault, Subject::Lanelet(id.0), message);
            findings.push(finding.with(Subject::Lanelet(next.id().0), "follower"));
        }
        findings
    }
}
