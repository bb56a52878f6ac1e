//! The map under construction. The id of a primitive depends on its key, so that a primitive that is drawn again replaces the one
//! before.
//!
//! Parts that do not depend on each other are made in parallel, each on top of the same map, and then added in order. The map is
//! the same as if they were made one after the other.

mod partial_maps;

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use crate::builder::ids::Key;
use crate::builder::streets::heights::{Ground, rounded};
use crate::geometry::Point as PlanePoint;
use crate::lanelet::{
    Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId, Polygon,
    PolygonId, Primitive, PrimitiveLayer, RegulatoryElement, RegulatoryElementId, Target,
};

/// A [`LaneletMap`] that grows.
#[derive(Debug, Default)]
pub struct MapBuilder<'a> {
    part: MapPart,
    /// The map on top of which this part is made.
    below: Option<&'a MapBuilder<'a>>,
    /// The ground on which new points lie.
    ground: Ground,
    /// Ids that no element gets; only the lowest builder has them.
    contested: BTreeSet<i64>,
}

/// What has been added to a [`MapBuilder`].
#[derive(Clone, Debug, Default)]
pub struct MapPart {
    map: LaneletMap,
    /// Elements to which lanelets of the map below refer.
    carried: Vec<(LaneletId, RegulatoryElementId)>,
}

/// The element of an id in a layer of this part or in the map below. Most lookups are for elements below, so the layer gets no
/// index before one is needed.
fn found<'a, T: Primitive>(
    shelf: &'a PrimitiveLayer<T>,
    id: T::Id,
    below: impl FnOnce() -> Option<&'a T>,
) -> Option<&'a T> {
    if shelf.is_indexed() { shelf.get(id).or_else(below) } else { below().or_else(|| shelf.get(id)) }
}

impl MapPart {
    /// The same part without spare memory.
    #[must_use]
    pub fn shrunk(mut self) -> Self {
        self.map.shrink();
        self
    }

    /// The places of a line of this part, which may run over points of the map below; none if the part has no such line.
    pub fn line_places(&self, below: &MapBuilder, line: LineStringId) -> Vec<PlanePoint> {
        let points = self.map.linestrings.get(line).map(|line| &line.points[..]).unwrap_or_default();
        let place = |id: &PointId| Some(self.map.points.get(*id).or_else(|| below.point_of(*id))?.position);
        points.iter().filter_map(place).collect()
    }
}

impl<'a> MapBuilder<'a> {
    /// An empty map in which no element gets a contested id.
    pub fn new(contested: BTreeSet<i64>) -> Self {
        Self { contested, ..Self::default() }
    }

    /// An empty part on top of another map.
    pub fn over(below: &'a MapBuilder<'a>) -> Self {
        Self::resume(below, MapPart::default())
    }

    /// Continues a part that was begun on top of the same map.
    pub fn resume(below: &'a MapBuilder<'a>, part: MapPart) -> Self {
        Self { part, below: Some(below), ..Self::default() }
    }

    /// Sets the ground for all points that are added from now on.
    pub fn set_ground(&mut self, ground: Ground) {
        self.ground = ground;
    }

    /// The ground between points that exist.
    pub fn ground_between(&self, points: impl Iterator<Item = PointId>) -> Ground {
        let place = |point: &Point| (point.position, point.ele().unwrap_or_default());
        Ground::between(self.points_of(points).map(|point| point.map_or_else(Default::default, place)).collect())
    }

    /// The places of points. It is fast for points of the map below that were added one after the other.
    pub fn positions(&self, ids: &[PointId]) -> Vec<PlanePoint> {
        let points = self.points_of(ids.iter().copied());
        points.map(|point| point.map(|point| point.position).unwrap_or_default()).collect()
    }

    fn points_of(&self, ids: impl Iterator<Item = PointId>) -> impl Iterator<Item = Option<&Point>> {
        let mut below = self.below.unwrap_or(self).part.map.points.cursor();
        ids.map(move |id| below.get(id).or_else(|| self.point_of(id)))
    }

    fn point_of(&self, id: PointId) -> Option<&Point> {
        found(&self.part.map.points, id, || self.below?.point_of(id))
    }

    /// The elevation of a point, metres.
    pub fn height(&self, id: PointId) -> f64 {
        self.point_of(id).and_then(Point::ele).unwrap_or_default()
    }

    /// The part that has been added.
    pub fn into_part(self) -> MapPart {
        self.part
    }

