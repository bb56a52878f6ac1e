//! The versions that a map gives itself in `<MetaInfo>`.

use quick_xml::escape::escape;

use crate::osm::element::Element;
use crate::osm::{OsmData, attribute};

/// The text of ours with the versions that theirs has changed; of two numbers that both have raised, the higher.
pub(super) fn merged(text: &str, maps: [&OsmData; 3]) -> String {
    let versions = maps.map(|osm| osm.meta.clone().unwrap_or_default());
    let [base, ours, theirs] = versions.each_ref();
    let mut text = text.to_owned();
    for (name, said) in [
        ("format_version", [&base.format_version, &ours.format_version, &theirs.format_version]),
        ("map_version", [&base.map_version, &ours.map_version, &theirs.map_version]),
    ] {
        let [was, own, other] = said.map(|version| version.as_deref());
        let number = |version: Option<&str>| version.and_then(|version| version.trim().parse::<u64>().ok());
        let is_newer = own == was || number(own).zip(number(other)).is_some_and(|(own, other)| own < other);
        if let Some(version) = other.filter(|_| other != was && other != own && is_newer) {
            set(&mut text, name, version);
        }
    }
    text
}

/// Writes a version into the head of a map.
fn set(text: &mut String, name: &str, version: &str) {
    const META: &str = "<MetaInfo";
    let escaped = escape(version);
    if let Some(start) = text.find(META) {
        let Some(end) = text.get(start..).and_then(|rest| rest.find('>')).map(|end| start + end + 1) else { return };
        let tag = text.get(start..end).unwrap_or_default().to_owned();
        let written = match attribute(&tag, name) {
            Some((from, to)) => {
                [tag.get(..from), Some(escaped.as_ref()), tag.get(to..)].into_iter().flatten().collect()
            }
            None => tag.replacen(META, &format!("{META} {name}=\"{escaped}\""), 1),
        };
        text.replace_range(start..end, &written);
        return;
    }
    let root = text.find("<osm").and_then(|start| Some(start + text.get(start..)?.find('>')? + 1));
    if let Some(behind) = root {
        let mut element = Element::without_id("MetaInfo", "\n  ");
        element.set_attribute(name, version);
        text.insert_str(behind, &element.render());
    }
}
