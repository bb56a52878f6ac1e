//! Why a run failed, as people see it: what is wrong, where in the file, and a way out.

use std::fmt;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, SourceCode};

use super::source::{SourceFile, boundary};
use super::{Sources, TextStyle, visible_lines};
use crate::diagnostic::SourceSpan;

/// Why a run failed.
#[derive(Debug)]
pub struct Failure {
    message: String,
    help: Option<String>,
    /// The file it is about, where it has no place in it.
    file: Option<String>,
    place: Option<Box<FilePlace>>,
}

/// A place in a file.
#[derive(Debug)]
struct FilePlace {
    name: String,
    text: String,
    /// Bytes from the begin of the text.
    offset: usize,
}

/// Letters of a message that are shown: a file may hold a word of any length.
const MOST_LETTERS: usize = 2000;

/// A message that is longer than [`MOST_LETTERS`] without its middle.
fn shortened(message: String) -> String {
    let letters = message.chars().count();
    if letters <= MOST_LETTERS {
        return message;
    }
    let (begin, end) = (MOST_LETTERS / 2, MOST_LETTERS / 4);
    let left_out = letters - begin - end;
    let head: String = message.chars().take(begin).collect();
    let tail: String = message.chars().skip(begin + left_out).collect();
    format!("{head}[{left_out} letters left out]{tail}")
}

impl Failure {
    /// A failure with one line that says what is wrong.
    pub fn new(message: impl Into<String>) -> Self {
        Self { message: shortened(message.into()), help: None, file: None, place: None }
    }

    /// Adds a way out.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// Shows the place, a byte offset into the whole text of a file.
    #[must_use]
    pub fn at(mut self, file: &str, text: impl Into<String>, offset: usize) -> Self {
        self.place = Some(Box::new(FilePlace { name: file.to_owned(), text: text.into(), offset }));
        self
    }

    /// Names the file that it is about, for whoever asks: the message says it already.
    #[must_use]
    pub fn about(mut self, file: impl Into<String>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// With other words for what the program says: where the command line is not what the reader types.
    #[must_use]
    pub fn reworded(mut self, words: impl Fn(&str) -> String) -> Self {
        self.message = words(&self.message);
        self.help = self.help.as_deref().map(&words);
        self
    }

    /// What is wrong, in one line.
    pub fn message(&self) -> &str {
        &self.message
    }

    /// A way out, where one is known.
    pub fn way_out(&self) -> Option<&str> {
        self.help.as_deref()
    }

    /// The file that it is about, where it is about one.
    pub fn file(&self) -> Option<&str> {
        self.place.as_ref().map(|place| &place.name).or(self.file.as_ref()).map(String::as_str)
    }

    /// Line and column of its place in the file, both from 1, the column in characters.
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        let FilePlace { text, offset, .. } = self.place.as_deref()?;
        let before = &text[..boundary(text, *offset)];
        let line = before.rsplit('\n').next().unwrap_or_default();
        Some((before.matches('\n').count() + 1, line.chars().count() + 1))
    }

    /// The report, several lines, with a line feed at its end.
    pub fn render(&self, style: TextStyle) -> String {
        let theme = if style.color { GraphicalTheme::unicode() } else { GraphicalTheme::unicode_nocolor() };
        // Not wrapped: a command to copy must stay in one piece.
        let handler = GraphicalReportHandler::new_themed(theme)
            .with_width(style.width)
            .with_wrap_lines(false)
            .without_cause_chain();
        let sources = Sources::new(self.place.iter().map(|place| (place.name.as_str(), place.text.as_str())));
        let offset = self.place.as_ref().map_or(0, |place| place.offset as u64);
        let span = SourceSpan { file: 0, start: offset, end: offset };
        let seen = Seen { failure: self, file: sources.file(&span), span };
        let mut text = String::new();
        match handler.render_report(&mut text, &seen) {
            Ok(()) => text,
            Err(fmt::Error) => format!("error: {}\n", visible_lines(&self.message)),
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

/// A failure as miette sees it.
#[derive(Debug)]
struct Seen<'a> {
    failure: &'a Failure,
    file: Option<&'a SourceFile<'a>>,
    span: SourceSpan,
}

impl fmt::Display for Seen<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&visible_lines(&self.failure.message))
    }
}

impl std::error::Error for Seen<'_> {}

impl miette::Diagnostic for Seen<'_> {
    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.failure.help.as_ref().map(|help| Box::new(visible_lines(help)) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.file.map(|file| file as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        let (start, _) = self.file?.first_line(&self.span);
        Some(Box::new(std::iter::once(LabeledSpan::new(Some("here".to_owned()), start, 0))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn message_place_and_way_out_are_shown() {
        let text = "<osm>\n  <node id=\"1\"\n</osm>\n";
        let failure = Failure::new("not well-formed XML").help("download it again").at("a.osm", text, 21);
        let report = failure.render(TextStyle::default());
        assert_eq!((failure.file(), failure.line_and_column()), (Some("a.osm"), Some((3, 1))));
        for part in ["not well-formed XML", "a.osm:3:1", "</osm>", "download it again"] {
            assert!(report.contains(part), "{part} is missing in:\n{report}");
        }
    }

    #[test]
    fn a_file_of_one_long_line_is_not_shown_whole() {
        let text = "é".repeat(1_000_000);
        let report = Failure::new("bad").at("a.osm", &text, 999_999).render(TextStyle::default());
        assert!(report.len() < 4_000, "{} bytes", report.len());
        assert!(report.contains("a.osm:1:"), "{report}");
    }

    #[test]
    fn a_place_behind_the_end_is_the_end() {
        let report = Failure::new("cut off").at("a.osm", "<osm>\n", 99).render(TextStyle::default());
        assert!(report.contains("a.osm:"), "{report}");
    }
}
