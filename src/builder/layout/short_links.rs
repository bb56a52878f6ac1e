//! Roads too short for the turns at their ends: no vehicle waits on what is left of them, and none takes the turn.

use crate::builder::intersection::movement_types::Movement;
use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::road_cut::ROAD_LEFT;
use crate::builder::network::{Intersection, RoadEnd, RoadIx};
use crate::geometry::pose;

use super::map_layout::Layout;

/// A car does not turn on a smaller radius, metres, of the middle of its lane: at full lock a usual one turns on some 4 to 5 m.
const CAR_RADIUS: f64 = 4.0;
/// Metres by which lengths of roads may differ that are the same.
const SAME: f64 = 0.05;

/// The roads of which nothing more can be cut off, although a way that begins or ends there bends too tightly for a car for
/// want of it; in order. The pieces of a roundabout's ring are driven around whatever their length.
pub fn short_links(layout: &Layout) -> Vec<RoadIx> {
    let spent = |road: &RoadIx| layout.left(*road) < ROAD_LEFT + SAME && !layout.network.road(*road).roundabout;
    let some_spent = |(at, _): &(&Intersection, &[TurningLanelet])| at.arms.iter().any(|at| spent(&at.road));
    let at = |(at, ways)| short_arms(layout, at, ways).filter(spent).collect::<Vec<_>>();
    let paths = layout.ways.iter().map(|ways| ways.as_ref().map_or(&[][..], |ways| &ways.drawn.paths));
    let mut roads: Vec<RoadIx> =
        layout.network.intersections.iter().zip(paths).filter(some_spent).flat_map(at).collect();
    roads.sort_unstable();
    roads.dedup();
    roads
}

/// The roads at an intersection that were not cut back far enough for a turn from or to them.
fn short_arms<'a>(
    layout: &'a Layout,
    at: &'a Intersection,
    paths: &'a [TurningLanelet],
) -> impl Iterator<Item = RoadIx> + 'a {
    let short = move |path: &TurningLanelet| {
        let Movement { from, to, in_lane, out_lane } = path.movement;
        let arms: [RoadEnd; 2] = [at.arms[from], at.arms[to]];
        let ends = (layout.lanes.arm(arms[0]).into.get(in_lane)).zip(layout.lanes.arm(arms[1]).out.get(out_lane));
        let tangents = ends.and_then(|(into, out)| pose::tangents(into.pose, out.pose));
        let short = tangents.map(|(before, behind, turn)| {
            let needed = CAR_RADIUS * (turn.abs() / 2.0).tan();
            [(arms[0], before), (arms[1], behind)].map(|(arm, length)| (length < needed).then_some(arm.road))
        });
        short.into_iter().flatten().flatten()
    };
    paths.iter().flat_map(short)
}
