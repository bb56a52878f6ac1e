//! The result file of the existing validator: its requirements with its validators, each passed or with its issues, so
//! that whatever reads that file can read ours.

mod exclusions;
mod prerequisites;
mod set;
mod types;

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;
use serde_json::ser::PrettyFormatter;
use serde_json::{Map, Value, json};

pub use exclusions::Exclusions;
pub use set::{FormatError, RequirementSet};
pub use types::{Issue, Validator};

use super::{TOOL, VERSION};
use crate::diagnostic::{Diagnostic, Severity};
use prerequisites::Verdict;

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
        // As often as a reader sees them: a validator may be under several requirements.
        for issue in set.names().flat_map(|name| found.get(name).into_iter().flatten()) {
            *counts.entry(issue.severity).or_default() += 1;
        }
        Self { document, counts }
    }

    /// Writes the document: indented by four blanks, keys in alphabetical order.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written to.
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
