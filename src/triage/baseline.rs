//! The baseline: findings that a map has had for long. With it a run fails on new ones only.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use crate::diagnostic::{Diagnostic, Finding, Subject};
use crate::settings::{PrimitiveKind, Selection};

use super::Sorted;

/// Version of the file's shape.
const SCHEMA_VERSION: u32 = 1;

/// How many findings of each code each primitive may have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline {
    counts: BTreeMap<(String, Subject), usize>,
}

/// Why a file is no baseline.
#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    /// It is not JSON, or not of this shape.
    #[error("not a baseline: {0}")]
    Shape(#[from] serde_json::Error),
    /// It is of a shape that this version does not know.
    #[error("the baseline has schema_version {0}; this version of lanewright reads {SCHEMA_VERSION}")]
    Version(u32),
}

#[derive(Deserialize)]
struct File {
    findings: Vec<KnownFinding>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct KnownFinding {
    code: String,
    primitive: PrimitiveKind,
    id: Option<i64>,
    count: usize,
}

impl Baseline {
    /// Of what a run found.
    pub fn of(found: &[Diagnostic]) -> Self {
        let mut counts: BTreeMap<(String, Subject), usize> = BTreeMap::new();
        for diagnostic in found {
            *counts.entry((diagnostic.code.clone(), diagnostic.finding.subject)).or_default() += 1;
        }
        Self { counts }
    }

    /// From the text of a file.
    ///
    /// # Errors
    ///
    /// If the text is no baseline, or one of another version.
    pub fn parse(text: &str) -> Result<Self, BaselineError> {
        #[derive(Deserialize)]
        struct Head {
            schema_version: u32,
        }
        let Head { schema_version } = serde_json::from_str(text)?;
        if schema_version != SCHEMA_VERSION {
            return Err(BaselineError::Version(schema_version));
        }
        let File { findings } = serde_json::from_str(text)?;
        let mut counts: BTreeMap<(String, Subject), usize> = BTreeMap::new();
        for KnownFinding { code, primitive, id, count } in findings {
            let known = counts.entry((code, primitive.subject(id))).or_default();
            *known = known.saturating_add(count);
        }
        Ok(Self { counts })
    }

    /// Writes a file with one line for every code and primitive, in order, so that a change of the map changes few lines.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written to.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        writeln!(out, "{{\n  \"schema_version\": {SCHEMA_VERSION},\n  \"findings\": [")?;
        for (at, ((code, subject), &count)) in self.counts.iter().enumerate() {
            let known = KnownFinding { code: code.clone(), primitive: (*subject).into(), id: subject.id(), count };
            let comma = if at + 1 < self.counts.len() { "," } else { "" };
            writeln!(out, "    {}{comma}", serde_json::to_string(&known)?)?;
        }
        writeln!(out, "  ]\n}}")
    }

    /// How many findings it knows.
    pub fn len(&self) -> usize {
        self.counts.values().sum()
    }

    /// Whether it knows none.
    pub fn is_empty(&self) -> bool {
        self.counts.is_empty()
    }

    /// Removes the known findings, and reports those that are known but no longer found. Of several equal findings on a
    /// primitive, the first are the known ones.
    pub(super) fn apply(&self, sorted: &mut Sorted, selection: &Selection) -> Vec<Finding> {
        let mut rest = self.counts.clone();
        let before = sorted.left.len();
        sorted.left.retain(|diagnostic| match rest.get_mut(&(diagnostic.code.clone(), diagnostic.finding.subject)) {
            Some(count) if *count > 0 => {
                *count -= 1;
                false
            }
            _ => true,
        });
        sorted.known = before - sorted.left.len();
        let stale = rest.into_iter().filter(|((code, _), count)| *count > 0 && selection.wants(code));
        stale
            .map(|((code, subject), count)| {
                let message =
                    format!("The baseline lists {count} of `{code}` on {subject} that {} not found.", be(count));
                Finding::new("stale-baseline", subject, message)
            })
            .collect()
    }
}

fn be(count: usize) -> &'static str {
    if count == 1 { "was" } else { "were" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::Severity;

    fn found(code: &str, subject: Subject) -> Diagnostic {
        Diagnostic::new(code, Severity::Error, Finding::new("x", subject, "x"))
    }

    #[test]
    fn only_new_findings_are_left_and_stale_entries_are_said() {
        let old = [found("a/b", Subject::Lanelet(1)), found("a/b", Subject::Lanelet(1)), found("a/c", Subject::Map)];
        let baseline = Baseline::of(&old);
        let mut text = Vec::new();
        baseline.write(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert_eq!(text.lines().count(), 7, "{text}");
        let baseline = Baseline::parse(&text).unwrap();
        assert_eq!((baseline.len(), &baseline), (3, &Baseline::of(&old)));

        let new = found("a/b", Subject::RegulatoryElement(1));
        let left = vec![old[0].clone(), new.clone()];
        let mut sorted = Sorted { left, ..Sorted::default() };
        let stale = baseline.apply(&mut sorted, &Selection::default());
        assert_eq!((sorted.left, sorted.known), (vec![new], 1));
        let said: Vec<&str> = stale.iter().map(|finding| finding.message.as_str()).collect();
        assert_eq!(
            said,
            [
                "The baseline lists 1 of `a/b` on lanelet 1 that was not found.",
                "The baseline lists 1 of `a/c` on map that was not found.",
            ]
        );
    }

    #[test]
    fn what_is_no_baseline_is_refused() {
        for text in ["", "[]", "{\"schema_version\":1}", "{\"schema_version\":1,\"findings\":[{\"code\":1}]}"] {
            assert!(matches!(Baseline::parse(text), Err(BaselineError::Shape(_))), "{text}");
        }
        assert!(matches!(Baseline::parse("{\"schema_version\":9,\"x\":1}"), Err(BaselineError::Version(9))));
    }
}
