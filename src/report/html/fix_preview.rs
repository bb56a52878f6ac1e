//! What a map would look like mended: the primitives that fixes would change, each with its shape afterwards.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::{Value, json};

use super::data::{kind, relative};
use super::plane::Frame;
use crate::diagnostic::{Diagnostic, Edit, Subject};
use crate::geometry::Point;
use crate::lanelet::{AreaId, LaneletId, LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElementId, Target};
use crate::report::diff::{Diff, Kind};

/// What is within this of where it was, metres, has not moved.
const STILL: f64 = 0.001;

/// A primitive that fixes would change.
#[derive(Clone, Debug, PartialEq)]
pub struct FixPreview {
    /// The primitive.
    pub subject: Subject,
    /// Whether it would come, go or change.
    pub change: Kind,
    /// What would be different.
    pub facts: Vec<String>,
    /// Lines and closed rings in the map's metres: the mended shape, or the shape that would go.
    pub shape: Vec<(bool, Vec<Point>)>,
    /// The findings that it mends, by their number in the report.
    pub mends: Vec<usize>,
}

/// What is different between a map and the map mended by the fixes of some of its findings (`done`, by number).
pub fn fix_previews(map: &LaneletMap, mended: &LaneletMap, findings: &[Diagnostic], done: &[usize]) -> Vec<FixPreview> {
    let changes = Diff::between(map, mended, STILL).changes;
    let causes = Causes::of(map, findings, done);
    let seen = changes.into_iter().filter(|change| !matches!(change.subject, Subject::Point(_)));
    seen.map(|change| FixPreview {
        subject: change.subject,
        change: change.change,
        facts: change.facts.iter().map(ToString::to_string).collect(),
        shape: shape_of(if change.change == Kind::Removed { map } else { mended }, change.subject),
        mends: causes.by(map, change.subject, change.change),
    })
    .collect()
}

/// Which findings' fixes reach for what.
#[derive(Default)]
struct Causes {
    subjects: BTreeMap<Subject, BTreeSet<usize>>,
    points: BTreeMap<i64, BTreeSet<usize>>,
    /// Fixes that make an element: its id is not known before.
    makers: BTreeSet<usize>,
}

impl Causes {
    fn of(map: &LaneletMap, findings: &[Diagnostic], done: &[usize]) -> Self {
        let mut causes = Self::default();
        let edits = done.iter().filter_map(|&i| Some((i, findings.get(i)?.finding.fix.as_ref()?)));
        for (i, edit) in edits.flat_map(|(i, fix)| fix.edits.iter().map(move |edit| (i, edit))) {
            let mut reach = |subject| causes.subjects.entry(subject).or_default().insert(i);
            match edit {
                Edit::SetTag { on, .. }
                | Edit::RemoveTag { on, .. }
                | Edit::AddMember { on, .. }
                | Edit::RemoveMember { on, .. }
                | Edit::SetRole { on, .. }
                | Edit::InsertVertex { way: on, .. }
                | Edit::RemoveVertex { way: on, .. }
                | Edit::SetVertices { way: on, .. } => _ = reach(alike(map, *on)),
                Edit::ReverseWay { way } => _ = reach(alike(map, *way)),
                Edit::ReplaceWay { lanelet, .. } => _ = reach(Subject::Lanelet(*lanelet)),
                Edit::SetPlace { point, .. } | Edit::PlaceBetween { point, .. } => {
                    _ = causes.points.entry(*point).or_default().insert(i)
                }
                Edit::SetFormatVersion { .. } => {}
                Edit::RemoveRepeat { on, .. } | Edit::Renumber { on, .. } => _ = reach(alike(map, *on)),
                Edit::Remove { subject } => _ = reach(alike(map, *subject)),
                Edit::MergePoints { from, to } => {
                    for point in [from, to] {
                        causes.points.entry(*point).or_default().insert(i);
                    }
                }
                Edit::CreateStopLine { element, .. } => {
                    reach(*element);
                    causes.makers.insert(i);
                }
                Edit::CreateRegulatoryElement { referrers: named, .. }
                | Edit::CreateMarking { lanelets: named, .. }
                | Edit::CreateArea { lanelets: named, .. } => {
                    named.iter().for_each(|id| _ = reach(Subject::Lanelet(*id)));
                    causes.makers.insert(i);
                }
                Edit::CreateOpposite { lanelet, .. } => {
                    reach(Subject::Lanelet(*lanelet));
                    causes.makers.insert(i);
                }
                Edit::Divide(division) => {
                    division.lanelets.iter().for_each(|cut| _ = reach(Subject::Lanelet(cut.lanelet)));
                    division.ways.iter().for_each(|cut| _ = reach(Subject::LineString(cut.way)));
                    causes.makers.insert(i);
                }
            }
        }
        causes
    }

