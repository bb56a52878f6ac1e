//! The map's files with their line starts, so that a byte offset becomes a line at once.

use std::borrow::Cow;

use miette::{MietteError, MietteSpanContents, SourceCode, SourceSpan as Span, SpanContents};
use rayon::prelude::*;

use super::escape::{is_plain, visible};
use crate::diagnostic::SourceSpan;
use crate::parallel::InSmallParts;

/// More bytes than this around a label are not shown: some programs write a whole map on one line.
const MOST_CONTEXT: usize = 300;

/// Bytes between two places of a long line whose columns are known.
const STRIDE: usize = 4096;

/// All files of a map.
#[derive(Debug)]
pub struct Sources<'a> {
    files: Vec<SourceFile<'a>>,
}

/// A place in a file, as editors count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position<'a> {
    /// The file's name as the user gave it.
    pub name: &'a str,
    /// From 1.
    pub line: usize,
    /// In characters, from 1.
    pub column: usize,
}

/// One file.
#[derive(Debug)]
pub(super) struct SourceFile<'a> {
    name: &'a str,
    /// Of the same length as the file's, with nothing that a terminal would obey.
    text: Cow<'a, str>,
    /// Offset of the first byte of each line.
    lines: Vec<usize>,
    /// Offsets within long lines, with their columns from 0.
    columns: Vec<(usize, usize)>,
}

impl<'a> Sources<'a> {
    /// From names and texts, in the order of `SourceSpan::file`.
    pub fn new(files: impl IntoIterator<Item = (&'a str, &'a str)>) -> Self {
        let files = files.into_iter().map(|(name, text)| {
            let breaks = text.bytes().enumerate().filter(|&(_, b)| b == b'\n').map(|(at, _)| at + 1);
            let lines: Vec<usize> = std::iter::once(0).chain(breaks).collect();
            SourceFile { name, columns: columns(text, &lines), lines, text: harmless(text) }
        });
        Self { files: files.collect() }
    }

    /// The position of an element; `None` for an unknown file or one without text.
    pub fn position(&self, span: &SourceSpan) -> Option<Position<'a>> {
        let file = self.file(span)?;
        let (line, column) = file.position(file.clip(span.start));
        Some(Position { name: file.name, line: line + 1, column: column + 1 })
    }

    /// The names of the files, in reading order.
    pub fn names(&self) -> impl Iterator<Item = &'a str> {
        self.files.iter().map(|file| file.name)
    }

    /// The text of an element, without anything that a terminal would obey.
    pub(super) fn text(&self, span: &SourceSpan) -> Option<&str> {
        let file = self.file(span)?;
        file.text.get(file.clip(span.start)..file.clip(span.end))
    }

    /// The file of a span, if its text is known.
    pub(super) fn file(&self, span: &SourceSpan) -> Option<&SourceFile<'a>> {
        self.files.get(span.file as usize).filter(|file| !file.text.is_empty())
    }
}

/// An offset held to a text and to the start of a character.
pub(super) fn boundary(text: &str, offset: usize) -> usize {
    let mut at = offset.min(text.len());
    while !text.is_char_boundary(at) {
        at -= 1;
    }
    at
}

/// Places within long lines, about every [`STRIDE`] bytes, so that no column is counted over a whole file.
fn columns(text: &str, lines: &[usize]) -> Vec<(usize, usize)> {
    let mut columns = Vec::new();
    let ends = lines.iter().skip(1).copied().chain([text.len()]);
    for (&start, end) in lines.iter().zip(ends) {
        let (mut at, mut column) = (start, 0);
        while end - at > STRIDE {
            let next = boundary(text, at + STRIDE);
            column += text.get(at..next).map_or(0, |piece| piece.chars().count());
            at = next;
            columns.push((at, column));
        }
    }
    columns
}

/// Whether all bytes are letters that a terminal shows, or blanks. It has no way out before the end, so that the processor looks at
/// many bytes at a time.
fn is_printable_ascii(piece: &[u8]) -> bool {
    piece.iter().fold(true, |all, byte| all & matches!(byte, b' '..=b'~' | b'\t' | b'\n' | b'\r'))
}

/// The text with characters that a terminal would obey replaced by others of the same length.
fn harmless(text: &str) -> Cow<'_, str> {
    /// Bytes that one thread looks at.
    const CHUNK: usize = 1 << 20;
    let harms = |c: char| !matches!(c, '\t' | '\n' | '\r') && !is_plain(c);
    // Most maps, and most lines of the others, are plain ASCII, which is faster to tell than that no letter does harm.
    let plain =
        text.as_bytes().par_chunks(CHUNK).in_small_parts().all(|part| part.chunks(STRIDE).all(is_printable_ascii));
    if plain || text.split('\n').all(|line| is_printable_ascii(line.as_bytes()) || !line.contains(harms)) {
        return Cow::Borrowed(text);
    }
    let replaced = |c: char| match c.len_utf8() {
        _ if !harms(c) => c,
        1 => '?',
        2 => '\u{bf}',
        _ => char::REPLACEMENT_CHARACTER,
    };
    Cow::Owned(text.chars().map(replaced).collect())
}

