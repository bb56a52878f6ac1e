//! Judges a map that is being mended: by all rules, as a whole or a part of it.

use std::cell::{Cell, OnceCell};

use rustc_hash::FxHashMap;

use crate::diagnostic::Diagnostic;
use crate::fix::Judge;
use crate::lanelet::index::{DrivingSide, MapIndex, Thresholds};
use crate::lanelet::{ProjectorInfo, from_osm};
use crate::osm::{Node, OsmData};
use crate::projection::Projector;
use crate::report::failure::Failure;
use crate::rules::{self, Config};
use crate::settings::{Settings, Side};
use crate::triage::{self, Suppressions};

use super::error::{Error, ErrorKind};
use super::load::Loaded;

/// Metres of a degree of latitude.
const DEGREE: f64 = 111_320.0;

/// A map's rules and settings, with which its edited texts are judged.
pub(super) struct MapJudge<'a> {
    map: &'a Loaded,
    projector: &'a Projector,
    info: &'a ProjectorInfo,
    /// On which side people drive, as the whole map shows: a part may show nothing.
    side: Cell<Option<DrivingSide>>,
    /// Metres of a degree of longitude.
    east: f64,
    /// The places of codes in the order of findings.
    ranks: OnceCell<FxHashMap<String, usize>>,
}

impl<'a> MapJudge<'a> {
    pub(super) fn of(map: &'a Loaded, projector: &'a Projector, info: &'a ProjectorInfo) -> Self {
        let latitude = map.osm.nodes.iter().find_map(|node| node.position).unwrap_or_default().lat;
        let east = DEGREE * latitude.to_radians().cos();
        Self { map, projector, info, side: Cell::default(), east, ranks: OnceCell::new() }
    }

    fn found(&self, osm: &OsmData, settings: &Settings) -> Result<(Vec<Diagnostic>, Option<DrivingSide>), Error> {
        let mut loaded = from_osm(osm, self.projector);
        self.info.judge(osm, self.projector, &mut loaded.faults);
        let index = MapIndex::new(&loaded.map, &loaded.faults, settings, Thresholds::default());
        let found = rules::run(&index, &Config::from(settings))
            .map_err(|error| ErrorKind::Config.error(Failure::new(error.to_string())))?;
        // What somebody has answered for is not mended.
        let left = triage::sort(found, settings, Suppressions::of(settings, osm), &loaded.map, None).left;
        Ok((left, index.side.side))
    }
}

impl Judge for MapJudge<'_> {
    type Error = Error;

    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Error> {
        let (left, side) = self.found(osm, &self.map.settings)?;
        self.side.set(side);
        Ok(left)
    }

    fn part(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Error> {
        let driving_side = self.side.get().map(|side| match side {
            DrivingSide::Left => Side::Left,
            DrivingSide::Right => Side::Right,
        });
        let settings =
            Settings { driving_side: driving_side.or(self.map.settings.driving_side), ..self.map.settings.clone() };
        Ok(self.found(osm, &settings)?.0)
    }

    fn place(&self, node: &Node) -> Option<[f64; 2]> {
        if *self.projector == Projector::Local {
            let number = |key: &str| node.tags.get(key)?.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            return Some([number("local_x")?, number("local_y")?]);
        }
        node.position.map(|place| [place.lon * self.east, place.lat * DEGREE])
    }

    fn rank(&self, code: &str) -> usize {
        let ranks = self.ranks.get_or_init(|| {
            let rows = rules::table().unwrap_or_default();
            let codes = rows.iter().flat_map(|row| {
                let id = &row.requirement.id;
                row.requirement.faults.iter().map(move |(slug, _)| format!("{id}/{slug}"))
            });
            codes.zip(0..).collect()
        });
        ranks.get(code).copied().unwrap_or(usize::MAX)
    }
}
