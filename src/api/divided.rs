//! A map that is divided into cells, and the directory that it becomes.

use std::fs;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use crate::cells::{self, Collision, DivideError, Divided, Grid, Merge};
use crate::lanelet::cell_metadata::METADATA;
use crate::lanelet::{MAP, ProjectorInfo, locate_files, read_elements};
use crate::projection::Projector;
use crate::report::failure::Failure;

use super::config::{self, Configuration, NAME};
use super::error::{Error, ErrorKind};
use super::files::{Draft, there_already};
use super::load::{home, open_failure, projector, read_failure};
use super::own_output::{spare_settings, without_hashes, write_known};

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
pub fn split(
    map: &Path,
    output: &Path,
    size: u32,
    said: &Configuration,
    tell: &dyn Fn(&str),
) -> Result<Divided, Error> {
    let grid = grid(size)?;
    let settings = config::settings(home(map), said).map_err(ErrorKind::Config.of())?;
    let (files, info) = locate_files(map).map_err(|error| ErrorKind::Read.error(open_failure(error)))?;
    let beside = Beside::of(&files, &info).map_err(ErrorKind::Read.of())?;
    let write = |error| ErrorKind::Write.error(error);
    let projector = projector(&settings).or_else(|| info.projector());
    let mut draft = Draft::new(output).map_err(write)?;
    let divided = into_draft(&mut draft, &files, projector, grid, tell).map_err(|error| division_error(map, error))?;
    beside.write(&mut draft, None).and_then(|()| draft.publish()).map_err(write)?;
    Ok(divided)
}

/// Why the cells of a draft could not be made.
pub(super) enum Unmade {
    Draft(Failure),
    Divide(DivideError),
}

/// Divides the map in these files into the cells of a draft, with their list.
pub(super) fn into_draft(
    draft: &mut Draft,
    files: &[PathBuf],
    projector: Option<Projector>,
    grid: Grid,
    tell: &dyn Fn(&str),
) -> Result<Divided, Unmade> {
    let folder = draft.folder(MAP).map_err(Unmade::Draft)?;
    let divided = cells::divide(files, projector, grid, None, &folder, tell).map_err(Unmade::Divide)?;
    draft.write(METADATA, |file| divided.write_metadata(file)).map_err(Unmade::Draft)?;
    Ok(divided)
}

/// Why a map was not divided, and the way out.
pub(super) fn division_error(map: &Path, error: Unmade) -> Error {
    match error {
        Unmade::Draft(failure) => ErrorKind::Write.error(failure),
        Unmade::Divide(error) => undivided(map, error),
    }
}

/// Why a map was not divided, and the way out.
pub(super) fn undivided(map: &Path, error: DivideError) -> Error {
    let about = |failure: Failure| failure.about(map.display().to_string());
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
#[derive(Debug, Default)]
pub(super) struct Beside(Vec<(String, Vec<u8>)>);

impl Beside {
    /// The projector's file, under its own name, and the settings.
    pub(super) fn of(files: &[PathBuf], info: &ProjectorInfo) -> Result<Self, Failure> {
        let folder = files.first().and_then(|file| file.parent()).unwrap_or(Path::new(""));
        // Beside the folder of the cells, not in it.
        let is_of_cells = folder.file_name().is_some_and(|name| name == MAP);
        let folder = folder.parent().filter(|_| is_of_cells).unwrap_or(folder);
        let settings = Some(folder.join(NAME)).filter(|file| file.is_file());
        let read = |file: PathBuf| {
            let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
            let bytes = fs::read(&file).map_err(|error| {
                Failure::new(format!("cannot read {}: {error}", file.display())).about(file.display().to_string())
            })?;
            let bytes =
                if name == NAME { without_hashes(&String::from_utf8_lossy(&bytes)).into_bytes() } else { bytes };
            Ok((name, bytes))
        };
        info.path.clone().into_iter().chain(settings).map(read).collect::<Result<_, _>>().map(Self)
    }

    /// What stands beside all of several maps, and whether settings were left out because they differ.
    fn of_all(all: Vec<Self>) -> (Self, bool) {
        let mut texts: Vec<(String, Vec<u8>)> = all.into_iter().flat_map(|one| one.0).collect();
        let settings: Vec<&Vec<u8>> = texts.iter().filter(|(name, _)| name == NAME).map(|(_, text)| text).collect();
        let differ = settings.iter().any(|text| Some(text) != settings.first());
        // The projector's files say the same, if not in the same words.
        let mut names = Vec::new();
        texts.retain(|(name, _)| {
            let unwanted = names.contains(name) || (differ && name == NAME);
            names.push(name.clone());
            !unwanted
        });
        (Self(texts), differ)
    }

    /// Adds the files to a draft; settings that no build has written are spared. They know the map again of which they get the line.
    pub(super) fn write(&self, draft: &mut Draft, known: Option<String>) -> Result<(), Failure> {
        spare_settings(draft.dir())?;
        let (settings, others): (Vec<_>, Vec<_>) = self.0.iter().partition(|(name, _)| name == NAME);
        let mut lines = known.clone().unwrap_or_default();
        for (name, bytes) in others {
            lines += &write_known(draft, name, |file| file.write_all(bytes))?;
        }
        let lines = known.map_or(String::new(), |_| lines);
        settings.into_iter().try_for_each(|(name, bytes)| {
            draft.write(name, |file| file.write_all(bytes).and_then(|()| file.write_all(lines.as_bytes())))
        })
    }
}

/// What came of putting maps together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Joined {
    /// Nodes, ways and relations.
    pub elements: [usize; 3],
    /// Elements that got another id.
    pub renumbered: usize,
    /// Whether the maps have different settings, so that none were written.
    pub settings_left_out: bool,
}

