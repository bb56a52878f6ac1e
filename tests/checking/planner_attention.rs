//! What the planner watches is what follows from the real library's routing graph by Autoware's algorithm, derived a second time in
//! `planner_attention.py`.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::process::Stdio;
use std::time::{Duration, Instant};

use lanewright::lanelet::index::view::View;
use lanewright::lanelet::{LaneletId, LineStringId, RegulatoryElementId};
use lanewright::planner::{
    Forecast, Outcome, Params, Priority, Reason, RoadNetwork, StopSource, Watched, surroundings,
};
use serde::Deserialize;

use crate::common::judging::load;
use crate::common::needs::python;
use crate::common::{hand_made_maps, is_fresh, root, rule_maps, samples, shared_maps};

/// What the script says of one lanelet.
#[derive(Deserialize)]
struct Derived {
    watched: BTreeSet<i64>,
    ignored: BTreeSet<i64>,
    before: BTreeSet<i64>,
    more: BTreeSet<i64>,
}

fn forecasts(map: &std::path::Path) -> BTreeMap<String, Forecast> {
    let loaded = load(map).1;
    let view = View::new(&loaded.map);
    let network = RoadNetwork::new(&view);
    let all = 0..view.lanelets.len();
    let inside = all.filter(|&at| network.graph.passes(at) && network.turn(at).is_some());
    let told = inside.filter_map(|at| network.forecast(at, &[], &Params::default()));
    told.map(|one| (one.lanelet.to_string(), one)).collect()
}

#[test]
fn the_planner_watches_what_the_real_routing_graph_says() {
    let maps = [hand_made_maps(), shared_maps("corpus/lanelet2_more", 5), rule_maps("good")].concat();
    let Some(mut python) = python() else { return };
    python.arg(root().join("tests/checking/planner_attention.py"));
    let mut child = python.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(serde_json::to_string(&maps).unwrap().as_bytes()).unwrap();
    let output = child.wait_with_output().unwrap();
    let derived: Vec<Option<BTreeMap<String, Derived>>> = serde_json::from_slice(&output.stdout).unwrap();
    let mut compared = 0;
    for (map, derived) in maps.iter().zip(derived) {
        let Some(derived) = derived else { continue };
        let ours = forecasts(map);
        assert!(ours.keys().eq(derived.keys()), "{}: other lanelets", map.display());
        for (id, derived) in &derived {
            let one = &ours[id];
            let ids = |list: &[Watched]| list.iter().map(|one| one.lanelet.0).collect::<BTreeSet<i64>>();
            assert_eq!(ids(&one.watched), derived.watched, "{}: watched on {id}", map.display());
            assert_eq!(ids(&one.ignored), derived.ignored, "{}: ignored on {id}", map.display());
            let before: BTreeSet<i64> = one.watched.iter().flat_map(|one| &one.before).map(|id| id.0).collect();
            let before = &before - &derived.watched;
            assert!(derived.before.is_subset(&before), "{}: too little before {id}", map.display());
            assert!(before.is_subset(&derived.more), "{}: too much before {id}", map.display());
            compared += 1;
        }
    }
    assert!(compared >= 200, "only {compared} lanelets were compared");
}

