//! Lanelets as TIER IV's validator sees them: who conflicts, and how an element of theirs is judged.

use std::collections::BTreeMap;

use crate::geometry::angle_between;
use crate::lanelet::RegulatoryElement;
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::tier4_yields::{Overlaps, Ruled, SAME_TIMING, light, turns_before};
use crate::lanelet::index::view::View;

/// How the validator judges the `right_of_way` element of a lanelet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// By what rules it.
    By(Ruled),
    /// Not at all.
    Never,
}

/// The lanelets of a map.
pub struct LanesSeen<'v, 'm> {
    /// The map.
    pub view: &'v View<'m>,
    /// Where cars drive.
    pub graph: Graph<'v, 'm>,
}

impl<'v, 'm> LanesSeen<'v, 'm> {
    /// Looks at a map.
    pub fn new(view: &'v View<'m>) -> Self {
        Self { graph: Graph::new(view, Rules::Car), view }
    }

    /// How the element of a lanelet is judged.
    pub fn judged(&self, at: usize) -> Judged {
        let has = |subtype| self.view.elements_of(&self.view.lanelets[at], subtype).next().is_some();
        let turns = matches!(self.view.lanelets[at].tag("turn_direction"), Some("left" | "right"));
        match (has("traffic_light"), has("virtual_traffic_light")) {
            (_, true) => Judged::By(Ruled::Virtually),
            (true, false) if turns => Judged::By(Ruled::ByLight),
            (true, false) => Judged::Never,
            (false, false) => Judged::By(Ruled::ByNothing),
        }
    }

    /// The lanelets that the element of a lanelet has to list, by position, in order.
    pub fn wanted(&self, at: usize, ruled: Ruled) -> Vec<usize> {
        Overlaps::new(self.view, &self.graph, at, ruled).wanted
    }

    /// Whether another lanelet turns left where the oncoming one turns right, both with the same green. The validator knows
    /// only the opposite order, that of roads on which people drive on the left.
    pub fn meets_oncoming_turn(&self, at: usize, other: usize) -> bool {
        let [seen, beside] = [at, other].map(|at| &self.view.lanelets[at]);
        let lights = light(self.view, seen).zip(light(self.view, beside));
        let angle = lights.map_or(0.0, |((_, own), (_, theirs))| angle_between(own, theirs).abs().to_degrees());
        angle > 180.0 - SAME_TIMING && turns_before(beside, seen)
    }

    /// The lanelets of each area, by position.
    pub fn areas(&self) -> BTreeMap<i64, Vec<usize>> {
        let mut areas: BTreeMap<i64, Vec<usize>> = BTreeMap::new();
        for (at, seen) in self.view.lanelets.iter().enumerate().filter(|(at, _)| self.graph.passes(*at)) {
            if let Some(area) = seen.area_tag() {
                areas.entry(area).or_default().push(at);
            }
        }
        areas
    }

    /// The `right_of_way` element of a lanelet.
    pub fn element(&self, at: usize) -> Option<&'m RegulatoryElement> {
        self.view.elements_of(&self.view.lanelets[at], "right_of_way").next()
    }

    /// The lanelets that an element lists, by position, in order.
    pub fn listed(&self, element: &RegulatoryElement) -> Vec<usize> {
        let mut listed: Vec<usize> = element.lanelets("yield").filter_map(|id| self.view.position(id)).collect();
        listed.sort_unstable();
        listed
    }
}
