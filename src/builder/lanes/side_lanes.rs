//! Side lanes: lanelets beside the lanes for cars, for bicycles, vehicles that halt or park, and people on foot.
//!
//! Adjacent strips of one use are one lanelet, or two on top of each other where bicycles ride both ways. A side lane shares its
//! borders with its neighbours: Autoware finds it from the lane by their common line only.

#[cfg(test)]
mod tests;

use std::cell::OnceCell;

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{Road, RoadIx, RoadNetwork};
use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::builder::tags::side_strips::{StripRun, StripUse, strip_runs};
use crate::geometry::Point;
use crate::lanelet::{Attributes, Bound, LaneletId};
use crate::settings::{BesideSettings, BicycleLanes};

use super::driven_borders::DrivenBorders;
use super::lanelet_validity::is_valid;
use super::road_lanes::directed;
use super::types::{Lanes, RoadPiece};

/// Speed limit of bicycle lanes, km/h.
const CYCLING: &str = "20";
/// Speed limit of shoulders and pedestrian lanes, km/h.
const CRAWLING: &str = "10";

/// Adds the side lanes of all roads; gives those for bicycles. `turning` gives the bounds of the lanelets in intersections.
pub fn side_lanes(
    assembly: &mut MapBuilder,
    network: &RoadNetwork,
    lanes: &Lanes,
    turning: impl Fn(&MapBuilder) -> Vec<Vec<Point>>,
) -> Vec<LaneletId> {
    let mut bicycles = Vec::new();
    // Most maps have no shoulders.
    let driven: OnceCell<DrivenBorders> = OnceCell::new();
    for (i, road) in network.roads.iter().enumerate() {
        let runs = strip_runs(&road.section);
        for run in runs.iter().filter(|run| is_drawn(road, run, &network.beside)) {
            for piece in lanes.pieces_of(RoadIx::new(i)) {
                let others = || driven.get_or_init(|| DrivenBorders::new(assembly, lanes, turning(assembly)));
                if run.used == StripUse::Shoulder && is_on_other_road(assembly, RoadIx::new(i), piece, run, others()) {
                    continue;
                }
                for &backward in run.directions() {
                    let lanelet = lanelet(assembly, road, piece, (run, backward), &network.beside);
                    bicycles.extend(lanelet.filter(|_| run.used == StripUse::Bicycle));
                }
            }
        }
    }
    bicycles
}

/// Whether the settings ask for the lanelets of a run.
fn is_drawn(road: &Road, run: &StripRun, settings: &BesideSettings) -> bool {
    let parked = || road.section.strips[run.strips.clone()].iter().any(|strip| strip.kind == StripKind::Parking);
    match run.used {
        StripUse::Bicycle => settings.bicycle_lanes != BicycleLanes::None,
        StripUse::Shoulder if parked() => settings.parking,
        StripUse::Shoulder => settings.shoulders,
        StripUse::Pedestrian => settings.pedestrian_lanes,
    }
}

/// Whether a side of a run lies along the border of a lane of another road: nobody halts there.
fn is_on_other_road(
    assembly: &MapBuilder,
    road: RoadIx,
    piece: &RoadPiece,
    run: &StripRun,
    others: &DrivenBorders,
) -> bool {
    let sides = [run.strips.start, run.strips.end].into_iter().filter_map(|edge| *piece.borders.get(edge)?);
    sides.into_iter().any(|side| others.run_along(road, &assembly.bound_line(side)))
}

/// Adds the lanelet of a run, unless there is no room for it.
fn lanelet(
    assembly: &mut MapBuilder,
    road: &Road,
    piece: &RoadPiece,
    (run, backward): (&StripRun, bool),
    settings: &BesideSettings,
) -> Option<LaneletId> {
    let [left, right] = bounds(assembly, road, &piece.borders, (run, backward))?;
    let key = road.key_of("beside");
    let key = piece.behind.map_or(key, |reason| reason.of(key)).number(run.strips.start as i64);
    let key = if backward && run.travel == Travel::Both { key.word("back") } else { key };
    let mut attributes = attributes(road, run, settings);
    attributes.push("road_id", crate::osm::Text::from(road.key.to_string()));
    Some(assembly.lanelet(key, left, right, attributes))
}

/// The bounds of the lanelet of a run along the road's line or against it, in its direction of travel; `None` if there is no
/// room for it.
pub fn bounds(
    assembly: &MapBuilder,
    road: &Road,
    borders: &[Option<Bound>],
    (run, backward): (&StripRun, bool),
) -> Option<[Bound; 2]> {
    let border = |edge: usize| borders.get(edge).copied().flatten();
    let bounds = directed([border(run.strips.start)?, border(run.strips.end)?], backward);
    let width: f64 = road.section.strips[run.strips.clone()].iter().map(|strip| strip.width).sum();
    is_valid(&bounds.map(|bound| assembly.bound_line(bound)), width).then_some(bounds)
}

/// Tags of a side lane. Lanelet2 admits bicycles to the subtype `bicycle_lane`; no route leads over the others.
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
