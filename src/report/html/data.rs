//! Findings and requirements as the page reads them.

use serde::{Deserialize, Serialize};

use super::super::{Entry, Report, split_code};
use super::plane::Frame;
use crate::diagnostic::{Diagnostic, Measure, Place, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::{LaneletId, LaneletMap};
use crate::requirement::{Check, Requirement};

/// How a finding relates to an earlier report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// The earlier report did not have it.
    New,
    /// Both have it.
    Same,
    /// Only the earlier report had it.
    Gone,
}

/// A kind of primitive, and its id as text: JavaScript's numbers do not hold all of them.
pub type Named = (String, String);

/// A finding as the page, and a later comparison, reads it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PageFinding {
    /// Code and subject; unique in the report, and the same in the next report of a map with the same ids.
    pub key: String,
    /// As in [`Diagnostic`].
    pub code: String,
    /// As in [`Diagnostic`].
    pub severity: Severity,
    /// What is wrong.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
    /// What a machine would do.
    pub fix: Option<String>,
    /// Kind and id; `None` for the map as a whole.
    pub subject: Option<Named>,
    /// The others, each with its part.
    pub related: Vec<(Named, String)>,
    /// `point`, `line` or `polygon`, and x, y, x, y, … in metres from the frame's origin.
    pub place: Option<(String, Vec<f64>)>,
    /// Value, limit, unit.
    pub measure: Option<(f64, f64, String)>,
    /// Where the pin is, metres from the frame's origin.
    pub at: Option<[f64; 2]>,
    /// Latitude, longitude.
    pub latlon: Option<[f64; 2]>,
    /// Where the subject stands in the source.
    pub source: Option<String>,
    /// Only where the report was compared.
    pub status: Option<Status>,
}

/// The word for a kind of primitive in keys and in the page.
pub fn kind(subject: Subject) -> &'static str {
    match subject {
        Subject::RegulatoryElement(_) => "rule",
        Subject::LineString(_) => "line",
        other => other.kind(),
    }
}

fn named(subject: Subject) -> Option<Named> {
    subject.id().map(|id| (kind(subject).to_owned(), id.to_string()))
}

/// The findings in their order, each with a key of its own.
pub fn findings(entries: &[Entry<'_>], map: &LaneletMap, frame: &Frame) -> Vec<PageFinding> {
    let mut seen = rustc_hash::FxHashMap::<String, u32>::default();
    let key = |diagnostic: &Diagnostic| {
        let subject = diagnostic.finding.subject;
        let mut key = match subject.id() {
            Some(id) => format!("{}@{}-{id}", diagnostic.code, kind(subject)),
            None => diagnostic.code.clone(),
        };
        let count = seen.entry(key.clone()).or_default();
        *count += 1;
        if *count > 1 {
            key += &format!("~{count}");
        }
        key
    };
    let keys: Vec<String> = entries.iter().map(|entry| entry.diagnostic).map(key).collect();
    let source = |entry: &Entry<'_>| entry.position.map(|at| format!("{}:{}", at.name, at.line));
    entries.iter().zip(keys).map(|(entry, key)| finding(entry.diagnostic, key, map, frame, source(entry))).collect()
}

fn finding(
    diagnostic: &Diagnostic,
    key: String,
    map: &LaneletMap,
    frame: &Frame,
    source: Option<String>,
) -> PageFinding {
    let finding = &diagnostic.finding;
    let flat = |points: &[Point]| points.iter().flat_map(|p| relative(*p, frame)).collect::<Vec<f64>>();
    PageFinding {
        key,
        code: diagnostic.code.clone(),
        severity: diagnostic.severity,
        message: finding.message.clone(),
        help: diagnostic.help.clone(),
        fix: finding.fix.as_ref().map(|fix| fix.title.clone()),
        subject: named(finding.subject),
        related: finding.related.iter().filter_map(|r| Some((named(r.subject)?, r.part.to_owned()))).collect(),
        place: match &finding.place {
            Place::Unknown => None,
            Place::Point(p) => Some(("point".to_owned(), flat(&[*p]))),
            Place::Line(points) => Some(("line".to_owned(), flat(points))),
            Place::Polygon(ring) => Some(("polygon".to_owned(), flat(ring))),
        },
        measure: finding.measure.map(|Measure { value, limit, unit }| (value, limit, unit.to_owned())),
        at: spot(diagnostic, map).map(|p| relative(p, frame)).filter(|at| at.iter().all(|c| c.is_finite())),
        latlon: diagnostic.lonlat.map(|at| [at.lat, at.lon]),
        source,
        status: None,
    }
}

/// Metres from the origin, to the millimetre.
pub fn relative(p: Point, frame: &Frame) -> [f64; 2] {
    let millimetres = |v: f64| (v * 1000.0).round() / 1000.0;
    [millimetres(p.x - frame.origin.x), millimetres(p.y - frame.origin.y)]
}

/// Where the pin is. A bent lanelet's middle may lie beside it, so the pin is between its bounds' middle points.
fn spot(diagnostic: &Diagnostic, map: &LaneletMap) -> Option<Point> {
    let on_lanelet = match (diagnostic.finding.subject, &diagnostic.finding.place) {
        (Subject::Lanelet(id), Place::Unknown) => map.lanelets.get(LaneletId(id)).and_then(|lanelet| {
            let middle = |bound| {
                let line = map.bound_line(bound);
                line.get(line.len() / 2).copied()
            };
            Some(nalgebra::center(&middle(lanelet.left)?, &middle(lanelet.right)?))
        }),
        _ => None,
    };
    on_lanelet.or(diagnostic.local).or_else(|| match &diagnostic.finding.place {
        Place::Unknown => None,
        Place::Point(p) => Some(*p),
        Place::Line(points) => points.get(points.len() / 2).copied(),
        Place::Polygon(ring) => {
            let sum = ring.iter().fold(nalgebra::Vector2::zeros(), |sum, p| sum + p.coords);
            (!ring.is_empty()).then(|| Point::from(sum / ring.len() as f64))
        }
    })
}

/// How a requirement came out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum RequirementOutcome {
    /// No warning, no error.
    Passed,
    /// Warnings, no error.
    Warned,
    /// An error.
    Failed,
    /// Not run.
    Skipped,
    /// No program judges it.
    Eyes,
}

