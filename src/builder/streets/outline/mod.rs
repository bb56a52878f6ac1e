//! The outline of every intersection, and how far each road is cut back for it.
//!
//! The method is A/B Street's (Dustin Carlino, "Intersection geometry"): thicken each road, find where the edges of
//! any two roads that meet collide, trim each road back to its farthest collision along a perpendicular of its centre
//! line, and walk the trimmed ends and the collisions clockwise into one polygon.

mod collide;
pub mod debug_steps;
mod general;
mod intersection_plan;
mod merged;
mod overlap;
mod plan_cache;
mod ring;
mod terminus;
#[cfg(test)]
mod tests;
mod thicken;
mod trim;
mod types;

pub use types::{Outline, OutlineCase, OutlineCut, OutlineOptions, Outlines};

use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Polyline;
use crate::parallel::Finely;

use intersection_plan::IntersectionSite;

use std::collections::BTreeSet;

use rayon::prelude::*;

pub use merged::ribbon;
pub use overlap::{overlap, overlapping, overlaps};
pub use plan_cache::PlanCache;
pub use thicken::MITER_LIMIT;

/// The stations between which each road remains at the most: after what its ends must have, without the room that
/// kerbs would like. Consolidation decides by them. The first is beyond the second where the road lies inside what
/// its ends need.
pub fn remaining(network: &RoadNetwork, options: &OutlineOptions, memory: &mut PlanCache) -> Vec<[f64; 2]> {
    let plans = memory.plans(network, options);
    stations(network, network.intersections.iter().zip(plans).map(|(at, plan)| (&at.arms[..], &plan.star.least[..])))
}

/// The stations between which each road remains if its ends get all they would like, kerbs included.
pub fn wanted(network: &RoadNetwork, options: &OutlineOptions, memory: &mut PlanCache) -> Vec<[f64; 2]> {
    let plans = memory.plans(network, options);
    stations(network, network.intersections.iter().zip(plans).map(|(at, plan)| (&at.arms[..], &plan.star.trims[..])))
}

/// The outline of every intersection of the network, with a finding for each that could not be made as it should.
pub fn outlines(network: &RoadNetwork, options: &OutlineOptions) -> (Outlines, Vec<Finding>) {
    outlines_within(network, &uncut(network), options, &PlanCache::default())
}

/// As [`outlines`], with every road cut back at least to the stations in `within`, and with what is known of intersections whose
/// arms have kept their shape.
pub fn outlines_within(
    network: &RoadNetwork,
    within: &[Stations],
    options: &OutlineOptions,
    memory: &PlanCache,
) -> (Outlines, Vec<Finding>) {
    let sites = memory.sites(network, within, options);
    let arms = || network.intersections.iter().map(|at| &at.arms[..]);
    let mut least = stations(network, arms().zip(sites.iter().map(|site| &site.plan.star.least[..])));
    let mut wanted = stations(network, arms().zip(sites.iter().map(|site| &site.plan.star.trims[..])));
    let mut kept: Vec<Stations> = network
        .roads
        .par_iter()
        .finely()
        .zip(least.par_iter().finely().zip(&wanted))
        .map(|(road, (least, wanted))| kept_of(road, *least, *wanted, options))
        .collect();
    let mut closed: Vec<Option<Outline>> = vec![None; sites.len()];
    for _ in 0..WIDENINGS {
        closed.par_iter_mut().finely().zip(&sites).filter(|(outline, _)| outline.is_none()).for_each(
            |(outline, site)| {
                *outline = site.close(&kept);
            },
        );
        let mut changed: BTreeSet<usize> = BTreeSet::new();
        for (_, site) in closed.iter().zip(&sites).filter(|(outline, _)| outline.is_none()) {
            changed.extend(widen(site, &kept, [&mut least, &mut wanted], options));
        }
        for &road in &changed {
            let before = kept[road];
            let Road { from, to, .. } = network.roads[road];
            kept[road] = kept_of(&network.roads[road], least[road], wanted[road], options);
            if kept[road][0] != before[0] {
                closed[from] = None;
            }
            if kept[road][1] != before[1] {
                closed[to] = None;
            }
        }
        if changed.is_empty() {
            break;
        }
    }
    let finish = |(outline, site): (Option<Outline>, IntersectionSite)| match outline.or_else(|| site.close(&kept)) {
        Some(outline) => (outline, None),
        None => (site.fallback(&kept), Some(failure(network, site.intersection))),
    };
    let finished = closed.into_par_iter().finely().zip(sites).map(finish);
    let (intersections, findings): (Vec<Outline>, Vec<Option<Finding>>) = finished.unzip();
    (Outlines { kept, intersections }, findings.into_iter().flatten().collect())
}

