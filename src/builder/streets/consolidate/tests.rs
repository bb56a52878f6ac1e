//! Merging on small hand-drawn networks.

use crate::builder::network::hand_drawn::{self, network_of, restrict};
use crate::builder::network::road_end::other_end;
use crate::builder::network::{IntersectionIx, RoadEnd};
use crate::builder::streets::outline::{OutlineCase, PlanCache, outlines, remaining};
use crate::builder::tags::cross_section::{StripKind, Travel};

use super::types::SHORT;
use super::*;

fn merge(network: RoadNetwork, options: &ConsolidateOptions) -> (RoadNetwork, Vec<MergeNote>) {
    let kept = |n: &RoadNetwork| remaining(n, &mut PlanCache::default());
    let (network, notes, _) = consolidate(join_continuations(network), options, kept);
    (network, notes)
}

/// Two dual carriageways, 12 m apart, driven on the right: `N-S` on x = 0 (south) and 12 (north), `E-W` on y = 0
/// (east) and 12 (west).
fn crossing_of_dual_carriageways(restriction: &[(&str, char, i64)]) -> RoadNetwork {
    crossing_at([(0.0, 0.0), (12.0, 0.0), (12.0, 12.0), (0.0, 12.0)], restriction)
}

/// Two dual carriageways that cross at these corners, counter-clockwise from the south-west, with a `no_left_turn` of these
/// members.
fn crossing_at([a, b, c, d]: [(f64, f64); 4], restriction: &[(&str, char, i64)]) -> RoadNetwork {
    let nodes = [
        (1, a.0, a.1, ""),
        (2, b.0, b.1, ""),
        (3, c.0, c.1, ""),
        (4, d.0, d.1, ""),
        (11, 0.0, 120.0, ""),
        (12, 0.0, -120.0, ""),
        (13, 12.0, -120.0, ""),
        (14, 12.0, 120.0, ""),
        (15, -120.0, 0.0, ""),
        (16, 120.0, 0.0, ""),
        (17, 120.0, 12.0, ""),
        (18, -120.0, 12.0, ""),
    ];
    let main = "highway=primary oneway=yes lanes=2 name=Main";
    let cross = "highway=primary oneway=yes lanes=2 name=Cross";
    let ways: [hand_drawn::DrawnWay<'_>; 4] = [
        (101, &[11, 4, 1, 12], main),
        (102, &[13, 2, 3, 14], main),
        (103, &[15, 1, 2, 16], cross),
        (104, &[17, 3, 4, 18], cross),
    ];
    let mut osm = hand_drawn::osm(&nodes, &ways);
    if !restriction.is_empty() {
        restrict(&mut osm, 7, "restriction=no_left_turn", restriction);
    }
    hand_drawn::network(&osm)
}

/// The merged intersection, and its arms as the far nodes they lead to.
fn the_merged(network: &RoadNetwork) -> (IntersectionIx, Vec<i64>) {
    let merged = network.intersections.iter().position(|i| i.nodes.len() > 1).unwrap();
    let far = |arm: &RoadEnd| network.road(arm.road).node(other_end(*arm).end);
    (IntersectionIx::new(merged), network.intersections[merged].arms.iter().map(far).collect())
}

#[test]
fn the_crossing_of_two_dual_carriageways_is_one_intersection() {
    let (merged, notes) = merge(crossing_of_dual_carriageways(&[]), &ConsolidateOptions::default());
    let (ix, far) = the_merged(&merged);
    let crossing = merged.intersection(ix);
    assert_eq!(crossing.nodes, [1, 2, 3, 4]);
    assert_eq!(crossing.inner.len(), 4);
    assert_eq!(notes.iter().filter(|n| n.merged).count(), 4);
    // Clockwise from the smallest key: the piece of way 101 from node 1 to node 12 in the south.
    assert_eq!(far, [12, 15, 18, 11, 14, 17, 16, 13]);
    assert_eq!(merged.roads.len(), 8);
    assert_eq!(merged.intersections.len(), 9);
}