/// Puts the cells of a divided map together, or several maps, and writes a map directory. All is written or nothing.
///
/// # Errors
///
/// Where a map cannot be read, the maps do not go together, or `output` holds a map already. Where two elements share an id and
/// are not the same, unless they may be renumbered.
pub fn merge(maps: &[PathBuf], output: &Path, renumber: bool, tell: &dyn Fn(&str)) -> Result<Joined, Error> {
    let read = |failure| ErrorKind::Read.error(failure);
    let place = output.join(MAP);
    if place.exists() {
        return Err(ErrorKind::Write.error(there_already(&place)));
    }
    let (mut data, mut beside, mut projectors) = (Vec::new(), Vec::new(), Vec::new());
    for map in maps {
        let (osm, files, info) = read_elements(map).map_err(|error| read(open_failure(error)))?;
        beside.push(Beside::of(&files, &info).map_err(read)?);
        projectors.push((info.projector(), osm.meta.as_ref().and_then(|meta| meta.format_version.clone())));
        data.push(osm);
    }
    let mut frames = maps.iter().zip(&projectors);
    if let Some((first, frame)) = frames.next()
        && let Some((other, its)) = frames.find(|(_, its)| *its != frame)
    {
        return Err(read(unlike(first, other, its.0 != frame.0)));
    }
    let merge = Merge::of(&data);
    if !renumber && !merge.collisions.is_empty() {
        return Err(read(collisions(maps, &merge.collisions)));
    }
    tell("writing");
    let (beside, settings_left_out) = Beside::of_all(beside);
    let write = || -> Result<(), Failure> {
        let mut draft = Draft::new(output)?;
        let known = write_known(&mut draft, MAP, |file| {
            let mut out = BufWriter::new(file);
            merge.write(&mut out).and_then(|()| out.flush())
        })?;
        beside.write(&mut draft, Some(known))?;
        draft.publish()
    };
    write().map_err(|failure| ErrorKind::Write.error(failure))?;
    Ok(Joined { elements: merge.counts(), renumbered: merge.renumbered(), settings_left_out })
}

/// Why two maps cannot become one.
fn unlike(first: &Path, other: &Path, projection: bool) -> Failure {
    let (first, other) = (first.display(), other.display());
    match projection {
        true => Failure::new(format!("{first} and {other} have different projections")).help(format!(
            "put one into the projection of the other: lanewright project convert {other} --to TYPE -o DIR"
        )),
        false => Failure::new(format!("{first} and {other} have different format versions"))
            .help("write the same format_version into <MetaInfo> of both, if both keep to it"),
    }
}

/// Which elements share their ids and are not the same.
fn collisions(maps: &[PathBuf], collisions: &[Collision]) -> Failure {
    /// So many are named, as examples.
    const NAMED: usize = 10;
    let of_map = collisions.first().map_or(0, |one| one.map);
    let named: Vec<String> = collisions.iter().take(NAMED).map(|one| format!("{} {}", one.kind, one.id)).collect();
    let more = collisions.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    let map = maps.get(of_map).map(|map| map.display().to_string()).unwrap_or_default();
    Failure::new(format!("{map} has other elements with ids that a map before it has: {}{more}", named.join(", ")))
        .about(map)
        .help("--renumber gives them other ids; cells of one map that differ are damaged: divide it anew")
}
