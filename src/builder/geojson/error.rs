//! The error of reading a file of streets.

/// Why a file cannot be read, and where.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct ReadError {
    /// What is wrong, in one line.
    pub message: String,
    /// What to do, in one line.
    pub help: &'static str,
    /// Byte offset in the text.
    pub offset: usize,
}

impl ReadError {
    pub(super) fn new(offset: usize, message: String, help: &'static str) -> Self {
        Self { message, help, offset }
    }

    /// An error of the JSON parser in `piece`, which begins at byte `offset` of the file.
    pub(super) fn json(piece: &str, offset: usize, error: &serde_json::Error) -> Self {
        let line_start = piece.split_inclusive('\n').take(error.line().saturating_sub(1)).map(str::len).sum::<usize>();
        let mut position = (line_start + error.column().saturating_sub(1)).min(piece.len());
        while !piece.is_char_boundary(position) {
            position -= 1;
        }
        let text = error.to_string();
        let message = text.rsplit_once(" at line ").map_or(text.as_str(), |(message, _)| message).to_owned();
        Self::new(offset + position, message, "docs/geometry.md says what each feature may hold")
    }
}
