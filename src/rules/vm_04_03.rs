//! vm-04-03: every bulb has a colour, and an arrow that points somewhere.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::LineStringId;
use crate::lanelet::index::MapIndex;
use crate::text::nearest;

use super::{NoParams, Rule};

/// See `rules/vm-04-03.md`.
pub struct Bulbs;

/// What a bulb may show, in the words that Autoware reads.
const COLORS: [&str; 3] = ["red", "yellow", "green"];
/// Where its arrow may point.
const ARROWS: [&str; 5] = ["up", "right", "left", "up_right", "up_left"];

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
                let on = Subject::Point(id.0);
                let mut say = |fault, message, meant: Option<(&str, &str)>| {
                    let finding = Finding::new(fault, on, message).with(Subject::LineString(line.id.0), "bulbs");
                    findings.push(match meant {
                        Some((key, value)) => {
                            let edits = vec![Edit::SetTag { on, key: key.into(), value: value.into() }];
                            finding.fixed_by(format!("set {key}={value}"), false, edits)
                        }
                        None => finding,
                    });
                };
                match point.attributes().get("color") {
                    None => say("color-missing", format!("Bulb {id} has no color."), None),
                    Some(color) if COLORS.contains(&color) => {}
                    Some(other) => {
                        let message = format!("color={other} of bulb {id} is not red, yellow or green.");
                        say("color-invalid", message, nearest(other, COLORS).map(|color| ("color", color)));
                    }
                }
                match point.attributes().get("arrow") {
                    None => {}
                    Some(arrow) if ARROWS.contains(&arrow) => {}
                    Some(other) => {
                        let message = format!("arrow={other} of bulb {id} points nowhere.");
                        say("arrow-invalid", message, nearest(other, ARROWS).map(|arrow| ("arrow", arrow)));
                    }
                }
            }
        }
        findings
    }
}
