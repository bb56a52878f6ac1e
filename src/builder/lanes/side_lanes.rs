//! What lies beside the lanes for cars as lanelets: bicycle lanes, shoulders, parked cars, strips for people on foot.
//!
//! Strips of one use side by side are one lanelet, or two on each other where bicycles ride both ways: so either shares its
//! border with the lane beside it. It shares its borders with what lies on either side, as far as that is
//! a lanelet, too: Autoware finds it from the lane over the common way only.

#[cfg(test)]
mod tests;

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{Road, RoadIx, RoadNetwork};
use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::builder::tags::side_strips::{StripRun, StripUse, strip_runs};
use crate::lanelet::{Attributes, Bound, LaneletId};
use crate::settings::{BesideSettings, BicycleLanes};

use super::lanelet_validity::is_valid;
use super::types::Lanes;

/// How fast one cycles, km/h.
const CYCLING: &str = "20";
/// How fast one drives onto what is meant for halting, or walks, km/h.
const CRAWLING: &str = "10";

/// Adds the lanelets beside the lanes of all roads; gives those for bicycles.
pub fn side_lanes(assembly: &mut MapBuilder, network: &RoadNetwork, lanes: &Lanes) -> Vec<LaneletId> {
    let mut bicycles = Vec::new();
    for (ix, road) in network.roads.iter().enumerate() {
        let ix = RoadIx::new(ix);
        let key = road.key_of("beside");
        let pieces = lanes.pieces_of(ix).iter();
        let pieces = pieces.map(|piece| (piece.behind.map_or(key, |cause| cause.of(key)), &piece.borders[..]));
        let pieces: Vec<(Key, &[Option<Bound>])> = pieces.collect();
        for run in strip_runs(&road.section) {
            for &(key, borders) in &pieces {
                for &backward in run.directions() {
                    let lanelet = lanelet(assembly, road, (key, borders), (&run, backward), &network.beside);
                    bicycles.extend(lanelet.filter(|_| run.used == StripUse::Bicycle));
                }
            }
        }
    }
    bicycles
}

/// Adds the lanelet of a run, unless the settings leave it out or there is no room for it.
fn lanelet(
    assembly: &mut MapBuilder,
    road: &Road,
    (key, borders): (Key, &[Option<Bound>]),
    (run, backward): (&StripRun, bool),
    settings: &BesideSettings,
) -> Option<LaneletId> {
    let parked = road.section.strips[run.strips.clone()].iter().any(|strip| strip.kind == StripKind::Parking);
    let wanted = match run.used {
        StripUse::Bicycle => settings.bicycle_lanes != BicycleLanes::None,
        StripUse::Shoulder => {
            if parked {
                settings.parking
            } else {
                settings.shoulders
            }
        }
        StripUse::Pedestrian => settings.pedestrian_lanes,
    };
    if !wanted {
        return None;
    }
    let [left, right] = bounds(assembly, road, borders, (run, backward))?;
    let key = key.number(run.strips.start as i64);
    let key = if backward && run.travel == Travel::Both { key.word("back") } else { key };
    let mut attributes = attributes(road, run, settings);
    attributes.push("road_id", crate::osm::Text::from(road.key.to_string()));
    Some(assembly.lanelet(key, left, right, attributes))
}

/// The bounds of the lanelet of a run that runs along the road's line or against it, in its direction; `None` if there is no
/// room for it.
pub fn bounds(
    assembly: &MapBuilder,
    road: &Road,
    borders: &[Option<Bound>],
    (run, backward): (&StripRun, bool),
) -> Option<[Bound; 2]> {
    let border = |edge: usize| borders.get(edge).copied().flatten();
    let (left, right) = (border(run.strips.start)?, border(run.strips.end)?);
    let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
    let bounds = if backward { [turned(right), turned(left)] } else { [left, right] };
    let width: f64 = road.section.strips[run.strips.clone()].iter().map(|strip| strip.width).sum();
    is_valid(&bounds.map(|bound| assembly.bound_line(bound)), width).then_some(bounds)
}

/// Tags of a lanelet beside the lanes. Its subtype says who may use it: Lanelet2 admits bicycles to a `bicycle_lane`, and
/// nobody to the others, over which no route leads.
pub fn attributes(road: &Road, run: &StripRun, settings: &BesideSettings) -> Attributes {
    let (subtype, speed) = match (run.used, settings.bicycle_lanes) {
        (StripUse::Bicycle, BicycleLanes::Road) => ("road", CYCLING),
        (StripUse::Bicycle, _) => ("bicycle_lane", CYCLING),
        (StripUse::Shoulder, _) => ("road_shoulder", CRAWLING),
        (StripUse::Pedestrian, _) => ("pedestrian_lane", CRAWLING),
    };
    let location = if road.public { "urban" } else { "private" };
    let mut tags =
        Attributes::of(&[("type", "lanelet"), ("subtype", subtype), ("location", location), ("one_way", "yes")]);
    tags.push("speed_limit", speed);
    tags
}
