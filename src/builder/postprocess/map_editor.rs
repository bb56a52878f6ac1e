//! Adds to a finished map: points on bounds, linestrings, regulatory elements.

use crate::builder::ids::Key;
use crate::geometry::{Point as Place, Polyline};
use crate::lanelet::{
    Attributes, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId, PolygonId, RegulatoryElement,
    RegulatoryElementId, Target,
};
use crate::projection::Projector;

use rustc_hash::FxHashSet;

/// A point of a line this close, metres, to the wanted place is used instead of a new one.
const POINT_AT_PLACE: f64 = 0.3;

/// A map with what is needed to add to it.
pub struct MapEditor<'m> {
    /// The map.
    pub map: &'m mut LaneletMap,
    projector: &'m Projector,
}

/// Whether an element of the map has this id.
pub fn is_taken(map: &LaneletMap, id: i64) -> bool {
    map.points.contains(PointId(id))
        || map.polygons.contains(PolygonId(id))
        || map.linestrings.contains(LineStringId(id))
        || map.lanelets.contains(LaneletId(id))
        || map.regulatory_elements.contains(RegulatoryElementId(id))
}

/// Adds a regulatory element, to which the lanelets `carriers` refer.
pub fn insert_element(
    map: &mut LaneletMap,
    id: RegulatoryElementId,
    subtype: &str,
    members: Vec<Member>,
    carriers: &[LaneletId],
) {
    let attributes = Attributes::of(&[("type", "regulatory_element"), ("subtype", subtype)]);
    map.regulatory_elements.insert(RegulatoryElement { id, subtype: subtype.into(), members, attributes, span: None });
    for &carrier in carriers {
        if let Some(lanelet) = map.lanelets.get_mut(carrier) {
            lanelet.regulatory_elements.push(id);
        }
    }
}

/// Takes elements out of a map, and out of all lanelets that refer to them.
pub fn drop_elements(map: &mut LaneletMap, dropped: &FxHashSet<RegulatoryElementId>) {
    if dropped.is_empty() {
        return;
    }
    map.regulatory_elements.retain(|element| !dropped.contains(&element.id));
    for lanelet in map.lanelets.as_mut_slice() {
        lanelet.regulatory_elements.retain(|id| !dropped.contains(id));
    }
}

/// The `right_of_way` elements of a lanelet that list it as the owner of the right of way.
pub fn right_of_way_of(map: &LaneletMap, lane: LaneletId) -> impl Iterator<Item = &RegulatoryElement> {
    let ids = map.lanelets.get(lane).into_iter().flat_map(|lanelet| &lanelet.regulatory_elements);
    let elements = ids.filter_map(|&id| map.regulatory_elements.get(id));
    elements.filter(move |e| e.subtype == "right_of_way" && e.lanelets("right_of_way").any(|owner| owner == lane))
}

impl<'m> MapEditor<'m> {
    /// An editor for a map of which the points have longitude and latitude by `projector`.
    pub fn new(map: &'m mut LaneletMap, projector: &'m Projector) -> Self {
        Self { map, projector }
    }

    fn free_id(&self, key: Key) -> i64 {
        key.id(|id| is_taken(self.map, id))
    }

    /// Adds a point. `ele` is its elevation, metres.
    pub fn point(&mut self, key: Key, position: Place, ele: f64) -> PointId {
        let id = PointId(key.node_id(|id| is_taken(self.map, id)));
        let lonlat = self.projector.inverse_each(&[position], |_| ele).pop().flatten();
        self.map.points.insert(Point::new(id, position, Some(ele)).with_lonlat(lonlat));
        id
    }

    /// Adds a linestring.
    pub fn line(&mut self, key: Key, points: Vec<PointId>, attributes: Attributes) -> LineStringId {
        let id = LineStringId(self.free_id(key));
        self.map.linestrings.insert(LineString { id, points, attributes, span: None });
        id
    }

    /// Adds a regulatory element, to which the lanelets `carriers` refer.
    pub fn element(&mut self, key: Key, subtype: &str, members: Vec<(&str, Target)>, carriers: &[LaneletId]) {
        let id = RegulatoryElementId(self.free_id(key));
        let members = members.into_iter().map(|(role, target)| Member { role: role.into(), target }).collect();
        insert_element(self.map, id, subtype, members, carriers);
    }

    /// The polyline of a linestring; `None` if it has no length.
    pub fn shape(&self, line: LineStringId) -> Option<Polyline> {
        let points = &self.map.linestrings.get(line)?.points;
        Polyline::new(points.iter().filter_map(|&id| Some(self.map.points.get(id)?.position)))
    }

    /// The elevation of a linestring at its nearest place, metres; 0 if it has none.
    pub fn height(&self, line: LineStringId, place: Place) -> f64 {
        let ids = self.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
        let points: Vec<&Point> = ids.iter().filter_map(|&id| self.map.points.get(id)).collect();
        let nearest = points.windows(2).filter_map(|pair| {
            let segment = Polyline::new(pair.iter().map(|point| point.position))?;
            let foot = segment.project(place);
            let [from, to] = [pair[0].ele()?, pair[1].ele()?];
            Some(((foot.point - place).norm(), from + (to - from) * foot.station / segment.length()))
        });
        nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, ele)| ele)
    }

    /// The point of a linestring at a place on it. A new one is inserted where none is near.
    pub fn point_on(&mut self, key: Key, line: LineStringId, place: Place) -> PointId {
        let points = self.map.linestrings.get(line).map_or(&[][..], |line| &line.points);
        let distance = |id: &PointId| self.map.points.get(*id).map_or(f64::INFINITY, |p| (p.position - place).norm());
        let nearest = points.iter().copied().min_by(|a, b| distance(a).total_cmp(&distance(b)));
        if let Some(near) = nearest.filter(|id| distance(id) <= POINT_AT_PLACE) {
            return near;
        }
        let index = self.shape(line).map(|shape| shape.project(place).segment + 1);
        let point = self.point(key, place, self.height(line, place));
        if let (Some(index), Some(line)) = (index, self.map.linestrings.get_mut(line)) {
            line.points.insert(index.min(line.points.len()), point);
        }
        point
    }
}
