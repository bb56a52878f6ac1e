//! What is said of turns, as what it means for single ones: a lanelet graph knows no other.
//!
//! A restriction over `via` roads forbids a way through several intersections. It becomes the prohibition of one turn
//! on that way where nobody but those whom it means makes that turn; where others do, nothing is forbidden to them,
//! and a note says that the map is more liberal than the street.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};

use super::road_end::{leads_in, leads_out, other_end};
use super::{End, Intersection, RoadEnd, RoadNetwork, TurnRestriction, cross};

/// Which turns are restricted, by where they begin, and which lanes take them.
#[derive(Debug, Default)]
pub struct ResolvedRestrictions {
    of: FxHashMap<RoadEnd, Vec<Turn>>,
    lanes: FxHashMap<[RoadEnd; 2], Vec<[usize; 2]>>,
    /// Whether every lane leads to all lanes of the road that it turns into.
    pub fan_out: bool,
}

/// What one restriction says of those who arrive on one road.
#[derive(Clone, Copy, Debug)]
struct Turn {
    to: RoadEnd,
    /// Every other turn is prohibited, instead of this one.
    only: bool,
}

impl ResolvedRestrictions {
    /// Reads the restrictions of a network; those that single turns cannot express are noted.
    pub fn new(network: &RoadNetwork) -> (Self, Vec<Finding>) {
        let mut found = Self { fan_out: network.fan_out, ..Self::default() };
        for connection in &network.connections {
            found.lanes.entry([connection.from, connection.to]).or_default().extend(&connection.lanes);
        }
        // What several relations, or a file of streets, say of the same two roads can be meant only as a whole.
        found.lanes.values_mut().for_each(|lanes| lanes.sort_unstable());
        found.lanes.retain(|_, lanes| !cross(lanes));
        for r in network.restrictions.iter().filter(|r| r.via.is_empty()) {
            found.add(r.from, r.to, r.only);
        }
        let mut notes = Vec::new();
        // Each chain is judged by the turns at nodes alone, so that their order does not matter.
        let chains: Vec<Chain> = network.restrictions.iter().filter_map(|r| Chain::of(network, r)).collect();
        let expressed: Vec<Expressed> = chains.iter().map(|chain| chain.as_turns(network, &found)).collect();
        for (chain, Expressed { turns, whole }) in chains.iter().zip(expressed) {
            turns.into_iter().for_each(|(from, to)| found.add(from, to, chain.restriction.only));
            if !whole {
                notes.push(chain.note(network));
            }
        }
        (found, notes)
    }

    fn add(&mut self, from: RoadEnd, to: RoadEnd, only: bool) {
        self.of.entry(from).or_default().push(Turn { to, only });
    }

    /// Whether the restrictions and, in a merged intersection, the roads inside let one go from one arm to the other.
    pub fn permit(&self, intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
        self.allow(from, to) && is_passable(intersection, from, to)
    }

    /// The same for bicycles, which have lanes of their own against the traffic.
    pub fn permit_bicycles(&self, intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
        self.allow(from, to) && (is_passable(intersection, from, to) || is_passable(intersection, to, from))
    }

    fn allow(&self, from: RoadEnd, to: RoadEnd) -> bool {
        let turns = self.of.get(&from).map_or(&[][..], Vec::as_slice);
        let forbidden = turns.iter().any(|turn| !turn.only && turn.to == to);
        let mut mandatory = turns.iter().filter(|turn| turn.only).peekable();
        let elsewhere = mandatory.peek().is_some() && mandatory.all(|turn| turn.to != to);
        !forbidden && !elsewhere
    }

    /// Whether any turn between these arms of an intersection is restricted, or told by lanes.
    pub fn concern(&self, arms: &[RoadEnd]) -> bool {
        let arms = || arms.iter().copied();
        let told = |from: RoadEnd| arms().any(|to| self.lanes.contains_key(&[from, to]));
        arms().any(|at| self.of.contains_key(&at)) || !self.lanes.is_empty() && arms().any(told)
    }

