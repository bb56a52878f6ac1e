//! The position of a primitive in the file, in the plane and on the globe.

use crate::diagnostic::{Place, SourceSpan, Subject};
use crate::geometry::Point as PlanePoint;
use crate::projection::LonLat;

use super::{AreaId, LaneletId, LaneletMap, LineStringId, Point, PointId, PolygonId, RegulatoryElementId, Target};

use nalgebra::Complex;

/// What [`locate`] found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Located {
    /// Place in the source.
    pub span: Option<SourceSpan>,
    /// Middle of the place or of the primitive, local metres.
    pub local: Option<PlanePoint>,
    /// Its longitude and latitude, by those of the primitive's points.
    pub lonlat: Option<LonLat>,
}

/// The position of a primitive, or of the given place on it.
pub fn locate(map: &LaneletMap, subject: Subject, place: &Place) -> Located {
    let points = points_of(map, subject);
    let middle_of = |positions: &[PlanePoint]| {
        let [low, high] = super::index::extent(positions);
        (low.x <= high.x).then(|| nalgebra::center(&low, &high))
    };
    let local = match place {
        Place::Point(point) => Some(*point),
        Place::Line(line) => line.get(line.len() / 2).copied(),
        Place::Polygon(ring) => middle_of(ring),
        Place::Unknown => None,
    };
    let local = local.or_else(|| middle_of(&points.iter().map(|p| p.position).collect::<Vec<_>>()));
    // Where local coordinates count, 0, 0 says that there is no other place.
    let lonlat = lonlat_of(&points, local).filter(|place| !map.local || *place != LonLat::default());
    Located { span: span_of(map, subject), local, lonlat }
}

/// Two points farther apart than this, metres, tell how the plane is turned against north, ...
const TELLING: f64 = 1.0;
/// ... if their distances in the plane and on the globe differ by less than this share: the scale of a projection differs less.
const ALIKE: f64 = 0.01;
/// Length of a degree of latitude, metres: of a sphere, which is near enough over a lanelet's length.
const DEGREE: f64 = 111_195.0;

/// Longitude and latitude of a place in the plane: those of the nearest point, moved by its distance from there; a second point
/// tells the direction of north.
fn lonlat_of(points: &[&Point], local: Option<PlanePoint>) -> Option<LonLat> {
    let far = |p: &Point, from: PlanePoint| (p.position - from).norm_squared();
    let Some(local) = local else { return points.first()?.lonlat() };
    let nearest = points.iter().min_by(|a, b| far(a, local).total_cmp(&far(b, local)))?;
    let origin = nearest.lonlat()?;
    let along = origin.lat.to_radians().cos();
    let on_globe = |to: LonLat| Complex::new((to.lon - origin.lon) * along, to.lat - origin.lat) * DEGREE;
    let in_plane = |to: PlanePoint| Complex::new(to.x - nearest.position.x, to.y - nearest.position.y);
    let other = points.iter().max_by(|a, b| far(a, nearest.position).total_cmp(&far(b, nearest.position)))?;
    let told = other.lonlat().filter(|_| far(other, nearest.position) > TELLING * TELLING);
    let turned = told.map(|to| on_globe(to) / in_plane(other.position));
    let Some(turned) = turned.filter(|turned| (turned.norm() - 1.0).abs() < ALIKE) else { return Some(origin) };
    let away = in_plane(local) * turned / DEGREE;
    Some(LonLat { lon: origin.lon + away.re / along, lat: origin.lat + away.im })
}

/// The position of the element in the file.
pub fn span_of(map: &LaneletMap, subject: Subject) -> Option<SourceSpan> {
    match subject {
        Subject::Map => None,
        Subject::Point(id) => map.points.get(PointId(id))?.span().cloned(),
        Subject::LineString(id) => map.linestrings.get(LineStringId(id))?.span.clone(),
        Subject::Polygon(id) => map.polygons.get(PolygonId(id))?.span.clone(),
        Subject::Lanelet(id) => map.lanelets.get(LaneletId(id))?.span.clone(),
        Subject::RegulatoryElement(id) => map.regulatory_elements.get(RegulatoryElementId(id))?.span.clone(),
        Subject::Relation(id) => map.areas.get(AreaId(id))?.span.clone(),
        Subject::Node(_) | Subject::Way(_) => None,
    }
}

