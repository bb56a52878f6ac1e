//! Which fixes may be made.

use crate::diagnostic::{Diagnostic, Edit, Fix, Severity};

/// What somebody lets the program do to a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Scope {
    /// Also fixes that need review afterwards.
    pub unsafe_too: bool,
    /// Also fixes that only give elements new ids.
    pub ids_too: bool,
    /// Also fixes that bring more warnings than they mend errors.
    pub warnings_too: bool,
    /// The least severity of findings that are mended.
    pub least: Severity,
}

impl From<bool> for Scope {
    /// All findings are mended; says whether fixes are made that need review.
    fn from(unsafe_too: bool) -> Self {
        Self { unsafe_too, ids_too: false, warnings_too: true, least: Severity::Info }
    }
}

impl Default for Scope {
    fn default() -> Self {
        Self { warnings_too: false, least: Severity::Warning, ..Self::from(false) }
    }
}

impl Scope {
    /// The same for somebody who names codes or families of them: what is named is mended however little it weighs, and new ids are given
    /// where the ids are named.
    #[must_use]
    pub fn naming(self, codes: &[String]) -> Self {
        let is_ids = |code: &String| code == "ids" || code.starts_with("ids/");
        match codes {
            [] => self,
            _ => Self { least: Severity::Info, ids_too: codes.iter().any(is_ids), ..self },
        }
    }

    /// Whether a fix may be made.
    pub fn may(self, fix: &Fix) -> bool {
        let renumbers = || fix.edits.iter().all(|edit| matches!(edit, Edit::Renumber { .. }));
        fix.safe || self.unsafe_too || (self.ids_too && renumbers())
    }

    /// Whether a finding is to be mended at all.
    pub fn wants(self, found: &Diagnostic) -> bool {
        found.severity >= self.least
    }
}