    /// The lanes that lead from one arm to the other, where that is told: pairs, each counted from 1 on the left.
    pub fn lanes(&self, from: RoadEnd, to: RoadEnd) -> Option<&[[usize; 2]]> {
        self.lanes.get(&[from, to]).map(Vec::as_slice)
    }

    /// Where those come from who leave over this road end, or go on to who arrive on it.
    fn neighbours<'a>(
        &'a self,
        network: &'a RoadNetwork,
        at: RoadEnd,
        before: bool,
    ) -> impl Iterator<Item = RoadEnd> + 'a {
        let intersection = network.intersection(network.road(at.road).intersection(at.end));
        intersection.arms.iter().copied().filter(move |&other| {
            let (from, to) = if before { (other, at) } else { (at, other) };
            from.road != to.road
                && leads_in(network, from)
                && leads_out(network, to)
                && self.permit(intersection, from, to)
        })
    }
}

/// Whether the roads inside a merged intersection lead from one arm to the other.
fn is_passable(intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
    intersection.passages.as_ref().is_none_or(|passages| passages.contains(&(from, to)))
}

/// A restriction over `via` roads as the turns on its way: from, to.
struct Chain<'a> {
    restriction: &'a TurnRestriction,
    turns: Vec<(RoadEnd, RoadEnd)>,
}

/// What single turns can say of a restriction.
struct Expressed {
    turns: Vec<(RoadEnd, RoadEnd)>,
    /// Whether that is all it says.
    whole: bool,
}

impl<'a> Chain<'a> {
    /// `None` for a restriction at a node, and where the roads do not form a chain.
    fn of(network: &RoadNetwork, restriction: &'a TurnRestriction) -> Option<Self> {
        let place = |at: RoadEnd| network.road(at.road).intersection(at.end);
        let mut turns = Vec::new();
        let mut from = restriction.from;
        for &road in &restriction.via {
            let ends = End::BOTH;
            let departures = ends.map(|end| RoadEnd { road, end });
            let to = departures.into_iter().find(|&to| place(to) == place(from) && leads_out(network, to))?;
            turns.push((from, to));
            from = other_end(to);
        }
        let closed = !turns.is_empty() && place(from) == place(restriction.to);
        turns.push((from, restriction.to));
        closed.then_some(Self { restriction, turns })
    }

    /// The single turns to restrict, so that nobody is bound whom the restriction does not mean.
    fn as_turns(&self, network: &RoadNetwork, at_nodes: &ResolvedRestrictions) -> Expressed {
        let lone = |at: RoadEnd, before: bool, other: RoadEnd| {
            at_nodes.neighbours(network, at, before).all(|neighbour| neighbour == other)
        };
        // How many turns from the first on are made only by those who come the way of the restriction.
        let own = 1 + self.turns.windows(2).take_while(|w| lone(w[0].1, true, w[0].0)).count();
        if self.restriction.only {
            let whole = self.turns[own..].iter().all(|&(from, to)| lone(from, false, to));
            return Expressed { turns: self.turns[..own].to_vec(), whole };
        }
        // How many turns up to the last one leave no choice behind them but the way of the restriction.
        let bound = 1 + self.turns.windows(2).rev().take_while(|w| lone(w[1].0, false, w[1].1)).count();
        let turns: Vec<_> =
            self.turns[..own].iter().skip(self.turns.len() - bound).next_back().copied().into_iter().collect();
        Expressed { whole: !turns.is_empty(), turns }
    }

