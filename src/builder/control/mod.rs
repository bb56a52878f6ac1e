//! Room 11: stop lines, traffic lights and signs, and the regulatory elements that tie them to lanes.

pub mod crosswalk;
pub mod mid_block_signals;
pub mod pedestrian_signals;
pub(crate) mod priority_road;
pub mod signal_arrows;
pub mod stop_line_segments;
pub mod walkway;

use crate::geometry::{Point, Vector, left_of};
use crate::lanelet::{Attributes, LaneletId, LineStringId, PointId, Target, TurnDirection};

use super::ids::Key;
use super::lanes::types::{Arm, ArmLane};
use super::map::map_builder::MapBuilder;
use super::network::approach_control::Control;
use super::tags::road_class::DrivingSide;

/// Height of the lower edge of a traffic light above the road, metres: trucks pass below.
pub const LIGHT_HEIGHT: f64 = 5.0;
/// Height of the lower edge of a sign above the road, metres.
const SIGN_HEIGHT: f64 = 2.0;
/// Width of a sign, metres.
const SIGN_SIZE: f64 = 0.6;
/// Long and short side of the body of a light, metres.
const BODY: [f64; 2] = [1.25, 0.45];
/// Distance of lights behind the far edge of the intersection, metres.
pub const BEHIND: f64 = 1.0;
/// The largest distance of lights from the stop line, metres: drivers must see them.
const LIGHT_REACH: f64 = 50.0;

