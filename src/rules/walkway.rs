//! Walkways: which piece of one lies on lanes, and who may use it.

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, Polyline, polygon, segment_crossing};
use crate::lanelet::index::{Lane, MapIndex};
use crate::lanelet::{LaneletId, RoadType};

/// A walkway that reaches by less over the edge of a lane, metres, ends at its kerb and does not cross it.
const LEAST_CROSSED: f64 = 1.0;

/// So close, metres, does the middle of a bound lie to that of a road of which it is a copy.
const COPIED: f64 = 0.3;

/// From where to where along a walkway lanes lie under it, metres from its start; `None` if none does, or it only reaches over a kerb.
pub fn crossed<'a>(walkway: &Lane, lanes: impl IntoIterator<Item = &'a Lane<'a>>) -> Option<[f64; 2]> {
    let center = walkway.center.as_ref()?;
    let (mut range, mut area) = ([f64::INFINITY, 0.0_f64], 0.0);
    for lane in lanes {
        let inside = polygon::intersection(&walkway.outline, &lane.outline);
        area += geo::Area::unsigned_area(&inside);
        for corner in geo::CoordsIter::coords_iter(&inside) {
            let station = center.project(Point::new(corner.x, corner.y)).station;
            range = [range[0].min(station), range[1].max(station)];
        }
    }
    let width = walkway.area / walkway.length();
    (area >= LEAST_CROSSED * width).then_some(range)
}

/// Whether the middle of a walkway leads over an edge of a lane: a pavement beside the lane may overlap it a little and does not.
pub fn leads_over(walkway: &Lane, lane: &Lane) -> bool {
    let Some(center) = &walkway.center else { return false };
    let crosses = |edge: &[Point]| {
        let pieces = edge.iter().zip(edge.iter().skip(1));
        pieces.into_iter().any(|(&c, &d)| center.segments().any(|(a, b)| segment_crossing(a, b, c, d).is_some()))
    };
    crosses(&lane.left) || crosses(&lane.right)
}

/// The finding with the fix that makes a strip at the side of the road of a walkway, on which people go along and not across. Such a
/// strip has a border in common with the road: a path elsewhere is none.
pub fn as_pedestrian_lane(map: &MapIndex, finding: Finding, id: LaneletId) -> Finding {
    if !borders_a_road(map, id) {
        return finding;
    }
    let on = Subject::Lanelet(id.0);
    let set = Edit::SetTag { on, key: "subtype".into(), value: "pedestrian_lane".into() };
    let edits = walking_allowed(map, id).into_iter().chain([set]).collect();
    finding.fixed_by("set subtype=pedestrian_lane, for people who walk along the road", false, edits)
}

/// Whether a bound of a walkway is that of a road lanelet, or runs along it.
fn borders_a_road(map: &MapIndex, id: LaneletId) -> bool {
    let Some(walkway) = map.lane_of(id) else { return false };
    let is_road = |lane: usize| map.lanes[lane].kind == RoadType::Road;
    if walkway.bounds.iter().flat_map(|&bound| map.users_of(bound)).any(|&lane| is_road(lane)) {
        return true;
    }
    let middles: Vec<Point> = [&walkway.left, &walkway.right]
        .into_iter()
        .filter_map(|bound| Polyline::new(bound.iter().copied()))
        .map(|bound| bound.at(bound.length() / 2.0))
        .collect();
    let runs_along = |edge: &[Point]| {
        let edge = Polyline::new(edge.iter().copied());
        edge.is_some_and(|edge| middles.iter().any(|&middle| edge.distance(middle) < COPIED))
    };
    let [low, high] = walkway.extent;
    let near = map.lanes_near(low, high).into_iter().filter(|&lane| is_road(lane));
    near.map(|lane| &map.lanes[lane]).any(|lane| runs_along(&lane.left) || runs_along(&lane.right))
}

/// The edit that lets people on foot use a lanelet that does not say whether they may, as each lanelet of a crosswalk element has to.
pub fn walking_allowed(map: &MapIndex, id: LaneletId) -> Option<Edit> {
    let lanelet = map.map.lanelets.get(id)?;
    let on = Subject::Lanelet(id.0);
    let key = "participant:pedestrian";
    (!lanelet.attributes.has(key)).then(|| Edit::SetTag { on, key: key.into(), value: "yes".into() })
}