    /// Adds parts that were made on top of this map, in order.
    pub fn add_all(&mut self, parts: Vec<MapPart>) {
        let mut carried = Vec::new();
        let maps = parts.into_iter().map(|part| {
            carried.extend(part.carried);
            part.map
        });
        self.part.map.absorb_all(maps.collect());
        carried.into_iter().for_each(|(lanelet, element)| self.carry(lanelet, element));
    }

    /// The whole map, with the parts that were made on top of this one.
    pub fn finish(self, parts: MapPart) -> LaneletMap {
        let MapPart { map, carried } = parts;
        let mut whole = Self { part: MapPart { map, carried: Vec::new() }, ..Self::default() };
        whole.part.map.prepend(self.part.map);
        carried.into_iter().for_each(|(lanelet, element)| whole.carry(lanelet, element));
        whole.part.map
    }

    fn carry(&mut self, carrier: LaneletId, element: RegulatoryElementId) {
        match self.part.map.lanelets.get_mut(carrier) {
            Some(lanelet) => lanelet.regulatory_elements.push(element),
            None => self.part.carried.push((carrier, element)),
        }
    }

    /// Removes all lines and lanelets but these, and all points but these and those of the lines.
    pub fn retain(
        &mut self,
        lines: &FxHashSet<LineStringId>,
        lanelets: &FxHashSet<LaneletId>,
        mut points: FxHashSet<PointId>,
    ) {
        let map = &mut self.part.map;
        map.linestrings.retain(|line| lines.contains(&line.id));
        map.lanelets.retain(|lanelet| lanelets.contains(&lanelet.id));
        points.extend(map.linestrings.iter().flat_map(|line| line.points.iter().copied()));
        map.points.retain(|point| points.contains(&point.id));
    }

    /// Adds an element to a layer. It replaces the one of the same id; on top of another map, no element is drawn twice.
    fn put<T: Primitive>(&mut self, shelf: impl Fn(&mut MapPart) -> &mut PrimitiveLayer<T>, item: T) {
        match self.below {
            Some(_) => shelf(&mut self.part).push(item),
            None => drop(shelf(&mut self.part).insert(item)),
        }
    }

    /// Reserves room for this number of points more.
    pub fn reserve(&mut self, points: usize) {
        self.part.map.points.reserve(points);
    }

    fn is_contested(&self, id: i64) -> bool {
        self.below.map_or_else(|| self.contested.contains(&id), |below| below.is_contested(id))
    }

    fn id(&self, key: Key) -> i64 {
        key.id(|id| self.is_contested(id))
    }

    /// The lanelet of an id.
    pub fn lanelet_of(&self, id: LaneletId) -> Option<&Lanelet> {
        found(&self.part.map.lanelets, id, || self.below?.lanelet_of(id))
    }

    /// Attributes of a lanelet that this part has added, to change.
    pub fn attributes_mut(&mut self, id: LaneletId) -> Option<&mut Attributes> {
        self.part.map.lanelets.get_mut(id).map(|lanelet| &mut lanelet.attributes)
    }

    /// Gives other tags to a line that this part has added.
    pub fn retag_line(&mut self, id: LineStringId, attributes: Attributes) {
        if let Some(line) = self.part.map.linestrings.get_mut(id) {
            line.attributes = attributes;
        }
    }

    /// Leads a line that this part has added through other points.
    pub fn reshape_line(&mut self, id: LineStringId, points: Vec<PointId>) {
        if let Some(line) = self.part.map.linestrings.get_mut(id) {
            line.points = points;
        }
    }

    /// The line of an id.
    pub fn line_of(&self, id: LineStringId) -> Option<&LineString> {
        found(&self.part.map.linestrings, id, || self.below?.line_of(id))
    }

    /// Adds a point at a place in local metres, `ele` metres above the ground.
    pub fn point(&mut self, key: Key, position: PlanePoint, ele: f64) -> PointId {
        self.tagged_point(key, position, ele, Attributes::new())
    }

    /// Adds a point with tags.
    pub fn tagged_point(&mut self, key: Key, position: PlanePoint, ele: f64, attributes: Attributes) -> PointId {
        let ele = self.ground.at(position) + ele;
        self.point_at(key, position, ele, attributes)
    }

    /// Adds a point that lies at a height, metres, whatever the ground is.
    pub fn point_at(&mut self, key: Key, position: PlanePoint, ele: f64, attributes: Attributes) -> PointId {
        let id = PointId(key.node_id(|id| self.is_contested(id)));
        let point = Point::new(id, position, Some(ele)).with_attributes(attributes);
        self.put(|part| &mut part.map.points, point);
        id
    }

