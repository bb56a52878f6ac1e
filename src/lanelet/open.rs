//! Opens a map wherever it lies: one file, a directory of `.osm` files, or an Autoware map directory.

use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use rustc_hash::FxHashSet;

use crate::diagnostic::SourceSpan;
use crate::osm::{Contradiction, ElementKind, OsmData, ReadError, read_bytes, read_files};
use crate::projection::{LonLat, MgrsGrid, Projector};

use super::cell_metadata::{CellMetadata, MAP, METADATA, MetadataError};
use super::{Loaded, ProjectorInfo, from_osm};

/// A map that was read, with where it came from.
#[derive(Debug)]
pub struct Opened {
    /// What the files say, with their text.
    pub osm: OsmData,
    /// The files, in reading order.
    pub files: Vec<PathBuf>,
    /// What turns longitude and latitude into metres.
    pub projector: Projector,
    /// Who says so.
    pub projector_from: ProjectorFrom,
    /// The projector file beside the map, to be checked again when the map changes.
    pub info: ProjectorInfo,
    /// Whether the map is divided into cells, so that an element may stand in several files.
    pub divided: bool,
    /// The map and its faults.
    pub loaded: Loaded,
}

/// Where the projector is known from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ProjectorFrom {
    /// The caller.
    Caller,
    /// This `map_projector_info.yaml`.
    Info(PathBuf),
    /// The map itself: MGRS of its first node, or no projection if no node has longitude and latitude.
    Map,
}

/// Why a map cannot be opened.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A directory without maps.
    #[error("{path} holds no .osm file")]
    EmptyDirectory {
        /// The directory.
        path: PathBuf,
    },
    /// Roads for navigation, not lanelets.
    #[error("{path} is not a Lanelet2 map but a plain OpenStreetMap extract: it has {roads} roads and no lanelet")]
    Navigation {
        /// The file or directory.
        path: PathBuf,
        /// Ways with `highway`.
        roads: usize,
    },
    /// Cells in which an element is not the same everywhere.
    #[error("{first} and {second} contradict each other: {kind} {id} is not the same in both{}", .more.map_or(String::new(), |more| format!("; so are {more} more elements")))]
    Contradiction {
        /// The file and line where it stands first.
        first: String,
        /// The file and line where it stands otherwise.
        second: String,
        /// Its kind.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// How many more there are, if any.
        more: Option<usize>,
    },
    /// A list of cells that cannot be read.
    #[error("{path}: {error}")]
    Metadata {
        /// The list.
        path: PathBuf,
        /// What is wrong with it.
        error: MetadataError,
    },
    /// A list of cells and a folder of cells that do not go together.
    #[error("{path} names {name}, and there is no such file{}", .more.map_or(String::new(), |more| format!("; so it does {more} more")))]
    MissingCell {
        /// The list.
        path: PathBuf,
        /// As the list writes it.
        name: String,
        /// How many more are missing, if any.
        more: Option<usize>,
    },
    /// A cell that no client would get.
    #[error("{path} is a cell that {METADATA} does not name")]
    UnlistedCell {
        /// The cell.
        path: PathBuf,
    },
    /// Neither lanelets nor roads.
    #[error("{path} is not a Lanelet2 map: it has no relation with type=lanelet")]
    NotLanelet2 {
        /// The file or directory.
        path: PathBuf,
    },
}

impl OpenError {
    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Read(error) => error.help(),
            Self::EmptyDirectory { .. } => {
                "give an .osm file, a directory of .osm files, or a map directory with lanelet2_map.osm in it"
            }
            Self::Navigation { .. } => "make a Lanelet2 map of it first: `lanewright build`",
            Self::Contradiction { .. } => {
                "divide the map anew from what the cells were made of: `lanewright split`; cells are never edited one by one"
            }
            Self::Metadata { .. } | Self::UnlistedCell { .. } => {
                "remove what does not belong there, or divide the map anew: `lanewright split` writes cells and their list"
            }
            Self::MissingCell { .. } => {
                "bring the missing cells back, or give the .osm files that are there by themselves, outside a map directory"
            }
            Self::NotLanelet2 { .. } => "give a map with lanelets; `lanewright build` makes one from OpenStreetMap",
        }
    }
}

/// The files that [`open`] reads the map from.
///
/// # Errors
///
/// If the directory cannot be listed, or holds no `.osm` file.
pub fn files_of(path: &Path) -> Result<Vec<PathBuf>, OpenError> {
    Ok(find(path)?.files)
}

