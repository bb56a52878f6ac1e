//! The map as Lanelet2 sees it: every lanelet that loads, in the plane, also those that the index leaves out.

use std::sync::OnceLock;

use geo::Coord;
use geo::coordinate_position::{CoordPos, CoordinatePosition};
use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use rustc_hash::FxHashMap;

use crate::geometry::insides::insides_meet;
use crate::geometry::simple_ring::crosses_itself;
use crate::geometry::{Point as Place, overlay, polygon};
use crate::lanelet::number::leading_integer;
use crate::lanelet::{
    Bound, Lanelet, LaneletId, LaneletMap, LineString, Member, Point, Polygon, RegulatoryElement, RegulatoryElementId,
    Target,
};
use crate::parallel::InSmallParts;

use super::extent;

/// Boxes of lanelets with their positions.
type Boxes = RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>;

/// A lanelet with its points in the direction of travel.
#[derive(Debug)]
pub struct Seen<'m> {
    /// The lanelet.
    pub lanelet: &'m Lanelet,
    /// Points of the left bound.
    pub left: Vec<&'m Point>,
    /// Points of the right bound.
    pub right: Vec<&'m Point>,
    /// Left bound, then the right one backwards.
    pub outline: Vec<Place>,
    /// Corners of its box.
    pub extent: [Place; 2],
    /// Square metres.
    pub area: f64,
    /// Whether the outline crosses itself, once somebody has asked.
    crosses_itself: OnceLock<bool>,
}

/// The map, looked at once for all validators.
#[derive(Debug)]
pub struct View<'m> {
    /// The map.
    pub map: &'m LaneletMap,
    /// Its lanelets in file order.
    pub lanelets: Vec<Seen<'m>>,
    by_id: FxHashMap<LaneletId, usize>,
    referrers: FxHashMap<RegulatoryElementId, Vec<usize>>,
    boxes: Boxes,
}

impl<'m> Seen<'m> {
    fn new(map: &'m LaneletMap, lanelet: &'m Lanelet) -> Option<Self> {
        let points = |bound: Bound| map.bound_points(bound).collect::<Vec<_>>();
        let outline = map.outline(lanelet);
        let finite = outline.iter().all(|p| p.x.is_finite() && p.y.is_finite());
        finite.then(|| Self {
            lanelet,
            left: points(lanelet.left),
            right: points(lanelet.right),
            extent: extent(&outline),
            area: polygon::signed_area(&outline).abs(),
            outline,
            crosses_itself: OnceLock::new(),
        })
    }

    /// Its id.
    pub fn id(&self) -> LaneletId {
        self.lanelet.id
    }

    /// A tag.
    pub fn tag(&self, key: &str) -> Option<&'m str> {
        self.lanelet.attributes.get(key)
    }

    /// Whether its `subtype` is this word.
    pub fn is(&self, subtype: &str) -> bool {
        self.tag("subtype") == Some(subtype)
    }

    /// The id in the tag `intersection_area`; `None` if there is none, no number, or 0, which is no id to Lanelet2.
    pub fn area_tag(&self) -> Option<i64> {
        leading_integer(self.tag("intersection_area")?).filter(|&id| id != 0)
    }

    /// Its end points: left and right, first and last.
    pub fn ends(&self) -> Option<[[&'m Point; 2]; 2]> {
        Some([[self.left.first()?, self.right.first()?], [self.left.last()?, self.right.last()?]])
    }

    /// Share of this lanelet's area (1) that an outline covers.
    pub fn share(&self, outline: &[Place]) -> f64 {
        let common = if self.crosses_itself() || crosses_itself(outline) {
            overlay::common_area_turned(&self.outline, outline)
        } else {
            polygon::overlap_by_winding(&self.outline, outline)
        };
        common / self.area
    }

    fn crosses_itself(&self) -> bool {
        *self.crosses_itself.get_or_init(|| crosses_itself(&self.outline))
    }

    /// Whether the insides of both meet. Lanelets that only touch do not.
    pub fn meets(&self, other: &Self) -> bool {
        let plain = |seen: &Self| polygon::signed_area(&seen.outline) <= 0.0 && !seen.crosses_itself();
        let meet = if plain(self) && plain(other) { insides_meet } else { overlay::insides_meet };
        boxes_meet(self.extent, other.extent) && meet(&self.outline, &other.outline)
    }
}

