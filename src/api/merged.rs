//! Two maps that were made from one, merged, and what came of it.

use std::collections::BTreeMap;
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Severity, Subject};
use crate::lanelet::{MAP, ProjectorInfo, is_lanelet2, locate_files};
use crate::osm::{ElementKind, OsmData, ReadError, read_bytes};
use crate::report::failure::Failure;
use crate::settings::Settings;
use crate::three_way::{self, Conflict, Deletions, Key, Merged, Side, Versions, merge_settings};

use super::checked::{CheckOptions, Checked};
use super::config::{self, Configuration, NAME};
use super::conflicts;
use super::error::{Error, ErrorKind};
use super::files::{self, Draft, there_already};
use super::fixed::undivided;
use super::load::{Loaded, home, open_failure, read_failure};
use super::own_output::without_hashes;

/// What is merged, and how.
#[derive(Clone, Debug, Default)]
pub struct MergeOptions {
    /// Where the map belongs, where that is not where ours is: the settings and the projector file beside it count.
    pub place: Option<PathBuf>,
    /// Whether the three maps are left unchecked.
    pub unchecked: bool,
    /// Who wins where one side has deleted what the other has changed.
    pub deletions: Deletions,
}

/// A merged map, in memory until it is written.
#[derive(Debug)]
pub struct MergedMap {
    /// Its text, and what became of the elements.
    pub merged: Merged,
    /// All that contradicts, in the map and beside it.
    pub conflicts: Vec<Conflict>,
    /// What is found in it that was found in neither side; nothing where it is unchecked.
    pub new_findings: Vec<Diagnostic>,
    /// The map as it is checked, with all of its findings; `None` where it is unchecked.
    pub checked: Option<Checked>,
    /// What stands beside it, where maps were given as directories.
    pub(super) beside: Option<Vec<(String, String)>>,
    /// The directory or file of ours, which may be written over.
    ours: PathBuf,
}

/// Merges what two maps have made of a third. Each is a file, or a directory with one; where they are directories, what stands beside
/// the maps is merged, too.
///
/// # Errors
///
/// Where a map or what stands beside it cannot be read, or a map has several files.
pub fn merge_versions(
    [base, ours, theirs]: [&Path; 3],
    options: &MergeOptions,
    tell: &dyn Fn(&str),
) -> Result<MergedMap, Error> {
    let (base, (own, other)) =
        rayon::join(|| Version::read(base), || rayon::join(|| Version::read(ours), || Version::read(theirs)));
    let (base, own, other) = (base?, own?, other?);
    merge_read([&base, &own, &other], options.place.as_deref().unwrap_or(ours), ours, options, tell)
}

/// Merges what was read; settings beside `place` count for the check, and `ours` may be written over.
pub(super) fn merge_read(
    [base, own, other]: [&Version; 3],
    place: &Path,
    ours: &Path,
    options: &MergeOptions,
    tell: &dyn Fn(&str),
) -> Result<MergedMap, Error> {
    let in_directories = base.is_directory && own.is_directory && other.is_directory;
    tell("merging");
    let merged = three_way::merge(Versions { base: &base.osm, ours: &own.osm, theirs: &other.osm }, options.deletions);
    let mut conflicts = merged.conflicts.clone();
    let beside = match in_directories {
        true => Some(merged_beside([base, own, other], &merged, &mut conflicts)?),
        false => None,
    };
    // A repository may hold roads of OpenStreetMap, too, from which maps are built: no rule speaks of them.
    let is_map = [own, other].iter().all(|version| is_lanelet2(&version.osm));
    let (new_findings, checked) = match options.unchecked || !is_map {
        true => (Vec::new(), None),
        false => {
            tell("checking");
            let (found, checked) = new_findings(place, [own, other], &merged)?;
            (found, Some(checked))
        }
    };
    Ok(MergedMap { merged, conflicts, new_findings, checked, beside, ours: ours.to_path_buf() })
}

impl MergedMap {
    /// Whether somebody has to look: something contradicts, or is wrong that was right on both sides.
    pub fn needs_a_look(&self) -> bool {
        !self.conflicts.is_empty() || self.new_findings.iter().any(|found| found.severity == Severity::Error)
    }

    /// The conflicts and the new findings, as findings on the map; nothing where it is unchecked.
    pub fn findings(&self) -> Vec<Diagnostic> {
        let conflicts = self.checked.as_ref().map(|it| conflicts::diagnostics(&self.conflicts, &it.loaded.map));
        conflicts.into_iter().flatten().chain(self.new_findings.iter().cloned()).collect()
    }

