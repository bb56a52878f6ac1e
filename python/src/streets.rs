//! `geometry`: streets laid out, before they become a map.

use std::path::PathBuf;
use std::sync::Arc;

use lanewright::api;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyTuple};

use crate::arguments::{self, Any};
use crate::findings::Found;
use crate::{errors, notes, work};

/// Lay out the streets of OpenStreetMap data: roads, lanes and intersections, before they become a map.
///
/// Args:
///     input: OpenStreetMap data (.osm, .osm.gz or .osm.pbf) or streets as GeoJSON (docs/geometry.md): a path, or the content
///         as bytes.
///     output: A file for the streets, written whole or not at all. Without it nothing is written.
///     driving_side: Side of the road on which people drive: 'left', 'right', or 'auto', by the country.
///     projector: Projection of a map of the streets: 'MGRS', 'TransverseMercator', 'LocalCartesianUTM' or 'LocalCartesian'.
///     dem: A terrain model to lay the roads on, as a path or bytes: GeoTIFF in degrees or UTM, heights in metres.
///     config: Settings (docs/configuration.md): a file to read instead of lanewright.toml, 'KEY=VALUE', a mapping, or a list of
///         these, of which the last counts most.
///     isolated: Whether to read no lanewright.toml that is not named.
///     name: What messages call an input that is given as bytes.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     The streets, as Streets.
///
/// Raises:
///     ReadError: The input or the terrain model cannot be read.
///     BuildError: There is no road in it.
///     ConfigError: Settings cannot be read, or name what is not there.
///     WriteError: The file cannot be written.
///     TypeError, ValueError: An argument is of the wrong type, or has a value that there is not.
#[pyfunction]
#[pyo3(signature = (input, output=None, *, driving_side=None, projector=None, dem=None, config=None, isolated=false, name=None, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn geometry(
    py: Python<'_>,
    input: Any<'_, '_>,
    output: Option<Any<'_, '_>>,
    driving_side: Option<Any<'_, '_>>,
    projector: Option<Any<'_, '_>>,
    dem: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
    name: Option<String>,
    threads: Option<Any<'_, '_>>,
) -> PyResult<Streets> {
    let input = arguments::input("input", input, name)?;
    let output = arguments::output(output)?;
    let options = arguments::layout(driving_side, projector, dem, None, config, isolated)?;
    let name = input.name();
    let laid = work::run(py, arguments::threads(threads)?, move || {
        let layout = lanewright::geometry(input, &options)?;
        let mut text = Vec::new();
        layout.write(&mut text)?;
        if let Some(file) = &output {
            api::write_file(file, &text)?;
        }
        let network = &layout.plan.streets.network;
        let notes = layout.plan.notes.iter().chain(&layout.plan.streets.findings);
        Ok(Laid {
            roads: network.roads.len(),
            intersections: network.intersections.len(),
            projector: layout.plan.projector.name(),
            notes: notes::taken(notes, &layout.plan.projector),
            merges: layout.plan.streets.merges.iter().map(ToString::to_string).collect(),
            text: Arc::new(text),
        })
    })?;
    let notes = notes::objects(py, &laid.notes)?;
    Ok(Streets { laid, name, notes })
}

/// What is kept of streets.
#[derive(Debug)]
struct Laid {
    text: Arc<Vec<u8>>,
    roads: usize,
    intersections: usize,
    projector: &'static str,
    notes: Vec<Arc<Found>>,
    merges: Vec<String>,
}

/// Roads, lanes and intersections as they lie on the ground. `build` takes their GeoJSON.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct Streets {
    laid: Laid,
    name: String,
    notes: Py<PyTuple>,
}

#[pymethods]
impl Streets {
    /// The GeoJSON text (docs/geometry.md), as `lanewright geometry` writes it.
    #[getter]
    fn geojson<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.laid.text)
    }

    /// How many roads there are.
    #[getter]
    fn roads(&self) -> usize {
        self.laid.roads
    }

    /// How many intersections there are.
    #[getter]
    fn intersections(&self) -> usize {
        self.laid.intersections
    }

    /// The projection of a map of them: 'MGRS', 'TransverseMercator', 'LocalCartesianUTM' or 'LocalCartesian'.
    #[getter]
    fn projector(&self) -> &'static str {
        self.laid.projector
    }

    /// What was guessed, left out, or could not be laid out as it should.
    #[getter]
    fn notes(&self, py: Python<'_>) -> Py<PyTuple> {
        self.notes.clone_ref(py)
    }

    /// For each road that may lie inside an intersection a line that says whether it was merged, and what decided.
    #[getter]
    fn merges(&self) -> Vec<String> {
        self.laid.merges.clone()
    }

    /// The GeoJSON as a dictionary: a FeatureCollection.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        py.import("json")?.getattr("loads")?.call1((self.geojson(py),))
    }

    /// The same as to_geojson: it is a dictionary that JSON can hold.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.to_geojson(py)
    }

    /// Write the GeoJSON, whole or not at all.
    ///
    /// Args:
    ///     path: The file.
    ///
    /// Raises:
    ///     WriteError: It cannot be written.
    fn write(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        let text = self.laid.text.clone();
        py.detach(move || api::write_file(&path, &text)).map_err(|error| errors::raised(py, error))
    }

    fn __repr__(&self) -> String {
        let Laid { roads, intersections, projector, .. } = &self.laid;
        format!("<Streets of {:?}: {projector}, {roads} roads, {intersections} intersections>", self.name)
    }
}
