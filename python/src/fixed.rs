//! `fix`: a map mended.

use std::sync::Arc;

use lanewright::api::{Configuration, EditedFile, Edits, Error, FixOptions};
use lanewright::fix::{Mend as Done, Scope};
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};
use serde_json::{Value, json};

use crate::arguments::{self, Any};
use crate::built::map_input;
use crate::checked::{CheckResult, Outcome};
use crate::{errors, json, work};

/// Mend a Lanelet2 map by the smallest change to its text.
///
/// Each fix is judged by checking again; one that brings a new error is not kept. Nothing is written unless `write` is True,
/// or FixResult.write is called.
///
/// Args:
///     map: A .osm file, a directory of .osm files, a map directory, the content of a .osm file as bytes, or a BuiltMap.
///     unsafe: Whether to make fixes, too, that need review afterwards.
///     write: Whether to change the files in place, all or none.
///     profile: Whose reading of the requirements counts: 'ours' or 'tier4'.
///     select: Only what these rules or faults find: a str with commas, or a list of str.
///     ignore: Not what these rules or faults find.
///     config: Settings (docs/configuration.md): a file to read instead of lanewright.toml, 'KEY=VALUE', a mapping, or a list of
///         these, of which the last counts most.
///     isolated: Whether to read no lanewright.toml that is not named.
///     name: What messages call a map that is given as bytes.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     What was done, what is left, and the changed text, as a FixResult.
///
/// Raises:
///     ReadError: The map cannot be read, or is none.
///     ConfigError: Settings cannot be read, or name what is not there.
///     WriteError: The files cannot be written, or the map is packed or was given as bytes.
///     TypeError, ValueError: An argument is of the wrong type, or has a value that there is not.
#[pyfunction]
#[pyo3(signature = (map, *, r#unsafe=false, write=false, profile=None, select=None, ignore=None, config=None, isolated=false, name=None, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn fix(
    py: Python<'_>,
    map: Any<'_, '_>,
    r#unsafe: bool,
    write: bool,
    profile: Option<Any<'_, '_>>,
    select: Option<Any<'_, '_>>,
    ignore: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
    name: Option<String>,
    threads: Option<Any<'_, '_>>,
) -> PyResult<FixResult> {
    let map = map_input(map, name)?;
    let configuration = Configuration {
        profile: arguments::profile(profile)?,
        select: arguments::words("select", select)?,
        ignore: arguments::words("ignore", ignore)?,
        ..arguments::configuration(config, isolated)?
    };
    let scope = Scope { unsafe_too: r#unsafe, ..Scope::default() }.naming(&configuration.select);
    let options = FixOptions { configuration, scope, baseline: None };
    let (mended, left) = work::run(py, arguments::threads(threads)?, move || {
        let fixed = lanewright::fix(map.read()?, &options)?;
        if write {
            fixed.write()?;
        }
        let one = match &fixed.mended.osm.sources[..] {
            [only] => Some(only.as_written()),
            _ => None,
        };
        let mended = Mended {
            diff: fixed.diff(),
            edits: Arc::new(fixed.edits()),
            osm: one,
            done: fixed.mended.done.iter().map(Mend::of).collect(),
            refused: fixed.mended.refused.iter().map(|(mend, _)| Mend::of(mend)).collect(),
            unsafe_left: fixed.mended.unsafe_left,
        };
        Ok::<_, Error>((mended, Outcome::of(&fixed.into_left())?))
    })?;
    Ok(FixResult { mended, left: Py::new(py, CheckResult::new(py, left)?)? })
}

/// A fix, and what it mends.
#[pyclass(frozen, eq, hash, get_all, module = "lanewright")]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Mend {
    /// Code of the finding: 'vm-03-08/lane-node-missing'.
    pub code: String,
    /// Kind of the primitive.
    pub kind: &'static str,
    /// Id of the primitive; None for the map as a whole.
    pub id: Option<i64>,
    /// What the fix does, in one line.
    pub title: String,
}