/// One line of the summary.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PageRequirement {
    /// `vm-03-08`, `load`.
    pub id: String,
    /// The standard's.
    pub title: String,
    /// What it asks for in plain words.
    pub subtitle: Option<String>,
    /// Whether it is one of Autoware's requirements.
    pub standard: bool,
    /// The chapter.
    pub category: String,
    /// How it came out.
    pub outcome: RequirementOutcome,
    /// Whether a program judges only a part of it.
    pub partial: bool,
    /// Whether the page has its document.
    pub documented: bool,
}

/// All requirements in the standard's order, then the families that no standard asks for.
pub fn requirements(all: &[&Requirement], report: &Report<'_>) -> Vec<PageRequirement> {
    let diagnostics = report.diagnostics;
    let mut worst: rustc_hash::FxHashMap<&str, Severity> = rustc_hash::FxHashMap::default();
    for one in diagnostics {
        let entry = worst.entry(split_code(&one.code).0).or_insert(one.severity);
        *entry = one.severity.max(*entry);
    }
    let outcome = |id: &str, otherwise| match worst.get(id) {
        Some(Severity::Error) => RequirementOutcome::Failed,
        Some(Severity::Warning) => RequirementOutcome::Warned,
        _ => otherwise,
    };
    let run = |id: &str| report.requirements.iter().any(|one| one.id == id);
    let mut lines: Vec<PageRequirement> = all
        .iter()
        .map(|requirement| {
            let unbroken = match requirement.check {
                Check::Manual => RequirementOutcome::Eyes,
                _ if run(&requirement.id) => RequirementOutcome::Passed,
                _ => RequirementOutcome::Skipped,
            };
            PageRequirement {
                id: requirement.id.clone(),
                title: requirement.title.clone(),
                subtitle: requirement.subtitle.clone(),
                standard: requirement.is_of_the_standard(),
                category: requirement.category.clone(),
                outcome: outcome(&requirement.id, unbroken),
                partial: requirement.check == Check::Partial,
                documented: true,
            }
        })
        .collect();
    lines.sort_by_key(|one| !one.standard);
    let mut families: Vec<&str> = diagnostics.iter().map(|d| split_code(&d.code).0).collect();
    families.sort_unstable();
    families.dedup();
    families.retain(|id| !all.iter().any(|one| one.id == *id));
    lines.extend(families.into_iter().map(|id| PageRequirement {
        id: id.to_owned(),
        title: title_of(id).to_owned(),
        subtitle: None,
        standard: false,
        category: "map health".to_owned(),
        outcome: outcome(id, RequirementOutcome::Passed),
        partial: false,
        documented: false,
    }));
    lines
}

fn title_of(family: &str) -> &str {
    match family {
        "load" => "Loads in Autoware",
        "ids" => "Ids",
        "node" => "Nodes",
        "topology" => "Topology",
        other => other,
    }
}
