//! The centre lines of turning lanelets: neighbours that part keep to their own sides.
//!
//! Each is drawn as smooth as it can be by itself. A lane that goes straight on for long before it turns off, or that shifts
//! sideways, can run into the lane beside it although both lead apart; then one of the two bends earlier or later.

use rustc_hash::{FxHashMap, FxHashSet};
use std::cell::{OnceCell, RefCell};

use crate::builder::lanes::types::ArmLane;
use crate::geometry::pose::Pose;
use crate::geometry::{Point, angle_between, curve, polygon, simple_ring, swing_out_turn};

use super::movement_types::Movement;

/// Lanelets that share less than this, square metres, do not overlap.
const TOUCH: f64 = 0.01;
/// Handles of the cubic Bézier curves to choose from at either end, in parts of the distance between the ends.
const HANDLES: [f64; 4] = [1.0 / 3.0, 0.2, 0.6, 0.8];
/// Parts of the distance between the ends over which a centre line may go straight before it bends, and after.
const STRAIGHT_PARTS: [f64; 3] = [0.0, 0.25, 0.5];
/// No centre line bends more tightly than this radius, metres, only to keep clear of another.
const RADIUS_LEAST: f64 = 6.0;
/// A lane shifts sideways where its direction changes by no more than this, radians.
const SHIFT_MOST: f64 = 0.5;
/// It goes straight on this far beyond the end of another road, metres, ...
const BEYOND: f64 = 1.0;
/// ... if it then shifts with at least this radius, metres.
const SHIFT_RADIUS: f64 = 12.0;

/// A movement with the lanes that it joins.
pub type MovementEnds<'a> = (Movement, &'a ArmLane, &'a ArmLane);

/// A centre line with its shapes to choose from.
struct TurnCenterline {
    /// The smoothest, then by handles, then with straight parts; `None` where it would bend too tightly. One that
    /// leads around has no other shapes.
    shapes: Vec<Option<Shape>>,
    /// Whether it leads around the island of a roundabout or along the streets.
    leads_around: bool,
    chosen: usize,
    /// The centre lines from the neighbouring lanes that part from it, by index.
    neighbours: Vec<usize>,
}

/// One shape of a centre line. Its outline is drawn on demand: few centre lines come near others.
struct Shape {
    poses: Vec<Pose>,
    outline: OnceCell<Outline>,
}

impl Shape {
    fn new(poses: Vec<Pose>) -> Self {
        Self { poses, outline: OnceCell::new() }
    }

    fn outline(&self, ends: &MovementEnds) -> &Outline {
        self.outline.get_or_init(|| Outline::new(ends, &self.poses))
    }
}

