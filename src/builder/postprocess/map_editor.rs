//! Draws into a map that stands: points on its bounds, lines through them, elements that lanelets refer to.

use crate::builder::ids::{Id, Ids, Key};
use crate::geometry::{Point as Place, Polyline};
use crate::lanelet::{
    Attributes, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId, PolygonId, RegulatoryElement,
    RegulatoryElementId, Target,
};
use crate::projection::Projector;

/// A point of a line closer than this, metres, to where one is wanted serves.
const NEAR: f64 = 0.3;

/// A map, and what is needed to add to it.
pub struct MapEditor<'m> {
    /// The map.
    pub map: &'m mut LaneletMap,
    projector: &'m Projector,
    ids: Ids,
}

/// Whether an element of the map has this id.
pub fn is_taken(map: &LaneletMap, id: Id) -> bool {
    let id = id as i64;
    map.points.contains(PointId(id))
        || map.polygons.contains(PolygonId(id))
        || map.linestrings.contains(LineStringId(id))
        || map.lanelets.contains(LaneletId(id))
        || map.regulatory_elements.contains(RegulatoryElementId(id))
}

impl<'m> MapEditor<'m> {
    /// For a map whose points have longitude and latitude by a projector.
    pub fn new(map: &'m mut LaneletMap, projector: &'m Projector) -> Self {
        Self { map, projector, ids: Ids::default() }
    }

    fn claim(&mut self, key: Key) -> i64 {
        self.ids.claim(key, |id| is_taken(self.map, *id))
    }

    /// Adds a point at a height in metres.
    pub fn point(&mut self, key: Key, position: Place, ele: f64) -> PointId {
        let id = PointId(self.claim(key));
        let lonlat = self.projector.inverse_each(&[position], |_| ele).pop().flatten();
        self.map.points.insert(Point::new(id, position, Some(ele)).with_lonlat(lonlat));
        id
    }

    /// Adds a line through points.
    pub fn line(&mut self, key: Key, points: Vec<PointId>, attributes: Attributes) -> LineStringId {
        let id = LineStringId(self.claim(key));
        self.map.linestrings.insert(LineString { id, points, attributes, span: None });
        id
    }

    /// Adds an element and lets lanelets refer to it.
    pub fn element(&mut self, key: Key, subtype: &str, members: Vec<(&str, Target)>, carriers: &[LaneletId]) {
        let id = RegulatoryElementId(self.claim(key));
        let members = members.into_iter().map(|(role, target)| Member { role: role.into(), target });
        self.map.regulatory_elements.insert(RegulatoryElement {
            id,
            subtype: subtype.into(),
            members: members.collect(),
            attributes: Attributes::of(&[("type", "regulatory_element"), ("subtype", subtype)]),
            span: None,
        });
        for &carrier in carriers {
            if let Some(lanelet) = self.map.lanelets.get_mut(carrier) {
                lanelet.regulatory_elements.push(id);
            }
        }
    }

    /// Where the points of a line lie; `None` if it has no length.
    pub fn shape(&self, line: LineStringId) -> Option<Polyline> {
        let points = &self.map.linestrings.get(line)?.points;
        Polyline::new(points.iter().filter_map(|&id| Some(self.map.points.get(id)?.position)))
    }

    /// How high a line passes a place, metres.
    pub fn height(&self, line: LineStringId, place: Place) -> f64 {
        let heights = || {
            let ids = &self.map.linestrings.get(line)?.points;
            let points: Vec<&Point> = ids.iter().filter_map(|&id| self.map.points.get(id)).collect();
            let nearest = points.windows(2).filter_map(|pair| {
                let segment = Polyline::new(pair.iter().map(|point| point.position))?;
                let at = segment.project(place);
                let ends = [pair[0].ele()?, pair[1].ele()?];
                let ele = ends[0] + (ends[1] - ends[0]) * at.station / segment.length();
                Some(((at.point - place).norm(), ele))
            });
            nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, ele)| ele)
        };
        heights().unwrap_or_default()
    }

    /// The point of a line at a place on it: one that is there already, else a new one.
    pub fn point_on(&mut self, key: Key, line: LineStringId, place: Place) -> PointId {
        let points = self.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
        let from = |id: &PointId| self.map.points.get(*id).map_or(f64::INFINITY, |p| (p.position - place).norm());
        let nearest = points.iter().copied().min_by(|a, b| from(a).total_cmp(&from(b)));
        if let Some(there) = nearest.filter(|id| from(id) <= NEAR) {
            return there;
        }
        let behind = self.shape(line).map(|shape| shape.project(place).segment + 1);
        let point = self.point(key, place, self.height(line, place));
        if let (Some(behind), Some(line)) = (behind, self.map.linestrings.get_mut(line)) {
            line.points.insert(behind.min(line.points.len()), point);
        }
        point
    }
}
