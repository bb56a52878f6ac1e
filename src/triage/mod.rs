//! Sorts out the findings that somebody has answered for: by a suppression, or by a baseline. Finds nothing in the map
//! itself; what it says, it says of suppressions and baselines.

mod baseline;
mod sorted;
mod suppress;

pub use sorted::Sorted;

use crate::diagnostic::{Diagnostic, Finding, Severity};
use crate::lanelet::LaneletMap;
use crate::lanelet::locate::locate;
use crate::requirement::{DocumentError, Requirement};
use crate::settings::{Settings, most_specific};

use std::sync::LazyLock;

pub use baseline::{Baseline, BaselineError};
pub use suppress::{Suppressions, TAG};

/// The document of what this module says.
///
/// # Errors
///
/// If a document of `rules/` was spoilt before compiling, which a test prevents.
pub fn requirement() -> Result<&'static Requirement, &'static DocumentError> {
    static DOCUMENT: LazyLock<Result<Requirement, DocumentError>> =
        LazyLock::new(|| Requirement::parse("triage", include_str!("../../rules/triage.md")));
    DOCUMENT.as_ref()
}

/// Takes out what suppressions name, then what the baseline knows.
pub fn sort(
    found: Vec<Diagnostic>,
    settings: &Settings,
    suppressions: Suppressions,
    map: &LaneletMap,
    baseline: Option<&Baseline>,
) -> Sorted {
    let mut sorted = Sorted { left: found, ..Sorted::default() };
    let mut said = suppress::apply(&mut sorted, settings, suppressions);
    if let Some(baseline) = baseline {
        said.extend(baseline.apply(&mut sorted, &settings.selection()));
    }
    sorted.left.extend(said.into_iter().filter_map(|finding| diagnostic(map, settings, finding)));
    sorted
}

/// A finding of this module with severity, help and places; `None` if the user does not want it.
fn diagnostic(map: &LaneletMap, settings: &Settings, finding: Finding) -> Option<Diagnostic> {
    let code = format!("triage/{}", finding.fault);
    if !wanted(settings, &code) {
        return None;
    }
    let fault = requirement().ok().and_then(|requirement| requirement.fault(finding.fault));
    let own = settings.severity.iter().map(|(prefix, &severity)| (prefix.as_str(), severity));
    let severity = most_specific(&code, own).map(|(_, severity)| severity);
    let located = locate(map, finding.subject, &finding.place);
    Some(Diagnostic {
        code,
        severity: severity.or(fault.map(|fault| fault.severity)).unwrap_or(Severity::Warning),
        help: fault.map(|fault| fault.help.clone()),
        span: located.span,
        lonlat: located.lonlat,
        local: located.local,
        finding,
    })
}

/// Whether what is said of suppressions is wanted: unless it is left out by name, since who selects one rule still wants
/// to know that a suppression of it does nothing.
fn wanted(settings: &Settings, code: &str) -> bool {
    let mut selection = settings.selection();
    selection.select.clear();
    selection.wants(code)
}