/// The ground of a lanelet.
struct Outline {
    ring: Vec<Point>,
    /// Whether it does not cross itself; nearly all do not, and their common area is found faster.
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

/// Area in square metres that the lanelets of two movements cover both, drawn as far apart as they can be. See [`turn_centerlines`] for
/// `around`.
pub fn common_ground(ends: [MovementEnds; 2], around: impl Fn(&MovementEnds, &[Pose]) -> Option<Vec<Pose>>) -> f64 {
    let poses = turn_centerlines(&ends, around);
    match &poses[..] {
        [a, b] => Outline::new(&ends[0], a).shared(&Outline::new(&ends[1], b)),
        _ => 0.0,
    }
}

/// The poses of all movements, in their order. `around` gives the way of a movement around the island of a roundabout or along the
/// streets instead of its direct one, if it has to go around: then its neighbours keep clear of it.
pub fn turn_centerlines(
    ends: &[MovementEnds],
    around: impl Fn(&MovementEnds, &[Pose]) -> Option<Vec<Pose>>,
) -> Vec<Vec<Pose>> {
    let bundles = bundles(ends);
    let direct = smoothest(ends, &bundles);
    let around: Vec<Option<Vec<Pose>>> = ends.iter().zip(&direct).map(|(ends, direct)| around(ends, direct)).collect();
    // Lanes that lead side by side go around together, or none of them does.
    let apart: FxHashSet<usize> =
        bundles.iter().zip(&around).filter(|(_, way)| way.is_none()).map(|(b, _)| *b).collect();
    let with_neighbours = |(i, (direct, around)): (usize, (Vec<Pose>, Option<Vec<Pose>>))| {
        let neighbours = (0..ends.len()).filter(|&j| j != i && part(&ends[i].0, &ends[j].0)).collect();
        let around = around.filter(|_| !apart.contains(&bundles[i]));
        let leads_around = around.is_some();
        let shapes = vec![Some(Shape::new(around.unwrap_or(direct)))];
        TurnCenterline { shapes, leads_around, chosen: 0, neighbours }
    };
    let lines = direct.into_iter().zip(around).enumerate().map(with_neighbours).collect();
    let mut all = TurnCenterlines { ends, lines, shared: RefCell::default() };
    let bundle = |i: usize| (0..ends.len()).filter(|&j| bundles[j] == bundles[i]).collect::<Vec<usize>>();
    for i in 0..ends.len() {
        for j in all.lines[i].neighbours.clone().into_iter().filter(|&j| j > i && bundles[j] != bundles[i]) {
            if all.overlap(i, j) > TOUCH {
                let both = [bundle(i), bundle(j)];
                both.iter().flatten().for_each(|&member| all.add_shapes(member));
                all.choose(&both);
            }
        }
    }
    let chosen = all.lines.into_iter().map(|mut line| line.shapes.swap_remove(line.chosen));
    chosen.map(|shape| shape.map_or_else(Vec::new, |shape| shape.poses)).collect()
}

/// The smoothest poses of every movement. A turn swings out for a larger radius unless it would run into a lanelet from a
/// neighbouring lane, however that one is drawn.
fn smoothest(ends: &[MovementEnds], bundles: &[usize]) -> Vec<Vec<Pose>> {
    let straights = bundle_straights(ends, bundles);
    let shapes = |(i, (_, from, to)): (usize, &MovementEnds)| {
        if let Some(straights) = straights[bundles[i]] {
            return (Shape::new(curve::held(from.pose, to.pose, straights)), None);
        }
        let direct = curve::join(from.pose, to.pose);
        let wide = swing_out_turn::swing_out(from.pose, to.pose, &direct);
        (Shape::new(direct), wide.map(Shape::new))
    };
    let shapes: Vec<(Shape, Option<Shape>)> = ends.iter().enumerate().map(shapes).collect();
    let clear: Vec<bool> = (0..ends.len()).map(|i| can_swing_out(ends, &shapes, i)).collect();
    let chosen = shapes.into_iter().zip(clear);
    chosen.map(|((direct, wide), clear)| wide.filter(|_| clear).unwrap_or(direct).poses).collect()
}

/// The lengths of the straight lines before and after the turns of each bundle, metres: those that all its members can have; or before
/// and after the shift of a bundle: those by which all its members keep clear of the ends of other roads.
fn bundle_straights(ends: &[MovementEnds], bundles: &[usize]) -> Vec<Option<[f64; 2]>> {
    let straights = |i: usize| {
        let (_, from, to) = &ends[i];
        curve::straight_ends(from.pose, to.pose, [from.straight, to.straight])
    };
    let mut of_bundles: Vec<Option<[f64; 2]>> = (0..ends.len()).map(straights).collect();
    let beside: Vec<Option<[f64; 2]>> = (0..ends.len()).map(|i| straights_beside_ends(ends, i)).collect();
    for (i, &first) in bundles.iter().enumerate() {
        let both = of_bundles[first].zip(of_bundles[i]);
        of_bundles[first] = both.map(|([a, b], [c, d])| [a.min(c), b.min(d)]);
    }
    for (i, &first) in bundles.iter().enumerate() {
        if let Some([c, d]) = beside[i] {
            let [a, b] = of_bundles[first].unwrap_or_default();
            of_bundles[first] = Some([a.max(c), b.max(d)]);
        }
    }
    of_bundles
}

/// The lengths over which a lane that shifts sideways goes straight on first, and at last, so that it does not run over the ends of
/// other roads, metres; `None` where it does not, or turns, or would bend too tightly in between.
fn straights_beside_ends(ends: &[MovementEnds], i: usize) -> Option<[f64; 2]> {
    let (own, from, to) = &ends[i];
    if angle_between(from.pose.heading, to.pose.heading).abs() > SHIFT_MOST {
        return None;
    }
    let ring = Outline::new(&ends[i], &curve::join(from.pose, to.pose)).ring;
    let [low, high] = polygon::bounds(&ring)?;
    let arms = [own.from, own.to];
    let others = ends.iter().flat_map(|(other, into, out)| [(other.from, *into), (other.to, *out)]);
    let places = others.filter(|(arm, _)| !arms.contains(arm)).flat_map(|(_, lane)| lane.places);
    let within = |p: &Point| p.x > low.x && p.y > low.y && p.x < high.x && p.y < high.y;
    let mut straights = [0.0_f64; 2];
    for p in places.filter(within).filter(|p| polygon::contains(&ring, *p)) {
        let before = (p - from.pose.point).dot(&from.pose.heading);
        let after = (to.pose.point - p).dot(&to.pose.heading);
        let (side, along) = if before < after { (0, before) } else { (1, after) };
        straights[side] = straights[side].max(along + BEYOND);
    }
    let held = (straights != [0.0; 2]).then(|| curve::held(from.pose, to.pose, straights))?;
    (curve::radius(&held) >= SHIFT_RADIUS).then_some(straights)
}

/// Whether the wide shape of a movement overlaps those from neighbouring lanes no more than its direct shape does.
fn can_swing_out(ends: &[MovementEnds], shapes: &[(Shape, Option<Shape>)], i: usize) -> bool {
    let (direct, Some(wide)) = &shapes[i] else { return false };
    let own = ends[i].0;
    let neighbours =
        (0..ends.len()).filter(|&j| ends[j].0.from == own.from && ends[j].0.in_lane.abs_diff(own.in_lane) == 1);
    let mut others = neighbours.flat_map(|j| {
        let (direct, wide) = &shapes[j];
        [Some(direct), wide.as_ref()].into_iter().flatten().map(move |other| other.outline(&ends[j]))
    });
    others.all(|other| {
        let shared = wide.outline(&ends[i]).shared(other);
        shared <= TOUCH || shared <= direct.outline(&ends[i]).shared(other)
    })
}

/// Whether two movements begin side by side and do not end so.
fn part(a: &Movement, b: &Movement) -> bool {
    let together = a.to == b.to && a.out_lane.abs_diff(b.out_lane) <= 1;
    a.from == b.from && a.in_lane.abs_diff(b.in_lane) == 1 && !together
}

/// For every movement the first of its bundle: of those that go side by side with it from end to end. They bend alike.
fn bundles(ends: &[MovementEnds]) -> Vec<usize> {
    let follows = |a: &Movement, b: &Movement| {
        let lanes = (b.in_lane.checked_sub(a.in_lane), b.out_lane.checked_sub(a.out_lane));
        (a.from, a.to) == (b.from, b.to) && lanes == (Some(1), Some(1))
    };
    // In order of their lanes, each finds the first through its neighbour.
    let mut order: Vec<usize> = (0..ends.len()).collect();
    order.sort_by_key(|&i| ends[i].0);
    let mut first: Vec<usize> = (0..ends.len()).collect();
    for (n, &i) in order.iter().enumerate() {
        if let Some(&before) = order[..n].iter().find(|&&j| follows(&ends[j].0, &ends[i].0)) {
            first[i] = first[before];
        }
    }
    first
}

/// The centre lines of an intersection while their shapes are chosen.
struct TurnCenterlines<'a> {
    ends: &'a [MovementEnds<'a>],
    lines: Vec<TurnCenterline>,
    /// The areas of `overlap` so far, by the two lines and their shapes: bundles are tried with the same neighbours many times.
    shared: RefCell<FxHashMap<[usize; 4], f64>>,
}

