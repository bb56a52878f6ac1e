//! Diagnostics and maps made readable: for people, for CI, for other programs.
//!
//! One file per format; each turns a [`Report`] into text. Knows no rule.

mod concise;
mod consequences;
mod details;
pub mod diff;
pub mod draw;
mod escape;
mod explain;
pub mod failure;
mod full;
pub mod geojson;
pub mod github;
pub mod gitlab;
mod groups;
pub mod html;
pub mod json;
pub mod junit;
mod known_words;
mod levels;
pub mod planner;
mod prose;
pub mod sarif;
mod source;
pub mod stats;
mod text;
pub mod tier4;
mod totals;
mod verdict;

pub use concise::{concise, line, sentence, summary};
pub use details::details;
pub use escape::{HarmlessJson, visible, visible_lines, visible_patch};
pub use explain::{explain, list, rule_index};
pub use full::{TextStyle, full};
pub use groups::{Group, groups};
pub use known_words::known_words;
pub use source::{Position, Sources};
pub use text::{Next, text};
pub use totals::{CodeTotal, Totals};
pub use verdict::{FailOn, exit_code, worst};

use crate::diagnostic::fingerprint::Fingerprints;
use crate::diagnostic::{Accepted, Diagnostic, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::LaneletMap;
use crate::lanelet::referrers::Referrers;
use crate::projection::LonLat;
use crate::requirement::Requirement;

/// The name under which the program reports.
pub const TOOL: &str = "lanewright";
/// Its version.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Turns local metres into longitude and latitude; `None` where the map has no projection.
pub type Unproject<'a> = &'a (dyn Fn(&[Point]) -> Option<Vec<LonLat>> + Sync);

/// What one run found, and what is needed to show it.
#[derive(Clone, Copy)]
pub struct Report<'a> {
    /// The findings that count, in the order of the run.
    pub diagnostics: &'a [Diagnostic],
    /// The map's files.
    pub sources: &'a Sources<'a>,
    /// The map.
    pub map: &'a LaneletMap,
    /// The requirements that the run held the map against, in the standard's order.
    pub requirements: &'a [&'a Requirement],
    /// From which severity on a finding makes the run fail.
    pub fail_on: FailOn,
    /// The least severity that people are shown finding by finding; what is below it is counted. Formats for programs keep all.
    pub show: Severity,
    /// Most findings of one code that are shown; all are counted. `None` shows all.
    pub cap: Option<usize>,
    /// Findings left out because the user said so, with a reason.
    pub suppressed: usize,
    /// Findings left out because the baseline knows them.
    pub known: usize,
    /// Those of them that somebody lets be for a reason.
    pub accepted: &'a [Accepted],
    /// The way from the plane to the globe.
    pub unproject: Option<Unproject<'a>>,
    /// Paths in reports for code hosts are relative to this directory, the root of the repository; `None` leaves them
    /// as the user gave them.
    pub root: Option<&'a std::path::Path>,
}

/// One finding with what every format looks up for it.
#[derive(Debug)]
pub struct Entry<'a> {
    /// The finding.
    pub diagnostic: &'a Diagnostic,
    /// Where it stands in its file.
    pub position: Option<Position<'a>>,
    /// Its name across runs.
    pub fingerprint: String,
}

impl<'a> Entry<'a> {
    /// What it is about.
    pub fn subject(&self) -> Subject {
        self.diagnostic.finding.subject
    }
}

impl<'a> Report<'a> {
    /// Findings of a map with nothing left out and no limits; the other fields are there to be set.
    pub fn new(diagnostics: &'a [Diagnostic], sources: &'a Sources<'a>, map: &'a LaneletMap) -> Self {
        Self {
            diagnostics,
            sources,
            map,
            requirements: &[],
            fail_on: FailOn::Error,
            show: Severity::Info,
            cap: None,
            suppressed: 0,
            known: 0,
            accepted: &[],
            unproject: None,
            root: None,
        }
    }

    /// All findings in the order of the run.
    pub fn entries(&self) -> Vec<Entry<'a>> {
        let mut fingerprints = Fingerprints::default();
        self.diagnostics
            .iter()
            .map(|diagnostic| Entry {
                diagnostic,
                position: diagnostic.span.as_ref().and_then(|span| self.sources.position(span)),
                fingerprint: fingerprints.next(diagnostic),
            })
            .collect()
    }

    /// The findings that somebody lets be for a reason, each with it.
    pub fn accepted_entries(&self) -> Vec<(Entry<'a>, &'a str)> {
        let mut fingerprints = Fingerprints::default();
        let entry = |Accepted { found, reason }: &'a Accepted| {
            let position = found.span.as_ref().and_then(|span| self.sources.position(span));
            (Entry { diagnostic: found, position, fingerprint: fingerprints.next(found) }, reason.as_str())
        };
        self.accepted.iter().map(entry).collect()
    }

    /// All findings, the worst first, else in the order of the run.
    pub fn worst_first(&self) -> Vec<Entry<'a>> {
        let mut entries = self.entries();
        entries.sort_by_key(|entry| std::cmp::Reverse(entry.diagnostic.severity));
        entries
    }

    /// Whether a finding makes the run fail.
    pub fn fails(&self, diagnostic: &Diagnostic) -> bool {
        exit_code(std::slice::from_ref(diagnostic), self.fail_on) != 0
    }

    /// The chains that lead to primitives.
    pub fn referrers(&self) -> Referrers {
        Referrers::new(self.map)
    }

    /// A file's name as a path from the root of the repository, with `/` between its parts; unchanged where it lies
    /// elsewhere.
    pub fn path(&self, name: &str) -> String {
        let Some(root) = self.root else { return name.to_owned() };
        let Ok(absolute) = std::path::absolute(name) else { return name.to_owned() };
        match absolute.strip_prefix(root) {
            Ok(inside) => {
                let parts: Vec<_> = inside.components().map(|part| part.as_os_str().to_string_lossy()).collect();
                parts.join("/")
            }
            Err(_) => name.to_owned(),
        }
    }

    /// The place a code host shows for a finding that has none of its own: the top of the first file.
    fn top(&self) -> Option<Position<'a>> {
        self.sources.names().next().map(|name| Position { name, line: 1, column: 1 })
    }
}

/// Rule and slug of a code.
pub fn split_code(code: &str) -> (&str, &str) {
    code.split_once('/').unwrap_or((code, ""))
}
