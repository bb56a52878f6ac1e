//! What the tests of the rules share: a map from a file, judged.

use std::path::Path;

use lanewright::diagnostic::Diagnostic;
use lanewright::lanelet::index::MapIndex;
use lanewright::lanelet::{Loaded, ProjectorInfo, from_osm};
use lanewright::osm::{OsmData, read_bytes};
use lanewright::projection::{MgrsGrid, Projector};
use lanewright::rules::{self, Config};
use lanewright::settings::Settings;

/// A file's content and the map Autoware would make of it, with the projector that is named beside it, or else in the MGRS
/// square of its first node.
pub fn load(path: &Path) -> (OsmData, Loaded) {
    let mut data = OsmData::default();
    let name = path.file_name().unwrap().to_string_lossy().into_owned();
    read_bytes(&mut data, &name, std::fs::read(path).unwrap()).unwrap();
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    let info =
        info_of(path).map_or_else(ProjectorInfo::default, |(name, text)| ProjectorInfo::of(name.as_ref(), &text));
    let projector = info.projector().unwrap_or(first.map_or(Projector::Local, Projector::mgrs));
    let mut loaded = from_osm(&data, &projector);
    info.judge(&data, &projector, &mut loaded.faults);
    (data, loaded)
}

/// The map Autoware would make of some data, in the MGRS square of its first node.
pub fn loaded(data: &OsmData) -> Loaded {
    let first = data.nodes.iter().find_map(|node| node.position).and_then(MgrsGrid::of);
    from_osm(data, &first.map_or(Projector::Local, Projector::mgrs))
}

/// Name and text of the projector's file of a map of the tests: `good.map_projector_info.yaml` beside `good.osm`.
pub fn info_of(map: &Path) -> Option<(String, String)> {
    let start = format!("{}.", map.file_stem()?.to_string_lossy());
    let files = map.parent()?.read_dir().ok()?.map(|entry| entry.unwrap().path());
    let mut infos = files.filter(|path| path.extension().is_some_and(|ending| ending == "yaml" || ending == "yml"));
    infos.find_map(|path| {
        let name = path.file_name()?.to_str()?.strip_prefix(&start)?.to_owned();
        Some((name, std::fs::read_to_string(&path).unwrap()))
    })
}

/// The findings of all rules as their documents have them.
pub fn judge(loaded: &Loaded, settings: &Settings) -> Vec<Diagnostic> {
    judge_as(loaded, settings, &Config::default())
}

/// The findings of all rules as a user wants them.
pub fn judge_as(loaded: &Loaded, settings: &Settings, config: &Config) -> Vec<Diagnostic> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, settings);
    rules::run(&index, config).unwrap()
}

/// What stands beside a map of the tests: `good.toml` beside `good.osm`, as `lanewright.toml` stands beside a map.
pub fn beside(map: &Path) -> (Settings, Config) {
    let Ok(text) = std::fs::read_to_string(map.with_extension("toml")) else { return Default::default() };
    let mut table: toml::Table = toml::from_str(&text).unwrap();
    let parameters = table.remove("parameters").map(|value| value.try_into().unwrap()).unwrap_or_default();
    (toml::Value::Table(table).try_into().unwrap(), Config { parameters, ..Config::default() })
}
