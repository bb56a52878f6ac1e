//! Workflow commands: GitHub Actions turns them into annotations on the changed files.

use std::io::{self, Write};

use super::{Report, details, sentence, visible};
use crate::diagnostic::Severity;

/// Writes a command for every finding, the worst first, since GitHub shows the first ten of a step and severity only.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let referrers = report.referrers();
    for entry in report.worst_first() {
        let diagnostic = entry.diagnostic;
        let command = match diagnostic.severity {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Info => "notice",
        };
        write!(out, "::{command} ")?;
        if let Some(at) = entry.position.or_else(|| report.top()) {
            write!(out, "file={},line={},col={},", property(&report.path(at.name)), at.line, at.column)?;
        }
        write!(out, "title={}::{}", property(&diagnostic.code), data(&visible(&sentence(diagnostic))))?;
        for detail in details(diagnostic, &referrers.chain(report.map, entry.subject())) {
            write!(out, "%0A{}", data(&detail))?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// The part behind the last `::`.
fn data(text: &str) -> String {
    text.replace('%', "%25").replace('\r', "%0D").replace('\n', "%0A")
}

/// A value before it.
fn property(text: &str) -> String {
    data(text).replace(':', "%3A").replace(',', "%2C")
}
