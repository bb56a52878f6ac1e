//! GitLab's code quality report: an array of issues, shown in merge requests.

use std::io::{self, Write};

use serde::Serialize;

use super::{Report, sentence};
use crate::diagnostic::Severity;

#[derive(Serialize)]
struct Issue<'a> {
    description: String,
    check_name: &'a str,
    fingerprint: &'a str,
    severity: &'static str,
    location: Location,
}

#[derive(Serialize)]
struct Location {
    path: String,
    lines: Lines,
}

#[derive(Serialize)]
struct Lines {
    begin: usize,
}

/// Writes the array, in the order of the run.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let entries = report.entries();
    let issues = entries.iter().map(|entry| {
        let diagnostic = entry.diagnostic;
        let at = entry.position.or_else(|| report.top());
        Issue {
            description: sentence(diagnostic),
            check_name: &diagnostic.code,
            fingerprint: &entry.fingerprint,
            severity: match diagnostic.severity {
                Severity::Error => "critical",
                Severity::Warning => "major",
                Severity::Info => "info",
            },
            location: Location {
                path: at.map_or(String::new(), |at| report.path(at.name)),
                lines: Lines { begin: at.map_or(1, |at| at.line) },
            },
        }
    });
    serde_json::to_writer_pretty(&mut *out, &issues.collect::<Vec<_>>())?;
    writeln!(out)
}
