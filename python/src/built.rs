//! `build`: a map from OpenStreetMap data.

use std::path::PathBuf;
use std::sync::Arc;

use lanewright::Input;
use lanewright::api::{self, Error, Layout};
use lanewright::projection::LonLat;
use lanewright::report::geojson;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::{PyBytes, PyDict, PyTuple};
use serde_json::{Value, json};

use crate::arguments::{self, Any};
use crate::findings::Found;
use crate::{json, notes, work};

/// What `check` and `fix` read: an input, or a map that was built.
pub enum MapInput {
    /// A path or bytes.
    Input(Input),
    /// A map that was built, and what messages call it.
    Built(Arc<api::BuiltMap>, String),
}

impl MapInput {
    /// What is read; a map that was built is written for it.
    pub fn read(self) -> Result<Input, Error> {
        match self {
            Self::Input(input) => Ok(input),
            Self::Built(map, name) => map.to_input(&name),
        }
    }
}

/// A map, given as a path, bytes or a map that was built.
pub fn map_input(given: Any<'_, '_>, name: Option<String>) -> PyResult<MapInput> {
    match given.cast::<BuiltMap>() {
        Ok(built) => Ok(MapInput::Built(built.get().map.clone(), name.unwrap_or_else(|| built.get().name.clone()))),
        Err(_) => Ok(MapInput::Input(arguments::input("map", given, name)?)),
    }
}

/// Build a Lanelet2 map from OpenStreetMap data, from streets as `geometry` writes them, or from OpenDRIVE.
///
/// The same input gives the same map, byte by byte, whatever the number of threads; it is the map that the command
/// `lanewright build` writes.
///
/// Args:
///     input: OpenStreetMap data (.osm, .osm.gz or .osm.pbf), streets as GeoJSON (docs/geometry.md) or OpenDRIVE
///         (docs/opendrive.md): a path, or the content as bytes. What it is, its content says.
///     output: A directory for lanelet2_map.osm, map_projector_info.yaml and lanewright.toml, made if it is not there. All three
///         are written or none. Without it nothing is written.
///     driving_side: Side of the road on which people drive: 'left', 'right', or 'auto', by the country.
///     projector: Projection of the map: 'MGRS', 'TransverseMercator', 'LocalCartesianUTM' or 'LocalCartesian', its origin in
///         the middle of the data. Without it MGRS, or TransverseMercator where the data does not fit one 100 km square.
///     dem: A terrain model to lay the roads on, as a path or bytes: GeoTIFF in degrees or UTM, heights in metres.
///     origin: Latitude and longitude, degrees, of the origin of an OpenDRIVE file that does not say where it lies.
///     profile: Whose reading of the requirements the map follows where readings differ: 'ours' or 'tier4'.
///     config: Settings (docs/configuration.md): a file to read instead of lanewright.toml, 'KEY=VALUE', a mapping, or a list of
///         these, of which the last counts most.
///     isolated: Whether to read no lanewright.toml that is not named.
///     force: Whether to write over a map that no run has written, or that was changed since.
///     name: What messages call an input that is given as bytes.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     The map, with what was guessed, as a BuiltMap.
///
/// Raises:
///     ReadError: The input or the terrain model cannot be read.
///     BuildError: There is nothing in it that a map could be built from.
///     ConfigError: Settings cannot be read, or name what is not there.
///     WriteError: The map cannot be written.
///     TypeError, ValueError: An argument is of the wrong type, or has a value that there is not.
#[pyfunction]
#[pyo3(signature = (input, output=None, *, driving_side=None, projector=None, dem=None, origin=None, profile=None, config=None, isolated=false, force=false, name=None, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn build(
    py: Python<'_>,
    input: Any<'_, '_>,
    output: Option<Any<'_, '_>>,
    driving_side: Option<Any<'_, '_>>,
    projector: Option<Any<'_, '_>>,
    dem: Option<Any<'_, '_>>,
    origin: Option<(f64, f64)>,
    profile: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
    force: bool,
    name: Option<String>,
    threads: Option<Any<'_, '_>>,
) -> PyResult<BuiltMap> {
    let input = arguments::input("input", input, name)?;
    let output = arguments::output(output)?;
    let mut options = arguments::layout(driving_side, projector, dem, profile, config, isolated)?;
    options.origin = origin.map(arguments::place).transpose()?;
    let threads = arguments::threads(threads)?;
    let name = input.name();
    let made = work::run(py, threads, move || {
        if let Some(directory) = &output {
            api::spare(directory, force)?;
        }
        let mut merges: Vec<String> = Vec::new();
        let map = if input.is_opendrive() {
            api::BuiltMap::of_opendrive(input, &options, &|_| ())?
        } else {
            api::BuiltMap::uncontested(&options, |options| {
                let layout = Layout::read(input.clone(), options, &|_| ())?;
                merges = layout.plan.streets.merges.iter().map(ToString::to_string).collect();
                Ok::<Layout, api::Error>(layout)
            })?
        };
        if let Some(directory) = &output {
            map.write(directory, force)?;
        }
        let notes = notes::taken(&map.built.notes, &map.built.projector);
        let settings = map.settings()?;
        Ok((map, notes, merges, settings))
    })?;
    let (map, notes, merges, settings) = made;
    let (objects, osm) = (notes::objects(py, &notes)?, PyOnceLock::new());
    Ok(BuiltMap { map: Arc::new(map), name, threads, settings, found: notes, notes: objects, merges, osm })
}

