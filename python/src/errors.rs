//! The exceptions.

use lanewright::api::{Error as Failed, ErrorKind};
use lanewright::report::TextStyle;
use pyo3::create_exception;
use pyo3::exceptions::PyException;
use pyo3::prelude::*;
use pyo3::types::PyType;

create_exception!(
    lanewright,
    Error,
    PyException,
    "Something could not be done.

str() of it is the whole report for people, with the lines of the file.

Attributes:
    message: What is wrong, in one line.
    help: A way out, or None.
    file: The file that it is about, or the name of an input that was given as bytes, or None.
    line: The line in the file, from 1, or None.
    column: The column in the line, in characters, from 1, or None."
);
create_exception!(lanewright, ReadError, Error, "An input cannot be read, or is not what it should be.");
create_exception!(lanewright, ConfigError, Error, "Settings cannot be read, or name what is not there.");
create_exception!(lanewright, BuildError, Error, "The input is sound, but no map can be built from it.");
create_exception!(lanewright, WriteError, Error, "A result cannot be written; what was there before is unchanged.");
create_exception!(lanewright, InternalError, Error, "A fault of lanewright itself. Please report it.");

/// What every error has, be it raised by us or by somebody else.
const ATTRIBUTES: [&str; 5] = ["message", "help", "file", "line", "column"];

/// Adds the exceptions to the module.
pub fn add(module: &Bound<'_, PyModule>) -> PyResult<()> {
    let py = module.py();
    let base = py.get_type::<Error>();
    for attribute in ATTRIBUTES {
        base.setattr(attribute, py.None())?;
    }
    module.add("Error", base)?;
    module.add("ReadError", py.get_type::<ReadError>())?;
    module.add("ConfigError", py.get_type::<ConfigError>())?;
    module.add("BuildError", py.get_type::<BuildError>())?;
    module.add("WriteError", py.get_type::<WriteError>())?;
    module.add("InternalError", py.get_type::<InternalError>())
}

/// The exception for what the library could not do.
pub fn raised(py: Python<'_>, error: Failed) -> PyErr {
    let error = error.reworded(python_words);
    let class = match error.kind() {
        ErrorKind::Read => py.get_type::<ReadError>(),
        ErrorKind::Config => py.get_type::<ConfigError>(),
        ErrorKind::Build => py.get_type::<BuildError>(),
        ErrorKind::Write => py.get_type::<WriteError>(),
        _ => py.get_type::<InternalError>(),
    };
    let text = error.render(TextStyle::default());
    let place = error.line_and_column();
    with_attributes(&class, text.trim_end(), |made| {
        made.setattr("message", error.message())?;
        made.setattr("help", error.help())?;
        made.setattr("file", error.file())?;
        made.setattr("line", place.map(|(line, _)| line))?;
        made.setattr("column", place.map(|(_, column)| column))
    })
}

/// The exception for a fault of ours.
pub fn fault(py: Python<'_>, what: &str) -> PyErr {
    let message = format!("a fault in lanewright: {what}");
    with_attributes(&py.get_type::<InternalError>(), &message, |made| {
        made.setattr("message", &message)?;
        made.setattr("help", "please report this, with the input if you can")
    })
}

fn with_attributes(
    class: &Bound<'_, PyType>,
    text: &str,
    set: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>,
) -> PyErr {
    match class.call1((text,)).and_then(|made| set(&made).map(|()| made)) {
        Ok(made) => PyErr::from_value(made),
        Err(error) => error,
    }
}

/// Options as Python writes them: `--driving-side` is `driving_side`.
fn python_words(text: &str) -> String {
    let mut parts = text.split("--");
    let mut words = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let end = part.find(|c: char| !c.is_ascii_lowercase() && c != '-').unwrap_or(part.len());
        let (option, rest) = part.split_at(end);
        if option.is_empty() || words.ends_with(|c: char| !c.is_whitespace() && c != '`') {
            words += "--";
            words += part;
        } else {
            words += &option.replace('-', "_");
            words += rest;
        }
    }
    words
}
