//! Whom a `right_of_way` element lists as TIER IV's validator reads it: by overlaps of lanelets, and by the directions in
//! which lights hang.

use super::routing_graph::Graph;
use super::view::{Seen, View};
use crate::geometry::{Vector, angle_between};
use crate::lanelet::LineStringId;

/// From this share of a lanelet's area on, an overlap is one that has to be listed.
const REAL: f64 = 0.01;
/// Two lights whose directions differ by less than this (deg) change at the same time.
pub const SAME_TIMING: f64 = 45.0;
/// A light shorter than this (m) has no direction.
const NO_LENGTH: f64 = 1e-6;

/// What rules a lanelet of an intersection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ruled {
    /// A traffic light: what has its green at another time is listed.
    ByLight,
    /// No light: all is listed that comes from elsewhere.
    ByNothing,
    /// A virtual traffic light: all is listed.
    Virtually,
}

/// The lanelets that overlap one, by position, in file order.
#[derive(Clone, Debug, Default)]
pub struct Overlaps {
    /// Those that its element has to list.
    pub wanted: Vec<usize>,
    /// Those that overlap it so little that they need not be listed.
    pub slivers: Vec<usize>,
}

impl Overlaps {
    /// Of a lanelet in the graph of cars.
    pub fn new(view: &View, graph: &Graph, at: usize, ruled: Ruled) -> Self {
        let seen = &view.lanelets[at];
        let mut overlaps = Self::default();
        for other in graph.conflicting(at) {
            if ruled == Ruled::ByLight && share_predecessor(graph, at, other) {
                continue;
            }
            let beside = &view.lanelets[other];
            if seen.share(&beside.outline) < REAL {
                overlaps.slivers.push(other);
            } else if match ruled {
                Ruled::ByLight => different_timing(view, seen, beside) || turns_before(seen, beside),
                Ruled::ByNothing => !share_predecessor(graph, at, other),
                Ruled::Virtually => true,
            } {
                overlaps.wanted.push(other);
            }
        }
        overlaps
    }
}

/// Whether two lanelets come from the same one.
pub fn share_predecessor(graph: &Graph, x: usize, y: usize) -> bool {
    let own = graph.previous(x);
    graph.previous(y).iter().any(|before| own.contains(before))
}

/// Whether a lanelet turns before another: to the left before one to the right, as where people drive on the left.
pub fn turns_before(seen: &Seen, other: &Seen) -> bool {
    seen.tag("turn_direction") == Some("left") && other.tag("turn_direction") == Some("right")
}

/// Whether the lights of two lanelets hang across each other; they do as well where one has none.
fn different_timing(view: &View, a: &Seen, b: &Seen) -> bool {
    let (Some((_, a)), Some((_, b))) = (light(view, a), light(view, b)) else { return true };
    let angle = angle_between(a, b).abs().to_degrees();
    angle.min(180.0 - angle) >= SAME_TIMING
}

/// The first light of a lanelet's first traffic light, and its direction.
pub fn light(view: &View, seen: &Seen) -> Option<(LineStringId, Vector)> {
    let element = view.elements_of(seen, "traffic_light").next()?;
    let line = view.lines(element, "refers").next()?;
    let places = view.places(line);
    let along = places.last()? - places.first()?;
    (along.norm() >= NO_LENGTH).then_some((line.id, along))
}
