//! Which primitives lead to a primitive: a lanelet to its bound, a bound to its point.

use super::{LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElementId, Target};
use crate::diagnostic::Subject;

/// For every primitive the first one, in file order, that refers to it. Lanelets come before regulatory elements,
/// lines before polygons: the nearer to what is driven on, the sooner a reader knows the place.
#[derive(Debug)]
pub struct Referrers {
    points: Vec<Option<Subject>>,
    linestrings: Vec<Option<Subject>>,
    polygons: Vec<Option<Subject>>,
    regulatory_elements: Vec<Option<Subject>>,
}

/// Enters `referrer` if there is none yet.
fn enter(table: &mut [Option<Subject>], position: Option<usize>, referrer: Subject) {
    if let Some(slot) = position.and_then(|position| table.get_mut(position)) {
        slot.get_or_insert(referrer);
    }
}

impl Referrers {
    /// Looks through the whole map once.
    pub fn new(map: &LaneletMap) -> Self {
        let mut made = Self {
            points: vec![None; map.points.len()],
            linestrings: vec![None; map.linestrings.len()],
            polygons: vec![None; map.polygons.len()],
            regulatory_elements: vec![None; map.regulatory_elements.len()],
        };
        for lanelet in &map.lanelets {
            let by = Subject::Lanelet(lanelet.id.0);
            for line in [Some(lanelet.left.line), Some(lanelet.right.line), lanelet.centerline].into_iter().flatten() {
                enter(&mut made.linestrings, map.linestrings.position(line), by);
            }
            for &element in &lanelet.regulatory_elements {
                enter(&mut made.regulatory_elements, map.regulatory_elements.position(element), by);
            }
        }
        for element in &map.regulatory_elements {
            let by = Subject::RegulatoryElement(element.id.0);
            for member in &element.members {
                match member.target {
                    Target::Point(id) => enter(&mut made.points, map.points.position(id), by),
                    Target::LineString(id) => enter(&mut made.linestrings, map.linestrings.position(id), by),
                    Target::Polygon(id) => enter(&mut made.polygons, map.polygons.position(id), by),
                    Target::Lanelet(_) => {}
                }
            }
        }
        made.enter_points(map);
        made
    }

    /// Points of lines that a lanelet or an element uses first, then of the other lines, then of polygons.
    fn enter_points(&mut self, map: &LaneletMap) {
        for used in [true, false] {
            for (line, by) in map.linestrings.iter().zip(&self.linestrings) {
                if by.is_some() == used {
                    for &point in &line.points {
                        enter(&mut self.points, map.points.position(point), Subject::LineString(line.id.0));
                    }
                }
            }
        }
        for polygon in &map.polygons {
            for &point in &polygon.points {
                enter(&mut self.points, map.points.position(point), Subject::Polygon(polygon.id.0));
            }
        }
    }

    /// The chain that leads to a primitive, outermost first, without the primitive itself: for a point its lanelet and
    /// its way. Empty where nothing refers to it.
    pub fn chain(&self, map: &LaneletMap, subject: Subject) -> Vec<Subject> {
        let mut chain = Vec::new();
        let mut at = subject;
        // Every step goes to a higher kind of primitive, so the way up ends.
        while let Some(by) = self.first(map, at) {
            chain.push(by);
            at = by;
        }
        chain.reverse();
        chain
    }

    fn first(&self, map: &LaneletMap, subject: Subject) -> Option<Subject> {
        let (table, position) = match subject {
            Subject::Point(id) | Subject::Node(id) => (&self.points, map.points.position(PointId(id))),
            Subject::LineString(id) => (&self.linestrings, map.linestrings.position(LineStringId(id))),
            Subject::Polygon(id) => (&self.polygons, map.polygons.position(PolygonId(id))),
            Subject::RegulatoryElement(id) => {
                (&self.regulatory_elements, map.regulatory_elements.position(RegulatoryElementId(id)))
            }
            Subject::Map | Subject::Lanelet(_) | Subject::Way(_) | Subject::Relation(_) => return None,
        };
        table.get(position?).copied().flatten()
    }
}