/// Where an outline does not close, cuts are moved outwards so often,
const WIDENINGS: usize = 12;
/// by so many metres at a time.
const WIDENING: f64 = 1.0;

/// Cuts those arms back further whose cuts other roads cover. Returns the roads that changed.
fn widen(
    site: &IntersectionSite,
    kept: &[Stations],
    stations: [&mut Vec<[f64; 2]>; 2],
    options: &OutlineOptions,
) -> Vec<usize> {
    let [least, wanted] = stations;
    let mut changed = Vec::new();
    for at in site.hidden(kept).map(|arm| arm.at) {
        let road = at.road.position();
        let left = kept[road][1] - kept[road][0];
        if left < 2.0 * WIDENING + options.least_road {
            continue;
        }
        let end = usize::from(at.end == End::End);
        let moved = kept[road][end] + if end == 0 { WIDENING } else { -WIDENING };
        // The other end keeps its cut.
        least[road] = kept[road];
        least[road][end] = moved;
        wanted[road] = least[road];
        changed.push(road);
    }
    changed
}

/// The whole of every road.
fn uncut(network: &RoadNetwork) -> Vec<[f64; 2]> {
    network.roads.par_iter().finely().map(|road| [0.0, road.line.length()]).collect()
}

/// Per road the stations between which it remains if each end is trimmed as its star says.
fn stations<'a>(network: &RoadNetwork, stars: impl Iterator<Item = (&'a [RoadEnd], &'a [f64])>) -> Vec<[f64; 2]> {
    let mut stations = uncut(network);
    for (arms, trims) in stars {
        for (arm, trim) in arms.iter().zip(trims) {
            let [from, to] = &mut stations[arm.road];
            match arm.end {
                End::Start => *from = *trim,
                End::End => *to -= *trim,
            }
        }
    }
    stations
}

/// What is left of a road between its cuts, which lie clear of its bends.
fn kept_of(road: &Road, least: Stations, wanted: [f64; 2], options: &OutlineOptions) -> [f64; 2] {
    let (length, half) = (road.line.length(), road.half_width());
    let trims = |[from, to]: [f64; 2]| [from, length - to];
    let [from, to] = trim::share(length, trims(least), trims(wanted), options.least_road);
    let clear = |line: &Polyline, trim: f64| if trim > 0.0 { trim::clear_of_bends(line, trim, half) } else { trim };
    let moved = [clear(&road.line, from), length - clear(&road.line.reversed(), length - to)];
    if moved[0] < moved[1] { moved } else { [from, to] }
}

fn failure(network: &RoadNetwork, intersection: &Intersection) -> Finding {
    let node = intersection.nodes.first().copied().unwrap_or_default();
    let mut finding = Finding::new(
        "outline-fallback",
        Subject::Node(node),
        format!("no simple outline fits the {} roads that meet at node {node}", intersection.arms.len()),
    )
    .at(Place::Point(intersection.position))
    .graded(Severity::Warning);
    for arm in &intersection.arms {
        finding = finding.with(Subject::Way(network.road(arm.road).key.way), "road");
    }
    finding
}
