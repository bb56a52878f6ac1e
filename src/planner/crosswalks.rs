//! Where the crosswalk module stops, as the path meets the crosswalks.

use std::collections::BTreeMap;

use serde::Serialize;

use super::params::Params;
use super::path::{Front, Path};
use super::road_network::RoadNetwork;
use crate::lanelet::participants::may_enter;
use crate::lanelet::{LaneletId, LineStringId, RegulatoryElementId};

/// Metres of path before a lanelet on which crosswalks are told: where it stops for them belongs to the same place.
const BEFORE: f64 = 30.0;
/// The same behind it: a vehicle that waits there still stands in the intersection.
const BEHIND: f64 = 15.0;

/// A crosswalk on the path.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrosswalkStop {
    /// The lanelet of the crosswalk.
    pub crosswalk: LaneletId,
    /// The lanelet of the path that meets it.
    pub lane: LaneletId,
    /// The element that names it, if the lanelet refers to one.
    pub element: Option<RegulatoryElementId>,
    /// Metres along the path from the begin of the lanelet to the edge of the crosswalk.
    pub from_start: f64,
    /// Where the front stops.
    pub stop: StopAt,
}

/// Where the front of the vehicle stops for a crosswalk.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StopAt {
    /// Metres before the edge of the crosswalk; negative: behind it.
    pub before: f64,
    /// The stop line that decides; `None`: the parameter does.
    pub line: Option<LineStringId>,
    /// The front there; `None` before the begin of the path.
    pub front: Option<Front>,
}

/// The crosswalks on a path around the lanelet that it is about, in the order in which the path meets them.
pub(super) fn find(network: &RoadNetwork<'_, '_>, path: &Path, params: &Params) -> Vec<CrosswalkStop> {
    let [start, end] = path.stations;
    let mut found: Vec<CrosswalkStop> = Vec::new();
    for &lane in &path.lanelets {
        for (crosswalk, element) in on_lanelet(network, lane) {
            let id = network.id(crosswalk);
            let ring = &network.seen(crosswalk).outline;
            let Some(edge) = path.entry(ring, start - BEFORE).filter(|edge| *edge <= end + BEHIND) else { continue };
            if found.iter().any(|known| known.crosswalk == id) {
                continue;
            }
            let lines = element.into_iter().flat_map(|element| network.view.lines(element, "ref_line"));
            let mut stops = lines.filter_map(|line| {
                let places = network.view.places(line);
                let crossed = places.windows(2).filter_map(|pair| path.crossing([pair[0], pair[1]], 0.0));
                Some((crossed.min_by(f64::total_cmp)?, line.id))
            });
            let (before, line) = match stops.next() {
                Some((station, line)) => (edge - station, Some(line)),
                None => (params.stop_distance_from_crosswalk, None),
            };
            let stop = StopAt { before, line, front: path.front_at(edge - before, params) };
            let element = element.map(|element| element.id);
            found.push(CrosswalkStop {
                crosswalk: id,
                lane: network.id(lane),
                element,
                from_start: edge - start,
                stop,
            });
        }
    }
    found.sort_by(|a, b| a.from_start.total_cmp(&b.from_start));
    found
}

/// The crosswalks of one lanelet: those that its elements name, and those of people on foot that overlap it.
fn on_lanelet<'m>(
    network: &RoadNetwork<'_, 'm>,
    lane: usize,
) -> BTreeMap<usize, Option<&'m crate::lanelet::RegulatoryElement>> {
    let view = network.view;
    let mut found = BTreeMap::new();
    let near = view.near(network.seen(lane).extent, 0.0);
    let walked = near.into_iter().filter(|&at| {
        let tags = &view.lanelets[at].lanelet.attributes;
        at != lane && tags.is("subtype", "crosswalk") && may_enter(tags, "pedestrian")
    });
    found.extend(walked.filter(|&at| view.lanelets[at].meets(network.seen(lane))).map(|at| (at, None)));
    for element in network.elements(lane, "crosswalk") {
        for crosswalk in element.lanelets("refers").filter_map(|id| view.position(id)) {
            found.insert(crosswalk, Some(element));
        }
    }
    found
}
