//! Tags that drivers obey on the ways of a random town: access by direction, buses against one-way streets, lanes beside lanes, closed
//! ways and nodes, limits, and turn restrictions over one way or several.

use super::dice::Dice;
use super::plan::{Plan, Restriction};

/// Tags for roads with both directions.
const BOTH_WAYS: [&str; 28] = [
    "motor_vehicle:backward=no",
    "vehicle:forward=no",
    "access=no access:forward=yes",
    "motor_vehicle:backward=no bus:backward=yes",
    "oneway=reversible",
    "lanes=3 busway:left=lane",
    "lanes=4 bus:lanes:forward=|designated",
    "lanes=3 lanes:forward=2 bicycle:lanes:forward=|designated| cycleway:left=no",
    "smoothness=impassable",
    "impassable=yes",
    "service=emergency_access",
    "maxspeed:motorcar=30 maxspeed=50",
    "maxspeed:advisory=40",
    "maxspeed=DE:urban",
    "access:backward=no",
    "motorcar:forward=no",
    "vehicle=no vehicle:forward=yes",
    "oneway=alternating",
    "motor_vehicle=private",
    "lanes=2 bus:lanes=|designated",
    "lanes=3 lanes:backward=1 bus:lanes=||designated",
    "lanes=3 lanes:bus:both_ways=1",
    "lanes=2 busway=opposite_lane",
    "lanes=2 turn:lanes=left|right",
    "lanes=3 lanes:backward=1 width:lanes=4|3|3",
    "disused=yes",
    "abandoned=yes",
    "maxspeed=JP:national",
];
/// Tags for one-way roads.
const ONE_WAY: [&str; 19] = [
    "oneway:bus=no",
    "oneway:psv=no lanes=3 lanes:forward=2 lanes:backward=1",
    "busway=opposite_lane",
    "busway:left=lane busway:left:oneway=-1",
    "busway:right=lane busway:right:oneway=-1",
    "psv=opposite_lane",
    "lanes:bus:backward=1",
    "motorcar:forward=no bus=yes",
    "motor_vehicle:backward=yes",
    "maxspeed:lanes=50|30",
    "change:lanes=no|yes",
    "oneway:psv=no lanes=2 psv:lanes=designated|no",
    "oneway:psv=no lanes=3 psv:lanes=designated||designated",
    "oneway:bus=no lanes=2 busway:right=lane",
    "oneway:bus=no lanes=1",
    "lanes=2 lanes:bus:both_ways=1",
    "lanes=2 busway=opposite_track",
    "lanes=2 bus:lanes:backward=designated",
    "vehicle:forward=no",
];
/// Tags for nodes in the middle of ways.
const NODES: [&str; 8] = [
    "barrier=bollard",
    "barrier=bollard bus=yes",
    "barrier=bollard bollard=rising",
    "barrier=bus_trap",
    "barrier=gate access=private",
    "access=no",
    "motor_vehicle:forward=no",
    "motor_vehicle:backward=no",
];
/// What a turn restriction may say.
const RESTRICTIONS: [&str; 9] = [
    "no_left_turn",
    "no_right_turn",
    "no_straight_on",
    "no_u_turn",
    "only_straight_on",
    "only_left_turn",
    "no_right_turn_on_red",
    "no_entry",
    "no_turn_whatever",
];

impl Plan {
    /// Gives some of its ways such tags, and restricts some of the turns between them.
    pub fn obey(&mut self, dice: &mut Dice) {
        for way in &mut self.ways {
            let is_street = way.tags.starts_with("highway") && !way.tags.contains("junction=");
            if is_street && dice.chance(0.25) {
                let more = if way.tags.contains("oneway=yes") { dice.pick(&ONE_WAY) } else { dice.pick(&BOTH_WAYS) };
                // The last of two values counts in none: the added key takes the place of the old one.
                let added = |tag: &str| more.split(' ').any(|new| new.split('=').next() == tag.split('=').next());
                let kept: Vec<&str> = way.tags.split_whitespace().filter(|tag| !added(tag)).collect();
                way.tags = format!("{} {more}", kept.join(" "));
            }
        }
        self.bar(dice);
        for from in 0..self.ways.len() {
            if !dice.chance(0.2) {
                continue;
            }
            let mut chain = vec![from];
            for _ in 0..1 + dice.below(4) {
                let Some(last) = chain.last().and_then(|way| self.ways[*way].nodes.last()) else { break };
                let next = (0..self.ways.len()).filter(|way| !chain.contains(way) && self.ways[*way].nodes[0] == *last);
                let next: Vec<usize> = next.collect();
                if next.is_empty() {
                    break;
                }
                chain.push(dice.pick(&next));
            }
            if chain.len() > 1 {
                let node = (chain.len() == 2).then(|| self.ways[from].nodes.last().copied()).flatten();
                self.restrictions.push(Restriction { ways: chain, node, value: dice.pick(&RESTRICTIONS) });
            }
        }
    }
    /// Closes or half closes some nodes in the middle of ways.
    fn bar(&mut self, dice: &mut Dice) {
        let mut uses = vec![0; self.nodes.len()];
        self.ways.iter().flat_map(|way| &way.nodes).for_each(|node| uses[*node] += 1);
        for way in &self.ways {
            let inner = way.nodes.get(1..way.nodes.len() - 1).unwrap_or_default();
            let Some(node) = inner.iter().find(|node| uses[**node] == 1 && self.nodes[**node].tags.is_empty()) else {
                continue;
            };
            if way.tags.starts_with("highway") && dice.chance(0.15) {
                self.nodes[*node].tags = dice.pick(&NODES).to_owned();
            }
        }
    }
}
