//! Reads turn restrictions and lane connections from relations, and finds their road ends.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::angle_between;
use crate::osm::{ElementKind, OsmData, Relation};

use super::road_end::outward;
use super::signal_assignment::arrives;
use super::{End, IntersectionIx, LaneConnection, RoadEnd, RoadIx, RoadNetwork, TurnRestriction, connectivity};

/// Keys of restrictions that bind cars, from the most specific to the least.
const KEYS: [&str; 4] = ["restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle", "restriction"];

/// What a restriction may say.
const VALUES: [&str; 11] = [
    "no_left_turn",
    "no_right_turn",
    "no_straight_on",
    "no_u_turn",
    "no_entry",
    "no_exit",
    "no_turn",
    "only_left_turn",
    "only_right_turn",
    "only_straight_on",
    "only_u_turn",
];

/// Distance from the node at which the direction of a way is taken, metres.
const LOOK: f64 = 8.0;

/// A turn up to this angle, radians, goes straight on.
const STRAIGHT_ON_ANGLE: f64 = std::f64::consts::FRAC_PI_4;

/// A turn beyond this angle, radians, is a U-turn.
const U_TURN: f64 = 2.6;

/// The most roads that `via` ways are cut into.
const MOST_VIA: usize = 24;

/// Finds the members of relations in a network.
struct Lookup<'a> {
    network: &'a RoadNetwork,
    roads_of_way: FxHashMap<i64, Vec<RoadIx>>,
    intersection_of_node: FxHashMap<i64, IntersectionIx>,
}

/// Members of one relation.
#[derive(Default)]
struct Members {
    from: Vec<i64>,
    to: Vec<i64>,
    via_nodes: Vec<i64>,
    via_ways: Vec<i64>,
}

/// Reads every restriction and lane connection of the data, with a note for each that cannot be read.
pub(super) fn turns(
    osm: &OsmData,
    network: &RoadNetwork,
    notes: &mut Vec<Finding>,
) -> (Vec<TurnRestriction>, Vec<LaneConnection>) {
    let mut lookup = Lookup { network, roads_of_way: FxHashMap::default(), intersection_of_node: FxHashMap::default() };
    for ix in RoadIx::all(network.roads.len()) {
        lookup.roads_of_way.entry(network.road(ix).key.way).or_default().push(ix);
    }
    for ix in IntersectionIx::all(network.intersections.len()) {
        lookup.intersection_of_node.extend(network.intersection(ix).nodes.iter().map(|id| (*id, ix)));
    }
    let mut ids: Vec<i64> = osm.relations.iter().map(|relation| relation.id).collect();
    ids.sort_unstable();
    ids.dedup();
    let (mut all, mut connections) = (Vec::new(), Vec::new());
    let mut skip = |fault: &'static str, what: &str, relation: &Relation, why: &str| {
        let message = format!("{what} {} is passed over: {why}", relation.id);
        notes.push(Finding::new(fault, Subject::Relation(relation.id), message).graded(Severity::Info));
    };
    for relation in ids.into_iter().filter_map(|id| osm.relation(id)) {
        match relation.tags.get("type").and_then(|kind| kind.split(':').next()) {
            Some("restriction") => match lookup.restrictions(relation) {
                Ok(mut turns) => all.append(&mut turns),
                Err(why) => skip("restriction-skipped", "turn restriction", relation, why),
            },
            Some("connectivity") => match lookup.connection(relation) {
                Ok(connection) => connections.push(connection),
                Err(why) => skip("connectivity-skipped", "connection of lanes", relation, why),
            },
            _ => {}
        }
    }
    all.sort_unstable();
    all.dedup();
    (all, connections)
}

