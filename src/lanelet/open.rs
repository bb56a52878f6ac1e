//! Opens a map wherever it lies: one file, a directory of `.osm` files, or an Autoware map directory.

mod error;
mod map_files;

use std::path::{Path, PathBuf};

use crate::osm::{OsmData, read_bytes, refuse_off_earth};
use crate::projection::{LonLat, MgrsGrid, Projector};

use super::{Loaded, ProjectorInfo, from_osm, inferred_projector};
pub use error::OpenError;
use map_files::MapFiles;

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
    /// The map itself: see [`inferred_projector`].
    Map,
}

/// The files that [`open`] reads the map from.
///
/// # Errors
///
/// If the directory cannot be listed, or holds no `.osm` file.
pub fn files_of(path: &Path) -> Result<Vec<PathBuf>, OpenError> {
    Ok(MapFiles::find(path)?.files)
}

/// The files that [`open`] reads the map from, and the projector file beside them, without reading the map.
///
/// # Errors
///
/// If the directory cannot be listed, or what is in it is no map, or not all of one.
pub fn locate_files(path: &Path) -> Result<(Vec<PathBuf>, ProjectorInfo), OpenError> {
    let found = MapFiles::find(path)?;
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
pub fn open(path: &Path, projector: Option<Projector>) -> Result<Opened, OpenError> {
    let found = MapFiles::find(path)?;
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
    let found = MapFiles::find(path)?;
    found.hold_against_list()?;
    let info = found.info()?;
    let osm = found.read(true)?;
    vet(path, &osm)?;
    Ok((osm, found.files, info))
}

/// Reads and loads a map of one file from its content. `info` is the content of the projector file; `projector` overrules it.
/// Messages call the map `name`.
///
/// # Errors
///
/// If the content is no OpenStreetMap data, or no Lanelet2 map.
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
    refuse_off_earth(osm)?;
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
    let (projector, projector_from, info) = match (projector, info.projector(), &info.path) {
        (Some(projector), ..) => (projector, ProjectorFrom::Caller, info),
        (None, Some(projector), Some(path)) => (projector, ProjectorFrom::Info(path.clone()), info),
        _ => {
            let inferred = inferred_projector(&osm);
            (inferred.projector, ProjectorFrom::Map, info.with_inferred(inferred))
        }
    };
    let mut loaded = from_osm(&osm, &projector);
    info.judge(&osm, &projector, &mut loaded.faults);
    Ok(Opened { osm, files, projector, projector_from, info, divided: false, loaded })
}

/// The projector that the first nodes of a map tell: MGRS, to which Autoware falls back; a map whose nodes have no longitude and
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanelet::cell_metadata::MAP;
    use crate::lanelet::{Condition, INFO};
    use crate::osm::ReadError;
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
