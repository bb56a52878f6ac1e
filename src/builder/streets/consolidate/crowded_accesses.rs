//! Short dead ends that crowd a road, such as driveways of a row of houses. If they were merged, the whole row would become one
//! intersection.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::builder::network::{IntersectionIx, Road, RoadEnd, RoadIx, RoadKey, RoadNetwork};
use crate::builder::tags::road_class::RoadClass;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::index::UnionFind;

/// At least this number of them, at intersections between which no vehicle has room, are a row. Two are the driveways on both
/// sides of a road.
const ROW: usize = 3;
/// A row shorter than this, metres, may become one intersection.
const SHORTEST: f64 = 15.0;
/// A dead end longer than this, metres, is not left out.
const LONGEST: f64 = 100.0;

/// The dead ends to leave out, in order: some of each row whose intersections are joined by roads without room. Without them, the
/// others of the row have more room, or are in shorter rows. The choice depends on the neighbours of a dead end and not on the
/// whole row: no two neighbours are left out, those between two others come first, and private ones before public ones.
pub fn crowded_accesses(network: &RoadNetwork, without_room: &[RoadIx]) -> Vec<RoadIx> {
    let mut joined = UnionFind::new(network.intersections.len());
    let mut beside: BTreeMap<IntersectionIx, Vec<IntersectionIx>> = BTreeMap::new();
    for road in without_room.iter().map(|road| network.road(*road)).filter(|road| road.from != road.to) {
        joined.join(road.from.position(), road.to.position());
        beside.entry(road.from).or_default().push(road.to);
        beside.entry(road.to).or_default().push(road.from);
    }
    let mut rows: BTreeMap<usize, Vec<Access>> = BTreeMap::new();
    for (at, others) in beside {
        rows.entry(joined.root(at.position())).or_default().extend(Access::at(network, at, others));
    }
    rows.retain(|_, row| row.iter().map(|access| access.roads.len()).sum::<usize>() >= ROW && spans(network, row));
    let mut crowding: Vec<RoadIx> = rows.values().flat_map(|row| first_to_go(row)).copied().collect();
    crowding.sort_unstable();
    crowding
}

/// An intersection that short dead ends lead to.
struct Access {
    at: IntersectionIx,
    /// The dead ends.
    roads: Vec<RoadIx>,
    /// Intersections at the other ends of roads without room.
    beside: Vec<IntersectionIx>,
    /// The dead ends of the access with the smallest order are left out first: whether it lies at the end of a row, whether one
    /// of its dead ends is public, and a pseudo-random number. `None` if other roads meet at the access, so that it is an
    /// intersection without its dead ends.
    order: Option<(bool, bool, i64)>,
}

impl Access {
    /// An intersection with its dead ends; `None` if it has none.
    fn at(network: &RoadNetwork, at: IntersectionIx, beside: Vec<IntersectionIx>) -> Option<Self> {
        let intersection = network.intersection(at);
        let roads: Vec<RoadIx> =
            intersection.arms.iter().filter(|arm| is_access(network, **arm)).map(|arm| arm.road).collect();
        let public = roads.iter().any(|road| network.road(*road).public);
        let lot = Key::new("crowded access").number(intersection.first_node()).new_node();
        let order = (intersection.arms.len() < roads.len() + 3).then_some((beside.len() < 2, public, lot));
        (!roads.is_empty()).then_some(Self { at, roads, beside, order })
    }
}

/// Whether a short service road or private road leads away from an intersection, and nowhere else.
fn is_access(network: &RoadNetwork, arm: RoadEnd) -> bool {
    let road = network.road(arm.road);
    let far = network.intersection(road.intersection(arm.end.other()));
    let minor = !road.public || road.class >= RoadClass::Service;
    minor && far.arms.len() == 1 && !far.map_edge && road.line.length() <= LONGEST
}

/// Whether two accesses of a row lie farther from each other than one intersection should reach.
fn spans(network: &RoadNetwork, row: &[Access]) -> bool {
    let place = |access: &Access| network.intersection(access.at).position;
    row.iter().any(|a| row.iter().any(|b| (place(a) - place(b)).norm() > SHORTEST))
}

/// The dead ends of those accesses of a row that come before all beside them. The row is in the order of its intersections.
fn first_to_go(row: &[Access]) -> impl Iterator<Item = &RoadIx> {
    let order = |at: &IntersectionIx| {
        let found = row.binary_search_by_key(at, |access| access.at).ok()?;
        row.get(found)?.order
    };
    let comes_first = move |access: &&Access| {
        let others = access.beside.iter().filter_map(order);
        access.order.is_some_and(|own| others.min().is_none_or(|other| own < other))
    };
    row.iter().filter(comes_first).flat_map(|access| &access.roads)
}

/// The note that a dead end is not built.
pub fn crowds(road: &Road) -> Finding {
    let RoadKey { way, first, last, .. } = road.key;
    let message = format!(
        "way {way} is not built between nodes {first} and {last}: it is one of a row of short dead ends that leave no room between them"
    );
    Finding::new("way-skipped", Subject::Way(way), message).graded(Severity::Info)
}
