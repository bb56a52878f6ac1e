//! The end of a road: its direction, points and lanes on a cut across it, and its other end.

use crate::builder::tags::cross_section::{CrossSection, Travel};
use crate::geometry::pose::Pose;
use crate::geometry::{Point, Vector, left_of};

use super::{End, Road, RoadEnd, RoadNetwork, Stations};

/// The direction into the intersection at the end of a road that is cut at `station`, metres.
pub fn inward(road: &Road, end: End, station: f64) -> Vector {
    match end {
        End::Start => -road.line.direction(station),
        // At a vertex the segment before it counts: it is the one that remains.
        End::End => road.line.direction((station - 1e-3).max(0.0)),
    }
}

/// The direction from the end of a road to the point `look` metres up its line, not normalised.
pub fn outward(road: &Road, end: End, look: f64) -> Vector {
    match end {
        End::Start => road.line.at(look) - road.line.first(),
        End::End => road.line.at(road.line.length() - look) - road.line.last(),
    }
}

/// The point on the cut across a road, `offset` metres to the left of its line.
pub fn on_cut(road: &Road, end: End, station: f64, offset: f64) -> Point {
    let along = match end {
        End::Start => -inward(road, end, station),
        End::End => inward(road, end, station),
    };
    road.line.at(station) + left_of(along) * offset
}

/// A lane of a road as seen from its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LaneAt {
    /// Index of the strip.
    pub strip: usize,
    /// Whether vehicles use it into the intersection.
    pub into: bool,
}

/// Driven lanes at an end, left to right looking into the intersection. A strip for both directions of travel gives two.
pub fn lanes_at(section: &CrossSection, end: End) -> Vec<LaneAt> {
    let mut lanes = Vec::new();
    for (strip, s) in section.driven() {
        let with_line = matches!(s.travel, Travel::Forward | Travel::Both);
        let against = matches!(s.travel, Travel::Backward | Travel::Both);
        for (used, into) in [(with_line, end == End::End), (against, end == End::Start)] {
            if used {
                lanes.push(LaneAt { strip, into });
            }
        }
    }
    if end == End::Start {
        lanes.reverse();
    }
    lanes
}

/// The middle of a lane on the cut, with its direction of travel.
pub fn lane_pose(road: &Road, end: End, station: f64, lane: LaneAt) -> Pose {
    let offset = (road.section.edge(lane.strip) + road.section.edge(lane.strip + 1)) / 2.0;
    let inward = inward(road, end, station);
    Pose { point: on_cut(road, end, station, offset), heading: if lane.into { inward } else { -inward } }
}

/// Distance, metres, up the road from the cut at one end.
pub fn from_cut(cut: Stations, end: End, station: f64) -> f64 {
    match end {
        End::Start => station - cut[0],
        End::End => cut[1] - station,
    }
}

/// The station that lies `depth` metres up the road from the cut at one end.
pub fn at_depth(cut: Stations, end: End, depth: f64) -> f64 {
    match end {
        End::Start => cut[0] + depth,
        End::End => cut[1] - depth,
    }
}

/// Whether vehicles arrive at the intersection over this road end.
pub fn leads_in(network: &RoadNetwork, arm: RoadEnd) -> bool {
    let inbound = arm.end.inbound();
    network.road(arm.road).section.driven().any(|(_, s)| s.travel == inbound || s.travel == Travel::Both)
}

/// Whether vehicles leave the intersection over this road end.
pub fn leads_out(network: &RoadNetwork, arm: RoadEnd) -> bool {
    leads_in(network, other_end(arm))
}

/// In how many directions vehicles pass this road end: in, out, or both.
pub fn directions(network: &RoadNetwork, arm: RoadEnd) -> usize {
    usize::from(leads_in(network, arm)) + usize::from(leads_out(network, arm))
}

/// The same road's other end.
pub fn other_end(arm: RoadEnd) -> RoadEnd {
    RoadEnd { road: arm.road, end: arm.end.other() }
}

/// Whether a road leads from one intersection of three roads or more to another.
pub fn is_between_crossings(network: &RoadNetwork, road: &Road) -> bool {
    let is_crossing = |at| network.intersection(at).arms.len() > 2;
    !road.roundabout && road.from != road.to && [road.from, road.to].into_iter().all(is_crossing)
}
