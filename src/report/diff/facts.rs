//! What is different about two elements of the same id.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use super::fact::{Fact, Sign};
use crate::diagnostic::{Place, Subject};
use crate::geometry::line_index::LineIndex;
use crate::geometry::{Point as PlanePoint, Polyline};
use crate::lanelet::{
    Area, Attributes, Bound, Lanelet, LaneletId, LaneletMap, LineString, Point, PointId, Polygon, RegulatoryElement,
    Target,
};

/// The two maps and what is asked of them more than once.
pub struct Sides<'a> {
    pub old: &'a LaneletMap,
    pub new: &'a LaneletMap,
    tolerance: f64,
    relations: [Relations; 2],
}

/// Which lanelet leads into which, and has right of way over which.
#[derive(Default)]
struct Relations {
    leads_to: FxHashMap<LaneletId, BTreeSet<i64>>,
    over: FxHashMap<LaneletId, BTreeSet<i64>>,
}

impl Relations {
    fn of(map: &LaneletMap) -> Self {
        let mut found = Self::default();
        let ends = |lanelet: &Lanelet, last: bool| -> Option<[PointId; 2]> {
            let end = |bound: Bound| {
                let points = &map.linestrings.get(bound.line)?.points;
                if bound.inverted == last { points.first().copied() } else { points.last().copied() }
            };
            Some([end(lanelet.left)?, end(lanelet.right)?])
        };
        let mut starting: FxHashMap<[PointId; 2], Vec<i64>> = FxHashMap::default();
        for lanelet in map.lanelets.iter() {
            if let Some(start) = ends(lanelet, false) {
                starting.entry(start).or_default().push(lanelet.id.0);
            }
        }
        for lanelet in map.lanelets.iter() {
            if let Some(next) = ends(lanelet, true).and_then(|end| starting.get(&end)) {
                found.leads_to.insert(lanelet.id, next.iter().copied().collect());
            }
        }
        for element in map.regulatory_elements.iter().filter(|element| element.subtype == "right_of_way") {
            for lanelet in element.lanelets("right_of_way") {
                found.over.entry(lanelet).or_default().extend(element.lanelets("yield").map(|id| id.0));
            }
        }
        found
    }
}

impl<'a> Sides<'a> {
    pub fn new(old: &'a LaneletMap, new: &'a LaneletMap, tolerance: f64) -> Self {
        Self { old, new, tolerance, relations: [Relations::of(old), Relations::of(new)] }
    }

    /// How far two outlines are apart, as far as that is more than the tolerance.
    fn moved(&self, old: &[PlanePoint], new: &[PlanePoint]) -> Option<Fact> {
        let by = apart(old, new).into_iter().fold(0.0, f64::max);
        (by > self.tolerance).then_some(Fact::Moved { by })
    }

    /// The same of lines, which may also have become longer or shorter at their ends: `lengths` are those of the old and the new one. A
    /// line that was cut has not moved.
    fn moved_or_cut(&self, [old, new]: [&[PlanePoint]; 2], lengths: [f64; 2], facts: &mut Vec<Fact>) {
        let [to_old, to_new] = apart(old, new);
        let (least, most) = (to_old.min(to_new), to_old.max(to_new));
        let longer = lengths[1] - lengths[0];
        // What lies beyond the other's end is farther from it than all the rest, and no farther than it is longer.
        let is_cut = most > BEYOND * least
            && most <= longer.abs() + least + self.tolerance
            && (longer > 0.0) == (to_old > to_new);
        if is_cut && longer.abs() > self.tolerance {
            facts.push(Fact::Longer { by: longer });
        }
        let by = if is_cut { least } else { most };
        if by > self.tolerance {
            facts.push(Fact::Moved { by });
        }
    }
}

/// A line goes on beyond the other's end if it is this many times farther from there than anywhere else.
const BEYOND: f64 = 4.0;

/// The largest distance of a vertex of the new line from the old one, and the other way round.
fn apart(old: &[PlanePoint], new: &[PlanePoint]) -> [f64; 2] {
    if old == new {
        return [0.0; 2];
    }
    let farthest = |from: &[PlanePoint], to: &[PlanePoint]| {
        let line = Polyline::new(to.iter().copied());
        let index = line.as_ref().map(LineIndex::new);
        let distance = |p: &PlanePoint| match (&index, to.first()) {
            (Some(line), _) => line.distance(*p),
            (None, Some(only)) => (p - only).norm(),
            (None, None) => 0.0,
        };
        from.iter().map(distance).fold(0.0, f64::max)
    };
    [farthest(new, old), farthest(old, new)]
}

fn length(line: &[PlanePoint]) -> f64 {
    Polyline::new(line.iter().copied()).map_or(0.0, |line| line.length())
}

