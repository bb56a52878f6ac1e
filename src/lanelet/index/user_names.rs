//! Resolves the names in the user's settings of intersections: approaches, movements and lines of the index.

use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use rustc_hash::FxHashMap;

use super::intersection::COMPASS;
use super::types::{Intersection, LaneTree, MapIndex, Movement};
use crate::geometry::{Point, polygon};
use crate::lanelet::{LaneletId, LaneletMap, LineStringId, RegulatoryElementId};
use crate::settings::{ApproachName, GuideLine, IntersectionSettings, Settings};

/// For every intersection the settings that name it: by the id of its area, or by a place inside.
pub(super) fn entries(map: &LaneletMap, intersections: &[Intersection], settings: &Settings) -> Vec<Vec<usize>> {
    let mut found = vec![Vec::new(); intersections.len()];
    let by_area: FxHashMap<i64, usize> =
        intersections.iter().enumerate().filter_map(|(at, one)| Some((one.area?.0, at))).collect();
    // Degrees serve as a plane here: only inside and outside matter.
    let mut outlines: Option<(Vec<Vec<Point>>, LaneTree)> = None;
    for (entry, one) in settings.intersection.iter().enumerate() {
        if let Some(&at) = one.ia.and_then(|ia| by_area.get(&ia)) {
            found[at].push(entry);
        }
        let Some([lat, lon]) = one.at.filter(|_| one.ia.is_none()) else { continue };
        let (rings, tree) = outlines.get_or_insert_with(|| {
            let rings: Vec<Vec<Point>> = intersections.iter().map(|one| degrees(map, one)).collect();
            let boxes = rings.iter().enumerate().filter(|(_, ring)| !ring.is_empty()).map(|(at, ring)| {
                let [low, high] = super::extent(ring);
                GeomWithData::new(Rectangle::from_corners([low.x, low.y], [high.x, high.y]), at)
            });
            let tree = RTree::bulk_load(boxes.collect());
            (rings, tree)
        });
        let inside = tree.locate_in_envelope_intersecting(&AABB::from_point([lon, lat])).map(|found| found.data);
        for at in inside.filter(|&at| polygon::contains(&rings[at], Point::new(lon, lat))) {
            found[at].push(entry);
        }
    }
    found
}

/// The outline of the area in degrees; empty where there is none.
fn degrees(map: &LaneletMap, intersection: &Intersection) -> Vec<Point> {
    let area = intersection.area.and_then(|id| map.polygons.get(id));
    let points = area.into_iter().flat_map(|area| &area.points).filter_map(|&id| map.points.get(id)?.lonlat());
    points.map(|place| Point::new(place.lon, place.lat)).filter(|p| p.x.is_finite() && p.y.is_finite()).collect()
}

/// The user's settings of one intersection.
pub(super) struct UserNames<'a> {
    map: &'a MapIndex<'a>,
    intersection: &'a Intersection,
    movements: &'a [Movement],
    entries: Vec<&'a IntersectionSettings>,
}

impl<'a> UserNames<'a> {
    pub fn new(map: &'a MapIndex<'a>, intersection: &'a Intersection, at: usize, movements: &'a [Movement]) -> Self {
        let entries = map.named[at].iter().filter_map(|&entry| map.settings.intersection.get(entry)).collect();
        Self { map, intersection, movements, entries }
    }

    /// For every movement the phases in which it is green. Where a movement or its element is named, the name of its approach
    /// does not apply to it.
    pub fn phases(&self) -> Vec<Vec<usize>> {
        let green = |means: &dyn Fn(&ApproachName) -> bool| -> Vec<usize> {
            let all = self.entries.iter().flat_map(|entry| &entry.phases).enumerate();
            all.filter(|(_, names)| names.iter().any(means)).map(|(phase, _)| phase).collect()
        };
        let phases = self.movements.iter().map(|movement| {
            let own = green(&|name| ids(name).iter().any(|&id| self.is_named(movement, id)));
            if own.is_empty() { green(&|name| self.starts_at(movement, name)) } else { own }
        });
        phases.collect()
    }

    /// The approaches of the priority road.
    pub fn priority_arms(&self) -> Vec<usize> {
        self.entries.iter().flat_map(|entry| &entry.priority_arms).flat_map(|name| self.arms(name)).collect()
    }

    /// The pairs of approaches between which there is no movement.
    pub fn prohibited(&self) -> Vec<[usize; 2]> {
        let all = self.entries.iter().flat_map(|entry| &entry.prohibited);
        all.flat_map(|[from, to]| {
            let to = self.arms(to);
            self.arms(from).into_iter().flat_map(move |a| to.clone().into_iter().map(move |b| [a, b]))
        })
        .collect()
    }

    /// The ways that are guide lines.
    pub fn guide_lines(&self) -> Vec<LineStringId> {
        let lines = self.entries.iter().flat_map(|entry| &entry.guide_lines);
        let ways = lines.filter_map(|line| match line {
            GuideLine::Way(way) => Some(LineStringId(*way)),
            GuideLine::Places(_) => None,
        });
        ways.collect()
    }

