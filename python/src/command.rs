//! The command `lanewright`, with all verbs.

use std::ffi::OsString;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};

use pyo3::prelude::*;
use pyo3::types::PyList;

/// Exit code of a Rust program that panicked.
const PANICKED: u8 = 101;

/// Run the command `lanewright` with all its verbs, as the program does.
///
/// It reads and writes files, prints on standard output and standard error, and raises nothing. While it runs, Ctrl-C ends the
/// process, as it ends the program.
///
/// Args:
///     argv: The arguments, without the name of the program; those of the process if None.
///
/// Returns:
///     The exit code: 0 clean, 1 findings, 2 the run failed.
#[pyfunction]
#[pyo3(signature = (argv=None))]
pub fn main(py: Python<'_>, argv: Option<Vec<OsString>>) -> PyResult<u8> {
    let given = match argv {
        Some(given) => given,
        None => py
            .import("sys")?
            .getattr("argv")?
            .cast::<PyList>()?
            .iter()
            .skip(1)
            .map(|one| one.extract())
            .collect::<PyResult<_>>()?,
    };
    let interrupt = Interrupt::left_to_the_system(py)?;
    let arguments = std::iter::once(OsString::from("lanewright")).chain(given);
    let code = py.detach(|| {
        let code = catch_unwind(AssertUnwindSafe(|| lanewright::cli::run_with(arguments))).unwrap_or(PANICKED);
        // Nobody does that for a module when the process ends. What has no reader any more was said to nobody.
        let _ = std::io::stdout().flush();
        code
    });
    interrupt.restored(py)?;
    Ok(code)
}

/// What Python did at Ctrl-C before.
struct Interrupt(Option<Py<PyAny>>);

impl Interrupt {
    /// Lets the system end the process at Ctrl-C.
    fn left_to_the_system(py: Python<'_>) -> PyResult<Self> {
        // What `signal` is made of; that one takes as long to import as a small map to build.
        let signal = py.import("_signal")?;
        let (interrupt, ignored) = (signal.getattr("SIGINT")?, signal.getattr("SIG_IGN")?);
        // Who started us where Ctrl-C is not heard wanted that.
        if signal.getattr("getsignal")?.call1((&interrupt,))?.eq(ignored)? {
            return Ok(Self(None));
        }
        // Only the main thread may say that; on another one, Ctrl-C is its business.
        let before = signal.getattr("signal")?.call1((interrupt, signal.getattr("SIG_DFL")?));
        Ok(Self(before.ok().map(Bound::unbind)))
    }

    fn restored(self, py: Python<'_>) -> PyResult<()> {
        // None where no Python code had set it.
        if let Some(before) = self.0.filter(|before| !before.is_none(py)) {
            let signal = py.import("_signal")?;
            signal.getattr("signal")?.call1((signal.getattr("SIGINT")?, before))?;
        }
        Ok(())
    }
}
