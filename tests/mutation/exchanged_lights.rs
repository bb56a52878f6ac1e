//! Two lights exchanged: told as that, and mended by exchanging them back, not by turning one around.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::fix::mend;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{OsmData, Relation, Way};
use lanewright::rules::{self, Config, ConfigError};
use rayon::prelude::*;

use super::{Base, Kind, all_kinds, bases, broken};
use crate::common::drawing::osm;

/// The mutations that exchange the lights of two elements, or two elements.
const EXCHANGES: [&str; 2] =
    ["exchange the lights of two approaches that cross", "let two approaches that cross obey each other's light"];

/// What lights are made of: the members of lanelets and elements of lights, and the nodes of lights.
type Lights = (BTreeMap<i64, BTreeSet<(i64, String)>>, BTreeMap<i64, Vec<i64>>);

fn lights(ways: &[Way], relations: &[Relation]) -> Lights {
    let counts = |one: &&Relation| one.tags.is("type", "lanelet") || one.tags.is("subtype", "traffic_light");
    let members = |one: &Relation| one.members.iter().map(|member| (member.id, member.role.to_string())).collect();
    let bodies = ways.iter().filter(|way| way.tags.is("type", "traffic_light"));
    let relations = relations.iter().filter(counts).map(|one| (one.id, members(one)));
    (relations.collect(), bodies.map(|way| (way.id, way.nodes.clone())).collect())
}

/// How many maps of a kind there are, of how many it is told, and how many are mended by exchanging back.
fn exchanged_back(bases: &[Base], at: usize, kind: &Kind) -> [usize; 3] {
    let mut counts = [0; 3];
    for (base, _, draft, _) in broken(bases, at, kind) {
        let data = osm(draft.text());
        let judge = |osm: &OsmData| -> Result<Vec<Diagnostic>, ConfigError> {
            let Loaded { map, faults } = from_osm(osm, &draft.projector);
            rules::run(&MapIndex::new(&map, &faults, &base.settings), &Config::default())
        };
        let told = judge(&data).unwrap().iter().any(|one| one.code == "vm-04-02/exchanged");
        let before = lights(&base.draft.ways, &base.draft.relations);
        let mended = mend(data, true, judge).unwrap();
        let is_clean = !mended.left.iter().any(|one| one.severity > Severity::Info && base.is_new(one));
        let is_back = lights(&mended.osm.ways, &mended.osm.relations) == before;
        counts[0] += 1;
        counts[1] += usize::from(told);
        counts[2] += usize::from(is_clean && is_back);
    }
    counts
}

#[test]
fn exchanged_lights_are_exchanged_back() {
    let bases = bases();
    let kinds: Vec<(usize, &Kind)> =
        all_kinds().enumerate().filter(|(_, kind)| EXCHANGES.contains(&kind.name)).collect();
    let counts = kinds.par_iter().map(|&(at, kind)| (kind.name, exchanged_back(&bases, at, kind)));
    let counts: Vec<(&str, [usize; 3])> = counts.collect();
    assert_eq!(counts.len(), EXCHANGES.len());
    for (name, [count, told, back]) in counts {
        println!("{name}: {count} maps, {told} told, {back} mended by exchanging back");
        assert!(count > 2 && told == count && back == count, "{name}: {count} maps, {told} told, {back} mended");
    }
}
