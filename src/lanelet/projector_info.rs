//! `map_projector_info.yaml` beside a map: found by its name or one like it, and held against the map.

use std::fs;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Subject, nearest};
use crate::osm::OsmData;
use crate::projection::{Info, InfoError, LonLat, MgrsGrid, Projector, VerticalDatum, read_info};

use super::fault::{Condition, InfoFault, LoadFault};
use super::inferred_projector::{Evidence, Inferred, explaining, twice};

/// What Autoware calls the projector's file beside a map.
pub const INFO: &str = "map_projector_info.yaml";

/// The shortest distance to an origin that is worth a word to the rules, metres.
const BESIDE: f64 = 10_000.0;
/// Mean radius of the earth, metres.
const EARTH: f64 = 6_371_000.0;

/// What is known of a map's projector without the map.
#[derive(Clone, Debug, Default)]
pub struct ProjectorInfo {
    /// The file.
    pub path: Option<PathBuf>,
    /// What it says.
    info: Option<Info>,
    /// Whether somebody else has named the projector: then the file does not matter.
    overruled: bool,
    /// Whether Autoware would look for the file beside this map.
    expected: bool,
    /// What the map tells, where the file does not.
    inferred: Option<Inferred>,
}

impl ProjectorInfo {
    /// Looks into a folder; `expected` if Autoware would load the map there.
    pub(super) fn beside(folder: &Path, expected: bool) -> std::io::Result<Self> {
        let own = folder.join(INFO);
        let path = if own.is_file() { Some(own) } else { like(folder) };
        let Some(path) = path else { return Ok(Self { expected, ..Self::default() }) };
        let mut found = Self::of(&path, &String::from_utf8_lossy(&fs::read(&path)?));
        if let Some(info) = found.info.as_mut().filter(|info| info.is_of_something_else())
            && fs::symlink_metadata(&path)?.is_symlink()
        {
            // Its lines may be nobody's business: the link may have come with a map.
            *info = Info { errors: vec![InfoError::Linked], ..Info::default() };
        }
        Ok(found)
    }

    /// A file of this name, with this text.
    pub fn of(path: &Path, text: &str) -> Self {
        Self { path: Some(path.to_path_buf()), info: Some(read_info(text)), expected: true, ..Self::default() }
    }

    /// The same, with what the map tells.
    #[must_use]
    pub(super) fn with_inferred(self, inferred: Inferred) -> Self {
        Self { inferred: Some(inferred), ..self }
    }

    /// Somebody else has named the projector.
    pub fn overruled() -> Self {
        Self { overruled: true, ..Self::default() }
    }

    /// The projector that the file names, or was meant to.
    pub fn projector(&self) -> Option<Projector> {
        self.info.as_ref()?.projector
    }

    /// What the file says that heights are measured from.
    pub fn datum(&self) -> VerticalDatum {
        self.info.as_ref().map_or_else(VerticalDatum::default, |info| info.datum)
    }

    /// Whether Autoware reads the file as it is.
    pub fn is_sound(&self) -> bool {
        self.info.as_ref().is_none_or(|info| info.errors.is_empty()) && self.misnamed().is_none()
    }

    fn misnamed(&self) -> Option<String> {
        let name = self.path.as_ref()?.file_name()?.to_string_lossy().into_owned();
        (name != INFO).then_some(name)
    }

    /// What the file that is not there would have to say.
    fn missing(&self, projector: Projector) -> Option<InfoFault> {
        let evidence = self.inferred.as_ref().map(|inferred| &inferred.evidence);
        if evidence == Some(&Evidence::Metres) {
            return None;
        }
        let needed = Some(projector).filter(|projector| !matches!(projector, Projector::Mgrs(_)));
        let squares = match evidence {
            Some(Evidence::Squares(squares)) => squares.clone(),
            _ => Vec::new(),
        };
        (needed.is_some() || self.expected).then_some(InfoFault::Missing { needed, squares })
    }

