//! Markdown of a rule's document as text for a terminal: paragraphs and items wrapped, links as their words.

use std::fmt::Write;

/// The text, lines at most `width` columns wide. Code blocks and tables stay as they are, and pictures are named with their file.
pub fn prose(markdown: &str, width: usize) -> String {
    let mut text = String::new();
    let mut block: Option<Block> = None;
    let mut in_code = false;
    for line in markdown.lines() {
        let fence = line.trim_start().starts_with("```");
        if in_code || fence || is_kept(line) {
            finish(&mut text, block.take(), width);
            text += &picture(line).unwrap_or_else(|| line.to_owned());
            text.push('\n');
            in_code ^= fence;
        } else if let Some(marker) = marker(line) {
            finish(&mut text, block.take(), width);
            block = Some(Block { hanging: marker, words: line.to_owned() });
        } else if let Some(block) = &mut block {
            let _ = write!(block.words, " {}", line.trim_start());
        } else {
            block = Some(Block { hanging: 0, words: line.to_owned() });
        }
    }
    finish(&mut text, block, width);
    text
}

/// A paragraph, or an item of a list.
struct Block {
    /// Columns by which lines after the first are indented.
    hanging: usize,
    words: String,
}

fn finish(text: &mut String, block: Option<Block>, width: usize) {
    let Some(Block { hanging, words }) = block else { return };
    let indent = " ".repeat(hanging);
    let options = textwrap::Options::new(width).subsequent_indent(&indent).break_words(false);
    *text += &textwrap::fill(&without_links(&words), options);
    text.push('\n');
}

/// Lines that are never joined with others: blank ones, headings, rows of tables, pictures.
fn is_kept(line: &str) -> bool {
    line.trim().is_empty() || ["#", "|", "!["].iter().any(|start| line.starts_with(start))
}

/// Columns that the marker of a list's item takes, its indentation included; `None` if the line begins no item.
fn marker(line: &str) -> Option<usize> {
    let rest = line.trim_start();
    let indent = line.len() - rest.len();
    let digits = rest.bytes().take_while(u8::is_ascii_digit).count();
    let numbered = digits > 0 && rest.get(digits..).is_some_and(|rest| rest.starts_with(". "));
    match () {
        () if rest.starts_with("* ") || rest.starts_with("- ") => Some(indent + 2),
        () if numbered => Some(indent + digits + 2),
        () => None,
    }
}

/// A terminal shows no pictures: it says where they are.
fn picture(line: &str) -> Option<String> {
    let (what, path) = line.strip_prefix("![")?.split_once("](")?;
    Some(format!("[{what}: rules/{}]", path.trim_end_matches(')')))
}

/// `[words](target)` becomes `words`.
fn without_links(text: &str) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, link)) = rest.split_once('[') {
        out += before;
        match link.split_once("](").and_then(|(words, more)| Some((words, more.split_once(')')?.1))) {
            Some((words, more)) if !words.contains('[') => {
                out += words;
                rest = more;
            }
            _ => {
                out.push('[');
                rest = link;
            }
        }
    }
    out + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paragraphs_and_items_are_wrapped() {
        let text = prose("one two\nthree four\n\n* five six\n  seven\n* eight\n\n1. nine ten eleven\n", 14);
        assert_eq!(text, "one two three\nfour\n\n* five six\n  seven\n* eight\n\n1. nine ten\n   eleven\n");
    }

    #[test]
    fn what_has_a_shape_of_its_own_stays() {
        let kept = "## A heading that is longer than the line\n\n| a | b |\n|---|---|\n\n```\ncode that is longer than the line\n```\n";
        assert_eq!(prose(kept, 10), kept);
    }

    #[test]
    fn links_are_their_words() {
        assert_eq!(prose("see [the page](a/b.md), [1] and [x](y)", 80), "see the page, [1] and x\n");
        assert_eq!(prose("![good](pictures/good.svg)", 80), "[good: rules/pictures/good.svg]\n");
    }
}
