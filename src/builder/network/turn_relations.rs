//! Turn restrictions and connections of lanes, from relations to road ends.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::angle_between;
use crate::osm::{ElementKind, OsmData, Relation};

use super::features::only_travel;
use super::signal_assignment::arrives;
use super::{End, IntersectionIx, LaneConnection, RoadEnd, RoadIx, RoadNetwork, TurnRestriction, connectivity};

/// Keys of restrictions that bind cars, from the most specific to the least.
const KEYS: [&str; 4] = ["restriction:motorcar", "restriction:motor_vehicle", "restriction:vehicle", "restriction"];

/// A way's direction is taken this far (metres) from the node where it meets another.
const LOOK: f64 = 8.0;

/// Up to this angle (radians) from straight on is no turn.
const STRAIGHT: f64 = std::f64::consts::FRAC_PI_4;

/// More than this angle (radians) from straight on is a U-turn.
const U_TURN: f64 = 2.6;

/// The longest chain of roads between the nodes of `via` ways.
const MOST_VIA: usize = 24;

/// What a network needs to look up the members of relations.
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

/// Reads every restriction and connection of lanes of the data; one that cannot be placed is noted.
pub(super) fn turns(
    osm: &OsmData,
    network: &RoadNetwork,
    notes: &mut Vec<Finding>,
) -> (Vec<TurnRestriction>, Vec<LaneConnection>) {
    let mut lookup = Lookup { network, roads_of_way: FxHashMap::default(), intersection_of_node: FxHashMap::default() };
    for (road, ix) in network.roads.iter().zip(0..) {
        lookup.roads_of_way.entry(road.key.way).or_default().push(RoadIx(ix));
    }
    for (intersection, ix) in network.intersections.iter().zip(0..) {
        lookup.intersection_of_node.extend(intersection.nodes.iter().map(|id| (*id, IntersectionIx(ix))));
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
            Some("restriction") => match lookup.read(relation) {
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
    all.sort_by(|a, b| (a.relation, a.from, a.to, &a.via).cmp(&(b.relation, b.from, b.to, &b.via)));
    all.dedup();
    (all, connections)
}

impl Lookup<'_> {
    fn read(&self, relation: &Relation) -> Result<Vec<TurnRestriction>, &'static str> {
        let value = KEYS.iter().find_map(|key| relation.tags.get(key));
        let Some(value) = value else {
            let conditional = relation.tags.iter().any(|(key, _)| key.ends_with(":conditional"));
            return Err(if conditional { "it holds at some times only" } else { "it does not bind cars" });
        };
        let except = relation.tags.get("except").unwrap_or_default();
        if except.split(';').any(|who| matches!(who.trim(), "motorcar" | "motor_vehicle" | "vehicle")) {
            return Err("cars are excepted");
        }
        let only = value.starts_with("only_");
        if !only && !value.starts_with("no_") {
            return Err("its value is neither no_* nor only_*");
        }
        let members = members(relation);
        let from = self.ends_of_ways(&members.from)?;
        let to = self.ends_of_ways(&members.to)?;
        let turns = match (members.via_nodes.as_slice(), members.via_ways.as_slice()) {
            ([node], []) => self.at_node(*node, &from, &to, value)?,
            ([], []) => return Err("it has no via"),
            ([], ways) => self.over_ways(ways, &from, &to)?,
            _ => return Err("its via is neither one node nor ways"),
        };
        let turn = |(from, via, to)| TurnRestriction { relation: relation.id, from, via, to, only };
        Ok(turns.into_iter().map(turn).collect())
    }

    /// The lanes that a relation connects.
    fn connection(&self, relation: &Relation) -> Result<LaneConnection, &'static str> {
        let lanes = connectivity::lanes(&relation.tags)?;
        let members = members(relation);
        let from = self.ends_of_ways(&members.from)?;
        let to = self.ends_of_ways(&members.to)?;
        let turns = match (members.via_nodes.as_slice(), members.via_ways.as_slice()) {
            ([node], []) => self.at_node(*node, &from, &to, "")?,
            ([], []) => return Err("it has no via"),
            ([], ways) => self.over_ways(ways, &from, &to)?,
            _ => return Err("its via is neither one node nor ways"),
        };
        match turns.as_slice() {
            [(from, _, to)] => Ok(LaneConnection { relation: relation.id, from: *from, to: *to, lanes }),
            _ => Err("its ways pass through its via, and which of their parts are meant is not said"),
        }
    }

    fn ends_of_ways(&self, ways: &[i64]) -> Result<Vec<RoadEnd>, &'static str> {
        let roads: Vec<RoadIx> = ways.iter().filter_map(|way| self.roads_of_way.get(way)).flatten().copied().collect();
        if roads.is_empty() {
            return Err("a way it names is missing or is not driven on");
        }
        Ok(roads.into_iter().flat_map(|road| End::BOTH.map(|end| RoadEnd { road, end })).collect())
    }

    fn place(&self, end: RoadEnd) -> IntersectionIx {
        self.network.road(end.road).intersection(end.end)
    }

    fn arrives(&self, end: RoadEnd) -> bool {
        arrives(self.network.road(end.road), end.end)
    }

    fn leaves(&self, end: RoadEnd) -> bool {
        only_travel(self.network.road(end.road)).is_none_or(|only| only != end.end.inbound())
    }

    /// The turns at a node; where a way passes through it, those that turn as the value says.
    fn at_node(&self, node: i64, from: &[RoadEnd], to: &[RoadEnd], value: &str) -> Result<Turns, &'static str> {
        let at = self.intersection_of_node.get(&node).ok_or("its via is not where roads meet")?;
        let from: Vec<RoadEnd> =
            from.iter().copied().filter(|end| self.place(*end) == *at && self.arrives(*end)).collect();
        let to: Vec<RoadEnd> = to.iter().copied().filter(|end| self.place(*end) == *at && self.leaves(*end)).collect();
        if from.is_empty() || to.is_empty() {
            return Err("no traffic can go from its first way to its last over its via");
        }
        let pairs = from.iter().flat_map(|f| to.iter().map(move |t| (*f, *t)));
        let mut turns: Vec<(RoadEnd, RoadEnd)> = pairs.collect();
        let several_members = value.ends_with("_entry") || value.ends_with("_exit");
        if turns.len() > 1 && !several_members {
            turns.retain(|(from, to)| self.turns_as(value, *from, *to));
        }
        if turns.is_empty() {
            return Err("its ways pass through its via, and no turn there is as it says");
        }
        Ok(turns.into_iter().map(|(from, to)| (from, Vec::new(), to)).collect())
    }

    /// Whether the turn between two road ends at one intersection is what the value names.
    fn turns_as(&self, value: &str, from: RoadEnd, to: RoadEnd) -> bool {
        let outward = |end: RoadEnd| {
            let line = &self.network.road(end.road).line;
            match end.end {
                End::Start => line.at(LOOK) - line.first(),
                End::End => line.at(line.length() - LOOK) - line.last(),
            }
        };
        let angle = if from == to { std::f64::consts::PI } else { angle_between(-outward(from), outward(to)) };
        match value.split_once('_').map(|(_, turn)| turn) {
            Some("left_turn") => angle > 0.0 && from != to,
            Some("right_turn") => angle < 0.0,
            Some("straight_on") => angle.abs() <= STRAIGHT,
            Some("u_turn") => angle.abs() >= U_TURN,
            _ => true,
        }
    }

    /// The turns over a chain of roads that uses every `via` way.
    fn over_ways(&self, via: &[i64], from: &[RoadEnd], to: &[RoadEnd]) -> Result<Turns, &'static str> {
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
        // Ways that touch the via ways more than once: the shortest chain is meant.
        let shortest = turns.iter().map(|(_, chain, _)| chain.len()).min();
        turns.retain(|(_, chain, _)| Some(chain.len()) == shortest);
        if turns.is_empty() { Err("its ways do not form a chain") } else { Ok(turns) }
    }

    /// The shortest chain of roads of the `via` ways, in their order, from one road end to another.
    fn chain(&self, via: &[i64], start: RoadEnd, end: RoadEnd) -> Option<Vec<RoadIx>> {
        let goal = self.place(end);
        // Places reached, each with the chain there and how many of the ways it has used.
        let mut front = vec![(self.place(start), Vec::new(), 0)];
        for _ in 0..MOST_VIA {
            let mut next = Vec::new();
            for (place, chain, used) in &front {
                for (index, way) in via.iter().enumerate().take(used + 1).skip(usize::saturating_sub(*used, 1)) {
                    for road in self.roads_of_way.get(way).into_iter().flatten() {
                        let Some(reached) = self.step(*road, *place).filter(|_| !chain.contains(road)) else {
                            continue;
                        };
                        let mut chain: Vec<RoadIx> = chain.clone();
                        chain.push(*road);
                        if reached == goal && index + 1 == via.len() {
                            return Some(chain);
                        }
                        next.push((reached, chain, index + 1));
                    }
                }
            }
            next.sort();
            next.dedup_by_key(|(place, _, used)| (*place, *used));
            front = next;
        }
        None
    }

    /// Where a road leads from a place, if traffic may take it that way.
    fn step(&self, road: RoadIx, place: IntersectionIx) -> Option<IntersectionIx> {
        let ways = [(End::Start, End::End), (End::End, End::Start)];
        ways.into_iter().find_map(|(enter, leave)| {
            let (enter, leave) = (RoadEnd { road, end: enter }, RoadEnd { road, end: leave });
            (self.place(enter) == place && self.leaves(enter)).then(|| self.place(leave))
        })
    }
}

/// From, what lies between, to.
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
