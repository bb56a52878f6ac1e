//! What was found, for people at a terminal: the worst first, what is alike in one entry, and what to do next.

use std::io::{self, Write};

use super::consequences::causes;
use super::details::spot;
use super::{Group, Report, TextStyle, groups, summary, visible};
use crate::diagnostic::{Diagnostic, Severity, Subject};

/// Places that an entry shows; the others are counted.
const PLACES: usize = 3;
/// Entries that one code gets at one severity; what is in none of them is counted.
const ENTRIES: usize = 3;

/// What a user may do after a check, as far as the report cannot tell.
#[derive(Clone, Copy, Debug)]
pub struct Next<'a> {
    /// The map as the user named it.
    pub map: &'a str,
    /// Whether `fix` edits maps that are stored like this one.
    pub fixable: bool,
    /// A page that was written.
    pub page: Option<&'a str>,
}

/// Writes how much was found, an entry for each cause, a line for each code that is only counted, and what to do next.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn text(out: &mut dyn Write, report: &Report<'_>, next: &Next<'_>, style: TextStyle) -> io::Result<()> {
    let found = report.diagnostics;
    if found.is_empty() {
        return writeln!(out, "{}", summary(found));
    }
    writeln!(out, "{}: {}\n", visible(next.map), summary(found))?;
    let messages = found.iter().map(|one| (one.severity, one.code.as_str(), one.finding.message.as_str()));
    let mut groups = groups(messages, report.requirements);
    // What follows from another finding is counted under it, where that is shown.
    let is_shown = |at: &usize| found[*at].severity >= report.show;
    let causes: Vec<Option<usize>> = causes(found, report.map).into_iter().map(|one| one.filter(is_shown)).collect();
    groups.iter_mut().for_each(|group| group.members.retain(|&at| causes[at].is_none()));
    groups.retain(|group| !group.members.is_empty());
    let (shown, counted) = groups.split_at(groups.partition_point(|group| group.severity >= report.show));
    for of_code in shown.chunk_by(|one, other| (one.severity, &one.code) == (other.severity, &other.code)) {
        let (told, others) = of_code.split_at(of_code.len().min(ENTRIES));
        told.iter().try_for_each(|group| entry(out, report, group, &causes, style))?;
        if !others.is_empty() {
            let count: usize = others.iter().map(|group| group.members.len()).sum();
            writeln!(out, "{} {count} more that say something else\n", head(&others[0], style))?;
        }
    }
    write_counted(out, counted)?;
    writeln!(out, "{}", summary(found))?;
    write_next(out, report, next, &groups, style)
}

/// Severity and code.
fn head(group: &Group, style: TextStyle) -> String {
    let color = match group.severity {
        Severity::Error => "1;31",
        Severity::Warning => "1;33",
        Severity::Info => "1;36",
    };
    format!(
        "{}{}",
        paint(color, &group.severity.to_string(), style),
        paint("1", &format!("[{}]", visible(&group.code)), style)
    )
}

fn paint(code: &str, text: &str, style: TextStyle) -> String {
    if style.color { format!("\u{1b}[{code}m{text}\u{1b}[0m") } else { text.to_owned() }
}

/// What is wrong, how often, where first, and how to mend it.
fn entry(
    out: &mut dyn Write,
    report: &Report<'_>,
    group: &Group,
    causes: &[Option<usize>],
    style: TextStyle,
) -> io::Result<()> {
    let members: Vec<&Diagnostic> = group.members.iter().map(|&at| &report.diagnostics[at]).collect();
    let times = if members.len() > 1 { format!("{} × ", members.len()) } else { String::new() };
    writeln!(out, "{} {times}{}", head(group, style), visible(&group.sentence))?;
    write_places(out, report, &members)?;
    let first = members[0];
    let follow =
        causes.iter().zip(report.diagnostics).filter(|(cause, _)| cause.is_some_and(|at| group.members.contains(&at)));
    let follow: Vec<Severity> = follow.map(|(_, one)| one.severity).collect();
    if !follow.is_empty() {
        let count = |severity| follow.iter().filter(|one| **one == severity).count();
        let counts = [Severity::Error, Severity::Warning, Severity::Info].map(|severity| (count(severity), severity));
        let counts = counts.into_iter().filter(|(count, _)| *count > 0);
        let plural = |count: usize| if count == 1 { "" } else { "s" };
        let counts = counts.map(|(count, severity)| format!("{count} {severity}{}", plural(count)));
        let counts: Vec<String> = counts.collect();
        let verb = if follow.len() == 1 { "follows" } else { "follow" };
        writeln!(out, "  {} {} more {verb} from this", paint("36", "so:", style), counts.join(", "))?;
    }
    if let Some(help) = &first.help {
        writeln!(out, "  {} {}", paint("36", "help:", style), visible(help))?;
    }
    if let Some(fix) = how_fixed(&members) {
        writeln!(out, "  {} {fix}", paint("36", "fix:", style))?;
    }
    if let ([_], [_, ..]) = (members.as_slice(), first.finding.related.as_slice()) {
        let related = first.finding.related.iter().map(|one| format!("{} ({})", one.subject, one.part));
        writeln!(out, "  {} {}", paint("36", "see also:", style), related.collect::<Vec<_>>().join(", "))?;
    }
    writeln!(out)
}