/// The subtype of a stop line that no sign refers to: its paint.
pub const PAINTED_LINE: &str = "solid";
/// The subtype of the stop line of a sign: TIER IV's validator reads there, and Autoware in its type, what it is.
const SIGN_LINE: &str = "stop_line";

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
    /// Adds the stop lines, lights or signs of the arm and their regulatory elements. `ring` is the outline of the intersection.
    pub fn draw(&self, assembly: &mut MapBuilder, key: Key, ring: &[Point]) {
        let lights = match self.control {
            Control::Signals => self.traffic_lights(assembly, key, ring),
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

    /// Adds lights on the far side of the intersection that face the arm, and their bulbs; gives them by lane. Neighbours with
    /// the same arrow, or without one, share them; lanes that lead nowhere have none.
    fn traffic_lights(&self, assembly: &mut MapBuilder, key: Key, ring: &[Point]) -> Vec<Option<[LineStringId; 2]>> {
        let mut lights = Vec::new();
        let mut lanes = &self.arm.into[..];
        for alike in self.approaches.chunk_by(|one, next| one.arrow == next.arrow) {
            let (own, others) = lanes.split_at(alike.len().min(lanes.len()));
            lanes = others;
            let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
            let leads_on = alike.iter().any(|approach| !approach.behind.is_empty());
            let light = leads_on.then(|| {
                let start = nalgebra::center(&first.pose.point, &last.pose.point);
                let inward = self.arm.inward;
                let far = ring.iter().map(|p| (p - start).dot(&inward)).fold(0.0, f64::max);
                let middle = start + inward * (far + BEHIND).min(LIGHT_REACH);
                let shape = LightShape::with_arrow(self.driving, middle, inward, alike[0].arrow);
                add_light(assembly, key.word("light").number(self.arm.at.end as i64).number(first.nodes[0].0), &shape)
            });
            lights.extend(own.iter().map(|_| light));
        }
        lights
    }

    /// Adds a sign at the kerb side of a lane.
    fn sign(&self, assembly: &mut MapBuilder, key: Key, lane: &ArmLane, subtype: &str) -> LineStringId {
        let right = right_of(lane.pose.heading);
        let outward = if self.driving == DrivingSide::Left { -1.0 } else { 1.0 };
        let middle = lane.pose.point + right * (outward * (lane.width / 2.0 + SIGN_SIZE));
        let ends = [("left", -0.5), ("right", 0.5)].map(|(name, along)| {
            assembly.point(key.word("sign").word(name), middle + right * (SIGN_SIZE * along), SIGN_HEIGHT)
        });
        let attributes = Attributes::of(&[("type", "traffic_sign"), ("subtype", subtype)]);
        assembly.line(key.word("sign line"), ends.to_vec(), attributes)
    }
}

/// Adds a stop line on the end nodes of a lane.
pub fn stop_line(assembly: &mut MapBuilder, key: Key, nodes: [PointId; 2], subtype: &str) -> LineStringId {
    assembly.line(key.word("stop line"), nodes.to_vec(), Attributes::of(&[("type", "stop_line"), ("subtype", subtype)]))
}

/// Adds the element by which the lanelets behind a stop line obey a light.
pub fn light_element(
    assembly: &mut MapBuilder,
    key: Key,
    [light, bulbs]: [LineStringId; 2],
    line: LineStringId,
    behind: &[LaneletId],
) {
    let members = [
        ("refers", Target::LineString(light)),
        ("light_bulbs", Target::LineString(bulbs)),
        ("ref_line", Target::LineString(line)),
    ];
    assembly.element(key.word("lights"), "traffic_light", &members, behind);
}

/// The direction to the right of `heading`.
fn right_of(heading: Vector) -> Vector {
    -left_of(heading)
}

/// Adds a light and its bulbs.
pub fn add_light(assembly: &mut MapBuilder, key: Key, shape: &LightShape) -> [LineStringId; 2] {
    let ends = ["left", "right"].into_iter().zip(shape.ends);
    let ends = ends.map(|(name, place)| assembly.point(key.word(name), place, LIGHT_HEIGHT)).collect();
    let light = assembly.named_line(key, ends, shape.attributes());
    let lamps = shape.lamps.iter().map(|(color, place, up)| {
        assembly.tagged_point(key.word(color), *place, LIGHT_HEIGHT + up, Attributes::of(&[("color", color)]))
    });
    let mut lamps: Vec<PointId> = lamps.collect();
    lamps.extend(shape.arrow.map(|(arrow, place, up)| {
        let attributes = Attributes::of(&[("color", "green"), ("arrow", arrow)]);
        assembly.tagged_point(key.word("arrow"), place, LIGHT_HEIGHT + up, attributes)
    }));
    let bulbs = assembly.line(key.word("bulbs"), lamps, bulbs_of(light));
    [light, bulbs]
}

/// The places of a light's body and lamps.
pub struct LightShape {
    /// The ends of its lower edge, from left to right as drivers see it.
    ends: [Point; 2],
    /// Height of its body, metres.
    height: f64,
    /// Colours, places, and heights above the lower edge, metres.
    lamps: [(&'static str, Point, f64); 3],
    /// A green arrow below the lamps: its direction, place, and height above the lower edge, metres.
    arrow: Option<(&'static str, Point, f64)>,
}

impl LightShape {
    /// Around a middle, for drivers who head along `heading`.
    pub fn new(driving: DrivingSide, middle: Point, heading: Vector) -> Self {
        Self::with_arrow(driving, middle, heading, None)
    }

    /// The same, with a green arrow if all lanelets that it controls go one way.
    fn with_arrow(driving: DrivingSide, middle: Point, heading: Vector, arrow: Option<TurnDirection>) -> Self {
        let right = right_of(heading);
        // Lamps lie side by side where people drive on the left, as in Japan, and in a column elsewhere.
        let lying = driving == DrivingSide::Left;
        let (width, height) = if lying { (BODY[0], BODY[1]) } else { (BODY[1], BODY[0]) };
        let below = if arrow.is_some() { BODY[1] } else { 0.0 };
        let lamp = |(i, color)| {
            let part = (i as f64 - 1.0) / 3.0;
            let (along, up) = if lying { (width * part, height / 2.0) } else { (0.0, height * (0.5 + part)) };
            (color, middle + right * along, below + up)
        };
        let lamps = [(0, "green"), (1, "yellow"), (2, "red")].map(lamp);
        let arrow = arrow.map(|arrow| {
            let (name, part) = match arrow {
                TurnDirection::Left => ("left", -1.0 / 3.0),
                TurnDirection::Straight => ("up", 0.0),
                TurnDirection::Right => ("right", 1.0 / 3.0),
            };
            (name, middle + right * if lying { width * part } else { 0.0 }, below / 2.0)
        });
        let ends = [-0.5, 0.5].map(|along| middle + right * (width * along));
        Self { ends, height: height + below, lamps, arrow }
    }

    /// Tags of its body.
    fn attributes(&self) -> Attributes {
        let mut attributes = Attributes::of(&[("type", "traffic_light"), ("subtype", "red_yellow_green")]);
        attributes.push("height", crate::osm::Text::from(format!("{}", self.height)));
        attributes
    }
}

/// Tags of the bulbs of a light.
pub fn bulbs_of(light: LineStringId) -> Attributes {
    let mut attributes = Attributes::of(&[("type", "light_bulbs")]);
    attributes.push("traffic_light_id", crate::osm::Text::from(light.0.to_string()));
    attributes
}
