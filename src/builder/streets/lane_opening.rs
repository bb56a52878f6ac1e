//! Lane openings: a wide road begins, or ends, with fewer lanes where it meets a narrow one, so that lanes open or close one after
//! another.

use crate::builder::network::{Road, RoadEnd, RoadNetwork, Stations};

use super::lane_drop::{MITER_LIMIT, heights_along, with_other_ends};

/// Fewer lanes at one end of a road.
#[derive(Clone, Debug)]
pub struct LaneOpening {
    /// The end of the wide road where it meets the narrow one.
    pub at: RoadEnd,
    /// The indices of the strips that are closed there, in order.
    pub closed: Vec<usize>,
    /// The index of a strip that stays where it is.
    pub stays: usize,
    /// Where they open: distance along the road's line from this end, metres.
    pub length: f64,
}

/// The network with fewer lanes at the ends of some roads, each of which is divided where they open. `kept` are the stations between
/// which the outlines leave each road; those of the result are returned, too. At most one opening is made for each road.
#[must_use]
pub fn with_lane_openings(
    network: RoadNetwork,
    kept: &[Stations],
    openings: &[LaneOpening],
) -> (RoadNetwork, Vec<Stations>) {
    let changes =
        openings.iter().map(|opening| ((opening.at, opening.length), move |road: &mut Road| narrow(road, opening)));
    with_other_ends(network, kept, changes)
}

/// Closes lanes. The others beside the one that stays do not move.
fn narrow(road: &mut Road, opening: &LaneOpening) -> Option<()> {
    let before = road.section.edge(opening.stays);
    let closed_before = opening.closed.iter().filter(|lane| **lane < opening.stays).count();
    let mut strip = 0..;
    road.section.strips.retain(|_| strip.next().is_some_and(|strip| !opening.closed.contains(&strip)));
    let line = road.line.offset(before - road.section.edge(opening.stays - closed_before), MITER_LIMIT)?;
    road.heights = heights_along(road, &line);
    road.line = line;
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::builder::network::hand_drawn::network_of;
    use crate::builder::network::{End, RoadIx};

    #[test]
    fn lanes_that_stay_go_straight_on() {
        for (end, closed, stays) in [(End::Start, vec![2, 3], 0), (End::Start, vec![0, 3], 1), (End::End, vec![0], 1)] {
            let tags = "highway=primary oneway=yes lanes=4";
            let network = network_of(&[(1, 0.0, 0.0), (2, 200.0, 0.0)], &[(9, &[1, 2], tags)]);
            let at = RoadEnd { road: RoadIx::new(0), end };
            let opening = LaneOpening { at, closed: closed.clone(), stays, length: 45.0 };
            let (network, kept) = with_lane_openings(network, &[[0.0, 200.0]], &[opening]);
            let near = |road: &&Road| (road.key.first == 1) == (end == End::Start);
            let (Some(narrow), Some(wide)) =
                (network.roads.iter().find(near), network.roads.iter().find(|road| !near(road)))
            else {
                panic!("{:?}", network.roads)
            };
            assert_eq!((narrow.section.strips.len(), wide.section.strips.len()), (4 - closed.len(), 4));
            let lane = stays - closed.iter().filter(|lane| **lane < stays).count();
            let edge = |road: &Road, lane: usize| road.line.first().y + road.section.edge(lane);
            assert!((edge(narrow, lane) - edge(wide, stays)).abs() < 1e-9, "{closed:?}");
            assert!((narrow.line.length() - 45.0).abs() < 1e-9);
            assert_eq!(kept.iter().map(|[a, b]| b - a).sum::<f64>(), 200.0);
        }
    }
}
