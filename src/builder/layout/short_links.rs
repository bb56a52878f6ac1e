//! Roads that are too short for the turns at their ends: no vehicle can wait on them or take the turn.

use crate::builder::intersection::movement_types::Movement;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::intersection::undrivable::begins_or_ends_in_corner;
use crate::builder::lanes::road_cut::Squeeze;
use crate::builder::network::{Intersection, RoadEnd, RoadIx};
use crate::geometry::curve;
use crate::geometry::pose::{self, Pose};

use super::map_layout::Layout;

/// The smallest radius of a lane's middle, metres, on which a car can turn: at full lock most cars need 4 to 5 m.
pub const CAR_RADIUS: f64 = 4.0;
/// The radius, metres, for which cuts are set back where the roads have room: lanelets bend a little more than the lines from which
/// they are drawn.
const SETBACK_RADIUS: f64 = 4.3;
/// From this change of direction, degrees, ...
const TURN_LEAST: f64 = 15.0;
/// ... up to this a turn needs room for its tangents even if the lines of its lanes do not meet ahead of both.
const TURN_MOST: f64 = 150.0;
/// A turn moves a cut by at least this, metres.
pub const SETBACK_LEAST: f64 = 0.2;
/// A turn moves a cut by at most this, metres: roads that meet at an acute angle are cut far back.
const SETBACK_MOST: f64 = 20.0;
/// A turn with this part of the largest radius is as good.
const WIDE: f64 = 0.9;

/// The tangents of a turn, metres, and its change of direction, radians.
type TangentsOf = fn(Pose, Pose) -> Option<(f64, f64, f64)>;

/// The roads that are too short to be cut back for a lanelet that bends too tightly for a car; in order. The pieces of a roundabout's
/// ring are not among them.
pub fn short_links(layout: &Layout) -> Vec<RoadIx> {
    let spent = |road: &RoadIx| layout.is_spent(*road) && !layout.network.road(*road).roundabout;
    let mut roads: Vec<RoadIx> = Vec::new();
    for (at, turning) in layout.network.intersections.iter().zip(&layout.turning) {
        if let Some(turning) = turning.as_ref().filter(|_| at.arms.iter().any(|arm| spent(&arm.road))) {
            let lacking = lacking(layout, at, &turning.drawn.paths, (CAR_RADIUS, pose::tangents));
            roads.extend(lacking.map(|(arm, _)| arm.road).filter(spent));
        }
    }
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// The roads from or to which a lanelet leads that is drawn with a corner, or bends too tightly for a car.
pub fn roads_of_tight_turns(layout: &Layout) -> impl Iterator<Item = RoadIx> {
    let drawn = layout.network.intersections.iter().zip(&layout.turning);
    drawn.filter_map(|(at, turning)| Some((at, turning.as_ref()?))).flat_map(|(at, turning)| {
        let is_tight = |path: &&TurningLanelet| path.radius < CAR_RADIUS || begins_or_ends_in_corner(path);
        let tight = turning.drawn.paths.iter().filter(is_tight);
        tight.flat_map(|path| [path.movement.from, path.movement.to].map(|arm| at.arms[arm].road))
    })
}

/// The setbacks, metres, of road ends where a turn bends too tightly for a car and the road has room. Each drawn intersection is asked
/// only once.
pub fn room_for_turns(layout: &mut Layout) -> Vec<(RoadEnd, f64)> {
    let wanted = unasked(layout);
    layout.turning.iter_mut().flatten().for_each(|turning| turning.turns_asked = true);
    wanted
}

fn unasked(layout: &Layout) -> Vec<(RoadEnd, f64)> {
    let setback = |(at, lack): (RoadEnd, f64)| {
        let room = room(layout, at)?;
        Some((at, (layout.setback(at) + lack.min(room)).min(SETBACK_MOST)))
    };
    let all = layout.network.intersections.iter().zip(&layout.turning).flat_map(|(at, turning)| {
        let drawn = turning.as_ref().filter(|turning| !turning.turns_asked);
        drawn.into_iter().flat_map(|turning| {
            let paths = &turning.drawn.paths;
            lacking(layout, at, paths, (SETBACK_RADIUS, turn_tangents)).chain(lacking_at_corners(layout, at, paths))
        })
    });
    all.filter_map(setback).collect()
}

/// How far a road can be cut back, metres; `None` if it cannot. The pieces of a ring are not cut back.
fn room(layout: &Layout, at: RoadEnd) -> Option<f64> {
    let room = layout.left(at.road) - layout.least_left(at.road);
    (room > SETBACK_LEAST && !layout.network.road(at.road).roundabout).then_some(room)
}

/// The ends of roads at which a lanelet begins or ends in a corner, and how much farther back, metres, they would have to be cut for a
/// turn that a car can take, or for the widest one there is.
fn lacking_at_corners<'a>(
    layout: &'a Layout,
    at: &'a Intersection,
    paths: &'a [TurningLanelet],
) -> impl Iterator<Item = (RoadEnd, f64)> + 'a {
    let lack = move |path: &TurningLanelet| {
        let Movement { from, to, in_lane, out_lane } = path.movement;
        let arms: [RoadEnd; 2] = [at.arms[from], at.arms[to]];
        let roomy = arms.map(|arm| room(layout, arm).is_some());
        let into = layout.lanes.arm(arms[0]).into.get(in_lane)?.pose;
        let out = layout.lanes.arm(arms[1]).out.get(out_lane)?.pose;
        let moved = |pose: Pose, by: f64| Pose { point: pose.point + pose.heading * by, ..pose };
        let radius = |metres: usize| {
            let [before, behind] = roomy.map(|roomy| if roomy { metres as f64 } else { 0.0 });
            curve::radius(&curve::join(moved(into, -before), moved(out, behind))).min(CAR_RADIUS)
        };
        let radii: Vec<f64> = (0..=SETBACK_MOST as usize).map(radius).collect();
        let widest = radii.iter().fold(0.0, |most: f64, radius| most.max(*radius));
        let by = radii.iter().position(|radius| *radius >= WIDE * widest)?;
        Some(arms.map(|arm| (arm, by as f64)))
    };
    paths.iter().filter(|path| begins_or_ends_in_corner(path)).filter_map(lack).flatten()
}

