//! Where the lights of an approach stand: where a mast would, at the far side of the intersection or at the near kerb.

use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::tags::cross_section::StripKind;
use crate::geometry::{Point, Vector, angle_between, left_of, polygon, polyline, segment_crossing};

/// Distance of lights behind the far edge of the intersection, metres.
pub const BEHIND: f64 = 1.0;
/// The largest distance of lights from the stop line, metres: drivers must see them. The Manual on Uniform Traffic Control Devices
/// (section 4D.14) lets a head be 180 ft away, 55 m, without another one nearer.
const SEEN_FROM: f64 = 50.0;
/// A mast stands at most this far, metres, from the edge of a lane: of arms that carry lights over the road few are longer, and poles
/// stand 0.5 to 3 m behind the kerb.
const FROM_LANE: f64 = 3.0;
/// A light is moved sideways by at most this, metres, to where a mast can stand, ...
const ASIDE: usize = 10;
/// ... and stands behind another road only if that leads on within this angle, degrees: it is seen from the stop line.
const AHEAD: f64 = 30.0;
/// From the edge of the kerb lane to a mast at the near side, metres.
const MAST_FROM_KERB_LANE: f64 = 1.0;
/// Of the lanes of an arm this length, metres, counts.
const LANE: f64 = 15.0;

/// The ground around which lights stand.
pub struct LightGround<'a> {
    /// The outlines of all that vehicles have to clear: the area, or the lanelets where there is none.
    pub rings: Vec<Vec<Point>>,
    /// The outlines of the lanelets for cars.
    pub lanelets: Vec<Vec<Point>>,
    /// All arms.
    pub arms: &'a [&'a Arm],
}

/// The lanes that share a light.
pub struct LightAim {
    /// The middle of their ends.
    pub start: Point,
    /// In which direction they arrive.
    pub heading: Vector,
    /// The unit direction from the lanes to their kerb.
    pub kerbward: Vector,
    /// Half of their common width, metres.
    pub half: f64,
}

impl LightGround<'_> {
    /// The middle of the light for some lanes: straight ahead behind the far edge, or beside that, or behind the road that leads on;
    /// else beside their stop line.
    pub fn place(&self, aim: &LightAim) -> Point {
        let aside = (1..=ASIDE).flat_map(|metres| [metres as f64, -(metres as f64)]);
        let ahead = std::iter::once(0.0).chain(aside).filter_map(|aside| self.behind_far_edge(aim, aside));
        let near = || aim.start + aim.kerbward * (aim.half + MAST_FROM_KERB_LANE);
        ahead.chain(self.behind_roads(aim)).find(|place| self.carries_mast(*place)).unwrap_or_else(near)
    }

    /// Behind the last edge of the ground that is met straight ahead of a place beside the middle of the lanes.
    fn behind_far_edge(&self, aim: &LightAim, aside: f64) -> Option<Point> {
        let from = aim.start + aim.kerbward * aside;
        let to = from + aim.heading * (2.0 * SEEN_FROM);
        let edges = self.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
        let met = edges.filter_map(|(a, b)| Some(segment_crossing(from, to, *a, *b)?.0 * 2.0 * SEEN_FROM));
        let far = met.fold(0.0, f64::max) + BEHIND;
        (far <= SEEN_FROM).then(|| from + aim.heading * far)
    }

    /// Behind the ends of the roads that lead on about straight ahead, the straightest first.
    fn behind_roads(&self, aim: &LightAim) -> Vec<Point> {
        let place = |arm: &&Arm| {
            let (first, last) = (arm.out.first()?, arm.out.last()?);
            let place = nalgebra::center(&first.pose.point, &last.pose.point) - arm.inward * BEHIND;
            let angle = angle_between(aim.heading, place - aim.start).abs().to_degrees();
            let turn = angle_between(aim.heading, -arm.inward).abs().to_degrees();
            (angle.max(turn) <= AHEAD && (place - aim.start).norm() <= SEEN_FROM).then_some((angle, place))
        };
        let mut places: Vec<(f64, Point)> = self.arms.iter().filter_map(place).collect();
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        places.into_iter().map(|(_, place)| place).collect()
    }

    /// Whether a mast can stand so that a light hangs at this place: outside of the area, and beside or over a lane.
    fn carries_mast(&self, place: Point) -> bool {
        let inside = |ring: &Vec<Point>| polygon::contains(ring, place);
        let beside = |ring: &Vec<Point>| {
            inside(ring) || {
                let edges = ring.iter().zip(ring.iter().cycle().skip(1));
                edges.filter_map(|(a, b)| polyline::within((*a, *b), place, FROM_LANE)).any(|it| it <= FROM_LANE)
            }
        };
        let over = |lane: &ArmLane, back: f64| {
            let end = lane.pose.point + lane.pose.heading * back;
            let reach = FROM_LANE + lane.width / 2.0;
            polyline::within((lane.pose.point, end), place, reach).is_some_and(|it| it <= reach)
        };
        let on_arm = |arm: &&Arm| {
            let driven = |lane: &&ArmLane| lane.kind == StripKind::Drive;
            arm.into.iter().filter(driven).any(|lane| over(lane, -LANE))
                || arm.out.iter().filter(driven).any(|lane| over(lane, LANE))
        };
        !self.rings.iter().any(inside) && (self.lanelets.iter().any(beside) || self.arms.iter().any(on_arm))
    }
}

impl LightAim {
    /// The aim of neighbouring lanes, from left to right, of an arm; `kerb_side` is 1 where the kerb is on their right, else -1.
    pub fn of(lanes: [&ArmLane; 2], heading: Vector, kerb_side: f64) -> Self {
        let [first, last] = lanes.map(|lane| lane.pose.point);
        let half = ((first - last).norm() + (lanes[0].width + lanes[1].width) / 2.0) / 2.0;
        let start = nalgebra::center(&first, &last);
        Self { start, heading, kerbward: -left_of(heading) * kerb_side, half }
    }
}

#[cfg(test)]
mod tests;
