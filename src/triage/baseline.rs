//! The baseline: findings that a map has had for long. With it a run fails on new ones only.

use std::collections::BTreeMap;
use std::io::{self, Write};

use serde::{Deserialize, Serialize};

use crate::diagnostic::{Accepted, Diagnostic, Finding, Subject};
use crate::settings::{PrimitiveKind, Selection};

use super::Sorted;

/// Version of the file's shape.
const SCHEMA_VERSION: u32 = 2;
/// The version of files without any reason, which older programs read, too.
const WITHOUT_REASONS: u32 = 1;

/// How many findings of each code each primitive may have, and why somebody lets it have them.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Baseline {
    known: BTreeMap<(String, Subject), Known>,
}

/// Findings of one code on one primitive.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
struct Known {
    count: usize,
    /// Why they stay, in the words of whoever rejected their fix.
    reason: Option<String>,
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
    #[serde(default, skip_serializing_if = "Option::is_none")]
    reason: Option<String>,
}

impl Baseline {
    /// Of what a run found.
    pub fn of(found: &[Diagnostic]) -> Self {
        let mut known: BTreeMap<(String, Subject), Known> = BTreeMap::new();
        for diagnostic in found {
            known.entry((diagnostic.code.clone(), diagnostic.finding.subject)).or_default().count += 1;
        }
        Self { known }
    }

    /// The same with the reasons that an earlier one gives for what both know.
    #[must_use]
    pub fn with_reasons_of(mut self, earlier: &Self) -> Self {
        for (key, known) in &mut self.known {
            known.reason = earlier.known.get(key).and_then(|known| known.reason.clone());
        }
        self
    }

    /// Lets a primitive have the findings of a code, as many as it has now, for a reason.
    pub fn accept(&mut self, code: &str, subject: Subject, count: usize, reason: &str) {
        let known = self.known.entry((code.to_owned(), subject)).or_default();
        (known.count, known.reason) = (known.count.max(count), Some(reason.to_owned()));
    }

    /// Forgets what it knows of a code on a primitive.
    pub fn forget(&mut self, code: &str, subject: Subject) {
        self.known.remove(&(code.to_owned(), subject));
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
        if !(WITHOUT_REASONS..=SCHEMA_VERSION).contains(&schema_version) {
            return Err(BaselineError::Version(schema_version));
        }
        let File { findings } = serde_json::from_str(text)?;
        let mut all: BTreeMap<(String, Subject), Known> = BTreeMap::new();
        for KnownFinding { code, primitive, id, count, reason } in findings {
            let known = all.entry((code, primitive.subject(id))).or_default();
            known.count = known.count.saturating_add(count);
            known.reason = known.reason.take().or(reason);
        }
        Ok(Self { known: all })
    }

    /// Writes a file with one line for every code and primitive, in order, so that a change of the map changes few lines.
    ///
    /// # Errors
    ///
    /// If `out` cannot be written to.
    pub fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let version = match self.known.values().any(|known| known.reason.is_some()) {
            true => SCHEMA_VERSION,
            false => WITHOUT_REASONS,
        };
        writeln!(out, "{{\n  \"schema_version\": {version},\n  \"findings\": [")?;
        for (at, ((code, subject), Known { count, reason })) in self.known.iter().enumerate() {
            let (code, reason, count) = (code.clone(), reason.clone(), *count);
            let known = KnownFinding { code, primitive: (*subject).into(), id: subject.id(), count, reason };
            let comma = if at + 1 < self.known.len() { "," } else { "" };
            writeln!(out, "    {}{comma}", serde_json::to_string(&known)?)?;
        }
        writeln!(out, "  ]\n}}")
    }

    /// How many findings it knows.
    pub fn len(&self) -> usize {
        self.known.values().map(|known| known.count).sum()
    }

    /// Whether it knows none.
    pub fn is_empty(&self) -> bool {
        self.known.is_empty()
    }

    /// Which findings it does not know. Of several equal findings on a primitive, the first are the known ones.
    pub fn which_are_new(&self, found: &[Diagnostic]) -> Vec<bool> {
        let mut rest = self.counts();
        found.iter().map(|one| is_new(&mut rest, one)).collect()
    }

    fn counts(&self) -> BTreeMap<(String, Subject), usize> {
        self.known.iter().map(|(key, known)| (key.clone(), known.count)).collect()
    }

    /// Removes the known findings, and reports those that are known but no longer found.
    pub(super) fn apply(&self, sorted: &mut Sorted, selection: &Selection) -> Vec<Finding> {
        let mut rest = self.counts();
        let before = sorted.left.len();
        sorted.left.retain(|diagnostic| {
            let is_new = is_new(&mut rest, diagnostic);
            if !is_new {
                sorted.reasons.extend(self.reason(diagnostic));
            }
            is_new
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

    /// Why somebody lets a finding be, where that is known.
    fn reason(&self, found: &Diagnostic) -> Option<Accepted> {
        let known = self.known.get(&(found.code.clone(), found.finding.subject))?;
        let reason = known.reason.clone()?;
        Some(Accepted { found: found.clone(), reason })
    }
}

/// Whether a finding is none of the known; takes it from those otherwise.
fn is_new(rest: &mut BTreeMap<(String, Subject), usize>, found: &Diagnostic) -> bool {
    match rest.get_mut(&(found.code.clone(), found.finding.subject)) {
        Some(count) if *count > 0 => {
            *count -= 1;
            false
        }
        _ => true,
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
    fn reasons_are_kept_and_told() {
        let found = [found("a/b", Subject::Lanelet(1)), found("a/c", Subject::Map)];
        let mut baseline = Baseline::default();
        baseline.accept("a/b", Subject::Lanelet(1), 1, "the \"sign\" stands there");
        let mut text = Vec::new();
        baseline.write(&mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        assert!(text.contains("\"schema_version\": 2"), "{text}");
        let baseline = Baseline::parse(&text).unwrap();
        let mut sorted = Sorted { left: found.to_vec(), ..Sorted::default() };
        assert!(baseline.apply(&mut sorted, &Selection::default()).is_empty());
        assert_eq!((sorted.left.as_slice(), sorted.known), (&found[1..], 1));
        assert_eq!(sorted.reasons[0].reason, "the \"sign\" stands there");
        // Written anew of all that is found, it still says why.
        let anew = Baseline::of(&found).with_reasons_of(&baseline);
        assert_eq!((anew.len(), anew.reason(&found[0]).is_some(), anew.reason(&found[1])), (2, true, None));
        let mut without = baseline.clone();
        without.forget("a/b", Subject::Lanelet(1));
        assert!(without.is_empty() && baseline.which_are_new(&found) == [false, true]);
    }

    #[test]
    fn what_is_no_baseline_is_refused() {
        for text in ["", "[]", "{\"schema_version\":1}", "{\"schema_version\":1,\"findings\":[{\"code\":1}]}"] {
            assert!(matches!(Baseline::parse(text), Err(BaselineError::Shape(_))), "{text}");
        }
        assert!(matches!(Baseline::parse("{\"schema_version\":9,\"x\":1}"), Err(BaselineError::Version(9))));
    }
}
