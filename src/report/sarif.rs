//! SARIF 2.1.0, as code scanning services read it.
//!
//! GitHub keeps the first 5,000 results of a run and refuses more than 25,000, so the worst 5,000 are written and a
//! notification says how many were left out. The crate `serde-sarif` builds its types with a generator that needs `regex`
//! and writes keys in another order, so the few objects of a log are made here.

use std::io::{self, Write};

use rustc_hash::FxHashMap;
use serde_json::{Value, json};

use super::{Entry, Position, Report, TOOL, VERSION, sentence, split_code};
use crate::diagnostic::{Fix, Severity, SourceSpan, Subject};
use crate::element_edits::replacements;
use crate::lanelet::locate::span_of;
use crate::lanelet::referrers::Referrers;
use crate::requirement::{Fault, Requirement};

/// Results that a code scanning service keeps.
pub const MAX_RESULTS: usize = 5_000;
/// Related places of a result; a service takes 1,000, nobody looks at so many.
const MAX_RELATED: usize = 100;

/// Writes a log of one run.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let mut entries = report.worst_first();
    let found = entries.len();
    entries.truncate(MAX_RESULTS);
    let mut accepted = report.accepted_entries();
    accepted.truncate(MAX_RESULTS - entries.len());
    let (rules, index) = rules(report, entries.iter().chain(accepted.iter().map(|(entry, _)| entry)));
    let referrers = report.referrers();
    let notifications = (found > entries.len()).then(|| {
        let text =
            format!("{found} findings; the worst {MAX_RESULTS} are in this file. `--format json` has all counts.");
        json!({ "level": "note", "message": { "text": text } })
    });
    let mut results: Vec<Value> = entries.iter().map(|entry| result(report, entry, &index, &referrers)).collect();
    // What was rejected in a review: services show it as dismissed, with the reason.
    results.extend(accepted.iter().map(|(entry, reason)| {
        let mut result = result(report, entry, &index, &referrers);
        result["suppressions"] = json!([{ "kind": "external", "status": "accepted", "justification": reason }]);
        result
    }));
    let log = json!({
        "$schema": "https://json.schemastore.org/sarif-2.1.0.json",
        "version": "2.1.0",
        "runs": [{
            "tool": { "driver": { "name": TOOL, "semanticVersion": VERSION, "rules": rules } },
            "invocations": [{
                "executionSuccessful": true,
                "toolExecutionNotifications": notifications.into_iter().collect::<Vec<_>>(),
            }],
            "columnKind": "unicodeCodePoints",
            "results": results,
        }],
    });
    serde_json::to_writer_pretty(&mut *out, &log)?;
    writeln!(out)
}

/// The rules that the results name, in order of first appearance, and the position of each.
fn rules<'a, 'e>(
    report: &Report<'a>,
    entries: impl Iterator<Item = &'e Entry<'a>>,
) -> (Vec<Value>, FxHashMap<&'a str, usize>)
where
    'a: 'e,
{
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

fn rule(report: &Report<'_>, entry: &Entry<'_>) -> Value {
    let code = entry.diagnostic.code.as_str();
    let (id, slug) = split_code(code);
    let requirement: Option<&Requirement> = report.requirements.iter().find(|one| one.id == id).copied();
    let fault: Option<&Fault> = requirement.and_then(|requirement| requirement.fault(slug));
    let severity = fault.map_or(entry.diagnostic.severity, |fault| fault.severity);
    let help = fault.map_or(entry.diagnostic.help.as_deref().unwrap_or(code), |fault| &fault.help);
    let prose = requirement.map_or("", |requirement| &requirement.prose);
    json_without_gaps(json!({
        "id": code,
        "shortDescription": { "text": fault.map_or(code, |fault| &fault.meaning) },
        "fullDescription": requirement.map(|requirement| json!({ "text": requirement.full_title() })),
        "help": { "text": help, "markdown": format!("{help}\n\n{prose}").trim_end() },
        "helpUri": requirement.map(|one| one.source.as_str()).filter(|source| source.starts_with("https://")),
        "defaultConfiguration": { "level": level(severity) },
        "properties": {
            "tags": requirement.map_or(vec![id], |requirement| vec![id, &requirement.category]),
            "problem.severity": match severity {
                Severity::Error => "error",
                Severity::Warning => "warning",
                Severity::Info => "recommendation",
            },
        },
    }))
}

/// An object without the keys that have no value.
fn json_without_gaps(mut object: Value) -> Value {
    if let Value::Object(entries) = &mut object {
        entries.retain(|_, value| !value.is_null() && value.as_array().is_none_or(|list| !list.is_empty()));
    }
    object
}

fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Error => "error",
        Severity::Warning => "warning",
        Severity::Info => "note",
    }
}

