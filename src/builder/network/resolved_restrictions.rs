//! Turn restrictions as prohibitions of single turns, the only ones that a lanelet graph can express.
//!
//! A restriction over `via` roads forbids a path through several intersections. It becomes the prohibition of one turn on
//! that path which no other traffic makes. If other traffic makes them all, nothing is forbidden, and a note says that the map
//! allows more than the street.

use rustc_hash::FxHashMap;

use crate::diagnostic::{Finding, Place, Severity, Subject};

use super::road_end::{leads_in, leads_out, other_end};
use super::{End, Intersection, RoadEnd, RoadNetwork, TurnRestriction, cross};

/// Restricted turns by the road end of arrival, and which lanes lead to which.
#[derive(Debug, Default)]
pub struct ResolvedRestrictions {
    turns: FxHashMap<RoadEnd, Vec<Turn>>,
    lanes: FxHashMap<[RoadEnd; 2], Vec<[usize; 2]>>,
    /// Whether every lane leads to all lanes of the road it turns into.
    pub fan_out: bool,
}

/// A restriction for the traffic of one road end.
#[derive(Clone, Copy, Debug)]
struct Turn {
    to: RoadEnd,
    /// Every other turn is prohibited, instead of this one.
    only: bool,
}

impl ResolvedRestrictions {
    /// The restrictions of a network, with a note for each that single turns cannot express.
    pub fn new(network: &RoadNetwork) -> (Self, Vec<Finding>) {
        let mut found = Self { fan_out: network.fan_out, ..Self::default() };
        for connection in &network.connections {
            found.lanes.entry([connection.from, connection.to]).or_default().extend(&connection.lanes);
        }
        // Several relations, or a GeoJSON file, may connect lanes of the same two roads; those that cross are dropped together.
        found.lanes.values_mut().for_each(|lanes| lanes.sort_unstable());
        found.lanes.retain(|_, lanes| !cross(lanes));
        let mut notes = Vec::new();
        for r in network.restrictions.iter().filter(|r| r.via.is_empty()) {
            if goes_on_for_others(network, r) {
                notes.push(Chain { restriction: r, turns: Vec::new() }.note(network));
            } else {
                found.add(r.from, r.to, r.only);
            }
        }
        // Chains see the turns at nodes only, so that their order does not matter.
        let mut chains = Vec::new();
        for r in network.restrictions.iter().filter(|r| !r.via.is_empty()) {
            match Chain::of(network, r) {
                Ok(chain) => chains.push(chain),
                Err(Broken::Undriven) => {}
                Err(Broken::Torn) => notes.push(Chain { restriction: r, turns: Vec::new() }.note(network)),
            }
        }
        let expressed: Vec<ChainTurns> = chains.iter().map(|chain| chain.as_turns(network, &found)).collect();
        for (chain, ChainTurns { turns, complete }) in chains.iter().zip(expressed) {
            turns.into_iter().for_each(|(from, to)| found.add(from, to, chain.restriction.only));
            if !complete {
                notes.push(chain.note(network));
            }
        }
        (found, notes)
    }

    fn add(&mut self, from: RoadEnd, to: RoadEnd, only: bool) {
        self.turns.entry(from).or_default().push(Turn { to, only });
    }

    /// Whether the restrictions and the inner roads of a merged intersection allow the turn from one arm to another.
    pub fn permit(&self, intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
        self.allow(from, to) && is_passable(intersection, from, to)
    }

    /// As [`Self::permit`] for bicycles, which may have lanes against the traffic.
    pub fn permit_bicycles(&self, intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
        self.allow(from, to) && (is_passable(intersection, from, to) || is_passable(intersection, to, from))
    }

    fn allow(&self, from: RoadEnd, to: RoadEnd) -> bool {
        let turns = self.turns.get(&from).map_or(&[][..], Vec::as_slice);
        let forbidden = turns.iter().any(|turn| !turn.only && turn.to == to);
        let mut mandatory = turns.iter().filter(|turn| turn.only).peekable();
        let elsewhere = mandatory.peek().is_some() && mandatory.all(|turn| turn.to != to);
        !forbidden && !elsewhere
    }

