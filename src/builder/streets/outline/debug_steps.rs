//! How the outline of one intersection comes to be: what each step of the method finds, to be looked at.

use crate::builder::network::{IntersectionIx, RoadEnd, RoadNetwork};
use crate::geometry::{Point, Polyline};

use super::collide::collisions;
use super::intersection_plan::IntersectionSite;
use super::{OutlineOptions, uncut};

/// The steps at one intersection.
#[derive(Clone, Debug)]
pub struct DebugSteps {
    /// The roads that meet, clockwise.
    pub arms: Vec<ArmTrace>,
    /// Where their edges collide.
    pub hits: Vec<Hit>,
    /// What the roads inside a merged intersection cover.
    pub ground: Vec<Vec<Point>>,
}

/// A thickened road, seen from the intersection outwards.
#[derive(Clone, Debug)]
pub struct ArmTrace {
    /// The road and the end from which it is seen.
    pub at: RoadEnd,
    /// Its centre line.
    pub line: Polyline,
    /// Its left edge.
    pub left: Polyline,
    /// Its right edge.
    pub right: Polyline,
    /// How far it must be cut back, metres.
    pub least: f64,
    /// How far it would be cut back with room for its kerbs, metres.
    pub wanted: f64,
}

/// A collision of two edges.
#[derive(Clone, Debug)]
pub struct Hit {
    /// Where.
    pub point: Point,
    /// Its nearest places on the two centre lines.
    pub feet: [Point; 2],
    /// Whether it decides how far one of the two roads is cut back.
    pub decides: [bool; 2],
}

/// Makes the outline of one intersection once more and tells each step.
pub fn trace(network: &RoadNetwork, ix: IntersectionIx, options: &OutlineOptions) -> DebugSteps {
    let site = IntersectionSite::new(network, network.intersection(ix), &uncut(network), options);
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
        at: arm.at,
        line: arm.line.clone(),
        left: arm.left.clone(),
        right: arm.right.clone(),
        least: *least,
        wanted: *wanted,
    });
    DebugSteps { arms: arms.collect(), hits, ground: plan.ground.clone() }
}
