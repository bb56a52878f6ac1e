//! GitLab's code quality report: an array of issues, shown in merge requests.

use std::io::{self, Write};

use serde::Serialize;

use super::{Report, details, sentence};
use crate::diagnostic::Severity;

#[derive(Serialize)]
struct CodeQualityIssue<'a> {
    description: String,
    content: IssueContent,
    check_name: &'a str,
    fingerprint: &'a str,
    severity: &'static str,
    location: IssueLocation,
}

/// GitLab shows the description alone; the shape, Code Climate's, has a place for the rest.
#[derive(Serialize)]
struct IssueContent {
    body: String,
}

#[derive(Serialize)]
struct IssueLocation {
    path: String,
    lines: Lines,
    positions: Positions,
}

#[derive(Serialize)]
struct Lines {
    begin: usize,
}

#[derive(Serialize)]
struct Positions {
    begin: LineAndColumn,
}

#[derive(Serialize)]
struct LineAndColumn {
    line: usize,
    column: usize,
}

/// Writes the array, in the order of the run.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (entries, referrers) = (report.entries(), report.referrers());
    let issues = entries.iter().map(|entry| {
        let diagnostic = entry.diagnostic;
        let at = entry.position.or_else(|| report.top());
        let (line, column) = at.map_or((1, 1), |at| (at.line, at.column));
        CodeQualityIssue {
            description: sentence(diagnostic),
            content: IssueContent {
                body: details(diagnostic, &referrers.chain(report.map, entry.subject())).join("\n"),
            },
            check_name: &diagnostic.code,
            fingerprint: &entry.fingerprint,
            severity: match diagnostic.severity {
                Severity::Error => "critical",
                Severity::Warning => "major",
                Severity::Info => "info",
            },
            location: IssueLocation {
                path: at.map_or(String::new(), |at| report.path(at.name)),
                lines: Lines { begin: line },
                positions: Positions { begin: LineAndColumn { line, column } },
            },
        }
    });
    serde_json::to_writer_pretty(&mut *out, &issues.collect::<Vec<_>>())?;
    writeln!(out)
}