    /// Whether any turn between these arms is restricted, or has its lanes connected by a relation.
    pub fn concern(&self, arms: &[RoadEnd]) -> bool {
        let arms = || arms.iter().copied();
        let is_connected = |from: RoadEnd| arms().any(|to| self.lanes.contains_key(&[from, to]));
        arms().any(|arm| self.turns.contains_key(&arm)) || !self.lanes.is_empty() && arms().any(is_connected)
    }

    /// Which lanes lead from one arm to another if a relation says so: pairs, each counted from 1 on the left.
    pub fn lanes(&self, from: RoadEnd, to: RoadEnd) -> Option<&[[usize; 2]]> {
        self.lanes.get(&[from, to]).map(Vec::as_slice)
    }

    /// The arms from which traffic turns into this arm, or to which traffic from this arm turns.
    fn neighbours<'a>(
        &'a self,
        network: &'a RoadNetwork,
        arm: RoadEnd,
        before: bool,
    ) -> impl Iterator<Item = RoadEnd> + 'a {
        let intersection = network.intersection(network.intersection_at(arm));
        intersection.arms.iter().copied().filter(move |&other| {
            let (from, to) = if before { (other, arm) } else { (arm, other) };
            from.road != to.road
                && leads_in(network, from)
                && leads_out(network, to)
                && self.permit(intersection, from, to)
        })
    }
}

/// Whether a restriction forbids to go on where only two roads meet, and those who come the other way may: the lanes of either
/// direction lie on one road.
fn goes_on_for_others(network: &RoadNetwork, r: &TurnRestriction) -> bool {
    let arms = network.intersection(network.intersection_at(r.from)).arms.len();
    let forbidden = |from: RoadEnd, to: RoadEnd| {
        network
            .restrictions
            .iter()
            .any(|other| !other.only && other.via.is_empty() && (other.from, other.to) == (from, to))
    };
    let back = leads_in(network, r.to) && leads_out(network, r.from);
    arms == 2 && !r.only && r.from.road != r.to.road && back && !forbidden(r.to, r.from)
}

/// Whether the inner roads of a merged intersection lead from one arm to another.
fn is_passable(intersection: &Intersection, from: RoadEnd, to: RoadEnd) -> bool {
    intersection.passages.as_ref().is_none_or(|passages| passages.contains(&(from, to)))
}

/// A restriction over `via` roads as the turns (from, to) along its path.
struct Chain<'a> {
    restriction: &'a TurnRestriction,
    turns: Vec<(RoadEnd, RoadEnd)>,
}

/// Why the roads of a restriction are no path.
enum Broken {
    /// They do not join each other.
    Torn,
    /// Nobody drives one of them that way, as after the lanes of a link are left out that nobody may enter: nothing is left to forbid.
    Undriven,
}

/// The single turns that express a restriction.
struct ChainTurns {
    turns: Vec<(RoadEnd, RoadEnd)>,
    /// Whether they express all of it.
    complete: bool,
}

impl<'a> Chain<'a> {
    /// The chain of a restriction over roads.
    fn of(network: &RoadNetwork, restriction: &'a TurnRestriction) -> Result<Self, Broken> {
        let mut turns = Vec::new();
        let mut from = restriction.from;
        for &road in &restriction.via {
            let here = network.intersection_at(from);
            let departures = End::BOTH.map(|end| RoadEnd { road, end });
            let mut ends = departures.into_iter().filter(|&to| network.intersection_at(to) == here).peekable();
            ends.peek().ok_or(Broken::Torn)?;
            let to = ends.find(|&to| leads_out(network, to)).ok_or(Broken::Undriven)?;
            turns.push((from, to));
            from = other_end(to);
        }
        let closed = !turns.is_empty() && network.intersection_at(from) == network.intersection_at(restriction.to);
        turns.push((from, restriction.to));
        closed.then_some(Self { restriction, turns }).ok_or(Broken::Torn)
    }

