//! What is taken from clean maps, a part or all, `fix` puts back.

use std::collections::{BTreeMap, BTreeSet};

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::fix::{Mended, mend};
use lanewright::geometry::polygon;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, from_osm};
use lanewright::osm::{ElementKind, OsmData};
use lanewright::rules::{self, Config, ConfigError};
use rayon::prelude::*;

use super::draft::{Dice, Draft, members, without};
use super::{Base, bases, mutations};
use crate::common::drawing::{Drawing, osm};

fn judge(base: &Base, draft: &Draft, osm: &OsmData) -> Result<Vec<Diagnostic>, ConfigError> {
    let Loaded { map, faults } = from_osm(osm, &draft.projector);
    let index = MapIndex::new(&map, &faults, &base.settings);
    rules::run(&index, &Config::default())
}

/// All fixes of a draft.
fn mended(base: &Base, draft: &Draft) -> Mended {
    mend(osm(draft.text()), true, |osm: &OsmData| judge(base, draft, osm)).unwrap()
}

/// Takes areas, turns, rights of way and crosswalk elements, as far as the dice say.
fn take(draft: &mut Draft, mut is_taken: impl FnMut() -> bool) {
    let areas: Vec<i64> = draft.lines("intersection_area").map(|area| area.id).filter(|_| is_taken()).collect();
    areas.into_iter().for_each(|area| draft.remove(ElementKind::Way, area));
    for subtype in ["right_of_way", "crosswalk"] {
        let elements: Vec<i64> = draft.elements(subtype).map(|element| element.id).filter(|_| is_taken()).collect();
        elements.into_iter().for_each(|element| draft.remove(ElementKind::Relation, element));
    }
    let movements: Vec<i64> = draft.movements().map(|lanelet| lanelet.id).collect();
    for id in movements {
        for key in ["intersection_area", "turn_direction"] {
            if is_taken() {
                draft.relation(id).tags = without(&draft.relation(id).tags, key);
            }
        }
    }
}

/// The values of a tag by lanelet.
fn values<'a>(map: &'a OsmData, key: &str) -> BTreeMap<i64, &'a str> {
    map.relations.iter().filter_map(|one| Some((one.id, one.tags.get(key)?))).collect()
}

/// Of each lanelet with a `right_of_way` element whom it may ignore.
fn ignored(map: &OsmData) -> BTreeMap<i64, BTreeSet<i64>> {
    let mut all: BTreeMap<i64, BTreeSet<i64>> = BTreeMap::new();
    for element in map.relations.iter().filter(|one| one.tags.is("subtype", "right_of_way")) {
        for own in members(element, "right_of_way") {
            all.entry(own).or_default().extend(members(element, "yield"));
        }
    }
    all
}

#[test]
fn all_marks_of_intersections_are_put_back() {
    for base in &bases() {
        let mut bare = base.draft.clone();
        take(&mut bare, || true);
        let (before, after) = (osm(base.draft.text()), mended(base, &bare).osm);
        let name = &base.name;
        assert_eq!(values(&after, "turn_direction"), values(&before, "turn_direction"), "{name}");
        let allowed = ignored(&before);
        for (lanelet, ignored) in ignored(&after) {
            let more = allowed.get(&lanelet).is_none_or(|allowed| !ignored.is_subset(allowed));
            assert!(!more, "{name}: lanelet {lanelet} ignores {ignored:?} and ignored {:?}", allowed.get(&lanelet));
        }
        let rings = |map: &OsmData| -> Vec<_> {
            let draft = Draft::of(map, base.draft.projector);
            draft.lines("intersection_area").map(|area| draft.line(area.id)).collect()
        };
        for area in rings(&before) {
            // What is drawn anew keeps to the ground under its lanelets: it may leave out corners beside them, and takes nothing else.
            let shares = |other: &Vec<_>| {
                let common = polygon::overlap(&area, other);
                [&area, other].map(|ring| common / polygon::signed_area(ring).abs())
            };
            let [old, new] = rings(&after)
                .iter()
                .map(shares)
                .fold([0.0, 0.0], |best: [f64; 2], next| if next[0] > best[0] { next } else { best });
            assert!(
                old > 0.7 && new > 0.95,
                "{name}: {old:.2} of an area come back, {new:.2} of it lie in the old one"
            );
        }
        let crosswalks = |map: &OsmData| -> BTreeSet<i64> {
            let elements = map.relations.iter().filter(|one| one.tags.is("type", "regulatory_element"));
            let announced = elements.filter(|one| one.tags.is("subtype", "crosswalk"));
            // A map without any of them does not show that it wants walkways announced.
            let is_crosswalk = |id: &i64| map.relation(*id).is_some_and(|lane| lane.tags.is("subtype", "crosswalk"));
            announced.flat_map(|one| members(one, "refers")).filter(is_crosswalk).collect()
        };
        assert_eq!(crosswalks(&after), crosswalks(&before), "{name}");
    }
}

