//! What rules ask about single primitives.

use super::{Intersection, Lane, MapIndex};
use crate::lanelet::lane_change::{LaneChange, Participant};
use crate::lanelet::{LaneletId, LaneletMap, LineString, Polygon, PolygonId, RegulatoryElement, TurnDirection};

impl MapIndex<'_> {
    /// The elements of one subtype that a lanelet refers to, in file order.
    pub fn elements<'a>(
        &'a self,
        lanelet: LaneletId,
        subtype: &'a str,
    ) -> impl Iterator<Item = &'a RegulatoryElement> + 'a {
        elements(self.map, lanelet, subtype)
    }

    /// See [`is_signalised`].
    pub fn is_signalised(&self, lanelet: LaneletId) -> bool {
        is_signalised(self.map, lanelet)
    }

    /// The `turn_direction` of a lane, if it is one of the three words.
    pub fn turn_direction(&self, lane: usize) -> Option<TurnDirection> {
        TurnDirection::parse(self.lanes[lane].lanelet.attributes.get("turn_direction")?)
    }

    /// The label that fits a turn (degrees, left positive) that is straight up to `straight`: beyond `u_turn` the far
    /// turn's, whichever way the lane bends, where the driving side is known.
    pub fn label_for(&self, turn: f64, straight: f64, u_turn: f64) -> TurnDirection {
        match self.side.side {
            Some(side) if turn.abs() > u_turn => side.far_turn(),
            _ if turn > straight => TurnDirection::Left,
            _ if turn < -straight => TurnDirection::Right,
            _ => TurnDirection::Straight,
        }
    }

    /// A polygon, if it is an intersection area.
    pub fn intersection_area(&self, id: PolygonId) -> Option<&Polygon> {
        self.map.polygons.get(id).filter(|polygon| polygon.attributes.is("type", "intersection_area"))
    }

    /// Whether a lane is part of an intersection that has an area.
    pub fn has_area(&self, lane: usize) -> bool {
        self.intersections_of(lane).iter().any(|&at| self.intersections[at].area.is_some())
    }

    /// Whether a lane begins in a point, as one that opens beside another: it is reached from beside alone, so that no movement of an
    /// intersection starts on it.
    pub fn begins_in_a_point(&self, lane: usize) -> bool {
        let [left, right] = self.lanes[lane].start.ids;
        left == right && self.predecessors(lane).is_empty()
    }

    /// Whether two lanes are part of one intersection, by place or because their tags name the same area.
    pub fn in_same_intersection(&self, x: usize, y: usize) -> Option<&Intersection> {
        let common = self.intersections_of(x).iter().find(|at| self.intersections_of(y).contains(at))?;
        self.intersections.get(*common)
    }

    /// Intersections whose area touches a lane, or of which it is part.
    pub fn intersections_touching(&self, lane: usize) -> impl Iterator<Item = &Intersection> + '_ {
        self.touching[lane].iter().filter_map(|&at| self.intersections.get(at))
    }

    /// The lane of an id; `None` if the lanelet is broken or not there.
    pub fn lane_of(&self, id: LaneletId) -> Option<&Lane<'_>> {
        self.lane(id).map(|at| &self.lanes[at])
    }
}

fn elements<'a>(
    map: &'a LaneletMap,
    lanelet: LaneletId,
    subtype: &'a str,
) -> impl Iterator<Item = &'a RegulatoryElement> + 'a {
    let ids = map.lanelets.get(lanelet).into_iter().flat_map(|lanelet| &lanelet.regulatory_elements);
    ids.filter_map(|&id| map.regulatory_elements.get(id)).filter(move |element| element.subtype == subtype)
}

/// Whether a signal rules a lanelet for Autoware: exactly one traffic light, and that with a stop line.
pub fn is_signalised(map: &LaneletMap, lanelet: LaneletId) -> bool {
    let mut lights = elements(map, lanelet, "traffic_light");
    match (lights.next(), lights.next()) {
        (Some(light), None) => light.linestrings("ref_line").next().is_some(),
        _ => false,
    }
}

/// Whether a line is the border of the carriageway: by `type`, or by `subtype` as the requirement's text has it.
pub fn is_road_border(line: &LineString) -> bool {
    line.attributes.is("type", "road_border") || line.attributes.is("subtype", "road_border")
}

/// Whether Autoware lets a vehicle change lanes across a line, to one side at least.
pub fn allows_lane_change(line: &LineString) -> bool {
    LaneChange::of(&line.attributes, Participant::Vehicle).any()
}
