//! Why one of the verbs could not do its work.

use std::fmt;

use crate::report::TextStyle;
use crate::report::failure::Failure;

/// What a failure is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// An input cannot be read, or is not what it should be.
    Read,
    /// Settings cannot be read, or name what is not there.
    Config,
    /// The input is sound, but no map can be built from it.
    Build,
    /// A result cannot be written.
    Write,
    /// A fault of this library.
    Internal,
}

impl ErrorKind {
    pub(super) fn error(self, failure: Failure) -> Error {
        Error { kind: self, failure: Box::new(failure) }
    }

    pub(super) fn of(self) -> impl FnOnce(Failure) -> Error {
        move |failure| self.error(failure)
    }
}

/// Why one of the verbs could not do its work: what is wrong, where, and a way out.
#[derive(Debug)]
pub struct Error {
    kind: ErrorKind,
    failure: Box<Failure>,
}

impl Error {
    /// A fault of ours.
    pub fn internal(message: impl Into<String>) -> Self {
        ErrorKind::Internal.error(Failure::new(message).help("please report this"))
    }

    /// With other words for what the program says: where the command line is not what the reader types.
    #[must_use]
    pub fn reworded(self, words: impl Fn(&str) -> String) -> Self {
        Self { failure: Box::new(self.failure.reworded(words)), ..self }
    }

    /// What it is about.
    pub fn kind(&self) -> ErrorKind {
        self.kind
    }

    /// What is wrong, in one line.
    pub fn message(&self) -> &str {
        self.failure.message()
    }

    /// A way out, where one is known.
    pub fn help(&self) -> Option<&str> {
        self.failure.way_out()
    }

    /// The file that it is about, by the name it was given by; the name of an input that was given as bytes.
    pub fn file(&self) -> Option<&str> {
        self.failure.file()
    }

    /// Line and column in the file, both from 1, the column in characters.
    pub fn line_and_column(&self) -> Option<(usize, usize)> {
        self.failure.line_and_column()
    }

    /// All of it for people, with the lines of the file: several lines, with a line feed at the end.
    pub fn render(&self, style: TextStyle) -> String {
        self.failure.render(style)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.failure.fmt(f)
    }
}

impl std::error::Error for Error {}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        *error.failure
    }
}
