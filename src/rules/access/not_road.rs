//! Lanelets that vehicles should drive on, and Autoware does not, because their subtype is not `road`.

use std::collections::BTreeMap;

use crate::diagnostic::{Edit, Finding, Place, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::number::{number, speed_with_unit};
use crate::lanelet::participants::{may_enter, names_anybody};
use crate::lanelet::vocabulary::{On, Slip, lanelet_subtypes, slip};
use crate::lanelet::{Attributes, Lanelet};
use crate::rules::lane_kinds::renaming;
use crate::text::counted;

/// What Lanelet2 lets every vehicle on, besides `road`.
const FOR_VEHICLES: [&str; 3] = ["highway", "play_street", "exit"];

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    let meant: Vec<bool> = map.lanes.iter().map(|lane| should_be_road(lane.lanelet)).collect();
    let mut seen = vec![false; map.lanes.len()];
    let mut findings = Vec::new();
    for first in (0..map.lanes.len()).filter(|&lane| meant[lane]) {
        let subtype = |lane: usize| map.lanes[lane].lanelet.attributes.get("subtype").unwrap_or_default();
        if std::mem::replace(&mut seen[first], true) {
            continue;
        }
        let mut group = vec![first];
        let mut next = 0;
        while let Some(&lane) = group.get(next) {
            next += 1;
            let beside = map.lanes[lane].bounds.into_iter().flat_map(|way| map.users_of(way));
            for &other in map.followers(lane).iter().chain(map.predecessors(lane)).chain(beside) {
                if meant[other] && subtype(other) == subtype(first) && !std::mem::replace(&mut seen[other], true) {
                    group.push(other);
                }
            }
        }
        group.sort_unstable();
        findings.push(group_finding(map, subtype(first), &group));
    }
    // On such a map Autoware drives nowhere.
    if !map.lanes.iter().any(|lane| lane.lanelet.attributes.is("subtype", "road")) {
        findings = findings.into_iter().map(|finding| finding.graded(Severity::Error)).collect();
    }
    findings
}

/// Whether vehicles are meant to drive on it, and its subtype is none that Autoware knows for something else. A subtype that is a
/// slip of the pen is told of as such.
fn should_be_road(lanelet: &Lanelet) -> bool {
    let tags = &lanelet.attributes;
    let subtype = tags.get("subtype").unwrap_or_default();
    let is_other = lanelet_subtypes().any(|known| known == subtype) && !FOR_VEHICLES.contains(&subtype);
    if is_other || slip(On::Lanelet, tags, "subtype", subtype).is_some() {
        return false;
    }
    !names_anybody(tags) || may_enter(tags, "vehicle") || may_enter(tags, "vehicle:car")
}

/// The subtype that a lanelet should have by what this rule and the rule of misspelt tags say of it; else the one that it has.
pub fn meant_subtype(lanelet: &Lanelet) -> &str {
    let tags = &lanelet.attributes;
    let subtype = tags.get("subtype").unwrap_or_default();
    match slip(On::Lanelet, tags, "subtype", subtype) {
        Some(Slip::Value(meant)) => meant,
        _ if should_be_road(lanelet) => "road",
        _ => subtype,
    }
}

fn group_finding(map: &MapIndex, subtype: &str, group: &[usize]) -> Finding {
    let lanelets: Vec<&Lanelet> = group.iter().map(|&lane| map.lanes[lane].lanelet).collect();
    let has = match subtype {
        "" => "no subtype".to_owned(),
        _ => format!("subtype {subtype}"),
    };
    let all = lanelets.iter().all(|lanelet| may_enter(&lanelet.attributes, "vehicle"));
    let library = match all {
        true => "Lanelet2 alone would let vehicles on",
        false => "Lanelet2 lets no vehicle on either",
    };
    let first = group[0];
    let (id, count) = (map.lanes[first].id, counted(group.len(), "connected lanelet"));
    let message = match group.len() {
        1 => format!("Lanelet {id} has {has}: Autoware drives on subtype road only; {library}."),
        _ => format!("{count}, {id} the first, have {has}: Autoware drives on subtype road only; {library}."),
    };
    let finding = Finding::new("not-road", Subject::Lanelet(id.0), message);
    let finding = finding.at(Place::Polygon(map.lanes[first].outline.clone()));
    let edits: Vec<Edit> = lanelets.iter().flat_map(|lanelet| edits(lanelet)).collect();
    if edits.is_empty() {
        return finding;
    }
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    for edit in &edits {
        if let Edit::SetTag { key, .. } = edit {
            *kinds.entry(key.as_str()).or_default() += 1;
        }
    }
    let set: Vec<String> = kinds.into_iter().map(|(key, count)| format!("{key} on {count}")).collect();
    finding.fixed_by(format!("set {}", set.join(", ")), false, edits)
}

/// What the tags of OpenStreetMap say in Autoware's words; what is said already stays. Nothing for subtypes of which nobody
/// knows what they mean.
fn edits(lanelet: &Lanelet) -> Vec<Edit> {
    let (tags, on) = (&lanelet.attributes, Subject::Lanelet(lanelet.id.0));
    let subtype = tags.get("subtype").unwrap_or_default();
    if !subtype.is_empty() && !FOR_VEHICLES.contains(&subtype) && !matches!(subtype, "street" | "lane" | "driving") {
        return Vec::new();
    }
    let kind = kind_of_way(tags);
    let mut edits: Vec<Edit> = match kind {
        "road" if subtype == "highway" => renaming(lanelet, "road").collect(),
        _ => vec![Edit::SetTag { on, key: "subtype".into(), value: kind.into() }],
    };
    let said = [("one_way", one_way(tags)), ("speed_limit", speed(tags)), ("location", location(tags))];
    for (key, value) in said.into_iter().filter(|(key, _)| tags.get(key).is_none_or(str::is_empty)) {
        edits.extend(value.map(|value| Edit::SetTag { on, key: key.into(), value: value.as_str().into() }));
    }
    edits
}

fn kind_of_way(tags: &Attributes) -> &'static str {
    match tags.get("highway") {
        Some("footway" | "pedestrian" | "path" | "steps") => "walkway",
        Some("cycleway") => "bicycle_lane",
        _ => "road",
    }
}

fn one_way(tags: &Attributes) -> Option<String> {
    match tags.get("oneway")? {
        "yes" | "true" | "1" => Some("yes".to_owned()),
        "no" | "false" | "0" => Some("no".to_owned()),
        _ => None,
    }
}

/// `maxspeed` in km/h, without a unit.
fn speed(tags: &Attributes) -> Option<String> {
    let said = tags.get("maxspeed")?;
    let speed = number(said).or_else(|| speed_with_unit(said)).filter(|speed| *speed > 0.0 && speed.is_finite())?;
    Some(((speed * 10.0).round() / 10.0).to_string())
}

/// Private ground by `access`; in a town by the street's class, or by which speed limits hold there.
fn location(tags: &Attributes) -> Option<String> {
    let town = matches!(tags.get("highway"), Some("residential" | "living_street"));
    let zone = ["zone:traffic", "source:maxspeed", "maxspeed:type"].into_iter().filter_map(|key| tags.get(key));
    let mut zone = zone.filter(|zone| zone.ends_with(":urban"));
    match tags.get("access") {
        Some("private") => Some("private".to_owned()),
        _ => (town || zone.next().is_some()).then(|| "urban".to_owned()),
    }
}
