//! Outlines of small stars of roads.

use proptest::prelude::*;

use crate::builder::network::{RoadIx, RoadKey, hand_drawn};
use crate::builder::streets::alignment::{lay_side_by_side, smooth_bends};
use crate::builder::tags::cross_section::{CrossSection, Strip, StripKind, Travel};
use crate::geometry::{Point, Polyline, polygon, simple_ring};

use super::intersection_plan::is_valid;
use super::sizes::{KERB_RADIUS, MARGIN, MOST_TRIM};
use super::*;

/// A road from node 0 at the origin through these points, with its width in metres.
#[derive(Clone, Debug)]
struct Arm {
    points: Vec<(f64, f64)>,
    width: f64,
}

fn arm(points: &[(f64, f64)], width: f64) -> Arm {
    Arm { points: points.to_vec(), width }
}

fn section(width: f64) -> CrossSection {
    let strip = |travel| Strip::plain(StripKind::Drive, travel, width / 2.0, false);
    CrossSection { strips: vec![strip(Travel::Backward), strip(Travel::Forward)] }
}

/// The network of these arms around node 0.
fn network(arms: &[Arm]) -> RoadNetwork {
    let mut roads = Vec::new();
    let mut ends = Vec::new();
    for (i, arm) in arms.iter().enumerate() {
        let points = std::iter::once(&(0.0, 0.0)).chain(&arm.points).map(|(x, y)| Point::new(*x, *y));
        let line = Polyline::new(points).unwrap();
        let node = i as i64 + 1;
        ends.push((node, line.last()));
        let key = RoadKey { way: node, first: 0, last: node, turn: 0 };
        roads.push(hand_drawn::road(key, [0, i as u32 + 1], line, section(arm.width)));
    }
    let direction = |i: usize| {
        let p = roads[i].line.at(1.0);
        -p.y.atan2(p.x)
    };
    let mut order: Vec<usize> = (0..roads.len()).collect();
    order.sort_by(|a, b| direction(*a).total_cmp(&direction(*b)));
    let first = order.iter().position(|i| *i == 0).unwrap();
    order.rotate_left(first);
    let centre = order.iter().map(|i| RoadEnd { road: RoadIx(*i as u32), end: End::Start }).collect();
    let mut intersections = vec![Intersection::of_arms(vec![0], Point::origin(), centre)];
    for (i, (node, p)) in ends.into_iter().enumerate() {
        let at = RoadEnd { road: RoadIx::new(i), end: End::End };
        intersections.push(Intersection { map_edge: true, ..Intersection::of_arms(vec![node], p, vec![at]) });
    }
    RoadNetwork { roads, intersections, ..RoadNetwork::default() }
}

/// The polygon of a road between its cuts.
fn ribbon(network: &RoadNetwork, outlines: &Outlines, road: usize) -> Vec<Point> {
    let [from, to] = outlines.kept[road];
    let line = network.roads[road].line.cut(from, to).unwrap();
    let half = network.roads[road].half_width();
    let mut ring = line.offset(half, thicken::MITER_LIMIT).unwrap().points().to_vec();
    ring.extend(line.offset(-half, thicken::MITER_LIMIT).unwrap().reversed().points());
    ring
}

/// Asserts what must hold for every outline.
fn assert_sound(network: &RoadNetwork) -> Outlines {
    // Without consolidation, which would join the two roads of a bend.
    let network = smooth_bends(network.clone());
    let mut memory = PlanCache::default();
    let cut = wanted(&network, &mut memory);
    let network = &lay_side_by_side(network, &cut).0;
    let (outlines, findings) = outlines_within(network, &cut, &memory);
    let (forgetful, _) = outlines_within(network, &cut, &PlanCache::default());
    assert_eq!(format!("{:.6?}", outlines), format!("{:.6?}", forgetful), "the cached plan is the new plan");
    assert!(findings.is_empty(), "{findings:?}");
    for (outline, intersection) in outlines.intersections.iter().zip(&network.intersections) {
        assert_eq!(outline.cuts.iter().map(|c| c.at).collect::<Vec<_>>(), intersection.arms);
        if outline.case == OutlineCase::MapEdge {
            continue;
        }
        assert!(simple_ring::is_simple(&outline.ring), "{:?}", outline.ring);
        assert!(polygon::signed_area(&outline.ring) < 0.0, "the ring runs clockwise");
        for (i, cut) in outline.cuts.iter().enumerate() {
            assert!(outline.ring.contains(&cut.left) && outline.ring.contains(&cut.right));
            assert_eq!(outline.corners[i].first(), Some(&cut.left));
            assert_eq!(outline.corners[i].last(), Some(&outline.cuts[(i + 1) % outline.cuts.len()].right));
        }
        for road in 0..network.roads.len() {
            let shared = polygon::overlap(&outline.ring, &ribbon(network, &outlines, road));
            assert!(shared < 0.05, "the outline overlaps road {road} by {shared} m2");
        }
    }
    for a in 0..network.roads.len() {
        for b in a + 1..network.roads.len() {
            let shared = polygon::overlap(&ribbon(network, &outlines, a), &ribbon(network, &outlines, b));
            assert!(shared < 0.05, "roads {a} and {b} overlap by {shared} m2");
        }
    }
    outlines
}

