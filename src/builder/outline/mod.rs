//! The outline of every intersection, and how far each road is cut back for it.
//!
//! The method is A/B Street's (Dustin Carlino, "Intersection geometry"): thicken each road, find where the edges of
//! any two roads that meet collide, trim each road back to its farthest collision along a perpendicular of its centre
//! line, and walk the trimmed ends and the collisions clockwise into one polygon.

mod collide;
mod general;
mod memory;
mod merged;
mod overlap;
mod terminus;
#[cfg(test)]
mod tests;
mod thicken;
pub mod trace;
mod trim;
mod walk;

use std::collections::BTreeSet;

use rayon::prelude::*;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::ring::faults;
use crate::geometry::{Point, Polyline};

use super::grid::snapped;
use super::road_network::{End, Intersection, Road, RoadEnd, RoadNetwork};

use general::Star;
pub use memory::Memory;
pub use merged::ribbon;
pub use overlap::{overlap, overlapping, overlaps};
use thicken::Arm;
pub use thicken::MITER_LIMIT;
use walk::Corner;

/// Which method made an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Case {
    /// The extract ends here.
    MapEdge,
    /// One road ends.
    DeadEnd,
    /// Two roads continue each other, perhaps with another width.
    Degenerate,
    /// Nearly parallel roads part or join.
    Ramp,
    /// Every other star of roads.
    General,
    /// Several nodes became one intersection.
    Merged,
    /// The method failed; a simple shape stands in.
    Fallback,
}

/// Where a road is cut at an intersection, seen by someone who looks from the road into the intersection.
#[derive(Clone, Debug, PartialEq)]
pub struct Cut {
    /// The road and which of its ends.
    pub at: RoadEnd,
    /// Left end of the cut.
    pub left: Point,
    /// Right end of the cut.
    pub right: Point,
}

/// The outline of one intersection.
#[derive(Clone, Debug)]
pub struct Outline {
    /// How it was made.
    pub case: Case,
    /// The cuts in clockwise order, the order of the intersection's arms.
    pub cuts: Vec<Cut>,
    /// `corners[i]` runs clockwise from the left end of `cuts[i]` to the right end of the next cut, both included: the
    /// kerb between two roads.
    pub corners: Vec<Vec<Point>>,
    /// The whole ring, clockwise, not closed: each cut from right to left, then the corner to the next cut. Empty at
    /// the edge of the map, where nothing is cut off.
    pub ring: Vec<Point>,
}

/// Outlines and cuts of a whole network.
#[derive(Clone, Debug)]
pub struct Outlines {
    /// Per road: the stations of its line between which it remains, start and end.
    pub kept: Vec<[f64; 2]>,
    /// Per intersection.
    pub intersections: Vec<Outline>,
}

/// Sizes that shape the outlines, metres.
#[derive(Clone, Debug)]
pub struct OutlineOptions {
    /// Radius of the kerb between two roads that meet at a right angle.
    pub kerb_radius: f64,
    /// The same where a service road or a track takes part.
    pub kerb_radius_minor: f64,
    /// A kerb's curve begins at most so far from the collision of the two edges.
    pub kerb_reach: f64,
    /// Roads that part at a small angle are cut back at most so many times the wider one's width: the rest of their
    /// overlap is no part of the intersection.
    pub reach: f64,
    /// Distance between a cut and the collision that decided it, so that corners never fall together.
    pub margin: f64,
    /// Every road is cut back at least so far where it meets another.
    pub least_trim: f64,
    /// What remains of a road at least, where it is long enough.
    pub least_road: f64,
}

impl Default for OutlineOptions {
    fn default() -> Self {
        Self {
            kerb_radius: 4.0,
            kerb_radius_minor: 2.5,
            kerb_reach: 4.0,
            reach: 2.0,
            margin: 0.2,
            least_trim: 0.5,
            least_road: 1.5,
        }
    }
}

/// The stations between which each road remains at the most: after what its ends must have, without the room that
/// kerbs would like. Consolidation decides by them. The first is beyond the second where the road lies inside what
/// its ends need.
pub fn remaining(network: &RoadNetwork, options: &OutlineOptions, memory: &mut Memory) -> Vec<[f64; 2]> {
    let trims = memory.trims(network, options);
    stations(network, network.intersections.iter().zip(&trims).map(|(at, t)| (&at.arms[..], &t.least[..])))
}

/// The stations between which each road remains if its ends get all they would like, kerbs included.
pub fn wanted(network: &RoadNetwork, options: &OutlineOptions, memory: &mut Memory) -> Vec<[f64; 2]> {
    let trims = memory.trims(network, options);
    stations(network, network.intersections.iter().zip(&trims).map(|(at, t)| (&at.arms[..], &t.wanted[..])))
}