    /// Says what is wrong with the file, and no longer of the nodes what only follows from it.
    pub fn judge(&self, osm: &OsmData, projector: &Projector, faults: &mut Vec<LoadFault>) {
        if self.overruled {
            return;
        }
        let mut found: Vec<InfoFault> =
            self.misnamed().map(|found| InfoFault::Misnamed { found }).into_iter().collect();
        if let Some(info) = &self.info {
            found.extend(info.errors.iter().cloned().map(InfoFault::Unusable));
            let unread = info.unread.iter().cloned();
            found.extend(unread.map(|(key, meant)| InfoFault::Unread { key, meant }));
        }
        match (self.info.is_some(), self.projector()) {
            // Where nobody has asked the map, what does not fit it still tells.
            (false, _) if self.inferred.is_none() => {
                let meant = at_odds(osm, projector, faults);
                found.extend(self.missing(meant.unwrap_or(*projector)));
            }
            (false, _) => found.extend(self.missing(*projector)),
            (true, Some(said)) => match at_odds(osm, projector, faults) {
                Some(meant) => found.push(InfoFault::AtOdds { said, meant }),
                None => found.extend(other_grid(osm, said, faults).or_else(|| far_origin(osm, said))),
            },
            // What does not fit a guess says nothing of a map whose file cannot be read.
            (true, None) => drop(at_odds(osm, projector, faults)),
        }
        let fault = |fault| LoadFault { subject: Subject::Map, span: None, condition: Condition::ProjectorInfo(fault) };
        faults.extend(found.into_iter().map(fault));
    }
}

/// A file whose name was meant to be the right one.
fn like(folder: &Path) -> Option<PathBuf> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let names = fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| is_like(name)).collect();
    names.sort_unstable();
    names.into_iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

fn is_like(name: &str) -> bool {
    let yaml =
        name.rsplit_once('.').is_some_and(|(_, ending)| matches!(ending.to_lowercase().as_str(), "yaml" | "yml"));
    yaml && nearest(name, [INFO]).is_some()
}

/// The projector that explains the local coordinates where this one does not.
fn at_odds(osm: &OsmData, projector: &Projector, faults: &mut Vec<LoadFault>) -> Option<Projector> {
    let of_all = |fault: &LoadFault| {
        matches!(fault.condition, Condition::LocalShifted { .. } | Condition::LocalUnexplained { .. })
    };
    if !faults.iter().any(of_all) {
        return None;
    }
    let best = explaining(&twice(osm))?;
    if best == *projector {
        return None;
    }
    faults.retain(|fault| !of_all(fault));
    Some(best)
}

/// The square that the map lies in, where none of it lies in the one that is named.
fn other_grid(osm: &OsmData, said: Projector, faults: &mut Vec<LoadFault>) -> Option<InfoFault> {
    let Projector::Mgrs(said) = said else { return None };
    let others = faults.iter().filter_map(|fault| match fault.condition {
        Condition::OtherSquare { square, nodes, .. } => Some((nodes, square)),
        _ => None,
    });
    let others: Vec<(usize, MgrsGrid)> = others.collect();
    let placed = osm.nodes.iter().filter(|node| node.position.is_some()).count();
    if others.is_empty() || others.iter().map(|(nodes, _)| nodes).sum::<usize>() < placed {
        return None;
    }
    let meant = others.iter().max_by_key(|(nodes, _)| *nodes)?.1;
    // In one square after all; in several, each is still said.
    faults.retain(|fault| match fault.condition {
        Condition::OtherSquare { square, .. } => !square.same_square(&meant),
        _ => true,
    });
    Some(InfoFault::OtherGrid { said, meant })
}

fn far_origin(osm: &OsmData, said: Projector) -> Option<InfoFault> {
    let (Projector::TransverseMercator { origin, .. }
    | Projector::LocalCartesianUtm { origin }
    | Projector::LocalCartesian { origin }) = said
    else {
        return None;
    };
    let places = osm.nodes.iter().filter_map(|node| node.position).filter(|place| *place != LonLat::default());
    let distance = places.map(|place| apart(place, origin)).min_by(f64::total_cmp)?;
    (distance > BESIDE).then_some(InfoFault::FarOrigin { distance })
}

/// Along a great circle, metres.
fn apart(a: LonLat, b: LonLat) -> f64 {
    let half = |x: f64, y: f64| ((y - x).to_radians() / 2.0).sin().powi(2);
    let [north, south] = [a.lat, b.lat].map(|lat| lat.to_radians().cos());
    let h = half(a.lat, b.lat) + north * south * half(a.lon, b.lon);
    2.0 * EARTH * h.clamp(0.0, 1.0).sqrt().asin()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_were_meant() {
        for name in
            ["Map_Projector_Info.yaml", "map_projection_info.yaml", "map_projector_info.yml", "map_proj_info.yaml"]
        {
            assert!(is_like(name), "{name}");
        }
        for name in
            ["map_config.yaml", "pointcloud_map_metadata.yaml", "lanelet2_map_metadata.yaml", "map_projector_info.txt"]
        {
            assert!(!is_like(name), "{name}");
        }
    }

    #[test]
    fn distances_are_those_of_the_globe() {
        let [tokyo, osaka] = [LonLat { lon: 139.6917, lat: 35.6895 }, LonLat { lon: 135.5023, lat: 34.6937 }];
        assert!((apart(tokyo, osaka) - 396_000.0).abs() < 3_000.0);
    }
}
