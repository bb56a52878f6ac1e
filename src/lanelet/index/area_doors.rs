//! Where lanelets lead into areas and out of them, as Lanelet2 1.2.3 reads it (`GenericTrafficRules`): over a line of the area's ring
//! that runs from corner to corner of a lanelet's end, or is a bound of the lanelet. Autoware passes areas by these rules since
//! autoware_lanelet2_extension 1.1.0 (`AutowareVehicle`).

use std::collections::BTreeSet;

use super::types::MapIndex;
use crate::lanelet::lane_change::{LaneChange, Participant};
use crate::lanelet::participants::may_enter;
use crate::lanelet::routing_pairs::is_one_way;
use crate::lanelet::{Area, Attributes, Bound, LaneletMap, LineStringId, PointId};

/// A line over which a lanelet leads into an area or out of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Door {
    /// The lanelet, by its position in `MapIndex::lanes`.
    pub lane: usize,
    /// The line, part of the area's ring.
    pub line: LineStringId,
    /// Whether the lanelet leads in, else out.
    pub leads_in: bool,
    /// Whether vehicles may cross the line that way.
    pub is_open: bool,
    /// Whether the lanelet ends or starts on the line, else has it as a bound.
    pub is_end: bool,
}

/// Whether vehicles may enter an area.
pub fn lets_vehicles_in(area: &Area) -> bool {
    may_enter(&area.attributes, "vehicle")
}

impl MapIndex<'_> {
    /// The doors between an area and the lanelets that vehicles may drive on, whether or not they may enter the area.
    pub fn doors(&self, area: &Area) -> Vec<Door> {
        let mut doors = Vec::new();
        for &bound in &area.outer {
            let Some([first, last]) = ends(self.map, bound) else { continue };
            let across = crossing(self.map, bound);
            // A lanelet that ends on the line runs over it from its left to its right: the ring is clockwise.
            let mut add = |is_end: bool, lane: usize, leads_in: bool, is_open: bool| {
                if self.lanes[lane].vehicle {
                    doors.push(Door { lane, line: bound.line, leads_in, is_open, is_end });
                }
            };
            for &lane in self.ending.get(&[last, first]).into_iter().flatten() {
                add(true, lane, true, across.to_right);
                if !is_one_way(self.lanes[lane].lanelet, "vehicle") {
                    add(true, lane, false, across.to_left);
                }
            }
            for &lane in self.starting.get(&[first, last]).into_iter().flatten() {
                add(true, lane, false, across.to_left);
                if !is_one_way(self.lanes[lane].lanelet, "vehicle") {
                    add(true, lane, true, across.to_right);
                }
            }
            for &lane in self.users_of(bound.line) {
                let lanelet = self.lanes[lane].lanelet;
                let beside = [(lanelet.left, true), (lanelet.right, false)].into_iter().find(|(own, is_left)| {
                    // The ring has the ground to its right: a left bound runs against it, a right bound along.
                    own.line == bound.line && (own.inverted != bound.inverted) == *is_left
                });
                let Some((own, is_left)) = beside else { continue };
                let across = crossing(self.map, own);
                let [inward, outward] = match is_left {
                    true => [across.to_left, across.to_right],
                    false => [across.to_right, across.to_left],
                };
                add(false, lane, true, inward);
                add(false, lane, false, outward);
            }
        }
        doors.sort_unstable();
        doors.dedup();
        doors
    }

    /// Lanes of vehicles that end or start with both corners on an area's ring, though no line runs from one to the other.
    pub fn unspanned_ends(&self, area: &Area) -> Vec<usize> {
        let spans: BTreeSet<[PointId; 2]> =
            area.outer.iter().filter_map(|&bound| ends(self.map, bound)).flat_map(|[a, b]| [[a, b], [b, a]]).collect();
        let on_ring: BTreeSet<PointId> = area.points.iter().copied().collect();
        let lacks = |ids: &[PointId; 2]| ids.iter().all(|id| on_ring.contains(id)) && !spans.contains(ids);
        let places: Vec<_> =
            area.points.iter().filter_map(|&id| self.map.points.get(id)).map(|point| point.position).collect();
        let [low, high] = super::extent(&places);
        let near = self.lanes_near(low, high).into_iter();
        near.filter(|&at| {
            let lane = &self.lanes[at];
            let is_beside = lane.bounds.iter().any(|way| area.outer.iter().any(|bound| bound.line == *way));
            lane.vehicle && !is_beside && (lacks(&lane.end.ids) || lacks(&lane.start.ids))
        })
        .collect()
    }

    /// Pairs of lanes between which an area leads vehicles: out of the first, onto the second.
    pub fn ways_over_areas(&self) -> Vec<[usize; 2]> {
        let mut ways = Vec::new();
        for area in self.map.areas.iter().filter(|area| lets_vehicles_in(area)) {
            let doors = self.doors(area);
            let open = |leads_in: bool| doors.iter().filter(move |door| door.is_open && door.leads_in == leads_in);
            ways.extend(open(true).flat_map(|into| open(false).map(move |out| [into.lane, out.lane])));
        }
        ways
    }

    /// The lanes that vehicles can leave into an area, and those onto which they can come from one.
    pub fn lanes_at_areas(&self) -> [BTreeSet<usize>; 2] {
        let mut lanes = [BTreeSet::new(), BTreeSet::new()];
        for area in self.map.areas.iter().filter(|area| lets_vehicles_in(area)) {
            for door in self.doors(area).into_iter().filter(|door| door.is_open) {
                lanes[usize::from(!door.leads_in)].insert(door.lane);
            }
        }
        lanes
    }
}

/// The end points of a line as a ring uses it.
fn ends(map: &LaneletMap, bound: Bound) -> Option<[PointId; 2]> {
    let points = &map.linestrings.get(bound.line)?.points;
    let (first, last) = (*points.first()?, *points.last()?);
    Some(if bound.inverted { [last, first] } else { [first, last] })
}

/// To which sides vehicles may cross a line on their way between lanelet and area: in addition to lane changes, lines of
/// type `virtual` may be crossed, unless tags say otherwise.
fn crossing(map: &LaneletMap, bound: Bound) -> LaneChange {
    let says = |tags: &Attributes| {
        let left = tags.get("lane_change:left").is_some_and(|value| matches!(value, "yes" | "true" | "1"));
        tags.has("lane_change") || left || tags.has("lane_change:right")
    };
    let line = map.linestrings.get(bound.line);
    if line.is_some_and(|line| line.attributes.is("type", "virtual") && !says(&line.attributes)) {
        return LaneChange { to_left: true, to_right: true };
    }
    LaneChange::over(map, bound, Participant::Vehicle)
}
