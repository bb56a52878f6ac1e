//! One line per finding, and the line that sums up.

use std::io::{self, Write};

use super::Sources;
use crate::diagnostic::{Diagnostic, Severity};

/// Writes `file:line:column: severity[code] message`, one line per finding.
pub fn concise(out: &mut dyn Write, diagnostics: &[Diagnostic], sources: &Sources) -> io::Result<()> {
    for diagnostic in diagnostics {
        if let Some(at) = diagnostic.span.as_ref().and_then(|span| sources.position(span)) {
            write!(out, "{}:{}:{}: ", at.name, at.line, at.column)?;
        }
        let Diagnostic { severity, code, finding, .. } = diagnostic;
        writeln!(out, "{severity}[{code}] {}", finding.message)?;
    }
    Ok(())
}

/// How many findings of each severity, in one line: `2 errors, 1 warning, 0 infos`.
pub fn summary(diagnostics: &[Diagnostic]) -> String {
    if diagnostics.is_empty() {
        return "no findings".to_owned();
    }
    let count = |severity| diagnostics.iter().filter(|one| one.severity == severity).count();
    let said = [Severity::Error, Severity::Warning, Severity::Info].map(|severity| match count(severity) {
        1 => format!("1 {severity}"),
        many => format!("{many} {severity}s"),
    });
    said.join(", ")
}
