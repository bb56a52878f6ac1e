//! What a build says of its input: what was guessed, left out, or could not be built as it should.

use std::sync::Arc;

use lanewright::diagnostic::{Finding, Place as Where, Severity};
use lanewright::geometry::Point;
use lanewright::projection::{LonLat, Projector};
use lanewright::report::geojson;
use pyo3::prelude::*;
use pyo3::types::PyTuple;
use serde_json::{Value, json};

use crate::findings::{Found, Measure, Place, Primitive};
use crate::json;

/// Notes, with their places on Earth.
pub fn taken<'a>(notes: impl IntoIterator<Item = &'a Finding>, projector: &Projector) -> Vec<Arc<Found>> {
    let to_globe =
        |points: &[Point]| -> Option<Vec<LonLat>> { projector.inverse_each(points, |_| 0.0).into_iter().collect() };
    let of_note = |note: &Finding| {
        let middle = middle(&note.place);
        let globe = middle.and_then(|at| to_globe(&[at])?.first().copied());
        let primitive = json!({ "kind": note.subject.kind(), "id": note.subject.id() });
        let (kind, points): (_, &[Point]) = match &note.place {
            Where::Unknown => (None, &[]),
            Where::Point(point) => (Some("point"), std::slice::from_ref(point)),
            Where::Line(points) => (Some("line"), points),
            Where::Polygon(ring) => (Some("polygon"), ring),
        };
        let points: Vec<[f64; 2]> = points.iter().map(|point| [point.x, point.y]).collect();
        let related = note.related.iter();
        let value = json!({
            "code": note.fault,
            "severity": note.severity.unwrap_or(Severity::Info),
            "primitive": primitive,
            "related": related
                .map(|one| json!({ "part": one.part, "kind": one.subject.kind(), "id": one.subject.id() }))
                .collect::<Vec<_>>(),
            "position": middle.map(|at| json!({
                "lat": globe.map(|globe| globe.lat),
                "lon": globe.map(|globe| globe.lon),
                "x": at.x,
                "y": at.y,
            })),
            "place": kind.map(|kind| json!({ "kind": kind, "points": points })),
            "measure": note.measure,
            "message": note.message,
        });
        let feature = json!({
            "type": "Feature",
            "geometry": geojson::place(&note.place, &to_globe),
            "properties": {
                "code": note.fault,
                "severity": note.severity.unwrap_or(Severity::Info),
                "primitive": note.subject.kind(),
                "id": note.subject.id(),
                "message": note.message,
                "lat": globe.map(|globe| globe.lat),
                "lon": globe.map(|globe| globe.lon),
                "x": middle.map(|at| at.x),
                "y": middle.map(|at| at.y),
            },
        });
        Arc::new(Found { value, feature })
    };
    notes.into_iter().map(of_note).collect()
}

fn middle(place: &Where) -> Option<Point> {
    match place {
        Where::Unknown => None,
        Where::Point(point) => Some(*point),
        Where::Line(points) => points.get(points.len() / 2).copied(),
        Where::Polygon(ring) => {
            let sum = ring.iter().fold([0.0, 0.0], |sum, point| [sum[0] + point.x, sum[1] + point.y]);
            let count = ring.len() as f64;
            (!ring.is_empty()).then(|| Point::new(sum[0] / count, sum[1] / count))
        }
    }
}

/// Notes as Python's objects.
pub fn objects(py: Python<'_>, notes: &[Arc<Found>]) -> PyResult<Py<PyTuple>> {
    let objects = notes.iter().map(|found| Py::new(py, Note { found: found.clone() }));
    Ok(PyTuple::new(py, objects.collect::<PyResult<Vec<_>>>()?)?.unbind())
}

/// Notes as values.
pub fn values(notes: &[Arc<Found>]) -> Value {
    notes.iter().map(|note| note.value.clone()).collect()
}

/// What a build says of one place of its input: what was guessed, left out, or could not be built as it should.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct Note {
    found: Arc<Found>,
}

#[pymethods]
impl Note {
    /// What it is about, in a word: 'speed-guessed'.
    #[getter]
    fn code(&self) -> &str {
        self.found.text("/code").unwrap_or_default()
    }

    /// 'info' for a guess, 'warning' or 'error' for what is worse.
    #[getter]
    fn severity(&self) -> &str {
        self.found.text("/severity").unwrap_or_default()
    }

    /// What there is to say, in one line.
    #[getter]
    fn message(&self) -> &str {
        self.found.text("/message").unwrap_or_default()
    }

    /// Kind of the element that it is about: of OpenStreetMap 'node', 'way' or 'relation'; of the map 'lanelet' and so on.
    #[getter]
    fn kind(&self) -> &str {
        self.found.text("/primitive/kind").unwrap_or_default()
    }

    /// Id of the element; None for the map as a whole.
    #[getter]
    fn id(&self) -> Option<i64> {
        self.found.integer("/primitive/id")
    }

    /// The other elements that have a part in it.
    #[getter]
    fn related(&self) -> Vec<Primitive> {
        self.found.primitives("/related")
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

    /// What it points at, or None.
    #[getter]
    fn place(&self) -> Option<Place> {
        self.found.place()
    }

    /// Value and limit, where something was measured, or None.
    #[getter]
    fn measure(&self) -> Option<Measure> {
        self.found.measure()
    }

    /// All of it as a dictionary that JSON can hold.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.found.value)
    }

    /// A GeoJSON feature, its geometry in degrees, or None where it has no place.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.found.feature)
    }

    fn __repr__(&self) -> String {
        let id = self.id().map_or(String::new(), |id| format!(" {id}"));
        format!("<Note {} [{}] {}{id}: {}>", self.severity(), self.code(), self.kind(), self.message())
    }
}
