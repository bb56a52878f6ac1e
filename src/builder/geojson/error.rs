//! Why a file of streets cannot be read.

/// Why a file cannot be read.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ReadError {
    /// What is wrong, in one line.
    pub message: String,
    /// A way out, in one line.
    pub help: &'static str,
    /// Byte offset in the text.
    pub offset: usize,
}

impl ReadError {
    pub(super) fn new(offset: usize, message: String, help: &'static str) -> Self {
        Self { message, help, offset }
    }

    /// What the JSON reader says of a piece of the text that begins at a byte.
    pub(super) fn json(piece: &str, offset: usize, error: &serde_json::Error) -> Self {
        let line_start = piece.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
        let mut at = (line_start + error.column().saturating_sub(1)).min(piece.len());
        while !piece.is_char_boundary(at) {
            at -= 1;
        }
        let said = error.to_string();
        let message = said.rsplit_once(" at line ").map_or(said.as_str(), |(message, _)| message).to_owned();
        Self::new(offset + at, message, "docs/geometry.md says what each feature may hold")
    }
}
