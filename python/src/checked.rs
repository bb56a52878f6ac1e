//! `check`: a map held against the rules.

use std::path::PathBuf;
use std::sync::Arc;

use lanewright::api::{CheckOptions, Checked, Configuration, Error};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use serde_json::Value;

use crate::arguments::{self, Any};
use crate::built::map_input;
use crate::findings::{Found, objects, rows, taken};
use crate::{errors, json, work};

/// What a check says, without the map.
#[derive(Debug)]
pub struct Outcome {
    /// The report without its findings.
    document: Value,
    found: Vec<Arc<Found>>,
    /// The findings as a baseline.
    baseline: Arc<lanewright::triage::Baseline>,
}

impl Outcome {
    /// Takes from a checked map what is shown of it; the map itself is given back.
    pub fn of(checked: &Checked) -> Result<Self, Error> {
        let (document, found) = checked.with_report(taken).map_err(|error| Error::internal(error.to_string()))?;
        Ok(Self { document, found, baseline: Arc::new(checked.baseline()) })
    }

    fn total(&self, key: &str) -> u64 {
        self.document.get("totals").and_then(|totals| totals.get(key)).and_then(Value::as_u64).unwrap_or_default()
    }
}

/// Check a Lanelet2 map against Autoware's requirements.
///
/// What is wrong with the map is not an exception but a finding.
///
/// Args:
///     map: A .osm file, a directory of .osm files, a map directory, the content of a .osm file as bytes, or a BuiltMap.
///         Beside a path, map_projector_info.yaml and lanewright.toml are read; beside bytes nothing is.
///     profile: Whose reading of the requirements counts: 'ours', or 'tier4' for that of TIER IV's existing validator.
///     select: Only these rules or faults, as 'vm-03' or 'vm-03-08/closed': a str with commas, or a list of str.
///     ignore: Not these rules or faults.
///     baseline: A file that write_baseline wrote, or its content as bytes: what it lists is left out.
///     config: Settings (docs/configuration.md): a file to read instead of lanewright.toml, 'KEY=VALUE', a mapping such as
///         {'parameters': {'vm-03-08': {'spike': 2.0}}}, or a list of these, of which the last counts most.
///     isolated: Whether to read no lanewright.toml that is not named.
///     name: What messages call a map that is given as bytes.
///     threads: How many threads share the work; one for each processor if None. The result is the same.
///
/// Returns:
///     The findings, as a CheckResult.
///
/// Raises:
///     ReadError: The map or the baseline cannot be read, or is none.
///     ConfigError: Settings cannot be read, or name what is not there.
///     TypeError, ValueError: An argument is of the wrong type, or has a value that there is not.
#[pyfunction]
#[pyo3(signature = (map, *, profile=None, select=None, ignore=None, baseline=None, config=None, isolated=false, name=None, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn check(
    py: Python<'_>,
    map: Any<'_, '_>,
    profile: Option<Any<'_, '_>>,
    select: Option<Any<'_, '_>>,
    ignore: Option<Any<'_, '_>>,
    baseline: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
    name: Option<String>,
    threads: Option<Any<'_, '_>>,
) -> PyResult<CheckResult> {
    let map = map_input(map, name)?;
    let configuration = Configuration {
        profile: arguments::profile(profile)?,
        select: arguments::words("select", select)?,
        ignore: arguments::words("ignore", ignore)?,
        ..arguments::configuration(config, isolated)?
    };
    let baseline = baseline.map(|given| arguments::input("baseline", given, None)).transpose()?;
    let options = CheckOptions { configuration, baseline, ..CheckOptions::default() };
    let outcome =
        work::run(py, arguments::threads(threads)?, move || Outcome::of(&lanewright::check(map.read()?, options)?))?;
    CheckResult::new(py, outcome)
}

/// What was found in a map. It can be iterated: `for finding in result`.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct CheckResult {
    outcome: Outcome,
    findings: Py<PyTuple>,
}

impl CheckResult {
    /// With its findings as objects.
    pub fn new(py: Python<'_>, outcome: Outcome) -> PyResult<Self> {
        Ok(Self { findings: objects(py, &outcome.found)?, outcome })
    }
}

#[pymethods]
impl CheckResult {
    /// The findings that count, in the order of the rules.
    #[getter]
    fn findings(&self, py: Python<'_>) -> Py<PyTuple> {
        self.findings.clone_ref(py)
    }

    /// How many findings are errors: the map does not load, Autoware crashes, or a rule of the road is unsafe or without effect.
    #[getter]
    fn errors(&self) -> u64 {
        self.outcome.total("error")
    }

    /// How many findings are warnings: degraded behaviour, or a requirement broken.
    #[getter]
    fn warnings(&self) -> u64 {
        self.outcome.total("warning")
    }

    /// How many findings are hints for a review.
    #[getter]
    fn infos(&self) -> u64 {
        self.outcome.total("info")
    }

    /// How many findings were left out because settings or the map suppress them.
    #[getter]
    fn suppressed(&self) -> u64 {
        self.outcome.total("suppressed")
    }

    /// How many findings were left out because the baseline knows them.
    #[getter]
    fn known(&self) -> u64 {
        self.outcome.total("baseline")
    }

    /// Whether there is no error.
    #[getter]
    fn ok(&self) -> bool {
        self.errors() == 0
    }

    /// The files of the map, in reading order.
    #[getter]
    fn files(&self) -> Vec<String> {
        let files = self.outcome.document.get("files").and_then(Value::as_array).into_iter().flatten();
        files.filter_map(|file| file.as_str().map(str::to_owned)).collect()
    }

    /// How many findings there are of each code, the most frequent first.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let counts = PyDict::new(py);
        let codes = self.outcome.document.pointer("/totals/codes").and_then(Value::as_array);
        for code in codes.into_iter().flatten() {
            let key = code.get("code").and_then(Value::as_str).unwrap_or_default();
            counts.set_item(key, code.get("count").and_then(Value::as_u64))?;
        }
        Ok(counts)
    }

    /// The whole report as a dictionary that JSON can hold: docs/report.schema.json, with all findings.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let document = json::to_python(py, &self.outcome.document)?;
        let findings = PyList::empty(py);
        for one in &self.outcome.found {
            findings.append(json::to_python(py, &one.value)?)?;
        }
        document.set_item("findings", findings)?;
        Ok(document)
    }

    /// A GeoJSON FeatureCollection, a feature for each finding, in degrees: for geopandas.GeoDataFrame.from_features.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        json::collection(py, self.outcome.found.iter().map(|one| &one.feature))
    }

    /// A flat dictionary for each finding: for pandas.DataFrame.
    fn to_rows<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        rows(py, &self.outcome.found)
    }

    /// Write all findings into a baseline, which a later check leaves out.
    ///
    /// Args:
    ///     path: The file, written whole or not at all.
    ///
    /// Raises:
    ///     WriteError: It cannot be written.
    fn write_baseline(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let baseline = self.outcome.baseline.clone();
        py.detach(move || lanewright::api::write_baseline(&baseline, &path)).map_err(|error| errors::raised(py, error))
    }

    fn __len__(&self) -> usize {
        self.outcome.found.len()
    }

    fn __bool__(&self) -> bool {
        true
    }

    fn __iter__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, pyo3::types::PyIterator>> {
        self.findings.bind(py).try_iter()
    }

    fn __repr__(&self) -> String {
        format!("<CheckResult: {} errors, {} warnings, {} infos>", self.errors(), self.warnings(), self.infos())
    }
}
