//! The middle of every way through an intersection: neighbours that part keep to their own sides.
//!
//! Each way is drawn as it is smoothest by itself. Where a lane goes straight on for long before it turns off, or shifts
//! sideways, it can run into the lane beside it although both lead apart; then one of the two bends earlier or later.

use std::cell::OnceCell;

use crate::builder::lanes::types::ArmLane;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, curve, polygon, simple_ring, swing_out_turn};

use super::movement_types::Movement;

/// Ways that share less than this, square metres, do not touch.
const TOUCH: f64 = 0.01;
/// Handles of the cubics to choose from at either end, in parts of the distance between the ends.
const HANDLES: [f64; 4] = [1.0 / 3.0, 0.2, 0.6, 0.8];
/// Parts of the distance between the ends over which a way may go straight on before it bends, and behind.
const HELD: [f64; 3] = [0.0, 0.25, 0.5];
/// No way bends more tightly than this radius, metres, only to keep clear of another.
const RADIUS_LEAST: f64 = 6.0;

/// A movement with the lanes that it joins.
pub type MovementEnds<'a> = (Movement, &'a ArmLane, &'a ArmLane);

/// One way with its shapes to choose from.
struct TurnCenterline {
    /// As it is smoothest by itself, then by handles, then held straight; `None` where it would bend too tightly.
    shapes: Vec<Option<Shape>>,
    chosen: usize,
    /// The ways from the lanes beside it that part from it, by index.
    beside: Vec<usize>,
}

struct Shape {
    poses: Vec<Pose>,
    /// `None` where no way lies beside it.
    outline: Option<Outline>,
}

/// What a way covers.
struct Outline {
    ring: Vec<Point>,
    /// Whether it never crosses itself, as hardly one does: what it shares with others is known without a sweep.
    simple: bool,
}

impl Outline {
    fn new((_, from, to): &MovementEnds, poses: &[Pose]) -> Self {
        let [mut ring, right] =
            curve::sides(poses, from.width / 2.0, to.width / 2.0).map(|side| curve::untangled(&side));
        ring.extend(right.into_iter().rev());
        Self { simple: simple_ring::is_simple(&ring), ring }
    }

    /// Area in square metres that both cover.
    fn shared(&self, other: &Self) -> f64 {
        let simple = self.simple && other.simple;
        if simple { polygon::common_area(&self.ring, &other.ring) } else { polygon::overlap(&self.ring, &other.ring) }
    }
}

/// The poses of all movements, in their order.
pub fn turn_centerlines(ends: &[MovementEnds]) -> Vec<Vec<Pose>> {
    let bundles = bundles(ends);
    let mut courses: Vec<TurnCenterline> = ends
        .iter()
        .enumerate()
        .zip(swept(ends))
        .map(|((i, end), poses)| {
            let beside: Vec<usize> = (0..ends.len()).filter(|&j| j != i && part(&end.0, &ends[j].0)).collect();
            let only = if beside.is_empty() { Shape { poses, outline: None } } else { shape(end, poses) };
            TurnCenterline { shapes: vec![Some(only)], chosen: 0, beside }
        })
        .collect();
    // The ways that go side by side with one from end to end, itself among them: they bend alike.
    let bundle = |i: usize| (0..ends.len()).filter(|&j| bundles[j] == bundles[i]).collect::<Vec<usize>>();
    for i in 0..courses.len() {
        for j in courses[i].beside.clone().into_iter().filter(|&j| j > i && bundles[j] != bundles[i]) {
            if overlap(&courses, i, j) > TOUCH {
                let both = [bundle(i), bundle(j)];
                for &member in both.iter().flatten() {
                    add_shapes(&mut courses[member], &ends[member]);
                }
                choose(&mut courses, &both);
            }
        }
    }
    let chosen = courses.into_iter().map(|mut course| course.shapes.swap_remove(course.chosen));
    chosen.map(|shape| shape.map_or_else(Vec::new, |shape| shape.poses)).collect()
}

