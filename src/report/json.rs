//! The report for other programs. Its shape is `docs/report.schema.json`; [`SCHEMA_VERSION`] grows when a reader of the
//! old shape would no longer understand it.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Serialize, Serializer};
use serde_json::{Value, json};

use super::{Entry, Report, TOOL, Totals, VERSION, split_code};
use crate::diagnostic::{Accepted, Place, Subject};

/// Version of the report's shape.
pub const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    tool: Value,
    files: Vec<&'a str>,
    totals: Value,
    rules: Vec<Value>,
    findings: Findings<'a>,
    accepted: Vec<Value>,
}

/// Findings that are made one by one as they are written.
struct Findings<'a> {
    report: &'a Report<'a>,
    entries: Vec<&'a Entry<'a>>,
}

impl Serialize for Findings<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (map, referrers) = (self.report.map, self.report.referrers());
        serializer.collect_seq(self.entries.iter().map(|entry| finding(entry, &referrers.chain(map, entry.subject()))))
    }
}

/// Writes the report, indented by two spaces.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let entries = report.entries();
    serde_json::to_writer_pretty(&mut *out, &document(report, &entries))?;
    writeln!(out)
}

/// The report as a value: what [`write()`] writes.
///
/// # Errors
///
/// Where JSON has no word for something, which would be a fault of ours.
pub fn value(report: &Report<'_>) -> serde_json::Result<Value> {
    serde_json::to_value(document(report, &report.entries()))
}

fn document<'a>(report: &'a Report<'a>, entries: &'a [Entry<'a>]) -> Document<'a> {
    let mut shown: BTreeMap<&str, usize> = BTreeMap::new();
    let mut findings = Findings { report, entries: Vec::new() };
    for entry in entries {
        let count = shown.entry(&entry.diagnostic.code).or_default();
        if report.cap.is_none_or(|cap| *count < cap) {
            *count += 1;
            findings.entries.push(entry);
        }
    }
    let totals = Totals::of(report.diagnostics);
    let codes: Vec<Value> = (totals.codes.iter())
        .map(|total| {
            let shown = shown.get(total.code.as_str()).copied().unwrap_or(0);
            json!({ "code": total.code, "severity": total.severity, "count": total.count, "shown": shown })
        })
        .collect();
    let rules = report.requirements.iter().map(|one| {
        json!({
            "id": one.id, "title": one.title, "subtitle": one.subtitle, "category": one.category, "check": one.check, "source": one.source,
        })
    });
    Document {
        schema_version: SCHEMA_VERSION,
        tool: json!({ "name": TOOL, "version": VERSION }),
        files: report.sources.names().collect(),
        totals: json!({
            "error": totals.errors,
            "warning": totals.warnings,
            "info": totals.infos,
            // Fewer than were found where a code has more than the cap.
            "shown": findings.entries.len(),
            "suppressed": report.suppressed,
            "baseline": report.known,
            "cap_per_code": report.cap,
            "codes": codes,
        }),
        rules: rules.collect(),
        findings,
        accepted: report.accepted.iter().map(accepted).collect(),
    }
}

/// A finding that is left out because somebody lets it be, with the reason.
fn accepted(one: &Accepted) -> Value {
    let (found, subject) = (&one.found, one.found.finding.subject);
    json!({
        "code": found.code,
        "severity": found.severity,
        "primitive": { "kind": subject.kind(), "id": subject.id() },
        "message": found.finding.message,
        "reason": one.reason,
    })
}

fn finding(entry: &Entry<'_>, referrers: &[Subject]) -> Value {
    let diagnostic = entry.diagnostic;
    let finding = &diagnostic.finding;
    let (rule, slug) = split_code(&diagnostic.code);
    let (globe, plane) = (diagnostic.lonlat, diagnostic.local);
    let position = json!({
        "lat": globe.map(|at| at.lat), "lon": globe.map(|at| at.lon), "x": plane.map(|at| at.x), "y": plane.map(|at| at.y),
    });
    let primitive = |one: &Subject| json!({ "kind": one.kind(), "id": one.id() });
    let related = finding.related.iter();
    let related = related.map(|one| json!({ "part": one.part, "kind": one.subject.kind(), "id": one.subject.id() }));
    json!({
        "code": diagnostic.code,
        "rule": rule,
        "slug": slug,
        "severity": diagnostic.severity,
        "primitive": primitive(&entry.subject()),
        "referrers": referrers.iter().map(primitive).collect::<Vec<_>>(),
        "related": related.collect::<Vec<_>>(),
        "position": (globe.is_some() || plane.is_some()).then_some(position),
        "source": entry.position.map(|at| json!({ "file": at.name, "line": at.line, "column": at.column })),
        "place": shape(&finding.place),
        "measure": finding.measure,
        "message": finding.message,
        "help": diagnostic.help,
        "fix": finding.fix,
        "fingerprint": entry.fingerprint,
    })
}

/// What to draw, in local metres, east and north.
fn shape(place: &Place) -> Option<Value> {
    let (kind, points) = match place {
        Place::Unknown => return None,
        Place::Point(point) => ("point", std::slice::from_ref(point)),
        Place::Line(points) => ("line", points.as_slice()),
        Place::Polygon(ring) => ("polygon", ring.as_slice()),
    };
    let points: Vec<[f64; 2]> = points.iter().map(|point| [point.x, point.y]).collect();
    Some(json!({ "kind": kind, "points": points }))
}