impl<'m> View<'m> {
    /// Looks at a map.
    pub fn new(map: &'m LaneletMap) -> Self {
        Self::of(map, |_| true)
    }

    /// Looks at those lanelets of a map that have a point of a bound between two corners.
    pub fn between(map: &'m LaneletMap, [low, high]: [Place; 2]) -> Self {
        let inside = |p: Place| low.x <= p.x && p.x <= high.x && low.y <= p.y && p.y <= high.y;
        Self::of(map, |lanelet| {
            [lanelet.left, lanelet.right]
                .iter()
                .any(|&bound| map.bound_points(bound).any(|point| inside(point.position)))
        })
    }

    fn of(map: &'m LaneletMap, wanted: impl Fn(&Lanelet) -> bool + Sync) -> Self {
        let all = map.lanelets.as_slice().par_iter().in_small_parts();
        let lanelets = all.filter(|lanelet| wanted(lanelet)).filter_map(|lanelet| Seen::new(map, lanelet));
        let lanelets: Vec<Seen<'m>> = lanelets.collect();
        let mut referrers: FxHashMap<RegulatoryElementId, Vec<usize>> = FxHashMap::default();
        for (at, seen) in lanelets.iter().enumerate() {
            for &element in &seen.lanelet.regulatory_elements {
                let list = referrers.entry(element).or_default();
                if list.last() != Some(&at) {
                    list.push(at);
                }
            }
        }
        // A lanelet without points lies nowhere.
        let somewhere = lanelets.iter().enumerate().filter(|(_, seen)| !seen.outline.is_empty());
        let boxes = somewhere.map(|(at, seen)| {
            let [low, high] = seen.extent;
            GeomWithData::new(Rectangle::from_corners([low.x, low.y], [high.x, high.y]), at)
        });
        let boxes = RTree::bulk_load(boxes.collect());
        let by_id = lanelets.iter().enumerate().map(|(at, seen)| (seen.id(), at)).collect();
        Self { map, lanelets, by_id, referrers, boxes }
    }

    /// Position of a lanelet.
    pub fn position(&self, id: LaneletId) -> Option<usize> {
        self.by_id.get(&id).copied()
    }

    /// Lanelets whose box meets this one, by position.
    pub fn near(&self, [low, high]: [Place; 2], reach: f64) -> Vec<usize> {
        let envelope = AABB::from_corners([low.x - reach, low.y - reach], [high.x + reach, high.y + reach]);
        let mut found: Vec<usize> = self.boxes.locate_in_envelope_intersecting(&envelope).map(|one| one.data).collect();
        found.sort_unstable();
        found
    }

    /// Lanelets that refer to an element, by position.
    pub fn referrers(&self, element: RegulatoryElementId) -> &[usize] {
        self.referrers.get(&element).map_or(&[], Vec::as_slice)
    }

