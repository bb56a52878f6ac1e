//! How far roads are cut back so that turns have room, and lanes that weave or change their width.

use crate::builder::network::road_end::{inward, lane_pose, lanes_at};
use crate::builder::network::{End, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::pose::Pose;
use crate::geometry::{angle_between, pose, s_curve};

/// Radius of the near turn's centre line that a car takes with ease, metres.
const TURN_RADIUS: f64 = 6.0;
/// A road is never cut back further than this, metres, for the sake of a turn ...
const TURN_SETBACK_MOST: f64 = 8.0;
/// ... nor than this for a sharp one that it can spare room for.
const SHARP_SETBACK_MOST: f64 = 12.0;
/// From this change of direction on, degrees, a turn is sharp ...
const SHARP: f64 = 120.0;
/// ... and from this on a setback makes hardly any room for it.
const BACK: f64 = 165.0;
/// Below this change of direction, degrees, lanes whose lines have crossed already need no turn but lead over.
const TURN_LEAST: f64 = 45.0;
/// Where two roads of unlike width meet, each gives this much, metres, to the taper between them at least, ...
const TAPER: f64 = 5.0;
/// ... and a taper is so many times as long as it leads sideways: then its bends stay below eight degrees.
const TAPER_RATIO: f64 = 12.0;
/// Each road gives this much, metres, to a taper at most.
const TAPER_MOST: f64 = 24.0;
/// At a crossing each road gives this much, metres, at most so that lanes straight on need not swerve.
const SWERVE_MOST: f64 = 4.0;
/// A road that can spare it gives this much, metres, at most so that lanes hardly weave, ...
const WEAVE_SETBACK_MOST: f64 = 8.0;
/// ... and keeps this much, metres: two cars.
pub const EASE_LEFT: f64 = 10.0;
/// No cut moves for comfort around a bend of the road sharper than this, degrees.
pub const EASE_BEND: f64 = 10.0;
/// Bends to and fro, degrees, that need no more room.
const WEAVE_MOST: f64 = 13.0;
/// Beyond this change of direction, degrees, a lane turns and needs no room to shift sideways.
const WEAVE_TURN: f64 = 60.0;
/// Up to this change of direction, degrees, a lane goes on straight but for a shift sideways.
const PARALLEL: f64 = 15.0;

/// Room for the turns between the arms, and for tapers between two roads: how far to cut them back at least.
pub fn turn_setbacks(network: &RoadNetwork, arms: &[RoadEnd], least: &[Stations]) -> Vec<(RoadEnd, f64)> {
    let mut setbacks = Vec::new();
    let mut raise = |at: RoadEnd, by: f64| {
        if by > 0.0 {
            setbacks.push((at, by));
        }
    };
    let poses = |at, into| {
        let mut poses = lane_poses(network, least, at, into);
        if !into {
            poses.reverse();
        }
        [poses.first().copied(), poses.last().copied()]
    };
    for &a in arms {
        for &b in arms.iter().filter(|&&b| b != a) {
            let (from, to) = (poses(a, true), poses(b, false));
            // What every turn needs is as much as the widest does, which joins the outermost lanes on opposite sides; the
            // tightest takes what the roads can spare.
            for (from, to) in from.into_iter().zip(to).filter_map(|(from, to)| from.zip(to)) {
                let back = swerve(from, to).min(if arms.len() == 2 { TAPER_MOST } else { SWERVE_MOST });
                raise(a, back);
                raise(b, back);
                let Some([before, after]) = room_for_turn([from, to], TURN_SETBACK_MOST) else { continue };
                raise(a, before);
                raise(b, after);
            }
            if arms.len() == 2 {
                raise(a, TAPER);
            }
        }
    }
    setbacks
}

/// How far, metres, to cut back the roads before and behind a turn so that a car takes it with ease; by no more than `most`
/// for a sharp one.
fn room_for_turn([from, to]: [Pose; 2], most: f64) -> Option<[f64; 2]> {
    let (before, after, turn) = pose::crossing(from, to)?;
    let degrees = turn.abs().to_degrees();
    let ahead = before > 0.0 && after > 0.0;
    if degrees > BACK || !(ahead || degrees > TURN_LEAST) {
        return None;
    }
    let most = if degrees > SHARP { most } else { TURN_SETBACK_MOST };
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

/// More room for turns, and for lanes that shift sideways, where the roads can spare it.
pub fn comfort(network: &RoadNetwork, arms: &[RoadEnd], least: &[Stations]) -> Vec<(RoadEnd, f64)> {
    let mut wishes = Vec::new();
    if arms.len() == 2 {
        return wishes;
    }
    let mut raise = |at: RoadEnd, by: f64| {
        if by > 0.0 {
            wishes.push((at, by));
        }
    };
    for &a in arms {
        for &b in arms.iter().filter(|&&b| b != a) {
            let (from, to) = (lane_poses(network, least, a, true), lane_poses(network, least, b, false));
            let back = weave(&from, &to);
            raise(a, back);
            raise(b, back);
            // The tightest way between two arms joins their outermost lanes on the same side.
            let outer = [from.first().zip(to.first()), from.last().zip(to.last())];
            for [before, after] in
                outer.into_iter().flatten().filter_map(|(a, b)| room_for_turn([*a, *b], SHARP_SETBACK_MOST))
            {
                raise(a, before);
                raise(b, after);
            }
        }
    }
    wishes
}

/// How far either of two roads should give way so that lanes from one to the other, all from left to right, hardly weave.
fn weave(from: &[Pose], to: &[Pose]) -> f64 {
    let few = from.len().min(to.len());
    if few == 0 || angle_between(from[0].heading, to[0].heading).abs() > WEAVE_TURN.to_radians() {
        return 0.0;
    }
    let bends = |back: f64, shift: [usize; 2]| {
        let pairs = from[shift[0]..].iter().zip(&to[shift[1]..]);
        let moved = |pose: &Pose, by: f64| Pose { point: pose.point + pose.heading * by, ..*pose };
        pairs.map(|(a, b)| s_curve::to_and_fro(moved(a, -back), moved(b, back))).fold(0.0, f64::max)
    };
    let shifts = (0..=from.len() - few).flat_map(|i| (0..=to.len() - few).map(move |j| [i, j]));
    let least = shifts.min_by(|&s, &t| bends(0.0, s).total_cmp(&bends(0.0, t))).unwrap_or_default();
    let steps = (0..WEAVE_SETBACK_MOST as usize).map(|metres| metres as f64);
    steps.into_iter().find(|&back| bends(back, least) <= WEAVE_MOST.to_radians()).unwrap_or(WEAVE_SETBACK_MOST)
}

/// Moves both cuts further up the road for comfort, as far as enough of it remains and it does not bend.
pub fn eased(road: &Road, [start, end]: [f64; 2], [a, b]: [f64; 2]) -> [f64; 2] {
    let room = (end - start - EASE_LEFT).max(0.0);
    let share = if a + b > room { room / (a + b) } else { 1.0 };
    let straight = |at: End, cut: f64, by: f64| {
        let bend = angle_between(inward(road, at, cut), inward(road, at, cut + by)).abs();
        bend <= EASE_BEND.to_radians()
    };
    let eased = |at: End, cut: f64, by: f64| {
        cut + [1.0, 0.5, 0.25].map(|part| part * by).into_iter().find(|&by| straight(at, cut, by)).unwrap_or(0.0)
    };
    [eased(End::Start, start, a * share), eased(End::End, end, -b * share)]
}

/// How far both roads should give way for a lane that shifts sideways between two ends.
fn swerve(from: Pose, to: Pose) -> f64 {
    let way = to.point - from.point;
    let sideways = crate::geometry::cross(from.heading, way).abs();
    let parallel = angle_between(from.heading, to.heading).abs() < PARALLEL.to_radians();
    let wanted = if parallel { TAPER_RATIO * sideways } else { 0.0 };
    ((wanted - way.dot(&from.heading)) / 2.0).max(0.0)
}