/// The files that [`open`] reads the map from, and the projector file beside them, without reading the map.
///
/// # Errors
///
/// If the directory cannot be listed, or what is in it is no map, or not all of one.
pub fn locate_files(path: &Path) -> Result<(Vec<PathBuf>, ProjectorInfo), OpenError> {
    let found = find(path)?;
    found.hold_against_list()?;
    let info = found.info()?;
    Ok((found.files, info))
}

/// Whether these are Lanelet2 data: lanelets, regulatory elements, or an Autoware format version.
pub fn is_lanelet2(osm: &OsmData) -> bool {
    osm.meta.as_ref().is_some_and(|m| m.format_version.is_some())
        || osm.relations.iter().any(|r| matches!(r.tags.get("type"), Some("lanelet" | "regulatory_element")))
}

/// Whether these are roads of OpenStreetMap, and no lanelets.
pub fn is_navigation_osm(osm: &OsmData) -> bool {
    !is_lanelet2(osm) && osm.ways.iter().any(|w| w.tags.has("highway"))
}

/// Reads and loads the map at `path`; `projector` overrules the file beside the map.
///
/// # Errors
///
/// If a file cannot be read, or there is no Lanelet2 map in it.
///
/// # Errors
///
/// If a file cannot be read, or there is no `.osm` file.
pub fn open(path: &Path, projector: Option<Projector>) -> Result<Opened, OpenError> {
    let found = find(path)?;
    let info = match projector {
        Some(_) => ProjectorInfo::overruled(),
        None => found.info()?,
    };
    found.hold_against_list()?;
    let divided = found.cells.is_some();
    let osm = found.read(divided)?;
    Ok(Opened { divided, ..opened(path, osm, found.files, info, projector)? })
}

