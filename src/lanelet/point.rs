//! Points: most of a map, so they are as small as can be.

use crate::diagnostic::SourceSpan;
use crate::geometry::Point as PlanePoint;
use crate::parallel::InSmallParts;
use crate::projection::{LonLat, Projector};

use super::{Attributes, LaneletMap, PointId};

use rayon::prelude::*;

/// A point: shared by id, never by place.
#[derive(Clone, Debug)]
pub struct Point {
    /// Its id.
    pub id: PointId,
    /// East, north in local metres, as the projector or `local_x`/`local_y` gives them.
    pub position: PlanePoint,
    /// Not a number where there is none.
    ele: f64,
    more: Option<Box<More>>,
}

/// Values that every point of a map from a file has, and few points of a built map.
#[derive(Clone, Debug)]
struct More {
    attributes: Attributes,
    /// Not a number where there is none.
    lonlat: LonLat,
    local: [bool; 2],
    span: Option<SourceSpan>,
}

const NOWHERE: LonLat = LonLat { lon: f64::NAN, lat: f64::NAN };
static NO_ATTRIBUTES: Attributes = Attributes::new();

impl Point {
    /// A point without tags, at a height in metres if it has one.
    pub const fn new(id: PointId, position: PlanePoint, ele: Option<f64>) -> Self {
        let ele = match ele {
            Some(ele) => ele,
            None => f64::NAN,
        };
        Self { id, position, ele, more: None }
    }

    /// With these tags.
    #[must_use]
    pub fn with_attributes(mut self, attributes: Attributes) -> Self {
        if !attributes.is_empty() {
            self.more().attributes = attributes;
        }
        self
    }

    /// With this longitude and latitude.
    #[must_use]
    pub fn with_lonlat(mut self, lonlat: Option<LonLat>) -> Self {
        self.more().lonlat = lonlat.unwrap_or(NOWHERE);
        self
    }

    /// With what its file says: whether it has `local_x` and `local_y`, and its position there.
    #[must_use]
    pub fn read(mut self, local: [bool; 2], span: SourceSpan) -> Self {
        let more = self.more();
        (more.local, more.span) = (local, Some(span));
        self
    }

    fn more(&mut self) -> &mut More {
        let none = || Box::new(More { attributes: Attributes::new(), lonlat: NOWHERE, local: [false; 2], span: None });
        self.more.get_or_insert_with(none)
    }

    /// Ellipsoidal height in metres (`ele`); `None` if the file has none, which loads as 0.
    pub fn ele(&self) -> Option<f64> {
        (!self.ele.is_nan()).then_some(self.ele)
    }

    /// As written; `None` if absent, which loads as 0, 0. A point that was built has none until
    /// [`LaneletMap::place_on_globe`].
    pub fn lonlat(&self) -> Option<LonLat> {
        self.more.as_ref().map(|more| more.lonlat).filter(|place| !place.lon.is_nan())
    }

    /// Whether the tags `local_x` and `local_y` exist and are numbers. A point that was built has none.
    pub fn local(&self) -> [bool; 2] {
        self.more.as_ref().map_or([false; 2], |more| more.local)
    }

    /// The other tags (`ele`, `local_x`, `local_y` are left out).
    pub fn attributes(&self) -> &Attributes {
        self.more.as_ref().map_or(&NO_ATTRIBUTES, |more| &more.attributes)
    }

    /// Its position in the file.
    pub fn span(&self) -> Option<&SourceSpan> {
        self.more.as_ref()?.span.as_ref()
    }
}

impl LaneletMap {
    /// Gives every point without longitude and latitude its own.
    pub fn place_on_globe(&mut self, projector: &Projector) {
        /// Points that one thread takes at a time: some milliseconds of work.
        const CHUNK: usize = 1 << 13;
        self.points.as_mut_slice().par_chunks_mut(CHUNK).in_small_parts().for_each(|points| {
            let places = lonlats(&points.iter().collect::<Vec<_>>(), projector);
            for (point, place) in points.iter_mut().zip(places) {
                point.more().lonlat = place.unwrap_or(NOWHERE);
            }
        });
    }
}

/// Longitude and latitude of points: what they have, or what the projector says of their position.
pub(super) fn lonlats(points: &[&Point], projector: &Projector) -> Vec<Option<LonLat>> {
    let mut places: Vec<Option<LonLat>> = points.iter().map(|point| point.lonlat()).collect();
    let wanted: Vec<usize> = (0..points.len()).filter(|&i| places[i].is_none()).collect();
    let positions: Vec<_> = wanted.iter().map(|&i| points[i].position).collect();
    let found = projector.inverse_each(&positions, |i| points[wanted[i]].ele().unwrap_or(0.0));
    for (&i, place) in wanted.iter().zip(found) {
        places[i] = place;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_was_built_is_small() {
        assert_eq!(size_of::<Point>(), 40);
        assert!(size_of::<More>() <= 64, "one step more in the allocator");
    }
}