fn result(report: &Report<'_>, entry: &Entry<'_>, index: &FxHashMap<&str, usize>, referrers: &Referrers) -> Value {
    let diagnostic = entry.diagnostic;
    let finding = &diagnostic.finding;
    let place = entry.position.or_else(|| report.top()).map(|at| physical(report, at));
    let fixes: Vec<Value> = finding.fix.iter().filter_map(|fix| sarif_fix(report, fix)).collect();
    json_without_gaps(json!({
        "ruleId": diagnostic.code,
        "ruleIndex": index.get(diagnostic.code.as_str()).copied().unwrap_or_default(),
        "level": level(diagnostic.severity),
        // Files of more than 1 MB are not shown beside the result: the text must lead to the place alone.
        "message": { "text": sentence(diagnostic) },
        "locations": [json_without_gaps(json!({
            "physicalLocation": place,
            "logicalLocations": [logical(report, entry.subject(), referrers)],
        }))],
        "relatedLocations": related(report, entry, referrers),
        // The name says how a fingerprint is made; a change of that way needs a new name.
        "partialFingerprints": { "primitive/v1": entry.fingerprint },
        "fixes": fixes,
        "properties": {
            "lat": diagnostic.lonlat.map(|at| at.lat),
            "lon": diagnostic.lonlat.map(|at| at.lon),
            "x": diagnostic.local.map(|at| at.x),
            "y": diagnostic.local.map(|at| at.y),
            "value": finding.measure.map(|measure| measure.value),
            "limit": finding.measure.map(|measure| measure.limit),
            "unit": finding.measure.map(|measure| measure.unit),
            "help": diagnostic.help,
            "fix": finding.fix.as_ref().map(|fix| &fix.title),
        },
    }))
}

/// Where the other primitives of a finding are, each with its part in it.
fn related(report: &Report<'_>, entry: &Entry<'_>, referrers: &Referrers) -> Vec<Value> {
    let related = entry.diagnostic.finding.related.iter().take(MAX_RELATED).enumerate();
    let locations = related.map(|(at, one)| {
        let span = span_of(report.map, one.subject);
        let position = span.and_then(|span| report.sources.position(&span));
        json_without_gaps(json!({
            "id": at + 1,
            "message": { "text": one.part },
            "physicalLocation": position.map(|at| physical(report, at)),
            "logicalLocations": [logical(report, one.subject, referrers)],
        }))
    });
    locations.collect()
}

/// The fix as changes of text; `None` where it takes more than that.
fn sarif_fix(report: &Report<'_>, fix: &Fix) -> Option<Value> {
    let mut changes: Vec<(u32, Value, Vec<Value>)> = Vec::new();
    let text = |subject: Subject| {
        let span = span_of(report.map, subject)?;
        Some((span.clone(), report.sources.text(&span)?))
    };
    for (span, text) in replacements(fix, text)? {
        let place = |offset: u64| report.sources.position(&SourceSpan { start: offset, ..span.clone() });
        let (start, end) = (place(span.start)?, place(span.end)?);
        let replacement = json!({
            "deletedRegion": {
                "startLine": start.line, "startColumn": start.column, "endLine": end.line, "endColumn": end.column,
            },
            "insertedContent": { "text": text },
        });
        match changes.last_mut().filter(|(file, ..)| *file == span.file) {
            Some((.., change)) => change.push(replacement),
            None => changes.push((span.file, artifact(report, start.name), vec![replacement])),
        }
    }
    let changes = changes.into_iter();
    let changes: Vec<Value> =
        changes.map(|(_, file, list)| json!({ "artifactLocation": file, "replacements": list })).collect();
    Some(json!({ "description": { "text": fix.title }, "artifactChanges": changes }))
}

fn physical(report: &Report<'_>, at: Position<'_>) -> Value {
    let region = json!({ "startLine": at.line, "startColumn": at.column });
    json!({ "artifactLocation": artifact(report, at.name), "region": region })
}

fn artifact(report: &Report<'_>, name: &str) -> Value {
    let path = report.path(name);
    match std::path::Path::new(&path).is_absolute() {
        true => json!({ "uri": format!("file://{}", uri(&path)) }),
        false => json!({ "uri": uri(&path), "uriBaseId": "%SRCROOT%" }),
    }
}

/// The chain of primitives that leads to the subject, outermost first.
fn logical(report: &Report<'_>, subject: Subject, referrers: &Referrers) -> Value {
    let mut chain = referrers.chain(report.map, subject);
    chain.push(subject);
    let names: Vec<String> = chain.iter().map(Subject::to_string).collect();
    json!({ "name": subject.to_string(), "kind": subject.kind(), "fullyQualifiedName": names.join("/") })
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