    fn note(&self, network: &RoadNetwork) -> Finding {
        let way = |at: RoadEnd| network.road(at.road).key.way;
        let TurnRestriction { relation, from, to, only, .. } = *self.restriction;
        let (from, to) = (way(from), way(to));
        let bound = if only { "must go on to" } else { "may not go on to" };
        let message = format!(
            "turn restriction {relation} cannot be built: those who come from way {from} {bound} way {to}, \
             but others make the same turns and may, so the map lets everybody"
        );
        let finding = Finding::new("restriction-not-built", Subject::Relation(relation), message)
            .with(Subject::Way(from), "from")
            .with(Subject::Way(to), "to")
            .graded(Severity::Warning);
        let road = network.road(self.restriction.to.road);
        finding.at(Place::Point(network.intersection(road.intersection(self.restriction.to.end)).position))
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::network::{NetworkOptions, road_network};
    use crate::geometry::Point;
    use crate::osm::{OsmData, read_bytes};
    use crate::projection::LonLat;

    use super::*;

    /// Way 1 arrives from the west at node 2, way 2 leads on to node 3, from where ways 3 and 4 go north and south.
    /// Way 5 comes to node 2 from the south.
    const PLACES: [(i64, f64, f64); 6] =
        [(1, -100.0, 0.0), (2, 0.0, 0.0), (3, 60.0, 0.0), (4, 60.0, 90.0), (5, 60.0, -90.0), (6, 0.0, -90.0)];

    /// The ways that one may take from node 3 after way 2 and from node 2 after way 1, and the notes.
    fn judged(value: &str, fifth: &str) -> (Vec<i64>, Vec<i64>, Vec<&'static str>) {
        let mut xml = String::from("<osm>");
        for (id, x, y) in PLACES {
            xml += &format!("<node id='{id}' lon='{}' lat='{}'/>", x / 1e5, y / 1e5);
        }
        let one_way = "<tag k='oneway' v='yes'/>";
        for (id, a, b, tags) in
            [(1, 1, 2, one_way), (2, 2, 3, one_way), (3, 3, 4, one_way), (4, 3, 5, one_way), (5, 6, 2, fifth)]
        {
            xml += &format!("<way id='{id}'><nd ref='{a}'/><nd ref='{b}'/><tag k='highway' v='primary'/>{tags}</way>");
        }
        let members = [("from", 1), ("via", 2), ("to", 3)];
        let members: String =
            members.iter().map(|(role, way)| format!("<member type='way' ref='{way}' role='{role}'/>")).collect();
        xml += &format!(
            "<relation id='7'>{members}<tag k='type' v='restriction'/><tag k='restriction' v='{value}'/></relation></osm>"
        );
        let mut data = OsmData::default();
        read_bytes(&mut data, "test", xml.into_bytes()).unwrap();
        let plane = |places: &[LonLat]| places.iter().map(|p| Point::new(p.lon * 1e5, p.lat * 1e5)).collect();
        let network = road_network(&data, &plane, &NetworkOptions::default()).unwrap().network;
        let (restricted, notes) = ResolvedRestrictions::new(&network);
        let after = |way: i64| {
            let road = network.roads.iter().position(|r| r.key.way == way).unwrap();
            let from = RoadEnd { road: crate::builder::network::RoadIx::new(road), end: End::End };
            let mut ways: Vec<i64> =
                restricted.neighbours(&network, from, false).map(|to| network.road(to.road).key.way).collect();
            ways.sort_unstable();
            ways
        };
        (after(2), after(1), notes.iter().map(|note| note.fault).collect())
    }

    const AWAY: &str = "<tag k='oneway' v='-1'/>";
    const TOWARD: &str = "<tag k='oneway' v='yes'/>";

    #[test]
    fn a_way_with_one_way_in_is_forbidden_at_its_end() {
        assert_eq!(judged("no_left_turn", AWAY), (vec![4], vec![2, 5], vec![]));
        assert_eq!(judged("only_left_turn", AWAY), (vec![3], vec![2], vec![]));
    }

    #[test]
    fn what_others_may_do_stays_and_is_said() {
        assert_eq!(judged("no_left_turn", TOWARD), (vec![3, 4], vec![2], vec!["restriction-not-built"]));
        assert_eq!(judged("only_left_turn", TOWARD), (vec![3, 4], vec![2], vec!["restriction-not-built"]));
    }
}