/// Of longer lines every second, third … point is looked at: a rule may speak of each of them.
const MOST_POINTS: usize = 1_000;

/// The points that a primitive is made of; those of its lines and lanelets for a regulatory element.
fn points_of(map: &LaneletMap, subject: Subject) -> Vec<&Point> {
    let all = |ids: &[PointId]| -> Vec<&Point> {
        map.points.get_each(ids.iter().copied().step_by(ids.len() / MOST_POINTS + 1)).collect()
    };
    let line = |id: LineStringId| map.linestrings.get(id).map_or(Vec::new(), |line| all(&line.points));
    let lanelet = |id: LaneletId| {
        let bounds = map.lanelets.get(id).map(|lanelet| [lanelet.left, lanelet.right]);
        bounds.into_iter().flatten().flat_map(|bound| line(bound.line)).collect::<Vec<_>>()
    };
    let polygon = |id: PolygonId| map.polygons.get(id).map_or(Vec::new(), |polygon| all(&polygon.points));
    match subject {
        Subject::Map | Subject::Way(_) => Vec::new(),
        Subject::Relation(id) => map.areas.get(AreaId(id)).map_or(Vec::new(), |area| all(&area.points)),
        Subject::Point(id) | Subject::Node(id) => all(&[PointId(id)]),
        Subject::LineString(id) => line(LineStringId(id)),
        Subject::Polygon(id) => polygon(PolygonId(id)),
        Subject::Lanelet(id) => lanelet(LaneletId(id)),
        Subject::RegulatoryElement(id) => {
            let element = map.regulatory_elements.get(RegulatoryElementId(id));
            let members = element.into_iter().flat_map(|element| &element.members);
            members
                .flat_map(|member| match member.target {
                    Target::Point(id) => all(&[id]),
                    Target::LineString(id) => line(id),
                    Target::Polygon(id) => polygon(id),
                    Target::Lanelet(id) => lanelet(id),
                })
                .collect()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64, lonlat: LonLat) -> Point {
        Point::new(PointId(1), PlanePoint::new(x, y), None).with_lonlat(Some(lonlat))
    }

    #[test]
    fn a_place_between_two_points_lies_between_them_on_the_globe() {
        // The plane is turned: its x-axis points north, and 0.001 degrees of latitude are 111.195 m.
        let ends = [(0.0, 50.0), (111.195, 50.001)].map(|(x, lat)| point(x, 0.0, LonLat { lon: 8.0, lat }));
        let at = |x: f64, y: f64| lonlat_of(&ends.each_ref(), Some(PlanePoint::new(x, y))).unwrap();
        let middle = at(55.0, 0.0);
        assert!((middle.lat - 50.000_495).abs() < 1e-6 && (middle.lon - 8.0).abs() < 1e-9, "{middle:?}");
        // Ten metres to the left of north is ten metres to the west.
        let west = at(0.0, 10.0);
        assert!((west.lon - (8.0 - 10.0 / (111_195.0 * 50f64.to_radians().cos()))).abs() < 1e-9, "{west:?}");
        assert!((west.lat - 50.0).abs() < 1e-9);
        // Where distances on the globe and in the plane differ, take the nearest point.
        let wrong = [point(0.0, 0.0, LonLat { lon: 8.0, lat: 50.0 }), point(10.0, 0.0, LonLat { lon: 9.0, lat: 50.0 })];
        let near = lonlat_of(&wrong.each_ref(), Some(PlanePoint::new(4.0, 0.0))).unwrap();
        assert_eq!(near, LonLat { lon: 8.0, lat: 50.0 });
    }
}