#[test]
fn around_an_island_opposite_sides_are_merged_instead_of_adjacent_ones() {
    let wide = 19.0;
    for (a, b) in [(0.3, 0.2), (0.0, 0.1)] {
        // The shortest two sides meet.
        let corners = [(0.0, 0.0), (wide + a, 0.0), (wide + 1.0, wide + 1.2), (0.0, wide + b)];
        let (merged, notes) = merge(crossing_at(corners, &[]), &ConsolidateOptions::default());
        let nodes: Vec<&[i64]> = merged.intersections.iter().map(|i| &i.nodes[..]).filter(|n| n.len() > 1).collect();
        assert_eq!(notes.iter().filter(|note| note.reason == MergeReason::Island).count(), 2, "{notes:?}");
        assert!(nodes == [[1, 2], [3, 4]] || nodes == [[1, 4], [2, 3]], "{nodes:?}");
    }
}

#[test]
fn a_small_island_may_lie_inside() {
    let wide = 19.0;
    let corners = [(0.0, 0.0), (wide, 0.0), (wide, wide), (0.0, wide)];
    let island = |most: f64| {
        let options = ConsolidateOptions { island: most, ..ConsolidateOptions::default() };
        merge(crossing_at(corners, &[]), &options).0.intersections.iter().filter(|i| i.nodes.len() == 4).count()
    };
    assert_eq!([0.0, 400.0].map(island), [0, 1]);
}

#[test]
fn its_passages_follow_the_inner_roads() {
    let (merged, _) = merge(crossing_of_dual_carriageways(&[]), &ConsolidateOptions::default());
    let (ix, _) = the_merged(&merged);
    let far = |arm: RoadEnd| merged.road(arm.road).node(other_end(arm).end);
    let mut pairs: Vec<(i64, i64)> =
        merged.intersection(ix).passages.iter().flatten().map(|(a, b)| (far(*a), far(*b))).collect();
    pairs.sort_unstable();
    // From each of the four approaches to each of the four exits, U-turns included.
    let (ins, outs) = ([11, 13, 15, 17], [12, 14, 16, 18]);
    let all: Vec<(i64, i64)> = ins.iter().flat_map(|a| outs.iter().map(move |b| (*a, *b))).collect();
    assert_eq!(pairs, all);
}

#[test]
fn restrictions_over_inner_roads_survive() {
    // No left turn from the south (way 102 to node 3, on to way 104).
    let members = [("from", 'w', 102), ("via", 'n', 3), ("to", 'w', 104)];
    let (merged, _) = merge(crossing_of_dual_carriageways(&members), &ConsolidateOptions::default());
    let (ix, _) = the_merged(&merged);
    let far = |arm: RoadEnd| merged.road(arm.road).node(other_end(arm).end);
    let from_south: Vec<i64> = merged
        .intersection(ix)
        .passages
        .iter()
        .flatten()
        .filter(|(a, _)| far(*a) == 13)
        .map(|(_, b)| far(*b))
        .collect();
    assert!(from_south.contains(&14) && from_south.contains(&16), "{from_south:?}");
    assert!(!from_south.contains(&18) && !from_south.contains(&12), "{from_south:?}");
}

#[test]
fn its_outline_is_one_simple_ring_with_all_cuts() {
    let (merged, _) = merge(crossing_of_dual_carriageways(&[]), &ConsolidateOptions::default());
    let (ix, _) = the_merged(&merged);
    let (outlines, findings) = outlines(&merged);
    assert!(findings.is_empty(), "{findings:?}");
    let outline = &outlines.intersections[ix];
    assert_eq!(outline.case, OutlineCase::Merged);
    assert_eq!(outline.cuts.len(), 8);
    for cut in &outline.cuts {
        assert!(outline.ring.contains(&cut.left) && outline.ring.contains(&cut.right));
    }
}

