//! Traffic lights for vehicles: their body, lamps and arrows, and the regulatory element by which lanelets obey them.

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::tags::road_class::DrivingSide;
use crate::geometry::{Point, Vector, left_of};
use crate::lanelet::{Attributes, LaneletId, LineStringId, PointId, Target, TurnDirection};

/// Height of the lower edge of a traffic light above the road, metres: trucks pass below.
pub const LIGHT_HEIGHT: f64 = 5.0;
/// Long and short side of the body of a light, metres.
const BODY: [f64; 2] = [1.25, 0.45];

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
    pub(super) fn with_arrow(
        driving: DrivingSide,
        middle: Point,
        heading: Vector,
        arrow: Option<TurnDirection>,
    ) -> Self {
        let right = -left_of(heading);
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
