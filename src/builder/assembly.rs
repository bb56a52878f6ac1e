//! The map under construction: primitives get their ids from keys and are never changed but to gain members.

use crate::geometry::Point as PlanePoint;
use crate::lanelet::{
    Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId, Polygon,
    PolygonId, RegulatoryElement, RegulatoryElementId, Target,
};

use super::ids::{Ids, Key};

/// A [`LaneletMap`] and the ids it has used.
#[derive(Debug, Default)]
pub struct Assembly {
    /// What stands so far.
    pub map: LaneletMap,
    ids: Ids,
}

/// Tags from pairs.
pub fn tags(pairs: &[(&str, &str)]) -> Attributes {
    pairs.iter().copied().collect()
}

impl Assembly {
    /// Adds a point at a place in local metres, `ele` metres above the ground.
    pub fn point(&mut self, key: Key, position: PlanePoint, ele: f64) -> PointId {
        self.tagged_point(key, position, ele, Attributes::new())
    }

    /// Adds a point with tags.
    pub fn tagged_point(&mut self, key: Key, position: PlanePoint, ele: f64, attributes: Attributes) -> PointId {
        let id = PointId(self.ids.claim(key));
        self.map.points.insert(Point {
            id,
            position,
            ele: Some(ele),
            lonlat: None,
            local: [Some(position.x), Some(position.y)],
            attributes,
            span: None,
        });
        id
    }

    /// Where a point lies.
    pub fn position(&self, id: PointId) -> PlanePoint {
        self.map.points.get(id).map_or_else(PlanePoint::origin, |p| p.position)
    }

    /// Adds a line through points.
    pub fn line(&mut self, key: Key, points: Vec<PointId>, attributes: Attributes) -> LineStringId {
        let id = LineStringId(self.ids.claim(key));
        self.map.linestrings.insert(LineString { id, points, attributes, span: None });
        id
    }

    /// Adds points between two that exist, and the line through all of them.
    pub fn line_between(
        &mut self,
        key: Key,
        [first, last]: [PointId; 2],
        inner: &[PlanePoint],
        attributes: Attributes,
    ) -> LineStringId {
        let mut points = vec![first];
        for (i, p) in inner.iter().enumerate() {
            points.push(self.point(key.word("point").number(i as i64), *p, 0.0));
        }
        points.push(last);
        self.line(key, points, attributes)
    }

    /// Adds the id for a polygon whose points are not known yet.
    pub fn polygon_id(&mut self, key: Key) -> PolygonId {
        PolygonId(self.ids.claim_polygon(key))
    }

    /// Adds a polygon under an id from [`Assembly::polygon_id`].
    pub fn polygon(&mut self, id: PolygonId, points: Vec<PointId>, attributes: Attributes) {
        self.map.polygons.insert(Polygon { id, points, attributes, span: None });
    }

    /// Adds a lanelet between two bounds.
    pub fn lanelet(&mut self, key: Key, left: Bound, right: Bound, attributes: Attributes) -> LaneletId {
        let id = LaneletId(self.ids.claim(key));
        self.map.lanelets.insert(Lanelet {
            id,
            left,
            right,
            centerline: None,
            regulatory_elements: Vec::new(),
            attributes,
            span: None,
        });
        id
    }

    /// Adds a regulatory element and lets the carriers refer to it.
    pub fn element(
        &mut self,
        key: Key,
        subtype: &str,
        members: &[(&str, Target)],
        carriers: &[LaneletId],
    ) -> RegulatoryElementId {
        let id = RegulatoryElementId(self.ids.claim(key));
        self.map.regulatory_elements.insert(RegulatoryElement {
            id,
            subtype: subtype.into(),
            members: members.iter().map(|&(role, target)| Member { role: role.into(), target }).collect(),
            attributes: tags(&[("type", "regulatory_element"), ("subtype", subtype)]),
            span: None,
        });
        for &carrier in carriers {
            if let Some(lanelet) = self.map.lanelets.get_mut(carrier) {
                lanelet.regulatory_elements.push(id);
            }
        }
        id
    }

    /// The points of a bound in the direction of travel.
    pub fn bound_ids(&self, bound: Bound) -> Vec<PointId> {
        self.map.bound_points(bound).map(|p| p.id).collect()
    }

    /// The outline of a lanelet; empty if there is no such lanelet.
    pub fn outline(&self, id: LaneletId) -> Vec<PlanePoint> {
        self.map.lanelets.get(id).map(|l| self.map.outline(l)).unwrap_or_default()
    }
}
