//! A town that is built anew and keeps what people changed in it since it was built last.

use std::collections::BTreeMap;
use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;

use crate::lanelet::{INFO, MAP};
use crate::osm::{OsmData, read_bytes};
use crate::report::failure::Failure;
use crate::three_way::Deletions;

use super::config::NAME;
use super::error::{Error, ErrorKind};
use super::files::Draft;
use super::git::{git, git_bytes};
use super::load::read_failure;
use super::merged::{MergeOptions, MergedMap, Version, merge_read};
use super::own_output::{hash_of_bytes, known_hash, known_line, spare, without_hashes, wrote};
use super::{BuiltMap, Input, LayoutOptions};

/// The map as it was built, packed, beside the one that people have changed: what the next build begins with.
pub const KEPT: &str = "lanelet2_map.built.gz";
/// Between the map and the settings in that file.
const END: &str = "</osm>\n";
/// So many versions of a file are looked at in the history of a repository, the newest first.
const MOST_VERSIONS: usize = 1000;

/// What is kept.
#[derive(Clone, Debug, Default)]
pub struct KeepOptions {
    /// The map that was built once and changed since.
    pub map: PathBuf,
    /// The old build, or what it was built from, where it cannot be found.
    pub base: Option<PathBuf>,
    /// Whether the maps are left unchecked.
    pub unchecked: bool,
}

/// A new build with what people had changed in the old one.
#[derive(Debug)]
pub struct KeptMap {
    /// The map, and what became of it.
    pub merged: MergedMap,
    /// Where the old build was found.
    pub base_from: String,
    /// The new build as it is without anybody's changes.
    built: Build,
}

/// The files of a build.
#[derive(Clone, Debug)]
struct Build {
    map: Vec<u8>,
    /// The settings without what was written with them.
    settings: String,
    info: Option<String>,
}

impl Build {
    fn of(built: &BuiltMap) -> Result<Self, Error> {
        let mut map = Vec::new();
        built
            .write_osm(&mut map)
            .map_err(|error| ErrorKind::Internal.error(Failure::new(format!("the map cannot be written: {error}"))))?;
        Ok(Self { map, settings: built.settings()?, info: Some(built.projector_info()) })
    }

    fn version(&self) -> Result<Version, Error> {
        let mut osm = OsmData::default();
        read_bytes(&mut osm, MAP, self.map.clone()).map_err(|error| ErrorKind::Read.error(read_failure(error)))?;
        let settings = (NAME.to_owned(), self.settings.clone());
        let beside: BTreeMap<String, String> =
            self.info.iter().map(|info| (INFO.to_owned(), info.clone())).chain([settings]).collect();
        Ok(Version { osm, is_directory: true, beside })
    }

    /// The bytes of [`KEPT`].
    fn packed(&self) -> std::io::Result<Vec<u8>> {
        let mut packer = GzEncoder::new(Vec::new(), Compression::default());
        packer.write_all(&self.map)?;
        packer.write_all(self.settings.as_bytes())?;
        packer.finish()
    }

    fn unpacked(bytes: &[u8]) -> Option<Self> {
        let mut text = String::new();
        GzDecoder::new(bytes).read_to_string(&mut text).ok()?;
        let (map, settings) = text.split_once(END)?;
        Some(Self { map: format!("{map}{END}").into_bytes(), settings: settings.to_owned(), info: None })
    }
}

/// Merges a new build with the map that was built before and changed by people. What they deleted stays out, what both have changed
/// to something else is as people have it.
///
/// # Errors
///
/// Where the map cannot be read, was not built, or the old build is not found.
pub fn keep(
    built: &BuiltMap,
    keep: &KeepOptions,
    options: &LayoutOptions,
    tell: &dyn Fn(&str),
) -> Result<KeptMap, Error> {
    let own = Version::read(&keep.map)?;
    let built = Build::of(built)?;
    tell("looking for the old build");
    let (mut base, base_from) = old_build(keep, options)?;
    // Of the projector's file it is enough to know that nobody has changed it.
    let settings = fs::read_to_string(keep.map.join(NAME)).unwrap_or_default();
    if let Some(info) = own.beside.get(INFO)
        && (base.info.is_none()
            && known_hash(&settings, INFO).is_some_and(|hash| hash == hash_of_bytes(info.as_bytes())))
    {
        base.info = Some(info.clone());
    }
    let options = MergeOptions { place: None, unchecked: keep.unchecked, deletions: Deletions::OfOursStand };
    let merged = merge_read([&base.version()?, &own, &built.version()?], &keep.map, &keep.map, &options, tell)?;
    Ok(KeptMap { merged, base_from, built })
}

impl KeptMap {
    /// Writes the map, what stands beside it, and the build without anybody's changes, which the next build begins with. The
    /// directory may be that of the map which was kept. All is written or nothing.
    ///
    /// # Errors
    ///
    /// Where it cannot be written, or would take the place of another map.
    pub fn write(&self, directory: &Path, kept: &Path, force: bool) -> Result<(), Error> {
        if directory.canonicalize().ok() != kept.canonicalize().ok() {
            spare(directory, force)?;
        }
        self.publish(directory).map_err(ErrorKind::Write.of())
    }

