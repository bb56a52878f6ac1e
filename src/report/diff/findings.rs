//! Changes as findings, so that the page that shows findings on the map shows changes too.

use std::sync::LazyLock;

use super::{Change, Diff, Kind};
use crate::diagnostic::{Diagnostic, Finding, Severity, Subject};
use crate::lanelet::LaneletMap;
use crate::lanelet::locate::locate;
use crate::requirement::{DocumentError, Requirement};

/// The document of the kinds of change.
///
/// # Errors
///
/// If a document of `rules/` was spoilt before compiling, which a test prevents.
pub fn requirement() -> Result<&'static Requirement, &'static DocumentError> {
    static DOCUMENT: LazyLock<Result<Requirement, DocumentError>> =
        LazyLock::new(|| Requirement::parse("diff", include_str!("../../../rules/diff.md")));
    DOCUMENT.as_ref()
}

/// Every change but those of single points, which show in the lines they are part of; on the new map.
pub fn diagnostics(diff: &Diff, new: &LaneletMap) -> Vec<Diagnostic> {
    let told = diff.changes.iter().filter(|change| !matches!(change.subject, Subject::Point(_)));
    told.map(|change| diagnostic(change, new)).collect()
}

fn diagnostic(change: &Change, new: &LaneletMap) -> Diagnostic {
    let fault = match change.change {
        Kind::Added => "added",
        Kind::Removed => "removed",
        Kind::Changed => "changed",
    };
    let finding = Finding::new(fault, change.subject, change.line()).at(change.place.clone());
    let located = locate(new, change.subject, &change.place);
    Diagnostic {
        code: format!("diff/{fault}"),
        severity: Severity::Info,
        help: requirement().ok().and_then(|document| document.fault(fault)).map(|fault| fault.help.clone()),
        span: located.span,
        lonlat: change.at.or(located.lonlat),
        local: located.local,
        finding,
    }
}
