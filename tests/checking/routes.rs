//! Who may go where: our reading is that of the real Lanelet2 library, and no safe fix changes it.

use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use lanewright::diagnostic::Severity;
use lanewright::fix::Scope;
use lanewright::lanelet::routing_pairs::{Directed, Relation, routing_pairs};

use crate::common::judging::load;
use crate::common::routes::{MendedFile, Routes, changed_unasked, changes, real};
use crate::common::{hand_made_maps, osm_files, rule_maps, shared_maps, soak};

/// The hand-made maps of both corpora, and of a folder of one's own: LANEWRIGHT_MAPS.
fn corpora() -> Vec<PathBuf> {
    let own = std::env::var_os("LANEWRIGHT_MAPS").map(|folder| osm_files(Path::new(&folder))).unwrap_or_default();
    [hand_made_maps(), shared_maps("corpus/lanelet2_more", 5), own].concat()
}

/// Every so many of a list, or all in a soak.
fn slice(maps: Vec<PathBuf>, step: usize) -> Vec<PathBuf> {
    let step = if soak() { 1 } else { step };
    maps.into_iter().step_by(step).collect()
}

fn relation(one: Relation) -> &'static str {
    match one {
        Relation::Pass => "pass",
        Relation::Following => "following",
        Relation::Left => "left",
        Relation::Right => "right",
        Relation::AdjacentLeft => "adjacent_left",
        Relation::AdjacentRight => "adjacent_right",
    }
}

/// Our routes of a map.
fn ours(map: &std::path::Path) -> Routes {
    let name = |one: Directed| format!("{}{}", one.lanelet, if one.inverted { "-" } else { "" });
    let pairs = routing_pairs(&load(map).1.map);
    pairs.iter().map(|pair| [pair.who.into(), relation(pair.relation).into(), name(pair.from), name(pair.to)]).collect()
}

/// Holds our reading of maps against the library's. Of several lanelets beside one the library names one.
fn compare(maps: &[PathBuf]) {
    let Some(real) = real(maps) else { return };
    let mut compared = 0;
    for (map, real) in maps.iter().zip(real) {
        // Without latitude and longitude the library has all nodes at one place.
        let is_placed = load(map).0.nodes.iter().all(|node| node.position.is_some());
        let Some(real) = real.filter(|_| is_placed) else { continue };
        let ours = ours(map);
        compared += real.len();
        let side = |route: &&[String; 4]| !["pass", "following"].contains(&route[1].as_str());
        let key = |[who, how, from, _]: &[String; 4]| [who.clone(), how.clone(), from.clone()];
        let sides: BTreeSet<[String; 3]> = real.iter().filter(side).map(key).collect();
        let more: Vec<_> = real.difference(&ours).collect();
        assert!(more.is_empty(), "{}: only the library has {more:?}", map.display());
        let more: Vec<_> =
            ours.difference(&real).filter(|route| !side(route) || !sides.contains(&key(route))).collect();
        assert!(more.is_empty(), "{}: only we have {more:?}", map.display());
    }
    assert!(compared > 100, "{compared} routes");
}

/// Pairs of lanelets beside each other, one for each set of tags on their common line, once along it and once against it.
fn drawn(tags: &[String], lanelet: &str) -> String {
    let mut text = String::from("<osm version='0.6' generator='test'>");
    let (mut ways, mut relations) = (String::new(), String::new());
    for (at, tags) in tags.iter().enumerate() {
        let first = 100 * (at + 1);
        for (row, y) in [4e-5, 2e-5, 0.0].into_iter().enumerate() {
            for (column, x) in [0.0, 2e-4].into_iter().enumerate() {
                let (id, lon) = (first + 2 * row + column, 139.7 + x + 4e-4 * at as f64);
                writeln!(text, "<node id='{id}' lat='{}' lon='{lon}'><tag k='ele' v='1'/></node>", 35.2 + y).unwrap();
            }
            let ends = [first + 2 * row, first + 2 * row + 1];
            let [a, b] = if row == 1 && at % 2 == 1 { [ends[1], ends[0]] } else { ends };
            let tags = if row == 1 { tags.as_str() } else { "<tag k='type' v='road_border'/>" };
            writeln!(ways, "<way id='{}'><nd ref='{a}'/><nd ref='{b}'/>{tags}</way>", first + 10 + row).unwrap();
        }
        for row in 0..2 {
            writeln!(
                relations,
                "<relation id='{}'><member type='way' ref='{}' role='left'/><member type='way' ref='{}' role='right'/>\
                 <tag k='type' v='lanelet'/>{lanelet}</relation>",
                first + 20 + row,
                first + 10 + row,
                first + 11 + row,
            )
            .unwrap();
        }
    }
    text + &ways + &relations + "</osm>"
}

