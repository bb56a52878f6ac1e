//! The index of a map, built once for all rules: which lanes follow each other, share a way or conflict, where the intersections
//! and their approaches are, on which side people drive.

mod area_bays;
mod area_doors;
mod area_ground;
mod area_outline;
mod area_pockets;
mod conflict;
pub mod drawn_centerline;
mod driving_side;
mod edges_near;
mod filled_unions;
mod intersection;
mod lane;
mod priority;
mod queries;
mod road_leg;
mod roundabout;
pub mod routing_graph;
mod stop_line;
pub mod thresholds;
pub mod tier4_yields;
mod traffic;
mod types;
mod union_find;
mod unloaded;
mod unmarked;
mod user_names;
pub mod view;

pub use area_doors::{Door, lets_vehicles_in};
pub use area_ground::Undrawn;
pub use area_outline::{AreaOutlines, Corner, Outline};
pub use conflict::{Reach, passing, reaches};
pub use filled_unions::FilledUnions;
pub use intersection::declared_area;
pub(crate) use lane::tangent;
pub use lane::{Edge, HEADING_REACH, HEADING_STEP, Lane, center_line, extent, turn_along};
pub use queries::{allows_lane_change, is_road_border, is_signalised};
pub use road_leg::{Crossed, legs};
pub use roundabout::RingShape;
pub use stop_line::{Misfit, StopLine};
pub use traffic::{STRAIGHT_ON, U_TURN};
pub use types::{
    Arm, ArmEdge, Conflict, DrivingSide, Intersection, IntersectionMember, MapIndex, Movement, Rank, SideVotes,
    Traffic, Unmarked,
};
pub use union_find::UnionFind;
pub use unmarked::JOINING;
use view::View;

use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Condition, Lanelet, LaneletId, LaneletMap, LineStringId, LoadFault, RegulatoryElementId};
use crate::diagnostic::Subject;
use crate::parallel::InSmallParts;
use crate::settings::Settings;

impl<'m> MapIndex<'m> {
    /// Indexes a map. Lanelets whose bounds oppose each other are skipped; a map that was never a file has no faults.
    pub fn new(map: &'m LaneletMap, faults: &'m [LoadFault], settings: &'m Settings) -> Self {
        let broken: FxHashSet<LaneletId> = faults.iter().filter_map(turned_inside_out).collect();
        let bicycles: FxHashSet<i64> = settings.bicycle_lanes.iter().copied().collect();
        let mut lanes: Vec<Lane> = map
            .lanelets
            .as_slice()
            .par_iter()
            .in_small_parts()
            .filter(|lanelet| !broken.contains(&lanelet.id))
            .filter_map(|lanelet| Lane::new(map, lanelet))
            .collect();
        lanes.iter_mut().for_each(|lane| lane.bicycle |= bicycles.contains(&lane.id.0));
        mark_both_ways(&mut lanes);
        let boxes = lanes.iter().enumerate().map(|(at, lane)| {
            let [low, high] = lane.extent;
            GeomWithData::new(Rectangle::from_corners([low.x, low.y], [high.x, high.y]), at)
        });
        let tree = RTree::bulk_load(boxes.collect());
        let conflicts = conflict::conflicts(map, &lanes, &tree);
        let intersections = intersection::intersections(map, &lanes, &tree, &conflicts);
        let side = driving_side::votes(&lanes, &intersections, settings);
        let [intersections_of, touching] = intersections_by_lane(&intersections, lanes.len());
        let named = user_names::entries(map, &intersections, settings);
        let mut index = Self {
            by_id: lanes.iter().enumerate().map(|(at, lane)| (lane.id, at)).collect(),
            starting: grouped(lanes.iter().enumerate().map(|(at, lane)| (lane.start.ids, at))),
            ending: grouped(lanes.iter().enumerate().map(|(at, lane)| (lane.end.ids, at))),
            way_users: grouped(lanes.iter().enumerate().flat_map(|(at, lane)| lane.bounds.map(|way| (way, at)))),
            map,
            faults,
            settings,
            on_roundabout: lanes.iter().map(|_| Default::default()).collect(),
            ends_on_roundabout: lanes.iter().map(|_| Default::default()).collect(),
            lanes,
            conflicts,
            intersections,
            side,
            traffic: Vec::new(),
            named,
            stop_lines: Default::default(),
            unmarked: Default::default(),
            unloaded: Default::default(),
            tree,
            edges: Default::default(),
            referrers: referrers(map),
            naming: Default::default(),
            intersections_of,
            touching,
            view: View::new(map),
            filled_unions: None,
        };
        index.traffic = (0..index.intersections.len())
            .into_par_iter()
            .in_small_parts()
            .map(|at| traffic::traffic(&index, at))
            .collect();
        index
    }
}

/// The lanelets that refer to each regulatory element.
fn referrers(map: &LaneletMap) -> FxHashMap<RegulatoryElementId, Vec<LaneletId>> {
    let of = |lanelet: &Lanelet| lanelet.regulatory_elements.iter().map(|&id| (id, lanelet.id)).collect::<Vec<_>>();
    grouped(map.lanelets.iter().flat_map(of))
}

/// Marks the lanes that are driven both ways: another lanelet has the same bounds in exchanged roles.
fn mark_both_ways(lanes: &mut [Lane]) {
    let bounds: FxHashSet<[LineStringId; 2]> = lanes.iter().map(|lane| lane.bounds).collect();
    for lane in lanes {
        let [left, right] = lane.bounds;
        lane.both_ways = bounds.contains(&[right, left]);
    }
}

/// The lanelet of a fault that says its bounds oppose each other: it has no inside.
fn turned_inside_out(fault: &LoadFault) -> Option<LaneletId> {
    match (&fault.condition, fault.subject) {
        (Condition::BoundsOpposed { .. }, Subject::Lanelet(id)) => Some(LaneletId(id)),
        _ => None,
    }
}

/// For every lane the intersections that it is a member of, and those plus the ones whose area it touches.
fn intersections_by_lane(intersections: &[Intersection], lanes: usize) -> [Vec<Vec<usize>>; 2] {
    let [mut member_of, mut touching] = [vec![Vec::new(); lanes], vec![Vec::new(); lanes]];
    for (at, intersection) in intersections.iter().enumerate() {
        for member in &intersection.members {
            member_of[member.lane].push(at);
            touching[member.lane].push(at);
        }
        for &(lane, _) in &intersection.touched {
            touching[lane].push(at);
        }
    }
    [member_of, touching]
}

/// Values by key, each list in the order of the input.
fn grouped<K: std::hash::Hash + Eq, V>(pairs: impl Iterator<Item = (K, V)>) -> FxHashMap<K, Vec<V>> {
    let mut groups: FxHashMap<K, Vec<V>> = FxHashMap::default();
    for (key, value) in pairs {
        groups.entry(key).or_default().push(value);
    }
    groups
}