#[test]
fn a_user_can_forbid_and_force() {
    let forbid = |way| MergeOverride { of: OverrideTarget::Way(way), merge: false };
    let options = ConsolidateOptions { wishes: [101, 102, 103, 104].map(forbid).into(), ..Default::default() };
    let (apart, notes) = merge(crossing_of_dual_carriageways(&[]), &options);
    assert!(apart.intersections.iter().all(|i| i.nodes.len() == 1));
    assert!(notes.iter().all(|n| !n.merged && n.reason == MergeReason::Wish));

    let t_junctions = || {
        network_of(
            &[(1, 0.0, 0.0), (2, 40.0, 0.0), (3, -90.0, 0.0), (4, 130.0, 0.0), (5, 0.0, 90.0), (6, 40.0, -90.0)],
            &[
                (21, &[3, 1], "highway=secondary name=A"),
                (22, &[1, 2], "highway=secondary name=A"),
                (23, &[2, 4], "highway=secondary name=A"),
                (24, &[5, 1], "highway=residential"),
                (25, &[6, 2], "highway=residential"),
            ],
        )
    };
    let (offset, _) = merge(t_junctions(), &ConsolidateOptions::default());
    assert_eq!(offset.intersections.iter().filter(|i| i.arms.len() == 3).count(), 2, "vehicles queue on 40 m");
    let options = ConsolidateOptions {
        wishes: vec![MergeOverride { of: OverrideTarget::Way(22), merge: true }],
        ..Default::default()
    };
    let (forced, _) = merge(t_junctions(), &options);
    assert_eq!(forced.intersections.iter().filter(|i| i.arms.len() == 4).count(), 1);
}

#[test]
fn a_dogleg_too_short_for_a_car_is_one_intersection() {
    let (merged, notes) = merge(
        network_of(
            &[(1, 0.0, 0.0), (2, 9.0, 0.0), (3, -90.0, 0.0), (4, 99.0, 0.0), (5, 0.0, 90.0), (6, 9.0, -90.0)],
            &[
                (21, &[3, 1, 2, 4], "highway=secondary"),
                (24, &[5, 1], "highway=residential"),
                (25, &[6, 2], "highway=residential"),
            ],
        ),
        &ConsolidateOptions::default(),
    );
    assert_eq!(notes.len(), 1);
    assert!(notes[0].merged && notes[0].reason == MergeReason::Short && notes[0].left < 5.0, "{notes:?}");
    assert_eq!(the_merged(&merged).1, [4, 6, 3, 5]);
}

#[test]
fn pieces_of_a_street_with_the_same_lanes_become_one_road() {
    let street = network_of(
        &[(1, 0.0, 0.0), (2, 50.0, 0.0), (3, 100.0, 10.0), (4, 150.0, 10.0)],
        &[
            (31, &[1, 2], "highway=residential name=A"),
            (32, &[3, 2], "highway=residential name=B"),
            (33, &[3, 4], "highway=residential maxspeed=10"),
        ],
    );
    let (joined, _) = merge(street, &ConsolidateOptions::default());
    assert_eq!(joined.roads.len(), 2, "the speed changes at node 3, nothing at node 2");
    let long = joined.roads.iter().find(|r| r.ways.len() == 2).unwrap();
    assert_eq!((long.key.first, long.key.last), (1, 3));
    assert!((long.line.length() - 50.0 - 2600_f64.sqrt()).abs() < 0.1);
}

#[test]
fn carriageways_around_an_island_become_one_road_with_a_median() {
    let link = network_of(
        &[
            (1, 0.0, 0.0),
            (2, 60.0, 0.0),
            (3, 20.0, 4.0),
            (4, 40.0, 4.0),
            (5, 20.0, -4.0),
            (6, 40.0, -4.0),
            (7, -80.0, 0.0),
            (8, 140.0, 0.0),
        ],
        &[
            (41, &[7, 1], "highway=secondary name=A"),
            (42, &[2, 4, 3, 1], "highway=secondary name=A oneway=yes"),
            (43, &[1, 5, 6, 2], "highway=secondary name=A oneway=yes"),
            (44, &[2, 8], "highway=secondary name=A"),
        ],
    );
    let (joined, _) = merge(link, &ConsolidateOptions::default());
    assert_eq!(joined.roads.len(), 3);
    let island = joined.roads.iter().find(|r| r.ways.len() == 2).unwrap();
    let kinds: Vec<_> = island.section.strips.iter().map(|s| (s.kind, s.travel)).collect();
    // Way 42 has the smaller key: its line runs from node 2 to node 1, and it is driven with it, on the right.
    assert_eq!(kinds.first(), Some(&(StripKind::Drive, Travel::Backward)), "{kinds:?}");
    assert_eq!(kinds.last(), Some(&(StripKind::Drive, Travel::Forward)), "{kinds:?}");
    assert!(kinds.iter().any(|(kind, _)| *kind == StripKind::Buffer));
}

