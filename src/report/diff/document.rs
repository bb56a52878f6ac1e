//! The document of the kinds of change, as `explain diff` shows it.

use std::sync::LazyLock;

use crate::requirement::{DocumentError, Requirement};

/// The document of the kinds of change.
///
/// # Errors
///
/// If a document of `rules/` was spoilt before compiling, which a test prevents.
pub fn requirement() -> Result<&'static Requirement, &'static DocumentError> {
    static DOCUMENT: LazyLock<Result<Requirement, DocumentError>> =
        LazyLock::new(|| Requirement::parse("diff", include_str!("../../../rules/diff.md")));
    DOCUMENT.as_ref()
}
