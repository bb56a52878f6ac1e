//! The Python module `lanewright._lanewright`.
#![allow(missing_docs)]
use pyo3::prelude::*;

#[pymodule]
fn _lanewright(_m: &Bound<'_, PyModule>) -> PyResult<()> {
    Ok(())
}
