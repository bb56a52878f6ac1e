//! Stop lines, traffic lights and stop signs, and the elements that tie them to lanes.

pub mod crosswalk;
pub mod pedestrian_crossing_signals;
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
use super::network::{End, FeatureKind, Road};
use super::tags::cross_section::Travel;
use super::tags::road_class::DrivingSide;

/// A sign or light on the road belongs to the intersection if it stands at most this far from its end, metres.
const SIGN_REACH: f64 = 40.0;
/// Lower edge of a traffic light above the road, metres: what trucks pass below.
pub const LIGHT_HEIGHT: f64 = 5.0;
/// Lower edge of a sign above the road, metres.
const SIGN_HEIGHT: f64 = 2.0;
/// Side of a sign, metres.
const SIGN_SIZE: f64 = 0.6;
/// Long and short side of a light's body, metres.
const BODY: [f64; 2] = [1.25, 0.45];
/// Lights stand this far, metres, behind the far edge of the intersection.
pub const BEHIND: f64 = 1.0;
/// Lights stand at most this far, metres, from the stop line: drivers must see them.
const LIGHT_REACH: f64 = 50.0;

/// What rules an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Lights.
    Signals,
    /// A stop sign.
    Stop,
    /// A give-way sign.
    GiveWay,
    /// Nothing.
    None,
}

/// The sign that stands on a road before its end.
pub fn sign_at(road: &Road, end: End) -> Control {
    let length = road.line.length();
    let into = end.inbound();
    let mut control = Control::None;
    for feature in &road.features {
        let depth = if end == End::Start { feature.station } else { length - feature.station };
        let (travel, kind) = match feature.kind {
            FeatureKind::Stop(travel) => (travel, Control::Stop),
            FeatureKind::GiveWay(travel) => (travel, Control::GiveWay),
            _ => continue,
        };
        let meant = travel == into || (travel == Travel::Both && depth <= length / 2.0);
        if meant && depth <= SIGN_REACH && control != Control::Stop {
            control = kind;
        }
    }
    control
}

/// A lane that arrives at an intersection, and the lanelets behind its stop line.
pub struct Approach {
    /// The lanelet before the line.
    pub lane: LaneletId,
    /// The lanelets that begin at the line.
    pub behind: Vec<LaneletId>,
    /// Where all of them go, if its light has an arrow.
    pub arrow: Option<TurnDirection>,
}

/// Adds stop lines, lights or signs of one arm and ties them to its lanes, one approach each, and what lies behind.
pub fn control_arm(
    assembly: &mut MapBuilder,
    driving: DrivingSide,
    key: Key,
    arm: &Arm,
    control: Control,
    approaches: &[Approach],
    ring: &[Point],
) {
    let lights = (control == Control::Signals).then(|| traffic_lights(assembly, driving, key, arm, approaches, ring));
    for (at, (lane, Approach { lane: before, behind, .. })) in arm.into.iter().zip(approaches).enumerate() {
        if behind.is_empty() {
            continue;
        }
        let key = key.number(lane.nodes[0].0).number(lane.nodes[1].0);
        let line = stop_line(assembly, key, lane.nodes);
        match (control, lights.as_ref().and_then(|lights| *lights.get(at)?)) {
            (Control::Signals, Some(light)) => light_element(assembly, key, light, line, behind),
            (Control::Stop, _) => sign_element(assembly, driving, key, lane, "stop_sign", line, *before),
            _ => {
                // Who has to give way stops only for others: this line is where.
                assembly.element(key.word("marking"), "road_marking", &[("refers", Target::LineString(line))], behind);
                if control == Control::GiveWay {
                    sign_element(assembly, driving, key, lane, "give_way", line, *before);
                }
            }
        }
    }
}

/// A stop line on the end nodes of a lane.
pub fn stop_line(assembly: &mut MapBuilder, key: Key, nodes: [PointId; 2]) -> LineStringId {
    assembly.line(key.word("stop line"), nodes.to_vec(), Attributes::of(&[("type", "stop_line"), ("subtype", "solid")]))
}