impl Mend {
    fn of(done: &Done) -> Self {
        let Done { code, subject, title } = done.clone();
        Self { code, kind: subject.kind(), id: subject.id(), title }
    }

    fn value(&self) -> Value {
        json!({ "code": self.code, "kind": self.kind, "id": self.id, "title": self.title })
    }
}

#[pymethods]
impl Mend {
    /// All of it as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.value())
    }

    fn __repr__(&self) -> String {
        let id = self.id.map_or(String::new(), |id| format!(" {id}"));
        format!("<Mend [{}] {}{id}: {}>", self.code, self.kind, self.title)
    }
}

/// What is kept of mending.
#[derive(Debug)]
struct Mended {
    diff: String,
    edits: Arc<Edits>,
    osm: Option<String>,
    done: Vec<Mend>,
    refused: Vec<Mend>,
    unsafe_left: usize,
}

/// What came of mending a map.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct FixResult {
    mended: Mended,
    left: Py<CheckResult>,
}

#[pymethods]
impl FixResult {
    /// What was done, in order.
    #[getter]
    fn fixed(&self) -> Vec<Mend> {
        self.mended.done.clone()
    }

    /// What was tried and not kept: it brought a new error, or did not mend what it was for.
    #[getter]
    fn refused(&self) -> Vec<Mend> {
        self.mended.refused.clone()
    }

    /// What is left to find in the map.
    #[getter]
    fn left(&self, py: Python<'_>) -> Py<CheckResult> {
        self.left.clone_ref(py)
    }

    /// How many of the findings left have a fix that needs review first.
    #[getter]
    fn unsafe_left(&self) -> usize {
        self.mended.unsafe_left
    }

    /// Whether anything in the files changes.
    #[getter]
    fn changed(&self) -> bool {
        !self.mended.edits.files.is_empty()
    }

    /// A unified diff of every file that changes; empty where none does.
    #[getter]
    fn diff(&self) -> &str {
        &self.mended.diff
    }

    /// The files that change, by name: their new content.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        for EditedFile { source, .. } in &self.mended.edits.files {
            files.set_item(&source.name, PyBytes::new(py, source.as_written().as_bytes()))?;
        }
        Ok(files)
    }

    /// The map's content as it is now, changed or not; None for a map of several files.
    #[getter]
    fn osm<'py>(&self, py: Python<'py>) -> Option<Bound<'py, PyBytes>> {
        self.mended.osm.as_ref().map(|text| PyBytes::new(py, text.as_bytes()))
    }

    /// Change the files in place, all or none.
    ///
    /// Raises:
    ///     WriteError: They cannot be written or were changed after they were read, or the map is packed or was given as bytes.
    fn write(&self, py: Python<'_>) -> PyResult<()> {
        let edits = self.mended.edits.clone();
        py.detach(move || edits.write()).map_err(|error| errors::raised(py, error))
    }

    /// All of it but the files' content as a dictionary that JSON can hold.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let values = |mends: &[Mend]| mends.iter().map(Mend::value).collect::<Vec<_>>();
        let value = json!({
            "fixed": values(&self.mended.done),
            "refused": values(&self.mended.refused),
            "unsafe_left": self.mended.unsafe_left,
            "diff": self.mended.diff,
        });
        let dict = json::to_python(py, &value)?;
        dict.set_item("left", self.left.bind(py).call_method0("to_dict")?)?;
        Ok(dict)
    }

    /// The findings left as a GeoJSON FeatureCollection.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.left.bind(py).call_method0("to_geojson")
    }

    fn __repr__(&self, py: Python<'_>) -> PyResult<String> {
        let Mended { done, refused, .. } = &self.mended;
        let left = self.left.bind(py).len()?;
        Ok(format!("<FixResult: {} fixed, {} refused, {left} findings left>", done.len(), refused.len()))
    }
}