    /// All elements of a subtype.
    pub fn elements<'a>(&'a self, subtype: &'a str) -> impl Iterator<Item = &'m RegulatoryElement> + 'a {
        self.map.regulatory_elements.iter().filter(move |element| element.subtype == subtype)
    }

    /// The elements of a subtype that a lanelet refers to, in file order.
    pub fn elements_of<'a>(
        &'a self,
        seen: &'a Seen<'m>,
        subtype: &'a str,
    ) -> impl Iterator<Item = &'m RegulatoryElement> + 'a {
        let ids = seen.lanelet.regulatory_elements.iter();
        ids.filter_map(|&id| self.map.regulatory_elements.get(id)).filter(move |element| element.subtype == subtype)
    }

    /// The lines of an element in one role, in file order.
    pub fn lines<'a>(
        &'a self,
        element: &'a RegulatoryElement,
        role: &'a str,
    ) -> impl Iterator<Item = &'m LineString> + 'a {
        element.linestrings(role).filter_map(|id| self.map.linestrings.get(id))
    }

    /// Diagonal (m) of the box around the members of an element and, of each lanelet that refers to it, the place that is nearest to
    /// them: a long lane makes no element large.
    pub fn reach(&self, element: &RegulatoryElement) -> f64 {
        let mut places = self.member_places(element, |_| true);
        let [low, high] = extent(&places);
        let middle = nalgebra::center(&low, &high);
        let outlines = self.referrers(element.id).iter().map(|&at| &self.lanelets[at].outline);
        let nearest = |outline: &Vec<Place>| {
            let squared = |place: &Place| (place - middle).norm_squared();
            outline.iter().copied().min_by(|a, b| squared(a).total_cmp(&squared(b)))
        };
        let near: Vec<Place> = outlines.filter_map(nearest).collect();
        places.extend(near);
        diagonal(places).unwrap_or_default()
    }

    /// Diagonal (m) of the box around the members of an element that count and the lanelets that refer to it; `None` where neither one
    /// of them nor a lanelet has a place.
    pub fn diagonal_of(&self, element: &RegulatoryElement, counts: impl Fn(&Member) -> bool) -> Option<f64> {
        let referrers = self.referrers(element.id).iter().flat_map(|&at| &self.lanelets[at].outline);
        diagonal(self.member_places(element, counts).into_iter().chain(referrers.copied()))
    }

    /// Diagonal (m) of the box around the members of an element.
    pub fn spread(&self, element: &RegulatoryElement) -> f64 {
        diagonal(self.member_places(element, |_| true)).unwrap_or_default()
    }

    fn member_places(&self, element: &RegulatoryElement, counts: impl Fn(&Member) -> bool) -> Vec<Place> {
        let mut places: Vec<Place> = Vec::new();
        for member in element.members.iter().filter(|member| counts(member)) {
            match member.target {
                Target::Point(id) => places.extend(self.map.points.get(id).map(|point| point.position)),
                Target::LineString(id) => {
                    places.extend(self.map.linestrings.get(id).into_iter().flat_map(|line| self.places(line)));
                }
                Target::Polygon(id) => {
                    places.extend(self.map.polygons.get(id).into_iter().flat_map(|polygon| self.ring(polygon)));
                }
                Target::Lanelet(id) => {
                    places.extend(self.position(id).into_iter().flat_map(|at| &self.lanelets[at].outline));
                }
            }
        }
        places
    }

    /// All polygons of a type.
    pub fn polygons<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'m Polygon> + 'a {
        self.map.polygons.iter().filter(move |polygon| polygon.attributes.is("type", kind))
    }

    /// The points of a line.
    pub fn points(&self, line: &LineString) -> Vec<&'m Point> {
        self.map.points.get_each(line.points.iter().copied()).collect()
    }

    /// Where the points of a line lie.
    pub fn places(&self, line: &LineString) -> Vec<Place> {
        self.points(line).iter().map(|point| point.position).collect()
    }

    /// Where the points of a polygon lie.
    pub fn ring(&self, polygon: &Polygon) -> Vec<Place> {
        self.map.points.get_each(polygon.points.iter().copied()).map(|point| point.position).collect()
    }
}

fn diagonal(places: impl IntoIterator<Item = Place>) -> Option<f64> {
    let places: Vec<Place> = places.into_iter().collect();
    let [low, high] = extent(&places);
    (!places.is_empty()).then(|| (high - low).norm())
}

/// Whether two boxes have a point in common.
pub fn boxes_meet([low, high]: [Place; 2], [other_low, other_high]: [Place; 2]) -> bool {
    low.x <= other_high.x && other_low.x <= high.x && low.y <= other_high.y && other_low.y <= high.y
}

/// Whether a point lies inside a ring or on it.
pub fn covered_by(p: Place, ring: &geo::Polygon<f64>) -> bool {
    ring.coordinate_position(&Coord { x: p.x, y: p.y }) != CoordPos::Outside
}

/// A place in space.
pub type Spot = nalgebra::Point3<f64>;

/// A point with its height.
pub fn spot(point: &Point) -> Spot {
    Spot::new(point.position.x, point.position.y, point.ele().unwrap_or(0.0))
}
