//! The words that Lanelet2, Autoware and map makers write in tags and roles, and whether a tag is one of them or a slip of the pen.

mod meanings;
mod slips;
mod table;

use std::sync::LazyLock;

use rustc_hash::{FxHashMap, FxHashSet};

use super::Attributes;
use crate::text::misspelt;
use meanings::Meanings;
pub use table::{Form, Key, On, Renamed, Roles, Slip, Source, Types, Words};

/// The table, made ready to look things up.
struct Index {
    words: Words,
    /// The keys with `…`, `LAMP` written out, and where each stands in the table.
    keys: Vec<(String, usize)>,
    by_name: FxHashMap<String, usize>,
    meanings: Meanings,
}

static INDEX: LazyLock<Option<Index>> = LazyLock::new(|| {
    let words = Words::parse().ok()?;
    let keys: Vec<(String, usize)> = words
        .key
        .iter()
        .enumerate()
        .flat_map(|(at, key)| words.written_out(key).into_iter().map(move |name| (name, at)))
        .collect();
    let by_name = keys.iter().cloned().collect();
    let meanings = Meanings::new(&words);
    Some(Index { words, keys, by_name, meanings })
});

/// The table; `None` if it was spoilt before compiling, which a test prevents.
pub fn words() -> Option<&'static Words> {
    INDEX.as_ref().map(|index| &index.words)
}

/// What is wrong with one tag of a primitive; `None` where it is known, or foreign.
pub fn slip(on: On, tags: &Attributes, key: &str, value: &str) -> Option<Slip> {
    let index = INDEX.as_ref()?;
    if let Some(now) = index.renamed(on, tags, key, value) {
        return Some(now);
    }
    let known = match index.by_name.get(key) {
        Some(&at) => index.words.key.get(at)?,
        None if is_number(key) => index.words.key.iter().find(|one| one.name == "ID")?,
        None => return index.key(on, tags, key).map(Slip::Key),
    };
    // A bound that is a polygon by mistake keeps the keys of a line; that it is none is told elsewhere.
    let is_line = on == On::Polygon && known.on.contains(&On::LineString);
    if known.own && !known.on.contains(&on) && !is_line {
        return Some(Slip::Elsewhere(&known.on));
    }
    if value.is_empty() {
        return None;
    }
    match known.name.as_str() {
        "type" => index.words.kind(on, value, &index.meanings).map(Slip::Value),
        "subtype" => index.words.subtype(on, tags.get("type"), value, &index.meanings).map(Slip::Value),
        _ => known.value(value, &index.meanings),
    }
}

/// The keys on some primitives that nothing reads and that mean this one, as `elevation` means `ele`.
pub fn other_names<'t>(on: On, key: &str, all: impl Iterator<Item = &'t Attributes>) -> FxHashSet<&'t str> {
    let keys: FxHashSet<&str> = all.flat_map(Attributes::iter).map(|(key, _)| key).collect();
    let tags = Attributes::default();
    keys.into_iter()
        .filter(|said| matches!(slip(on, &tags, said, ""), Some(Slip::Key(meant)) if meant == key))
        .collect()
}

impl Index {
    fn renamed(&'static self, on: On, tags: &Attributes, key: &str, value: &str) -> Option<Slip> {
        let old =
            self.words.renamed.iter().find(|one| {
                one.on.contains(&on) && one.key == key && one.value.as_ref().is_none_or(|old| old == value)
            })?;
        match old.value {
            Some(_) => Some(Slip::RenamedValue(&old.now)),
            None => (!tags.has(&old.now)).then_some(Slip::RenamedKey(&old.now)),
        }
    }

    /// The key that was meant by one that nothing knows.
    fn key(&'static self, on: On, tags: &Attributes, said: &str) -> Option<&'static str> {
        if self.words.foreign.keys.iter().any(|foreign| foreign == said) {
            return None;
        }
        let is_here = |at: usize| self.words.key.get(at).is_some_and(|key| key.on.contains(&on));
        let keys = |here: bool| {
            let keys = self.keys.iter().filter(move |(_, at)| is_here(*at) == here);
            keys.map(|(name, _)| name.as_str())
        };
        // Beside those of its own kind, what somebody wrote on the wrong kind of primitive. Another word is somebody's own where the
        // known one stands beside it.
        misspelt(said, keys(true))
            .or_else(|| misspelt(said, keys(false)))
            .or_else(|| self.key_of_vehicles(said))
            .or_else(|| self.meanings.of(said, keys(true)).filter(|meant| !tags.has(meant)))
    }

    /// The key that names a kind of vehicle alone: `participant:car` for `participant:vehicle:car`.
    fn key_of_vehicles(&'static self, said: &str) -> Option<&'static str> {
        let (head, vehicle) = said.rsplit_once(':')?;
        let whole = format!("{head}:vehicle:{vehicle}");
        self.keys.iter().map(|(name, _)| name.as_str()).find(|name| *name == whole)
    }
}

fn is_number(key: &str) -> bool {
    key.parse::<i64>().is_ok()
}

/// The roles that members may have: of `lanelet`, `multipolygon`, or of a regulatory element by its subtype. `None` where the
/// table does not know it.
pub fn roles(of: &str) -> Option<&'static [String]> {
    words()?.roles.iter().find(|roles| roles.of == of).map(|roles| roles.words.as_slice())
}

/// The subtypes that a lanelet may have.
pub fn lanelet_subtypes() -> impl Iterator<Item = &'static str> {
    words()
        .into_iter()
        .flat_map(|words| words.lists(On::Lanelet))
        .flat_map(|list| list.subtypes.iter().flatten())
        .map(String::as_str)
}