fn tag(key: &str, value: &str) -> String {
    format!("<tag k='{key}' v='{value}'/>")
}

/// Every way to say who may change lanes: tags of both sides, of one side, paint, and these on each other.
fn ways_to_say_it() -> Vec<String> {
    let mut said = vec![String::new()];
    for value in ["yes", "no", "true", "false", "1", "0", "ture", "Yes"] {
        said.push(tag("lane_change", value));
        said.push(tag("lane_change:left", value));
        said.push(tag("lane_change:right", value));
        for other in ["yes", "no"] {
            said.push(tag("lane_change:left", value) + &tag("lane_change:right", other));
            said.push(tag("lane_change", other) + &tag("lane_change:left", value));
        }
    }
    let mut paints = vec![String::new()];
    for kind in ["line_thin", "line_thick", "virtual", "curbstone", "road_border", "pedestrian_marking"] {
        for subtype in ["", "dashed", "solid", "dashed_solid", "solid_dashed", "solid_solid", "dashed_dashed", "low"] {
            paints.push(tag("type", kind) + &if subtype.is_empty() { String::new() } else { tag("subtype", subtype) });
        }
    }
    let all = said.iter().flat_map(|said| paints.iter().map(move |paint| said.clone() + paint));
    // Each twice, for the two directions of the line.
    all.flat_map(|tags| [tags.clone(), tags]).collect()
}

#[test]
fn lane_changes_are_read_as_lanelet2_reads_them() {
    let dir = tempfile::tempdir().unwrap();
    let everybody = tag("subtype", "road") + &tag("participant:vehicle", "yes") + &tag("participant:bicycle", "yes");
    let everybody = everybody + &tag("participant:pedestrian", "yes");
    let text = drawn(&ways_to_say_it(), &everybody);
    let file = dir.path().join("map.osm");
    std::fs::write(&file, text).unwrap();
    compare(&[file]);
}

#[test]
fn participants_and_directions_are_read_as_lanelet2_reads_them() {
    let dir = tempfile::tempdir().unwrap();
    let subtypes = ["", "road", "highway", "bicycle_lane", "play_street", "bus_lane", "emergency_lane", "exit"];
    let more =
        ["walkway", "crosswalk", "stairs", "shared_walkway", "road_shoulder", "pedestrian_lane", "raod", "parking"];
    let mut kinds: Vec<String> = subtypes.iter().chain(&more).map(|kind| tag("subtype", kind)).collect();
    kinds.push(String::new());
    for value in ["yes", "no", "ture"] {
        for who in ["", ":vehicle", ":vehicle:car", ":vehicle:truck", ":pedestrian", ":bicycle", ":tram"] {
            kinds.push(tag("subtype", "road") + &tag(&format!("participant{who}"), value));
            kinds.push(tag("subtype", "road") + &tag(&format!("one_way{who}"), value));
            kinds.push(tag("subtype", "walkway") + &tag(&format!("one_way{who}"), value));
        }
    }
    kinds.push(tag("participants:vehicle", "yes"));
    kinds.push(tag("one_way", "yes") + &tag("one_way:pedestrian", "no") + &tag("participant:pedestrian", "yes"));
    let files: Vec<PathBuf> = (0..kinds.len()).map(|at| dir.path().join(format!("{at}.osm"))).collect();
    for (file, kind) in files.iter().zip(&kinds) {
        std::fs::write(file, drawn(&[String::new(), tag("lane_change", "yes")], kind)).unwrap();
    }
    compare(&files);
}

#[test]
fn routes_are_those_of_lanelet2() {
    compare(&[slice(corpora(), 3), slice(rule_maps("good"), 8)].concat());
}

