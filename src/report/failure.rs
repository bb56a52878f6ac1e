//! Why a run failed, as people see it: what is wrong, where in the file, and a way out.

use std::fmt;

use miette::{
    GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteError, MietteSpanContents, SourceCode, SourceSpan,
    SpanContents,
};

/// How a report is laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Whether the terminal shows colours and the user wants them.
    pub colour: bool,
    /// Columns of text.
    pub width: usize,
}

impl Look {
    /// Without colours and as wide as most terminals: for files, pipes and tests.
    pub const PLAIN: Self = Self { colour: false, width: 100 };

    fn theme(self) -> GraphicalTheme {
        if self.colour { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() }
    }
}

/// Why a run failed.
#[derive(Debug)]
pub struct Failure {
    message: String,
    help: Option<String>,
    excerpt: Option<Excerpt>,
}

impl Failure {
    /// A failure with one line that says what is wrong.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: message.into(), help: None, excerpt: None }
    }

    /// Adds a way out.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Shows the place, a byte offset into the whole text of a file.
    #[must_use]
    pub fn at(mut self, file: &str, text: &str, offset: usize) -> Self {
        self.excerpt = Some(Excerpt::around(file, text, offset));
        self
    }

    /// The report, several lines, with a line feed at its end.
    pub fn render(&self, look: Look) -> String {
        let handler = GraphicalReportHandler::new_themed(look.theme()).with_width(look.width).without_cause_chain();
        let mut text = String::new();
        match handler.render_report(&mut text, self) {
            Ok(()) => text,
            Err(fmt::Error) => format!("error: {}\n", self.message),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

impl miette::Diagnostic for Failure {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.excerpt.as_ref().map(|excerpt| excerpt as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let excerpt = self.excerpt.as_ref()?;
        Some(Box::new(std::iter::once(LabeledSpan::new(Some("here".to_owned()), excerpt.at, 0))))
    }
}

/// A few lines of a file. The whole file may be large, and one line of it may be the whole file.
#[derive(Debug)]
struct Excerpt {
    file: String,
    text: String,
    /// Of the excerpt's first character in the file, from 0.
    line: usize,
    /// See `line`.
    column: usize,
    /// Offset of the place in the excerpt.
    at: usize,
}

impl Excerpt {
    /// Most bytes shown before and behind the place.
    const REACH: usize = 240;

    fn around(file: &str, text: &str, offset: usize) -> Self {
        let boundary = |mut i: usize| {
            while !text.is_char_boundary(i) {
                i -= 1;
            }
            i
        };
        let offset = boundary(offset.min(text.len()));
        let line_start = text[..offset].rfind('\n').map_or(0, |i| i + 1);
        let before = text[..line_start.saturating_sub(1)].rfind('\n').map_or(0, |i| i + 1);
        let begin = boundary(before.max(offset.saturating_sub(Self::REACH)));
        let reach = boundary((offset + Self::REACH).min(text.len()));
        let end = text[offset..reach].match_indices('\n').nth(1).map_or(reach, |(i, _)| offset + i);
        let begin_of_line = text[..begin].rfind('\n').map_or(0, |i| i + 1);
        Self {
            file: file.to_owned(),
            text: text[begin..end].to_owned(),
            line: text[..begin].matches('\n').count(),
            column: text[begin_of_line..begin].chars().count(),
            at: offset - begin,
        }
    }
}

impl SourceCode for Excerpt {
    fn read_span<'a>(
        &'a self,
        span: &SourceSpan,
        before: usize,
        after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let inner = self.text.read_span(span, before, after)?;
        let column = inner.column() + if inner.line() == 0 { self.column } else { 0 };
        Ok(Box::new(MietteSpanContents::new_named(
            self.file.clone(),
            inner.data(),
            *inner.span(),
            inner.line() + self.line,
            column,
            inner.line_count(),
        )))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_place_and_way_out_are_shown() {
        let text = "<osm>\n  <node id=\"1\"\n</osm>\n";
        let failure = Failure::new("not well-formed XML").help("download it again").at("a.osm", text, 21);
        let report = failure.render(Look::PLAIN);
        for part in ["not well-formed XML", "a.osm:3:1", "</osm>", "download it again"] {
            assert!(report.contains(part), "{part} is missing in:\n{report}");
        }
    }

    #[test]
    fn a_file_of_one_long_line_is_not_shown_whole() {
        let text = "é".repeat(1_000_000);
        let report = Failure::new("bad").at("a.osm", &text, 999_999).render(Look::PLAIN);
        assert!(report.len() < 4_000, "{} bytes", report.len());
        assert!(report.contains("a.osm:1:500"), "{report}");
    }

    #[test]
    fn a_place_behind_the_end_is_the_end() {
        let report = Failure::new("cut off").at("a.osm", "<osm>\n", 99).render(Look::PLAIN);
        assert!(report.contains("a.osm:"), "{report}");
    }
}