    /// Writes the map: a file, where files were merged, else a map directory, which may be that of ours. All is written or nothing.
    ///
    /// # Errors
    ///
    /// Where it cannot be written, or the directory holds another map.
    pub fn write(&self, output: &Path) -> Result<(), Error> {
        self.publish(output).map_err(ErrorKind::Write.of())
    }

    fn publish(&self, output: &Path) -> Result<(), Failure> {
        let Some(beside) = &self.beside else {
            return files::write(output, self.merged.text.as_bytes());
        };
        let is_ours = || output.canonicalize().ok() == self.ours.canonicalize().ok();
        let place = output.join(MAP);
        if place.exists() && !is_ours() {
            return Err(there_already(&place));
        }
        let mut draft = Draft::new(output)?;
        draft.write(MAP, |file| file.write_all(self.merged.text.as_bytes()).and_then(|()| file.sync_all()))?;
        for (name, text) in beside {
            draft.write(name, |file| file.write_all(text.as_bytes()).and_then(|()| file.sync_all()))?;
        }
        draft.publish()
    }
}

/// One of the three maps.
pub(super) struct Version {
    pub(super) osm: OsmData,
    pub(super) is_directory: bool,
    /// What stands beside it, by name.
    pub(super) beside: BTreeMap<String, String>,
}

impl Version {
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let read = |failure| ErrorKind::Read.error(failure);
        files::complete(home(path)).map_err(read)?;
        let (files, info) = locate_files(path).map_err(|error| read(open_failure(error)))?;
        let is_cell =
            |file: &PathBuf| file.parent().is_some_and(|folder| folder.file_name().is_some_and(|it| it == MAP));
        if files.iter().any(is_cell) {
            return Err(read(undivided("merges versions of")));
        }
        let [file] = &files[..] else {
            let failure = Failure::new(format!("{} has {} files", path.display(), files.len()));
            return Err(read(
                failure
                    .about(path.display().to_string())
                    .help(format!("make one of them first: lanewright merge {} -o WHOLE", path.display())),
            ));
        };
        let is_directory = path.is_dir();
        let mut beside = BTreeMap::new();
        if is_directory {
            let settings = Some(home(path).join(NAME)).filter(|file| file.is_file());
            for file in info.path.into_iter().chain(settings) {
                let name = file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
                let text = fs::read_to_string(&file).map_err(|error| read(unreadable(&file, &error)))?;
                beside.insert(name, text);
            }
        }
        Ok(Self { osm: read_map(file).map_err(|error| read(read_failure(error)))?, is_directory, beside })
    }
}

fn unreadable(file: &Path, error: &std::io::Error) -> Failure {
    Failure::new(format!("cannot read {}: {error}", file.display())).about(file.display().to_string())
}

/// Reads a map. An empty file, which git gives where both sides have added a map, is an empty one.
fn read_map(file: &Path) -> Result<OsmData, ReadError> {
    let mut osm = OsmData::default();
    let bytes = fs::read(file).map_err(|source| ReadError::Io { path: file.to_path_buf(), source })?;
    if !bytes.is_empty() {
        read_bytes(&mut osm, &file.display().to_string(), bytes)?;
    }
    Ok(osm)
}

/// Merges three versions of a `lanewright.toml`, by keys; the text, and what contradicts.
///
/// # Errors
///
/// Where a file cannot be read or is no TOML.
pub fn merge_settings_files(files: [&Path; 3]) -> Result<(String, Vec<Conflict>), Error> {
    let [base, ours, theirs] =
        files.map(|file| fs::read_to_string(file).map_err(|error| ErrorKind::Read.error(unreadable(file, &error))));
    merge_settings([&base?, &ours?, &theirs?], &Default::default())
        .map_err(|error| ErrorKind::Config.error(broken_settings(&error)))
}

/// What stands beside the merged map.
fn merged_beside(
    versions: [&Version; 3],
    merged: &Merged,
    conflicts: &mut Vec<Conflict>,
) -> Result<Vec<(String, String)>, Error> {
    let mut names: Vec<&String> = versions.iter().flat_map(|one| one.beside.keys()).collect();
    names.sort_unstable();
    names.dedup();
    let mut beside = Vec::new();
    for name in names {
        let texts = versions.map(|one| one.beside.get(name).map(String::as_str));
        let text = if name == NAME {
            let texts = texts.map(|text| without_hashes(text.unwrap_or_default()));
            let (text, unmerged) = merge_settings(texts.each_ref().map(String::as_str), &merged.new_ids)
                .map_err(|error| ErrorKind::Config.error(broken_settings(&error)))?;
            conflicts.extend(unmerged);
            Some(text)
        } else {
            one_of(name, texts, conflicts).map(str::to_owned)
        };
        beside.extend(text.map(|text| (name.clone(), text)));
    }
    Ok(beside)
}