/// Lets the lanelets behind a stop line obey a light.
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

/// The right of someone who looks along `heading`.
fn right_of(heading: Vector) -> Vector {
    -left_of(heading)
}

/// Lights on the far side of the intersection that face the arm, and their bulbs, by lane: neighbours with the same arrow, or
/// without one, have one together. There is none where nothing leads on.
fn traffic_lights(
    assembly: &mut MapBuilder,
    driving: DrivingSide,
    key: Key,
    arm: &Arm,
    approaches: &[Approach],
    ring: &[Point],
) -> Vec<Option<[LineStringId; 2]>> {
    let mut lights = Vec::new();
    let mut lanes = &arm.into[..];
    for alike in approaches.chunk_by(|one, next| one.arrow == next.arrow) {
        let (own, others) = lanes.split_at(alike.len().min(lanes.len()));
        lanes = others;
        let (Some(first), Some(last)) = (own.first(), own.last()) else { continue };
        if alike.iter().all(|approach| approach.behind.is_empty()) {
            lights.extend(own.iter().map(|_| None));
            continue;
        }
        let start = nalgebra::center(&first.pose.point, &last.pose.point);
        let far = ring.iter().map(|p| (p - start).dot(&arm.inward)).fold(0.0, f64::max);
        let middle = start + arm.inward * (far + BEHIND).min(LIGHT_REACH);
        let shape = LightShape::with_arrow(driving, middle, arm.inward, alike[0].arrow);
        let key = key.word("light").number(arm.at.end as i64).number(first.nodes[0].0);
        let light = add_light(assembly, key, &shape);
        lights.extend(own.iter().map(|_| Some(light)));
    }
    lights
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

/// Where a light that drivers see as they head somewhere has its ends, from left to right, and its lamps.
pub struct LightShape {
    /// The lower edge of its body.
    ends: [Point; 2],
    /// Of its body, metres.
    height: f64,
    /// Colours, places, and metres above the lower edge.
    lamps: [(&'static str, Point, f64); 3],
    /// A green arrow below these: where it points, its place, and metres above the lower edge.
    arrow: Option<(&'static str, Point, f64)>,
}

impl LightShape {
    /// Around a middle, for those who look along `heading`.
    pub fn new(driving: DrivingSide, middle: Point, heading: Vector) -> Self {
        Self::with_arrow(driving, middle, heading, None)
    }

    /// The same, with a lamp more if those whom it rules all go one way.
    fn with_arrow(driving: DrivingSide, middle: Point, heading: Vector, arrow: Option<TurnDirection>) -> Self {
        let right = right_of(heading);
        // Lamps lie side by side where people drive on the left, as in Japan, and stand in a column elsewhere.
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

/// Lets the lane before a stop line obey a sign at its kerb side: `stop_sign` is the word that Autoware looks for, and halts;
/// others it passes.
fn sign_element(
    assembly: &mut MapBuilder,
    driving: DrivingSide,
    key: Key,
    lane: &ArmLane,
    subtype: &str,
    line: LineStringId,
    before: LaneletId,
) {
    let right = right_of(lane.pose.heading);
    let outward = if driving == DrivingSide::Left { -1.0 } else { 1.0 };
    let middle = lane.pose.point + right * (outward * (lane.width / 2.0 + SIGN_SIZE));
    let ends = [("left", -0.5), ("right", 0.5)].map(|(name, along)| {
        assembly.point(key.word("sign").word(name), middle + right * (SIGN_SIZE * along), SIGN_HEIGHT)
    });
    let sign = assembly.line(
        key.word("sign line"),
        ends.to_vec(),
        Attributes::of(&[("type", "traffic_sign"), ("subtype", subtype)]),
    );
    let members = [("refers", Target::LineString(sign)), ("ref_line", Target::LineString(line))];
    assembly.element(key.word("sign"), "traffic_sign", &members, &[before]);
}