impl Lookup<'_> {
    /// The turns that a relation restricts.
    fn restrictions(&self, relation: &Relation) -> Result<Vec<TurnRestriction>, &'static str> {
        let value = KEYS.iter().find_map(|key| relation.tags.get(key));
        let Some(value) = value else {
            let conditional = relation.tags.iter().any(|(key, _)| key.ends_with(":conditional"));
            return Err(if conditional { "it holds at some times only" } else { "it does not bind cars" });
        };
        let except = relation.tags.get("except").unwrap_or_default();
        if except.split(';').any(|who| matches!(who.trim(), "motorcar" | "motor_vehicle" | "vehicle")) {
            return Err("cars are excepted");
        }
        let mut restricted = Vec::new();
        for value in value.split(';').map(str::trim) {
            let only = value.starts_with("only_");
            if value.ends_with("_on_red") {
                return Err("it holds at red only, and a light that is red stops everybody");
            }
            if !VALUES.contains(&value) {
                return Err("its value is unknown");
            }
            let turn = |(from, via, to)| TurnRestriction { relation: relation.id, from, via, to, only };
            restricted.extend(self.turns(relation, value)?.into_iter().map(turn));
        }
        Ok(restricted)
    }

    /// The lanes that a relation connects.
    fn connection(&self, relation: &Relation) -> Result<LaneConnection, &'static str> {
        let lanes = connectivity::lanes(&relation.tags)?;
        match self.turns(relation, "")?.as_slice() {
            [(from, _, to)] => Ok(LaneConnection { relation: relation.id, from: *from, to: *to, lanes }),
            _ => Err("its ways pass through its via, and which of their parts are meant is not said"),
        }
    }

    /// The turns between the members of a relation; `value` is the restriction.
    fn turns(&self, relation: &Relation, value: &str) -> Result<Turns, &'static str> {
        let members = members(relation);
        let from = self.ends_of_ways(&members.from)?;
        let to = self.ends_of_ways(&members.to)?;
        match (members.via_nodes.as_slice(), members.via_ways.as_slice()) {
            ([node], []) => self.at_node(*node, &from, &to, value),
            ([], []) => Err("it has no via"),
            ([], ways) => self.over_ways(ways, &from, &to, value),
            _ => Err("its via is neither one node nor ways"),
        }
    }

    fn ends_of_ways(&self, ways: &[i64]) -> Result<Vec<RoadEnd>, &'static str> {
        let roads: Vec<RoadIx> = ways.iter().filter_map(|way| self.roads_of_way.get(way)).flatten().copied().collect();
        if roads.is_empty() {
            return Err("a way it names is missing or is not driven on");
        }
        Ok(roads.into_iter().flat_map(|road| End::BOTH.map(|end| RoadEnd { road, end })).collect())
    }

    fn arrives(&self, arm: RoadEnd) -> bool {
        arrives(self.network.road(arm.road), arm.end)
    }

    fn leaves(&self, arm: RoadEnd) -> bool {
        self.network.road(arm.road).one_way().is_none_or(|travel| travel != arm.end.inbound())
    }

    /// The turns at a node. If a way passes through it, only those whose angle fits the value.
    fn at_node(&self, node: i64, from: &[RoadEnd], to: &[RoadEnd], value: &str) -> Result<Turns, &'static str> {
        let ix = *self.intersection_of_node.get(&node).ok_or("its via is not where roads meet")?;
        let is_here = |arm: &&RoadEnd| self.network.intersection_at(**arm) == ix;
        let to: Vec<&RoadEnd> = to.iter().filter(is_here).filter(|arm| self.leaves(**arm)).collect();
        let from = from.iter().filter(is_here).filter(|arm| self.arrives(**arm));
        let mut turns: Vec<(RoadEnd, RoadEnd)> = from.flat_map(|f| to.iter().map(|t| (*f, **t))).collect();
        if turns.is_empty() {
            return Err("no traffic can go from its first way to its last over its via");
        }
        if turns.len() > 1 && !has_several_members(value) {
            turns.retain(|(from, to)| self.turns_as(value, *from, *to));
        }
        if turns.is_empty() {
            return Err("its ways pass through its via, and no turn there is as it says");
        }
        Ok(turns.into_iter().map(|(from, to)| (from, Vec::new(), to)).collect())
    }

    /// Whether the angle between two arms of an intersection fits the value.
    fn turns_as(&self, value: &str, from: RoadEnd, to: RoadEnd) -> bool {
        let outward = |arm: RoadEnd| outward(self.network.road(arm.road), arm.end, LOOK);
        let angle = if from == to { std::f64::consts::PI } else { angle_between(-outward(from), outward(to)) };
        match value.split_once('_').map(|(_, turn)| turn) {
            Some("left_turn") => angle > 0.0 && from != to,
            Some("right_turn") => angle < 0.0,
            Some("straight_on") => angle.abs() <= STRAIGHT_ON_ANGLE,
            Some("u_turn") => angle.abs() >= U_TURN,
            _ => true,
        }
    }

    /// The turns over a chain of roads that uses every `via` way. If a way passes through its ends, only those whose angle as a whole fits
    /// the value.
    fn over_ways(&self, via: &[i64], from: &[RoadEnd], to: &[RoadEnd], value: &str) -> Result<Turns, &'static str> {
        if via.iter().any(|way| !self.roads_of_way.contains_key(way)) {
            return Err("a via way is missing or is not driven on");
        }
        let mut turns = Vec::new();
        for start in from.iter().copied().filter(|end| self.arrives(*end)) {
            for end in to.iter().copied().filter(|end| self.leaves(*end)) {
                if let Some(chain) = self.chain(via, start, end) {
                    turns.push((start, chain, end));
                }
            }
        }
        // Ways may touch the via ways more than once: the shortest chain counts.
        let shortest = turns.iter().map(|(_, chain, _)| chain.len()).min();
        turns.retain(|(_, chain, _)| Some(chain.len()) == shortest);
        if turns.is_empty() {
            return Err("its ways do not form a chain");
        }
        if turns.len() > 1 && !has_several_members(value) {
            turns.retain(|(from, _, to)| self.turns_as(value, *from, *to));
        }
        if turns.is_empty() {
            Err("its ways pass through its via ways, and no turn there is as it says")
        } else {
            Ok(turns)
        }
    }

    /// The shortest chain of roads of the `via` ways, in their order, from one road end to another.
    fn chain(&self, via: &[i64], start: RoadEnd, end: RoadEnd) -> Option<Vec<RoadIx>> {
        let goal = self.network.intersection_at(end);
        // Intersections reached, each with the chain there and how many of the ways it has used.
        let mut front = vec![(self.network.intersection_at(start), Vec::new(), 0)];
        for _ in 0..MOST_VIA {
            let mut next = Vec::new();
            for (ix, chain, used) in &front {
                for (road, used) in self.continuations(via, *used) {
                    let Some(reached) = self.step(road, *ix).filter(|_| !chain.contains(&road)) else { continue };
                    let chain = [chain.as_slice(), &[road]].concat();
                    if reached == goal && used == via.len() {
                        return Some(chain);
                    }
                    next.push((reached, chain, used));
                }
            }
            next.sort();
            next.dedup_by_key(|(ix, _, used)| (*ix, *used));
            front = next;
        }
        None
    }

    /// The roads that may continue a chain over its last `via` way or the next one, and how many ways are used then.
    fn continuations(&self, via: &[i64], used: usize) -> impl Iterator<Item = (RoadIx, usize)> {
        let ways = via.iter().zip(1..).take(used + 1).skip(used.saturating_sub(1));
        ways.filter_map(|(way, used)| Some(self.roads_of_way.get(way)?.iter().map(move |road| (*road, used)))).flatten()
    }

    /// The intersection to which a road leads from this one, if traffic may take it.
    fn step(&self, road: RoadIx, from: IntersectionIx) -> Option<IntersectionIx> {
        let arms = End::BOTH.map(|end| RoadEnd { road, end }).into_iter();
        let entry = arms.filter(|arm| self.network.intersection_at(*arm) == from).find(|arm| self.leaves(*arm))?;
        Some(self.network.road(road).intersection(entry.end.other()))
    }
}

/// Whether a restriction of this value may name several ways to come from, or to go to.
fn has_several_members(value: &str) -> bool {
    value.ends_with("_entry") || value.ends_with("_exit")
}

/// From, via, to.
type Turns = Vec<(RoadEnd, Vec<RoadIx>, RoadEnd)>;

fn members(relation: &Relation) -> Members {
    let mut members = Members::default();
    for member in &relation.members {
        match (member.role.as_str(), member.kind) {
            ("from", ElementKind::Way) => members.from.push(member.id),
            ("to", ElementKind::Way) => members.to.push(member.id),
            ("via", ElementKind::Node) => members.via_nodes.push(member.id),
            ("via", ElementKind::Way) => members.via_ways.push(member.id),
            _ => {}
        }
    }
    members
}
