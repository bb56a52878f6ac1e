//! Whom the intersection module watches: the conflicting lanelets and those before them, less those that it may ignore.

use std::collections::BTreeMap;

use serde::Serialize;

use super::params::Params;
use super::road_network::RoadNetwork;
use crate::lanelet::{LaneletId, RegulatoryElementId, TurnDirection};

/// Whom the module watches on one lanelet. Lanelets go by their position in the road network.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attention {
    /// The lanelet before, and all that start where this one starts: never watched.
    pub own: Vec<usize>,
    /// The lanelets that conflict with this one, less its own, in file order.
    pub conflicting: Vec<usize>,
    /// Those of them that are watched.
    pub watched: Vec<usize>,
    /// Those that are ignored, each with the reason.
    pub ignored: Vec<Ignored>,
}

/// A conflicting lanelet that the module ignores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ignored {
    /// Its position in the road network.
    pub lanelet: usize,
    /// Why.
    pub reason: Reason,
}

/// Why a conflicting lanelet is ignored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(tag = "because", content = "element", rename_all = "snake_case")]
pub enum Reason {
    /// A `right_of_way` element of the lanelet lists it as `yield`.
    RightOfWay(RegulatoryElementId),
    /// It leads to a lanelet that such an element lists.
    BeforeYield(RegulatoryElementId),
    /// The lanelet goes straight on and has a light with a stop line: then nobody is watched.
    StraightWithLight(RegulatoryElementId),
}

/// How far upstream of a watched lanelet the module looks.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach {
    /// The lanelets before it, in file order.
    pub before: Vec<usize>,
    /// Where no lanelet leads on before the length is reached.
    pub ends: Vec<AttentionEnd>,
}

/// A begin of the road network that cuts an attention area short.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AttentionEnd {
    /// The lanelet that begins there, by its position; the watched one itself where none is before it.
    pub lanelet: usize,
    /// Metres from its begin to the watched lanelet.
    pub after: f64,
}

impl RoadNetwork<'_, '_> {
    /// Whom the intersection module watches on a lanelet.
    pub fn attention(&self, at: usize, params: &Params) -> Attention {
        self.attention_among(at, self.graph.conflicting(at), params)
    }

    /// Whether the module watches one lanelet on another.
    pub fn watches(&self, at: usize, other: usize, params: &Params) -> bool {
        let attention = match params.consider_wrong_direction_vehicle {
            true => self.attention(at, params),
            false if self.graph.conflict(at, other) => self.attention_among(at, vec![other], params),
            false => return false,
        };
        attention.watched.contains(&other)
    }

    /// Whom it watches, where it is known which lanelets conflict with it.
    pub fn attention_among(&self, at: usize, conflicting: Vec<usize>, params: &Params) -> Attention {
        let mut own: Vec<usize> = Vec::new();
        for before in self.graph.previous(at) {
            own.push(before);
            own.extend(self.graph.following(before));
        }
        own.sort_unstable();
        own.dedup();
        let yields = self.yields(at);
        let light = self.light(at).filter(|_| self.turn(at) == Some(TurnDirection::Straight));
        let conflicting = conflicting.into_iter().filter(|other| own.binary_search(other).is_err());
        let mut found = Attention { conflicting: conflicting.collect(), own, ..Attention::default() };
        for &lanelet in &found.conflicting {
            let reason = light.map(|light| Reason::StraightWithLight(light.id)).or(yields.get(&lanelet).copied());
            match reason {
                Some(reason) => found.ignored.push(Ignored { lanelet, reason }),
                None => found.watched.push(lanelet),
            }
        }
        if params.consider_wrong_direction_vehicle && light.is_none() {
            let beside = found
                .conflicting
                .iter()
                .flat_map(|&one| self.graph.following(one).into_iter().chain(self.graph.previous(one)));
            found.watched.extend(beside.collect::<Vec<_>>());
            found.watched.sort_unstable();
            found.watched.dedup();
        }
        found
    }

    /// What the elements of a lanelet that list it as having the right of way let it ignore.
    fn yields(&self, at: usize) -> BTreeMap<usize, Reason> {
        let mut yields = BTreeMap::new();
        let id = self.id(at);
        for element in self.elements(at, "right_of_way") {
            if !element.lanelets("right_of_way").any(|listed| listed == id) {
                continue;
            }
            let listed: Vec<usize> = element.lanelets("yield").filter_map(|id| self.view.position(id)).collect();
            for &lanelet in &listed {
                yields.insert(lanelet, Reason::RightOfWay(element.id));
            }
            for before in listed.iter().flat_map(|&lanelet| self.graph.previous(lanelet)) {
                yields.entry(before).or_insert(Reason::BeforeYield(element.id));
            }
        }
        yields
    }

    /// The lanelets before a watched one, up to a length in metres that begins where the watched one does. `own` are passed over.
    pub fn reach(&self, watched: usize, length: f64, own: &[usize]) -> Reach {
        // The most that is left of the length at the end of each lanelet.
        let mut left: BTreeMap<usize, f64> = BTreeMap::new();
        let mut ends: BTreeMap<usize, f64> = BTreeMap::new();
        let before = |at: usize| self.graph.previous(at).into_iter().filter(|other| own.binary_search(other).is_err());
        let mut open: Vec<(usize, f64)> = before(watched).map(|at| (at, length)).collect();
        if self.graph.previous(watched).is_empty() {
            ends.insert(watched, 0.0);
        }
        while let Some((at, rest)) = open.pop() {
            if left.get(&at).is_some_and(|&known| known >= rest) {
                continue;
            }
            left.insert(at, rest);
            let rest = rest - self.length(at);
            if rest <= 0.0 {
                ends.remove(&at);
            } else if self.graph.previous(at).is_empty() {
                ends.insert(at, length - rest);
            } else {
                open.extend(before(at).map(|other| (other, rest)));
            }
        }
        let ends = ends.into_iter().map(|(lanelet, after)| AttentionEnd { lanelet, after }).collect();
        Reach { before: left.into_keys().filter(|&at| at != watched).collect(), ends }
    }

    /// The lanelets that begin less than a length (m) behind the begin of one, itself included, each with the metres between.
    pub fn downstream(&self, begin: usize, length: f64) -> BTreeMap<usize, f64> {
        let mut found: BTreeMap<usize, f64> = BTreeMap::new();
        let mut open = vec![(begin, 0.0)];
        while let Some((at, after)) = open.pop() {
            if after >= length || found.get(&at).is_some_and(|&known| known <= after) {
                continue;
            }
            found.insert(at, after);
            let after = after + self.length(at);
            open.extend(self.graph.following(at).into_iter().map(|next| (next, after)));
        }
        found
    }

    /// The ids of lanelets.
    pub fn ids(&self, lanelets: &[usize]) -> Vec<LaneletId> {
        lanelets.iter().map(|&at| self.id(at)).collect()
    }
}