#[test]
fn the_roads_of_a_roundabout_are_not_merged() {
    // Four two-way streets on a ring of 6 m: its roads have no room for a waiting car, but no car waits there.
    let around: Vec<(i64, f64, f64)> = (0..16)
        .map(|i: i32| (i64::from(i) + 1, f64::from(i) * std::f64::consts::TAU / 16.0))
        .map(|(id, angle)| (id, 6.0 * angle.cos(), 6.0 * angle.sin()))
        .chain([(101, 80.0, 0.0), (102, 0.0, 80.0), (103, -80.0, 0.0), (104, 0.0, -80.0)])
        .collect();
    let ring: Vec<i64> = (1..=16).chain([1]).collect();
    let street = "highway=residential";
    let ways: [(i64, &[i64], &str); 5] = [
        (1, &ring, "highway=residential junction=roundabout"),
        (2, &[1, 101], street),
        (3, &[5, 102], street),
        (4, &[9, 103], street),
        (5, &[13, 104], street),
    ];
    let (merged, notes) = merge(network_of(&around, &ways), &ConsolidateOptions::default());
    assert!(notes.iter().all(|note| !note.merged), "{notes:?}");
    assert_eq!(merged.roads.iter().filter(|road| road.roundabout).count(), 4);
    // Elsewhere such a short road would lie inside an intersection.
    let options = ConsolidateOptions { short_on_ring: SHORT, ..ConsolidateOptions::default() };
    let notes = merge(network_of(&around, &ways), &options).1;
    assert!(notes.iter().any(|note| note.merged), "{notes:?}");
}

/// A street with dead ends `apart` metres from each other, on alternating sides, each with these tags and this length, metres.
fn street_with_dead_ends(count: i64, apart: f64, (tags, length): (&str, f64)) -> RoadNetwork {
    let east = |at: i64| apart * at as f64;
    let mut nodes = vec![(1, -100.0, 0.0), (2, east(count - 1) + 100.0, 0.0)];
    for at in 0..count {
        let side = if at % 2 == 0 { 1.0 } else { -1.0 };
        nodes.extend([(100 + at, east(at), 0.0), (500 + at, east(at), side * length)]);
    }
    let street: Vec<i64> = [1].into_iter().chain((0..count).map(|at| 100 + at)).chain([2]).collect();
    let dead_ends: Vec<[i64; 2]> = (0..count).map(|at| [100 + at, 500 + at]).collect();
    let ways = dead_ends.iter().zip(10..).map(|(nodes, id)| (id, &nodes[..], tags));
    network_of(&nodes, &[(9, &street[..], "highway=residential")].into_iter().chain(ways).collect::<Vec<_>>())
}

/// The network as it is laid out, and how many roads are left out.
fn without_crowding(network: RoadNetwork) -> (RoadNetwork, usize) {
    let kept = |n: &RoadNetwork| remaining(n, &mut PlanCache::default());
    let (network, _, left_out) = consolidate(join_continuations(network), &ConsolidateOptions::default(), kept);
    (network, left_out.len())
}

/// How many roads lead off the street that are not built and how many that are, and how many nodes the largest intersection has.
fn dead_ends_left(network: RoadNetwork) -> (usize, usize, usize) {
    let (network, left_out) = without_crowding(network);
    let built = network.roads.iter().filter(|road| road.key.way >= 10).count();
    let largest = network.intersections.iter().map(|at| at.nodes.len()).max();
    (left_out, built, largest.unwrap_or_default())
}

