//! `cut`, `build_tile`, `join_tiles`: a map that is built in tiles, each where there is room for it.

use std::collections::BTreeSet;

use lanewright::api::{self, Cut, Error, Joining, MARGIN, TileBuilder, TileSizes};
use lanewright::cells::Cell;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict};

use crate::arguments::{self, Any};
use crate::work;

/// Widest tile and cell that can be asked for, metres: half the Earth's girth.
const WIDEST: u32 = 20_000_000;

/// Cut OpenStreetMap data into tiles from which a map can be built piece by piece, anywhere and in any order: what the command
/// `lanewright cut` does (docs/scale.md).
///
/// Args:
///     input: OpenStreetMap data (.osm, .osm.gz or .osm.pbf), as a path. They are read once, block by block.
///     output: A directory for the data of each tile and `cut.json`, made if it is not there. All is written or nothing.
///     tiles: Width and height of a tile, whole metres, a multiple of that of a cell.
///     cells: Width and height of a cell of the map, whole metres.
///     margin: How far around a tile data are read with it, metres.
///     driving_side: As for `build`; so are the others.
///     projector: Projection of the map.
///     dem: A terrain model to lay the roads on; it is copied.
///     profile: Whose reading of the requirements the map follows.
///     config: Settings.
///     isolated: Whether to read no lanewright.toml that is not named.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     The description that `cut.json` holds: JSON, with the list of the tiles.
///
/// Raises:
///     ReadError, BuildError, ConfigError, WriteError: As for `build`; the output holds cut data already.
///     TypeError, ValueError: An argument is of the wrong type, or has a value that there is not.
#[pyfunction]
#[pyo3(signature = (input, output, *, tiles, cells=None, margin=None, driving_side=None, projector=None, dem=None, profile=None, config=None, isolated=false, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn cut(
    py: Python<'_>,
    input: Any<'_, '_>,
    output: Any<'_, '_>,
    tiles: Any<'_, '_>,
    cells: Option<Any<'_, '_>>,
    margin: Option<Any<'_, '_>>,
    driving_side: Option<Any<'_, '_>>,
    projector: Option<Any<'_, '_>>,
    dem: Option<Any<'_, '_>>,
    profile: Option<Any<'_, '_>>,
    config: Option<Any<'_, '_>>,
    isolated: bool,
    threads: Option<Any<'_, '_>>,
) -> PyResult<String> {
    /// As `split` has it.
    const CELL: u32 = 100;
    let (input, output) = (arguments::directory("input", input)?, arguments::directory("output", output)?);
    let metres = |argument, given: Option<Any<'_, '_>>, default| {
        given.map_or(Ok(default), |given| arguments::metres(argument, given, WIDEST))
    };
    let sizes = TileSizes {
        tile: arguments::metres("tiles", tiles, WIDEST)?,
        cell: metres("cells", cells, CELL)?,
        margin: metres("margin", margin, MARGIN)?,
    };
    let options = arguments::layout(driving_side, projector, dem, profile, config, isolated)?;
    work::run(py, arguments::threads(threads)?, move || api::cut(&input, &output, sizes, &options, &|_| ())?.text())
}

/// Build one tile of data that were cut. The same data give the same bytes, wherever and how often the tile is built.
///
/// Args:
///     description: The text of `cut.json`. The list of its tiles is not read and may be left out.
///     tile: Column and row of the tile, as the list has them.
///     data: The data of the tile, as a path or bytes.
///     directory: A directory for its cells, which is there and in which there is nothing.
///     contested: Ids that two elements of the map are known to want, as `join_tiles` finds them.
///     dem: The terrain model of the cut data, where there is one, as a path or bytes.
///     check: Whether to hold it against Autoware's requirements, too, and count what is found in it.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     What came of it, as a BuiltTile.
///
/// Raises:
///     ReadError: The description or the data cannot be read, or are of another version of lanewright.
///     BuildError: The data are a Lanelet2 map.
///     WriteError: The cells cannot be written; some may have been.
#[pyfunction]
#[pyo3(signature = (description, tile, data, directory, *, contested=Vec::new(), dem=None, check=false, threads=None))]
#[allow(clippy::too_many_arguments, reason = "Python names them")]
pub fn build_tile(
    py: Python<'_>,
    description: String,
    tile: (i32, i32),
    data: Any<'_, '_>,
    directory: Any<'_, '_>,
    contested: Vec<i64>,
    dem: Option<Any<'_, '_>>,
    check: bool,
    threads: Option<Any<'_, '_>>,
) -> PyResult<BuiltTile> {
    let (column, row) = tile;
    let name = format!("{column}_{row}.osm");
    let is_bytes = data.hasattr("__len__")? && !data.hasattr("encode")?;
    let data = arguments::input("data", data, is_bytes.then_some(name))?;
    let dem = dem.map(|given| arguments::input("dem", given, None)).transpose()?;
    let folder = arguments::directory("directory", directory)?;
    let contested: BTreeSet<i64> = contested.into_iter().collect();
    work::run(py, arguments::threads(threads)?, move || {
        let builder = TileBuilder::new(&Cut::parse(&description)?, dem.as_ref(), &folder)?.checking(check);
        let record = builder.build(Cell { row, column }, &data, &contested, &folder)?;
        let divided = &record.divided;
        Ok(BuiltTile {
            cells: divided.cells.iter().map(|cell| divided.grid.name(*cell)).collect(),
            elements: divided.elements,
            notes: record.notes,
            findings: record.findings.map(|[errors, warnings, infos]| (errors, warnings, infos)),
            record: record.to_bytes().map_err(|error| Error::internal(error.to_string()))?,
        })
    })
}

