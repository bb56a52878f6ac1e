//! One tile of cut data is built: its cells in a folder, and what is to be known of it to put it together with the others.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use rustc_hash::FxHashSet;

use crate::builder::{BuildError, BuildOptions, Built, build_plan, plan};
use crate::cells::{self, Cell, Grid, Tile, excerpt};
use crate::diagnostic::Severity;
use crate::lanelet;
use crate::osm::{self, OsmData};
use crate::projection::{Extent, Projector};
use crate::report::failure::Failure;
use crate::tiles::Record;

use super::built::BuiltMap;
use super::checked::{CheckOptions, Checked};
use super::config::Configuration;
use super::cut::{Cut, TileSizes, unwritten};
use super::divided::undivided;
use super::error::{Error, ErrorKind};
use super::layout::{build_failure, loaded, terrain, unread};
use super::load::Loaded;
use super::{InMemory, Input};

/// What all tiles of some data are built with.
#[derive(Debug)]
pub struct TileBuilder {
    /// What messages call the data.
    name: String,
    /// What messages call the place of the cells.
    output: PathBuf,
    options: BuildOptions,
    projector: Projector,
    /// What the data hold of the Earth.
    bounds: Vec<Extent>,
    cells: Grid,
    sizes: TileSizes,
    check: bool,
}

impl TileBuilder {
    /// For data that were cut, with the terrain model of their folder where there is one. Messages call the place of the cells
    /// `output`.
    ///
    /// # Errors
    ///
    /// Where the terrain model is missing or cannot be read, or the description is not that of cut data.
    pub fn new(cut: &Cut, dem: Option<&Input>, output: &Path) -> Result<Self, Error> {
        if cut.terrain && dem.is_none() {
            let failure = Failure::new("the data were cut to be built on a terrain model");
            return Err(ErrorKind::Read.error(failure.help("give the file terrain.tif of their folder, too")));
        }
        let terrain = dem.map(terrain).transpose()?.map(Into::into);
        Self::with(cut, BuildOptions { terrain, ..cut.options()? }, output)
    }

    /// With options that are known already.
    pub(super) fn with(cut: &Cut, options: BuildOptions, output: &Path) -> Result<Self, Error> {
        let (cells, _) = cut.sizes.grids()?;
        Ok(Self {
            name: cut.input.clone(),
            output: output.to_path_buf(),
            options,
            projector: cut.projector()?,
            bounds: cut.bounds.clone(),
            cells,
            sizes: cut.sizes,
            check: false,
        })
    }

    /// Whether tiles are held against the rules, too, and their findings counted. That takes as long again as to build them.
    #[must_use]
    pub fn checking(self, check: bool) -> Self {
        Self { check, ..self }
    }

    /// Builds a tile from its data. Its cells are written into a folder that is there and in which there is nothing; the same data
    /// give the same bytes. The `contested` ids are those that two elements of the map are known to want.
    ///
    /// # Errors
    ///
    /// Where the data cannot be read or are no OpenStreetMap data, or a cell cannot be written.
    pub fn build(&self, tile: Cell, data: &Input, contested: &BTreeSet<i64>, folder: &Path) -> Result<Record, Error> {
        let mut osm = OsmData::default();
        let bytes = match data {
            Input::Path(path) => loaded(path.clone())?,
            Input::Bytes(InMemory { bytes, .. }) => bytes.clone(),
        };
        osm::read_bytes(&mut osm, &data.name(), bytes).map_err(unread)?;
        osm::refuse_off_earth(&osm).map_err(unread)?;
        osm.bounds.clone_from(&self.bounds);
        let options = BuildOptions { contested: contested.clone(), ..self.options.clone() };
        match plan(osm, &options) {
            Err(BuildError::Network(_) | BuildError::NoPlace) => Ok(Record::empty(self.cells)),
            Err(error) => Err(ErrorKind::Build.error(build_failure(error, &self.name))),
            Ok(plan) => self.divide(tile, build_plan(plan), folder),
        }
    }

    /// Writes the cells of a tile.
    fn divide(&self, tile: Cell, mut built: Built, folder: &Path) -> Result<Record, Error> {
        let unwritten = |error: std::io::Error| unwritten(&self.output, &error);
        let TileSizes { tile: size, cell, .. } = self.sizes;
        let size = f64::from(size);
        let corner = [tile.column, tile.row].map(|at| f64::from(at) * size);
        let square = [corner, corner.map(|low| low + size)];
        let (contested, notes) = (std::mem::take(&mut built.contested), built.notes.len());
        let mut findings = None;
        if self.check {
            let (unchanged, counts) = checked(built, square)?;
            (built, findings) = (unchanged, Some(counts));
        }
        excerpt(&mut built.map, square);
        if built.map.points.is_empty() {
            return Ok(Record { contested, notes, findings, ..Record::empty(self.cells) });
        }
        let map = folder.join("whole.osm");
        File::create(&map).and_then(|file| lanelet::to_osm(&built.map, &self.projector, file)).map_err(unwritten)?;
        drop(built.map);
        let within = Tile { at: tile, cells: (self.sizes.tile / cell) as i32 };
        let files = [map.clone()];
        let divided = cells::divide(&files, Some(self.projector), self.cells, Some(within), folder, &|_| ());
        let divided = divided.map_err(|error| undivided(&self.output, error))?;
        fs::remove_file(map).map_err(unwritten)?;
        let mut settings = built.settings;
        let own: FxHashSet<i64> = divided.own.iter().copied().collect();
        settings.intersection.retain(|entry| entry.ia.is_some_and(|area| own.contains(&area)));
        settings.bicycle_lanes.retain(|lanelet| own.contains(lanelet));
        settings.loose_ends.retain(|lanelet| own.contains(lanelet));
        let settings = toml::to_string(&settings).map_err(|error| unwritten(std::io::Error::other(error)))?;
        Ok(Record { divided, settings: Some(settings), contested, notes, findings })
    }
}

/// Western and southern sides, which belong to it, and eastern and northern ones, which do not.
type Square = [[f64; 2]; 2];

fn is_in([low, high]: Square, [x, y]: [f64; 2]) -> bool {
    (low[0]..high[0]).contains(&x) && (low[1]..high[1]).contains(&y)
}

/// How many errors, warnings and infos a map has in a square. All of it is checked: at its edges there is more to complain of.
fn checked(built: Built, square: Square) -> Result<(Built, [usize; 3]), Error> {
    let whole = BuiltMap { built };
    let loaded = Loaded::read(whole.to_input("the tile")?, &Configuration::default())?;
    let checked = Checked::of(loaded, CheckOptions::default())?;
    let within = checked.sorted.left.iter().filter(|one| one.local.is_some_and(|at| is_in(square, [at.x, at.y])));
    let counts = within.fold([0; 3], |[errors, warnings, infos], one| match one.severity {
        Severity::Error => [errors + 1, warnings, infos],
        Severity::Warning => [errors, warnings + 1, infos],
        Severity::Info => [errors, warnings, infos + 1],
    });
    Ok((whole.built, counts))
}
