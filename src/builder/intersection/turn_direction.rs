//! The `turn_direction` of turning lanelets, and the other tags that they get once their intersection has an area.

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Intersection;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::marking::unpainted;
use crate::lanelet::{PolygonId, TurnDirection};

use super::turning_lanelets::{IntersectionPaint, TurningLanelet, paint};

/// The turn direction of a lanelet, by its change of direction.
pub fn turn_direction(path: &TurningLanelet) -> TurnDirection {
    match path.turn {
        turn if turn.abs() <= STRAIGHT_ON => TurnDirection::Straight,
        turn if turn > 0.0 => TurnDirection::Left,
        _ => TurnDirection::Right,
    }
}

/// Tags lanelets with their area and turn direction. Nothing is painted across an intersection, not even where two roads only
/// merge lanes.
pub fn tag_turns<'p>(
    assembly: &mut MapBuilder,
    intersection: &Intersection,
    area: PolygonId,
    paths: impl Iterator<Item = &'p TurningLanelet>,
) {
    let (area, painted) = (area.0.to_string(), paint(intersection) != IntersectionPaint::None);
    for path in paths {
        if let Some(attributes) = assembly.attributes_mut(path.lanelet) {
            attributes.set("turn_direction", turn_direction(path).as_str());
            attributes.set("intersection_area", &area);
        }
        for line in path.bounds.into_iter().filter(|_| painted) {
            assembly.retag_line(line, unpainted());
        }
    }
}
