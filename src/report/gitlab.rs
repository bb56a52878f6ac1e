//! GitLab's code quality report: an array of issues, shown in merge requests.

use std::io::{self, Write};

use serde::Serializer;
use serde_json::json;

use super::{Report, details, sentence};
use crate::diagnostic::Severity;

/// Writes the array, in the order of the run.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let (entries, referrers) = (report.entries(), report.referrers());
    let issues = entries.iter().map(|entry| {
        let diagnostic = entry.diagnostic;
        let at = entry.position.or_else(|| report.top());
        let (line, column) = at.map_or((1, 1), |at| (at.line, at.column));
        // GitLab shows the description alone; the shape, Code Climate's, has a place for the rest.
        json!({
            "description": sentence(diagnostic),
            "content": { "body": details(diagnostic, &referrers.chain(report.map, entry.subject())).join("\n") },
            "check_name": diagnostic.code,
            "fingerprint": entry.fingerprint,
            "severity": match diagnostic.severity {
                Severity::Error => "critical",
                Severity::Warning => "major",
                Severity::Info => "info",
            },
            "location": {
                "path": at.map_or(String::new(), |at| report.path(at.name)),
                "lines": { "begin": line },
                "positions": { "begin": { "line": line, "column": column } },
            },
        })
    });
    serde_json::Serializer::pretty(&mut *out).collect_seq(issues)?;
    writeln!(out)
}
