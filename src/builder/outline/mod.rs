//! The outline of every intersection, and how far each road is cut back for it.
//!
//! The method is A/B Street's (Dustin Carlino, "Intersection geometry"): thicken each road, find where the edges of
//! any two roads that meet collide, trim each road back to its farthest collision along a perpendicular of its centre
//! line, and walk the trimmed ends and the collisions clockwise into one polygon.

mod collide;
mod general;
mod merged;
mod terminus;
#[cfg(test)]
mod tests;
mod thicken;
mod trim;
mod walk;

use crate::diagnostic::{Finding, Place, Severity, Subject};
use crate::geometry::Point;

use super::road_network::{End, Intersection, RoadEnd, RoadNetwork};

use general::Star;
use merged::Ground;
pub use thicken::MITER_LIMIT;
use thicken::{Arm, Side};
use walk::Corner;

/// Which method made an outline.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
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
    /// A kerb's curve begins at most so far from the collision of the two edges.
    pub kerb_reach: f64,
    /// Distance between a cut and the collision that decided it, so that corners never fall together.
    pub margin: f64,
    /// Every road is cut back at least so far where it meets another.
    pub least_trim: f64,
    /// What remains of a road at least, where it is long enough.
    pub least_road: f64,
}

impl Default for OutlineOptions {
    fn default() -> Self {
        Self { kerb_radius: 4.0, kerb_reach: 4.0, margin: 0.2, least_trim: 0.5, least_road: 1.5 }
    }
}

/// The outline of every intersection of the network, with a finding for each that could not be made as it should.
pub fn outlines(network: &RoadNetwork, options: &OutlineOptions) -> (Outlines, Vec<Finding>) {
    let plans = plans(network, options);
    let least = stations(network, &plans, |star| &star.least);
    let wanted = stations(network, &plans, |star| &star.trims);
    let kept: Vec<[f64; 2]> = network
        .roads
        .iter()
        .zip(least.iter().zip(&wanted))
        .map(|(road, (least, wanted))| {
            let length = road.line.length();
            let trims = |[from, to]: &[f64; 2]| [*from, length - to];
            trim::share(length, trims(least), trims(wanted), options.least_road)
        })
        .collect();
    let mut findings = Vec::new();
    let intersections = plans
        .iter()
        .zip(&network.intersections)
        .map(|(plan, intersection)| close(network, intersection, plan, &kept, &mut findings))
        .collect();
    (Outlines { kept, intersections }, findings)
}

/// The stations between which each road remains at the most: after what its ends must have, without the room that
/// kerbs would like. Consolidation decides by them. The first is beyond the second where the road lies inside what
/// its ends need.
pub fn remaining(network: &RoadNetwork, options: &OutlineOptions) -> Vec<[f64; 2]> {
    stations(network, &plans(network, options), |star| &star.least)
}

fn plans(network: &RoadNetwork, options: &OutlineOptions) -> Vec<Plan> {
    network.intersections.iter().map(|i| plan(network, i, options)).collect()
}

/// Per road the stations between which it remains if each end is trimmed as its star says.
fn stations(network: &RoadNetwork, plans: &[Plan], trims: impl Fn(&Star) -> &[f64]) -> Vec<[f64; 2]> {
    let mut stations: Vec<[f64; 2]> = network.roads.iter().map(|road| [0.0, road.line.length()]).collect();
    for plan in plans {
        for (arm, trim) in plan.arms.iter().zip(trims(&plan.star)) {
            let [from, to] = &mut stations[arm.at.road.0 as usize];
            match arm.at.end {
                End::Start => *from = *trim,
                End::End => *to -= *trim,
            }
        }
    }
    stations
}

/// What is to be done at one intersection before the roads' other ends are known.
struct Plan {
    case: Case,
    arms: Vec<Arm>,
    star: Star,
    /// Where several nodes were merged.
    ground: Option<Ground>,
}

fn plan(network: &RoadNetwork, intersection: &Intersection, options: &OutlineOptions) -> Plan {
    let arms: Vec<Arm> = intersection.arms.iter().map(|at| Arm::new(network, *at)).collect();
    if let Some(ground) = Ground::new(network, intersection) {
        let trims = ground.trims(options);
        let star = Star { least: trims.clone(), trims, corners: Vec::new() };
        return Plan { case: Case::Merged, arms, star, ground: Some(ground) };
    }
    match arms.as_slice() {
        [_] if intersection.map_edge => Plan {
            case: Case::MapEdge,
            arms,
            star: Star { least: vec![0.0], trims: vec![0.0], corners: vec![Corner::Open] },
            ground: None,
        },
        [arm] => {
            let trims = vec![terminus::dead_end(arm, options)];
            let star = Star { least: trims.clone(), trims, corners: vec![Corner::Open] };
            Plan { case: Case::DeadEnd, arms, star, ground: None }
        }
        _ => {
            let star = general::star(&arms, options);
            let case = match arms.len() {
                2 => Case::Degenerate,
                _ => Case::General,
            };
            Plan { case, arms, star, ground: None }
        }
    }
}

/// Closes the ring with the cuts as they came out.
fn close(
    network: &RoadNetwork,
    intersection: &Intersection,
    plan: &Plan,
    kept: &[[f64; 2]],
    findings: &mut Vec<Finding>,
) -> Outline {
    let trims: Vec<f64> = plan
        .arms
        .iter()
        .map(|arm| {
            let [from, to] = kept[arm.at.road.0 as usize];
            match arm.at.end {
                End::Start => from,
                End::End => arm.length - to,
            }
        })
        .collect();
    let cuts: Vec<Cut> = plan.arms.iter().zip(&trims).map(|(arm, trim)| walk::cut(arm, *trim)).collect();
    if matches!(plan.case, Case::MapEdge) || cuts.is_empty() {
        return Outline { case: plan.case, corners: vec![Vec::new(); cuts.len()], cuts, ring: Vec::new() };
    }
    for rounded in [true, false] {
        let corners = match &plan.ground {
            Some(ground) => ground.corners(&trims, &cuts),
            None => Some(corners(plan, &trims, rounded)),
        };
        let Some(corners) = corners else { break };
        let ring = walk::ring(&cuts, &corners);
        if walk::is_simple(&ring) {
            return Outline { case: plan.case, cuts, corners, ring };
        }
    }
    findings.push(failure(network, intersection));
    fallback(cuts)
}

fn corners(plan: &Plan, trims: &[f64], rounded: bool) -> Vec<Vec<Point>> {
    let n = plan.arms.len();
    (0..n)
        .map(|i| {
            let next = (i + 1) % n;
            let (a, b) = (&plan.arms[i], &plan.arms[next]);
            let corner = fitted(a, b, [trims[i], trims[next]], plan.star.corners[i], rounded);
            match corner {
                Some(corner) => walk::corner(a, b, [trims[i], trims[next]], corner),
                None => vec![walk::cut(a, trims[i]).left, walk::cut(b, trims[next]).right],
            }
        })
        .collect()
}

/// The corner with a curve that begins before the cuts; `None` if the collision itself lies beyond a cut.
fn fitted(a: &Arm, b: &Arm, trims: [f64; 2], corner: Corner, rounded: bool) -> Option<Corner> {
    let Corner::Collision { point, along, tangent } = corner else { return Some(corner) };
    let room_a = a.right.project(a.corner(trims[0], Side::Right)).station - along[0];
    let room_b = b.left.project(b.corner(trims[1], Side::Left)).station - along[1];
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
