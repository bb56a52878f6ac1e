//! The outline of every intersection, and how far each road is cut back for it.
//!
//! The method is A/B Street's (Dustin Carlino, "Intersection geometry"): thicken each road, find where the edges of any two
//! roads collide, trim each road back to its farthest collision perpendicular to its centre line, and join the trimmed ends
//! and the collisions clockwise into one polygon.

mod collide;
pub mod debug_steps;
mod general_outline;
mod intersection_plan;
mod merged_outline;
mod overlap;
mod plan_cache;
mod ring;
mod sizes;
mod terminus;
#[cfg(test)]
mod tests;
mod thicken;
mod trim;
mod types;

pub use types::{Outline, OutlineCase, OutlineCut, Outlines};

use crate::builder::network::road_end::{is_between_crossings, outward};
use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Polyline;
use crate::parallel::InSmallParts;

use intersection_plan::IntersectionSite;
pub use sizes::LEAST_ROAD;
use sizes::LEAST_ROAD_BETWEEN;

use std::collections::BTreeSet;

use rayon::prelude::*;

pub use merged_outline::ribbon;
pub use overlap::{overlap, overlapping, resolve_overlaps};
pub use plan_cache::PlanCache;
pub use thicken::MITER_LIMIT;

/// The stations between which each road remains, metres, if its ends get the trims that they need, without the room for kerbs.
/// Consolidation decides by them. The first is larger than the second if nothing remains.
pub fn remaining(network: &RoadNetwork, cache: &mut PlanCache) -> Vec<Stations> {
    let plans = cache.plans(network);
    stations(network, network.intersections.iter().zip(plans).map(|(i, plan)| (&i.arms[..], &plan.star.least[..])))
}

/// The stations between which each road remains, metres, if its ends get all the trim that they want, kerbs included.
pub fn wanted(network: &RoadNetwork, cache: &mut PlanCache) -> Vec<Stations> {
    let plans = cache.plans(network);
    stations(network, network.intersections.iter().zip(plans).map(|(i, plan)| (&i.arms[..], &plan.star.trims[..])))
}

/// The outline of every intersection, with a finding for each that needs the fallback.
pub fn outlines(network: &RoadNetwork) -> (Outlines, Vec<Finding>) {
    outlines_within(network, &uncut(network), &PlanCache::default())
}

/// As [`outlines`], with every road cut back at least to its stations in `within`, and with cached plans.
pub fn outlines_within(network: &RoadNetwork, within: &[Stations], cache: &PlanCache) -> (Outlines, Vec<Finding>) {
    let sites = cache.sites(network, within);
    let mut cuts = Cuts::new(network, &sites);
    let mut closed: Vec<Option<Outline>> = vec![None; sites.len()];
    for _ in 0..WIDENINGS {
        let open = closed.par_iter_mut().in_small_parts().zip(&sites).filter(|(outline, _)| outline.is_none());
        open.for_each(|(outline, site)| *outline = site.close(&cuts.kept));
        let open = sites.iter().zip(&closed).filter(|(_, outline)| outline.is_none());
        let changed: BTreeSet<RoadIx> = open.flat_map(|(site, _)| cuts.widen(site)).collect();
        for road in &changed {
            cuts.update(*road).into_iter().for_each(|ix| closed[ix] = None);
        }
        if changed.is_empty() {
            break;
        }
    }
    let kept = cuts.kept;
    let finish = |(outline, site): (Option<Outline>, IntersectionSite)| match outline.or_else(|| site.close(&kept)) {
        Some(outline) => (outline, None),
        None => (site.fallback(&kept), Some(failure(network, site.intersection))),
    };
    let finished = closed.into_par_iter().in_small_parts().zip(sites).map(finish);
    let (intersections, findings): (Vec<Outline>, Vec<Option<Finding>>) = finished.unzip();
    (Outlines { kept, intersections }, findings.into_iter().flatten().collect())
}

/// The largest number of rounds in which cuts are moved outwards because an outline does not close.
const WIDENINGS: usize = 12;
/// How far they are moved in one round, metres.
const WIDENING: f64 = 1.0;
/// Roads cross where the sine of the angle between them is larger than this: 30 degrees, ...
const CROSSES: f64 = 0.5;
/// ... at this distance from the intersection, metres.
const LOOK: f64 = 10.0;

