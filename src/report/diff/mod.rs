//! What changed between two versions of a map, by element and by meaning. Elements are the same if their ids are.

mod document;
mod fact;
mod facts;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

pub use document::requirement;
pub use fact::{Fact, Sign};

use crate::diagnostic::{Place, Subject};
use crate::lanelet::locate::locate;
use crate::lanelet::{LaneletMap, Primitive, PrimitiveLayer};
use crate::projection::LonLat;

use facts::Sides;

/// Whether an element is in both maps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// In the new map only.
    Added,
    /// In the old map only.
    Removed,
    /// In both, but not the same.
    Changed,
}

/// One element that is not the same in both maps.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The element.
    pub subject: Subject,
    /// In which map it is.
    pub change: Kind,
    /// What is different, for an element that is in both; what it is, for one that is not.
    pub facts: Vec<Fact>,
    /// Where it lies, in the old map if it is only there.
    pub at: Option<LonLat>,
    /// Its shape in metres, where the new map does not have it.
    #[serde(skip)]
    pub place: Place,
}

/// How many elements of a kind differ.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Count {
    /// In the new map only.
    pub added: usize,
    /// In the old map only.
    pub removed: usize,
    /// In both, but not the same.
    pub changed: usize,
    /// In both, and the same.
    pub same: usize,
}

/// What changed. Serialises as `diff --format json` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Diff {
    /// By kind of element.
    pub totals: BTreeMap<&'static str, Count>,
    /// Lanelets, regulatory elements, areas, polygons, linestrings, points; each in the order of ids.
    pub changes: Vec<Change>,
}

impl Diff {
    /// Compares two maps whose metres are those of the same projection. What lies within `tolerance`, metres, of where it
    /// was has not moved.
    pub fn between(old: &LaneletMap, new: &LaneletMap, tolerance: f64) -> Self {
        let sides = Sides::new(old, new, tolerance);
        let mut diff = Self { totals: BTreeMap::new(), changes: Vec::new() };
        diff.layer("lanelets", &old.lanelets, &new.lanelets, &sides);
        diff.layer("regulatory elements", &old.regulatory_elements, &new.regulatory_elements, &sides);
        diff.layer("areas", &old.areas, &new.areas, &sides);
        diff.layer("polygons", &old.polygons, &new.polygons, &sides);
        diff.layer("linestrings", &old.linestrings, &new.linestrings, &sides);
        diff.layer("points", &old.points, &new.points, &sides);
        diff
    }

    fn layer<T: Primitive + facts::Compared>(
        &mut self,
        name: &'static str,
        old: &PrimitiveLayer<T>,
        new: &PrimitiveLayer<T>,
        sides: &Sides<'_>,
    ) {
        let mut count = Count::default();
        let mut found = Vec::new();
        for item in old.iter() {
            match new.get(item.id()) {
                None => {
                    count.removed += 1;
                    found.push(change(sides.old, item, Kind::Removed, item.alone(sides.old)));
                }
                Some(now) => {
                    let mut facts = Vec::new();
                    item.compare(now, sides, &mut facts);
                    if facts.is_empty() {
                        count.same += 1;
                    } else {
                        count.changed += 1;
                        found.push(change(sides.new, now, Kind::Changed, facts));
                    }
                }
            }
        }
        for item in new.iter().filter(|item| !old.contains(item.id())) {
            count.added += 1;
            found.push(change(sides.new, item, Kind::Added, item.alone(sides.new)));
        }
        found.sort_by_key(|change| change.subject);
        self.changes.extend(found);
        self.totals.insert(name, count);
    }

    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.changes.is_empty()
    }

    /// For people: totals, then a line for every element but points, which are summed up.
    pub fn text(&self) -> String {
        let mut text = String::new();
        // Writing to a string cannot fail.
        for (name, count) in &self.totals {
            let Count { added, removed, changed, same } = count;
            if added + removed + changed > 0 {
                let _ = writeln!(text, "{name}: {added} added, {removed} removed, {changed} changed, {same} the same");
            }
        }
        if self.is_empty() {
            text.push_str("no difference\n");
        }
        let moved = self.changes.iter().filter(|change| matches!(change.subject, Subject::Point(_)));
        let moved = moved.filter_map(|change| Some((change.facts.iter().find_map(Fact::metres)?, change.subject)));
        if let Some((by, point)) = moved.max_by(|a, b| a.0.total_cmp(&b.0)) {
            let _ = writeln!(text, "the point that moved most: {point}, by {by:.3} m");
        }
        for change in self.changes.iter().filter(|change| !matches!(change.subject, Subject::Point(_))) {
            let _ = writeln!(text, "{}", change.line());
        }
        text
    }
}

impl Change {
    /// One line: sign, element, what is different, where.
    pub fn line(&self) -> String {
        let sign = match self.change {
            Kind::Added => '+',
            Kind::Removed => '-',
            Kind::Changed => '~',
        };
        let facts: Vec<String> = self.facts.iter().map(ToString::to_string).collect();
        let place = self.at.map_or_else(String::new, |at| format!(" (at {:.7}, {:.7})", at.lat, at.lon));
        format!("{sign} {}: {}{place}", self.subject, facts.join("; "))
    }
}

fn change<T: facts::Compared>(map: &LaneletMap, item: &T, change: Kind, facts: Vec<Fact>) -> Change {
    let subject = item.subject();
    let place = if change == Kind::Removed { item.shape(map) } else { Place::Unknown };
    Change { subject, change, facts, at: locate(map, subject, &Place::Unknown).lonlat, place }
}
