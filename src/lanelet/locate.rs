//! Where a primitive stands: in the file, in the plane, on the globe.

use super::{LaneletId, LaneletMap, LineStringId, Point, PointId, PolygonId, RegulatoryElementId, Target};
use crate::diagnostic::{Place, SourceSpan, Subject};
use crate::geometry::Point as PlanePoint;
use crate::projection::LonLat;

/// What [`locate`] found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Located {
    /// Place in the source.
    pub span: Option<SourceSpan>,
    /// Middle of the place or of the primitive, local metres.
    pub local: Option<PlanePoint>,
    /// Longitude and latitude of the primitive's point next to it.
    pub lonlat: Option<LonLat>,
}

/// Where a primitive stands, or the place on it that is given.
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
    let nearest = points.iter().min_by(|a, b| {
        let far = |p: &Point| local.map_or(0.0, |local| (p.position - local).norm_squared());
        far(a).total_cmp(&far(b))
    });
    Located { span: span_of(map, subject), local, lonlat: nearest.and_then(|p| p.lonlat) }
}

/// Where the element stands in the file.
pub fn span_of(map: &LaneletMap, subject: Subject) -> Option<SourceSpan> {
    match subject {
        Subject::Map => None,
        Subject::Point(id) => map.points.get(PointId(id))?.span.clone(),
        Subject::LineString(id) => map.linestrings.get(LineStringId(id))?.span.clone(),
        Subject::Polygon(id) => map.polygons.get(PolygonId(id))?.span.clone(),
        Subject::Lanelet(id) => map.lanelets.get(LaneletId(id))?.span.clone(),
        Subject::RegulatoryElement(id) => map.regulatory_elements.get(RegulatoryElementId(id))?.span.clone(),
        Subject::Node(_) | Subject::Way(_) | Subject::Relation(_) => None,
    }
}

/// The points that a primitive is made of; those of its lines and lanelets for a regulatory element.
fn points_of(map: &LaneletMap, subject: Subject) -> Vec<&Point> {
    let all = |ids: &[PointId]| -> Vec<&Point> { ids.iter().filter_map(|&id| map.points.get(id)).collect() };
    let line = |id: LineStringId| map.linestrings.get(id).map_or(Vec::new(), |line| all(&line.points));
    let lanelet = |id: LaneletId| {
        let bounds = map.lanelets.get(id).map(|lanelet| [lanelet.left, lanelet.right]);
        bounds.into_iter().flatten().flat_map(|bound| line(bound.line)).collect::<Vec<_>>()
    };
    let polygon = |id: PolygonId| map.polygons.get(id).map_or(Vec::new(), |polygon| all(&polygon.points));
    match subject {
        Subject::Map | Subject::Way(_) | Subject::Relation(_) => Vec::new(),
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
