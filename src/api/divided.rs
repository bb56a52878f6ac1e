//! A map that is divided into cells, and the directory that it becomes.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::cells::{self, DivideError, Divided, Grid};
use crate::lanelet::cell_metadata::METADATA;
use crate::lanelet::{MAP, ProjectorInfo, locate_files};
use crate::projection::Projector;
use crate::report::failure::Failure;

use super::built::spare;
use super::config::{self, Configuration, NAME};
use super::error::{Error, ErrorKind};
use super::files::Draft;
use super::load::{home, open_failure, projector, read_failure};

/// The grid of cells with sides of this length.
pub(crate) fn grid(size: u32) -> Result<Grid, Error> {
    Grid::new(size).ok_or_else(|| {
        ErrorKind::Config.error(Failure::new("a cell must be a metre wide at least").help("100 m is usual"))
    })
}

/// Divides a map into cells that Autoware loads one by one, and writes a map directory: the cells, their list, and what stands
/// beside the map. All is written or nothing.
///
/// # Errors
///
/// Where the map or settings cannot be read, the map cannot be divided, or `output` holds a map already.
pub fn split(map: &Path, output: &Path, size: u32, said: &Configuration, tell: &dyn Fn(&str)) -> Result<Divided, Error> {
    let grid = grid(size)?;
    let settings = config::settings(home(map), said).map_err(ErrorKind::Config.of())?;
    let (files, info) = locate_files(map).map_err(|error| ErrorKind::Read.error(open_failure(error)))?;
    let beside = Beside::of(map, &files, &info).map_err(ErrorKind::Read.of())?;
    let write = |error| ErrorKind::Write.error(error);
    let projector = projector(&settings).or_else(|| info.projector());
    let mut draft = Draft::new(output).map_err(write)?;
    let divided = into_draft(&mut draft, &files, projector, grid, tell).map_err(|error| told(map, error))?;
    beside.write(&mut draft).and_then(|()| draft.publish()).map_err(write)?;
    Ok(divided)
}

/// Why the cells of a draft could not be made.
pub(super) enum Unmade {
    Draft(Failure),
    Divide(DivideError),
}

/// Divides the map in these files into the cells of a draft, with their list.
pub(super) fn into_draft(
    draft: &mut Draft<'_>,
    files: &[PathBuf],
    projector: Option<Projector>,
    grid: Grid,
    tell: &dyn Fn(&str),
) -> Result<Divided, Unmade> {
    let folder = draft.folder(MAP).map_err(Unmade::Draft)?;
    let divided = cells::divide(files, projector, grid, &folder, tell).map_err(Unmade::Divide)?;
    draft
        .write(METADATA, |file| file.write_all(divided.metadata.text().as_bytes()))
        .map_err(Unmade::Draft)?;
    Ok(divided)
}

/// Why a map was not divided, and the way out.
pub(super) fn told(map: &Path, error: Unmade) -> Error {
    let about = |failure: Failure| failure.about(map.display().to_string());
    let error = match error {
        Unmade::Draft(failure) => return ErrorKind::Write.error(failure),
        Unmade::Divide(error) => error,
    };
    let help = error.help();
    match error {
        DivideError::Read(error) => ErrorKind::Read.error(read_failure(error)),
        DivideError::Write { path, source } => {
            // The draft has a name that nobody knows.
            let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            ErrorKind::Write.error(Failure::new(format!("cannot write the cell {name}: {source}")).help(help))
        }
        error => ErrorKind::Read.error(about(Failure::new(format!("{}: {error}", map.display())).help(help))),
    }
}

/// What stands beside a map and belongs to it.
pub(super) struct Beside(Vec<(String, Vec<u8>)>);

impl Beside {
    /// The projector's file, under its own name, and the settings.
    pub(super) fn of(map: &Path, files: &[PathBuf], info: &ProjectorInfo) -> Result<Self, Failure> {
        // The settings of a map that is given as one of its files, or as the folder of its cells, stand beside the others.
        let settings = [home(map).join(NAME), info.path.iter().map(|path| path.with_file_name(NAME)).collect()];
        let settings = settings.into_iter().find(|file| file.is_file() && !files.contains(file));
        let read = |file: PathBuf| {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let bytes = fs::read(&file).map_err(|error| {
                Failure::new(format!("cannot read {}: {error}", file.display())).about(file.display().to_string())
            })?;
            Ok((name, bytes))
        };
        info.path.clone().into_iter().chain(settings).map(read).collect::<Result<_, _>>().map(Self)
    }

    /// Adds the files to a draft; settings that no build has written are spared.
    pub(super) fn write(&self, draft: &mut Draft<'_>) -> Result<(), Failure> {
        spare(draft.dir())?;
        self.0.iter().try_for_each(|(name, bytes)| draft.write(name, |file| file.write_all(bytes)))
    }
}
