//! The map as the existing validator holds it (profile `tier4`), where that differs from the map that Autoware holds.

use std::borrow::Cow;

use super::align::align_in_space;
use super::index::view::{Spot, spot};
use super::{Attributes, Bound, Dummies, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Point, Target};
use crate::geometry::Point as Place;
use crate::projection::{ExactUtm, LonLat, Projector};

/// The map with other places or other directions of bounds; `None` where nothing differs.
///
/// The loader reads latitudes and longitudes only: a point without them lies at 0, 0, and `local_x` says nothing. Bounds
/// are aligned in space, and once more when the map is complete, which turns back some ambiguous ones. What did not load is there
/// as a dummy.
pub fn placed(map: &LaneletMap) -> Option<LaneletMap> {
    let mut own = Cow::Borrowed(map);
    if !map.dummies.is_empty() {
        put_dummies(own.to_mut());
    }
    if map.local {
        let places: Vec<LonLat> = map.points.iter().map(|point| point.lonlat().unwrap_or_default()).collect();
        let found = Projector::in_squares(&places);
        for (point, place) in own.to_mut().points.as_mut_slice().iter_mut().zip(found) {
            point.position = place.map_or_else(Place::origin, |(place, _)| place);
        }
    }
    let turned: Vec<(LaneletId, [Bound; 2])> =
        own.lanelets.iter().filter_map(|lanelet| Some((lanelet.id, turned(&own, lanelet)?))).collect();
    for (id, [left, right]) in turned {
        if let Some(lanelet) = own.to_mut().lanelets.get_mut(id) {
            (lanelet.left, lanelet.right) = (left, right);
        }
    }
    match own {
        Cow::Owned(map) => Some(map),
        Cow::Borrowed(_) => None,
    }
}

/// Places nearer to each other than this (m) are the same, with other digits at the end.
pub const SAME_PLACE: f64 = 1e-4;

/// Where points lie to the last digit, as the validator has them.
#[derive(Default)]
pub struct ExactPlaces(ExactUtm);

impl ExactPlaces {
    /// Where a point lies; where the map is projected in another way than the validator does it, as we have it.
    pub fn place(&self, point: &Point) -> Place {
        let own = point.lonlat().and_then(|lonlat| self.0.in_square(lonlat));
        own.filter(|own| (own - point.position).norm() < SAME_PLACE).unwrap_or(point.position)
    }
}

/// Puts lanelets with unusable lines, and elements with members that did not load, where the loader has them.
fn put_dummies(map: &mut LaneletMap) {
    let dummies = std::mem::take(&mut map.dummies);
    for id in lines_of(&dummies) {
        if !map.linestrings.contains(id) {
            map.linestrings.insert(LineString { id, points: Vec::new(), attributes: Attributes::new(), span: None });
        }
    }
    let Dummies { lanelets, centerlines, members, elements, references } = dummies;
    for lanelet in lanelets {
        map.lanelets.insert(lanelet);
    }
    for element in elements {
        map.regulatory_elements.insert(element);
    }
    for (id, element) in references {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            lanelet.regulatory_elements.push(element);
        }
    }
    for (id, line) in centerlines {
        if let Some(lanelet) = map.lanelets.get_mut(id) {
            lanelet.centerline = Some(line);
        }
    }
    for (id, members) in members {
        if let Some(element) = map.regulatory_elements.get_mut(id) {
            element.members = members;
        }
    }
}

/// All lines that dummies refer to.
fn lines_of(dummies: &Dummies) -> Vec<LineStringId> {
    let bounds = dummies.lanelets.iter().flat_map(|lanelet| [lanelet.left.line, lanelet.right.line]);
    let centers = dummies.centerlines.iter().map(|&(_, line)| line);
    let members = dummies.members.iter().flat_map(|(_, members)| members);
    let members = members.chain(dummies.elements.iter().flat_map(|element| &element.members));
    let lines = members.filter_map(|member| match member.target {
        Target::LineString(id) => Some(id),
        _ => None,
    });
    bounds.chain(centers).chain(lines).collect()
}

/// The bounds of a lanelet if they are used in other directions than it says.
fn turned(map: &LaneletMap, lanelet: &Lanelet) -> Option<[Bound; 2]> {
    let [left, right] = aligned(map, lanelet, 2);
    ([left, right] != [lanelet.left, lanelet.right]).then_some([left, right])
}

/// The bounds of a lanelet as the loader first aligns them.
pub fn aligned_once(map: &LaneletMap, lanelet: &Lanelet) -> [Bound; 2] {
    aligned(map, lanelet, 1)
}

/// The bounds of a lanelet, aligned this many times in succession.
fn aligned(map: &LaneletMap, lanelet: &Lanelet, times: usize) -> [Bound; 2] {
    let mut bounds = [lanelet.left, lanelet.right].map(|bound| Bound { inverted: false, ..bound });
    for _ in 0..times {
        let spots = |bound: Bound| -> Vec<Spot> { map.bound_points(bound).map(spot).collect() };
        let (left, right) = align_in_space(&spots(bounds[0]), &spots(bounds[1]));
        bounds[0].inverted ^= left;
        bounds[1].inverted ^= right;
    }
    bounds
}