/// The subtype of a light with three lamps, as vehicles obey it.
pub const THREE_LAMPS: &str = "red_yellow_green";

/// The subtypes that a line of some type may have.
pub fn subtypes(kind: &str) -> impl Iterator<Item = &'static str> {
    let lists = words().into_iter().flat_map(|words| words.lists(On::LineString));
    let own = lists.filter(move |list| list.names.iter().any(|name| name == kind));
    own.flat_map(|list| list.subtypes.iter().flatten()).map(String::as_str)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::known_subtypes;

    fn slip_of(on: On, tags: &[(&'static str, &str)], key: &str) -> Option<Slip> {
        let tags: Attributes = tags.iter().copied().collect();
        slip(on, &tags, key, tags.get(key).unwrap())
    }

    #[test]
    fn the_table_is_read_and_knows_every_source_and_element() {
        let words = Words::parse().unwrap();
        for source in words.named_sources() {
            assert!(words.sources.contains_key(source), "{source}");
        }
        for subtype in known_subtypes().filter(|subtype| *subtype != "regulatory_element") {
            assert!(roles(subtype).is_some(), "{subtype} has no roles");
            for limit in crate::lanelet::role_limits(subtype).unwrap() {
                assert!(roles(subtype).unwrap().iter().any(|role| role == limit.role), "{subtype} {}", limit.role);
            }
        }
    }

    #[test]
    fn slips_are_told_and_known_and_foreign_words_are_not() {
        let line = |kind: &'static str| slip_of(On::LineString, &[("type", kind)], "type");
        assert_eq!(line("road_boarder"), Some(Slip::Value("road_border")));
        for known in ["line_thin", "zig-zag", "intersection_area", "invented", ""] {
            assert_eq!(line(known), None, "{known}");
        }
        assert_eq!(line("thin_line"), Some(Slip::Value("line_thin")));
        let sub = |kind: &'static str, subtype: &'static str| {
            slip_of(On::LineString, &[("type", kind), ("subtype", subtype)], "subtype")
        };
        assert_eq!(sub("line_thin", "sold"), Some(Slip::Value("solid")));
        assert_eq!(sub("lin_thin", "soild"), Some(Slip::Value("solid")));
        assert_eq!(sub("curbstone", "hihg"), Some(Slip::Value("high")));
        assert_eq!(sub("line_thin", "dash"), Some(Slip::Value("dashed")));
        assert_eq!(sub("traffic_sign", "de206"), None);
        assert_eq!(sub("traffic_sign", "stop_sgin"), Some(Slip::Value("stop_sign")));
        let lanelet = |key: &'static str, value: &'static str| slip_of(On::Lanelet, &[(key, value)], key);
        assert_eq!(lanelet("turn_directon", "left"), Some(Slip::Key("turn_direction")));
        assert_eq!(lanelet("heigth", "1"), Some(Slip::Key("height")));
        assert_eq!(lanelet("participant_vehicle", "yes"), Some(Slip::Key("participant:vehicle")));
        assert_eq!(lanelet("speed_limit:car", "0"), Some(Slip::Key("speed_limit:vehicle:car")));
        assert_eq!(lanelet("subtype", "Road"), Some(Slip::Value("road")));
        assert_eq!(lanelet("one_way", "ture"), Some(Slip::Form(Form::YesNo, Some("yes".to_owned()))));
        assert_eq!(lanelet("one_way", "1"), Some(Slip::Form(Form::YesNo, Some("yes".to_owned()))));
        for alone in ["no_drivable_lane", "direction_change"] {
            assert_eq!(lanelet(alone, "true"), Some(Slip::Form(Form::YesNoAlone, Some("yes".to_owned()))));
            assert_eq!(lanelet(alone, "yes"), None);
        }
        assert_eq!(lanelet("direction_change_lane", "yes"), Some(Slip::RenamedKey("direction_change")));
        let both = [("direction_change_lane", "yes"), ("direction_change", "yes")];
        assert_eq!(slip_of(On::Lanelet, &both, "direction_change_lane"), None);
        let polygon = slip_of(On::Polygon, &[("type", "map_area_filter")], "type");
        assert_eq!(polygon, Some(Slip::RenamedValue("obstacle_removal_area")));
        assert_eq!(lanelet("301599", "turn_signal_right"), None);
        assert_eq!(lanelet("301599", "turn_singal_right"), Some(Slip::Value("turn_signal_right")));
        let line = |key, value| slip_of(On::LineString, &[(key, value)], key);
        assert_eq!(line("turn_direction", "left"), Some(Slip::Elsewhere(&[On::Lanelet])));
        assert_eq!(line("participant:vehicle", "no"), Some(Slip::Elsewhere(&[On::Lanelet, On::Area])));
        assert_eq!(lanelet("lane_change", "yes"), Some(Slip::Elsewhere(&[On::LineString])));
        assert_eq!(lanelet("width", "3.5"), None);
        for foreign in ["oneway", "highway", "junction_id", "2237", "anything"] {
            assert_eq!(lanelet(foreign, "yes"), None, "{foreign}");
        }
    }

    #[test]
    fn other_words_of_the_same_meaning_are_told() {
        let value = |on: On, kind: &str, subtype: &str| {
            let key = if subtype.is_empty() { "type" } else { "subtype" };
            let tags: Attributes = [("type", kind), ("subtype", subtype)].into_iter().collect();
            match slip(on, &tags, key, tags.get(key).unwrap()) {
                Some(Slip::Value(meant)) => meant,
                None => "",
                other => panic!("{kind} {subtype}: {other:?}"),
            }
        };
        for (said, meant) in [
            ("line", "line_thin"),
            ("lane_marking", "line_thin"),
            ("road_edge", "road_border"),
            ("roadBoundary", "road_border"),
            ("kerb", "curbstone"),
            ("unmarked", "virtual"),
            ("halt_line", "stop_line"),
            ("traffic_signal", "traffic_light"),
            // A word of polygons, on a way that is none.
            ("speed_bumper", "speed_bump"),
            ("area", ""),
            ("station", ""),
            ("poi", ""),
            ("building", ""),
        ] {
            assert_eq!(value(On::LineString, said, ""), meant, "{said}");
        }
        for (said, meant) in [
            ("dotted", "dashed"),
            ("dashed_line", "dashed"),
            ("solid_white", "solid"),
            ("continuous", "solid"),
            // The order counts where both orders are known.
            ("solid_broken", "solid_dashed"),
            ("broken_solid", "dashed_solid"),
            ("double_solid", "solid_solid"),
        ] {
            assert_eq!(value(On::LineString, "line_thin", said), meant, "{said}");
        }
        for (said, meant) in [("rgy", "red_yellow_green"), ("red_amber_green", "red_yellow_green"), ("vertical", "")] {
            assert_eq!(value(On::LineString, "traffic_light", said), meant, "{said}");
        }
        assert_eq!(value(On::Polygon, "parking_spot", ""), "parking_space");
        assert_eq!(value(On::Polygon, "junction_area", ""), "intersection_area");
        assert_eq!(value(On::Polygon, "camping_site", ""), "");
        for (said, meant) in [("sidewalk", "walkway"), ("bikelane", "bicycle_lane"), ("motorway", ""), ("street", "")] {
            assert_eq!(value(On::Lanelet, "lanelet", said), meant, "{said}");
        }
        for (said, meant) in [
            ("vehicle", "participant:vehicle"),
            ("car", "participant:vehicle:car"),
            ("access:vehicle", "participant:vehicle"),
            ("turn", "turn_direction"),
            ("max_speed", "speed_limit"),
        ] {
            assert_eq!(slip_of(On::Lanelet, &[(said, "yes")], said), Some(Slip::Key(meant)), "{said}");
            assert_eq!(slip_of(On::Lanelet, &[(said, "yes"), (meant, "yes")], said), None, "{said}");
        }
        for foreign in ["maxspeed", "bicycle", "zone", "slope", "level"] {
            assert_eq!(slip_of(On::Lanelet, &[(foreign, "1")], foreign), None, "{foreign}");
        }
    }

    #[test]
    fn other_words_stand_for_known_ones_and_are_not_known_themselves() {
        let words = Words::parse().unwrap();
        let lists = words.types.iter().flat_map(|list| list.names.iter().chain(list.subtypes.iter().flatten()));
        let keys: Vec<String> = words.key.iter().flat_map(|key| words.written_out(key)).collect();
        let known: Vec<&String> = lists.chain(&words.paint.words).chain(&keys).collect();
        for one in &words.meant {
            assert!(known.contains(&&one.word), "{} is not known", one.word);
            assert!(!one.said.contains(&one.word), "{} stands for itself", one.word);
        }
    }
}