/// What two versions of an element are compared by.
pub trait Compared {
    fn subject(&self) -> Subject;
    /// What it is, for an element that has no counterpart.
    fn alone(&self, map: &LaneletMap) -> Vec<Fact>;
    /// Adds what is different in `new`.
    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>);
    fn shape(&self, map: &LaneletMap) -> Place;
}

fn is(attributes: &Attributes, length: Option<f64>) -> Vec<Fact> {
    let words = ["type", "subtype"]
        .map(|key| attributes.get(key).filter(|value| !matches!(*value, "lanelet" | "regulatory_element")));
    let what: Vec<&str> = words.into_iter().flatten().collect();
    let what = if what.is_empty() { "without a type".to_owned() } else { what.join(" ") };
    vec![Fact::Is { what, length }]
}

fn tags(old: &Attributes, new: &Attributes, facts: &mut Vec<Fact>) {
    let of = |tags: &Attributes| -> BTreeMap<String, String> {
        tags.iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect()
    };
    if old == new {
        return;
    }
    let (old, new) = (of(old), of(new));
    let keys: BTreeSet<&String> = old.keys().chain(new.keys()).collect();
    for key in keys {
        let (old, new) = (old.get(key), new.get(key));
        if old != new {
            facts.push(Fact::Tag { key: key.clone(), old: old.cloned(), new: new.cloned() });
        }
    }
}

/// What `new` has more, then what it lacks.
fn sets<T: Ord + Clone>(old: &BTreeSet<T>, new: &BTreeSet<T>, fact: impl Fn(Sign, T) -> Fact, facts: &mut Vec<Fact>) {
    facts.extend(new.difference(old).map(|one| fact(Sign::Added, one.clone())));
    facts.extend(old.difference(new).map(|one| fact(Sign::Removed, one.clone())));
}

fn places(map: &LaneletMap, points: &[PointId]) -> Vec<PlanePoint> {
    points.iter().filter_map(|&id| map.points.get(id)).map(|point| point.position).collect()
}

/// The line of points of a linestring.
fn line(old: &[PointId], new: &[PointId], sides: &Sides<'_>, facts: &mut Vec<Fact>) {
    other_points(old, new, facts);
    let [old, new] = [places(sides.old, old), places(sides.new, new)];
    sides.moved_or_cut([&old, &new], [length(&old), length(&new)], facts);
}

/// The outline of a polygon or an area.
fn outline(old: &[PointId], new: &[PointId], sides: &Sides<'_>, facts: &mut Vec<Fact>) {
    other_points(old, new, facts);
    facts.extend(sides.moved(&places(sides.old, old), &places(sides.new, new)));
}

fn other_points(old: &[PointId], new: &[PointId], facts: &mut Vec<Fact>) {
    if old != new {
        let [before, after]: [BTreeSet<PointId>; 2] = [old, new].map(|ids| ids.iter().copied().collect());
        let (added, removed) = (after.difference(&before).count(), before.difference(&after).count());
        facts.push(Fact::Points { added, removed });
    }
}

impl Compared for Point {
    fn subject(&self) -> Subject {
        Subject::Point(self.id.0)
    }

    fn alone(&self, _: &LaneletMap) -> Vec<Fact> {
        Vec::new()
    }

    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>) {
        let by = (new.position - self.position).norm();
        if by > sides.tolerance {
            facts.push(Fact::Moved { by });
        }
        let raised = new.ele().unwrap_or(0.0) - self.ele().unwrap_or(0.0);
        if raised.abs() > sides.tolerance {
            facts.push(Fact::Raised { by: raised });
        }
        tags(self.attributes(), new.attributes(), facts);
    }

    fn shape(&self, _: &LaneletMap) -> Place {
        Place::Point(self.position)
    }
}

impl Compared for LineString {
    fn subject(&self) -> Subject {
        Subject::LineString(self.id.0)
    }

    fn alone(&self, map: &LaneletMap) -> Vec<Fact> {
        is(&self.attributes, Polyline::new(places(map, &self.points)).map(|line| line.length()))
    }

    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>) {
        line(&self.points, &new.points, sides, facts);
        tags(&self.attributes, &new.attributes, facts);
    }

    fn shape(&self, map: &LaneletMap) -> Place {
        Place::Line(places(map, &self.points))
    }
}

impl Compared for Polygon {
    fn subject(&self) -> Subject {
        Subject::Polygon(self.id.0)
    }

    fn alone(&self, _: &LaneletMap) -> Vec<Fact> {
        is(&self.attributes, None)
    }

    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>) {
        outline(&self.points, &new.points, sides, facts);
        tags(&self.attributes, &new.attributes, facts);
    }

    fn shape(&self, map: &LaneletMap) -> Place {
        Place::Polygon(places(map, &self.points))
    }
}