/// Reads the elements of a map, each once, and the projector file beside it. Files that contradict each other are no map.
///
/// # Errors
///
/// If a file cannot be read, files contradict each other, or there is no Lanelet2 map in them.
pub fn read_elements(path: &Path) -> Result<(OsmData, Vec<PathBuf>, ProjectorInfo), OpenError> {
    let found = find(path)?;
    found.hold_against_list()?;
    let info = found.info()?;
    let osm = found.read(true)?;
    vet(path, &osm)?;
    Ok((osm, found.files, info))
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

/// Reads and loads a map of one file from its content. `info` is the content of the projector file; `projector` overrules it.
/// Messages call the map `name`.
///
/// # Errors
///
/// If the content is no Lanelet2 map.
///
/// # Errors
///
/// If the content is no OpenStreetMap data.
pub fn open_bytes(
    name: &str,
    bytes: Vec<u8>,
    info: ProjectorInfo,
    projector: Option<Projector>,
) -> Result<Opened, OpenError> {
    let info = if projector.is_some() { ProjectorInfo::overruled() } else { info };
    let mut osm = OsmData::default();
    read_bytes(&mut osm, name, bytes)?;
    opened(Path::new(name), osm, Vec::new(), info, projector)
}

/// Whether there is a Lanelet2 map.
fn vet(path: &Path, osm: &OsmData) -> Result<(), OpenError> {
    if is_lanelet2(osm) {
        return Ok(());
    }
    let path = path.to_path_buf();
    Err(if is_navigation_osm(osm) {
        let roads = osm.ways.iter().filter(|w| w.tags.has("highway")).count();
        OpenError::Navigation { path, roads }
    } else {
        OpenError::NotLanelet2 { path }
    })
}

fn opened(
    path: &Path,
    osm: OsmData,
    files: Vec<PathBuf>,
    info: ProjectorInfo,
    projector: Option<Projector>,
) -> Result<Opened, OpenError> {
    vet(path, &osm)?;
    let (projector, projector_from) = match (projector, info.projector(), &info.path) {
        (Some(projector), ..) => (projector, ProjectorFrom::Caller),
        (None, Some(projector), Some(path)) => (projector, ProjectorFrom::Info(path.clone())),
        _ => (projector_for(&osm), ProjectorFrom::Map),
    };
    let mut loaded = from_osm(&osm, &projector);
    info.judge(&osm, &projector, &mut loaded.faults);
    Ok(Opened { osm, files, projector, projector_from, info, divided: false, loaded })
}

/// The projector of a map that does not name one. Autoware then takes MGRS; a map whose nodes have no longitude and
/// latitude at all, or 0 throughout, can only be meant for `Local`.
pub fn projector_for(osm: &OsmData) -> Projector {
    let placed = osm.nodes.iter().filter_map(|n| n.position).find(|p| *p != LonLat::default());
    if placed.is_none() && osm.nodes.iter().any(|n| n.tags.has("local_x") || n.tags.has("local_y")) {
        return Projector::Local;
    }
    let place = placed.unwrap_or_default();
    // Near the poles there is no square: any will do, and every node says that it cannot be projected.
    MgrsGrid::of(place).or_else(|| MgrsGrid::of(LonLat::default())).map_or(Projector::Local, Projector::Mgrs)
}

/// The files of a map, and the directory of its projector file.
struct Found {
    files: Vec<PathBuf>,
    folder: PathBuf,
    /// Another folder, where that one has none.
    above: Option<PathBuf>,
    /// The folder of the cells, where the map is divided.
    cells: Option<PathBuf>,
    /// Whether Autoware would load the map from here.
    autoware: bool,
}

impl Found {
    fn info(&self) -> Result<ProjectorInfo, OpenError> {
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
    fn read(&self, one_map: bool) -> Result<OsmData, OpenError> {
        let mut osm = read_files(&self.files)?;
        let contradictions = osm.leave_out_copies();
        if one_map && self.files.len() > 1 {
            agree(&osm, &contradictions)?;
            osm.sort_by_id();
        }
        Ok(osm)
    }

    /// Whether the list of the cells, where there is one, names all cells and no others.
    fn hold_against_list(&self) -> Result<(), OpenError> {
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

fn find(path: &Path) -> Result<Found, OpenError> {
    if !path.is_dir() {
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        let autoware = path.file_name() == Some(OsStr::new(MAP));
        // One cell of a divided map.
        let above = folder.parent().filter(|_| folder.file_name() == Some(OsStr::new(MAP))).map(Path::to_path_buf);
        return Ok(Found { files: vec![path.to_path_buf()], folder, above, cells: None, autoware });
    }
    let folder = path.to_path_buf();
    for inner in [path.join(MAP), path.join(format!("{MAP}.gz"))] {
        if inner.is_dir() {
            let files = files_in(&inner)?;
            return Ok(Found { files, folder, above: None, cells: Some(inner), autoware: true });
        }
        if inner.exists() {
            return Ok(Found { files: vec![inner], folder, above: None, cells: None, autoware: true });
        }
    }
    let files = files_in(path)?;
    // `.` and `..` have no name until they are resolved.
    let full = path.canonicalize().ok().filter(|full| full.file_name() == Some(OsStr::new(MAP)));
    let above = full.as_ref().and_then(|full| full.parent()).map(Path::to_path_buf);
    let cells = above.is_some().then(|| folder.clone());
    Ok(Found { files, folder, autoware: above.is_some(), above, cells })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::{Condition, INFO};
    use std::fs;

    const NODE: &str = r#"<osm><node id="1" lat="35" lon="139.3"/>"#;
    const LANELET: &str = r#"<relation id="2"><tag k="type" v="lanelet"/></relation></osm>"#;
    const LOCAL: &str = "projector_type: Local\n";

    fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        folder
    }

    fn map(id: i64) -> String {
        format!(r#"<osm><node id="{id}" lat="35" lon="139.3"/>{LANELET}"#)
    }

    fn names(opened: &Opened) -> Vec<String> {
        opened.files.iter().map(|f| f.file_name().unwrap().to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn a_file_with_and_without_projector_beside_it() {
        let alone = folder(&[("a.osm", &map(1))]);
        let opened = open(&alone.path().join("a.osm"), None).unwrap();
        assert_eq!(opened.projector, Projector::mgrs("54SUD".parse().unwrap()));
        assert_eq!(opened.projector_from, ProjectorFrom::Map);
        let beside = folder(&[("a.osm", &map(1)), (INFO, LOCAL)]);
        let opened = open(&beside.path().join("a.osm"), None).unwrap();
        assert_eq!(opened.projector, Projector::Local);
        let projector = Projector::transverse_mercator(LonLat { lon: 139.0, lat: 35.0 });
        let opened = open(&beside.path().join("a.osm"), Some(projector)).unwrap();
        assert_eq!((opened.projector, opened.projector_from), (projector, ProjectorFrom::Caller));
    }

    #[test]
    fn directories() {
        let plain = folder(&[("b.osm", &map(2)), ("a.OSM", &map(1)), ("c/d.osm", &map(3)), ("x.txt", "no map")]);
        let opened = open(plain.path(), None).unwrap();
        assert_eq!(names(&opened), ["a.OSM", "b.osm"]);
        assert_eq!(opened.loaded.map.points.len(), 2);
        let one = folder(&[(MAP, &map(1)), ("other.osm", &map(2)), (INFO, LOCAL)]);
        let opened = open(one.path(), None).unwrap();
        assert_eq!(names(&opened), [MAP]);
        assert_eq!(opened.projector_from, ProjectorFrom::Info(one.path().join(INFO)));
        let cells = folder(&[("lanelet2_map.osm/2.osm", &map(2)), ("lanelet2_map.osm/1.osm", &map(1)), (INFO, LOCAL)]);
        for path in [cells.path().to_path_buf(), cells.path().join(MAP)] {
            let opened = open(&path, None).unwrap();
            assert_eq!(names(&opened), ["1.osm", "2.osm"]);
            assert_eq!(opened.projector, Projector::Local);
        }
    }

    #[test]
    fn gzip() {
        use std::io::Write;
        let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::default());
        packed.write_all(map(1).as_bytes()).unwrap();
        let folder = folder(&[]);
        fs::write(folder.path().join("lanelet2_map.osm.gz"), packed.finish().unwrap()).unwrap();
        assert_eq!(open(folder.path(), None).unwrap().loaded.map.points.len(), 1);
    }

    #[test]
    fn errors_say_what_and_help_says_how() {
        let fails = |folder: &tempfile::TempDir, name: &str| open(&folder.path().join(name), None).unwrap_err();
        let empty = folder(&[("notes.txt", "")]);
        assert!(matches!(fails(&empty, ""), OpenError::EmptyDirectory { .. }));
        assert!(matches!(fails(&empty, "none.osm"), OpenError::Read(ReadError::Io { .. })));
        let roads = r#"<way id="2"><nd ref="1"/><tag k="highway" v="primary"/></way></osm>"#;
        let roads = folder(&[("a.osm", &[NODE, roads].concat())]);
        let error = fails(&roads, "a.osm");
        assert!(matches!(error, OpenError::Navigation { roads: 1, .. }), "{error}");
        assert!(error.to_string().contains("not a Lanelet2 map") && error.help().contains("lanewright build"));
        let nothing = folder(&[("a.osm", "<osm/>")]);
        assert!(matches!(fails(&nothing, "a.osm"), OpenError::NotLanelet2 { .. }));
    }

    /// How many things are wrong with the projector's file.
    fn about_info(files: &[(&str, &str)], name: &str) -> (Projector, usize) {
        let folder = folder(files);
        let opened = open(&folder.path().join(name), None).unwrap();
        let about = |fault: &&crate::lanelet::LoadFault| matches!(fault.condition, Condition::ProjectorInfo(_));
        (opened.projector, opened.loaded.faults.iter().filter(about).count())
    }

    #[test]
    fn what_is_wrong_with_the_projectors_file_is_a_fault_of_the_map() {
        let (map, mgrs) = (map(1), Projector::mgrs("54SUD".parse().unwrap()));
        assert_eq!(about_info(&[("a.osm", &map), (INFO, "projector_type: local\n")], "a.osm"), (Projector::Local, 1));
        assert_eq!(about_info(&[("a.osm", &map), (INFO, "nothing\n")], "a.osm"), (mgrs, 1));
        assert_eq!(about_info(&[("a.osm", &map), ("Map_projector_info.yml", LOCAL)], "a.osm"), (Projector::Local, 1));
        assert_eq!(about_info(&[("a.osm", &map)], "a.osm"), (mgrs, 0));
        assert_eq!(about_info(&[(MAP, &map)], MAP), (mgrs, 1));
        assert_eq!(about_info(&[(MAP, &map)], ""), (mgrs, 1));
    }

    #[test]
    fn a_map_without_longitudes_is_local() {
        let node = r#"<osm><node id="1" lat="" lon=""><tag k="local_x" v="1"/><tag k="local_y" v="2"/></node>"#;
        let folder = folder(&[("a.osm", &[node, LANELET].concat())]);
        assert_eq!(open(folder.path(), None).unwrap().projector, Projector::Local);
    }

    #[test]
    fn near_the_pole_nothing_breaks() {
        let folder = folder(&[("a.osm", &map(1).replace("35", "89"))]);
        assert!(matches!(open(folder.path(), None).unwrap().projector, Projector::Mgrs(_)));
    }
}