    /// Adds a point at a place on the straight piece from one point to another, whose slope it lies on.
    pub fn point_between(&mut self, key: Key, position: PlanePoint, [from, to]: [PointId; 2]) -> PointId {
        let [start, end] = [from, to].map(|id| self.position(id));
        let [low, high] = [from, to].map(|id| self.height(id));
        let part = ((position - start).norm() / (end - start).norm().max(f64::EPSILON)).min(1.0);
        self.point_at(key, position, rounded(low + (high - low) * part), Attributes::new())
    }

    /// Heights of the places of a line on the ground from one point to another, which are among the places.
    pub fn heights_along(&self, line: &[PlanePoint], ends: [PointId; 2]) -> Vec<f64> {
        self.ground.along(line, || ends.map(|id| self.height(id)))
    }

    /// Where a point lies.
    pub fn position(&self, id: PointId) -> PlanePoint {
        self.point_of(id).map(|point| point.position).unwrap_or_default()
    }

    /// Adds a line through points.
    pub fn line(&mut self, key: Key, points: Vec<PointId>, attributes: Attributes) -> LineStringId {
        let id = LineStringId(self.id(key));
        self.put(|part| &mut part.map.linestrings, LineString { id, points, attributes, span: None });
        id
    }

    /// Adds a line whose id fits 31 bits, because tools read the tags that name it into 31 bits.
    pub fn named_line(&mut self, key: Key, points: Vec<PointId>, attributes: Attributes) -> LineStringId {
        let id = LineStringId(self.polygon_id(key).0);
        self.put(|part| &mut part.map.linestrings, LineString { id, points, attributes, span: None });
        id
    }

    /// Adds the line along places from one point that exists to another, and the points between.
    pub fn line_between(
        &mut self,
        key: Key,
        [first, last]: [PointId; 2],
        line: &[PlanePoint],
        attributes: Attributes,
    ) -> LineStringId {
        let heights = self.heights_along(line, [first, last]);
        let inner = line.iter().zip(heights).skip(1).take(line.len().saturating_sub(2));
        let mut points = Vec::with_capacity(line.len().max(2));
        points.push(first);
        for (number, (place, height)) in inner.enumerate() {
            let key = key.word("point").number(number as i64);
            points.push(self.point_at(key, *place, height, Attributes::new()));
        }
        points.push(last);
        self.line(key, points, attributes)
    }

    /// The id of a polygon.
    pub fn polygon_id(&self, key: Key) -> PolygonId {
        PolygonId(key.short_id(|id| self.is_contested(id)))
    }

    /// Adds a polygon under an id from [`MapBuilder::polygon_id`].
    pub fn polygon(&mut self, id: PolygonId, points: Vec<PointId>, attributes: Attributes) {
        self.put(|part| &mut part.map.polygons, Polygon { id, points, attributes, span: None });
    }

    /// Adds a lanelet between two bounds.
    pub fn lanelet(&mut self, key: Key, left: Bound, right: Bound, attributes: Attributes) -> LaneletId {
        let id = LaneletId(self.id(key));
        let (centerline, regulatory_elements) = (None, Vec::new());
        let lanelet = Lanelet { id, left, right, centerline, regulatory_elements, attributes, span: None };
        self.put(|part| &mut part.map.lanelets, lanelet);
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
        let id = RegulatoryElementId(self.id(key));
        let element = RegulatoryElement {
            id,
            subtype: subtype.into(),
            members: members.iter().map(|&(role, target)| Member { role: role.into(), target }).collect(),
            attributes: Attributes::of(&[("type", "regulatory_element"), ("subtype", subtype)]),
            span: None,
        };
        self.put(|part| &mut part.map.regulatory_elements, element);
        for &carrier in carriers {
            self.carry(carrier, id);
        }
        id
    }

    /// The points of a bound in the direction of travel.
    pub fn bound_ids(&self, bound: Bound) -> Vec<PointId> {
        let mut ids = self.line_of(bound.line).map(|line| line.points.clone()).unwrap_or_default();
        if bound.inverted {
            ids.reverse();
        }
        ids
    }

    /// Where the points of a bound lie, in the direction of travel.
    pub fn bound_line(&self, bound: Bound) -> Vec<PlanePoint> {
        self.bound_ids(bound).into_iter().map(|id| self.position(id)).collect()
    }

    /// The outline of a lanelet; empty if there is no such lanelet.
    pub fn outline(&self, id: LaneletId) -> Vec<PlanePoint> {
        let Some(lanelet) = self.lanelet_of(id) else { return Vec::new() };
        let [left, right] = [lanelet.left, lanelet.right].map(|bound| self.bound_ids(bound));
        left.into_iter().chain(right.into_iter().rev()).map(|id| self.position(id)).collect()
    }
}
