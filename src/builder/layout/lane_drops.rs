//! Where more lanes lead into a road than it has: they merge behind the intersection if the road has room for that.

use std::collections::BTreeSet;

use rustc_hash::FxHashSet;

use crate::builder::network::road_end::{at_depth, from_cut};
use crate::builder::network::{FeatureKind, Intersection, Road, RoadEnd, RoadKey, RoadNetwork};
use crate::builder::streets::lane_drop::LaneDrop;
use crate::builder::tags::cross_section::{StripKind, Travel};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::spatial_hash::{Bounds, SpatialHash};
use crate::geometry::{Point, Vector, left_of};

use super::map_layout::Layout;

/// Additional lanes reach this far, metres, behind the cut of a road, ...
pub(super) const LENGTH: f64 = 45.0;
/// ... or over this share of a shorter road, ...
const SHARE: f64 = 0.6;
/// ... which has at least this length, metres, between its cuts.
const LEAST_LEFT: f64 = 25.0;
/// No crossing, light or sign lies nearer to the end of additional lanes than this, metres: there the road tapers.
const CONTROL_FROM_DROP: f64 = 20.0;
/// Places at which a road is measured for room lie this far apart, metres; the first one this far behind its cut.
const MEASURED_EVERY: f64 = 3.0;
/// Between additional lanes and another road there is at least this, metres.
const GAP: f64 = 0.3;

/// The additional lanes that roads need so that no lanes merge in an intersection; at most for one end of each road.
pub fn lane_drops(layout: &Layout) -> Vec<LaneDrop> {
    let drawn = layout.network.intersections.iter().zip(&layout.turning);
    // Where one road only goes on as another, lanes end on the way from one to the other.
    let junctions = drawn.filter(|(at, _)| at.arms.len() > 2);
    let exits = junctions.flat_map(|(at, turning)| {
        let paths = turning.as_ref().map_or(&[][..], |turning| &turning.drawn.paths[..]);
        (0..at.arms.len()).filter_map(move |to| {
            let movements = paths.iter().map(|path| path.movement).filter(|movement| movement.to == to);
            let pairs: Vec<[usize; 3]> = movements.map(|one| [one.from, one.in_lane, one.out_lane]).collect();
            let lanes = missing_lanes(layout, at, to, &pairs);
            (lanes > 0).then_some((at.arms[to], lanes))
        })
    });
    let mut roads = FxHashSet::default();
    let drops = exits.filter_map(|(at, lanes)| Some(LaneDrop { at, lanes, length: length(layout, at)? }));
    let mut drops: Vec<LaneDrop> = drops.collect();
    if !drops.is_empty() {
        let others = Neighbours::new(&layout.network);
        drops.retain(|drop| others.leave_room(layout, drop) && roads.insert(drop.at.road));
    }
    drops
}

/// The note that a road begins with more lanes than its way has.
pub fn added_lanes(network: &RoadNetwork, drop: &LaneDrop) -> Finding {
    let RoadKey { way, first, last, .. } = network.road(drop.at.road).key;
    let node = network.intersection(network.intersection_at(drop.at)).first_node();
    let lanes = if drop.lanes == 1 { "one lane more".to_owned() } else { format!("{} lanes more", drop.lanes) };
    let message = format!(
        "way {way} between nodes {first} and {last} has {lanes} over {:.0} m from node {node}: as many lead into it there, and merge \
         behind the intersection",
        drop.length
    );
    Finding::new("lanes-added", Subject::Way(way), message).graded(Severity::Info)
}

/// The number of lanes that an exit lacks: of those that lead there from one approach, each of `pairs` being approach, lane in and
/// lane out, some merge.
fn missing_lanes(layout: &Layout, at: &Intersection, to: usize, pairs: &[[usize; 3]]) -> usize {
    let outs = &layout.lanes.arm(at.arms[to]).out;
    let cars = outs.iter().filter(|lane| lane.kind == StripKind::Drive).count();
    let lacking = (0..at.arms.len()).map(|from| {
        let into = &layout.lanes.arm(at.arms[from]).into;
        let drive = |lane: usize| into.get(lane).is_some_and(|lane| lane.kind == StripKind::Drive);
        let own = pairs.iter().filter(|[arm, lane, _]| *arm == from && drive(*lane));
        let (ins, reached): (BTreeSet<usize>, BTreeSet<usize>) = own.map(|[_, into, out]| (*into, *out)).unzip();
        if ins.len() > reached.len() { ins.len().saturating_sub(cars) } else { 0 }
    });
    lacking.max().unwrap_or(0)
}