#[test]
fn no_safe_fix_changes_a_route_that_its_finding_is_not_about() {
    let scope = Scope { least: Severity::Info, ..Scope::default() };
    let Some(changed) = changed_unasked(&[slice(corpora(), 2), slice(rule_maps("bad-"), 6)].concat(), scope) else {
        return;
    };
    assert!(changed.is_empty(), "{changed:#?}");
}

/// Who may change lanes is said by side, and a safe fix leaves it so.
#[test]
fn what_is_said_by_side_stays() {
    let dir = tempfile::tempdir().unwrap();
    let lanelet = ["subtype road", "location urban", "one_way yes", "speed_limit 30"];
    let lanelet: String = lanelet.iter().filter_map(|said| said.split_once(' ')).map(|(k, v)| tag(k, v)).collect();
    let line = |subtype: &str| tag("type", "line_thin") + &tag("subtype", subtype);
    let said = [
        line("dashed") + &tag("lane_change:left", "no") + &tag("lane_change:right", "yes"),
        line("dashed") + &tag("lane_change:left", "no"),
        line("solid") + &tag("lane_change:right", "yes"),
        line("solid_dashed"),
        line("dashed_solid"),
    ];
    for (at, tags) in said.iter().enumerate() {
        let file = dir.path().join(format!("{at}.osm"));
        std::fs::write(&file, drawn(&[tags.clone(), tags.clone()], &lanelet)).unwrap();
        let (_, loaded) = load(&file);
        let found = crate::common::judging::judge(&loaded, &lanewright::settings::Settings::default());
        let of_changes = found.iter().filter(|one| one.code.starts_with("vm-01-02/") && one.finding.fix.is_some());
        assert_eq!(of_changes.count(), 0, "{tags}: {found:?}");
        assert_eq!(changed_unasked(&[file], true.into()).unwrap_or_default(), Vec::<String>::new(), "{tags}");
    }
}

/// Whether somebody still comes from one lanelet to another, through at most so many others that are new.
fn still_leads(routes: &Routes, [who, _, from, to]: &[String; 4]) -> bool {
    const PIECES: usize = 4;
    let mut reached = BTreeSet::from([from]);
    for _ in 0..PIECES {
        let on = routes
            .iter()
            .filter(|[other, how, start, _]| other == who && how == "following" && reached.contains(start));
        reached = on.map(|[.., end]| end).collect();
        if reached.contains(to) {
            return true;
        }
    }
    false
}

/// A soak with `--no-capture` prints the table.
#[test]
fn no_fix_changes_a_route_of_which_no_finding_speaks() {
    for unsafe_too in [false, true] {
        let scope = Scope { unsafe_too, ..Scope::default() };
        let Some(changed) = changes(&slice(corpora(), 4), scope) else { return };
        for one in &changed {
            let name = one.map.file_stem().unwrap_or_default().to_string_lossy();
            let (lost, won) = (one.lost, one.won);
            println!("| {name} | {unsafe_too} | {} | {lost} | {won} | {} |", one.before, one.unasked.len());
        }
        let unasked: Vec<_> = changed.iter().filter(|one| !one.unasked.is_empty()).collect();
        let told: Vec<String> = unasked.iter().map(|one| format!("{}: {:?}", one.map.display(), one.unasked)).collect();
        assert!(told.is_empty(), "{unsafe_too}: {}", told.join("\n"));
    }
}

#[test]
fn no_fix_takes_a_way_on_that_its_finding_is_not_about() {
    let dir = tempfile::tempdir().unwrap();
    let scope = || Scope { unsafe_too: true, ..Scope::default() };
    for (at, map) in slice(corpora(), 4).iter().enumerate() {
        let Some(fixed) = MendedFile::of(map, &dir.path().join(at.to_string()), scope()) else { continue };
        let (before, after) = (ours(&fixed.before), ours(&fixed.after));
        let passes = |lanelet: &String, who: &String| {
            after.contains(&[who.clone(), "pass".into(), lanelet.clone(), lanelet.clone()])
        };
        let is_lost = |route: &&[String; 4]| {
            let [who, how, from, to] = route;
            how == "following" && passes(from, who) && passes(to, who) && !still_leads(&after, route)
        };
        let lost: Vec<_> = before.difference(&after).filter(is_lost).filter(|route| !fixed.is_about(route)).collect();
        assert!(lost.is_empty(), "{}: {lost:?}", map.display());
    }
}
