//! Text from a map is a stranger's text: it must not steer a terminal.

use std::borrow::Cow;
use std::fmt::Write as _;
use std::io;

/// Whether a character is shown as it is. Control characters move the cursor and change colours; directional overrides
/// let a text look different from what it is.
pub(super) fn is_plain(c: char) -> bool {
    !c.is_control()
        && !matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{feff}')
}

/// Whether a line would be a command to a machine that runs CI: `::` at its begin is one to GitHub's, the others are wherever they stand.
fn is_command(line: &str) -> bool {
    line.trim_start().starts_with("::") || line.contains("##[") || line.contains("##vso[")
}

/// The line without commands.
fn without_commands(line: &str) -> String {
    let line = line.replace("##[", "#\\u{23}[").replace("##vso[", "#\\u{23}vso[");
    match line.trim_start().strip_prefix("::") {
        Some(rest) => format!("{}\\u{{3a}}:{rest}", &line[..line.len() - line.trim_start().len()]),
        None => line,
    }
}

/// The text on one line, with every character that a terminal would obey written out as `\u{1b}`.
pub fn visible(text: &str) -> Cow<'_, str> {
    if is_command(text) {
        return Cow::Owned(visible(&without_commands(text)).into_owned());
    }
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

/// A text of several lines, each as [`visible`] has it; tabs and line ends stay.
pub fn visible_lines(text: &str) -> Cow<'_, str> {
    lines(text, is_plain)
}

/// A patch: what steers no terminal stays as it is in the file, such as marks of direction, so that it fits there.
pub fn visible_patch(text: &str) -> Cow<'_, str> {
    lines(text, |c| !c.is_control())
}

fn lines(text: &str, is_plain: impl Fn(char) -> bool) -> Cow<'_, str> {
    let is_harmless = |line: &str| !is_command(line) && line.chars().all(|c| c == '\t' || is_plain(c));
    let split = |line: &str| match line.strip_suffix('\r') {
        Some(line) => (line.to_owned(), "\r"),
        None => (line.to_owned(), ""),
    };
    if text.split('\n').all(|line| is_harmless(line.strip_suffix('\r').unwrap_or(line))) {
        return Cow::Borrowed(text);
    }
    let mut out = String::with_capacity(text.len() + 64);
    for (at, line) in text.split('\n').enumerate() {
        let (line, end) = split(line);
        if at > 0 {
            out.push('\n');
        }
        for c in without_commands(&line).chars() {
            if c == '\t' || is_plain(c) { out.push(c) } else { out.push_str(&visible(c.encode_utf8(&mut [0; 4]))) }
        }
        out.push_str(end);
    }
    Cow::Owned(out)
}

/// Passes JSON on with what would steer a terminal, or a machine that runs CI, as escapes: it stands in strings alone, so that the
/// document says the same.
pub struct HarmlessJson<'a> {
    out: &'a mut dyn io::Write,
    /// The begin of a letter that comes in two pieces.
    rest: Vec<u8>,
}

impl<'a> HarmlessJson<'a> {
    /// Passes JSON on to `out`.
    pub fn new(out: &'a mut dyn io::Write) -> Self {
        Self { out, rest: Vec::new() }
    }
}

impl io::Write for HarmlessJson<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.rest.is_empty()
            && bytes.iter().all(|byte| matches!(byte, b' '..=b'~' | b'\n' | b'\t'))
            && !bytes.contains(&b'#')
        {
            self.out.write_all(bytes)?;
            return Ok(bytes.len());
        }
        self.rest.extend_from_slice(bytes);
        let whole = match std::str::from_utf8(&self.rest) {
            Err(error) if error.error_len().is_none() => error.valid_up_to(),
            _ => self.rest.len(),
        };
        let rest = self.rest.split_off(whole);
        let text = String::from_utf8_lossy(&self.rest).replace("##[", "#\\u0023[").replace("##vso[", "#\\u0023vso[");
        let mut shown = String::with_capacity(text.len());
        for c in text.chars() {
            if is_plain(c) || matches!(c, '\n' | '\t') {
                shown.push(c)
            } else {
                let _ = write!(shown, "\\u{:04x}", u32::from(c));
            }
        }
        self.rest = rest;
        self.out.write_all(shown.as_bytes())?;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_says_the_same_without_steering() {
        let meant =
            serde_json::json!({ "a": "\u{1b}[0m\u{9b}2J ##[error] ##vso[x] \u{202e} é 停止線 \u{7f}", "b": [1, null] });
        let text = serde_json::to_string_pretty(&meant).unwrap();
        for piece in [1, 2, 3, text.len()] {
            let mut out = Vec::new();
            let mut writer = HarmlessJson::new(&mut out);
            // As it is written, a command may not come in pieces; a letter may.
            let pieces = if piece < 4 { text.replace("##", "# ").into_bytes() } else { text.clone().into_bytes() };
            pieces.chunks(piece).for_each(|piece| io::Write::write_all(&mut writer, piece).unwrap());
            let shown = String::from_utf8(out).unwrap();
            assert!(!shown.chars().any(|c| c != '\n' && !is_plain(c)) && !shown.contains("##"), "{shown}");
            if piece == text.len() {
                assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), meant);
            }
        }
    }

    #[test]
    fn what_a_terminal_obeys_is_written_out() {
        assert_eq!(visible("plain 停止線 é"), "plain 停止線 é");
        assert_eq!(visible("::error::a"), "\\u{3a}:error::a");
        assert_eq!(visible("a ##[error]b ##vso[c]"), "a #\\u{23}[error]b #\\u{23}vso[c]");
        assert_eq!(visible_lines("a\tb\r\n  ::error::\n\u{9b}c\rd\n"), "a\tb\r\n  \\u{3a}:error::\n\\u{9b}c\\rd\n");
        assert_eq!(visible_patch("\u{feff}a\u{200f}\u{1b}[0m"), "\u{feff}a\u{200f}\\u{1b}[0m");
        assert_eq!(visible("a\u{1b}[31mb\nc\r\u{202e}d\u{0}"), "a\\u{1b}[31mb\\nc\\r\\u{202e}d\\u{0}");
    }
}