    fn by(&self, map: &LaneletMap, subject: Subject, change: Kind) -> Vec<usize> {
        let mut found = self.subjects.get(&subject).cloned().unwrap_or_default();
        let points = match subject {
            Subject::LineString(id) => map.linestrings.get(LineStringId(id)).map(|line| &line.points),
            Subject::Polygon(id) => map.polygons.get(PolygonId(id)).map(|polygon| &polygon.points),
            _ => None,
        };
        found.extend(points.into_iter().flatten().filter_map(|point| self.points.get(&point.0)).flatten());
        if change == Kind::Added
            && matches!(
                subject,
                Subject::RegulatoryElement(_) | Subject::Polygon(_) | Subject::LineString(_) | Subject::Lanelet(_)
            )
        {
            found.extend(&self.makers);
        }
        found.into_iter().collect()
    }
}

/// A subject in the words of the map: fixes of what the file says speak of ways and relations.
fn alike(map: &LaneletMap, subject: Subject) -> Subject {
    match subject {
        Subject::Node(id) => Subject::Point(id),
        Subject::Way(id) if map.polygons.contains(PolygonId(id)) => Subject::Polygon(id),
        Subject::Way(id) => Subject::LineString(id),
        Subject::Relation(id) if map.areas.contains(AreaId(id)) => subject,
        Subject::Relation(id) if map.lanelets.contains(LaneletId(id)) => Subject::Lanelet(id),
        Subject::Relation(id) => Subject::RegulatoryElement(id),
        other => other,
    }
}

/// Lines and rings that show a primitive.
pub fn shape_of(map: &LaneletMap, subject: Subject) -> Vec<(bool, Vec<Point>)> {
    let places = |points: &[PointId]| -> Vec<Point> {
        points.iter().filter_map(|&id| map.points.get(id)).map(|point| point.position).collect()
    };
    let one = match subject {
        Subject::Lanelet(id) => map.lanelets.get(LaneletId(id)).map(|lanelet| (true, map.outline(lanelet))),
        Subject::LineString(id) => map.linestrings.get(LineStringId(id)).map(|line| (false, places(&line.points))),
        Subject::Polygon(id) => map.polygons.get(PolygonId(id)).map(|polygon| (true, places(&polygon.points))),
        Subject::Relation(id) => map.areas.get(AreaId(id)).map(|area| (true, places(&area.points))),
        Subject::RegulatoryElement(id) => {
            let members = map.regulatory_elements.get(RegulatoryElementId(id)).map(|element| &element.members);
            let of = |target| match target {
                Target::Point(_) => Vec::new(),
                Target::LineString(id) => shape_of(map, Subject::LineString(id.0)),
                Target::Polygon(id) => shape_of(map, Subject::Polygon(id.0)),
                Target::Lanelet(id) => shape_of(map, Subject::Lanelet(id.0)),
            };
            return members.into_iter().flatten().flat_map(|member| of(member.target)).collect();
        }
        _ => None,
    };
    one.into_iter().collect()
}

/// Previews of fixes as the page reads them.
pub fn page_fix_previews(previews: &[FixPreview], frame: &Frame) -> Value {
    let one = |preview: &FixPreview| {
        let shape: Vec<(bool, Vec<[f64; 2]>)> = preview
            .shape
            .iter()
            .map(|(closed, points)| (*closed, points.iter().map(|p| relative(*p, frame)).collect()))
            .collect();
        json!({
            "subject": [kind(preview.subject), preview.subject.id().map(|id| id.to_string())],
            "change": preview.change,
            "facts": preview.facts,
            "shape": shape,
            "mends": preview.mends,
        })
    };
    previews.iter().map(one).collect()
}