/// The outline of every intersection of the network, with a finding for each that could not be made as it should.
pub fn outlines(network: &RoadNetwork, options: &OutlineOptions) -> (Outlines, Vec<Finding>) {
    outlines_within(network, &uncut(network), options)
}

/// As [`outlines`], with every road cut back at least to the stations in `within`.
pub fn outlines_within(
    network: &RoadNetwork,
    within: &[[f64; 2]],
    options: &OutlineOptions,
) -> (Outlines, Vec<Finding>) {
    let plans = plans(network, within, options);
    let arms = || network.intersections.iter().map(|at| &at.arms[..]);
    let mut least = stations(network, arms().zip(plans.iter().map(|plan| &plan.star.least[..])));
    let mut wanted = stations(network, arms().zip(plans.iter().map(|plan| &plan.star.trims[..])));
    let mut kept: Vec<[f64; 2]> = network
        .roads
        .par_iter()
        .zip(least.par_iter().zip(&wanted))
        .map(|(road, (least, wanted))| kept_of(road, *least, *wanted, options))
        .collect();
    let mut closed: Vec<Option<Outline>> = vec![None; plans.len()];
    for _ in 0..WIDENINGS {
        let mut changed: BTreeSet<usize> = BTreeSet::new();
        closed.par_iter_mut().zip(&plans).zip(&network.intersections).for_each(|((outline, plan), intersection)| {
            if outline.is_none() {
                *outline = close(network, intersection, plan, &kept, options);
            }
        });
        for ((outline, plan), intersection) in closed.iter().zip(&plans).zip(&network.intersections) {
            if outline.is_none() {
                changed.extend(widen(network, intersection, plan, &kept, [&mut least, &mut wanted], options));
            }
        }
        for &road in &changed {
            let before = kept[road];
            let Road { from, to, .. } = network.roads[road];
            kept[road] = kept_of(&network.roads[road], least[road], wanted[road], options);
            if kept[road][0] != before[0] {
                closed[from.0 as usize] = None;
            }
            if kept[road][1] != before[1] {
                closed[to.0 as usize] = None;
            }
        }
        if changed.is_empty() {
            break;
        }
    }
    let finish = |((outline, plan), intersection): ((Option<Outline>, Plan), &Intersection)| match outline
        .or_else(|| close(network, intersection, &plan, &kept, options))
    {
        Some(outline) => (outline, None),
        None => (fallback(cuts(&plan, &ends(&plan, &kept).0)), Some(failure(network, intersection))),
    };
    let finished = closed.into_par_iter().zip(plans).zip(&network.intersections).map(finish);
    let (intersections, findings): (Vec<Outline>, Vec<Option<Finding>>) = finished.unzip();
    (Outlines { kept, intersections }, findings.into_iter().flatten().collect())
}

/// Edges that meet at less than this, degrees, lie on each other where coordinates are rounded.
const FOLD: f64 = 1.0;

/// Cuts closer together than this, metres, are the same but for rounding.
const SAME: f64 = 1e-9;

/// Where an outline does not close, cuts are moved outwards so often,
const WIDENINGS: usize = 12;
/// by so many metres at a time.
const WIDENING: f64 = 1.0;

/// Cuts those arms back further whose cuts other roads cover. Returns the roads that changed.
fn widen(
    network: &RoadNetwork,
    intersection: &Intersection,
    plan: &Plan,
    kept: &[[f64; 2]],
    stations: [&mut Vec<[f64; 2]>; 2],
    options: &OutlineOptions,
) -> Vec<usize> {
    let (trims, _) = ends(plan, kept);
    let hidden = merged::hidden(&plan.arms, &trims, &cuts(plan, &trims), &ground(network, intersection, plan));
    let [least, wanted] = stations;
    let mut changed = Vec::new();
    for arm in hidden.into_iter().map(|i| &plan.arms[i]) {
        let road = arm.at.road.0 as usize;
        let left = kept[road][1] - kept[road][0];
        if left < 2.0 * WIDENING + options.least_road {
            continue;
        }
        let end = usize::from(arm.at.end == End::End);
        let moved = kept[road][end] + if end == 0 { WIDENING } else { -WIDENING };
        // The other end keeps its cut.
        least[road] = kept[road];
        least[road][end] = moved;
        wanted[road] = least[road];
        changed.push(road);
    }
    changed
}

