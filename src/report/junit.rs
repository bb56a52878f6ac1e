//! JUnit XML: a test case for every requirement, so that a build server shows the map's state as it shows tests.

use std::collections::BTreeMap;
use std::io::{self, Write};

use super::{Entry, Report, TOOL, details, line, split_code};
use crate::lanelet::referrers::Referrers;
use crate::requirement::{Check, Requirement};

/// Writes one suite. A requirement fails if one of its findings makes the run fail; its other findings stand in the
/// case's output. One that no program can judge is skipped.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    let entries = report.entries();
    let mut by_rule: BTreeMap<&str, Vec<&Entry<'_>>> = BTreeMap::new();
    for entry in &entries {
        by_rule.entry(split_code(&entry.diagnostic.code).0).or_default().push(entry);
    }
    let mut cases: Vec<Case<'_>> = report
        .requirements
        .iter()
        .map(|requirement| Case {
            id: &requirement.id,
            requirement: Some(requirement),
            entries: by_rule.remove(requirement.id.as_str()).unwrap_or_default(),
        })
        .collect();
    cases.extend(by_rule.into_iter().map(|(id, entries)| Case { id, requirement: None, entries }));

    let failures = cases.iter().filter(|case| case.failures(report) > 0).count();
    let skipped = cases.iter().filter(|case| case.is_skipped()).count();
    let counts = format!(r#"tests="{}" failures="{failures}" errors="0" skipped="{skipped}""#, cases.len());
    writeln!(out, r#"<?xml version="1.0" encoding="UTF-8"?>"#)?;
    writeln!(out, r#"<testsuites name="{TOOL}" {counts}>"#)?;
    let files: Vec<&str> = report.sources.names().collect();
    writeln!(out, r#"  <testsuite name="{}" {counts}>"#, escape(&files.join(", ")))?;
    let referrers = report.referrers();
    cases.iter().try_for_each(|case| case.write(report, &referrers, out))?;
    writeln!(out, "  </testsuite>\n</testsuites>")
}

struct Case<'a> {
    id: &'a str,
    requirement: Option<&'a Requirement>,
    entries: Vec<&'a Entry<'a>>,
}

impl Case<'_> {
    fn failures(&self, report: &Report<'_>) -> usize {
        self.entries.iter().filter(|entry| report.fails(entry.diagnostic)).count()
    }

    fn is_skipped(&self) -> bool {
        self.entries.is_empty() && self.requirement.is_some_and(|requirement| requirement.check == Check::Manual)
    }

    fn write(&self, report: &Report<'_>, referrers: &Referrers, out: &mut dyn Write) -> io::Result<()> {
        let title = self.requirement.map_or(String::new(), |requirement| format!(" {}", requirement.title));
        let class = self.requirement.map_or(self.id, |requirement| &requirement.category);
        let head =
            format!(r#"    <testcase classname="{}" name="{}""#, escape(class), escape(&format!("{}{title}", self.id)));
        if self.is_skipped() {
            return writeln!(out, "{head}>\n      <skipped message=\"needs eyes\"/>\n    </testcase>");
        }
        if self.entries.is_empty() {
            return writeln!(out, "{head}/>");
        }
        let (failing, others): (Vec<&Entry<'_>>, Vec<&Entry<'_>>) =
            self.entries.iter().partition(|entry| report.fails(entry.diagnostic));
        writeln!(out, "{head}>")?;
        if let Some(worst) = failing.iter().map(|entry| entry.diagnostic.severity).max() {
            let count = failing.len();
            let noun = if count == 1 { "finding" } else { "findings" };
            writeln!(out, r#"      <failure message="{count} {noun}" type="{worst}">"#)?;
            lines(report, referrers, &failing, out)?;
            writeln!(out, "      </failure>")?;
        }
        if !others.is_empty() {
            writeln!(out, "      <system-out>")?;
            lines(report, referrers, &others, out)?;
            writeln!(out, "      </system-out>")?;
        }
        writeln!(out, "    </testcase>")
    }
}

fn lines(report: &Report<'_>, referrers: &Referrers, entries: &[&Entry<'_>], out: &mut dyn Write) -> io::Result<()> {
    let shown = report.cap.unwrap_or(entries.len()).min(entries.len());
    for entry in &entries[..shown] {
        writeln!(out, "{}", escape(&line(entry.diagnostic, entry.position)))?;
        for detail in details(entry.diagnostic, &referrers.chain(report.map, entry.subject())) {
            writeln!(out, "    {}", escape(&detail))?;
        }
    }
    if shown < entries.len() {
        writeln!(out, "and {} more", entries.len() - shown)?;
    }
    Ok(())
}

/// XML text. What XML 1.0 cannot hold even escaped becomes the replacement character.
fn escape(text: &str) -> String {
    let allowed =
        |c: char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{d7ff}' | '\u{e000}'..='\u{fffd}' | '\u{10000}'..);
    let text: String = text.chars().map(|c| if allowed(c) { c } else { '\u{fffd}' }).collect();
    quick_xml::escape::escape(text.as_str()).replace('\n', "&#10;").replace('\r', "&#13;")
}
