//! Judges a map that is being mended: by all rules, as a whole or a part of it.

use std::cell::{Cell, OnceCell, RefCell};
use std::hash::{Hash, Hasher};

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHasher};

use crate::diagnostic::Diagnostic;
use crate::fix::{Judge, Route};
use crate::lanelet::index::{DrivingSide, FilledUnions, MapIndex};
use crate::lanelet::routing_pairs::{Directed, Pair, Relation, routing_pairs};
use crate::lanelet::{Condition, LoadFault, Loaded as FromOsm, ProjectorInfo, from_osm};
use crate::osm::{Node, OsmData};
use crate::projection::{LonLat, Projector};
use crate::report::failure::Failure;
use crate::rules::{self, Config};
use crate::settings::{Settings, Side};
use crate::triage::{self, Baseline, Suppressions};

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
    /// Is told how many fixes were made and how many are open.
    tell: &'a dyn Fn(usize, usize),
    /// Metres of a degree of longitude.
    east: f64,
    of_projector: RefCell<Option<OfProjector>>,
    filled_unions: FilledUnions,
    /// What is known and not to be mended.
    baseline: Option<&'a Baseline>,
    /// The places of codes in the order of findings.
    ranks: OnceCell<FxHashMap<String, usize>>,
}

/// What was found of the projector last.
struct OfProjector {
    /// Stands for where the nodes were.
    places: u64,
    /// Faults that it explains, which are not said.
    explained: Vec<LoadFault>,
    /// What is wrong with the projector.
    said: Vec<LoadFault>,
}

/// Whether two faults say the same, wherever that stands.
fn is_same(a: &LoadFault, b: &LoadFault) -> bool {
    a.subject == b.subject && a.condition == b.condition
}

impl<'a> MapJudge<'a> {
    /// One that says how far mending has come.
    pub(super) fn telling(
        map: &'a Loaded,
        projector: &'a Projector,
        info: &'a ProjectorInfo,
        tell: &'a dyn Fn(usize, usize),
    ) -> Self {
        let latitude = map.osm.nodes.iter().find_map(|node| node.position).unwrap_or_default().lat;
        let east = DEGREE * latitude.to_radians().cos();
        Self {
            map,
            projector,
            info,
            side: Cell::default(),
            tell,
            east,
            of_projector: RefCell::default(),
            filled_unions: FilledUnions::default(),
            baseline: None,
            ranks: OnceCell::new(),
        }
    }

    /// The same, and passes over what a baseline knows.
    pub(super) fn knowing(self, baseline: Option<&'a Baseline>) -> Self {
        Self { baseline, ..self }
    }

    /// What the baseline does not know.
    fn new_only(&self, mut found: Vec<Diagnostic>) -> Vec<Diagnostic> {
        if let Some(baseline) = self.baseline {
            let mut are_new = baseline.which_are_new(&found).into_iter();
            found.retain(|_| are_new.next().unwrap_or(true));
        }
        found
    }

    /// Adds what is wrong with the projector: all of it follows from where the nodes are, and few fixes move one.
    fn judge_projector(&self, osm: &OsmData, faults: &mut Vec<LoadFault>) {
        let mut hasher = FxHasher::default();
        for node in &osm.nodes {
            let bits = |place: LonLat| [place.lon.to_bits(), place.lat.to_bits()];
            let tags = ["local_x", "local_y", "ele"].map(|key| node.tags.get(key));
            (node.position.map(bits), tags).hash(&mut hasher);
        }
        let places = hasher.finish();
        let mut last = self.of_projector.borrow_mut();
        match &*last {
            Some(known) if known.places == places => {
                faults.retain(|fault| !known.explained.iter().any(|one| is_same(one, fault)));
                faults.extend(known.said.iter().cloned());
            }
            _ => {
                let before = faults.clone();
                self.info.judge(osm, self.projector, faults);
                // Some of those before are left out, and others follow them.
                let mut after = faults.iter().peekable();
                let is_left_out = |fault: &&LoadFault| after.next_if(|one| is_same(one, fault)).is_none();
                let explained: Vec<LoadFault> = before.iter().filter(is_left_out).cloned().collect();
                *last = Some(OfProjector { places, explained, said: after.cloned().collect() });
            }
        }
    }
}

/// What is found of a map's projector: it follows from the faults of the loader alone.
pub(super) fn found_of_projector(map: &Loaded) -> Result<Vec<Diagnostic>, Error> {
    let faults = map.faults.iter().filter(|fault| matches!(fault.condition, Condition::ProjectorInfo(_)));
    let faults = FromOsm { faults: faults.cloned().collect(), ..FromOsm::default() };
    Ok(found(&map.osm, &faults, &map.settings, &FilledUnions::default())?.0)
}

/// What is found in a map that is loaded, and the side on which people drive there.
fn found(
    osm: &OsmData,
    loaded: &FromOsm,
    settings: &Settings,
    unions: &FilledUnions,
) -> Result<(Vec<Diagnostic>, Option<DrivingSide>), Error> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, settings).with_filled_unions(unions);
    let found = rules::run(&index, &Config::from(settings))
        .map_err(|error| ErrorKind::Config.error(Failure::new(error.to_string())))?;
    // What somebody has answered for is not mended.
    let left = triage::sort(found, settings, Suppressions::of(settings, osm), &loaded.map, None).left;
    Ok((left, index.side.side))
}

impl Judge for MapJudge<'_> {
    type Error = Error;

    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Error> {
        let mut loaded = from_osm(osm, self.projector);
        self.judge_projector(osm, &mut loaded.faults);
        let (left, side) = found(osm, &loaded, &self.map.settings, &self.filled_unions)?;
        self.side.set(side);
        Ok(self.new_only(left))
    }

    fn parts(&self, parts: &[&OsmData]) -> Result<Vec<Vec<Diagnostic>>, Error> {
        let driving_side = self.side.get().map(|side| match side {
            DrivingSide::Left => Side::Left,
            DrivingSide::Right => Side::Right,
        });
        let settings =
            Settings { driving_side: driving_side.or(self.map.settings.driving_side), ..self.map.settings.clone() };
        let (projector, unions) = (self.projector, &self.filled_unions);
        // Whether the projector fits is a matter of the whole map.
        let found = parts.par_iter().map(|osm| Ok(found(osm, &from_osm(osm, projector), &settings, unions)?.0));
        let found: Result<Vec<Vec<Diagnostic>>, Error> = found.collect();
        Ok(found?.into_iter().map(|found| self.new_only(found)).collect())
    }

    fn place(&self, node: &Node) -> Option<[f64; 2]> {
        if *self.projector == Projector::Local {
            let number = |key: &str| node.tags.get(key)?.trim().parse::<f64>().ok().filter(|number| number.is_finite());
            return Some([number("local_x")?, number("local_y")?]);
        }
        node.position.map(|place| [place.lon * self.east, place.lat * DEGREE])
    }

    fn routes(&self, part: &OsmData) -> Vec<Route> {
        let map = from_osm(part, self.projector).map;
        let ends = |one: Directed| (one.lanelet.0, one.inverted);
        let route = |pair: Pair| {
            let Pair { who, relation, from, to } = pair;
            let is_on = relation == Relation::Following;
            Route { who, how: relation.as_str(), is_on, from: ends(from), to: ends(to) }
        };
        routing_pairs(&map).into_iter().map(route).collect()
    }

    fn tell(&self, made: usize, open: usize) {
        (self.tell)(made, open);
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