/// The map that the builder makes of a network.
fn built(drawing: &Drawing) -> Base {
    let folder = tempfile::tempdir().unwrap();
    let input = folder.path().join("ring.osm");
    std::fs::write(&input, drawing.xml()).unwrap();
    Base::of(&input)
}

/// How many intersections are not marked in a map.
fn unmarked(base: &Base, draft: &Draft) -> usize {
    let found = judge(base, draft, &osm(draft.text())).unwrap();
    found.iter().filter(|one| one.code == "vm-03-01/unmarked").count()
}

/// How many intersections the builder marks in a network, and how many are found without the marks.
fn marked_and_found(drawing: &Drawing) -> [usize; 2] {
    let base = built(drawing);
    let mut bare = base.draft.clone();
    take(&mut bare, || true);
    [base.draft.lines("intersection_area").count(), unmarked(&base, &bare)]
}

/// How many intersections are found where nothing names the lanelets of the roundabouts.
fn found_without_elements(drawing: &Drawing) -> usize {
    let base = built(drawing);
    let mut bare = base.draft.clone();
    let elements: Vec<i64> = ["roundabout", "road_marking"]
        .into_iter()
        .flat_map(|subtype| bare.elements(subtype).map(|element| element.id).collect::<Vec<_>>())
        .collect();
    elements.into_iter().for_each(|element| bare.remove(ElementKind::Relation, element));
    let lines: Vec<i64> = bare.lines("stop_line").map(|line| line.id).collect();
    lines.into_iter().for_each(|line| bare.remove(ElementKind::Way, line));
    unmarked(&base, &bare)
}

/// A closed way of these tags over corners (degrees, metres from the middle), and a street of these from each corner that is named, the
/// far end of which lies so many degrees farther around and so many metres from the middle.
fn ring(corners: &[[f64; 2]], tags: &str, streets: &[(usize, &str)], [skew, far]: [f64; 2]) -> Drawing {
    let mut drawing = Drawing::default();
    for (at, [degrees, metres]) in corners.iter().enumerate() {
        for (id, degrees, metres) in [(at + 1, *degrees, *metres), (at + 51, degrees + skew, far)] {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let place = [49.0 + metres * sine / 111_195.0, 8.4 + metres * cosine / 73_000.0];
            drawing.node(id, place, "");
        }
    }
    for &(at, tags) in streets {
        // A street that leads in is drawn toward the ring.
        drawing.way(at + 121, [at + 51, at + 1], tags);
    }
    let around: Vec<usize> = (1..=corners.len()).chain([1]).collect();
    drawing.way(201, around, tags);
    drawing
}

/// Streets for both directions around a small block, with a street to each corner: cars can drive around it as around a roundabout, but
/// others come towards them inside.
#[test]
fn the_crossings_around_a_small_block_are_told() {
    let street = "highway=residential";
    let corners = [90.0, 210.0, 330.0].map(|degrees| [degrees, 24.0]);
    assert_eq!(marked_and_found(&ring(&corners, street, &[0, 1, 2].map(|at| (at, street)), [0.0, 120.0])), [3, 3]);
}

/// At a roundabout its rules say who goes first, and an element tells Autoware. Without the element, who joins where a street leads to it
/// askew crosses the way of who leaves.
#[test]
fn at_a_roundabout_only_the_places_are_told_where_cars_that_join_and_leave_cross() {
    let around = "highway=residential junction=roundabout";
    let corners = [0.0, 45.0, 90.0, 135.0, 180.0, 225.0, 270.0, 315.0].map(|degrees| [degrees, 12.0]);
    let streets = [0, 2, 4, 6].map(|at| (at, "highway=residential"));
    let [askew, straight] = [-80.0, 0.0].map(|skew| ring(&corners, around, &streets, [skew, 60.0]));
    assert_eq!(marked_and_found(&askew), [0, 0]);
    assert_eq!(marked_and_found(&straight), [0, 0]);
    assert_eq!(found_without_elements(&askew), 4);
    assert_eq!(found_without_elements(&straight), 0);
}