    /// The single turns to restrict without binding other traffic.
    fn as_turns(&self, network: &RoadNetwork, at_nodes: &ResolvedRestrictions) -> ChainTurns {
        let lone = |arm: RoadEnd, before: bool, other: RoadEnd| {
            at_nodes.neighbours(network, arm, before).all(|neighbour| neighbour == other)
        };
        // How many turns, counted from the first, only traffic on the restricted path makes.
        let own = 1 + self.turns.windows(2).take_while(|w| lone(w[0].1, true, w[0].0)).count();
        if self.restriction.only {
            let complete = self.turns[own..].iter().all(|&(from, to)| lone(from, false, to));
            return ChainTurns { turns: self.turns[..own].to_vec(), complete };
        }
        // How many turns, counted back from the last, leave no other choice than the restricted path.
        let bound = 1 + self.turns.windows(2).rev().take_while(|w| lone(w[1].0, false, w[1].1)).count();
        // The first of these, so that nobody drives into a road that only leads on over the forbidden turn.
        let turns: Vec<_> = self.turns[..own].iter().skip(self.turns.len() - bound).take(1).copied().collect();
        ChainTurns { complete: !turns.is_empty(), turns }
    }

    fn note(&self, network: &RoadNetwork) -> Finding {
        let way = |arm: RoadEnd| network.road(arm.road).key.way;
        let TurnRestriction { relation, from, to, only, .. } = *self.restriction;
        let (from, to) = (way(from), way(to));
        let bound = if only { "must go on to" } else { "may not go on to" };
        let others = match self.restriction.via.is_empty() {
            true => "the road goes on there for those who come the other way",
            false => "others make the same turns and may",
        };
        let message = format!(
            "turn restriction {relation} cannot be built: those who come from way {from} {bound} way {to}, \
             but {others}, so the map lets everybody"
        );
        let finding = Finding::new("restriction-not-built", Subject::Relation(relation), message)
            .with(Subject::Way(from), "from")
            .with(Subject::Way(to), "to")
            .graded(Severity::Warning);
        let last = network.intersection_at(self.restriction.to);
        finding.at(Place::Point(network.intersection(last).position))
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::network::RoadIx;
    use crate::builder::network::hand_drawn::{network, osm, restrict};
    use crate::builder::tags::cross_section::StripKind;

    use super::*;

    /// Way 1 arrives from the west at node 2, way 2 leads on to node 3, from where ways 3 and 4 go north and south.
    /// Way 5 comes to node 2 from the south.
    const NODES: [(i64, f64, f64, &str); 6] = [
        (1, -100.0, 0.0, ""),
        (2, 0.0, 0.0, ""),
        (3, 60.0, 0.0, ""),
        (4, 60.0, 90.0, ""),
        (5, 60.0, -90.0, ""),
        (6, 0.0, -90.0, ""),
    ];

    /// The ways permitted from node 3 after way 2 and from node 2 after way 1, and the notes.
    fn permitted(value: &str, fifth: &str) -> (Vec<i64>, Vec<i64>, Vec<&'static str>) {
        let ways: [(i64, &[i64], &str); 5] = [
            (1, &[1, 2], TOWARD),
            (2, &[2, 3], TOWARD),
            (3, &[3, 4], TOWARD),
            (4, &[3, 5], TOWARD),
            (5, &[6, 2], fifth),
        ];
        let mut data = osm(&NODES, &ways);
        restrict(&mut data, 7, &format!("restriction={value}"), &[("from", 'w', 1), ("via", 'w', 2), ("to", 'w', 3)]);
        let network = network(&data);
        let (restrictions, notes) = ResolvedRestrictions::new(&network);
        let after = |way: i64| {
            let road = network.roads.iter().position(|r| r.key.way == way).unwrap();
            let from = RoadEnd { road: RoadIx::new(road), end: End::End };
            let mut ways: Vec<i64> =
                restrictions.neighbours(&network, from, false).map(|to| network.road(to.road).key.way).collect();
            ways.sort_unstable();
            ways
        };
        (after(2), after(1), notes.iter().map(|note| note.fault).collect())
    }

    const AWAY: &str = "highway=primary oneway=-1";
    const TOWARD: &str = "highway=primary oneway=yes";

    #[test]
    fn a_path_with_one_entry_is_forbidden_at_its_end() {
        assert_eq!(permitted("no_left_turn", AWAY), (vec![4], vec![2, 5], vec![]));
        assert_eq!(permitted("only_left_turn", AWAY), (vec![3], vec![2], vec![]));
    }

    #[test]
    fn nobody_drives_into_a_link_from_which_the_only_way_on_is_forbidden() {
        // Way 2 leads to way 3 only.
        let ways: [(i64, &[i64], &str); 4] =
            [(1, &[1, 2], TOWARD), (2, &[2, 3], TOWARD), (3, &[3, 4], TOWARD), (5, &[2, 6], TOWARD)];
        let mut data = osm(&NODES, &ways);
        restrict(&mut data, 7, "restriction=no_u_turn", &[("from", 'w', 1), ("via", 'w', 2), ("to", 'w', 3)]);
        let network = network(&data);
        let (restrictions, notes) = ResolvedRestrictions::new(&network);
        let road = |way: i64| RoadIx::new(network.roads.iter().position(|road| road.key.way == way).unwrap());
        let from = RoadEnd { road: road(1), end: End::End };
        let onto: Vec<i64> =
            restrictions.neighbours(&network, from, false).map(|to| network.road(to.road).key.way).collect();
        assert_eq!((onto, notes.len()), (vec![5], 0));
        // Its lanes are left out then, and nothing is left to forbid.
        let link = road(2);
        let mut without = network;
        without.roads[link].section.strips.iter_mut().for_each(|strip| strip.kind = StripKind::Buffer);
        assert_eq!(ResolvedRestrictions::new(&without).1.len(), 0);
    }

    #[test]
    fn a_joint_is_closed_only_where_nobody_else_goes_on() {
        let nodes = [(1, -100.0, 0.0, ""), (2, 0.0, 0.0, ""), (3, 100.0, 0.0, "")];
        let closed = |tags: &str, both: bool| {
            let mut data = osm(&nodes, &[(1, &[1, 2], tags), (2, &[2, 3], tags)]);
            for (id, [from, to]) in [(7, [1, 2]), (8, [2, 1])].into_iter().take(1 + usize::from(both)) {
                restrict(
                    &mut data,
                    id,
                    "restriction=no_entry",
                    &[("from", 'w', from), ("via", 'n', 2), ("to", 'w', to)],
                );
            }
            let network = network(&data);
            let (restrictions, notes) = ResolvedRestrictions::new(&network);
            let at = |way: i64, end| RoadEnd {
                road: RoadIx::new(network.roads.iter().position(|road| road.key.way == way).unwrap()),
                end,
            };
            let permitted = restrictions.allow(at(1, End::End), at(2, End::Start));
            (!permitted, notes.iter().map(|note| note.fault).collect::<Vec<_>>())
        };
        assert_eq!(closed("highway=residential", false), (false, vec!["restriction-not-built"]));
        assert_eq!(closed("highway=residential", true), (true, vec![]));
        assert_eq!(closed(TOWARD, false), (true, vec![]));
    }

    #[test]
    fn turns_of_other_traffic_stay_with_a_note() {
        assert_eq!(permitted("no_left_turn", TOWARD), (vec![3, 4], vec![2], vec!["restriction-not-built"]));
        assert_eq!(permitted("only_left_turn", TOWARD), (vec![3, 4], vec![2], vec!["restriction-not-built"]));
    }
}