    /// Whether a movement belongs to what a name means: all of an approach, or the lanelets of some ids.
    fn starts_at(&self, movement: &Movement, name: &ApproachName) -> bool {
        let outside = |id: i64| {
            let before = self.map.predecessors(movement.lane).iter();
            before.copied().any(|lane| self.map.lanes[lane].id == LaneletId(id))
        };
        match name {
            ApproachName::Compass(side) => self.on_side(side).contains(&movement.from),
            _ => ids(name).iter().any(|&id| self.is_named(movement, id) || outside(id)),
        }
    }

    /// Whether an id is that of a movement's lanelet or of an element that it refers to.
    fn is_named(&self, movement: &Movement, id: i64) -> bool {
        let (lane, element) = (self.map.lanes[movement.lane].id, RegulatoryElementId(id));
        let refers = || self.map.map.lanelets.get(lane).is_some_and(|l| l.regulatory_elements.contains(&element));
        lane == LaneletId(id) || refers()
    }

    /// The approaches from one side of the intersection, or else the one whose direction is nearest to it: a road can have
    /// another direction along its length than at its end.
    fn on_side(&self, side: &str) -> Vec<usize> {
        let arms = &self.intersection.arms;
        let exact: Vec<usize> = (0..arms.len()).filter(|&at| arms[at].compass == side).collect();
        let Some(wanted) = COMPASS.iter().position(|name| *name == side).filter(|_| exact.is_empty()) else {
            return exact;
        };
        let off = |at: usize| {
            let off = (arms[at].bearing - 45.0 * wanted as f64).rem_euclid(360.0);
            off.min(360.0 - off)
        };
        let near = (0..arms.len()).filter(|&at| off(at) <= 45.0);
        near.min_by(|&a, &b| off(a).total_cmp(&off(b))).into_iter().collect()
    }

    /// The approaches that a name means.
    fn arms(&self, name: &ApproachName) -> Vec<usize> {
        if let ApproachName::Compass(side) = name {
            return self.on_side(side);
        }
        let ids = ids(name);
        let mut arms: Vec<usize> = Vec::new();
        for movement in self.movements {
            if ids.iter().any(|&id| self.starts_at(movement, &ApproachName::Id(id))) {
                arms.push(movement.from);
            }
            let after = self.map.followers(movement.lane).iter();
            if after.copied().any(|lane| ids.contains(&self.map.lanes[lane].id.0)) {
                arms.push(movement.to);
            }
        }
        arms.sort_unstable();
        arms.dedup();
        arms
    }
}

impl MapIndex<'_> {
    /// The entries of the settings that speak of an intersection, by position.
    pub fn entries_of(&self, intersection: usize) -> &[usize] {
        &self.named[intersection]
    }

    /// The movements of an intersection that a name means as one whose signal changes, by position.
    pub fn movements_named(&self, intersection: usize, name: &ApproachName) -> Vec<usize> {
        let movements = &self.traffic[intersection].movements;
        let named = UserNames::new(self, &self.intersections[intersection], intersection, movements);
        (0..movements.len()).filter(|&x| named.starts_at(&movements[x], name)).collect()
    }

    /// An approach in words: its side, and where another approach lies on the same side the id of a lanelet by which `lanewright.toml` can
    /// name it: one that leads in (`inward`) or out.
    pub fn approach_name(&self, intersection: &Intersection, arm: usize, inward: bool) -> String {
        let Some(own) = intersection.arms.get(arm) else { return String::new() };
        let side = own.compass;
        if intersection.arms.iter().filter(|other| other.compass == side).count() < 2 {
            return format!("{side} approach");
        }
        let edges = own.edges.iter().filter(|edge| edge.inward == inward).chain(&own.edges);
        let inside = edges.filter_map(|edge| Some((edge.inward, *edge.lanes.first()?))).next();
        let name = inside.map(|(inward, lane)| {
            let outside = if inward { self.predecessors(lane) } else { self.followers(lane) };
            self.lanes[outside.first().copied().unwrap_or(lane)].id
        });
        name.map_or_else(|| format!("{side} approach"), |id| format!("{side} approach (lanelet {id})"))
    }

    /// The approaches of an intersection that a name means, by position.
    pub fn approaches_named(&self, intersection: usize, name: &ApproachName) -> Vec<usize> {
        let movements = &self.traffic[intersection].movements;
        UserNames::new(self, &self.intersections[intersection], intersection, movements).arms(name)
    }
}

/// The ids that a name lists; none if it is a side.
fn ids(name: &ApproachName) -> &[i64] {
    match name {
        ApproachName::Compass(_) => &[],
        ApproachName::Ids(ids) => ids,
        ApproachName::Id(id) => std::slice::from_ref(id),
    }
}
