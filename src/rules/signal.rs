//! signal: whether what one light tells of another is read.

use crate::diagnostic::{Edit, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::vocabulary::words;
use crate::lanelet::{RegulatoryElement, RegulatoryElementId};
use crate::text::misspelt;

use super::NoParams;

/// What the keys begin with; two lamps follow.
pub const RELATION: &str = "signal_color_relation:";
/// The lamps that Autoware reads; TIER IV's branch reads arrows in addition.
const LAMPS: [&str; 4] = ["red", "amber", "green", "white"];
/// What people call the amber lamp.
const AMBER: [&str; 2] = ["yellow", "orange"];

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let mut findings = Vec::new();
    for element in &map.map.regulatory_elements {
        for (key, value) in element.attributes.iter() {
            let Some(lamps) = key.strip_prefix(RELATION) else { continue };
            if element.subtype != "traffic_light" {
                let message =
                    format!("{} {} has {key}, which is read of traffic lights alone.", element.subtype, element.id);
                findings.push(Finding::new("no-light", Subject::RegulatoryElement(element.id.0), message));
                continue;
            }
            findings.extend(lamp(element, key, lamps, value));
            findings.extend(blank(element, key, value));
            findings.extend(targets(map, element, key, value));
        }
    }
    findings
}

/// Lamps that nothing reads.
fn lamp(element: &RegulatoryElement, key: &str, lamps: &str, value: &str) -> Option<Finding> {
    let about = Subject::RegulatoryElement(element.id.0);
    let known = || words().into_iter().flat_map(|words| &words.lamps.words).map(String::as_str);
    let read: Vec<&str> = lamps.split(':').collect();
    let [from, to] = read[..] else {
        let message = format!("{key} of traffic light {} does not name two lamps.", element.id);
        return Some(Finding::new("lamp", about, message));
    };
    let unread = [from, to].into_iter().find(|lamp| !LAMPS.contains(lamp))?;
    if [from, to].iter().all(|lamp| known().any(|known| known == *lamp)) {
        let message = format!(
            "{key} of traffic light {} names {unread}, which TIER IV's Autoware reads and others do not.",
            element.id
        );
        return Some(Finding::new("lamp", about, message).graded(Severity::Info));
    }
    let meant = |lamp: &str| match lamp {
        lamp if AMBER.contains(&lamp) => Some("amber".to_owned()),
        lamp if known().any(|known| known == lamp) => Some(lamp.to_owned()),
        lamp => misspelt(lamp, known()).map(str::to_owned),
    };
    let message =
        format!("{key} of traffic light {} names {unread}, which is no lamp that Autoware reads.", element.id);
    let finding = Finding::new("lamp", about, message);
    let Some((from, to)) = meant(from).zip(meant(to)) else { return Some(finding) };
    let right = format!("{RELATION}{from}:{to}");
    if element.attributes.has(&right) {
        return Some(finding);
    }
    let edits = vec![
        Edit::RemoveTag { on: about, key: key.into() },
        Edit::SetTag { on: about, key: right.as_str().into(), value: value.into() },
    ];
    Some(finding.fixed_by(format!("name the key {right}"), false, edits))
}

/// Blanks before an id: the ids behind the first comma are not read then.
fn blank(element: &RegulatoryElement, key: &str, value: &str) -> Option<Finding> {
    let lost: Vec<&str> = value.split(',').filter(|id| id.starts_with(char::is_whitespace)).map(str::trim).collect();
    let first = lost.first()?;
    let about = Subject::RegulatoryElement(element.id.0);
    let message = format!(
        "{key} of traffic light {} has a blank before {first}, so that Autoware does not read that id.",
        element.id
    );
    let whole: String = value.chars().filter(|letter| !letter.is_whitespace()).collect();
    let edit = Edit::SetTag { on: about, key: key.into(), value: whole.into() };
    Some(Finding::new("blank", about, message).fixed_by("remove the blanks", false, vec![edit]))
}

/// Ids that are no traffic lights of the map.
fn targets(map: &MapIndex, element: &RegulatoryElement, key: &str, value: &str) -> Vec<Finding> {
    let ids = value.split(',').filter_map(|id| id.trim().parse::<i64>().ok());
    let wrong = ids.filter(|id| {
        let target = map.map.regulatory_elements.get(RegulatoryElementId(*id));
        target.is_none_or(|target| target.subtype != "traffic_light")
    });
    let findings = wrong.map(|id| {
        let message =
            format!("{key} of traffic light {} names {id}, which is no traffic light element of the map.", element.id);
        Finding::new("target", Subject::RegulatoryElement(element.id.0), message)
    });
    findings.collect()
}
