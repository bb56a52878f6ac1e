//! The broad phase against the comparison of all roads with all.

use std::sync::atomic::AtomicUsize;

use proptest::prelude::*;

use crate::builder::network::{Intersection, RoadKey, Stations, hand_drawn};
use crate::builder::tags::cross_section::{CrossSection, Strip, StripKind, Travel};
use crate::geometry::Point;

use super::*;
use crate::builder::streets::alignment::INNER_RADIUS;
use crate::builder::streets::alignment::side_order::SideHints;

/// A road: points, width, whether it is raised, first and last intersection.
type Drawn = (Vec<(f64, f64)>, f64, bool, u32, u32);

fn road(index: usize, (points, width, raised, from, to): &Drawn) -> Option<Road> {
    let key = RoadKey { way: index as i64, first: 0, last: 1, turn: 0 };
    let line = Polyline::new(points.iter().map(|(x, y)| Point::new(*x, *y)))?;
    let section = CrossSection { strips: vec![Strip::plain(StripKind::Drive, Travel::Forward, *width, false)] };
    Some(Road { level: f64::from(u8::from(*raised)), ..hand_drawn::road(key, [*from, *to], line, section) })
}

/// A network of roads between five intersections, whose arms do not matter.
fn network(roads: Vec<Road>) -> RoadNetwork {
    let intersections = (0..5).map(|_| Intersection::of_arms(Vec::new(), Point::origin(), Vec::new())).collect();
    RoadNetwork { roads, intersections, ..RoadNetwork::default() }
}

/// Random walks: roads that wind, turn back and cross themselves.
fn line() -> impl Strategy<Value = Vec<(f64, f64)>> {
    let strides = prop::collection::vec((-60.0..60.0, -40.0..40.0), 1..6);
    ((0.0..120.0, 0.0..80.0), strides).prop_map(|(begin, strides)| {
        let walked = strides.into_iter().scan(begin, |at, stride| {
            *at = (at.0 + stride.0, at.1 + stride.1);
            Some(*at)
        });
        std::iter::once(begin).chain(walked).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 512, ..ProptestConfig::default() })]

    #[test]
    fn the_broad_phase_keeps_every_road_beside_another(
        drawn in prop::collection::vec((line(), 2.0..14.0, any::<bool>(), 0..5_u32, 0..5_u32), 1..8),
        cut in 0.0..6.0,
    ) {
        let roads: Vec<Road> = drawn.iter().enumerate().filter_map(|(i, drawn)| road(i, drawn)).collect();
        let network = network(roads);
        let kept: Vec<Stations> = network.roads.iter().map(|road| [cut, road.line.length() - cut]).collect();
        let likely = candidates(&network, &kept);
        let all: Vec<usize> = (0..network.roads.len()).collect();
        let mut roads = ShiftedRoads { network: &network, kept: &kept, made: FxHashMap::default() };
        roads.make(&all);
        let search = OverlapSearch { roads: &roads.made, hints: &SideHints::default(), crowded: &AtomicUsize::new(0) };
        for (a, b) in search.find(&all, &all).keys() {
            prop_assert!(likely.contains(a) && likely.contains(b), "road {} beside road {}", a, b);
        }
    }
}

#[test]
fn roads_that_lie_on_too_many_others_are_told() {
    let laid = |count: usize| {
        let drawn = |i: usize| (vec![(0.0, 0.01 * i as f64), (12.0, 0.01 * i as f64)], 3.0, false, 0, 1);
        let roads: Vec<Road> = (0..count).filter_map(|i| road(i, &drawn(i))).collect();
        let kept: Vec<Stations> = roads.iter().map(|road| [0.0, road.line.length()]).collect();
        lay_side_by_side(network(roads), &kept).1.map(|finding| finding.message)
    };
    assert_eq!(laid(10), None);
    assert!(laid(65).is_some_and(|message| message.contains("beside or on 60 others: too many to lay side by side")));
}

/// How far away a road may lie, metres, so that it changes nothing: eight rounds of 35 m, one of 83 m, 92 m along which the sides show,
/// and a square of [`STRAIGHT_WITHIN`].
const FAR: f64 = 480.0;
/// What numbers differ by that are computed alike, metres.
const ROUNDING: f64 = 1e-9;
/// Half the length of the roads and of what is looked at in their middle, metres.
const HALF: f64 = 1500.0;
const MIDDLE: f64 = 50.0;

/// A road to the east from one place to another, metres, that winds by up to 6 m.
fn winding(from: f64, to: f64, north: f64) -> impl Strategy<Value = Drawn> {
    let winds = prop::collection::vec(-3.0..3.0, ((to - from) / 50.0) as usize + 2);
    (winds, 3.0..9.0).prop_map(move |(winds, width)| {
        let step = (to - from) / (winds.len() - 1) as f64;
        let points = winds.into_iter().enumerate().map(|(i, wind)| (from + step * i as f64, north + wind));
        (points.collect(), width, false, 0, 1)
    })
}