#[test]
fn a_crossing_at_right_angles_has_four_rounded_corners() {
    let network = network(&[
        arm(&[(0.0, 50.0)], 6.0),
        arm(&[(50.0, 0.0)], 6.0),
        arm(&[(0.0, -50.0)], 6.0),
        arm(&[(-50.0, 0.0)], 6.0),
    ]);
    let outlines = assert_sound(&network);
    let trim = 3.0 + KERB_RADIUS + MARGIN;
    assert!(outlines.kept.iter().all(|k| (k[0] - trim).abs() < 1e-9), "{:?}", outlines.kept);
    let outline = &outlines.intersections[0];
    assert_eq!(outline.case, OutlineCase::General);
    assert!(outline.corners.iter().all(|c| c.len() == 9));
    let north = &outline.cuts[0];
    assert_eq!((north.left.x, north.right.x), (3.0, -3.0), "left looking into the intersection");
}

#[test]
fn a_t_junction_is_straight_on_its_far_side() {
    let network = network(&[arm(&[(0.0, -50.0)], 6.0), arm(&[(-50.0, 0.0)], 8.0), arm(&[(50.0, 0.0)], 8.0)]);
    let outlines = assert_sound(&network);
    let ring = &outlines.intersections[0].ring;
    assert!(ring.iter().all(|p| p.y <= 4.0 + 1e-9));
}

#[test]
fn a_bend_is_trimmed_by_its_angle() {
    let trim = |to: (f64, f64)| {
        let network = network(&[arm(&[(-60.0, 0.0)], 6.0), arm(&[to], 6.0)]);
        let outlines = assert_sound(&network);
        assert_eq!(outlines.intersections[0].case, OutlineCase::Degenerate);
        outlines.kept[0][0]
    };
    let (straight, slight, right, sharp) =
        (trim((60.0, 0.0)), trim((60.0, 10.0)), trim((0.0, 60.0)), trim((-60.0, 40.0)));
    assert!(
        straight < 1.0 && straight < slight && slight < right && right < sharp,
        "{straight} {slight} {right} {sharp}"
    );
}

#[test]
fn a_change_of_width_is_a_taper() {
    assert_sound(&network(&[arm(&[(-60.0, 0.0)], 12.0), arm(&[(60.0, 3.0)], 6.0)]));
}

#[test]
fn a_ramp_diverges_in_a_wedge() {
    // At six degrees the edges collide 50 m away; the intersection must not become as long.
    let (main, ramp) = (7.0, 4.0);
    let network = network(&[arm(&[(-150.0, 0.0)], main), arm(&[(150.0, 0.0)], main), arm(&[(150.0, 15.0)], ramp)]);
    let outlines = assert_sound(&network);
    let outline = &outlines.intersections[0];
    assert_eq!(outline.case, OutlineCase::Ramp);
    let farthest = MOST_TRIM * main + 1.0;
    assert!(outlines.kept.iter().all(|kept| kept[0] < farthest), "{:?}", outlines.kept);
    assert!(polygon::signed_area(&outline.ring).abs() < (main + ramp) * farthest * 1.5);
}