/// Every way as it is smoothest by itself. It swings out for a wider turn unless it would run into a way from the lane
/// beside it, however that one is drawn.
fn swept(ends: &[MovementEnds]) -> Vec<Vec<Pose>> {
    let sketches = |(_, from, to): &MovementEnds| {
        let plain = curve::join(from.pose, to.pose);
        let wide = swing_out_turn::swing_out(from.pose, to.pose, &plain);
        (Sketch::new(plain), wide.map(Sketch::new))
    };
    let sketches: Vec<(Sketch, Option<Sketch>)> = ends.iter().map(sketches).collect();
    let clear = |i: usize, wide: &Sketch| {
        let beside =
            |&j: &usize| ends[j].0.from == ends[i].0.from && ends[j].0.in_lane.abs_diff(ends[i].0.in_lane) == 1;
        let both = |j: usize| [Some(&sketches[j].0), sketches[j].1.as_ref()].into_iter().flatten();
        let mut others = (0..ends.len()).filter(beside).flat_map(|j| both(j).map(move |other| other.outline(&ends[j])));
        others.all(|other| {
            let shared = |own: &Sketch| own.outline(&ends[i]).shared(other);
            let more = shared(wide);
            more <= TOUCH || more <= shared(&sketches[i].0)
        })
    };
    let clear: Vec<bool> =
        sketches.iter().enumerate().map(|(i, (_, wide))| wide.as_ref().is_some_and(|wide| clear(i, wide))).collect();
    let chosen = sketches.into_iter().zip(clear);
    chosen.map(|((plain, wide), clear)| wide.filter(|_| clear).unwrap_or(plain).poses).collect()
}

/// A course whose outline is drawn where it is asked for: few ways come near others.
struct Sketch {
    poses: Vec<Pose>,
    outline: OnceCell<Outline>,
}

impl Sketch {
    fn new(poses: Vec<Pose>) -> Self {
        Self { poses, outline: OnceCell::new() }
    }

    fn outline(&self, ends: &MovementEnds) -> &Outline {
        self.outline.get_or_init(|| Outline::new(ends, &self.poses))
    }
}

/// Whether two movements begin side by side and do not end so.
fn part(a: &Movement, b: &Movement) -> bool {
    let together = a.to == b.to && a.out_lane.abs_diff(b.out_lane) <= 1;
    a.from == b.from && a.in_lane.abs_diff(b.in_lane) == 1 && !together
}

/// For every movement the first of those that go side by side with it from end to end.
fn bundles(ends: &[MovementEnds]) -> Vec<usize> {
    let beside = |a: &Movement, b: &Movement| {
        let lanes = (b.in_lane.checked_sub(a.in_lane), b.out_lane.checked_sub(a.out_lane));
        (a.from, a.to) == (b.from, b.to) && lanes == (Some(1), Some(1))
    };
    // Neighbours follow each other in order of their lanes, so that each finds the first through the one before.
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by_key(|&i| ends[i].0);
    let mut first: Vec<usize> = (0..ends.len()).collect();
    for (n, &i) in order.iter().enumerate() {
        if let Some(&before) = order[..n].iter().find(|&&j| beside(&ends[j].0, &ends[i].0)) {
            first[i] = first[before];
        }
    }
    first
}

fn shape(ends: &MovementEnds, poses: Vec<Pose>) -> Shape {
    Shape { outline: Some(Outline::new(ends, &poses)), poses }
}

fn add_shapes(course: &mut TurnCenterline, ends: &MovementEnds) {
    if course.shapes.len() > 1 {
        return;
    }
    let least = RADIUS_LEAST.min(course.shapes[0].as_ref().map_or(RADIUS_LEAST, |own| curve::radius(&own.poses)));
    let [from, to] = [ends.1.pose, ends.2.pose];
    let bent = HANDLES.iter().flat_map(|&a| HANDLES.iter().map(move |&b| curve::cubic(from, to, [a, b])));
    let held = HELD.iter().flat_map(|&a| HELD.iter().map(move |&b| [a, b])).skip(1);
    let poses = bent.chain(held.map(|parts| curve::held(from, to, parts)));
    course.shapes.extend(poses.map(|poses| (curve::radius(&poses) >= least).then(|| shape(ends, poses))));
}

fn overlap(courses: &[TurnCenterline], i: usize, j: usize) -> f64 {
    let outline = |at: usize| courses[at].shapes[courses[at].chosen].as_ref()?.outline.as_ref();
    outline(i).zip(outline(j)).map_or(0.0, |(a, b)| a.shared(b))
}

