//! Tags that hold ids of other elements.

use std::borrow::Cow;

use rustc_hash::FxHashMap;

use super::versions::Key;
use crate::osm::ElementKind;

/// Their value is the id of a way.
const OF_A_WAY: [&str; 3] = ["intersection_area", "traffic_light_id", "waypoints"];
/// Their value is a list of ids of lanelets.
const OF_LANELETS: [&str; 2] = ["exit_turn_signal_left", "exit_turn_signal_right"];
/// What keys begin with whose value is a list of ids of regulatory elements.
const OF_LIGHTS: &str = "signal_color_relation:";
/// Their key is the id of a lanelet.
const KEYED_BY_A_LANELET: [&str; 2] = ["turn_signal_left", "turn_signal_right"];

/// The kind of the elements whose ids stand in the value of a tag.
fn kind_of_value(key: &str) -> Option<ElementKind> {
    match key {
        key if OF_A_WAY.contains(&key) => Some(ElementKind::Way),
        key if OF_LANELETS.contains(&key) || key.starts_with(OF_LIGHTS) => Some(ElementKind::Relation),
        _ => None,
    }
}

/// The elements that a tag names.
pub(super) fn named(key: &str, value: &str) -> Vec<Key> {
    if KEYED_BY_A_LANELET.contains(&value) {
        return key.trim().parse().map(|id| (ElementKind::Relation, id)).into_iter().collect();
    }
    let Some(kind) = kind_of_value(key) else { return Vec::new() };
    numbers(value).filter_map(|(_, digits)| Some((kind, digits.parse().ok()?))).collect()
}

/// A tag with other ids: its key and its value.
pub(super) fn renamed<'t>(key: &'t str, value: &'t str, new: &FxHashMap<Key, i64>) -> (Cow<'t, str>, Cow<'t, str>) {
    if KEYED_BY_A_LANELET.contains(&value) {
        let id = key.trim().parse().ok().and_then(|id| new.get(&(ElementKind::Relation, id)));
        return (id.map_or(Cow::Borrowed(key), |id| Cow::Owned(id.to_string())), Cow::Borrowed(value));
    }
    let Some(kind) = kind_of_value(key) else { return (Cow::Borrowed(key), Cow::Borrowed(value)) };
    let mut text = String::with_capacity(value.len());
    let mut copied = 0;
    for (start, digits) in numbers(value) {
        if let Some(id) = digits.parse().ok().and_then(|id| new.get(&(kind, id))) {
            text += value.get(copied..start).unwrap_or_default();
            text += &id.to_string();
            copied = start + digits.len();
        }
    }
    if copied == 0 {
        return (Cow::Borrowed(key), Cow::Borrowed(value));
    }
    text += value.get(copied..).unwrap_or_default();
    (Cow::Borrowed(key), Cow::Owned(text))
}

/// The whole numbers of a text, each with the place where it begins.
fn numbers(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let pieces = text.split([',', '[', ']', ' ']);
    let start = |piece: &str| piece.as_ptr() as usize - text.as_ptr() as usize;
    pieces.map(move |piece| (start(piece), piece)).filter(|(_, piece)| piece.parse::<i64>().is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_in_tags_are_found_and_changed_and_nothing_else_is() {
        let new: FxHashMap<Key, i64> =
            [((ElementKind::Way, 5), 50), ((ElementKind::Relation, 5), 55)].into_iter().collect();
        let of = |key: &str, value: &str| {
            let (key, value) = renamed(key, value, &new);
            format!("{key}={value}")
        };
        assert_eq!(of("intersection_area", "5"), "intersection_area=50");
        assert_eq!(of("exit_turn_signal_left", "[4, 5,55]"), "exit_turn_signal_left=[4, 55,55]");
        assert_eq!(of("signal_color_relation:red:green", "5"), "signal_color_relation:red:green=55");
        assert_eq!(of("5", "turn_signal_left"), "55=turn_signal_left");
        assert_eq!(of("speed_limit", "5"), "speed_limit=5");
        assert_eq!(of("intersection_area", "five"), "intersection_area=five");
        assert_eq!(named("exit_turn_signal_left", "4, 5").len(), 2);
        assert_eq!(named("5", "turn_signal_right"), [(ElementKind::Relation, 5)]);
    }
}
