//! Who may enter a lanelet, and how fast, as Lanelet2 1.2.3 reads its tags (`GenericTrafficRules.cpp`).

use super::Attributes;
use super::number::{leading_number, number};

/// Everybody whom Lanelet2 knows.
pub const PARTICIPANTS: [&str; 12] = [
    "vehicle",
    "vehicle:car",
    "vehicle:car:electric",
    "vehicle:car:combustion",
    "vehicle:bus",
    "vehicle:truck",
    "vehicle:motorcycle",
    "vehicle:taxi",
    "vehicle:emergency",
    "pedestrian",
    "bicycle",
    "train",
];

/// Whom a subtype lets in where no tag names anybody; a participant is let in with all that its name begins.
const BY_SUBTYPE: &[(&str, &[&str])] = &[
    ("", &["vehicle"]),
    ("road", &["vehicle", "bicycle"]),
    ("highway", &["vehicle"]),
    ("bicycle_lane", &["bicycle"]),
    ("play_street", &["pedestrian", "bicycle", "vehicle"]),
    ("emergency_lane", &["vehicle:emergency"]),
    ("bus_lane", &["vehicle:bus", "vehicle:emergency", "vehicle:taxi"]),
    ("exit", &["pedestrian", "bicycle", "vehicle"]),
    ("walkway", &["pedestrian"]),
    ("crosswalk", &["pedestrian"]),
    ("stairs", &["pedestrian"]),
    ("shared_walkway", &["pedestrian", "bicycle"]),
];

/// The tag that decides for a participant: of those that begin as `KEY:PARTICIPANT` does, down to `least` letters, the first by
/// name, so that `participant` hides `participant:vehicle`, and that hides `participant:vehicle:car`.
fn deciding<'a>(tags: &'a Attributes, least: usize, whole: &str) -> Option<(&'a str, &'a str)> {
    let begins = |(key, _): &(&str, &str)| key.len() >= least && whole.starts_with(key);
    tags.iter().filter(begins).min()
}

/// Whether any tag names who may enter; who is not named then may not.
pub fn names_anybody(tags: &Attributes) -> bool {
    tags.iter().any(|(key, _)| key.starts_with("participant"))
}

/// The tag that decides whether a participant may enter, if one does.
pub fn deciding_entry<'a>(tags: &'a Attributes, participant: &str) -> Option<(&'a str, &'a str)> {
    deciding(tags, "participant".len(), &format!("participant:{participant}"))
}

/// Whether a participant may enter a lanelet.
pub fn may_enter(tags: &Attributes, participant: &str) -> bool {
    if names_anybody(tags) {
        let said = deciding_entry(tags, participant).map(|(_, value)| value);
        return matches!(said, Some("yes" | "true" | "1"));
    }
    let subtype = tags.get("subtype").unwrap_or_default();
    let who = BY_SUBTYPE.iter().find(|(name, _)| *name == subtype).map_or(&[][..], |(_, who)| who);
    who.iter().any(|who| participant.starts_with(who))
}

/// The speed limit that tags give a participant, km/h; `None` where no tag speaks of one. A text that is no speed is 0.
pub fn speed_limit(tags: &Attributes, participant: &str) -> Option<f64> {
    tags.iter().any(|(key, _)| key.starts_with("speed_limit")).then(|| {
        let of_all = tags.get("speed_limit").and_then(velocity);
        let own = deciding(tags, "speed_limit:".len(), &format!("speed_limit:{participant}"));
        own.and_then(|(_, value)| velocity(value)).or(of_all).unwrap_or(0.0)
    })
}

/// A speed in km/h: a number alone, or one with a unit that Lanelet2 finds in what follows.
fn velocity(text: &str) -> Option<f64> {
    if let Some(alone) = number(text) {
        return Some(alone);
    }
    const UNITS: [(&[&str], f64); 3] = [(&["m/s", "mps"], 3.6), (&["km/h", "kmh"], 1.0), (&["m/h", "mph"], 1.609_344)];
    let factor =
        UNITS.iter().find(|(names, _)| names.iter().any(|name| text.contains(name))).map(|(_, factor)| factor)?;
    Some(leading_number(text)? * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(said: &[(&'static str, &'static str)]) -> Attributes {
        said.iter().copied().collect()
    }

    #[test]
    fn a_group_hides_its_parts_and_who_is_not_named_stays_out() {
        let road = |own: &[(&'static str, &'static str)]| {
            let tags = tags(&[&[("subtype", "road")], own].concat());
            PARTICIPANTS.into_iter().filter(|who| may_enter(&tags, who)).count()
        };
        assert_eq!(road(&[]), 10);
        assert_eq!(road(&[("participant:vehicle:truck", "no")]), 0);
        assert_eq!(road(&[("participant:vehicle", "no"), ("participant:vehicle:car", "yes")]), 0);
        assert_eq!(road(&[("participant:vehicle", "yes"), ("participant:vehicle:car", "no")]), 9);
        assert_eq!(road(&[("participant:vehicle", "designated")]), 0);
    }

    #[test]
    fn texts_that_are_no_speed_are_0() {
        let limit = |own: &[(&'static str, &'static str)]| speed_limit(&tags(own), "vehicle");
        assert_eq!(limit(&[]), None);
        assert_eq!(limit(&[("speed_limit", "50")]), Some(50.0));
        assert_eq!(limit(&[("speed_limit", "none")]), Some(0.0));
        assert_eq!(limit(&[("speed_limit", "10 m/s")]), Some(36.0));
        assert_eq!(limit(&[("speed_limit", "50"), ("speed_limit:vehicle", "0")]), Some(0.0));
        assert_eq!(limit(&[("speed_limit_mandatory", "yes")]), Some(0.0));
    }
}
