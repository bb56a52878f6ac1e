//! vm-04-03: every bulb has a colour, and an arrow that points somewhere.

use std::collections::BTreeSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{LineStringId, Point};
use crate::text::nearest;

use super::NoParams;

/// What a bulb may show, in the words that Autoware reads.
const COLORS: [&str; 3] = ["red", "yellow", "green"];
/// Where its arrow may point.
const ARROWS: [&str; 5] = ["up", "right", "left", "up_right", "up_left"];

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let view = map.view();
    let elements = view.map.regulatory_elements.iter();
    let lines: BTreeSet<LineStringId> = elements.flat_map(|element| element.linestrings("light_bulbs")).collect();
    let mut findings = Vec::new();
    for line in lines.into_iter().filter_map(|id| view.map.linestrings.get(id)) {
        let points: Vec<&Point> = view.points(line);
        for point in &points {
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
                None => say("color-missing", format!("Bulb {id} has no color."), left_over(&points, point)),
                Some(color) if COLORS.contains(&color) => {}
                Some(other) => {
                    let message = format!("color={other} of bulb {id} is not red, yellow or green.");
                    let meant = nearest(other, COLORS).map(|color| ("color", color));
                    say("color-invalid", message, meant.or_else(|| left_over(&points, point)));
                }
            }
            match point.attributes().get("arrow") {
                None => {}
                Some(arrow) if ARROWS.contains(&arrow) => {}
                Some(other) => {
                    let message = format!("arrow={other} of bulb {id} points nowhere.");
                    let meant = if other == "straight" { Some("up") } else { nearest(other, ARROWS) };
                    say("arrow-invalid", message, meant.map(|arrow| ("arrow", arrow)));
                }
            }
        }
    }
    findings
}

/// What a bulb shows of which the colour is not known: an arrow is green; else the colour that
/// the others do not show, of three or, for people on foot, of red and green.
fn left_over(bulbs: &[&Point], bulb: &Point) -> Option<(&'static str, &'static str)> {
    let is_plain = |bulb: &&Point| !bulb.attributes().has("arrow");
    if !is_plain(&bulb) {
        return Some(("color", "green"));
    }
    let plain: Vec<&Point> = bulbs.iter().copied().filter(is_plain).collect();
    let colors: &[&str] = match plain.len() {
        2 => &["red", "green"],
        3 => &COLORS,
        _ => &[],
    };
    let shown = |color: &&str| plain.iter().any(|bulb| bulb.attributes().get("color") == Some(*color));
    let left: Vec<&str> = colors.iter().copied().filter(|color| !shown(color)).collect();
    match left[..] {
        [color] => Some(("color", color)),
        _ => None,
    }
}