/// The first places in columns: file and line, primitive, latitude and longitude; how many there are beside them.
fn write_places(out: &mut dyn Write, report: &Report<'_>, members: &[&Diagnostic]) -> io::Result<()> {
    let row = |one: &&Diagnostic| {
        let position = one.span.as_ref().and_then(|span| report.sources.position(span));
        let position = position.map_or(String::new(), |at| format!("{}:{}:{}", visible(at.name), at.line, at.column));
        let subject = if one.finding.subject == Subject::Map { String::new() } else { one.finding.subject.to_string() };
        [position, subject, spot(one).unwrap_or_default()]
    };
    let rows: Vec<[String; 3]> = members.iter().take(PLACES).map(row).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let widths = [width(0), width(1), width(2)];
    let more = members.len() - rows.len();
    for (at, row) in rows.iter().enumerate() {
        let cells = row.iter().zip(widths).filter(|(_, width)| *width > 0);
        let mut cells: Vec<String> = cells.map(|(cell, width)| format!("{cell:<width$}")).collect();
        if at + 1 == PLACES && more > 0 {
            cells.push(format!("and {more} more"));
        }
        if !cells.is_empty() {
            writeln!(out, "  {}", cells.join("  ").trim_end())?;
        }
    }
    Ok(())
}

/// What `fix` would do about an entry.
fn how_fixed(members: &[&Diagnostic]) -> Option<String> {
    if let [one] = members {
        let fix = one.finding.fix.as_ref()?;
        let look = if fix.safe { "" } else { " (needs review: --unsafe)" };
        return Some(format!("{}{look}", visible(&fix.title)));
    }
    let (safe, others) = fixes(members.iter().copied());
    let parts = [(safe, "safely"), (others, "needs review (--unsafe)")];
    let parts: Vec<String> = parts.iter().filter(|(n, _)| *n > 0).map(|(n, how)| format!("{n} {how}")).collect();
    (!parts.is_empty()).then(|| parts.join(", "))
}

/// How many findings have a fix that is safe, and how many one that needs review.
fn fixes<'a>(found: impl Iterator<Item = &'a Diagnostic>) -> (usize, usize) {
    found
        .filter_map(|one| one.finding.fix.as_ref())
        .fold((0, 0), |(safe, others), fix| if fix.safe { (safe + 1, others) } else { (safe, others + 1) })
}

/// How many there are of each code that is not shown, with what most of them say.
fn write_counted(out: &mut dyn Write, groups: &[Group]) -> io::Result<()> {
    let Some(worst) = groups.first().map(|group| group.severity) else { return Ok(()) };
    writeln!(
        out,
        "counted only; --show {} shows them:",
        if worst == Severity::Info { "info" } else { "warning or info" }
    )?;
    let of_code: Vec<(usize, &Group)> = groups
        .chunk_by(|one, other| (one.severity, &one.code) == (other.severity, &other.code))
        .map(|of_code| (of_code.iter().map(|group| group.members.len()).sum(), &of_code[0]))
        .collect();
    let digits = of_code.iter().map(|(count, _)| count.to_string().len()).max().unwrap_or(0);
    let width = of_code.iter().map(|(_, group)| group.code.len()).max().unwrap_or(0);
    for (count, Group { severity, code, sentence, .. }) in of_code {
        let severity = severity.to_string();
        writeln!(out, "  {count:>digits$}  {severity:<7}  {:<width$}  {}", visible(code), visible(sentence))?;
    }
    writeln!(out)
}

/// Commands that lead on from here.
fn write_next(
    out: &mut dyn Write,
    report: &Report<'_>,
    next: &Next<'_>,
    groups: &[Group],
    style: TextStyle,
) -> io::Result<()> {
    let map = quoted(next.map);
    let mut steps = Vec::new();
    if let Some(first) = groups.first() {
        steps.push(("understand", format!("lanewright explain {}", visible(&first.code)), String::new()));
    }
    let fix = match fixes(report.diagnostics.iter()) {
        (0, 0) => None,
        (0, others) => Some((" --unsafe", format!("{others} that need review; --diff shows how"))),
        (safe, 0) => Some(("", format!("{safe} safely; --diff shows how"))),
        (safe, others) => {
            Some(("", format!("{safe} safely, with --unsafe {others} more that need review; --diff shows how")))
        }
    };
    if let (true, Some((how, what))) = (next.fixable, fix) {
        steps.push(("mend", format!("lanewright fix {map}{how}"), format!("  ({what})")));
    }
    let look = next.page.map_or_else(|| format!("lanewright check {map} --report report.html"), quoted);
    steps.push(("look", look, String::new()));
    if groups.iter().any(|group| group.severity < report.show || group.members.len() > PLACES) {
        steps.push(("list all", format!("lanewright check {map} --format concise"), String::new()));
    }
    writeln!(out, "next:")?;
    steps.iter().try_for_each(|(aim, command, what)| writeln!(out, "  {aim:<10}  {}{what}", paint("1", command, style)))
}

/// A path as a shell takes it.
fn quoted(path: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "/._-+@%:,=".contains(c);
    let path = visible(path);
    if !path.is_empty() && path.chars().all(plain) {
        path.into_owned()
    } else {
        format!("'{}'", path.replace('\'', "'\\''"))
    }
}
