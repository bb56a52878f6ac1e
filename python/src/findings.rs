//! Findings, as objects with typed fields. They hold what the JSON report says of them (`docs/report.schema.json`).

use std::sync::Arc;

use lanewright::report::geojson;
use lanewright::report::{Report, json as report};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyTuple};
use serde_json::Value;

use crate::json;

/// One finding as JSON: as the report has it, and as a feature.
#[derive(Debug)]
pub struct Found {
    /// The finding of the report.
    pub value: Value,
    /// The feature.
    pub feature: Value,
}

impl Found {
    /// What stands at a path, as `/position/lat`.
    fn at(&self, path: &str) -> Option<&Value> {
        self.value.pointer(path).filter(|value| !value.is_null())
    }

    /// A text.
    pub fn text(&self, path: &str) -> Option<&str> {
        self.at(path)?.as_str()
    }

    /// A whole number.
    pub fn integer(&self, path: &str) -> Option<i64> {
        self.at(path)?.as_i64()
    }

    /// A number.
    pub fn number(&self, path: &str) -> Option<f64> {
        self.at(path)?.as_f64()
    }

    /// Primitives of a list.
    pub fn primitives(&self, path: &str) -> Vec<Primitive> {
        let all = self.at(path).and_then(Value::as_array).into_iter().flatten();
        let text = |one: &Value, key: &str| one.get(key).and_then(Value::as_str).map(str::to_owned);
        let primitive = |one: &Value| Primitive {
            kind: text(one, "kind").unwrap_or_default(),
            id: one.get("id").and_then(Value::as_i64),
            part: text(one, "part"),
        };
        all.map(primitive).collect()
    }

    /// What is drawn.
    pub fn place(&self) -> Option<Place> {
        let points = self.at("/place/points")?.as_array()?;
        let point = |point: &Value| Some((point.get(0)?.as_f64()?, point.get(1)?.as_f64()?));
        let points = points.iter().filter_map(point).collect();
        Some(Place { kind: self.text("/place/kind")?.to_owned(), points })
    }

    /// What was measured.
    pub fn measure(&self) -> Option<Measure> {
        Some(Measure {
            value: self.number("/measure/value")?,
            limit: self.number("/measure/limit")?,
            unit: self.text("/measure/unit")?.to_owned(),
        })
    }
}

/// The report of a run without its findings, and the findings.
pub fn taken(shown: &Report<'_>) -> serde_json::Result<(Value, Vec<Arc<Found>>)> {
    let mut document = report::value(shown)?;
    let findings = document.get_mut("findings").map(Value::take);
    let Some(Value::Array(values)) = findings else { return Ok((document, Vec::new())) };
    let features = geojson::features(shown);
    let found = values.into_iter().zip(features).map(|(value, feature)| Arc::new(Found { value, feature }));
    Ok((document, found.collect()))
}

/// Findings as Python's objects.
pub fn objects(py: Python<'_>, found: &[Arc<Found>]) -> PyResult<Py<PyTuple>> {
    let objects = found.iter().map(|found| Py::new(py, Finding { found: found.clone() }));
    Ok(PyTuple::new(py, objects.collect::<PyResult<Vec<_>>>()?)?.unbind())
}

/// A primitive of the map that has a part in a finding.
#[pyclass(frozen, eq, hash, get_all, module = "lanewright")]
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Primitive {
    /// Its kind: 'map', 'point', 'linestring', 'polygon', 'lanelet', 'regulatory element', 'node', 'way' or 'relation'.
    pub kind: String,
    /// Its id in the file; None for the map as a whole.
    pub id: Option<i64>,
    /// Its part in the finding, in a word or two, such as 'stop line'; None if it has none of its own.
    pub part: Option<String>,
}

#[pymethods]
impl Primitive {
    fn __repr__(&self) -> String {
        let id = self.id.map_or(String::new(), |id| format!(" {id}"));
        let part = self.part.as_ref().map_or(String::new(), |part| format!(" ({part})"));
        format!("<Primitive {}{id}{part}>", self.kind)
    }
}

/// Where to look, in the metres of the map.
#[pyclass(frozen, get_all, module = "lanewright")]
#[derive(Clone, Debug)]
pub struct Place {
    /// 'point', 'line' or 'polygon'. The ring of a polygon is not closed.
    pub kind: String,
    /// Its points, (x, y) in metres: east and north.
    pub points: Vec<(f64, f64)>,
}

#[pymethods]
impl Place {
    fn __repr__(&self) -> String {
        format!("<Place {} of {} points>", self.kind, self.points.len())
    }
}

/// What was measured, and the limit that it was held against.
#[pyclass(frozen, get_all, module = "lanewright")]
#[derive(Clone, Debug)]
pub struct Measure {
    /// The measured value.
    pub value: f64,
    /// The limit of the rule.
    pub limit: f64,
    /// The unit of both: 'm', 'm2', 'deg', '%' or '1'.
    pub unit: String,
}

#[pymethods]
impl Measure {
    fn __repr__(&self) -> String {
        format!("<Measure {} {}, limit {}>", self.value, self.unit, self.limit)
    }
}

/// How a program mends what was found.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct Fix {
    found: Arc<Found>,
}

