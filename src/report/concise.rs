//! One line per finding, and the line that sums up.

use std::io::{self, Write};

use super::details::spot;
use super::{Position, Sources, visible};
use crate::diagnostic::{Diagnostic, Severity};

/// Writes `file:line:column: severity[code] message (at lat, lon)`, one line per finding; in metres where a map has only
/// those.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn concise<'d>(
    out: &mut dyn Write,
    diagnostics: impl IntoIterator<Item = &'d Diagnostic>,
    sources: &Sources,
) -> io::Result<()> {
    let place = |diagnostic: &Diagnostic| diagnostic.span.as_ref().and_then(|span| sources.position(span));
    diagnostics.into_iter().try_for_each(|diagnostic| writeln!(out, "{}", line(diagnostic, place(diagnostic))))
}

/// The line of one finding, without line feed.
pub fn line(diagnostic: &Diagnostic, position: Option<Position<'_>>) -> String {
    let place = position.map_or(String::new(), |at| format!("{}:{}:{}: ", visible(at.name), at.line, at.column));
    format!("{place}{}[{}] {}", diagnostic.severity, visible(&diagnostic.code), visible(&sentence(diagnostic)))
}

/// The message with the primitive's id and place, for where nothing else shows them. Most messages name the id
/// themselves.
pub fn sentence(diagnostic: &Diagnostic) -> String {
    let finding = &diagnostic.finding;
    let mut sentence = match finding.subject.id() {
        Some(id) if !names(&finding.message, id) => format!("{}: {}", finding.subject, finding.message),
        _ => finding.message.clone(),
    };
    if let Some(at) = spot(diagnostic) {
        sentence.push_str(&format!(" (at {at})"));
    }
    sentence
}

/// Whether the number stands in the text.
fn names(text: &str, id: i64) -> bool {
    let id = id.to_string();
    text.split(|c: char| !c.is_ascii_digit() && c != '-').any(|word| word == id)
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
