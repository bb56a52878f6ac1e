//! Directs loops at the end of a road that are too narrow for two lanes: cars turn there, and drive around one way.

use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::DrivingSide;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::polygon::signed_area;

use super::{Road, RoadIx, RoadNetwork};

/// A loop with a smaller mean radius of its middle, metres, has no room for two lanes between the places where cars turn into it and
/// out of it.
const TWO_LANES: f64 = 7.5;
/// A longer loop, metres, is a street with a narrow middle and no place to turn.
const LONGEST: f64 = 100.0;

/// Leaves narrow loops with two directions only that in which the island stays on the far side: counter-clockwise where people
/// drive on the right. A loop begins and ends at the end of one other road. With a note for each.
pub(super) fn direct(network: &mut RoadNetwork, notes: &mut Vec<Finding>) {
    for ix in RoadIx::all(network.roads.len()) {
        let Some((travel, radius)) = one_way_around(network, ix) else { continue };
        let road = &mut network.roads[ix];
        road.section.strips.retain(|strip| !strip.kind.is_driven() || [travel, Travel::Both].contains(&strip.travel));
        road.section.strips.iter_mut().filter(|strip| strip.kind.is_driven()).for_each(|strip| strip.travel = travel);
        let around = if network.side == DrivingSide::Right { "counter-clockwise" } else { "clockwise" };
        let way = road.key.way;
        let message = format!("the loop of way {way} is too narrow for two lanes: cars drive around it {around}");
        let note = Finding::new("narrow-loop", Subject::Way(way), message).measured(radius, TWO_LANES, "m");
        notes.push(note.graded(Severity::Info));
    }
}

/// The direction in which cars drive around a narrow loop with two directions, and its mean radius, metres.
fn one_way_around(network: &RoadNetwork, ix: RoadIx) -> Option<(Travel, f64)> {
    let road = network.road(ix);
    let at = network.intersection(road.from);
    if road.from != road.to
        || road.roundabout
        || road.tags.is("oneway", "no")
        || at.arms.len() != 3
        || !is_two_way(road)
    {
        return None;
    }
    let area = signed_area(road.line.points());
    let radius = 2.0 * area.abs() / road.line.length();
    let forward = (area > 0.0) == (network.side == DrivingSide::Right);
    let lane = if forward { Travel::Forward } else { Travel::Backward };
    (radius < TWO_LANES && road.line.length() <= LONGEST).then_some((lane, radius))
}

fn is_two_way(road: &Road) -> bool {
    let mut driven = road.section.driven().map(|(_, strip)| strip.travel);
    let leads = |travel: Travel| road.section.driven().any(|(_, strip)| strip.travel == travel);
    driven.any(|travel| travel == Travel::Both) || (leads(Travel::Forward) && leads(Travel::Backward))
}

#[cfg(test)]
mod tests {
    use crate::builder::network::hand_drawn::{osm, plane};
    use crate::builder::network::{NetworkOptions, road_network};

    use super::*;

    /// The directions of the lanes of a ring of eight nodes at the end of a road, drawn counter-clockwise.
    fn ring(radius: f64, tags: &str, side: DrivingSide) -> (Vec<Travel>, usize) {
        let place = |i: usize| {
            let angle = std::f64::consts::TAU * i as f64 / 8.0;
            (1 + i as i64, radius * angle.cos(), radius * angle.sin(), "")
        };
        let nodes: Vec<_> = (0..8).map(place).chain([(9, 60.0, 0.0, "")]).collect();
        let data = osm(&nodes, &[(10, &[9, 1], ""), (11, &[1, 2, 3, 4, 5, 6, 7, 8, 1], tags)]);
        let options = NetworkOptions { driving_side: Some(side), ..NetworkOptions::default() };
        let reading = road_network(&data, &plane, &options).unwrap();
        let ring = reading.network.roads.iter().find(|road| road.key.way == 11).unwrap();
        let notes = reading.notes.iter().filter(|note| note.fault == "narrow-loop").count();
        (ring.section.driven().map(|(_, strip)| strip.travel).collect(), notes)
    }

    #[test]
    fn a_narrow_loop_is_driven_one_way_with_the_island_on_the_far_side() {
        for (side, around) in [(DrivingSide::Right, Travel::Forward), (DrivingSide::Left, Travel::Backward)] {
            assert_eq!(ring(5.0, "lanes=2", side), (vec![around], 1), "{side:?}");
            assert_eq!(ring(5.0, "lanes=1", side), (vec![around], 1), "{side:?}, a single track");
            assert_eq!(ring(9.0, "lanes=2", side).0.len(), 2, "{side:?}, room for both");
            assert_eq!(ring(5.0, "lanes=2 oneway=no", side).0.len(), 2, "{side:?}, the tags say so");
            assert_eq!(ring(5.0, "oneway=-1", side), (vec![Travel::Backward], 0), "{side:?}, what tags say stays");
        }
    }
}
