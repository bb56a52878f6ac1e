//! SARIF 2.1.0, as code scanning services read it.
//!
//! GitHub keeps the first 5,000 results of a run and refuses more than 25,000, so the worst 5,000 are written and a
//! notification says how many were left out.

mod model;

use std::io::{self, Write};

use model::*;
use rustc_hash::FxHashMap;

use super::patch::{Replacement, replacements};
use super::{Entry, Position, Report, TOOL, VERSION, sentence, split_code};
use crate::diagnostic::{Fix, Severity, SourceSpan, Subject};
use crate::lanelet::locate::span_of;
use crate::lanelet::referrers::Referrers;
use crate::requirement::{Fault, Requirement};

/// Results that a code scanning service keeps.
pub const MAX_RESULTS: usize = 5_000;
/// Related places of a result; a service takes 1,000, nobody looks at so many.
const MAX_RELATED: usize = 100;

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
            id: None,
            message: None,
            physical_location: place.map(|at| physical(report, at)),
            logical_locations: [logical(report, entry.subject(), referrers)],
        }],
        related_locations: related(report, entry, referrers),
        fixes: finding.fix.iter().filter_map(|fix| sarif_fix(report, fix)).collect(),
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

/// Where the other primitives of a finding stand, each with its part in it.
fn related(report: &Report<'_>, entry: &Entry<'_>, referrers: &Referrers) -> Vec<Location> {
    let related = entry.diagnostic.finding.related.iter().take(MAX_RELATED).enumerate();
    let locations = related.map(|(at, one)| {
        let span = span_of(report.map, one.subject);
        let position = span.and_then(|span| report.sources.position(&span));
        Location {
            id: Some(at + 1),
            message: Some(OwnText { text: one.part.to_owned() }),
            physical_location: position.map(|at| physical(report, at)),
            logical_locations: [logical(report, one.subject, referrers)],
        }
    });
    locations.collect()
}

/// The fix as changes of text; `None` where it takes more than that.
fn sarif_fix<'a>(report: &Report<'a>, fix: &'a Fix) -> Option<SarifFix<'a>> {
    let mut changes: Vec<(u32, ArtifactChange)> = Vec::new();
    for Replacement { span, text } in replacements(report, fix)? {
        let place = |offset: u64| report.sources.position(&SourceSpan { start: offset, ..span.clone() });
        let (start, end) = (place(span.start)?, place(span.end)?);
        let deleted_region = Region {
            start_line: start.line,
            start_column: start.column,
            end_line: Some(end.line),
            end_column: Some(end.column),
        };
        let replacement = SarifReplacement { deleted_region, inserted_content: OwnText { text } };
        match changes.last_mut().filter(|(file, _)| *file == span.file) {
            Some((_, change)) => change.replacements.push(replacement),
            None => {
                let artifact_location = artifact(report, start.name);
                changes.push((span.file, ArtifactChange { artifact_location, replacements: vec![replacement] }));
            }
        }
    }
    let artifact_changes = changes.into_iter().map(|(_, change)| change).collect();
    Some(SarifFix { description: Text { text: &fix.title }, artifact_changes })
}

fn physical(report: &Report<'_>, at: Position<'_>) -> PhysicalLocation {
    PhysicalLocation {
        artifact_location: artifact(report, at.name),
        region: Region { start_line: at.line, start_column: at.column, end_line: None, end_column: None },
    }
}

fn artifact(report: &Report<'_>, name: &str) -> ArtifactLocation {
    let path = report.path(name);
    let relative = !std::path::Path::new(&path).is_absolute();
    ArtifactLocation {
        uri: if relative { uri(&path) } else { format!("file://{}", uri(&path)) },
        uri_base_id: relative.then_some("%SRCROOT%"),
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
