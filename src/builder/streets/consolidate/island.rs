//! Detects islands that traffic drives around: a merged intersection must not cover them.

use rustc_hash::{FxHashMap, FxHashSet};

use geo::{Area, Polygon};

use crate::builder::network::road_end::other_end;
use crate::builder::network::{End, IntersectionIx, Road, RoadIx, RoadNetwork};
use crate::builder::streets::outline::ribbon;
use crate::geometry::{Point, polygon};

/// Largest ratio of the ground that a merged intersection covers to the ground of its roads.
pub const COVER_MOST: f64 = 1.3;
/// Length of the arms that counts as ground of an intersection, metres: about the trim at a right angle.
const STUB: f64 = 3.0;

/// Whether the intersections and inner roads, merged, would cover much more than the ground of these roads, and more than
/// `most` square metres beside it.
pub fn encloses_island(network: &RoadNetwork, members: &[IntersectionIx], inner: &[RoadIx], most: f64) -> bool {
    let before: usize = members.iter().map(|m| network.intersection(*m).inner.len()).sum();
    let nodes: usize = members.iter().map(|m| network.intersection(*m).nodes.len()).sum();
    // Fewer links than nodes make a tree, which encloses nothing.
    if before + inner.len() < nodes {
        return false;
    }
    let Some([ground, holes]) = covered(network, members, inner) else { return false };
    holes > most && ground + holes > COVER_MOST * ground
}

/// If a road would close a block of four sides of which two adjacent ones are `joined`: the one of these joined last.
pub fn around_corner(network: &RoadNetwork, closing: RoadIx, joined: &FxHashMap<RoadIx, usize>) -> Option<RoadIx> {
    // The roads at an intersection, with the intersections they lead to.
    let sides = |from: IntersectionIx| {
        let arms = network.intersection(from).arms.iter();
        arms.map(move |arm| (arm.road, network.intersection_at(other_end(*arm))))
    };
    let Road { from, to, .. } = *network.road(closing);
    for [near, far] in [[from, to], [to, from]] {
        for (first, middle) in sides(near).filter(|(road, _)| joined.contains_key(road)) {
            for (second, last) in sides(middle).filter(|(road, _)| joined.contains_key(road)) {
                let apart = ![near, middle, far].contains(&last) && ![near, far].contains(&middle);
                if apart && sides(last).any(|(_, end)| end == far) {
                    return [first, second].into_iter().max_by_key(|road| joined[road]);
                }
            }
        }
    }
    None
}

/// The ground of the roads inside, and the holes in it, square metres.
fn covered(network: &RoadNetwork, members: &[IntersectionIx], inner: &[RoadIx]) -> Option<[f64; 2]> {
    let held: FxHashSet<RoadIx> = inner.iter().copied().collect();
    let intersections = || members.iter().map(|m| network.intersection(*m));
    let mut ribbons: Vec<Vec<Point>> = intersections()
        .flat_map(|i| &i.inner)
        .filter_map(|road| ribbon(&road.line, road.section.width() / 2.0))
        .collect();
    ribbons.extend(inner.iter().map(|ix| network.road(*ix)).filter_map(|road| ribbon(&road.line, road.half_width())));
    for arm in intersections().flat_map(|i| &i.arms).filter(|arm| !held.contains(&arm.road)) {
        let road = network.road(arm.road);
        let (length, stub) = (road.line.length(), STUB.min(road.line.length()));
        let [from, to] = if arm.end == End::Start { [0.0, stub] } else { [length - stub, length] };
        ribbons.extend(road.line.cut(from, to).and_then(|line| ribbon(&line, road.half_width())));
    }
    let ground = polygon::ground(&ribbons);
    let with_holes: f64 =
        ground.iter().map(|piece| Polygon::new(piece.exterior().clone(), Vec::new()).unsigned_area()).sum();
    let ground = ground.unsigned_area();
    (ground > 0.0).then_some([ground, with_holes - ground])
}
