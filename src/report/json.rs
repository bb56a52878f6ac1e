//! The report for other programs. Its shape is `docs/report.schema.json`; [`SCHEMA_VERSION`] grows when a reader of the
//! old shape would no longer understand it.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use super::{Entry, Report, TOOL, Totals, VERSION, split_code};
use crate::diagnostic::{Fix, Measure, Place, Severity, Subject};

/// Version of the report's shape.
pub const SCHEMA_VERSION: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    schema_version: u32,
    tool: Tool,
    files: Vec<&'a str>,
    totals: DocumentTotals,
    rules: Vec<Rule<'a>>,
    findings: Vec<Finding<'a>>,
}

#[derive(Serialize)]
struct Tool {
    name: &'static str,
    version: &'static str,
}

#[derive(Serialize)]
struct DocumentTotals {
    error: usize,
    warning: usize,
    info: usize,
    /// Findings in `findings`; fewer than were found where a code has more than the cap.
    shown: usize,
    suppressed: usize,
    baseline: usize,
    cap_per_code: Option<usize>,
    codes: Vec<Code>,
}

#[derive(Serialize)]
struct Code {
    code: String,
    severity: Severity,
    count: usize,
    shown: usize,
}

#[derive(Serialize)]
struct Rule<'a> {
    id: &'a str,
    title: &'a str,
    category: &'a str,
    check: crate::requirement::Check,
    source: &'a str,
}

#[derive(Serialize)]
struct Finding<'a> {
    code: &'a str,
    rule: &'a str,
    slug: &'a str,
    severity: Severity,
    primitive: Primitive,
    referrers: Vec<Primitive>,
    related: Vec<Part>,
    position: Option<Coordinates>,
    source: Option<Source<'a>>,
    place: Option<FindingShape>,
    measure: Option<Measure>,
    message: &'a str,
    help: Option<&'a str>,
    fix: Option<&'a Fix>,
    fingerprint: &'a str,
}

#[derive(Serialize)]
struct Primitive {
    kind: &'static str,
    id: Option<i64>,
}

impl From<Subject> for Primitive {
    fn from(subject: Subject) -> Self {
        Self { kind: subject.kind(), id: subject.id() }
    }
}

#[derive(Serialize)]
struct Part {
    part: &'static str,
    kind: &'static str,
    id: Option<i64>,
}

#[derive(Serialize)]
struct Coordinates {
    lat: Option<f64>,
    lon: Option<f64>,
    x: Option<f64>,
    y: Option<f64>,
}

#[derive(Serialize)]
struct Source<'a> {
    file: &'a str,
    line: usize,
    column: usize,
}

/// In local metres, east and north.
#[derive(Serialize)]
struct FindingShape {
    kind: &'static str,
    points: Vec<[f64; 2]>,
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
pub fn value(report: &Report<'_>) -> serde_json::Result<serde_json::Value> {
    serde_json::to_value(document(report, &report.entries()))
}

fn document<'a>(report: &'a Report<'a>, entries: &'a [Entry<'a>]) -> Document<'a> {
    let referrers = report.referrers();
    let mut shown: BTreeMap<&str, usize> = BTreeMap::new();
    let mut findings = Vec::new();
    for entry in entries {
        let count = shown.entry(&entry.diagnostic.code).or_default();
        if report.cap.is_some_and(|cap| *count >= cap) {
            continue;
        }
        *count += 1;
        findings.push(finding(entry, referrers.chain(report.map, entry.subject())));
    }
    let totals = Totals::of(report.diagnostics);
    Document {
        schema_version: SCHEMA_VERSION,
        tool: Tool { name: TOOL, version: VERSION },
        files: report.sources.names().collect(),
        totals: DocumentTotals {
            error: totals.errors,
            warning: totals.warnings,
            info: totals.infos,
            shown: findings.len(),
            suppressed: report.suppressed,
            baseline: report.known,
            cap_per_code: report.cap,
            codes: totals
                .codes
                .into_iter()
                .map(|total| {
                    let shown = shown.get(total.code.as_str()).copied().unwrap_or(0);
                    Code { code: total.code, severity: total.severity, count: total.count, shown }
                })
                .collect(),
        },
        rules: report
            .requirements
            .iter()
            .map(|requirement| Rule {
                id: &requirement.id,
                title: &requirement.title,
                category: &requirement.category,
                check: requirement.check,
                source: &requirement.source,
            })
            .collect(),
        findings,
    }
}

fn finding<'a>(entry: &'a Entry<'a>, referrers: Vec<Subject>) -> Finding<'a> {
    let diagnostic = entry.diagnostic;
    let (rule, slug) = split_code(&diagnostic.code);
    let (globe, plane) = (diagnostic.lonlat, diagnostic.local);
    let known = globe.is_some() || plane.is_some();
    Finding {
        code: &diagnostic.code,
        rule,
        slug,
        severity: diagnostic.severity,
        primitive: entry.subject().into(),
        referrers: referrers.into_iter().map(Primitive::from).collect(),
        related: diagnostic
            .finding
            .related
            .iter()
            .map(|related| Part { part: related.part, kind: related.subject.kind(), id: related.subject.id() })
            .collect(),
        position: known.then(|| Coordinates {
            lat: globe.map(|at| at.lat),
            lon: globe.map(|at| at.lon),
            x: plane.map(|at| at.x),
            y: plane.map(|at| at.y),
        }),
        source: entry.position.map(|at| Source { file: at.name, line: at.line, column: at.column }),
        place: shape(&diagnostic.finding.place),
        measure: diagnostic.finding.measure,
        message: &diagnostic.finding.message,
        help: diagnostic.help.as_deref(),
        fix: diagnostic.finding.fix.as_ref(),
        fingerprint: &entry.fingerprint,
    }
}

fn shape(place: &Place) -> Option<FindingShape> {
    let (kind, points) = match place {
        Place::Unknown => return None,
        Place::Point(point) => ("point", std::slice::from_ref(point)),
        Place::Line(points) => ("line", points.as_slice()),
        Place::Polygon(ring) => ("polygon", ring.as_slice()),
    };
    Some(FindingShape { kind, points: points.iter().map(|point| [point.x, point.y]).collect() })
}
