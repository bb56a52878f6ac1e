//! The stop lines, traffic lights and signs of one arm of an intersection, with their regulatory elements.

use crate::builder::ids::Key;
use crate::builder::lanes::types::{Arm, ArmLane};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::approach_control::Control;
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::left_of;
use crate::lanelet::{Attributes, LaneletId, LineStringId, Target, TurnDirection};

use super::light_places::{LightAim, LightGround};
use super::stop_line::{PAINTED_LINE, SIGN_LINE, stop_line};
use super::vehicle_signals::{LightShape, add_light, light_element};

/// Height of the lower edge of a sign above the road, metres.
const SIGN_HEIGHT: f64 = 2.0;
/// Width of a sign, metres.
const SIGN_SIZE: f64 = 0.6;

/// A lane that arrives at an intersection, and the lanelets behind its stop line.
pub struct Approach {
    /// The lanelet before the stop line.
    pub lane: LaneletId,
    /// The lanelets that begin at the stop line.
    pub behind: Vec<LaneletId>,
    /// The direction of all of them, if its light has an arrow.
    pub arrow: Option<TurnDirection>,
}

/// An arm whose control is drawn.
pub struct ControlledArm<'a> {
    /// The arm.
    pub arm: &'a Arm,
    /// What controls it.
    pub control: Control,
    /// One for each lane that leads in.
    pub approaches: &'a [Approach],
    /// The side on which people drive.
    pub driving: DrivingSide,
}

impl ControlledArm<'_> {
    /// Adds the stop lines, lights or signs of the arm and their regulatory elements. Lights stand around the `ground`.
    pub fn draw(&self, assembly: &mut MapBuilder, key: Key, ground: &LightGround) {
        let lights = match self.control {
            Control::Signals => self.traffic_lights(assembly, key, ground),
            _ => vec![None; self.approaches.len()],
        };
        for ((lane, approach), light) in self.arm.into.iter().zip(self.approaches).zip(lights) {
            if approach.behind.is_empty() {
                continue;
            }
            let key = key.number(lane.nodes[0].0).number(lane.nodes[1].0);
            let sign = self.control.sign();
            let line = stop_line(assembly, key, lane.nodes, if sign.is_some() { SIGN_LINE } else { PAINTED_LINE });
            if let Some(light) = light {
                light_element(assembly, key, light, line, &approach.behind);
                continue;
            }
            if self.control != Control::Stop {
                // Vehicles stop here only for others.
                let members = [("refers", Target::LineString(line))];
                assembly.element(key.word("marking"), "road_marking", &members, &approach.behind);
            }
            if let Some(subtype) = sign {
                let sign = self.sign(assembly, key, lane, subtype);
                let members = [("refers", Target::LineString(sign)), ("ref_line", Target::LineString(line))];
                assembly.element(key.word("sign"), "traffic_sign", &members, &[approach.lane]);
            }
        }
    }

    /// Adds lights that face the arm, and their bulbs; gives them by lane. Neighbours with
    /// the same arrow, or without one, share them; lanes that lead nowhere have none.
    fn traffic_lights(
        &self,
        assembly: &mut MapBuilder,
        key: Key,
        ground: &LightGround,
    ) -> Vec<Option<[LineStringId; 2]>> {
        let mut lights = Vec::new();
        let mut lanes = &self.arm.into[..];
        for alike in self.approaches.chunk_by(|one, next| one.arrow == next.arrow) {
            let (own, others) = lanes.split_at(alike.len().min(lanes.len()));
            lanes = others;
            let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
            let leads_on = alike.iter().any(|approach| !approach.behind.is_empty());
            let light = leads_on.then(|| {
                let inward = self.arm.inward;
                let middle = ground.place(&LightAim::of([first, last], inward, self.kerb_side()));
                let shape = LightShape::with_arrow(self.driving, middle, inward, alike[0].arrow);
                add_light(assembly, key.word("light").number(self.arm.at.end as i64).number(first.nodes[0].0), &shape)
            });
            lights.extend(own.iter().map(|_| light));
        }
        lights
    }

    /// On which side of its lanes the kerb is: 1 on the right, -1 on the left.
    fn kerb_side(&self) -> f64 {
        if self.driving == DrivingSide::Left { -1.0 } else { 1.0 }
    }

    /// Adds a sign at the kerb side of a lane.
    fn sign(&self, assembly: &mut MapBuilder, key: Key, lane: &ArmLane, subtype: &str) -> LineStringId {
        let right = -left_of(lane.pose.heading);
        let middle = lane.pose.point + right * (self.kerb_side() * (lane.width / 2.0 + SIGN_SIZE));
        let ends = [("left", -0.5), ("right", 0.5)].map(|(name, along)| {
            assembly.point(key.word("sign").word(name), middle + right * (SIGN_SIZE * along), SIGN_HEIGHT)
        });
        let attributes = Attributes::of(&[("type", "traffic_sign"), ("subtype", subtype)]);
        assembly.line(key.word("sign line"), ends.to_vec(), attributes)
    }
}
