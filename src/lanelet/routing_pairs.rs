//! Who may go from which lanelet to which, by Lanelet2's own routing graph (1.2.3), for each participant that it knows.
//!
//! The plain list of all pairs, for comparing two maps. Rules ask `index`.

use rustc_hash::FxHashMap;

use super::lane_change::{LaneChange, Participant};
use super::{Bound, Lanelet, LaneletId, LaneletMap, LineStringId, PointId};

/// The participants that Lanelet2 has names for.
pub const PARTICIPANTS: [&str; 8] = [
    "vehicle",
    "vehicle:bus",
    "vehicle:truck",
    "vehicle:car",
    "vehicle:taxi",
    "vehicle:emergency",
    "pedestrian",
    "bicycle",
];

/// How one may go from a lanelet to another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Relation {
    /// A lanelet may be used at all; both lanelets of the pair are the same.
    Pass,
    /// On from its end.
    Following,
    /// To the left, by a lane change.
    Left,
    /// To the right, by a lane change.
    Right,
    /// It lies to the left, over a bound that may not be crossed.
    AdjacentLeft,
    /// It lies to the right, over a bound that may not be crossed.
    AdjacentRight,
}

impl Relation {
    /// In words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Pass => "the way",
            Self::Following => "the way on",
            Self::Left => "a lane change to the left",
            Self::Right => "a lane change to the right",
            Self::AdjacentLeft => "a closed border on the left",
            Self::AdjacentRight => "a closed border on the right",
        }
    }
}

/// A lanelet in one of its directions.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Directed {
    /// The lanelet.
    pub lanelet: LaneletId,
    /// Whether it is used against its direction.
    pub inverted: bool,
}

/// One edge of the graph.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Pair {
    /// Of [`PARTICIPANTS`].
    pub who: &'static str,
    /// What leads from one to the other.
    pub relation: Relation,
    /// The one.
    pub from: Directed,
    /// The other.
    pub to: Directed,
}

/// Subtypes of lanelets with the participants that Lanelet2 lets in where no tag names any.
const ADMITTED: [(&str, &[&str]); 12] = [
    ("", &["vehicle"]),
    ("road", &["vehicle", "bicycle"]),
    ("highway", &["vehicle"]),
    ("bicycle_lane", &["bicycle"]),
    ("play_street", &["pedestrian", "bicycle", "vehicle"]),
    ("bus_lane", &["vehicle:bus", "vehicle:emergency", "vehicle:taxi"]),
    ("emergency_lane", &["vehicle:emergency"]),
    ("exit", &["pedestrian", "bicycle", "vehicle"]),
    ("walkway", &["pedestrian"]),
    ("crosswalk", &["pedestrian"]),
    ("stairs", &["pedestrian"]),
    ("shared_walkway", &["pedestrian", "bicycle"]),
];

/// The value of the tag `KEY` or `KEY:participant` that Lanelet2 finds first; `None` if no tag begins with the key, and `otherwise`
/// if none of these is for the participant, or its value means neither yes nor no.
fn said(lanelet: &Lanelet, key: &str, who: &str, otherwise: bool) -> Option<bool> {
    let mut named: Vec<(&str, &str)> = lanelet.attributes.iter().filter(|(name, _)| name.starts_with(key)).collect();
    named.sort_unstable();
    let own = |name: &str| {
        name.strip_prefix(key)
            .is_some_and(|rest| rest.is_empty() || rest.strip_prefix(':').is_some_and(|of| who.starts_with(of)))
    };
    let value = named.iter().find(|(name, _)| own(name)).map(|(_, value)| *value);
    (!named.is_empty()).then_some(match value {
        Some("yes" | "true" | "1") => true,
        Some("no" | "false" | "0") => false,
        _ => otherwise,
    })
}

/// Whether a participant may use a lanelet.
pub fn may_pass(lanelet: &Lanelet, who: &str) -> bool {
    said(lanelet, "participant", who, false).unwrap_or_else(|| {
        let subtype = lanelet.attributes.get("subtype").unwrap_or_default();
        let admitted = ADMITTED.iter().find(|(known, _)| *known == subtype);
        admitted.is_some_and(|(_, groups)| groups.iter().any(|group| who.starts_with(group)))
    })
}