pub(super) fn broken_settings(error: &three_way::SettingsConflict) -> Failure {
    let side = error.side.map_or("base", Side::as_str);
    Failure::new(format!("{NAME} of {side} cannot be merged: {error}")).help("mend it first; nothing was written")
}

/// A file beside the map that has no parts, such as the projector's.
fn one_of<'t>(
    name: &str,
    [base, ours, theirs]: [Option<&'t str>; 3],
    conflicts: &mut Vec<Conflict>,
) -> Option<&'t str> {
    if theirs == base || ours == theirs {
        return ours;
    }
    if ours == base {
        return theirs;
    }
    let said = |text: Option<&str>| text.map(|text| text.trim().replace('\n', ", "));
    conflicts.push(Conflict {
        subject: Subject::Map,
        about: format!("file {name}"),
        base: said(base),
        ours: said(ours),
        theirs: said(theirs),
        taken: Side::Ours,
        at: None,
    });
    ours
}

/// What is found in the merged map and in neither side, so that the merge has brought it about; and the map as it was checked.
fn new_findings(
    place: &Path,
    [ours, theirs]: [&Version; 2],
    merged: &Merged,
) -> Result<(Vec<Diagnostic>, Checked), Error> {
    let settings = config::settings(home(place), &Configuration::default()).map_err(ErrorKind::Config.of())?;
    let (_, info) = locate_files(place).map_err(|error| ErrorKind::Read.error(open_failure(error)))?;
    let name = place.display().to_string();
    let check = |text: &str| checked(&name, text, &info, &settings);
    let text = |version: &Version| version.osm.sources.first().map(|source| source.text.clone()).unwrap_or_default();
    let checked = check(&merged.text)?;
    // Each finding with how many of its like come before it.
    let mut seen: BTreeMap<(&str, Subject), usize> = BTreeMap::new();
    let mut new: Vec<(&Diagnostic, usize)> = Vec::new();
    for found in &checked.sorted.left {
        let before = seen.entry((&found.code, found.finding.subject)).or_default();
        new.push((found, *before));
        *before += 1;
    }
    for (version, new_ids) in [(ours, None), (theirs, Some(&merged.new_ids))] {
        // Most maps have no findings, and checking takes longest.
        if new.is_empty() {
            break;
        }
        let mut known: BTreeMap<(String, Subject), usize> = BTreeMap::new();
        for found in check(&text(version))?.sorted.left {
            *known.entry((found.code, renumbered(found.finding.subject, new_ids))).or_default() += 1;
        }
        let is_new = |found: &Diagnostic, before: usize| {
            known.get(&(found.code.clone(), found.finding.subject)).is_none_or(|count| *count <= before)
        };
        new.retain(|(found, before)| is_new(found, *before));
    }
    let new = new.into_iter().map(|(found, _)| found.clone()).collect();
    Ok((new, checked))
}

fn checked(name: &str, text: &str, info: &ProjectorInfo, settings: &Settings) -> Result<Checked, Error> {
    let loaded = Loaded::of_text(name, text.to_owned(), info.clone(), settings.clone())?;
    Checked::of(loaded, CheckOptions::default())
}

/// The element under the id that it has in the merged map.
fn renumbered(subject: Subject, new_ids: Option<&rustc_hash::FxHashMap<Key, i64>>) -> Subject {
    let new = |kind, id: i64| new_ids.and_then(|ids| ids.get(&(kind, id)).copied()).unwrap_or(id);
    match subject {
        Subject::Map => Subject::Map,
        Subject::Point(id) => Subject::Point(new(ElementKind::Node, id)),
        Subject::Node(id) => Subject::Node(new(ElementKind::Node, id)),
        Subject::LineString(id) => Subject::LineString(new(ElementKind::Way, id)),
        Subject::Polygon(id) => Subject::Polygon(new(ElementKind::Way, id)),
        Subject::Way(id) => Subject::Way(new(ElementKind::Way, id)),
        Subject::Lanelet(id) => Subject::Lanelet(new(ElementKind::Relation, id)),
        Subject::RegulatoryElement(id) => Subject::RegulatoryElement(new(ElementKind::Relation, id)),
        Subject::Relation(id) => Subject::Relation(new(ElementKind::Relation, id)),
    }
}
