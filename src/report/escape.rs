//! Text from a map is a stranger's text: it must not steer a terminal.

use std::borrow::Cow;
use std::fmt::Write as _;

/// Whether a character is shown as it is. Control characters move the cursor and change colours; directional overrides
/// let a text look different from what it is.
pub(super) fn is_plain(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// The text on one line, with every character that a terminal would obey written out as `\u{1b}`.
pub fn visible(text: &str) -> Cow<'_, str> {
    if text.chars().all(is_plain) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        match c {
            c if is_plain(c) => out.push(c),
            '\n' => out.push_str("\\n"),
            '\r' => out.push_str("\\r"),
            '\t' => out.push_str("\\t"),
            c => {
                // Writing to a string cannot fail.
                let _ = write!(out, "\\u{{{:x}}}", u32::from(c));
            }
        }
    }
    Cow::Owned(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(visible("plain 停止線 é"), "plain 停止線 é");
        assert_eq!(visible("a\u{1b}[31mb\nc\r\u{202e}d\u{0}"), "a\\u{1b}[31mb\\nc\\r\\u{202e}d\\u{0}");
    }
}
