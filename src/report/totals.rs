//! How many findings there are, by severity and by code.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::Serialize;

use crate::diagnostic::{Diagnostic, Severity};

/// Count of one code and one severity.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct CodeTotal {
    /// Rule and slug.
    pub code: String,
    /// Their severity: a code that is graded by size has a row for each.
    pub severity: Severity,
    /// How many were found.
    pub count: usize,
}

/// Counts of one run.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Totals {
    /// Of severity error.
    pub errors: usize,
    /// Of severity warning.
    pub warnings: usize,
    /// Of severity info.
    pub infos: usize,
    /// By code and severity, the most frequent first, equal ones by code, the worse severity first.
    pub codes: Vec<CodeTotal>,
}

impl Totals {
    /// Counts findings.
    pub fn of(diagnostics: &[Diagnostic]) -> Self {
        let mut totals = Self::default();
        let mut codes: BTreeMap<(&str, Reverse<Severity>), usize> = BTreeMap::new();
        for diagnostic in diagnostics {
            match diagnostic.severity {
                Severity::Error => totals.errors += 1,
                Severity::Warning => totals.warnings += 1,
                Severity::Info => totals.infos += 1,
            }
            *codes.entry((&diagnostic.code, Reverse(diagnostic.severity))).or_default() += 1;
        }
        totals.codes = codes
            .into_iter()
            .map(|((code, Reverse(severity)), count)| CodeTotal { code: code.to_owned(), severity, count })
            .collect();
        totals.codes.sort_by_key(|total| Reverse(total.count));
        totals
    }

    /// Of all severities.
    pub fn all(&self) -> usize {
        self.errors + self.warnings + self.infos
    }

    /// The table of `--statistics`: count, severity and code, one line each.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written to.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let width = self.codes.first().map_or(1, |most| most.count.to_string().len());
        for CodeTotal { code, severity, count } in &self.codes {
            writeln!(out, "{count:>width$}  {:<7}  {code}", severity.to_string())?;
        }
        Ok(())
    }
}