/// The station of each arm's cut, and that of the cut at its other end, seen from the intersection outwards.
fn ends(plan: &Plan, kept: &[[f64; 2]]) -> (Vec<f64>, Vec<f64>) {
    let seen = |arm: &Arm| {
        let [from, to] = kept[arm.at.road.0 as usize];
        match arm.at.end {
            End::Start => (from, to),
            End::End => (arm.length - to, arm.length - from),
        }
    };
    plan.arms.iter().map(seen).unzip()
}

fn cuts(plan: &Plan, trims: &[f64]) -> Vec<Cut> {
    plan.arms.iter().zip(trims).map(|(arm, trim)| walk::cut(arm, *trim)).collect()
}

fn ground(network: &RoadNetwork, intersection: &Intersection, plan: &Plan) -> Vec<Vec<Point>> {
    match plan.ground.is_empty() {
        true => merged::ground(network, intersection, &plan.arms),
        false => plan.ground.clone(),
    }
}

/// The whole of every road.
fn uncut(network: &RoadNetwork) -> Vec<[f64; 2]> {
    network.roads.iter().map(|road| [0.0, road.line.length()]).collect()
}

fn plans(network: &RoadNetwork, within: &[[f64; 2]], options: &OutlineOptions) -> Vec<Plan> {
    network.intersections.par_iter().map(|intersection| plan(network, intersection, within, options)).collect()
}

/// Per road the stations between which it remains if each end is trimmed as its star says.
fn stations<'a>(network: &RoadNetwork, stars: impl Iterator<Item = (&'a [RoadEnd], &'a [f64])>) -> Vec<[f64; 2]> {
    let mut stations = uncut(network);
    for (arms, trims) in stars {
        for (arm, trim) in arms.iter().zip(trims) {
            let [from, to] = &mut stations[arm.road.0 as usize];
            match arm.end {
                End::Start => *from = *trim,
                End::End => *to -= *trim,
            }
        }
    }
    stations
}

/// What is left of a road between its cuts, which lie clear of its bends.
fn kept_of(road: &Road, least: [f64; 2], wanted: [f64; 2], options: &OutlineOptions) -> [f64; 2] {
    let (length, half) = (road.line.length(), road.half_width());
    let trims = |[from, to]: [f64; 2]| [from, length - to];
    let [from, to] = trim::share(length, trims(least), trims(wanted), options.least_road);
    let clear = |line: &Polyline, trim: f64| if trim > 0.0 { trim::clear_of_bends(line, trim, half) } else { trim };
    let moved = [clear(&road.line, from), length - clear(&road.line.reversed(), length - to)];
    if moved[0] < moved[1] { moved } else { [from, to] }
}

/// What is to be done at one intersection before the roads' other ends are known.
struct Plan {
    case: Case,
    arms: Vec<Arm>,
    star: Star,
    /// The ground inside, where several nodes were merged.
    ground: Vec<Vec<Point>>,
    /// The outline if the star is trimmed as it would like to be.
    outline: Option<Outline>,
}

impl Plan {
    fn new(case: Case, arms: Vec<Arm>, star: Star) -> Self {
        Self { case, arms, star, ground: Vec::new(), outline: None }
    }
}

fn plan(network: &RoadNetwork, intersection: &Intersection, within: &[[f64; 2]], options: &OutlineOptions) -> Plan {
    let arms: Vec<Arm> = intersection.arms.iter().map(|at| Arm::new(network, *at, options)).collect();
    match arms.as_slice() {
        [_] if intersection.map_edge => Plan::new(Case::MapEdge, arms, Star::terminus(0.0)),
        [arm] => {
            let star = Star::terminus(terminus::dead_end(arm, options));
            Plan::new(Case::DeadEnd, arms, star)
        }
        _ => {
            let mut star = general::star(&arms, options);
            for (i, arm) in arms.iter().enumerate() {
                let [from, to] = within[arm.at.road.0 as usize];
                let floor = if arm.at.end == End::Start { from } else { arm.length - to };
                star.trims[i] = star.trims[i].max(floor);
            }
            let merged = !intersection.inner.is_empty();
            let case = match arms.len() {
                _ if merged => Case::Merged,
                2 => Case::Degenerate,
                _ if star.wedge => Case::Ramp,
                _ => Case::General,
            };
            let mut plan = Plan::new(case, arms, star);
            if !merged {
                plan.outline = outline(&plan, &plan.star.trims);
            }
            if plan.outline.is_none() {
                plan.ground = merged::ground(network, intersection, &plan.arms);
                plan.star.least = merged::trims(&plan.arms, &plan.ground, &plan.star.least, options);
                plan.star.trims = merged::trims(&plan.arms, &plan.ground, &plan.star.trims, options);
            }
            plan
        }
    }
}