/// Where additional lanes of a road end: distance along its line from the end at the intersection, metres. `None` where
/// [`place_to_change_lanes`] gives none.
fn length(layout: &Layout, at: RoadEnd) -> Option<f64> {
    place_to_change_lanes(layout, at, LENGTH.min(SHARE * layout.left(at.road)))
}

/// The distance along the line of a road from one of its ends to a place so many metres behind its cut there, if its number of lanes may
/// change there. `None` where the road is too short, is part of a roundabout or has a lane for both directions, and where a light,
/// sign or stop line for this end of the road would lie beyond that place, or too near it.
pub(super) fn place_to_change_lanes(layout: &Layout, at: RoadEnd, behind: f64) -> Option<f64> {
    let network = &layout.network;
    let road = network.road(at.road);
    let both = road.section.driven().any(|(_, strip)| strip.travel == Travel::Both);
    let left = layout.left(at.road);
    let is_via = network.restrictions.iter().any(|restriction| restriction.via.contains(&at.road));
    if road.roundabout || both || road.from == road.to || left < LEAST_LEFT || is_via {
        return None;
    }
    let whole = [0.0, road.line.length()];
    let cut = from_cut(whole, at.end, layout.lines.kept[at.road][at.end]);
    let length = cut + behind;
    let far_node = road.node(at.end.other());
    let is_clear = road.features.iter().filter(|feature| feature.node != far_node).all(|feature| {
        let depth = from_cut(whole, at.end, feature.station);
        (depth - length).abs() > CONTROL_FROM_DROP && (depth < length || !leads_to(feature.kind, at))
    });
    is_clear.then_some(length)
}

/// Whether a light, sign or stop line is for vehicles that drive to this end of the road.
fn leads_to(kind: FeatureKind, at: RoadEnd) -> bool {
    let travel = match kind {
        FeatureKind::Crossing { .. } | FeatureKind::Sidewalk => return false,
        FeatureKind::Signals(travel)
        | FeatureKind::MidBlockSignals(travel)
        | FeatureKind::Stop(travel)
        | FeatureKind::GiveWay(travel)
        | FeatureKind::StopLine(travel) => travel,
    };
    travel == at.end.inbound() || travel == Travel::Both
}

/// The roads of a network by place.
struct Neighbours<'a> {
    roads: &'a [Road],
    boxes: SpatialHash,
}

impl<'a> Neighbours<'a> {
    fn new(network: &'a RoadNetwork) -> Self {
        let around = |road: &Road| -> Bounds {
            let [low, high] = road.line.bounds();
            let margin = Vector::repeat(road.half_width() + GAP);
            [low - margin, high + margin]
        };
        /// The side of a cell, metres: about a city block.
        const SIDE: f64 = 100.0;
        Self { roads: &network.roads, boxes: SpatialHash::new(network.roads.iter().map(around).collect(), SIDE) }
    }

    /// Whether no other road of the same level lies where additional lanes would lie.
    fn leave_room(&self, layout: &Layout, drop: &LaneDrop) -> bool {
        let road = layout.network.road(drop.at.road);
        let whole = [0.0, road.line.length()];
        let cut = from_cut(whole, drop.at.end, layout.lines.kept[drop.at.road][drop.at.end]);
        let reaches = drop.reaches(road, layout.network.side);
        let depths = (1..).map(|i| cut + MEASURED_EVERY * f64::from(i)).take_while(|depth| *depth < drop.length);
        let stations = depths.map(|depth| at_depth(whole, drop.at.end, depth));
        let mut edges = stations.flat_map(|station| {
            let (middle, left) = (road.line.at(station), left_of(road.line.direction(station)));
            reaches.map(|aside| middle + left * aside)
        });
        edges.all(|place| self.is_free(place, road))
    }

    fn is_free(&self, place: Point, road: &Road) -> bool {
        let mut free = true;
        self.boxes.touching([place, place], |other| {
            if let Some(other) =
                self.roads.get(other).filter(|other| other.key != road.key && other.level == road.level)
            {
                free &= other.line.distance(place) > other.half_width() + GAP;
            }
        });
        free
    }
}
