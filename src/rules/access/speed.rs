//! Lanelets on which Lanelet2 reads a limit of 0 km/h.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::Lanelet;
use crate::lanelet::index::MapIndex;
use crate::lanelet::participants::{PARTICIPANTS, may_enter, speed_limit};

pub fn judge(map: &MapIndex) -> Vec<Finding> {
    map.map.lanelets.iter().filter_map(standstill).collect()
}

fn standstill(lanelet: &Lanelet) -> Option<Finding> {
    let (id, tags) = (lanelet.id, &lanelet.attributes);
    let may = PARTICIPANTS.into_iter().filter(|who| may_enter(tags, who));
    let who = may.filter(|who| speed_limit(tags, who).is_some_and(|limit| limit <= 0.0)).min_by_key(|who| who.len())?;
    // The limit of a road is judged by vm-01-09 where no other tag hides it.
    let is_road = matches!(tags.get("subtype"), Some("road" | "private"));
    let limits: Vec<(&str, &str)> = tags.iter().filter(|(key, _)| key.starts_with("speed_limit")).collect();
    let hiding = limits.iter().any(|(key, _)| *key != "speed_limit");
    // A key with a blank is tag/key's.
    let is_misspelt = limits.iter().any(|(key, _)| key.contains(char::is_whitespace));
    if is_misspelt || is_road && !hiding {
        return None;
    }
    let said: Vec<String> = limits.iter().map(|(key, value)| format!("{key}={value}")).collect();
    let message = format!("{who} may drive 0 km/h on lanelet {id}, as Lanelet2 reads {}.", said.join(", "));
    let finding = Finding::new("standstill", Subject::Lanelet(id.0), message);
    let own = format!("speed_limit:{who}");
    let hidden = tags.has("speed_limit") && tags.has(&own);
    let wanted: Option<(&str, &str)> = if hidden { Some((own.as_str(), "the limit of all holds then")) } else { None };
    Some(match wanted {
        Some((key, why)) => {
            let edits = vec![Edit::RemoveTag { on: Subject::Lanelet(id.0), key: key.into() }];
            finding.fixed_by(format!("remove {key}; {why}"), false, edits)
        }
        None => finding,
    })
}
