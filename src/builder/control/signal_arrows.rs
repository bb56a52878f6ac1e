//! Which lights have arrows: by the settings, those of lanes from which all movements go one way.

use crate::builder::options::{Inside, metres};
use crate::geometry::{Point, polygon};
use crate::lanelet::{PolygonId, TurnDirection};
use crate::projection::Projector;

/// The settings for arrows on lights.
#[derive(Clone, Debug, Default)]
pub struct SignalArrows {
    everywhere: bool,
    /// Single intersections, by the id of the area or a place in it, and whether they have arrows.
    single: Vec<(Option<i64>, Option<Point>, bool)>,
}

impl SignalArrows {
    /// From the settings, in the metres of the map.
    pub fn new(inside: &Inside, projector: &Projector) -> Self {
        let single = inside.intersections.iter().filter_map(|entry| {
            let place = entry.at.map(|place| metres(projector, place));
            Some((entry.ia, place, entry.arrows?))
        });
        Self { everywhere: inside.lights.arrows == Some(true), single: single.collect() }
    }

    /// Whether the lights of an intersection with this area and outline have arrows.
    pub fn are_at(&self, area: PolygonId, ring: &[Point]) -> bool {
        let is_of_area = |&&(ia, place, _): &&(Option<i64>, Option<Point>, bool)| match (ia, place) {
            (Some(ia), _) => ia == area.0,
            (None, Some(place)) => polygon::contains(ring, place),
            (None, None) => false,
        };
        self.single.iter().find(is_of_area).map_or(self.everywhere, |&(.., arrows)| arrows)
    }
}

/// The direction in which all go; `None` if that is not the same for all.
pub fn one_way(mut directions: impl Iterator<Item = TurnDirection>) -> Option<TurnDirection> {
    let first = directions.next()?;
    directions.all(|other| other == first).then_some(first)
}