    fn publish(&self, directory: &Path) -> Result<(), Failure> {
        let mut draft = Draft::new(directory)?;
        let mut write =
            |name: &str, bytes: &[u8]| draft.write(name, |file| file.write_all(bytes).and_then(|()| file.sync_all()));
        write(MAP, self.merged.merged.text.as_bytes())?;
        let packed = self.built.packed().map_err(|error| Failure::new(format!("cannot pack the map: {error}")))?;
        write(KEPT, &packed)?;
        for (name, text) in self.merged.beside.iter().flatten() {
            let mut text = text.clone();
            if name == NAME {
                // Of the build, not of what is written: so a later run knows that people have changed it, and from what.
                text += &known_line(MAP, &self.built.map);
                text += &self.built.info.as_ref().map_or(String::new(), |info| known_line(INFO, info.as_bytes()));
            }
            write(name, text.as_bytes())?;
        }
        draft.publish()
    }
}

/// The build from which people made the map, and where it was found.
fn old_build(keep: &KeepOptions, options: &LayoutOptions) -> Result<(Build, String), Error> {
    let map = &keep.map;
    let settings = fs::read_to_string(map.join(NAME)).unwrap_or_default();
    let hash = known_hash(&settings, MAP).map(str::to_owned);
    let is_it = |bytes: &[u8]| hash.as_ref().is_some_and(|hash| *hash == hash_of_bytes(bytes));
    if let Some(base) = &keep.base {
        let build = named_build(base, options)?;
        // Whoever names one for a map that does not know its own knows better.
        if hash.is_some() && !is_it(&build.map) {
            let failure =
                Failure::new(format!("{} is not the build that {} was made from", base.display(), map.display()));
            return Err(ErrorKind::Read.error(failure.about(base.display().to_string()).help(format!(
                "{NAME} says its sha256, of {MAP}; what another version of lanewright builds from the same input may differ"
            ))));
        }
        return Ok((build, base.display().to_string()));
    }
    let Some(_) = &hash else {
        let what = if wrote(&map.join(NAME)) {
            "does not say from which build"
        } else {
            "was not written by `build`, so that nobody knows from which build"
        };
        let failure = Failure::new(format!("{} {what} {MAP} was made", map.join(NAME).display()));
        return Err(ErrorKind::Read.error(failure.help("give the old build with --base, or what it was built from")));
    };
    if let Ok(bytes) = fs::read(map.join(MAP))
        && is_it(&bytes)
    {
        return Ok((
            Build { map: bytes, settings: without_hashes(&settings), info: None },
            "the map itself, which nobody has changed".to_owned(),
        ));
    }
    let kept = fs::read(map.join(KEPT)).ok().and_then(|bytes| Build::unpacked(&bytes));
    if let Some(build) = kept.filter(|build| is_it(&build.map)) {
        return Ok((build, map.join(KEPT).display().to_string()));
    }
    if let Some((build, commit)) = in_history(map, &is_it) {
        return Ok((build, format!("commit {commit}")));
    }
    let failure = Failure::new(format!("the build that {} was made from is not found", map.display()));
    Err(ErrorKind::Read.error(failure.about(map.display().to_string()).help(format!(
        "it is neither beside it ({KEPT}) nor in the history of a git repository; give it with --base, or what it was built from"
    ))))
}

/// A build that the user names: a map, or what it was built from.
fn named_build(base: &Path, options: &LayoutOptions) -> Result<Build, Error> {
    let read = |path: &Path| {
        fs::read(path).map_err(|error| {
            ErrorKind::Read.error(
                Failure::new(format!("cannot read {}: {error}", path.display())).about(path.display().to_string()),
            )
        })
    };
    if base.is_dir() {
        let beside = |name: &str| fs::read_to_string(base.join(name)).ok();
        let settings = without_hashes(&beside(NAME).unwrap_or_default());
        return Ok(Build { map: read(&base.join(MAP))?, settings, info: beside(INFO) });
    }
    let bytes = read(base)?;
    if let Some(build) = Build::unpacked(&bytes).filter(|build| is_map(&build.map)) {
        return Ok(build);
    }
    if is_map(&bytes) {
        return Ok(Build { map: bytes, settings: String::new(), info: None });
    }
    let input = Input::from(base);
    let built = match input.is_opendrive() {
        true => BuiltMap::of_opendrive(input, options, &|_| ())?,
        false => BuiltMap::uncontested(options, |options| super::geometry(base, options))?,
    };
    Build::of(&built)
}

/// Whether these are Lanelet2 data.
fn is_map(bytes: &[u8]) -> bool {
    let mut osm = OsmData::default();
    read_bytes(&mut osm, MAP, bytes.to_vec()).is_ok() && crate::lanelet::is_lanelet2(&osm)
}

/// The build in the history of the map's file, where that is in a git repository, and its commit.
fn in_history(map: &Path, is_it: &dyn Fn(&[u8]) -> bool) -> Option<(Build, String)> {
    let commits = git(map, &["log", "--format=%h", &format!("--max-count={MOST_VERSIONS}"), "--", MAP]).ok()?;
    let mut seen: Vec<String> = Vec::new();
    for commit in commits.lines() {
        let file = |name: &str| format!("{commit}:./{name}");
        // A commit that deletes it has none.
        let Ok(blob) = git(map, &["rev-parse", &file(MAP)]) else { continue };
        if seen.contains(&blob) {
            continue;
        }
        let bytes = git_bytes(map, &["cat-file", "blob", &blob]).ok()?;
        seen.push(blob);
        if is_it(&bytes) {
            let beside =
                |name: &str| git_bytes(map, &["show", &file(name)]).ok().and_then(|text| String::from_utf8(text).ok());
            let settings = without_hashes(&beside(NAME).unwrap_or_default());
            return Some((Build { map: bytes, settings, info: beside(INFO) }, commit.to_owned()));
        }
    }
    None
}