impl TurnCenterlines<'_> {
    /// Adds the shapes by handles and with straight parts to a line that has only the smoothest.
    fn add_shapes(&mut self, i: usize) {
        let (_, from, to) = self.ends[i];
        let TurnCenterline { shapes, leads_around, .. } = &mut self.lines[i];
        if *leads_around || shapes.len() > 1 {
            return;
        }
        let least = RADIUS_LEAST.min(shapes[0].as_ref().map_or(RADIUS_LEAST, |own| curve::radius(&own.poses)));
        let bent = HANDLES.iter().flat_map(|&a| HANDLES.iter().map(move |&b| curve::cubic(from.pose, to.pose, [a, b])));
        let parts = STRAIGHT_PARTS.iter().flat_map(|&a| STRAIGHT_PARTS.iter().map(move |&b| [a, b])).skip(1);
        let chord = (to.pose.point - from.pose.point).norm();
        let straight = parts.map(|parts| curve::held(from.pose, to.pose, parts.map(|part| part * chord)));
        let poses = std::iter::once(curve::join(from.pose, to.pose)).chain(bent).chain(straight);
        shapes.extend(poses.map(|poses| (curve::radius(&poses) >= least).then(|| Shape::new(poses))));
    }

    /// Area in square metres that two lines cover by their chosen shapes.
    fn overlap(&self, i: usize, j: usize) -> f64 {
        let outline = |i: usize| Some(self.lines[i].shapes[self.lines[i].chosen].as_ref()?.outline(&self.ends[i]));
        let shared = || outline(i).zip(outline(j)).map_or(0.0, |(a, b)| a.shared(b));
        let key = [i, self.lines[i].chosen, j, self.lines[j].chosen];
        *self.shared.borrow_mut().entry(key).or_insert_with(shared)
    }

    fn take(&mut self, bundle: &[usize], shape: usize) {
        bundle.iter().for_each(|&member| self.lines[member].chosen = shape);
    }

    /// The shapes that all members of a bundle can take.
    fn shapes(&self, bundle: &[usize]) -> Vec<usize> {
        let count = bundle.first().map_or(0, |&member| self.lines[member].shapes.len());
        let all_have =
            |shape: usize| bundle.iter().all(|&i| self.lines[i].shapes.get(shape).is_some_and(Option::is_some));
        (0..count).filter(|&shape| all_have(shape)).collect()
    }

    /// The overlap of two bundles with each other and with their neighbours, square metres; a pair of two members counts once.
    fn total_overlap(&self, members: &[usize]) -> f64 {
        let pairs = members.iter().flat_map(|&m| self.lines[m].neighbours.iter().map(move |&k| (m, k)));
        let once = pairs.filter(|(m, k)| k > m || !members.contains(k));
        once.map(|(m, k)| self.overlap(m, k)).sum()
    }

    /// Chooses the shapes of two bundles with which they and their neighbours overlap least; the first of several equal ones.
    fn choose(&mut self, bundles: &[Vec<usize>; 2]) {
        let [shapes_a, shapes_b] = bundles.each_ref().map(|bundle| self.shapes(bundle));
        let mut order: Vec<[usize; 2]> = shapes_a.iter().flat_map(|&a| shapes_b.iter().map(move |&b| [a, b])).collect();
        order.sort_by_key(|&[a, b]| (a + b, a));
        let members = bundles.concat();
        let mut best = (f64::INFINITY, [0, 0]);
        for [a, b] in order {
            self.take(&bundles[0], a);
            self.take(&bundles[1], b);
            let total = self.total_overlap(&members);
            if total < best.0 - TOUCH {
                best = (total, [a, b]);
            }
            if best.0 <= TOUCH {
                break;
            }
        }
        self.take(&bundles[0], best.1[0]);
        self.take(&bundles[1], best.1[1]);
    }
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
            straight: 0.0,
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
        let poses = turn_centerlines(&ends, |_, _| None);
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
        let poses = turn_centerlines(&ends, |_, _| None);
        let outlines: Vec<Outline> = ends.iter().zip(poses).map(|(end, poses)| Outline::new(end, &poses)).collect();
        let turns = outlines[0].shared(&outlines[1]);
        // What remains between two cubics of unlike length is taken away where their common bound runs midway.
        assert!(turns < 4.0, "the two turns overlap by {turns} m2");
    }

    #[test]
    fn a_lane_that_shifts_goes_straight_on_past_the_end_of_another_road() {
        // Eastward over 60 m and 7 m to the left, where a road ends beside the way, 3 m to the left of it.
        let (from, to, beside) = (lane(0.0, 0.0, 0.0), lane(60.0, 7.0, 0.0), lane(20.0, 3.0, 0.0));
        let movement = |from, to| Movement { from, to, in_lane: 0, out_lane: 0 };
        let ends = [(movement(0, 1), &from, &to), (movement(2, 1), &beside, &to)];
        let over = |poses: &[Pose]| polygon::contains(&Outline::new(&ends[0], poses).ring, beside.places[0]);
        assert!(over(&curve::join(from.pose, to.pose)));
        let [poses, _] = &turn_centerlines(&ends, |_, _| None)[..] else { panic!("two movements") };
        assert!(!over(poses) && curve::radius(poses) > SHIFT_RADIUS, "{} m", curve::radius(poses));
        // Where no room is left for the shift, it begins at once.
        let near = lane(34.0, 7.0, 0.0);
        let ends = [(movement(0, 1), &from, &near), (movement(2, 1), &beside, &near)];
        assert_eq!(straights_beside_ends(&ends, 0), None);
    }

    #[test]
    fn lanes_side_by_side_go_around_together_or_not_at_all() {
        let (into, out) = ([lane(0.0, 1.5, 0.0), lane(0.0, -1.5, 0.0)], [lane(40.0, 1.5, 0.0), lane(40.0, -1.5, 0.0)]);
        let movement = |lane| Movement { from: 0, to: 1, in_lane: lane, out_lane: lane };
        let ends = [(movement(0), &into[0], &out[0]), (movement(1), &into[1], &out[1])];
        let way = |ends: &MovementEnds| curve::cubic(ends.1.pose, ends.2.pose, [0.8, 0.8]);
        let alone = turn_centerlines(&ends, |ends, _| (ends.0.in_lane == 0).then(|| way(ends)));
        assert_eq!(alone, turn_centerlines(&ends, |_, _| None));
        let together = turn_centerlines(&ends, |ends, _| Some(way(ends)));
        assert_eq!(together, ends.each_ref().map(way));
    }
}