impl Compared for Area {
    fn subject(&self) -> Subject {
        Subject::Relation(self.id.0)
    }

    fn alone(&self, _: &LaneletMap) -> Vec<Fact> {
        is(&self.attributes, None)
    }

    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>) {
        let lines = |area: &Self| -> BTreeSet<(String, Subject)> {
            area.outer.iter().map(|bound| ("outer".to_owned(), Subject::LineString(bound.line.0))).collect()
        };
        sets(&lines(self), &lines(new), |sign, (role, member)| Fact::Member { sign, role, member }, facts);
        outline(&self.points, &new.points, sides, facts);
        tags(&self.attributes, &new.attributes, facts);
    }

    fn shape(&self, map: &LaneletMap) -> Place {
        Place::Polygon(places(map, &self.points))
    }
}

/// The mean of a lanelet's bounds.
fn lanelet_length(map: &LaneletMap, lanelet: &Lanelet) -> f64 {
    let bound = |bound| Polyline::new(map.bound_line(bound)).map_or(0.0, |line| line.length());
    f64::midpoint(bound(lanelet.left), bound(lanelet.right))
}

impl Compared for Lanelet {
    fn subject(&self) -> Subject {
        Subject::Lanelet(self.id.0)
    }

    fn alone(&self, map: &LaneletMap) -> Vec<Fact> {
        is(&self.attributes, Some(lanelet_length(map, self)))
    }

    fn compare(&self, new: &Self, sides: &Sides<'_>, facts: &mut Vec<Fact>) {
        for (side, old, new) in [("left", self.left, new.left), ("right", self.right, new.right)] {
            if old.line != new.line {
                facts.push(Fact::Bound { side, old: old.line.0, new: new.line.0 });
            } else if old.inverted != new.inverted {
                facts.push(Fact::TurnedAround { side });
            }
        }
        let outlines = [sides.old.outline(self), sides.new.outline(new)];
        let lengths = [lanelet_length(sides.old, self), lanelet_length(sides.new, new)];
        sides.moved_or_cut([&outlines[0], &outlines[1]], lengths, facts);
        let elements =
            |lanelet: &Self| -> BTreeSet<i64> { lanelet.regulatory_elements.iter().map(|id| id.0).collect() };
        sets(&elements(self), &elements(new), |sign, id| Fact::Element { sign, id }, facts);
        let [old_side, new_side] = &sides.relations;
        let of = |of_all: &FxHashMap<LaneletId, BTreeSet<i64>>| of_all.get(&self.id).cloned().unwrap_or_default();
        sets(&of(&old_side.leads_to), &of(&new_side.leads_to), |sign, id| Fact::LeadsTo { sign, id }, facts);
        sets(&of(&old_side.over), &of(&new_side.over), |sign, over| Fact::RightOfWay { sign, over }, facts);
        tags(&self.attributes, &new.attributes, facts);
    }

    fn shape(&self, map: &LaneletMap) -> Place {
        Place::Polygon(map.outline(self))
    }
}

impl Compared for RegulatoryElement {
    fn subject(&self) -> Subject {
        Subject::RegulatoryElement(self.id.0)
    }

    fn alone(&self, _: &LaneletMap) -> Vec<Fact> {
        is(&self.attributes, None)
    }

    fn compare(&self, new: &Self, _: &Sides<'_>, facts: &mut Vec<Fact>) {
        let members = |element: &Self| -> BTreeSet<(String, Subject)> {
            element.members.iter().map(|one| (one.role.to_string(), target(one.target))).collect()
        };
        let fact = |sign, (role, member)| Fact::Member { sign, role, member };
        sets(&members(self), &members(new), fact, facts);
        tags(&self.attributes, &new.attributes, facts);
    }

    fn shape(&self, map: &LaneletMap) -> Place {
        let lines = self.members.iter().filter_map(|member| match member.target {
            Target::LineString(id) => map.linestrings.get(id).map(|line| places(map, &line.points)),
            Target::Lanelet(id) => map.lanelets.get(id).map(|lanelet| map.outline(lanelet)),
            Target::Point(_) | Target::Polygon(_) => None,
        });
        lines.into_iter().next().map_or(Place::Unknown, Place::Line)
    }
}

fn target(target: Target) -> Subject {
    match target {
        Target::Point(id) => Subject::Point(id.0),
        Target::LineString(id) => Subject::LineString(id.0),
        Target::Polygon(id) => Subject::Polygon(id.0),
        Target::Lanelet(id) => Subject::Lanelet(id.0),
    }
}
