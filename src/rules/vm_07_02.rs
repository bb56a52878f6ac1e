//! vm-07-02: lines behind which nobody steps onto the road are said so that they are seen.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::lanelet::index::MapIndex;

use super::NoParams;
use super::barrier::KINDS;

pub fn check(map: &MapIndex, _: &NoParams) -> Vec<Finding> {
    let polygons = map.map.polygons.iter().filter_map(|polygon| {
        let kind = polygon.attributes.get("type").filter(|kind| KINDS.contains(kind))?;
        let on = Subject::Polygon(polygon.id.0);
        let message = format!("The {kind} {} has area=yes and is no line for Autoware.", polygon.id);
        let edits = vec![Edit::RemoveTag { on, key: "area".into() }];
        Some(Finding::new("area", on, message).fixed_by("remove the tag area", false, edits))
    });
    let words = map.map.linestrings.iter().filter_map(|line| {
        let said = line.attributes.get("type")?;
        let meant = meant(said)?;
        let on = Subject::LineString(line.id.0);
        let message = format!("Linestring {} has type={said}; Autoware knows {meant}.", line.id);
        let edits = vec![Edit::SetTag { on, key: "type".into(), value: meant.into() }];
        Some(Finding::new("word", on, message).fixed_by(format!("set type={meant}"), true, edits))
    });
    polygons.chain(words).collect()
}

/// The valid word that a wrong one stands for: it differs only in case, blanks or an `s` at the end, or the wrong one is the
/// usual name of the thing.
pub fn meant(said: &str) -> Option<&'static str> {
    if KINDS.contains(&said) {
        return None;
    }
    let plain: String = said.chars().filter(|c| c.is_ascii_alphabetic()).map(|c| c.to_ascii_lowercase()).collect();
    let plain = plain.strip_suffix('s').unwrap_or(&plain);
    match plain {
        "guardrail" | "guardpipe" | "crashbarrier" => Some("guard_rail"),
        "wall" => Some("wall"),
        "fence" => Some("fence"),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn other_words_for_barriers_are_known() {
        for (said, expected) in [
            ("guard_rail", None),
            ("guardrail", Some("guard_rail")),
            ("Guard-Rails", Some("guard_rail")),
            ("Fence", Some("fence")),
            ("walls", Some("wall")),
            ("wallpaper", None),
            ("curbstone", None),
        ] {
            assert_eq!(meant(said), expected, "{said}");
        }
    }
}