#[test]
fn a_row_of_driveways_does_not_become_one_intersection() {
    let driveway = ("highway=service service=driveway", 25.0);
    let (left_out, built, largest) = dead_ends_left(street_with_dead_ends(40, 7.0, driveway));
    assert_eq!(left_out + built, 40);
    assert!(
        built >= 10 && largest <= 3,
        "{built} driveways are left, and {largest} nodes make the largest intersection"
    );
    // They have room, or there are only two of them; or they are no dead ends to a house.
    assert_eq!(dead_ends_left(street_with_dead_ends(40, 14.0, driveway)), (0, 40, 1));
    assert_eq!(dead_ends_left(street_with_dead_ends(2, 4.0, driveway)), (0, 2, 2));
    assert_eq!(dead_ends_left(street_with_dead_ends(6, 7.0, ("highway=residential", 25.0))).0, 0);
    assert_eq!(dead_ends_left(street_with_dead_ends(6, 7.0, ("highway=service", 150.0))).0, 0);
}

#[test]
fn which_driveways_of_a_row_are_built_depends_on_those_beside_them() {
    let driveway = ("highway=service service=driveway", 25.0);
    let ways = |count: i64| -> Vec<i64> {
        let (network, _) = without_crowding(street_with_dead_ends(count, 7.0, driveway));
        let mut ways: Vec<i64> = network.roads.iter().map(|road| road.key.way).filter(|way| *way >= 10).collect();
        ways.sort_unstable();
        ways
    };
    // A longer row begins with the same ones, up to a few before its end.
    let (long, longer) = (ways(60), ways(90));
    let same = long.iter().zip(&longer).take_while(|(a, b)| a == b).last().map(|(way, _)| *way);
    assert!(same.is_some_and(|way| way >= 10 + 60 - 15), "{same:?}");
}

/// Where a street leads across another one, metres: each a little farther from the one before, so that these are merged one after
/// another.
fn place_in_row(street: i64) -> f64 {
    9.0 * street as f64 + 0.0005 * (street * street) as f64
}

/// The nodes that are one intersection each, where these streets lead across another one; numbered from west to east.
fn merged_in_a_row(streets: std::ops::Range<i64>) -> Vec<Vec<i64>> {
    let at = place_in_row;
    let across = streets.clone().flat_map(|i| [(i, at(i), 0.0), (1000 + i, at(i), 60.0), (2000 + i, at(i), -60.0)]);
    let ends = [(3001, at(streets.start) - 150.0, 0.0), (3002, at(streets.end) + 150.0, 0.0)];
    let nodes: Vec<(i64, f64, f64)> = across.chain(ends).collect();
    let along: Vec<i64> = [3001].into_iter().chain(streets.clone()).chain([3002]).collect();
    let lines: Vec<[i64; 3]> = streets.clone().map(|i| [1000 + i, i, 2000 + i]).collect();
    let mut ways: Vec<hand_drawn::DrawnWay<'_>> = vec![(1, &along, "highway=tertiary")];
    ways.extend(lines.iter().zip(streets).map(|(line, i)| (100 + i, &line[..], "highway=residential")));
    let (merged, _) = merge(network_of(&nodes, &ways), &ConsolidateOptions::default());
    merged.intersections.into_iter().map(|i| i.nodes).filter(|nodes| nodes.len() > 1).collect()
}

/// What is merged depends on nothing farther away than this, metres: as far as tiles look by themselves.
const FARTHEST: f64 = 400.0;

#[test]
fn what_is_merged_in_a_row_depends_on_its_surroundings_alone() {
    let whole = merged_in_a_row(0..140);
    assert!(whole.len() > 10, "{whole:?}");
    for first in 1..9 {
        let far = |nodes: &Vec<i64>| nodes.iter().all(|node| place_in_row(*node) - place_in_row(first) > FARTHEST);
        let shorter = merged_in_a_row(first..140);
        assert!(whole.iter().filter(|nodes| far(nodes)).eq(shorter.iter().filter(|nodes| far(nodes))), "from {first}");
    }
}