/// The outline of the general method; `None` if it is no simple polygon.
fn outline(plan: &Plan, trims: &[f64]) -> Option<Outline> {
    let cuts = cuts(plan, trims);
    let (corners, ring) = [true, false].into_iter().find_map(|rounded| {
        let corners = corners(plan, trims, &cuts, rounded);
        let ring = walk::ring(&cuts, &corners);
        is_sound(&ring).then_some((corners, ring))
    })?;
    Some(Outline { case: plan.case, cuts, corners, ring })
}

/// Closes the ring with the cuts as they came out; `None` if no simple ring goes through them.
fn close(
    network: &RoadNetwork,
    intersection: &Intersection,
    plan: &Plan,
    kept: &[[f64; 2]],
    options: &OutlineOptions,
) -> Option<Outline> {
    let (trims, far) = ends(plan, kept);
    if matches!(plan.case, Case::MapEdge) || trims.is_empty() {
        let cuts = cuts(plan, &trims);
        return Some(Outline { case: plan.case, corners: vec![Vec::new(); cuts.len()], cuts, ring: Vec::new() });
    }
    let as_planned = trims.iter().zip(&plan.star.trims).all(|(trim, planned)| (trim - planned).abs() < SAME);
    if let (true, Some(outline)) = (as_planned, &plan.outline) {
        return Some(outline.clone());
    }
    let general = || outline(plan, &trims);
    let around = || around_union(network, intersection, plan, [&trims, &far], options);
    // Roads that cover a cut of another keep the boundary from closing; the star's own corners still may.
    if plan.ground.is_empty() { general().or_else(around) } else { around().or_else(general) }
}

/// Whether the ring is simple where it will be written, on the grid, and stays so when others round it again.
fn is_sound(ring: &[Point]) -> bool {
    let ring: Vec<Point> = ring.iter().copied().map(snapped).collect();
    let distinct = ring.iter().zip(ring.iter().cycle().skip(1)).all(|(a, b)| a != b);
    distinct && faults(&ring, FOLD, 1).is_empty()
}

/// The outline around the union of what the roads cover.
fn around_union(
    network: &RoadNetwork,
    intersection: &Intersection,
    plan: &Plan,
    [trims, far]: [&[f64]; 2],
    options: &OutlineOptions,
) -> Option<Outline> {
    let (cuts, ground) = (cuts(plan, trims), ground(network, intersection, plan));
    let sharp = merged::corners(&plan.arms, trims, far, &cuts, &ground)?;
    let round = sharp.iter().map(|chain| merged::rounded(chain, options.kerb_reach)).collect();
    [round, sharp].into_iter().find_map(|corners: Vec<Vec<Point>>| {
        let ring = walk::ring(&cuts, &corners);
        is_sound(&ring).then(|| Outline { case: plan.case, cuts: cuts.clone(), corners, ring })
    })
}

fn corners(plan: &Plan, trims: &[f64], cuts: &[Cut], rounded: bool) -> Vec<Vec<Point>> {
    let n = plan.arms.len();
    (0..n)
        .map(|i| {
            let next = (i + 1) % n;
            let (a, b) = (&plan.arms[i], &plan.arms[next]);
            let ends = [cuts[i].left, cuts[next].right];
            match fitted(a, b, ends, plan.star.corners[i], rounded) {
                Some(corner) => walk::corner(a, b, [trims[i], trims[next]], ends, corner),
                None => ends.to_vec(),
            }
        })
        .collect()
}

/// The corner with a curve that begins before the cuts; `None` if the collision itself lies beyond a cut.
fn fitted(a: &Arm, b: &Arm, ends: [Point; 2], corner: Corner, rounded: bool) -> Option<Corner> {
    let Corner::Collision { point, along, tangent } = corner else { return Some(corner) };
    let room_a = a.right.project(ends[0]).station - along[0];
    let room_b = b.left.project(ends[1]).station - along[1];
    let room = room_a.min(room_b);
    let tangent = if rounded { tangent.min(room) } else { 0.0 };
    (room >= 0.0).then_some(Corner::Collision { point, along, tangent })
}

/// A shape for the intersection whose own could not be made: the convex hull of its cuts.
fn fallback(cuts: Vec<Cut>) -> Outline {
    let corners = (0..cuts.len()).map(|i| vec![cuts[i].left, cuts[(i + 1) % cuts.len()].right]).collect();
    let ring = crate::geometry::polygon::convex_hull(cuts.iter().flat_map(|cut| [cut.left, cut.right]));
    Outline { case: Case::Fallback, cuts, corners, ring }
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
