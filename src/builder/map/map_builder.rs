//! The map under construction: primitives get their ids from keys and are never changed but to gain members
//! or to be cut in two.
//!
//! Parts that do not depend on each other are made apart, each over what stands already, and then added in order: the
//! map is the same as if they had been made one after the other.

mod partial_maps;

pub use partial_maps::PartialMaps;

use std::sync::Arc;

use crate::builder::ids::{Contest, Id, IdTaken, Ids, Key, wanted_by_polygon};
use crate::builder::streets::heights::{Ground, rounded};
use crate::geometry::Point as PlanePoint;
use crate::lanelet::{
    Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, LineStringId, Member, Point, PointId, Polygon,
    PolygonId, Primitive, PrimitiveLayer, RegulatoryElement, RegulatoryElementId, Target,
};

/// A [`LaneletMap`] and the ids it has used.
#[derive(Debug, Default)]
pub struct MapBuilder<'a> {
    part: MapPart,
    /// What stood before this part was begun.
    below: Option<&'a MapBuilder<'a>>,
    /// What points that are added stand on.
    ground: Ground,
    /// Ids that nobody gets.
    contest: Arc<Contest>,
    /// Whether parts over this one ask for every id whether it is taken here. It hardly ever is, so they are first made
    /// without; that no id comes twice shows when they are added.
    careful: bool,
}

/// What has been added to an [`MapBuilder`].
#[derive(Clone, Debug, Default)]
pub struct MapPart {
    map: LaneletMap,
    ids: Ids,
    /// Elements to which lanelets from below are to refer.
    carried: Vec<(LaneletId, RegulatoryElementId)>,
}

/// What stands on a shelf or below. A part that is being drawn mostly asks for what stands below: it needs no index of its own
/// before it asks for more.
fn found<'a, T: Primitive>(
    shelf: &'a PrimitiveLayer<T>,
    id: T::Id,
    below: impl FnOnce() -> Option<&'a T>,
) -> Option<&'a T> {
    if shelf.is_indexed() { shelf.get(id).or_else(below) } else { below().or_else(|| shelf.get(id)) }
}

impl MapPart {
    /// The same without room for more.
    #[must_use]
    pub fn shrunk(mut self) -> Self {
        self.map.shrink();
        self.ids.rest();
        self
    }
}

impl<'a> MapBuilder<'a> {
    /// An empty assembly in which nobody gets ids that two elements want.
    pub fn new(contest: Arc<Contest>) -> Self {
        Self { contest, ..Self::default() }
    }

    /// An empty assembly that knows what stands in another.
    pub fn over(below: &'a MapBuilder<'a>) -> Self {
        Self::resume(below, MapPart::default())
    }

    /// Goes on with a part that was begun over the same assembly.
    pub fn resume(below: &'a MapBuilder<'a>, mut part: MapPart) -> Self {
        part.ids.wake();
        Self { part, below: Some(below), contest: below.contest.clone(), ..Self::default() }
    }

    /// From now on parts over this one take none of its ids.
    fn require_unique_ids(&mut self) {
        self.part.ids.wake();
        self.careful = true;
    }

    /// Takes less memory until [`MapBuilder::add_one_by_one`]; nothing is added until then.
    pub fn compact(&mut self) {
        self.part.ids.rest();
    }

    /// Puts all points that are added from now on on this ground.
    pub fn set_ground(&mut self, ground: Ground) {
        self.ground = ground;
    }

    /// The ground between points that exist.
    pub fn ground_between(&self, points: impl Iterator<Item = PointId>) -> Ground {
        let place = |point: &Point| (point.position, point.ele().unwrap_or_default());
        Ground::between(self.points_of(points).map(|point| point.map_or_else(Default::default, place)).collect())
    }

    /// Where points lie. Quick where they were made one behind the other and stand below.
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

    /// How high a point lies, metres.
    fn height(&self, id: PointId) -> f64 {
        self.point_of(id).and_then(Point::ele).unwrap_or_default()
    }

    /// What has been added.
    pub fn into_part(self) -> MapPart {
        self.part
    }

    /// What has been added, as a map.
    pub fn into_map(self) -> LaneletMap {
        self.part.map
    }

    /// Adds a part that was made over this assembly.
    ///
    /// # Errors
    /// One of its ids was taken since; then nothing is added.
    pub fn add(&mut self, part: MapPart) -> Result<(), IdTaken> {
        self.part.ids.join(&part.ids)?;
        self.part.map.absorb(part.map);
        for (lanelet, element) in part.carried {
            self.carry(lanelet, element);
        }
        Ok(())
    }

    /// Adds parts that were made side by side over this assembly, in order.
    ///
    /// # Errors
    /// Gives the parts back, to be added one by one, where two share an id.
    pub fn add_all(&mut self, parts: Vec<MapPart>) -> Result<(), Vec<MapPart>> {
        if !Ids::are_apart(parts.iter().chain([&self.part]).map(|part| &part.ids)) {
            return Err(parts);
        }
        self.part.ids.join_apart(parts.iter().map(|part| &part.ids));
        let mut carried = Vec::new();
        let maps = parts.into_iter().map(|part| {
            carried.extend(part.carried);
            part.map
        });
        self.part.map.absorb_all(maps.collect());
        carried.into_iter().for_each(|(lanelet, element)| self.carry(lanelet, element));
        Ok(())
    }

