//! The result file of the existing validator: its requirements with its validators, each passed or with its issues, so
//! that whatever reads that file can read ours.

mod exclusions;
mod prerequisites;
mod set;

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::PrettyFormatter;
use serde_json::{Map, Value, json};

pub use exclusions::Exclusions;
pub use set::{FormatError, RequirementSet};

use super::{TOOL, VERSION};
use crate::diagnostic::{Diagnostic, Severity, Subject};
use prerequisites::Verdict;

/// One validator, as far as the result is concerned.
#[derive(Clone, Debug)]
pub struct Validator<'a> {
    /// `mapping.intersection.road_markings`.
    pub name: &'a str,
    /// Its issue codes up to the number: `Intersection.RoadMarkings`.
    pub code: String,
    /// The requirement under which it is shown where the user has no set.
    pub requirement: &'a str,
}

/// One line of a validator's issues.
#[derive(Clone, Debug, PartialEq)]
pub struct Issue {
    /// How bad it is.
    pub severity: Severity,
    /// The word for the primitive's kind.
    pub primitive: &'static str,
    /// Its id.
    pub id: i64,
    /// `Intersection.RoadMarkings-001`.
    pub code: String,
    /// What is wrong.
    pub message: String,
}

impl Issue {
    fn of(diagnostic: &Diagnostic) -> Option<Self> {
        let subject = diagnostic.finding.subject;
        let primitive = match subject {
            Subject::Map | Subject::Node(_) | Subject::Way(_) | Subject::Relation(_) => "primitive",
            _ => subject.kind(),
        };
        Some(Self {
            severity: diagnostic.severity,
            primitive,
            id: subject.id().unwrap_or_default(),
            code: diagnostic.finding.peer.as_ref()?.to_string(),
            message: diagnostic.finding.message.clone(),
        })
    }

    /// An issue of the run itself.
    fn general(code: &str, message: String) -> Self {
        Self { severity: Severity::Error, primitive: "primitive", id: 0, code: code.to_owned(), message }
    }

    fn to_json(&self) -> Value {
        let severity = match self.severity {
            Severity::Error => "Error",
            Severity::Warning => "Warning",
            Severity::Info => "info",
        };
        json!({
            "severity": severity, "primitive": self.primitive, "id": self.id, "issue_code": self.code,
            "message": self.message,
        })
    }
}

/// What a run came to.
#[derive(Clone, Debug)]
pub struct Outcome {
    document: Value,
    /// How many issues there are of each severity.
    pub counts: BTreeMap<Severity, usize>,
}

impl Outcome {
    /// Holds the findings against a set of requirements. `map` is the map's file, for the record.
    pub fn new(
        diagnostics: &[Diagnostic],
        validators: &[Validator<'_>],
        set: &RequirementSet,
        exclusions: &Exclusions,
        map: &std::path::Path,
    ) -> Self {
        let mut found: BTreeMap<&str, Vec<Issue>> = BTreeMap::new();
        for issue in diagnostics.iter().filter_map(Issue::of) {
            let code = issue.code.rsplit_once('-').map_or("", |(code, _)| code);
            let Some(validator) = validators.iter().find(|validator| validator.code == code) else { continue };
            if !exclusions.hold(validator.name, issue.primitive, issue.id) {
                found.entry(validator.name).or_default().push(issue);
            }
        }
        prerequisites::apply(&set.prerequisites(), &mut found);
        let document = document(set, &found, map);
        let mut counts = BTreeMap::new();
        // As often as a reader sees them: a validator may stand under several requirements.
        for issue in set.names().flat_map(|name| found.get(name).into_iter().flatten()) {
            *counts.entry(issue.severity).or_default() += 1;
        }
        Self { document, counts }
    }

    /// Writes the document: indented by four blanks, keys in alphabetical order.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let mut text = serde_json::Serializer::with_formatter(&mut *out, PrettyFormatter::with_indent(b"    "));
        sorted(&self.document).serialize(&mut text)?;
        writeln!(out)
    }

    /// The document.
    pub fn document(&self) -> &Value {
        &self.document
    }
}

fn document(set: &RequirementSet, found: &BTreeMap<&str, Vec<Issue>>, map: &std::path::Path) -> Value {
    let mut document = set.document().clone();
    for requirement in document.get_mut("requirements").and_then(Value::as_array_mut).into_iter().flatten() {
        let mut all_passed = true;
        for validator in requirement.get_mut("validators").and_then(Value::as_array_mut).into_iter().flatten() {
            let issues = validator.get("name").and_then(Value::as_str).and_then(|name| found.get(name));
            let passed = Verdict::of(issues.map_or(&[], Vec::as_slice)).passed();
            all_passed &= passed;
            if let Value::Object(validator) = validator {
                validator.insert("passed".to_owned(), passed.into());
                if let Some(issues) = issues.filter(|issues| !issues.is_empty()) {
                    validator.insert("issues".to_owned(), issues.iter().map(Issue::to_json).collect());
                }
            }
        }
        if let Value::Object(requirement) = requirement {
            requirement.insert("passed".to_owned(), all_passed.into());
        }
    }
    if let Value::Object(document) = &mut document {
        document.insert(
            "validation_info".to_owned(),
            json!({
                "target_map": target(map),
                "map_requirements": { "filename": set.file(), "version": set.version() },
                "validator": { "name": TOOL, "version": VERSION },
            }),
        );
    }
    document
}

/// The map's file with the directory it lies in.
fn target(map: &std::path::Path) -> String {
    let absolute = std::path::absolute(map).unwrap_or_else(|_| map.to_path_buf());
    let parts: Vec<String> = absolute.iter().map(|part| part.to_string_lossy().into_owned()).collect();
    parts[parts.len().saturating_sub(2)..].join("/")
}

/// The same value with its keys in alphabetical order.
fn sorted(value: &Value) -> Value {
    match value {
        Value::Object(entries) => {
            let entries: BTreeMap<&String, Value> = entries.iter().map(|(key, value)| (key, sorted(value))).collect();
            Value::Object(entries.into_iter().map(|(key, value)| (key.clone(), value)).collect::<Map<_, _>>())
        }
        Value::Array(list) => list.iter().map(sorted).collect(),
        _ => value.clone(),
    }
}
