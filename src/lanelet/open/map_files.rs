//! Finds the files that are one map, and reads them.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use rustc_hash::FxHashSet;

use super::error::OpenError;
use crate::diagnostic::SourceSpan;
use crate::lanelet::ProjectorInfo;
use crate::lanelet::cell_metadata::{CellMetadata, MAP, METADATA};
use crate::osm::{Contradiction, OsmData, ReadError, read_files};

/// The files of a map, and the directory of its projector file.
pub(super) struct MapFiles {
    /// In reading order.
    pub(super) files: Vec<PathBuf>,
    folder: PathBuf,
    /// Another folder, where that one has none.
    above: Option<PathBuf>,
    /// The folder of the cells, where the map is divided.
    pub(super) cells: Option<PathBuf>,
    /// Whether Autoware would load the map from here.
    autoware: bool,
}

impl MapFiles {
    /// Finds them: `path` is a file, or a directory.
    pub(super) fn find(path: &Path) -> Result<Self, OpenError> {
        if !path.is_dir() {
            let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
            let autoware = path.file_name() == Some(OsStr::new(MAP));
            // One cell of a divided map.
            let above = folder.parent().filter(|_| folder.file_name() == Some(OsStr::new(MAP))).map(Path::to_path_buf);
            return Ok(Self { files: vec![path.to_path_buf()], folder, above, cells: None, autoware });
        }
        let folder = path.to_path_buf();
        for inner in [path.join(MAP), path.join(format!("{MAP}.gz"))] {
            if inner.is_dir() {
                let files = files_in(&inner)?;
                return Ok(Self { files, folder, above: None, cells: Some(inner), autoware: true });
            }
            if inner.exists() {
                return Ok(Self { files: vec![inner], folder, above: None, cells: None, autoware: true });
            }
        }
        let files = files_in(path)?;
        // `.` and `..` have no name until they are resolved.
        let full = path.canonicalize().ok().filter(|full| full.file_name() == Some(OsStr::new(MAP)));
        let above = full.as_ref().and_then(|full| full.parent()).map(Path::to_path_buf);
        let cells = above.is_some().then(|| folder.clone());
        Ok(Self { files, folder, autoware: above.is_some(), above, cells })
    }

    /// What the projector file says.
    pub(super) fn info(&self) -> Result<ProjectorInfo, OpenError> {
        let look = |folder: &Path| {
            let failed = |source| ReadError::Io { path: folder.to_path_buf(), source };
            ProjectorInfo::beside(folder, self.autoware).map_err(failed)
        };
        let own = look(&self.folder)?;
        Ok(match &self.above {
            Some(above) if own.path.is_none() => look(above)?,
            _ => own,
        })
    }

    /// The elements of all files, each once. Cells, and whatever else must be one map, are in the order of ids and may not
    /// contradict each other.
    pub(super) fn read(&self, one_map: bool) -> Result<OsmData, OpenError> {
        let mut osm = read_files(&self.files)?;
        let contradictions = osm.leave_out_copies();
        if one_map && self.files.len() > 1 {
            agree(&osm, &contradictions)?;
            osm.sort_by_id();
        }
        Ok(osm)
    }

    /// Whether the list of the cells, where there is one, names all cells and no others.
    pub(super) fn hold_against_list(&self) -> Result<(), OpenError> {
        let Some(cells) = &self.cells else { return Ok(()) };
        let beside = self.above.as_ref().unwrap_or(&self.folder);
        let path = beside.join(METADATA);
        if !path.is_file() {
            return Ok(());
        }
        let failed = |source| ReadError::Io { path: path.clone(), source };
        let text = String::from_utf8_lossy(&std::fs::read(&path).map_err(failed)?).into_owned();
        let list = CellMetadata::read(&text).map_err(|error| OpenError::Metadata { path: path.clone(), error })?;
        let file_of = |name: &str| CellMetadata::file(beside, cells, name);
        let missing: Vec<&str> =
            list.cells.iter().map(|(name, _)| name.as_str()).filter(|name| file_of(name).is_none()).collect();
        if let [name, more @ ..] = missing.as_slice() {
            let more = (!more.is_empty()).then_some(more.len());
            return Err(OpenError::MissingCell { path, name: (*name).to_owned(), more });
        }
        let listed: FxHashSet<OsString> =
            list.cells.iter().filter_map(|(name, _)| Some(Path::new(name).file_name()?.to_owned())).collect();
        match self.files.iter().find(|file| file.file_name().is_some_and(|name| !listed.contains(name))) {
            Some(file) => Err(OpenError::UnlistedCell { path: file.clone() }),
            None => Ok(()),
        }
    }
}

/// The `.osm` and `.osm.gz` files right in a directory, in the order of their names.
fn files_in(folder: &Path) -> Result<Vec<PathBuf>, OpenError> {
    let failed = |source| ReadError::Io { path: folder.to_path_buf(), source };
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let file = entry.map_err(failed)?.path();
        let name = file.file_name().map(|n| n.to_string_lossy().to_ascii_lowercase()).unwrap_or_default();
        if (name.ends_with(".osm") || name.ends_with(".osm.gz")) && file.is_file() {
            files.push(file);
        }
    }
    if files.is_empty() {
        return Err(OpenError::EmptyDirectory { path: folder.to_path_buf() });
    }
    files.sort();
    Ok(files)
}

/// Whether cells say the same of each element.
fn agree(osm: &OsmData, contradictions: &[Contradiction]) -> Result<(), OpenError> {
    let [Contradiction { kind, id, spans }, more @ ..] = contradictions else { return Ok(()) };
    let place = |span: &SourceSpan| {
        let source = osm.sources.get(span.file as usize);
        let before = source.and_then(|source| source.text.get(..span.start as usize)).unwrap_or_default();
        format!("{}:{}", source.map_or("", |source| &source.name), before.matches('\n').count() + 1)
    };
    let [first, second] = spans.each_ref().map(place);
    let more = (!more.is_empty()).then_some(more.len());
    Err(OpenError::Contradiction { first, second, kind: *kind, id: *id, more })
}