/// Takes the shapes of two bundles by which they and their neighbours overlap least; of equals the first.
fn choose(courses: &mut [TurnCenterline], bundles: &[Vec<usize>; 2]) {
    let open = |courses: &[TurnCenterline], bundle: &[usize], shape: usize| {
        bundle.iter().all(|&member| courses[member].shapes.get(shape).is_some_and(Option::is_some))
    };
    let take = |courses: &mut [TurnCenterline], [a, b]: [usize; 2]| {
        bundles[0].iter().for_each(|&member| courses[member].chosen = a);
        bundles[1].iter().for_each(|&member| courses[member].chosen = b);
    };
    let count = |bundle: &[usize]| bundle.first().map_or(0, |&member| courses[member].shapes.len());
    let mut order: Vec<[usize; 2]> = (0..count(&bundles[0]))
        .flat_map(|a| (0..count(&bundles[1])).map(move |b| [a, b]))
        .filter(|&[a, b]| open(courses, &bundles[0], a) && open(courses, &bundles[1], b))
        .collect();
    order.sort_by_key(|&[a, b]| (a + b, a));
    let members = || bundles.iter().flatten().copied();
    let mut best = (f64::INFINITY, [0, 0]);
    for shapes in order {
        take(courses, shapes);
        let touching = members().flat_map(|m| {
            // A pair of two members counts once.
            let others = courses[m].beside.iter().copied().filter(move |&k| k > m || members().all(|other| other != k));
            others.map(move |k| (m, k))
        });
        let total: f64 = touching.map(|(m, k)| overlap(courses, m, k)).sum();
        if total < best.0 - TOUCH {
            best = (total, shapes);
        }
        if best.0 <= TOUCH {
            break;
        }
    }
    take(courses, best.1);
}

#[cfg(test)]
mod tests {
    use crate::builder::tags::cross_section::{Arrows, StripKind};
    use crate::geometry::Vector;
    use crate::lanelet::PointId;

    use super::*;

    fn lane(x: f64, y: f64, degrees: f64) -> ArmLane {
        let heading = Vector::new(degrees.to_radians().cos(), degrees.to_radians().sin());
        ArmLane {
            lane: 0,
            nodes: [PointId(1), PointId(2)],
            places: [Point::new(x, y); 2],
            pose: Pose { point: Point::new(x, y), heading },
            width: 3.0,
            kind: StripKind::Drive,
            arrows: Arrows::NONE,
        }
    }

    #[test]
    fn lanes_that_part_keep_to_their_own_sides() {
        // Side by side eastward; the left one shifts to the right, the right one turns off only at the end.
        let (left, right) = (lane(0.0, 1.5, 0.0), lane(0.0, -1.5, 0.0));
        let (on, off) = (lane(70.0, 0.0, 0.0), lane(66.0, -8.0, -30.0));
        let movement = |to, in_lane| Movement { from: 0, to, in_lane, out_lane: 0 };
        let ends = [(movement(1, 0), &left, &on), (movement(2, 1), &right, &off)];
        let alone = ends.map(|end| Outline::new(&end, &curve::join(end.1.pose, end.2.pose)));
        let apart = alone[0].shared(&alone[1]);
        assert!(apart > 5.0, "{apart} m2");
        let poses = turn_centerlines(&ends);
        let outlines: Vec<Outline> = ends.iter().zip(poses).map(|(end, poses)| Outline::new(end, &poses)).collect();
        let left = outlines[0].shared(&outlines[1]);
        assert!(left < 0.5, "{left} m2 remain");
    }

    #[test]
    fn lanes_that_turn_side_by_side_bend_alike() {
        // Two lanes turn left together; a third, beside them, goes straight on and would be run into.
        let into = [1.5, -1.5, -4.5].map(|y| lane(0.0, y, 0.0));
        let out = [lane(22.0, 20.0, 90.0), lane(25.0, 20.0, 90.0), lane(40.0, -2.0, 0.0)];
        let movement = |lane: usize, to, out_lane| Movement { from: 0, to, in_lane: lane, out_lane };
        let ends = [
            (movement(0, 1, 0), &into[0], &out[0]),
            (movement(1, 1, 1), &into[1], &out[1]),
            (movement(2, 2, 0), &into[2], &out[2]),
        ];
        assert_eq!(bundles(&ends), [0, 0, 2]);
        let poses = turn_centerlines(&ends);
        let outlines: Vec<Outline> = ends.iter().zip(poses).map(|(end, poses)| Outline::new(end, &poses)).collect();
        let turns = outlines[0].shared(&outlines[1]);
        // What remains between two cubics of unlike length is taken away where their common bound runs midway.
        assert!(turns < 4.0, "the two turns overlap by {turns} m2");
    }
}
