//! What `build` and `geometry` say of their input on the command line.

use std::fmt::Write;
use std::path::Path;

use crate::api::layout::{Layout, LayoutOptions};
use crate::builder::MERGE_UNMET;
use crate::builder::UNDRAWN;
use crate::builder::network::UNMET_ROAD;
use crate::builder::streets::consolidate::MergeNote;
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Severity};
use crate::report::failure::Failure;
use crate::report::visible;

use super::args::{LayoutArgs, SideArg, StreetArgs};
use super::check_args::ConfigArgs;
use super::output::Progress;

/// So many oddities of a file are told unasked.
const ODDITIES: usize = 10;

/// Reads an input and lays out its streets.
pub fn streets(input: &Path, args: &StreetArgs, progress: &Progress) -> Result<Layout, Failure> {
    Ok(Layout::read(input, &args.layout.options(), &|doing| progress.next(doing))?)
}

impl LayoutArgs {
    /// As the library wants them.
    pub fn options(&self) -> LayoutOptions {
        LayoutOptions {
            driving_side: match self.driving_side {
                SideArg::Left => Some(DrivingSide::Left),
                SideArg::Right => Some(DrivingSide::Right),
                SideArg::Auto => None,
            },
            projector: self.projector.map(Into::into),
            dem: self.dem.clone().map(Into::into),
            configuration: ConfigArgs { config: self.config.clone(), isolated: self.isolated, ..ConfigArgs::default() }
                .configuration(),
            ..LayoutOptions::default()
        }
    }
}

/// Whether a note is a fault of an OpenDRIVE file.
fn is_oddity(note: &Finding) -> bool {
    note.fault.starts_with("opendrive-") && note.severity != Some(Severity::Info)
}

/// Whether a note says that something which the settings want is not drawn, or that there is too much to draw it.
fn is_undrawn(note: &Finding) -> bool {
    note.fault == UNDRAWN || note.fault.starts_with("too-many-")
}

/// Whether a note says that settings meant no road.
fn is_unmet(note: &Finding) -> bool {
    [MERGE_UNMET, UNMET_ROAD].contains(&note.fault)
}

/// What is odd in an OpenDRIVE file: all of it, or how to see it. Gaps and what could not be drawn are told always.
pub fn oddities(notes: &[Finding], all: bool) -> String {
    let mut text = String::new();
    for note in notes.iter().filter(|note| is_oddity(note)).take(if all { usize::MAX } else { ODDITIES }) {
        let _ = writeln!(text, "warning: {} [{}]", visible(&note.message), note.fault);
    }
    let more = notes.iter().filter(|note| is_oddity(note)).count().saturating_sub(ODDITIES);
    if more > 0 && !all {
        let _ = writeln!(text, "and {more} more: --guesses lists them");
    }
    text
}

/// Lines that count things, each with its singular and plural.
pub fn counts(of: &[(usize, &str, &str)]) -> String {
    let mut text = String::new();
    for (count, one, many) in of {
        let _ = writeln!(text, "  {count:>7} {}", if *count == 1 { one } else { many });
    }
    text
}

/// What decided about each road that may lie inside an intersection, where that is asked for; and settings that meant
/// no road, always.
pub fn merges(notes: &[MergeNote], findings: &[Finding], args: &StreetArgs) -> String {
    let mut text = String::new();
    for note in notes.iter().filter(|_| args.explain_merges) {
        let _ = writeln!(text, "{}", visible(&note.to_string()));
    }
    for unmet in findings.iter().filter(|finding| is_unmet(finding)) {
        let _ = writeln!(text, "warning: {}", visible(&unmet.message));
    }
    text
}

/// What the settings want drawn and the map did not get, and what is too many to be drawn.
pub fn undrawn<'a>(notes: impl IntoIterator<Item = &'a Finding>) -> String {
    let mut text = String::new();
    for note in notes.into_iter().filter(|note| is_undrawn(note)) {
        let _ = writeln!(text, "warning: {}", visible(&note.message));
    }
    text
}

/// What was guessed: all of it, or how to see it; without what is told as a warning.
pub fn guesses<'a>(count: usize, notes: impl IntoIterator<Item = &'a Finding>, args: &StreetArgs) -> String {
    let mut text = String::new();
    if count > 0 && !args.guesses {
        let _ = writeln!(text, "--guesses lists what the input did not say");
    }
    let is_guess = |note: &&Finding| !is_oddity(note) && !is_undrawn(note) && !is_unmet(note);
    for Finding { fault, subject, message, .. } in notes.into_iter().filter(|_| args.guesses).filter(is_guess) {
        let subject = subject.to_string();
        // Some messages begin with what they are about.
        let message = message.strip_prefix(&format!("{subject}: ")).unwrap_or(message);
        let _ = writeln!(text, "{subject}: {} [{fault}]", visible(message));
    }
    text
}
