//! SARIF 2.1.0, as code scanning services read it.
//!
//! GitHub keeps the first 5,000 results of a run and refuses more than 25,000, so the worst 5,000 are written and a
//! notification says how many were left out.

use std::io::{self, Write};

use rustc_hash::FxHashMap;
use serde::Serialize;

use super::{Entry, Position, Report, TOOL, VERSION, sentence, split_code};
use crate::diagnostic::{Severity, Subject};
use crate::lanelet::referrers::Referrers;
use crate::requirement::{Fault, Requirement};

/// Results that a code scanning service keeps.
pub const MAX_RESULTS: usize = 5_000;

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Log<'a> {
    #[serde(rename = "$schema")]
    schema: &'static str,
    version: &'static str,
    runs: [Run<'a>; 1],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Run<'a> {
    tool: Tool<'a>,
    invocations: [Invocation; 1],
    column_kind: &'static str,
    results: Vec<SarifResult<'a>>,
}

#[derive(Serialize)]
struct Tool<'a> {
    driver: Driver<'a>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Driver<'a> {
    name: &'static str,
    semantic_version: &'static str,
    rules: Vec<Rule<'a>>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Rule<'a> {
    id: &'a str,
    short_description: Text<'a>,
    #[serde(skip_serializing_if = "Option::is_none")]
    full_description: Option<Text<'a>>,
    help: Help,
    #[serde(skip_serializing_if = "Option::is_none")]
    help_uri: Option<&'a str>,
    default_configuration: Configuration,
    properties: RuleProperties<'a>,
}

#[derive(Serialize)]
struct Text<'a> {
    text: &'a str,
}

#[derive(Serialize)]
struct Help {
    text: String,
    markdown: String,
}

#[derive(Serialize)]
struct Configuration {
    level: &'static str,
}

#[derive(Serialize)]
struct RuleProperties<'a> {
    tags: Vec<&'a str>,
    #[serde(rename = "problem.severity")]
    severity: &'static str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Invocation {
    execution_successful: bool,
    tool_execution_notifications: Vec<Notification>,
}

#[derive(Serialize)]
struct Notification {
    level: &'static str,
    message: OwnText,
}

#[derive(Serialize)]
struct OwnText {
    text: String,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct SarifResult<'a> {
    rule_id: &'a str,
    rule_index: usize,
    level: &'static str,
    message: OwnText,
    locations: Vec<Location>,
    partial_fingerprints: Fingerprint<'a>,
    properties: ResultProperties<'a>,
}

/// The name says how a fingerprint is made; a change of that way needs a new name.
#[derive(Serialize)]
struct Fingerprint<'a> {
    #[serde(rename = "primitive/v1")]
    primitive: &'a str,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Location {
    #[serde(skip_serializing_if = "Option::is_none")]
    physical_location: Option<PhysicalLocation>,
    logical_locations: [LogicalLocation; 1],
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct PhysicalLocation {
    artifact_location: ArtifactLocation,
    region: Region,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct ArtifactLocation {
    uri: String,
    #[serde(skip_serializing_if = "Option::is_none")]
    uri_base_id: Option<&'static str>,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct Region {
    start_line: usize,
    start_column: usize,
}

#[derive(Serialize)]
#[serde(rename_all = "camelCase")]
struct LogicalLocation {
    name: String,
    kind: &'static str,
    fully_qualified_name: String,
}

#[derive(Serialize)]
struct ResultProperties<'a> {
    lat: Option<f64>,
    lon: Option<f64>,
    x: Option<f64>,
    y: Option<f64>,
    value: Option<f64>,
    limit: Option<f64>,
    unit: Option<&'a str>,
    help: Option<&'a str>,
    fix: Option<&'a str>,
}

/// Writes a log of one run.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut entries = report.worst_first();
    let found = entries.len();
    entries.truncate(MAX_RESULTS);
    let (rules, index) = rules(report, &entries);
    let referrers = report.referrers();
    let notifications = (found > entries.len()).then(|| Notification {
        level: "note",
        message: OwnText {
            text: format!(
                "{found} findings; the worst {MAX_RESULTS} are in this file. `--format json` has all counts."
            ),
        },
    });
    let log = Log {
        schema: "https://json.schemastore.org/sarif-2.1.0.json",
        version: "2.1.0",
        runs: [Run {
            tool: Tool { driver: Driver { name: TOOL, semantic_version: VERSION, rules } },
            invocations: [Invocation {
                execution_successful: true,
                tool_execution_notifications: notifications.into_iter().collect(),
            }],
            column_kind: "unicodeCodePoints",
            results: entries.iter().map(|entry| result(report, entry, &index, &referrers)).collect(),
        }],
    };
    serde_json::to_writer_pretty(&mut *out, &log)?;
    writeln!(out)
}