/// The tangents of a turn, metres, and its change of direction, radians. A tangent is negative if the turn begins or ends beyond the
/// place where the lines of its lanes cross.
fn turn_tangents(from: Pose, to: Pose) -> Option<(f64, f64, f64)> {
    let turns = |turn: f64| (TURN_LEAST..=TURN_MOST).contains(&turn.abs().to_degrees());
    let crossing = pose::crossing(from, to);
    let near = crossing.filter(|(before, behind, turn)| turns(*turn) && before.min(*behind) > -CAR_RADIUS);
    near.or_else(|| pose::tangents(from, to))
}

/// The ends of roads at an intersection that are not cut back far enough for one of their turns, and how much is missing, metres. Of the
/// room of a waiting vehicle a turn takes none if it is drawn as wide as a car needs it.
fn lacking<'a>(
    layout: &'a Layout,
    at: &'a Intersection,
    paths: &'a [TurningLanelet],
    (radius, tangents): (f64, TangentsOf),
) -> impl Iterator<Item = (RoadEnd, f64)> + 'a {
    let lack = move |path: &TurningLanelet| {
        let Movement { from, to, in_lane, out_lane } = path.movement;
        let arms: [RoadEnd; 2] = [at.arms[from], at.arms[to]];
        let ends = (layout.lanes.arm(arms[0]).into.get(in_lane)).zip(layout.lanes.arm(arms[1]).out.get(out_lane));
        let lacks = ends.and_then(|(into, out)| tangents(into.pose, out.pose)).map(|(before, behind, turn)| {
            let needed = |arm: RoadEnd| {
                let least = layout.squeeze_of(arm.road) == Some(Squeeze::Least);
                let radius = if least { radius.min(CAR_RADIUS) } else { radius };
                radius * (turn.abs() / 2.0).tan()
            };
            [(arms[0], needed(arms[0]) - before), (arms[1], needed(arms[1]) - behind)]
        });
        let is_tight = path.radius < CAR_RADIUS;
        let gives_needed = |road: RoadIx| matches!(layout.squeeze_of(road), Some(Squeeze::Least | Squeeze::Needed));
        let asks = move |(arm, lack): &(RoadEnd, f64)| *lack > 0.0 && (is_tight || !gives_needed(arm.road));
        lacks.into_iter().flatten().filter(asks)
    };
    paths.iter().flat_map(lack)
}