/// Whether a participant may use a lanelet in its direction alone.
pub fn is_one_way(lanelet: &Lanelet, who: &str) -> bool {
    said(lanelet, "one_way", who, true).unwrap_or(who != "pedestrian")
}

type Side = (LineStringId, bool);

/// A lanelet in one direction, with its ends and sides.
struct Vertex {
    directed: Directed,
    start: [PointId; 2],
    end: [PointId; 2],
    left: Bound,
    right: Bound,
}

impl Vertex {
    fn of(map: &LaneletMap, lanelet: &Lanelet, inverted: bool) -> Option<Self> {
        let turned = |bound: Bound| Bound { inverted: !bound.inverted, ..bound };
        let [left, right] = match inverted {
            false => [lanelet.left, lanelet.right],
            true => [turned(lanelet.right), turned(lanelet.left)],
        };
        let ends = |bound: Bound| {
            let points = &map.linestrings.get(bound.line)?.points;
            let (first, last) = (*points.first()?, *points.last()?);
            Some(if bound.inverted { [last, first] } else { [first, last] })
        };
        let ([a, b], [c, d]) = (ends(left)?, ends(right)?);
        Some(Self { directed: Directed { lanelet: lanelet.id, inverted }, start: [a, c], end: [b, d], left, right })
    }
}

/// All pairs, sorted. Where several lanelets lie beside one on the same side, all are listed; the library's queries name one.
pub fn routing_pairs(map: &LaneletMap) -> Vec<Pair> {
    let mut pairs: Vec<Pair> = PARTICIPANTS.into_iter().flat_map(|who| pairs_of(map, who)).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

fn pairs_of(map: &LaneletMap, who: &'static str) -> Vec<Pair> {
    let kind = match who {
        "pedestrian" => Participant::Pedestrian,
        "bicycle" => Participant::Bicycle,
        _ => Participant::Vehicle,
    };
    let mut vertices: Vec<Vertex> = Vec::new();
    for lanelet in map.lanelets.iter().filter(|lanelet| may_pass(lanelet, who)) {
        vertices.extend(Vertex::of(map, lanelet, false));
        if !is_one_way(lanelet, who) {
            vertices.extend(Vertex::of(map, lanelet, true));
        }
    }
    let mut by_start: FxHashMap<[PointId; 2], Vec<&Vertex>> = FxHashMap::default();
    let mut by_left: FxHashMap<Side, Vec<&Vertex>> = FxHashMap::default();
    let mut by_right = by_left.clone();
    let side = |bound: Bound| (bound.line, bound.inverted);
    for vertex in &vertices {
        by_start.entry(vertex.start).or_default().push(vertex);
        by_left.entry(side(vertex.left)).or_default().push(vertex);
        by_right.entry(side(vertex.right)).or_default().push(vertex);
    }
    let mut pairs = Vec::new();
    for vertex in &vertices {
        let from = vertex.directed;
        let mut add = |relation, to| pairs.push(Pair { who, relation, from, to });
        add(Relation::Pass, from);
        for next in by_start.get(&vertex.end).into_iter().flatten() {
            if next.directed.lanelet != from.lanelet || next.directed == from {
                add(Relation::Following, next.directed);
            }
        }
        let sides = [
            (vertex.left, &by_right, [Relation::Left, Relation::AdjacentLeft]),
            (vertex.right, &by_left, [Relation::Right, Relation::AdjacentRight]),
        ];
        for (bound, others, [change, adjacent]) in sides {
            let over = LaneChange::over(map, bound, kind);
            let is_open = if change == Relation::Left { over.to_left } else { over.to_right };
            for other in others.get(&side(bound)).into_iter().flatten() {
                if other.directed.lanelet != from.lanelet {
                    add(if is_open { change } else { adjacent }, other.directed);
                }
            }
        }
    }
    pairs
}