#[test]
fn a_ring_that_folds_is_not_valid() {
    let ring = |tip: f64| [(0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (9.0, 4.0), (9.5, tip), (5.0, 3.0)];
    let ring = |tip| ring(tip).map(|(x, y)| Point::new(x, y));
    assert!(is_valid(&ring(3.5)));
    let hair =
        [(0.0, 0.0), (0.0, 9.0), (9.0, 9.0), (9.0, 4.0), (9.5, 4.01), (5.0, 3.88)].map(|(x, y)| Point::new(x, y));
    assert!(simple_ring::is_simple(&hair) && !is_valid(&hair), "two edges nearly coincide");
}

#[test]
fn a_dead_end_is_cut_square() {
    let mut network = network(&[arm(&[(60.0, 0.0)], 6.0)]);
    let outlines = assert_sound(&network);
    assert_eq!(outlines.intersections[0].case, OutlineCase::DeadEnd);
    assert_eq!(outlines.kept[0], [3.0, 60.0]);
    network.intersections[0].map_edge = true;
    let (outlines, _) = super::outlines(&network);
    assert_eq!(outlines.intersections[0].case, OutlineCase::MapEdge);
    assert_eq!(outlines.kept[0], [0.0, 60.0]);
}

fn any_star() -> impl Strategy<Value = Vec<Arm>> {
    (2_usize..=6, 0.0..std::f64::consts::TAU)
        .prop_flat_map(|(n, turn)| {
            proptest::collection::vec((-0.3..0.3_f64, 3.0..14.0_f64, -0.3..0.3_f64), n).prop_map(move |arms| {
                arms.iter()
                    .enumerate()
                    .map(|(i, (jitter, width, bend))| {
                        let angle = turn + (i as f64 + jitter) * std::f64::consts::TAU / n as f64;
                        let at = |r: f64, a: f64| (r * a.cos(), r * a.sin());
                        let p = at(40.0, angle);
                        let q = at(60.0, angle + bend);
                        arm(&[p, (p.0 + q.0, p.1 + q.1)], *width)
                    })
                    .collect()
            })
        })
        .prop_filter("roads that overlap at their far ends", |arms: &Vec<Arm>| ends_clear(arms))
}

/// Whether no road overlaps the far end of another: no cut at the intersection could separate them.
fn ends_clear(arms: &[Arm]) -> bool {
    let end = |arm: &Arm| arm.points.last().map(|&(x, y)| Point::new(x, y));
    let clear = |a: &Arm, b: &Arm| end(a).zip(end(b)).is_none_or(|(p, q)| (p - q).norm() >= (a.width + b.width) / 2.0);
    arms.iter().enumerate().all(|(i, a)| arms[i + 1..].iter().all(|b| clear(a, b)))
}

proptest! {
    #[test]
    fn stars_are_sound(arms in any_star()) {
        assert_sound(&network(&arms));
    }

    #[test]
    fn the_order_of_the_arms_does_not_matter(arms in any_star(), shift in 1_usize..6) {
        let mut moved = arms.clone();
        let n = arms.len();
        moved.rotate_left(shift % n);
        let (a, b) = (assert_sound(&network(&arms)), assert_sound(&network(&moved)));
        for i in 0..n {
            prop_assert_eq!(a.kept[(i + shift) % n], b.kept[i]);
        }
    }
}

#[test]
fn a_corner_leaves_out_what_another_road_covers_unless_a_cut_lies_on_it() {
    let network = network(&[arm(&[(0.0, 50.0)], 6.0), arm(&[(50.0, 0.0)], 6.0), arm(&[(-50.0, 0.0)], 6.0)]);
    let outline = &assert_sound(&network).intersections[0];
    let box_of = |[west, east]: [f64; 2], north: f64| {
        vec![Point::new(west, -9.0), Point::new(west, north), Point::new(east, north), Point::new(east, -9.0)]
    };
    let past = box_of([-4.0, 4.0], -2.5);
    assert!(polygon::overlap(&outline.ring, &past) > 3.9);
    let clear = outline.without(std::slice::from_ref(&past)).unwrap();
    assert!(polygon::overlap(&clear.ring, &past) < 0.01);
    let kept = polygon::overlap(&clear.ring, &outline.ring) + polygon::overlap(&past, &outline.ring);
    assert!((kept + polygon::signed_area(&outline.ring)).abs() < 0.01, "it keeps the rest");
    assert_eq!(clear.cuts, outline.cuts);
    for (i, corner) in clear.corners.iter().enumerate() {
        let next = &clear.cuts[(i + 1) % clear.cuts.len()];
        assert_eq!((corner.first(), corner.last()), (Some(&clear.cuts[i].left), Some(&next.right)));
    }
    assert!(outline.without(&[box_of([-20.0, 4.0], -2.5)]).is_none(), "a cut is covered");
    assert!(outline.without(&[box_of([-1.0, 1.0], 20.0)]).is_none(), "it would fall apart");
}

/// What the outlines leave of the road between nodes 2 and 3, metres.
fn left_between(nodes: &[(i64, f64, f64)], ways: &[&[i64]]) -> f64 {
    let ways: Vec<_> = ways.iter().zip(10..).map(|(nodes, id)| (id, *nodes, "highway=tertiary lanes=2")).collect();
    let network = hand_drawn::network_of(nodes, &ways);
    let road = network.roads.iter().position(|road| (road.key.first, road.key.last) == (2, 3)).unwrap();
    let [from, to] = outlines(&network).0.kept[road];
    to - from
}

#[test]
fn kerbs_leave_room_for_a_car_between_two_side_streets() {
    let apart = |apart: f64| {
        let ends = [(1, -90.0, 0.0), (2, 0.0, 0.0), (3, apart, 0.0), (4, 90.0 + apart, 0.0)];
        let nodes = [&ends[..], &[(5, 0.0, 80.0), (6, apart, 80.0)]].concat();
        left_between(&nodes, &[&[1, 2], &[2, 3], &[3, 4], &[2, 5], &[3, 6]])
    };
    assert!((apart(16.0) - LEAST_ROAD_BETWEEN).abs() < 0.01, "{}", apart(16.0));
    assert!(apart(40.0) > 20.0, "kerbs have all the room that they want");
    assert!((LEAST_ROAD..LEAST_ROAD_BETWEEN).contains(&apart(9.0)), "not even without kerbs");
}
