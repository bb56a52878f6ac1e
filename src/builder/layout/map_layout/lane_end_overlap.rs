//! How far turning lanelets run over the ends of the roads at their intersection.

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::lanes::road_cut::ConnectionLines;
use crate::builder::lanes::types::Lanes;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::road_end::from_cut;
use crate::builder::network::{End, Intersection, Road, RoadEnd, RoadNetwork, Stations};
use crate::geometry::{Point, Polyline, Vector, polygon};

/// A lanelet that reaches over a cut by less than this, metres, only touches it.
pub(super) const TOUCH: f64 = 0.05;
/// The largest setback of a road, metres behind its outline, for a lanelet that runs over its end: a lanelet that reaches farther runs
/// along the road.
pub(super) const BACK_MOST: f64 = 12.0;

/// The distance between the places at which outlines are measured, metres.
const MEASURED_EVERY: f64 = 0.5;

/// The ends of roads that lanelets run over, and how far behind their cuts, metres.
pub fn depths(
    network: &RoadNetwork,
    lines: &ConnectionLines,
    lanes: &Lanes,
    assembly: &MapBuilder,
    intersection: &Intersection,
    paths: &[TurningLanelet],
) -> Vec<(RoadEnd, f64)> {
    let paths: Vec<_> = paths.iter().filter_map(|path| Some((path, polygon::bounds(&path.outline)?))).collect();
    let depth = |&at: &RoadEnd| {
        let cut = assembly.positions(&lanes.arm(at).cut);
        (at, depth(network.road(at.road), lines.kept[at.road], (at, &cut), intersection, &paths))
    };
    intersection.arms.iter().map(depth).filter(|(_, depth)| *depth > TOUCH).collect()
}

/// How far behind the cut of a road lanelets reach, metres. `places` are those of the cut; each lanelet comes with its bounding box.
fn depth(
    road: &Road,
    kept: Stations,
    (at, places): (RoadEnd, &[Point]),
    intersection: &Intersection,
    paths: &[(&TurningLanelet, [Point; 2])],
) -> f64 {
    let (Some(&right), Some(&left)) = (places.first(), places.last()) else { return 0.0 };
    let reach = (left - right).norm() + BACK_MOST;
    let (first, last) = road.section.carriageway();
    let (left, right) = (road.section.edge(first), road.section.edge(last));
    // The ground that is tested lies within this distance of the first place of the cut.
    let near = BACK_MOST + 2.0 * left.abs().max(right.abs()) + TOUCH;
    let Some([low, high]) = behind_cut(road, kept, at.end, left.abs().max(right.abs()) + TOUCH) else { return 0.0 };
    let beyond = |p: &Point| {
        let within = p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y;
        if !within || (p - places[0]).norm() > near {
            return 0.0;
        }
        let foot = road.line.project(*p);
        let level = ((p - foot.point).norm() - foot.offset.abs()).abs() < TOUCH;
        let within = foot.offset < left - TOUCH && foot.offset > right + TOUCH;
        let depth = from_cut(kept, at.end, foot.station);
        if level && within && depth < BACK_MOST { depth } else { 0.0 }
    };
    let own = |arm: usize| intersection.arms[arm] == at;
    paths
        .iter()
        // A lanelet of this arm begins or ends on the cut; it reaches behind the cut only if it turns back.
        .filter(|(path, _)| !(own(path.movement.from) || own(path.movement.to)) || path.turn.abs() > 90.0)
        .filter(|(path, around)| {
            enters(path, around, [low, high]) && path.outline.iter().any(|p| (p - places[0]).norm() < reach)
        })
        .filter_map(|(path, _)| Polyline::new(path.outline.iter().chain(path.outline.first()).copied()))
        .flat_map(|ring| ring.resampled(MEASURED_EVERY).into_points())
        .map(|p| beyond(&p))
        .fold(0.0, f64::max)
}

/// Whether an edge of a lanelet may run through a box, by the bounding boxes of the lanelet and of the edge.
fn enters(path: &TurningLanelet, [from, to]: &[Point; 2], [low, high]: [Point; 2]) -> bool {
    let touches = |from: &Point, to: &Point| from.x <= high.x && from.y <= high.y && low.x <= to.x && low.y <= to.y;
    let mut edges = path.outline.iter().zip(path.outline.iter().cycle().skip(1));
    touches(from, to) && edges.any(|(a, b)| touches(&a.inf(b), &a.sup(b)))
}

/// The bounding box of the ground up to [`BACK_MOST`] behind the cut of a road, `half` metres to either side of its line.
fn behind_cut(road: &Road, kept: Stations, end: End, half: f64) -> Option<[Point; 2]> {
    let [from, to] = match end {
        End::Start => [kept[0], kept[0] + BACK_MOST],
        End::End => [kept[1] - BACK_MOST, kept[1]],
    };
    let [low, high] = polygon::bounds(road.line.cut(from, to)?.points())?;
    let around = Vector::repeat(half);
    Some([low - around, high + around])
}