/// A tile that was built.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct BuiltTile {
    /// The names of the files of its cells.
    #[pyo3(get)]
    cells: Vec<String>,
    /// Elements of the map that stand in no tile before it.
    #[pyo3(get)]
    elements: usize,
    /// What was guessed, left out or could not be built as it should, its surroundings included.
    #[pyo3(get)]
    notes: usize,
    /// Errors, warnings and infos in the tile; None unless it was checked.
    #[pyo3(get)]
    findings: Option<(usize, usize, usize)>,
    record: Vec<u8>,
}

#[pymethods]
impl BuiltTile {
    /// What must be known of it to put it together with others, for `join_tiles`.
    #[getter]
    fn record<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, &self.record)
    }

    fn __repr__(&self) -> String {
        format!("<BuiltTile: {} cells, {} elements, {} notes>", self.cells.len(), self.elements, self.notes)
    }
}

/// Hold the tiles of cut data against each other, and find out whether they make a map.
///
/// Args:
///     description: The text of `cut.json`, with the list of the tiles.
///     records: A directory with the record of each tile, COLUMN_ROW.json. Files are made there meanwhile.
///     contested: The ids with which they were built.
///     threads: How many threads share the work; one for each processor if None.
///
/// Returns:
///     The files that stand beside the cells, or the tiles that must be built again with more ids, as JoinedTiles.
///
/// Raises:
///     BuildError: Two tiles disagree on what stands in both: they need a larger margin.
///     ReadError: A record is missing or no record; the description cannot be read, or is of another version of lanewright.
///     WriteError: Nothing can be written into the directory.
#[pyfunction]
#[pyo3(signature = (description, records, *, contested=Vec::new(), threads=None))]
pub fn join_tiles(
    py: Python<'_>,
    description: String,
    records: Any<'_, '_>,
    contested: Vec<i64>,
    threads: Option<Any<'_, '_>>,
) -> PyResult<JoinedTiles> {
    let records = arguments::directory("records", records)?;
    let contested: BTreeSet<i64> = contested.into_iter().collect();
    work::run(py, arguments::threads(threads)?, move || {
        Ok(match api::join(&Cut::parse(&description)?, &records, &contested)? {
            Joining::Again { tiles, contested } => JoinedTiles {
                again: tiles.into_iter().map(|Cell { row, column }| (column, row)).collect(),
                contested: contested.into_iter().collect(),
                files: Vec::new(),
            },
            Joining::Whole(whole) => {
                let files = whole.texts();
                JoinedTiles { again: Vec::new(), contested: contested.into_iter().collect(), files }
            }
        })
    })
}

/// What comes of all tiles.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct JoinedTiles {
    /// Columns and rows of the tiles that must be built again; none if the map is complete.
    #[pyo3(get)]
    again: Vec<(i32, i32)>,
    /// The ids with which they must be built: two elements want each of them, so that neither may have it.
    #[pyo3(get)]
    contested: Vec<i64>,
    files: Vec<(&'static str, String)>,
}

#[pymethods]
impl JoinedTiles {
    /// The texts of the files that stand beside the cells, by their names; none where tiles must be built again.
    #[getter]
    fn files<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let files = PyDict::new(py);
        self.files.iter().try_for_each(|(name, text)| files.set_item(name, text))?;
        Ok(files)
    }

    fn __repr__(&self) -> String {
        match self.again.len() {
            0 => "<JoinedTiles: complete>".to_owned(),
            again => format!("<JoinedTiles: {again} to be built again>"),
        }
    }
}
