//! Lanelets whose tags let nobody in, or others than they seem to.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::participants::{PARTICIPANTS, deciding_entry, may_enter, names_anybody};
use crate::lanelet::{Attributes, Lanelet, LaneletId};

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    // Who walks on crosswalks and walkways is judged by vm-05-01 and vm-01-19.
    let is_for_people = |lanelet: &&Lanelet| matches!(lanelet.attributes.get("subtype"), Some("crosswalk" | "walkway"));
    let named = map.map.lanelets.iter().filter(|lanelet| names_anybody(&lanelet.attributes) && !is_for_people(lanelet));
    let mut findings = Vec::new();
    let mut shut = FxHashSet::default();
    for lanelet in named {
        if let Some(finding) = closed(lanelet) {
            findings.push(finding);
            shut.insert(lanelet.id);
        } else {
            findings.extend(hidden(lanelet));
        }
    }
    findings.extend(map.map.lanelets.iter().flat_map(hidden_ways));
    findings.extend(cut_off(map, &shut));
    findings
}

/// Whether nobody may enter, or of all vehicles only some that Autoware does not ask for.
fn closed(lanelet: &Lanelet) -> Option<Finding> {
    let (id, tags) = (lanelet.id, &lanelet.attributes);
    let is_road = tags.is("subtype", "road");
    let said: Vec<String> = participants(tags).map(|(key, value)| format!("{key}={value}")).collect();
    let said = said.join(", ");
    let message = if !PARTICIPANTS.into_iter().any(|who| may_enter(tags, who)) {
        format!("Nobody may enter lanelet {id}: it has {said}, and who is not named may not.")
    } else if is_road && !may_enter(tags, "vehicle") && may_enter(tags, "vehicle:car") {
        format!("Autoware may not enter lanelet {id}: it asks as participant vehicle, and the lanelet has {said}.")
    } else {
        return None;
    };
    let finding = Finding::new("closed", Subject::Lanelet(id.0), message);
    // Who says no to all vehicles, and no more, means it.
    let meant =
        participants(tags).all(|(key, value)| key == "participant:vehicle" && matches!(value, "no" | "false" | "0"));
    Some(if is_road && !meant { opened(lanelet, finding) } else { finding })
}

/// Adds the fix that lets vehicles in. Tags for kinds of vehicles go: none of them counts beside the one for all.
fn opened(lanelet: &Lanelet, finding: Finding) -> Finding {
    let on = Subject::Lanelet(lanelet.id.0);
    let kinds = participants(&lanelet.attributes)
        .filter(|(key, _)| *key == "participant" || key.starts_with("participant:vehicle:"));
    let mut edits: Vec<Edit> = kinds.map(|(key, _)| Edit::RemoveTag { on, key: key.into() }).collect();
    edits.push(Edit::SetTag { on, key: "participant:vehicle".into(), value: "yes".into() });
    finding.fixed_by("set participant:vehicle=yes, in place of the tags for kinds of vehicles", false, edits)
}

/// A tag for a part of a group that says otherwise than the one for the group, which is the one that counts.
fn hidden(lanelet: &Lanelet) -> Option<Finding> {
    let tags = &lanelet.attributes;
    let (key, value, (group, group_says)) = participants(tags).find_map(|(key, value)| {
        let who = key.strip_prefix("participant:").filter(|who| PARTICIPANTS.contains(who))?;
        let deciding = deciding_entry(tags, who).filter(|(group, said)| *group != key && yes(said) != yes(value))?;
        Some((key, value, deciding))
    })?;
    let message =
        format!("{key}={value} of lanelet {} has no effect beside {group}={group_says}, which decides.", lanelet.id);
    Some(Finding::new("hidden", Subject::Lanelet(lanelet.id.0), message))
}

/// Tags that say of a participant that a lane may be driven both ways, or not, beside one for all that says otherwise: Lanelet2
/// takes the one for all.
fn hidden_ways(lanelet: &Lanelet) -> Vec<Finding> {
    let (id, tags) = (lanelet.id, &lanelet.attributes);
    let Some(all) = tags.get("one_way") else { return Vec::new() };
    let own = tags.iter().filter(|(key, value)| key.starts_with("one_way:") && yes(value) != yes(all));
    let told = own.map(|(key, value)| {
        let message = format!("{key}={value} of lanelet {id} has no effect beside one_way={all}, which decides.");
        Finding::new("hidden", Subject::Lanelet(id.0), message)
    });
    told.collect()
}

fn yes(value: &str) -> bool {
    matches!(value, "yes" | "true" | "1")
}

/// Roads whose only ways on are closed.
fn cut_off(map: &MapIndex, shut: &FxHashSet<LaneletId>) -> Vec<Finding> {
    if shut.is_empty() {
        return Vec::new();
    }
    let is_shut = |lane: usize| shut.contains(&map.lanes[lane].id);
    let open = (0..map.lanes.len()).filter(|&lane| map.lanes[lane].vehicle && !is_shut(lane));
    let losing =
        open.filter(|&lane| !map.followers(lane).is_empty() && map.followers(lane).iter().all(|&next| is_shut(next)));
    let findings = losing.map(|lane| {
        let id = map.lanes[lane].id;
        let next: Vec<LaneletId> = map.followers(lane).iter().map(|&next| map.lanes[next].id).collect();
        let names: Vec<String> = next.iter().map(LaneletId::to_string).collect();
        let message = format!("Lane {id} leads only into {}, where the tags let nobody in.", names.join(", "));
        let finding = Finding::new("cut-off", Subject::Lanelet(id.0), message);
        next.into_iter().fold(finding, |finding, id| finding.with(Subject::Lanelet(id.0), "closed lanelet"))
    });
    findings.collect()
}

fn participants(tags: &Attributes) -> impl Iterator<Item = (&str, &str)> {
    tags.iter().filter(|(key, _)| key.starts_with("participant"))
}