    /// The whole map, with the parts that were made over this assembly.
    pub fn finish(self, parts: PartialMaps) -> LaneletMap {
        let (mut whole, MapPart { map: first, ids, .. }) =
            (Self { part: parts.into_part(), ..Self::default() }, self.part);
        // No more ids are handed out: what is taken need not be known while the whole is made.
        drop((ids, std::mem::take(&mut whole.part.ids)));
        whole.part.map.prepend(first);
        for (lanelet, element) in std::mem::take(&mut whole.part.carried) {
            whole.carry(lanelet, element);
        }
        whole.part.map
    }

    /// Adds parts that were made over this assembly and share ids, in order. Where something added before has taken one of a
    /// part's ids, `make` makes that part, by its index, once more over all that stands, with ids of its own.
    pub fn add_one_by_one(&mut self, parts: Vec<MapPart>, mut make: impl FnMut(usize, &MapBuilder) -> MapPart) {
        self.require_unique_ids();
        for (i, part) in parts.into_iter().enumerate() {
            if self.add(part).is_err() {
                let again = make(i, self);
                let _ = self.add(again);
            }
        }
    }

    fn carry(&mut self, carrier: LaneletId, element: RegulatoryElementId) {
        match self.part.map.lanelets.get_mut(carrier) {
            Some(lanelet) => lanelet.regulatory_elements.push(element),
            None => self.part.carried.push((carrier, element)),
        }
    }

    /// Gives back the ids of a line and of its points but for those that stay, so that they can be made anew.
    pub fn release_line(&mut self, id: LineStringId, stays: impl Fn(PointId) -> bool) {
        let MapPart { map, ids, .. } = &mut self.part;
        let points = map.linestrings.get(id).map_or(&[][..], |line| &line.points);
        points.iter().filter(|point| !stays(**point)).for_each(|point| ids.release(point.0));
        ids.release(id.0);
    }

    /// As [`MapBuilder::release_line`] for a lanelet, whose bounds stay.
    pub fn release_lanelet(&mut self, id: LaneletId) {
        self.part.ids.release(id.0);
    }

    /// Takes away the points, lines and lanelets that were given back and not made anew.
    pub fn remove_released(&mut self) {
        let MapPart { map, ids, .. } = &mut self.part;
        let gone = ids.released();
        map.points.retain(|point| !gone.contains(&(point.id.0 as Id)));
        map.linestrings.retain(|line| !gone.contains(&(line.id.0 as Id)));
        map.lanelets.retain(|lanelet| !gone.contains(&(lanelet.id.0 as Id)));
    }

    /// Puts an element on a shelf. What was given back is made anew in its place; over another assembly nothing is.
    fn put<T: Primitive>(&mut self, shelf: impl Fn(&mut MapPart) -> &mut PrimitiveLayer<T>, item: T) {
        match self.below {
            Some(_) => shelf(&mut self.part).push(item),
            None => drop(shelf(&mut self.part).insert(item)),
        }
    }

    /// Makes room for so many more points.
    pub fn reserve(&mut self, points: usize) {
        self.part.map.points.reserve(points);
        self.part.ids.reserve(points);
    }

    fn claim(&mut self, key: Key) -> i64 {
        let Self { part, below, contest, .. } = self;
        part.ids.claim(key, |id| contest.knows(id) || below.is_some_and(|below| below.forbids(id)))
    }

    fn forbids(&self, id: &Id) -> bool {
        self.careful && (self.part.ids.taken(id) || self.below.is_some_and(|below| below.forbids(id)))
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
        let id = PointId(self.claim(key));
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
        let id = LineStringId(self.claim(key));
        self.put(|part| &mut part.map.linestrings, LineString { id, points, attributes, span: None });
        id
    }

    /// Adds a line whose id fits 31 bits: tools read the tags that name it into as many.
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
        let inner = 1..line.len().max(2) - 1;
        let mut points = Vec::with_capacity(line.len().max(2));
        points.push(first);
        for (number, i) in inner.enumerate() {
            let key = key.word("point").number(number as i64);
            points.push(self.point_at(key, line[i], heights[i], Attributes::new()));
        }
        points.push(last);
        self.line(key, points, attributes)
    }

    /// Adds the id for a polygon whose points are not known yet.
    pub fn polygon_id(&mut self, key: Key) -> PolygonId {
        let Self { part, below, contest, .. } = self;
        let id = part.ids.claim_polygon(key, |id| contest.knows(id) || below.is_some_and(|below| below.forbids(id)));
        contest.note(wanted_by_polygon(key), id);
        PolygonId(id)
    }

    /// Adds a polygon under an id from [`MapBuilder::polygon_id`].
    pub fn polygon(&mut self, id: PolygonId, points: Vec<PointId>, attributes: Attributes) {
        self.put(|part| &mut part.map.polygons, Polygon { id, points, attributes, span: None });
    }

    /// Adds a lanelet between two bounds.
    pub fn lanelet(&mut self, key: Key, left: Bound, right: Bound, attributes: Attributes) -> LaneletId {
        let id = LaneletId(self.claim(key));
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
        let id = RegulatoryElementId(self.claim(key));
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