/// One-way aisles around a block of stands are as short as a roundabout, but turn at their corners alone.
#[test]
fn aisles_around_a_block_are_no_roundabout() {
    let aisle = "highway=service service=parking_aisle oneway=yes";
    let corners = [[32.0, 30.0], [90.0, 16.0], [148.0, 30.0], [212.0, 30.0], [270.0, 16.0], [328.0, 30.0]];
    let [marked, found] = marked_and_found(&ring(&corners, aisle, &[(1, aisle), (4, aisle)], [0.0, 120.0]));
    assert!(marked > 0 && marked == found, "{marked} marked, {found} found");
}

/// Errors by code and element.
fn errors(found: &[Diagnostic]) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for one in found.iter().filter(|one| one.severity == Severity::Error) {
        *counts.entry(format!("{} {}", one.code, one.finding.subject)).or_default() += 1;
    }
    counts
}

#[test]
fn whatever_is_taken_fixing_ends_and_makes_no_error() {
    fixing_ends_and_makes_no_error(|draft, dice| {
        let share = 1 + dice.below(4);
        take(draft, || dice.below(4) < share);
    });
}

#[test]
fn in_whatever_order_the_elements_stand_fixing_ends_and_makes_no_error() {
    fixing_ends_and_makes_no_error(|draft, dice| {
        take(draft, || dice.below(2) == 0);
        dice.shuffle(&mut draft.nodes);
        dice.shuffle(&mut draft.ways);
        dice.shuffle(&mut draft.relations);
    });
}

/// A piece of a map: what is cut off is missing, though others still refer to it.
#[test]
fn of_a_torn_map_fixing_ends_and_makes_no_error() {
    fixing_ends_and_makes_no_error(|draft, dice| {
        take(draft, || dice.below(2) == 0);
        for _ in 0..1 + dice.below(3) {
            let (node, way, relation) =
                (dice.below(draft.nodes.len()), dice.below(draft.ways.len()), dice.below(draft.relations.len()));
            match dice.below(3) {
                0 => drop(draft.nodes.swap_remove(node)),
                1 => drop(draft.ways.swap_remove(way)),
                _ => drop(draft.relations.swap_remove(relation)),
            }
        }
    });
}

/// Errors of lanes that end or begin where an intersection has no lanelet for them.
const LOOSE_ENDS: [&str; 2] = ["vm-03-04/in-lane-dead-end", "vm-03-04/out-lane-unreached"];

/// Breaks the clean maps in as many ways as there are seeds; `fix` ends, adds no error, and finds nothing more to do.
fn fixing_ends_and_makes_no_error(break_map: impl Fn(&mut Draft, &mut Dice) + Sync) {
    let bases = bases();
    let count = mutations() as u64;
    let draws: Vec<(&Base, u64)> = bases.iter().flat_map(|base| (0..count).map(move |seed| (base, seed))).collect();
    draws.par_iter().for_each(|(base, seed)| {
        let mut draft = base.draft.clone();
        break_map(&mut draft, &mut Dice(1 + seed));
        let broken = judge(base, &draft, &osm(draft.text())).unwrap();
        let once = mended(base, &draft);
        let known = errors(&broken);
        // Where a lanelet is torn away, the lane before it ends. Nobody sees that until the intersection is marked.
        let is_torn = draft.lanelets().count() < base.draft.lanelets().count();
        let is_loose_end = |error: &str| LOOSE_ENDS.iter().any(|code| error.starts_with(code));
        for (error, count) in errors(&once.left).into_iter().filter(|(error, _)| !(is_torn && is_loose_end(error))) {
            let before = known.get(&error).copied().unwrap_or_default();
            assert!(count <= before, "{} seed {seed}: {error} {before} -> {count}", base.name);
        }
        let again = mend(once.osm.clone(), true, |osm: &OsmData| judge(base, &draft, osm)).unwrap();
        assert!(again.done.is_empty(), "{} seed {seed}: a second run makes {:?}", base.name, again.done);
    });
}
