//! Pedestrian signals: a light at each end of a crosswalk, for people who come from the other end.

use crate::builder::ids::Key;
use crate::builder::lanes::road_cut::{CROSSWALK_BREADTH, RoadCrossing, has_lights};
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Road;
use crate::geometry::{Point, Vector, left_of};
use crate::lanelet::{Attributes, LaneletId, LineStringId, Target};

use super::vehicle_signals::bulbs_of;

/// Height of the lower edge of a light above the ground, metres: a tall person walks below.
const LIGHT_HEIGHT: f64 = 2.1;
/// Width and height of the body of a light, metres.
const BODY: [f64; 2] = [0.3, 0.85];
/// Distance of a light behind the kerb, metres, ...
const BEHIND: f64 = 0.5;
/// ... and beside the crosswalk, metres, on the right of people who face it.
const BESIDE: f64 = 0.3;

/// Adds the lights of a crosswalk, if it has lights, and their regulatory element.
pub fn pedestrian_signals(assembly: &mut MapBuilder, road: &Road, crossing: &RoadCrossing, crosswalk: LaneletId) {
    if !has_lights(road, crossing) {
        return;
    }
    let (first, last) = road.section.carriageway();
    let middle = road.line.at(crossing.station);
    let to_left = left_of(road.line.direction(crossing.station));
    let key = Key::new("walk lights").number(crosswalk.0);
    let ends = [("left", road.section.edge(first), to_left), ("right", road.section.edge(last), -to_left)];
    let lights = ends.map(|(name, offset, ahead)| light(assembly, key.word(name), middle + to_left * offset, ahead));
    let mut members: Vec<(&str, Target)> = Vec::new();
    members.extend(lights.iter().map(|[body, _]| ("refers", Target::LineString(*body))));
    members.extend(lights.iter().map(|[_, bulbs]| ("light_bulbs", Target::LineString(*bulbs))));
    assembly.element(key, "traffic_light", &members, &[crosswalk]);
}

/// Adds a light behind a kerb, and its bulbs, for people who walk `ahead` toward it.
fn light(assembly: &mut MapBuilder, key: Key, kerb: Point, ahead: Vector) -> [LineStringId; 2] {
    let right = -left_of(ahead);
    let [width, height] = BODY;
    let middle = kerb + ahead * BEHIND + right * (CROSSWALK_BREADTH / 2.0 + BESIDE);
    let ends = [("from", -0.5), ("to", 0.5)]
        .map(|(name, along)| assembly.point(key.word(name), middle + right * (width * along), LIGHT_HEIGHT));
    let mut attributes = Attributes::of(&[("type", "traffic_light"), ("subtype", "red_green")]);
    attributes.push("height", crate::osm::Text::from(format!("{height}")));
    let body = assembly.named_line(key, ends.to_vec(), attributes);
    let lamps = [("green", 0.25), ("red", 0.75)].map(|(color, up)| {
        assembly.tagged_point(key.word(color), middle, LIGHT_HEIGHT + height * up, Attributes::of(&[("color", color)]))
    });
    [body, assembly.line(key.word("bulbs"), lamps.to_vec(), bulbs_of(body))]
}