/// The rules that the results name, in order of first appearance, and the position of each.
fn rules<'a>(report: &Report<'a>, entries: &[Entry<'a>]) -> (Vec<Rule<'a>>, FxHashMap<&'a str, usize>) {
    let mut rules = Vec::new();
    let mut index = FxHashMap::default();
    for entry in entries {
        let code = entry.diagnostic.code.as_str();
        if !index.contains_key(code) {
            index.insert(code, rules.len());
            rules.push(rule(report, entry));
        }
    }
    (rules, index)
}

fn rule<'a>(report: &Report<'a>, entry: &Entry<'a>) -> Rule<'a> {
    let code = entry.diagnostic.code.as_str();
    let (id, slug) = split_code(code);
    let requirement: Option<&'a Requirement> = report.requirements.iter().find(|one| one.id == id).copied();
    let fault: Option<&'a Fault> = requirement.and_then(|requirement| requirement.fault(slug));
    let severity = fault.map_or(entry.diagnostic.severity, |fault| fault.severity);
    let help = fault.map_or(entry.diagnostic.help.as_deref().unwrap_or(code), |fault| &fault.help);
    let prose = requirement.map_or("", |requirement| &requirement.prose);
    Rule {
        id: code,
        short_description: Text { text: fault.map_or(code, |fault| &fault.meaning) },
        full_description: requirement.map(|requirement| Text { text: &requirement.title }),
        help: Help { text: help.to_owned(), markdown: format!("{help}\n\n{prose}").trim_end().to_owned() },
        help_uri: requirement.map(|one| one.source.as_str()).filter(|source| source.starts_with("https://")),
        default_configuration: Configuration { level: level(severity) },
        properties: RuleProperties {
            tags: requirement.map_or(vec![id], |requirement| vec![id, &requirement.category]),
            severity: match severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Info => "recommendation",
            },
        },
    }
}

fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "note",
    }
}

fn result<'a>(
    report: &Report<'a>,
    entry: &'a Entry<'a>,
    index: &FxHashMap<&'a str, usize>,
    referrers: &Referrers,
) -> SarifResult<'a> {
    let diagnostic = entry.diagnostic;
    let finding = &diagnostic.finding;
    let place = entry.position.or_else(|| report.top());
    SarifResult {
        rule_id: &diagnostic.code,
        rule_index: index.get(diagnostic.code.as_str()).copied().unwrap_or_default(),
        level: level(diagnostic.severity),
        // Files of more than 1 MB are not shown beside the result: the text must lead to the place alone.
        message: OwnText { text: sentence(diagnostic) },
        locations: vec![Location {
            physical_location: place.map(|at| physical(report, at)),
            logical_locations: [logical(report, entry.subject(), referrers)],
        }],
        partial_fingerprints: Fingerprint { primitive: &entry.fingerprint },
        properties: ResultProperties {
            lat: diagnostic.lonlat.map(|at| at.lat),
            lon: diagnostic.lonlat.map(|at| at.lon),
            x: diagnostic.local.map(|at| at.x),
            y: diagnostic.local.map(|at| at.y),
            value: finding.measure.map(|measure| measure.value),
            limit: finding.measure.map(|measure| measure.limit),
            unit: finding.measure.map(|measure| measure.unit),
            help: diagnostic.help.as_deref(),
            fix: finding.fix.as_ref().map(|fix| fix.title.as_str()),
        },
    }
}

fn physical(report: &Report<'_>, at: Position<'_>) -> PhysicalLocation {
    let path = report.path(at.name);
    let relative = !std::path::Path::new(&path).is_absolute();
    PhysicalLocation {
        artifact_location: ArtifactLocation {
            uri: if relative { uri(&path) } else { format!("file://{}", uri(&path)) },
            uri_base_id: relative.then_some("%SRCROOT%"),
        },
        region: Region { start_line: at.line, start_column: at.column },
    }
}

/// The chain of primitives that leads to the subject, outermost first.
fn logical(report: &Report<'_>, subject: Subject, referrers: &Referrers) -> LogicalLocation {
    let mut chain = referrers.chain(report.map, subject);
    chain.push(subject);
    let names: Vec<String> = chain.iter().map(Subject::to_string).collect();
    LogicalLocation { name: subject.to_string(), kind: subject.kind(), fully_qualified_name: names.join("/") }
}

/// A path as a relative reference of RFC 3986.
fn uri(path: &str) -> String {
    let mut out = String::with_capacity(path.len());
    for byte in path.bytes() {
        match byte {
            b'A'..=b'Z' | b'a'..=b'z' | b'0'..=b'9' | b'/' | b'-' | b'.' | b'_' | b'~' => out.push(char::from(byte)),
            _ => out.push_str(&format!("%{byte:02X}")),
        }
    }
    out
}
