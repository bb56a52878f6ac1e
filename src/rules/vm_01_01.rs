//! vm-01-01: a road lanelet says where it lies and which way it runs.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule};

/// See `rules/vm-01-01.md`.
pub struct RoadBasics;

impl Rule for RoadBasics {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        let mut findings = Vec::new();
        for lanelet in map.map.lanelets.iter().filter(|lanelet| lanelet.attributes.is("subtype", "road")) {
            let (id, on) = (lanelet.id, Subject::Lanelet(lanelet.id.0));
            let said = |key: &str| match lanelet.attributes.get(key) {
                Some(value) => format!("{key}={value}"),
                None => format!("no {key}"),
            };
            if !matches!(lanelet.attributes.get("location"), Some("urban" | "private")) {
                let message = format!("Road lanelet {id} has {}; it must be urban or private.", said("location"));
                findings.push(Finding::new("location", on, message));
            }
            if !lanelet.attributes.is("one_way", "yes") {
                let message = format!("Road lanelet {id} has {}; it must be yes.", said("one_way"));
                let edits = vec![Edit::SetTag { on, key: "one_way".into(), value: "yes".into() }];
                findings.push(Finding::new("one-way", on, message).fixed_by("set one_way=yes", true, edits));
            }
        }
        findings
    }
}
