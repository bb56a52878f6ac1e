//! vm-04-03: every bulb has a colour, and an arrow that points somewhere.

use std::collections::BTreeSet;

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::LineStringId;
use crate::lanelet::index::MapIndex;

use super::{NoParams, Rule};

/// See `rules/vm-04-03.md`.
pub struct Bulbs;

impl Rule for Bulbs {
    type Params = NoParams;

    fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
        let view = map.view();
        let elements = view.map.regulatory_elements.iter();
        let lines: BTreeSet<LineStringId> = elements.flat_map(|element| element.linestrings("light_bulbs")).collect();
        let mut findings = Vec::new();
        for line in lines.into_iter().filter_map(|id| view.map.linestrings.get(id)) {
            for point in view.points(line) {
                let id = point.id;
                let mut say = |fault, message| {
                    let finding = Finding::new(fault, Subject::Point(id.0), message);
                    findings.push(finding.with(Subject::LineString(line.id.0), "bulbs"));
                };
                match point.attributes().get("color") {
                    None => say("color-missing", format!("Bulb {id} has no color.")),
                    Some("red" | "yellow" | "green") => {}
                    Some(other) => {
                        say("color-invalid", format!("color={other} of bulb {id} is not red, yellow or green."))
                    }
                }
                match point.attributes().get("arrow") {
                    None | Some("up" | "right" | "left" | "up_right" | "up_left") => {}
                    Some(other) => say("arrow-invalid", format!("arrow={other} of bulb {id} points nowhere.")),
                }
            }
        }
        findings
    }
}