/// The cuts of all roads while the outlines close; per road the stations between which it remains.
struct Cuts<'a> {
    network: &'a RoadNetwork,
    /// With the trims that the ends need.
    least: Vec<Stations>,
    /// With the trims that they want.
    wanted: Vec<Stations>,
    /// With the trims that they get.
    kept: Vec<Stations>,
}

impl<'a> Cuts<'a> {
    fn new(network: &'a RoadNetwork, sites: &[IntersectionSite]) -> Self {
        let arms = || network.intersections.iter().map(|i| &i.arms[..]);
        let least = stations(network, arms().zip(sites.iter().map(|site| &site.plan.star.least[..])));
        let wanted = stations(network, arms().zip(sites.iter().map(|site| &site.plan.star.trims[..])));
        let mut cuts = Self { network, least, wanted, kept: Vec::new() };
        cuts.kept =
            (0..network.roads.len()).into_par_iter().in_small_parts().map(|i| cuts.kept_of(RoadIx::new(i))).collect();
        cuts
    }

    /// Asks to cut those arms back further whose cuts other roads cover. Returns their roads.
    fn widen(&mut self, site: &IntersectionSite) -> Vec<RoadIx> {
        let mut changed = Vec::new();
        for RoadEnd { road, end } in site.covered_arms(&self.kept) {
            let mut stations = self.kept[road];
            if stations[1] - stations[0] < 2.0 * WIDENING + LEAST_ROAD {
                continue;
            }
            // The other end keeps its cut.
            stations[end] += if end == End::Start { WIDENING } else { -WIDENING };
            (self.least[road], self.wanted[road]) = (stations, stations);
            changed.push(road);
        }
        changed
    }

    /// Cuts a road anew. Returns the intersections at which its cut moves.
    fn update(&mut self, road: RoadIx) -> Vec<IntersectionIx> {
        let before = self.kept[road];
        self.kept[road] = self.kept_of(road);
        let moved = End::BOTH.into_iter().filter(|end| self.kept[road][*end] != before[*end]);
        moved.map(|end| self.network.road(road).intersection(end)).collect()
    }

    /// Whether another road leads away from the end of a road at an angle: else the roads part or join there, as at the nose of an island.
    fn is_crossed(&self, ix: RoadIx, end: End) -> bool {
        let leaving = |at: RoadEnd| outward(self.network.road(at.road), at.end, LOOK).normalize();
        let own = leaving(RoadEnd { road: ix, end });
        let arms = &self.network.intersection(self.network.road(ix).intersection(end)).arms;
        arms.iter().any(|arm| leaving(*arm).perp(&own).abs() > CROSSES)
    }

    /// The stations between which a road remains, with its cuts clear of bends.
    fn kept_of(&self, ix: RoadIx) -> Stations {
        let road = self.network.road(ix);
        let (length, half) = (road.line.length(), road.half_width());
        let trims = |[from, to]: Stations| [from, length - to];
        let least = trims(self.least[ix]);
        let between =
            if is_between_crossings(self.network, road) && End::BOTH.iter().all(|end| self.is_crossed(ix, *end)) {
                LEAST_ROAD_BETWEEN
            } else {
                LEAST_ROAD
            };
        let remains = (length - least[0] - least[1]).clamp(LEAST_ROAD, between);
        let [from, to] = trim::share(length, least, trims(self.wanted[ix]), remains);
        let clear = |line: &Polyline, trim: f64| if trim > 0.0 { trim::clear_of_bends(line, trim, half) } else { trim };
        let moved = [clear(&road.line, from), length - clear(&road.line.reversed(), length - to)];
        if moved[0] < moved[1] { moved } else { [from, to] }
    }
}

/// The first and last station of every road.
fn uncut(network: &RoadNetwork) -> Vec<Stations> {
    network.roads.par_iter().in_small_parts().map(|road| [0.0, road.line.length()]).collect()
}

/// The stations between which each road remains if its ends get these trims, metres, by the arms of each intersection.
fn stations<'a>(network: &RoadNetwork, stars: impl Iterator<Item = (&'a [RoadEnd], &'a [f64])>) -> Vec<Stations> {
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

fn failure(network: &RoadNetwork, intersection: &Intersection) -> Finding {
    let node = intersection.first_node();
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