#[pymethods]
impl Fix {
    /// What it does, in one line.
    #[getter]
    fn title(&self) -> &str {
        self.found.text("/fix/title").unwrap_or_default()
    }

    /// Whether it can be made without a look afterwards.
    #[getter]
    fn safe(&self) -> bool {
        self.found.at("/fix/safe").and_then(Value::as_bool).unwrap_or_default()
    }

    /// The edits in their order, as dictionaries (docs/report.schema.json).
    #[getter]
    fn edits<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        json::list(py, self.found.at("/fix/edits").and_then(Value::as_array).map_or(&[], Vec::as_slice))
    }

    fn __repr__(&self) -> String {
        format!("<Fix {:?}, {}>", self.title(), if self.safe() { "safe" } else { "needs review" })
    }
}

/// One place where a map breaks a requirement.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct Finding {
    found: Arc<Found>,
}

#[pymethods]
impl Finding {
    /// Rule and fault: 'vm-03-08/lane-node-missing'.
    #[getter]
    fn code(&self) -> &str {
        self.found.text("/code").unwrap_or_default()
    }

    /// The rule: 'vm-03-08'.
    #[getter]
    fn rule(&self) -> &str {
        self.found.text("/rule").unwrap_or_default()
    }

    /// The fault inside the rule: 'lane-node-missing'.
    #[getter]
    fn fault(&self) -> &str {
        self.found.text("/slug").unwrap_or_default()
    }

    /// 'error', 'warning' or 'info', after the settings.
    #[getter]
    fn severity(&self) -> &str {
        self.found.text("/severity").unwrap_or_default()
    }

    /// What is wrong, in one line.
    #[getter]
    fn message(&self) -> &str {
        self.found.text("/message").unwrap_or_default()
    }

    /// How to mend it, in words, or None.
    #[getter]
    fn help(&self) -> Option<&str> {
        self.found.text("/help")
    }

    /// Kind of the primitive that it is about: 'lanelet', 'linestring', 'point' and so on; 'map' for the map as a whole.
    #[getter]
    fn kind(&self) -> &str {
        self.found.text("/primitive/kind").unwrap_or_default()
    }

    /// Id of the primitive in the file; None for the map as a whole.
    #[getter]
    fn id(&self) -> Option<i64> {
        self.found.integer("/primitive/id")
    }

    /// The other primitives that have a part in it, each with its part.
    #[getter]
    fn related(&self) -> Vec<Primitive> {
        self.found.primitives("/related")
    }

    /// The primitives through which a lanelet or an area leads to the primitive, the nearest first.
    #[getter]
    fn referrers(&self) -> Vec<Primitive> {
        self.found.primitives("/referrers")
    }

    /// Longitude of its place, degrees, or None.
    #[getter]
    fn lon(&self) -> Option<f64> {
        self.found.number("/position/lon")
    }

    /// Latitude of its place, degrees, or None.
    #[getter]
    fn lat(&self) -> Option<f64> {
        self.found.number("/position/lat")
    }

    /// Its place in the map, metres to the east, or None.
    #[getter]
    fn x(&self) -> Option<f64> {
        self.found.number("/position/x")
    }

    /// Its place in the map, metres to the north, or None.
    #[getter]
    fn y(&self) -> Option<f64> {
        self.found.number("/position/y")
    }

    /// What the rule points at, or None where it is the primitive itself.
    #[getter]
    fn place(&self) -> Option<Place> {
        self.found.place()
    }

    /// Value and limit, where the rule measures, or None.
    #[getter]
    fn measure(&self) -> Option<Measure> {
        self.found.measure()
    }

    /// How a program mends it, or None.
    #[getter]
    fn fix(&self) -> Option<Fix> {
        self.found.at("/fix").map(|_| Fix { found: self.found.clone() })
    }

    /// The file in which the primitive stands, or None.
    #[getter]
    fn file(&self) -> Option<&str> {
        self.found.text("/source/file")
    }

    /// The line in which it begins, from 1, or None.
    #[getter]
    fn line(&self) -> Option<i64> {
        self.found.integer("/source/line")
    }

    /// The column in which it begins, in characters, from 1, or None.
    #[getter]
    fn column(&self) -> Option<i64> {
        self.found.integer("/source/column")
    }

    /// A name for it that stays the same while lines of the file move.
    #[getter]
    fn fingerprint(&self) -> &str {
        self.found.text("/fingerprint").unwrap_or_default()
    }

    /// All of it as a dictionary that JSON can hold, as `lanewright check --format json` writes it.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.found.value)
    }

    /// A GeoJSON feature, its geometry in degrees; of a flat shape that suits a table.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.found.feature)
    }

    fn __repr__(&self) -> String {
        let id = self.id().map_or(String::new(), |id| format!(" {id}"));
        format!("<Finding {} [{}] {}{id}: {}>", self.severity(), self.code(), self.kind(), self.message())
    }
}

/// Features as rows: their properties.
pub fn rows<'py>(py: Python<'py>, found: &[Arc<Found>]) -> PyResult<Bound<'py, PyList>> {
    let rows = PyList::empty(py);
    for one in found {
        rows.append(match one.feature.get("properties").and_then(Value::as_object) {
            Some(properties) => json::dict(py, properties)?,
            None => PyDict::new(py),
        })?;
    }
    Ok(rows)
}
