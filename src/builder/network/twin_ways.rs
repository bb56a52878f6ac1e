//! Ways over the same nodes are one road: a street was drawn once for each direction, or twice.

use std::borrow::Cow;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::{OsmData, Tags, Way};

use super::access::{AccessVerdict, classify};

/// Keys that tell of the direction of a one-way road, and get a direction where it becomes one of two.
const OF_DIRECTION: [&str; 4] = ["lanes", "maxspeed", "destination", "placement"];

/// Puts ways in the place of others over the same nodes: the one with the lowest id stays, the others are no roads. `corrected` has
/// the ways whose tags differ from the data.
pub(super) fn unite(osm: &OsmData, corrected: &mut FxHashMap<i64, Way>, notes: &mut Vec<Finding>) {
    let mut by_ends: FxHashMap<(i64, i64, usize), Vec<&Way>> = FxHashMap::default();
    for way in osm.ways.iter().filter(|way| way.tags.has("highway")) {
        if let (Some(&first), Some(&last)) = (way.nodes.first(), way.nodes.last()) {
            by_ends.entry((first.min(last), first.max(last), way.nodes.len())).or_default().push(way);
        }
    }
    let mut groups: Vec<Vec<&Way>> = by_ends.into_values().filter(|ways| ways.len() > 1).collect();
    groups.iter_mut().for_each(|ways| ways.sort_unstable_by_key(|way| way.id));
    groups.sort_unstable_by_key(|ways| ways.first().map(|way| way.id));
    let mut changed: Vec<Way> = Vec::new();
    for ways in groups {
        let mut left: Vec<Cow<'_, Way>> = ways.into_iter().map(|way| in_force(corrected, way)).collect();
        left.retain(|way| matches!(classify(way), AccessVerdict::Road(_)));
        while let [kept, ..] = &left[..] {
            let kept = kept.clone();
            left.remove(0);
            let of_same_nodes = |other: &Cow<'_, Way>| {
                other.id != kept.id
                    && (other.nodes == kept.nodes || other.nodes.iter().eq(kept.nodes.iter().rev()))
                    && level(&other.tags) == level(&kept.tags)
            };
            let Some(at) = left.iter().position(of_same_nodes) else { continue };
            let twin = left.remove(at);
            let reversed =
                twin.nodes != kept.nodes || is_palindrome(&kept.nodes) && !same_direction(&kept.tags, &twin.tags);
            let tags = united(&kept.tags, &twin.tags, reversed);
            let message =
                format!("ways {} and {} run over the same nodes; they are built as one road", kept.id, twin.id);
            let note = Finding::new("way-twin", Subject::Way(kept.id), message).with(Subject::Way(twin.id), "the same");
            notes.push(note.graded(Severity::Warning));
            let mut gone = twin.into_owned();
            gone.tags = Tags::default();
            changed.push(gone);
            let one = Way { tags, ..kept.into_owned() };
            changed.push(one.clone());
            left.insert(0, Cow::Owned(one));
        }
    }
    corrected.extend(changed.into_iter().map(|way| (way.id, way)));
}

/// A way with the tags that count.
fn in_force<'a>(corrected: &FxHashMap<i64, Way>, way: &'a Way) -> Cow<'a, Way> {
    corrected.get(&way.id).cloned().map_or(Cow::Borrowed(way), Cow::Owned)
}

fn level(tags: &Tags) -> [Option<&str>; 3] {
    ["layer", "bridge", "tunnel"].map(|key| tags.get(key))
}

fn is_palindrome(nodes: &[i64]) -> bool {
    nodes.iter().eq(nodes.iter().rev())
}

fn same_direction(a: &Tags, b: &Tags) -> bool {
    a.get("oneway") == b.get("oneway")
}

/// Whether a way leads one way: along it, or against it.
fn one_way(tags: &Tags) -> Option<bool> {
    match tags.get("oneway")? {
        "yes" | "true" | "1" => Some(true),
        "-1" | "reverse" => Some(false),
        _ => None,
    }
}

/// The tags of one road for two ways; the nodes of the second may run the other way (`reversed`). Two one-way roads against each other
/// are a road with two directions, and a two-way road beside a one-way one is two-way.
fn united(kept: &Tags, twin: &Tags, reversed: bool) -> Tags {
    let (own, other) = (one_way(kept), one_way(twin).map(|along| along != reversed));
    match (own, other) {
        (Some(own), Some(other)) if own != other => {
            let mut tags: Tags = with_direction(kept, own).collect();
            for (key, value) in with_direction(twin, other) {
                if !tags.has(&key) {
                    tags.push(key, value);
                }
            }
            tags.set("oneway", "no");
            tags
        }
        (Some(_), None) if !reversed => twin.clone(),
        (Some(_), None) => {
            let mut tags = kept.clone();
            tags.set("oneway", "no");
            tags
        }
        _ => kept.clone(),
    }
}

/// The tags of a one-way road as those of one direction.
fn with_direction(tags: &Tags, along: bool) -> impl Iterator<Item = (String, &str)> {
    let suffix = if along { ":forward" } else { ":backward" };
    tags.iter().filter(|(key, _)| !key.starts_with("oneway")).map(move |(key, value)| {
        let directed = OF_DIRECTION.contains(&key) || key.ends_with(":lanes");
        (if directed { format!("{key}{suffix}") } else { key.to_owned() }, value)
    })
}
