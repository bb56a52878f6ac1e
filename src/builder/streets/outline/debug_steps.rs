//! The steps of the outline of one intersection, for pictures.

use crate::builder::network::{IntersectionIx, RoadEnd, RoadNetwork};
use crate::geometry::{Point, Polyline};

use super::collide::collisions;
use super::intersection_plan::IntersectionSite;
use super::uncut;

/// The steps at one intersection.
#[derive(Clone, Debug)]
pub struct DebugSteps {
    /// The arms, clockwise.
    pub arms: Vec<ArmTrace>,
    /// The collisions of their edges.
    pub hits: Vec<Hit>,
}

/// A thickened arm, outwards.
#[derive(Clone, Debug)]
pub struct ArmTrace {
    /// The road end at the intersection.
    pub at: RoadEnd,
    /// Its centre line.
    pub line: Polyline,
    /// How far it must be cut back, metres.
    pub least: f64,
    /// How far it is cut back with room for its kerbs, metres.
    pub wanted: f64,
}

/// A collision of two edges.
#[derive(Clone, Debug)]
pub struct Hit {
    /// Where.
    pub point: Point,
    /// Its projections onto the two centre lines.
    pub feet: [Point; 2],
    /// For each road whether this is its farthest collision.
    pub decides: [bool; 2],
}

/// The steps of the outline of one intersection.
pub fn trace(network: &RoadNetwork, ix: IntersectionIx) -> DebugSteps {
    let site = IntersectionSite::new(network, network.intersection(ix), &uncut(network));
    let (arms, plan) = (site.arms(), &site.plan);
    let mut found = Vec::new();
    let mut farthest = vec![f64::NEG_INFINITY; arms.len()];
    for i in 0..arms.len() {
        for j in i + 1..arms.len() {
            for hit in collisions(&arms[i], &arms[j]) {
                farthest[i] = farthest[i].max(hit.stations[0]);
                farthest[j] = farthest[j].max(hit.stations[1]);
                found.push((i, j, hit));
            }
        }
    }
    let hits = found.iter().map(|(i, j, hit)| Hit {
        point: hit.point,
        feet: [arms[*i].line.at(hit.stations[0]), arms[*j].line.at(hit.stations[1])],
        decides: [hit.stations[0] >= farthest[*i], hit.stations[1] >= farthest[*j]],
    });
    let hits = hits.collect();
    let trims = plan.star.least.iter().zip(&plan.star.trims);
    let arms = arms.iter().zip(trims).map(|(arm, (least, wanted))| ArmTrace {
        at: arm.road_end,
        line: arm.line.clone(),
        least: *least,
        wanted: *wanted,
    });
    DebugSteps { arms: arms.collect(), hits }
}
