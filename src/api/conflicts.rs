//! Conflicts as findings, so that the page that shows findings on the map shows them, too.

use std::sync::LazyLock;

use crate::diagnostic::{Diagnostic, Finding, Place, Severity, Subject};
use crate::lanelet::LaneletMap;
use crate::lanelet::locate::locate;
use crate::requirement::{DocumentError, Requirement};
use crate::three_way::{Conflict, Side};

/// The document about conflicts.
///
/// # Errors
///
/// If a document of `rules/` was spoilt before compiling, which a test prevents.
pub fn conflict_requirement() -> Result<&'static Requirement, &'static DocumentError> {
    static DOCUMENT: LazyLock<Result<Requirement, DocumentError>> =
        LazyLock::new(|| Requirement::parse("merge", include_str!("../../rules/merge.md")));
    DOCUMENT.as_ref()
}

/// Each conflict as a finding on the merged map.
pub(super) fn diagnostics(conflicts: &[Conflict], map: &LaneletMap) -> Vec<Diagnostic> {
    conflicts.iter().map(|conflict| diagnostic(conflict, map)).collect()
}

fn diagnostic(conflict: &Conflict, map: &LaneletMap) -> Diagnostic {
    let Conflict { subject, about, base, ours, theirs, taken, at } = conflict;
    let said = |side: Side, said: &Option<String>| {
        let mark = if *taken == side { ", which is in the result" } else { "" };
        format!("{} says {}{mark}", side.as_str(), said.as_deref().unwrap_or("that it is not there"))
    };
    let before = base.as_deref().map_or_else(|| "was not there".to_owned(), |base| format!("was {base}"));
    let whose = if *subject == Subject::Map { String::new() } else { format!("{subject}: ") };
    let message = format!("{whose}{about} {before}; {}; {}.", said(Side::Ours, ours), said(Side::Theirs, theirs));
    let located = locate(map, *subject, &Place::Unknown);
    Diagnostic {
        code: "merge/conflict".to_owned(),
        severity: Severity::Error,
        help: conflict_requirement().ok().and_then(|it| it.fault("conflict")).map(|fault| fault.help.clone()),
        span: located.span,
        lonlat: located.lonlat.or(*at),
        local: located.local,
        finding: Finding::new("conflict", *subject, message),
    }
}
