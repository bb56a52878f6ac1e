//! What changed between two versions of a map as a page to look at: every element that came, went or changed, before and after side
//! by side.

use std::io;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use super::data::{kind, relative};
use super::fix_preview::shape_of;
use super::plane::Frame;
use super::{JOSM, MAIN, Page, SCRIPTS, deflate, facts, filled, pack};
use crate::diagnostic::Subject;
use crate::lanelet::{LaneletMap, RegulatoryElementId};
use crate::report::diff::{Change, Diff, Kind};
use crate::report::{Report, Sources};

/// What people look for first comes first.
const GROUPS: [&str; 6] =
    ["Lanelets", "Rights of way", "Traffic lights", "Other regulatory elements", "Areas", "Lines"];

/// The page of a diff; `names` are those of the old and the new map.
///
/// # Errors
///
/// If the data cannot be compressed.
pub fn changes_page(diff: &Diff, maps: [&LaneletMap; 2], names: [&str; 2]) -> io::Result<String> {
    let [old, new] = maps;
    // A map that lost all its points has a plane all the same.
    let frame = Frame::of(if new.points.is_empty() { old } else { new }, None);
    let title = format!("{} → {}", names[0], names[1]);
    let sources = Sources::new([]);
    let page = Page { title: &title, ..Page::default() };
    let mut facts = facts(&Report::new(&[], &sources, new), &page, &frame);
    facts["diff"] = json!({ "names": names, "groups": GROUPS, "changes": changes(diff, maps, &frame) });
    let data = STANDARD.encode(deflate(facts.to_string().as_bytes())?);
    let [old, new] = [old, new].map(|map| pack::pack(map, &frame).map(|packed| STANDARD.encode(packed)));
    let scripts = [&SCRIPTS[..SCRIPTS.len() - 1], &[include_str!("changes.js")], &[MAIN]].concat();
    let text = filled(&title, "", &scripts, JOSM, Some([&data, &new?]));
    let before = format!("<script type=\"application/octet-stream\" id=\"old-map-data\">{}</script>\n<script>", old?);
    Ok(text.replacen("<script>", &before, 1))
}

/// Every change but those of single points, which show in the lines that they are part of.
fn changes(diff: &Diff, maps: [&LaneletMap; 2], frame: &Frame) -> Vec<Value> {
    let told = diff.changes.iter().filter(|change| !matches!(change.subject, Subject::Point(_)));
    told.map(|change| one(change, maps, frame)).collect()
}

fn one(change: &Change, [old, new]: [&LaneletMap; 2], frame: &Frame) -> Value {
    let map = if change.change == Kind::Removed { old } else { new };
    let shape: Vec<(bool, Vec<[f64; 2]>)> = shape_of(map, change.subject)
        .into_iter()
        .map(|(closed, points)| (closed, points.iter().map(|point| relative(*point, frame)).collect()))
        .collect();
    json!({
        "subject": [kind(change.subject), change.subject.id().map(|id| id.to_string())],
        "change": change.change,
        "group": group(change.subject, map),
        "facts": change.facts.iter().map(ToString::to_string).collect::<Vec<_>>(),
        "shape": shape,
    })
}

/// The number of a subject's group in [`GROUPS`].
fn group(subject: Subject, map: &LaneletMap) -> usize {
    match subject {
        Subject::Lanelet(_) => 0,
        Subject::RegulatoryElement(id) => {
            let subtype = map.regulatory_elements.get(RegulatoryElementId(id)).map(|element| element.subtype.as_str());
            match subtype {
                Some("right_of_way") => 1,
                Some("traffic_light") => 2,
                _ => 3,
            }
        }
        Subject::Polygon(_) | Subject::Relation(_) => 4,
        _ => 5,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_old_map_stands_before_the_script_that_reads_it() {
        let map = LaneletMap::default();
        let diff = Diff::between(&map, &map, 0.001);
        let page = changes_page(&diff, [&map, &map], ["a <b>", "c"]).unwrap();
        let [old, script] = ["id=\"old-map-data\"", "'use strict'"].map(|mark| page.find(mark).unwrap());
        assert!(old < script && page.contains("<title>a &lt;b&gt; → c"), "{}", &page[..400]);
        assert_eq!(page.matches("id=\"old-map-data\"").count(), 1);
    }
}
