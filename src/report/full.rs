//! Every finding by itself, for people at a terminal: file, line, snippet, help. The only file that shows findings by miette.

use std::fmt;
use std::io::{self, Write};

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, SourceCode};

use super::source::SourceFile;
use super::{Report, details, summary, visible};
use crate::diagnostic::{Diagnostic, Severity};

/// How the terminal wants it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TextStyle {
    /// Whether to colour.
    pub color: bool,
    /// Characters per line.
    pub width: usize,
}

impl Default for TextStyle {
    fn default() -> Self {
        Self { color: false, width: 100 }
    }
}

/// Writes the findings that are shown, the worst first, then the summary.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn full(out: &mut dyn Write, report: &Report<'_>, style: TextStyle) -> io::Result<()> {
    let Report { diagnostics, sources, map, .. } = *report;
    let referrers = report.referrers();
    let theme = if style.color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
    let handler = GraphicalReportHandler::new_themed(theme).with_width(style.width).with_links(false);
    let mut shown: Vec<&Diagnostic> = diagnostics.iter().filter(|one| one.severity >= report.show).collect();
    shown.sort_by_key(|one| std::cmp::Reverse(one.severity));
    for diagnostic in shown {
        let file = diagnostic.span.as_ref().and_then(|span| sources.file(span));
        let mut rendered = String::new();
        let details = details(diagnostic, &referrers.chain(map, diagnostic.finding.subject)).join("\n");
        handler.render_report(&mut rendered, &Shown { diagnostic, file, details }).map_err(io::Error::other)?;
        writeln!(out, "{}", rendered.trim_end())?;
        writeln!(out)?;
    }
    writeln!(out, "{}", summary(diagnostics))
}

/// A finding as miette sees it.
#[derive(Debug)]
struct Shown<'a> {
    diagnostic: &'a Diagnostic,
    file: Option<&'a SourceFile<'a>>,
    details: String,
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible(&self.diagnostic.finding.message))
    }
}

impl std::error::Error for Shown<'_> {}

impl miette::Diagnostic for Shown<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(&self.diagnostic.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.diagnostic.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
            Severity::Info => miette::Severity::Advice,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        (!self.details.is_empty()).then(|| Box::new(&self.details) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.file.map(|file| file as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (start, length) = self.file?.first_line(self.diagnostic.span.as_ref()?);
        let label = self.diagnostic.finding.subject.to_string();
        Some(Box::new(std::iter::once(LabeledSpan::new(Some(label), start, length))))
    }
}
