//! The Python module `lanewright._lanewright`: the library's verbs as functions, and the command line as it is.
//!
//! Each function turns its arguments into the library's options (`arguments`), does the work on threads of its own while the
//! interpreter goes on (`work`), and hands back an object that holds the result.

mod arguments;
mod built;
mod checked;
mod command;
mod errors;
mod findings;
mod fixed;
mod json;
mod notes;
mod rules;
mod streets;
mod tiles;
mod work;

use pyo3::prelude::*;

/// As in the program; of the module's own memory only, not of Python's.
#[cfg(feature = "allocator")]
#[global_allocator]
static ALLOCATOR: tikv_jemallocator::Jemalloc = tikv_jemallocator::Jemalloc;

/// As in the program (`main.rs`).
#[cfg(feature = "allocator")]
#[allow(unsafe_code, reason = "a name for the linker; nothing else has it")]
#[unsafe(export_name = "_rjem_malloc_conf")]
pub static ALLOCATION: &[u8] = b"dirty_decay_ms:100,muzzy_decay_ms:0\0";

/// What lanewright does, for Python: see the package `lanewright`, which brings all of it.
#[pymodule(gil_used = false)]
fn _lanewright(module: &Bound<'_, PyModule>) -> PyResult<()> {
    work::keep_panics();
    module.add("__version__", lanewright::report::VERSION)?;
    errors::add(module)?;
    module.add_function(wrap_pyfunction!(built::build, module)?)?;
    module.add_function(wrap_pyfunction!(streets::geometry, module)?)?;
    module.add_function(wrap_pyfunction!(checked::check, module)?)?;
    module.add_function(wrap_pyfunction!(fixed::fix, module)?)?;
    module.add_function(wrap_pyfunction!(rules::rules, module)?)?;
    module.add_function(wrap_pyfunction!(tiles::cut, module)?)?;
    module.add_function(wrap_pyfunction!(tiles::build_tile, module)?)?;
    module.add_function(wrap_pyfunction!(tiles::join_tiles, module)?)?;
    module.add_function(wrap_pyfunction!(command::main, module)?)?;
    module.add_class::<built::BuiltMap>()?;
    module.add_class::<built::BuildSummary>()?;
    module.add_class::<streets::Streets>()?;
    module.add_class::<notes::Note>()?;
    module.add_class::<checked::CheckResult>()?;
    module.add_class::<findings::Finding>()?;
    module.add_class::<findings::Primitive>()?;
    module.add_class::<findings::Place>()?;
    module.add_class::<findings::Measure>()?;
    module.add_class::<findings::Fix>()?;
    module.add_class::<fixed::FixResult>()?;
    module.add_class::<fixed::Mend>()?;
    module.add_class::<tiles::BuiltTile>()?;
    module.add_class::<tiles::JoinedTiles>()?;
    module.add_class::<rules::Rule>()?;
    module.add_class::<rules::Fault>()?;
    module.add_class::<rules::Parameter>()?;
    Ok(())
}
