//! Lanelets that are for both directions, of which a lanelet for each is made.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::diagnostic::{Edit, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Lanelet, LineStringId, PointId};

/// Regulatory elements that speak of the ground, whichever way one drives over it.
const OF_GROUND: [&str; 6] =
    ["crosswalk", "speed_bump", "detection_area", "no_stopping_area", "no_parking_area", "bus_stop_area"];

/// Whether a lanelet says that it may be driven in both directions.
pub fn is_two_way(lanelet: &Lanelet) -> bool {
    matches!(lanelet.attributes.get("one_way"), Some("no" | "false" | "0"))
}

/// Whether a lane for both directions, driven backwards, leads on from the end of a lane, or else up to its start. That such a lane should
/// be two is told of it, and not that a piece is missing.
pub fn leads_on_backwards(map: &MapIndex, at: usize, end: bool) -> bool {
    let lane = &map.lanes[at];
    let lanes = match end {
        true => map.ending_at(turned(lane.end.ids)),
        false => map.starting_at(turned(lane.start.ids)),
    };
    lanes.iter().any(|&other| other != at && is_two_way(map.lanes[other].lanelet))
}

/// Where lanes begin and end, those for both directions at either end, and what lies beside each other.
pub struct TwoWay<'m> {
    map: &'m MapIndex<'m>,
    starts: FxHashSet<[PointId; 2]>,
    ends: FxHashSet<[PointId; 2]>,
    /// How many lanes have the piece between two points on this side of theirs (0 left, 1 right).
    beside: FxHashMap<(usize, [PointId; 2]), usize>,
}

impl<'m> TwoWay<'m> {
    /// Of a map.
    pub fn of(map: &'m MapIndex<'m>) -> Self {
        let (mut starts, mut ends) = (FxHashSet::default(), FxHashSet::default());
        let mut beside: FxHashMap<(usize, [PointId; 2]), usize> = FxHashMap::default();
        let lanes = || map.lanes.iter().filter(|lane| lane.is_drivable());
        for piece in lanes().flat_map(|lane| pieces(map, lane.bounds)) {
            *beside.entry(piece).or_default() += 1;
        }
        for lane in lanes() {
            starts.insert(lane.start.ids);
            ends.insert(lane.end.ids);
            // Where a lane of the other direction lies beside it, nobody drives back on the lane itself.
            if map.map.lanelets.get(lane.id).is_some_and(is_two_way) && !is_opposed(map, &beside, lane.bounds) {
                starts.insert(turned(lane.end.ids));
                ends.insert(turned(lane.start.ids));
            }
        }
        Self { map, starts, ends, beside }
    }

    /// The edit that creates the lanelet of the other direction. `None` if there is one, between the same bounds or beside it, or
    /// if nobody drives that way because nothing leads to it and nothing leads on from it.
    pub fn opposite(&self, lanelet: &Lanelet) -> Option<Edit> {
        let lane = self.map.lanes.get(self.map.lane(lanelet.id)?)?;
        let [start, end] = [lane.end.ids, lane.start.ids].map(turned);
        let is_opposed = is_opposed(self.map, &self.beside, lane.bounds);
        let is_used = self.ends.contains(&start) || self.starts.contains(&end);
        if !is_two_way(lanelet) || lane.both_ways || is_opposed || !is_used {
            return None;
        }
        let elements = lanelet.regulatory_elements.iter().filter(|id| {
            let element = self.map.map.regulatory_elements.get(**id);
            element.is_some_and(|element| OF_GROUND.contains(&element.subtype.as_str()))
        });
        Some(Edit::CreateOpposite { lanelet: lanelet.id.0, elements: elements.map(|id| id.0).collect() })
    }

    /// The edits that make a lanelet one-way, and whether they draw the lanelet of the other direction.
    pub fn edits(&self, lanelet: &Lanelet) -> (Vec<Edit>, bool) {
        let on = Subject::Lanelet(lanelet.id.0);
        let set = Edit::SetTag { on, key: "one_way".into(), value: "yes".into() };
        match self.opposite(lanelet) {
            // The copy is made of the lanelet as it was.
            Some(create) => (vec![create, set], true),
            None => (vec![set], false),
        }
    }
}

/// Whether a lane has a piece of a bound on the same side as another: the two are driven in opposite directions.
fn is_opposed(map: &MapIndex, beside: &FxHashMap<(usize, [PointId; 2]), usize>, bounds: [LineStringId; 2]) -> bool {
    pieces(map, bounds).any(|piece| beside.get(&piece).is_some_and(|&lanes| lanes > 1))
}

/// The pieces between the points of two bounds, left and right: each with its side and its points, the smaller id first.
fn pieces<'m>(map: &MapIndex<'m>, bounds: [LineStringId; 2]) -> impl Iterator<Item = (usize, [PointId; 2])> + use<'m> {
    let lines = bounds.map(|bound| map.map.linestrings.get(bound));
    lines.into_iter().enumerate().flat_map(|(side, line)| {
        let points = line.map_or(&[][..], |line| &line.points);
        points.windows(2).filter_map(move |pair| match *pair {
            [a, b] => Some((side, [a.min(b), a.max(b)])),
            _ => None,
        })
    })
}

/// The two points of an end in the order for the opposite direction.
fn turned([left, right]: [PointId; 2]) -> [PointId; 2] {
    [right, left]
}