/// How much was built.
#[pyclass(frozen, get_all, module = "lanewright")]
#[derive(Clone, Debug)]
pub struct BuildSummary {
    /// Roads between intersections.
    pub roads: usize,
    /// Intersections that Autoware knows as such.
    pub intersections: usize,
    /// Lanelets of all kinds.
    pub lanelets: usize,
    /// Regulatory elements of all kinds.
    pub regulatory_elements: usize,
    /// What the input did not say.
    pub guesses: usize,
}

#[pymethods]
impl BuildSummary {
    /// All of it as a dictionary.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.value())
    }

    fn __repr__(&self) -> String {
        let Self { roads, intersections, lanelets, regulatory_elements, guesses } = self;
        format!(
            "<BuildSummary: {roads} roads, {intersections} intersections, {lanelets} lanelets, \
             {regulatory_elements} regulatory elements, {guesses} guesses>"
        )
    }
}

impl BuildSummary {
    fn value(&self) -> Value {
        json!({
            "roads": self.roads,
            "intersections": self.intersections,
            "lanelets": self.lanelets,
            "regulatory_elements": self.regulatory_elements,
            "guesses": self.guesses,
        })
    }
}

/// A Lanelet2 map that was built, in memory. `check` and `fix` take it as it is.
#[pyclass(frozen, module = "lanewright")]
pub struct BuiltMap {
    map: Arc<api::BuiltMap>,
    name: String,
    threads: Option<usize>,
    settings: String,
    found: Vec<Arc<Found>>,
    notes: Py<PyTuple>,
    merges: Vec<String>,
    osm: PyOnceLock<Py<PyBytes>>,
}

#[pymethods]
impl BuiltMap {
    /// The content of lanelet2_map.osm. It is made when it is asked for, and kept.
    #[getter]
    fn osm(&self, py: Python<'_>) -> PyResult<Py<PyBytes>> {
        let made = self.osm.get_or_try_init(py, || {
            let map = self.map.clone();
            let bytes = work::run(py, self.threads, move || {
                let mut bytes = Vec::new();
                map.write_osm(&mut bytes).map_err(|error| Error::internal(error.to_string()))?;
                Ok(bytes)
            })?;
            PyResult::Ok(PyBytes::new(py, &bytes).unbind())
        })?;
        Ok(made.clone_ref(py))
    }

    /// The text of map_projector_info.yaml.
    #[getter]
    fn projector_info(&self) -> String {
        self.map.projector_info()
    }

    /// The text of lanewright.toml: what the input told and the map cannot say.
    #[getter]
    fn settings(&self) -> &str {
        &self.settings
    }

    /// The projection: 'MGRS', 'TransverseMercator', 'LocalCartesianUTM' or 'LocalCartesian'.
    #[getter]
    fn projector(&self) -> &'static str {
        self.map.built.projector.name()
    }

    /// How much was built.
    #[getter]
    fn summary(&self) -> BuildSummary {
        let built = self.map.built.summary;
        BuildSummary {
            roads: built.roads,
            intersections: built.intersections,
            lanelets: built.lanelets,
            regulatory_elements: built.regulatory_elements,
            guesses: built.guesses,
        }
    }

    /// What was guessed, left out, or could not be built as it should.
    #[getter]
    fn notes(&self, py: Python<'_>) -> Py<PyTuple> {
        self.notes.clone_ref(py)
    }

    /// For each road that may lie inside an intersection a line that says whether it was merged, and what decided.
    #[getter]
    fn merges(&self) -> Vec<String> {
        self.merges.clone()
    }

    /// Write lanelet2_map.osm, map_projector_info.yaml and lanewright.toml, all or none.
    ///
    /// Args:
    ///     directory: Where to; made if it is not there.
    ///     force: Whether to write over a map that no run has written, or that was changed since.
    ///
    /// Raises:
    ///     WriteError: They cannot be written, a lanewright.toml is there that no build has written, or such a map without force.
    #[pyo3(signature = (directory, *, force=false))]
    fn write(&self, py: Python<'_>, directory: PathBuf, force: bool) -> PyResult<()> {
        let map = self.map.clone();
        work::run(py, self.threads, move || map.write(&directory, force))
    }

    /// Summary, projector and notes as a dictionary that JSON can hold.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = json!({
            "projector": self.projector(),
            "summary": self.summary().value(),
            "notes": notes::values(&self.found),
        });
        json::to_python(py, &value)
    }

    /// The lanelets as a GeoJSON FeatureCollection: outlines in degrees, with ids and tags as properties.
    fn to_geojson<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let map = self.map.clone();
        let features = work::run(py, self.threads, move || {
            let projector = map.built.projector;
            let to_globe = move |points: &[_]| -> Option<Vec<LonLat>> {
                projector.inverse_each(points, |_| 0.0).into_iter().collect()
            };
            Ok(geojson::lanelets(&map.built.map, &to_globe))
        })?;
        json::collection(py, &features)
    }

    fn __repr__(&self) -> String {
        let summary = self.map.built.summary;
        format!(
            "<BuiltMap of {:?}: {}, {} lanelets, {} intersections, {} guesses>",
            self.name,
            self.projector(),
            summary.lanelets,
            summary.intersections,
            summary.guesses
        )
    }
}
