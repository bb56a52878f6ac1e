//! The setbacks of roads for turns, for tapers and for lanes that shift sideways.

use crate::builder::network::road_end::{inward, lane_pose, lanes_at};
use crate::builder::network::{End, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::pose::Pose;
use crate::geometry::{angle_between, cross, pose, s_curve};

/// Radius of the near turn's centre line that a car takes with ease, metres.
const TURN_RADIUS: f64 = 6.0;
/// A turn sets a road back by at most this, metres ...
const TURN_SETBACK_MOST: f64 = 8.0;
/// ... and a sharp turn by this where the road is long enough.
const SHARP_SETBACK_MOST: f64 = 12.0;
/// From this change of direction on, degrees, a turn is sharp ...
const SHARP: f64 = 120.0;
/// ... and beyond this a setback hardly helps it.
const BACK: f64 = 165.0;
/// Below this change of direction, degrees, lanes whose lines have crossed before the intersection need no turn.
const TURN_LEAST: f64 = 45.0;
/// Where two roads of different widths meet, the taper between them takes at least this much, metres, of each, ...
const TAPER: f64 = 5.0;
/// ... and is this many times as long as its shift sideways: its bends stay below eight degrees.
const TAPER_RATIO: f64 = 12.0;
/// A taper takes at most this much, metres, of each road.
const TAPER_MOST: f64 = 24.0;
/// For a shift of lanes straight on, a road at an intersection is set back by at most this, metres.
const SHIFT_SETBACK_MOST: f64 = 4.0;
/// The same for comfort, where the road is long enough, metres.
const WEAVE_SETBACK_MOST: f64 = 8.0;
/// Setbacks for comfort leave this much, metres, of a road: two cars.
pub const COMFORT_LEFT: f64 = 10.0;
/// No cut moves for comfort around a bend of the road sharper than this, degrees.
pub const COMFORT_BEND: f64 = 10.0;
/// Bends to and fro, degrees, that need no more room.
const WEAVE_MOST: f64 = 13.0;
/// Beyond this change of direction, degrees, a lane turns and needs no room to shift sideways.
const WEAVE_TURN: f64 = 60.0;
/// Up to this change of direction, degrees, a lane goes straight on or only shifts sideways.
const PARALLEL: f64 = 15.0;

/// Setbacks of the ends of roads, metres.
pub type EndSetbacks = Vec<(RoadEnd, f64)>;

/// Adds the setbacks, metres, of two road ends, where they have some.
fn raise(setbacks: &mut EndSetbacks, ends: [RoadEnd; 2], by: [f64; 2]) {
    setbacks.extend(ends.into_iter().zip(by).filter(|(_, by)| *by > 0.0));
}

/// All pairs of different arms: from, to.
fn pairs(arms: &[RoadEnd]) -> impl Iterator<Item = (RoadEnd, RoadEnd)> {
    arms.iter().flat_map(|&from| arms.iter().filter(move |&&to| to != from).map(move |&to| (from, to)))
}

/// The least setbacks for the turns between the arms, and for the taper between two roads.
pub fn turn_setbacks(network: &RoadNetwork, arms: &[RoadEnd], least: &[Stations]) -> EndSetbacks {
    let mut setbacks = Vec::new();
    for (a, b) in pairs(arms) {
        let (from, to) = (lane_poses(network, least, a, true), lane_poses(network, least, b, false));
        // The widest turns, which join the outermost lanes on opposite sides: every turn needs as much room. The tightest
        // ones get what the roads can spare.
        for (from, to) in [from.first().zip(to.last()), from.last().zip(to.first())].into_iter().flatten() {
            raise(&mut setbacks, [a, b], room_for_turn([*from, *to], TURN_SETBACK_MOST).unwrap_or_default());
        }
        if arms.len() == 2 {
            setbacks.push((a, TAPER));
        }
    }
    setbacks
}

/// The setbacks for lanes that shift sideways between two arms.
pub fn shift_setbacks(network: &RoadNetwork, arms: &[RoadEnd], least: &[Stations]) -> EndSetbacks {
    let mut setbacks = Vec::new();
    let most = if arms.len() == 2 { TAPER_MOST } else { SHIFT_SETBACK_MOST };
    for (a, b) in pairs(arms) {
        let (from, to) = (lane_poses(network, least, a, true), lane_poses(network, least, b, false));
        for (from, to) in [from.first().zip(to.last()), from.last().zip(to.first())].into_iter().flatten() {
            raise(&mut setbacks, [a, b], [shift_setback(*from, *to).min(most); 2]);
        }
    }
    setbacks
}

/// The setbacks, metres, of the roads before and behind a turn so that a car takes it with ease; at most `sharp_most` for a
/// sharp one.
fn room_for_turn([from, to]: [Pose; 2], sharp_most: f64) -> Option<[f64; 2]> {
    let (before, after, turn) = pose::crossing(from, to)?;
    let degrees = turn.abs().to_degrees();
    let ahead = before > 0.0 && after > 0.0;
    if degrees > BACK || !(ahead || degrees > TURN_LEAST) {
        return None;
    }
    let most = if degrees > SHARP { sharp_most } else { TURN_SETBACK_MOST };
    let tangent = TURN_RADIUS * (turn.abs() / 2.0).tan();
    Some([before, after].map(|length| (tangent - length).clamp(0.0, most)))
}

/// The lanes that lead into an intersection or out of it, from left to right in their direction of travel.
fn lane_poses(network: &RoadNetwork, least: &[Stations], at: RoadEnd, into: bool) -> Vec<Pose> {
    let road = network.road(at.road);
    let station = least[at.road][at.end];
    let lanes = lanes_at(&road.section, at.end).into_iter().filter(|lane| lane.into == into);
    let mut poses: Vec<Pose> = lanes.map(|lane| lane_pose(road, at.end, station, lane)).collect();
    if !into {
        poses.reverse();
    }
    poses
}

/// Setbacks for the comfort of turns, and of lanes that shift sideways, where the roads are long enough.
pub fn comfort_setbacks(network: &RoadNetwork, arms: &[RoadEnd], least: &[Stations]) -> EndSetbacks {
    let mut setbacks = Vec::new();
    for (a, b) in pairs(arms).filter(|_| arms.len() != 2) {
        let (from, to) = (lane_poses(network, least, a, true), lane_poses(network, least, b, false));
        raise(&mut setbacks, [a, b], [weave_setback(&from, &to); 2]);
        // The tightest turns between two arms join their outermost lanes on the same side.
        for (from, to) in [from.first().zip(to.first()), from.last().zip(to.last())].into_iter().flatten() {
            raise(&mut setbacks, [a, b], room_for_turn([*from, *to], SHARP_SETBACK_MOST).unwrap_or_default());
        }
    }
    setbacks
}

/// The setback, metres, of two roads so that lanes from one to the other, all from left to right, hardly weave.
fn weave_setback(from: &[Pose], to: &[Pose]) -> f64 {
    let count = from.len().min(to.len());
    if count == 0 || angle_between(from[0].heading, to[0].heading).abs() > WEAVE_TURN.to_radians() {
        return 0.0;
    }
    let bends = |setback: f64, shift: [usize; 2]| {
        let pairs = from[shift[0]..].iter().zip(&to[shift[1]..]);
        let moved = |pose: &Pose, by: f64| Pose { point: pose.point + pose.heading * by, ..*pose };
        pairs.map(|(a, b)| s_curve::to_and_fro(moved(a, -setback), moved(b, setback))).fold(0.0, f64::max)
    };
    let shifts = (0..=from.len() - count).flat_map(|i| (0..=to.len() - count).map(move |j| [i, j]));
    let best = shifts.min_by(|&s, &t| bends(0.0, s).total_cmp(&bends(0.0, t))).unwrap_or_default();
    let mut steps = (0..WEAVE_SETBACK_MOST as usize).map(|metres| metres as f64);
    steps.find(|&setback| bends(setback, best) <= WEAVE_MOST.to_radians()).unwrap_or(WEAVE_SETBACK_MOST)
}

/// Moves both cuts up the road for comfort, by these metres, as far as enough of it remains and it does not bend.
pub fn add_comfort(road: &Road, [start, end]: Stations, [a, b]: [f64; 2]) -> Stations {
    let room = (end - start - COMFORT_LEFT).max(0.0);
    let share = if a + b > room { room / (a + b) } else { 1.0 };
    let straight = |at: End, cut: f64, by: f64| {
        let bend = angle_between(inward(road, at, cut), inward(road, at, cut + by)).abs();
        bend <= COMFORT_BEND.to_radians()
    };
    let moved = |at: End, cut: f64, by: f64| {
        cut + [1.0, 0.5, 0.25].map(|part| part * by).into_iter().find(|&by| straight(at, cut, by)).unwrap_or(0.0)
    };
    [moved(End::Start, start, a * share), moved(End::End, end, -b * share)]
}

/// The setback, metres, of two roads for a lane that shifts sideways between them.
fn shift_setback(from: Pose, to: Pose) -> f64 {
    let way = to.point - from.point;
    let parallel = angle_between(from.heading, to.heading).abs() < PARALLEL.to_radians();
    let length = if parallel { TAPER_RATIO * cross(from.heading, way).abs() } else { 0.0 };
    ((length - way.dot(&from.heading)) / 2.0).max(0.0)
}
