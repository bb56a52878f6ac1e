//! Lanelets that are for both directions, of which a lanelet for each is made.

use rustc_hash::FxHashSet;

use crate::diagnostic::{Edit, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Lanelet, PointId};

/// Regulatory elements that speak of the ground, whichever way one drives over it.
const OF_GROUND: [&str; 6] =
    ["crosswalk", "speed_bump", "detection_area", "no_stopping_area", "no_parking_area", "bus_stop_area"];

/// Whether a lanelet says that it may be driven in both directions.
pub fn is_two_way(lanelet: &Lanelet) -> bool {
    matches!(lanelet.attributes.get("one_way"), Some("no" | "false" | "0"))
}

/// Where lanes begin and end, those for both directions at either end.
pub struct TwoWay<'m> {
    map: &'m MapIndex<'m>,
    starts: FxHashSet<[PointId; 2]>,
    ends: FxHashSet<[PointId; 2]>,
}

impl<'m> TwoWay<'m> {
    /// Of a map.
    pub fn of(map: &'m MapIndex<'m>) -> Self {
        let (mut starts, mut ends) = (FxHashSet::default(), FxHashSet::default());
        for lane in map.lanes.iter().filter(|lane| lane.is_drivable()) {
            starts.insert(lane.start.ids);
            ends.insert(lane.end.ids);
            if map.map.lanelets.get(lane.id).is_some_and(is_two_way) {
                starts.insert(turned(lane.end.ids));
                ends.insert(turned(lane.start.ids));
            }
        }
        Self { map, starts, ends }
    }

    /// The edit that creates the lanelet of the other direction; `None` where there is one, or where nothing leads on from there
    /// and nothing leads there, so that nobody drives that way.
    pub fn opposite(&self, lanelet: &Lanelet) -> Option<Edit> {
        let lane = self.map.lanes.get(self.map.lane(lanelet.id)?)?;
        let [start, end] = [lane.end.ids, lane.start.ids].map(turned);
        if !is_two_way(lanelet) || lane.both_ways || !self.ends.contains(&start) && !self.starts.contains(&end) {
            return None;
        }
        let elements = lanelet.regulatory_elements.iter().filter(|id| {
            let element = self.map.map.regulatory_elements.get(**id);
            element.is_some_and(|element| OF_GROUND.contains(&element.subtype.as_str()))
        });
        Some(Edit::CreateOpposite { lanelet: lanelet.id.0, elements: elements.map(|id| id.0).collect() })
    }

    /// The edits that make a lanelet one-way, and whether they follow from the file for certain.
    pub fn edits(&self, lanelet: &Lanelet) -> (Vec<Edit>, bool) {
        let on = Subject::Lanelet(lanelet.id.0);
        let set = Edit::SetTag { on, key: "one_way".into(), value: "yes".into() };
        match self.opposite(lanelet) {
            // The copy is made of the lanelet as it was.
            Some(create) => (vec![create, set], false),
            None => (vec![set], true),
        }
    }
}

/// The two points of an end as one sees them who comes from the other side.
fn turned([left, right]: [PointId; 2]) -> [PointId; 2] {
    [right, left]
}