/// What lies around a lanelet tells the same as the whole map, and is found in a small part of the time that reading takes.
#[test]
fn the_surroundings_of_a_lanelet_are_enough() {
    let maps = [hand_made_maps(), shared_maps("corpus/lanelet2_more", 5), samples()].concat();
    let (mut compared, mut reading, mut forecasting) = (0, Duration::ZERO, Duration::ZERO);
    let params = Params { attention_area_length: 60.0, backward_attention_length: 40.0, ..Params::default() };
    for map in &maps {
        let start = Instant::now();
        let loaded = load(map).1;
        let read = start.elapsed();
        let whole = View::new(&loaded.map);
        let network = RoadNetwork::new(&whole);
        let inside = |at: &usize| network.graph.passes(*at) && network.turn(*at).is_some();
        for at in (0..whole.lanelets.len()).filter(inside).step_by(3) {
            let id = whole.lanelets[at].id();
            reading += read;
            let start = Instant::now();
            let near = surroundings(&loaded.map, id, &params).unwrap();
            let part = RoadNetwork::new(&near);
            let told = part.forecast(part.lanelet(id.0).unwrap(), &[], &params);
            forecasting += start.elapsed();
            assert_eq!(told, network.forecast(at, &[], &params), "{}: lanelet {id}", map.display());
            compared += 1;
        }
    }
    assert!(compared >= 100, "only {compared} lanelets were compared");
    let share = forecasting.as_secs_f64() / reading.as_secs_f64();
    println!("one forecast takes {:.1} % of reading a map", share * 100.0);
    assert!(share < 0.33, "one forecast takes {:.0} % of reading a map", share * 100.0);
}

/// What the program prints of a lanelet of one of the rules' maps.
fn printed(map: &str, lanelet: i64) -> String {
    let map = root().join("tests/rules").join(map);
    let told = forecasts(&map).remove(&lanelet.to_string()).unwrap();
    lanewright::report::planner::text(&[told])
}

#[test]
fn the_examples_of_the_page_are_what_is_printed() {
    let path = root().join("docs/planner.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let command = |map: &str, id: i64| format!("```console\n$ lanewright planner tests/rules/{map} --lanelet {id}\n");
    let mut wanted = page.clone();
    for (map, id) in [("vm-03-10/good.osm", 213), ("vm-03-11/good.osm", 215)] {
        let (before, rest) = wanted.split_once(&command(map, id)).unwrap();
        let (_, after) = rest.split_once("```\n").unwrap();
        wanted = format!("{before}{}{}```\n{after}", command(map, id), printed(map, id));
    }
    assert!(is_fresh(&path, &wanted), "docs/planner.md is stale; run: LANEWRIGHT_UPDATE=1 cargo test --test checking");
}

/// A far turn with a signal waits for who comes toward it, and ignores who stands at red by its element.
#[test]
fn each_lane_has_its_reason() {
    let maps = root().join("tests/rules");
    let far_turn = forecasts(&maps.join("vm-03-10/good.osm")).remove("213").unwrap();
    let ids = |list: &[Watched]| list.iter().map(|one| one.lanelet.0).collect::<Vec<_>>();
    assert_eq!((ids(&far_turn.watched), ids(&far_turn.ignored)), (vec![212, 214], vec![215]));
    assert_eq!(far_turn.ignored[0].ignored, Some(Reason::RightOfWay(RegulatoryElementId(313))));
    assert_eq!(far_turn.watched[0].ends, [(LaneletId(203), far_turn.watched[0].ends[0].1)]);
    // Without the line in its element, the turn waits for the crossing road, too.
    let missing = forecasts(&maps.join("vm-03-10/bad-self-missing.osm"));
    let waits_in_vain = missing.values().any(|one| one.ignored.is_empty() && !one.watched.is_empty());
    assert!(waits_in_vain);
    let straight = forecasts(&maps.join("vm-03-10/good.osm")).remove("212").unwrap();
    assert_eq!((straight.outcome, straight.watched.len()), (Outcome::WatchesNobody, 0));
    assert!(straight.ignored.iter().all(|one| matches!(one.ignored, Some(Reason::StraightWithLight(_)))));
    let side_road = forecasts(&maps.join("vm-03-11/good.osm")).remove("215").unwrap();
    assert_eq!(side_road.outcome, Outcome::Watches);
    let stop = side_road.lines.default_stop.unwrap();
    assert_eq!(stop.source, StopSource::RoadMarking(LineStringId(133)));
    assert!(stop.front.from_start.abs() < 0.15, "{}", stop.front.from_start);
    assert!(side_road.watched.iter().all(|one| one.waits == Priority::Mine), "all lanes of the main road ignore it");
}