/// Long roads beside each other, and some beside them that are far away from their middle.
fn long_and_far() -> impl Strategy<Value = (Vec<Drawn>, Vec<Drawn>)> {
    let long = prop::collection::vec((40.0..70.0).prop_flat_map(|north| winding(-HALF, HALF, north)), 2..6);
    let far = (FAR..HALF - 100.0, 20.0..300.0, 36.0..74.0, any::<bool>());
    let far = far.prop_flat_map(|(from, length, north, west)| {
        let from = from + MIDDLE;
        let [from, to] = if west { [-from - length, -from] } else { [from, from + length] };
        winding(from, to, north)
    });
    (long, prop::collection::vec(far, 1..4))
}

/// How far north roads that lead east are after they were laid side by side, around the middle, metres.
fn laid_in_the_middle(drawn: &[Drawn]) -> Vec<Vec<f64>> {
    let roads: Vec<Road> = drawn.iter().enumerate().filter_map(|(i, drawn)| road(i, drawn)).collect();
    let kept: Vec<Stations> = roads.iter().map(|road| [0.0, road.line.length()]).collect();
    let laid = lay_side_by_side(network(roads), &kept).0;
    let near = |road: &Road| (-5..=5).filter_map(|i| north_at(&road.line, MIDDLE / 5.0 * f64::from(i))).collect();
    laid.roads.iter().map(near).collect()
}

/// How far north a line that leads east is at a place, metres.
fn north_at(line: &Polyline, east: f64) -> Option<f64> {
    let mut segments = line.points().iter().zip(line.points().iter().skip(1));
    let (from, to) = segments.find(|(from, to)| (from.x..=to.x).contains(&east))?;
    Some(from.y + (to.y - from.y) * (east - from.x) / (to.x - from.x))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn roads_are_laid_side_by_side_as_their_surroundings_want((long, far) in long_and_far()) {
        let all: Vec<Drawn> = long.iter().chain(&far).cloned().collect();
        let (alone, beside) = (laid_in_the_middle(&long), laid_in_the_middle(&all));
        prop_assert!(alone.iter().all(|norths| norths.len() == 11), "{alone:?}");
        for (alone, beside) in alone.iter().flatten().zip(beside.iter().flatten()) {
            prop_assert!((alone - beside).abs() < ROUNDING, "{alone} {beside}");
        }
    }
}

#[test]
fn on_which_side_roads_lie_is_decided_near_by() {
    // Two roads lie on each other for 3 km. Far away, the second is drawn clearly on the other side of the first.
    let second_in_the_middle = |far: f64| {
        let first = (vec![(-HALF, 0.0), (HALF, 0.0)], 6.0, false, 0, 1);
        let second = (vec![(-HALF, 0.5), (400.0, 0.5), (500.0, far), (HALF, far)], 6.0, false, 2, 3);
        laid_in_the_middle(&[first, second]).pop()
    };
    let (alike, across) = (second_in_the_middle(0.5).unwrap(), second_in_the_middle(-4.0).unwrap());
    let same = alike.iter().zip(&across).all(|(alike, across)| (alike - across).abs() < 0.001);
    assert!(same && alike.iter().all(|north| *north > 3.0), "{alike:?} {across:?}");
}

#[test]
fn roads_that_are_squeezed_stay_and_the_wide_ones_beside_them_yield() {
    // Two bus lanes between two carriageways of eight lanes, whose lines lie 20 m apart.
    let drawn = [(-10.0, 24.0), (-2.0, 3.0), (2.0, 3.0), (10.0, 24.0)];
    let straight = |(north, width): (f64, f64)| (vec![(-HALF, north), (HALF, north)], width, false, 0, 1);
    let norths: Vec<f64> = laid_in_the_middle(&drawn.map(straight)).into_iter().map(|norths| norths[5]).collect();
    let gaps: Vec<f64> = norths.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let apart = gaps.iter().zip([13.5, 3.0, 13.5]).all(|(gap, least)| *gap > least - TOLERANCE);
    assert!(apart, "{norths:?}");
    assert!((norths[0] + norths[3]).abs() < 0.1 && norths[1].abs() < 3.0, "{norths:?}");
}

#[test]
fn the_legs_of_a_hairpin_lie_so_far_apart_that_its_inner_edge_keeps_a_radius() {
    let legs = |between: f64| {
        let drawn = (vec![(0.0, 0.0), (100.0, 0.0), (100.0, between), (0.0, between)], 3.0, false, 0, 1);
        let network = network(road(0, &drawn).into_iter().collect());
        let kept = [[0.0, network.roads[0].line.length()]];
        let laid = lay_side_by_side(network, &kept).0;
        let line = &laid.roads[0].line;
        let [there, back] = [line.clone(), line.reversed()].map(|line| line.at(50.0).y);
        back - there
    };
    let least = 3.0 + 2.0 * INNER_RADIUS;
    assert!(legs(4.0) > least - TOLERANCE, "{} m", legs(4.0));
    assert!((legs(7.0) - 7.0).abs() < 1e-9, "legs that are far apart stay: {} m", legs(7.0));
}