impl SourceFile<'_> {
    /// An offset held to the text and to the start of a character.
    fn clip(&self, offset: u64) -> usize {
        boundary(&self.text, usize::try_from(offset).unwrap_or(usize::MAX))
    }

    /// Line and column in characters, from 0.
    fn position(&self, offset: usize) -> (usize, usize) {
        let line = self.lines.partition_point(|&start| start <= offset).saturating_sub(1);
        let start = (self.lines.get(line).copied().unwrap_or(0), 0);
        let within = self.columns.partition_point(|&(at, _)| at <= offset).checked_sub(1);
        let (from, column) = within.and_then(|at| self.columns.get(at)).copied().unwrap_or(start).max(start);
        (line, column + self.text.get(from..offset).map_or(0, |before| before.chars().count()))
    }

    /// Offset and length of an element's first line, which is its opening tag.
    pub(super) fn first_line(&self, span: &SourceSpan) -> (usize, usize) {
        let start = self.clip(span.start);
        let end = self.clip(span.end).max(start);
        let element = self.text.get(start..end).unwrap_or_default();
        let length = element.find('\n').unwrap_or(element.len()).min(MOST_CONTEXT);
        (start, self.clip((start + length) as u64) - start)
    }
}

impl SourceCode for SourceFile<'_> {
    /// miette's own reader counts lines from the first byte of the file for every label; this one looks them up.
    fn read_span<'a>(
        &'a self,
        span: &Span,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn SpanContents<'a> + 'a>, MietteError> {
        let (start, end) = (span.offset(), span.offset().saturating_add(span.len()));
        if end > self.text.len() {
            return Err(MietteError::OutOfBounds);
        }
        let line_of = |offset: usize| self.lines.partition_point(|&first| first <= offset).saturating_sub(1);
        let first = match lines_before {
            // Asked for the place alone, miette shows where the contents begin.
            0 => start,
            _ => self.lines.get(line_of(start).saturating_sub(lines_before)).copied().unwrap_or(0),
        };
        // The context ends before the line break of its last line.
        let behind = self.lines.get(line_of(end) + lines_after + 1).map_or(self.text.len(), |next| next - 1);
        let from = self.clip(first.max(start.saturating_sub(MOST_CONTEXT)) as u64);
        let to = self.clip(behind.min(end.saturating_add(MOST_CONTEXT)).max(end) as u64);
        let (line, column) = self.position(from);
        let data = self.text.get(from..to).ok_or(MietteError::OutOfBounds)?.as_bytes();
        let lines = self.lines.len();
        let contents = MietteSpanContents::new_named(
            visible(self.name).into_owned(),
            data,
            (from, to - from).into(),
            line,
            column,
            lines,
        );
        Ok(Box::new(contents))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn span(start: u64, end: u64) -> SourceSpan {
        SourceSpan { file: 0, start, end }
    }

    #[test]
    fn offsets_become_lines_and_columns() {
        let sources = Sources::new([("a.osm", "<a>\n  é<b/>\n</a>\n")]);
        let at = |offset| sources.position(&span(offset, offset)).map(|p| (p.line, p.column));
        assert_eq!(at(0), Some((1, 1)));
        assert_eq!(at(4), Some((2, 1)));
        assert_eq!(at(8), Some((2, 4)), "é is one character of two bytes");
        assert_eq!(at(9_999), Some((4, 1)), "held to the text");
        assert_eq!(sources.position(&SourceSpan { file: 1, start: 0, end: 0 }), None);
    }

    #[test]
    fn columns_of_a_long_line_are_known() {
        let text = format!("<a>\n{}", "é".repeat(STRIDE * 2));
        let sources = Sources::new([("a.osm", text.as_str())]);
        for at in [0, 1, STRIDE / 2, STRIDE / 2 + 1, STRIDE * 2 - 1] {
            let offset = (4 + at * 2) as u64;
            let found = sources.position(&span(offset, offset)).unwrap();
            assert_eq!((found.line, found.column), (2, at + 1));
        }
    }

    #[test]
    fn nothing_in_a_file_steers_the_terminal() {
        let shown = harmless("a\u{1b}[2J\u{9b}\u{202e}\r\n\tb");
        assert_eq!(shown, "a?[2J\u{bf}\u{fffd}\r\n\tb");
        assert_eq!(shown.len(), "a\u{1b}[2J\u{9b}\u{202e}\r\n\tb".len());
        assert!(matches!(harmless("plain é 停止線\n"), Cow::Borrowed(_)));
    }

    #[test]
    fn context_is_whole_lines_but_never_a_whole_map() {
        let text = format!("<osm>\n<x/>\n<y/>\n{}\n", "z".repeat(10_000));
        let sources = Sources::new([("a.osm", text.as_str())]);
        let file = sources.file(&span(0, 1)).unwrap();
        let read = |offset: usize, length: usize| {
            let contents = file.read_span(&(offset, length).into(), 1, 1).unwrap();
            (String::from_utf8(contents.data().to_vec()).unwrap(), contents.line(), contents.column())
        };
        assert_eq!(read(6, 4), ("<osm>\n<x/>\n<y/>".to_owned(), 0, 0));
        let (long, line, column) = read(5_000, 10);
        assert!(long.len() <= 2 * MOST_CONTEXT + 10, "{}", long.len());
        assert_eq!((line, column), (3, 5_000 - 16 - MOST_CONTEXT));
    }
}
