//! Lights where none can be for those who obey them: below the road, or far from the stop line.

use crate::diagnostic::{Finding, Place, Subject};
use crate::geometry::{Point, Vector, polygon, polyline};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Spot, View, spot};
use crate::lanelet::{LineString, RegulatoryElement};

use super::exchanged_lights::edge_at;

/// Whether a lanelet lies within some metres of a place.
pub fn is_near(map: &MapIndex, lane: usize, place: Point, most: f64) -> bool {
    let outline = &map.lanes[lane].outline;
    let edge: Vec<Point> = outline.iter().chain(outline.first()).copied().collect();
    polyline::reaches(&edge, place, most, &mut 0) || polygon::contains(outline, place)
}

/// A light that lies deeper than this, metres, under the lowest road for vehicles within reach.
pub fn below_road(map: &MapIndex, light: &LineString, reach: f64, depth: f64) -> Option<Finding> {
    let points = map.view().points(light);
    let (first, last) = (points.first()?, points.last()?);
    let low = first.ele()?.min(last.ele()?);
    let middle = nalgebra::center(&first.position, &last.position);
    let around = Vector::repeat(reach);
    let near = map.lanes_near(middle - around, middle + around).into_iter();
    let roads = near.filter(|&lane| map.lanes[lane].vehicle && is_near(map, lane, middle, reach));
    let ground = roads.filter_map(|lane| map.height(lane, middle)).min_by(f64::total_cmp)?;
    let under = ground - low;
    (under > depth).then(|| {
        let message = format!("Traffic light {} lies {under:.1} m below the road.", light.id);
        let finding = Finding::new("below-road", Subject::LineString(light.id.0), message);
        finding.measured(under, depth, "m").at(Place::Point(middle))
    })
}

/// The lights of an element that stand farther from its stop line than this, metres: beside the way on which its vehicles come, or ahead
/// or behind.
pub fn far_from_stop_line(map: &MapIndex, element: &RegulatoryElement, [aside, ahead]: [f64; 2]) -> Vec<Finding> {
    let view = map.view();
    let lines: Vec<[Spot; 2]> = view.lines(element, "ref_line").filter_map(|line| ends(view, line)).collect();
    let lanes = view.referrers(element.id).iter().map(|&at| &view.lanelets[at]).filter(|seen| seen.is("road"));
    let across: Vec<([Spot; 2], Vector)> = lanes
        .flat_map(|seen| lines.iter().filter_map(|&line| Some((line, edge_at(map, seen, line)?.xy()))))
        .filter_map(|(line, edge)| Some((line, edge.try_normalize(f64::EPSILON)?)))
        .collect();
    let lights = view.lines(element, "refers").filter(|line| line.attributes.is("type", "traffic_light"));
    let far = lights.filter_map(|light| {
        let [left, right] = ends(view, light)?;
        let place = nalgebra::center(&left, &right).xy();
        let away = |&(line, across): &([Spot; 2], Vector)| {
            let from = place - nalgebra::center(&line[0], &line[1]).xy();
            let half = (line[1] - line[0]).norm() / 2.0;
            let beside = (from.dot(&across).abs() - half).max(0.0);
            [beside, (from - across * from.dot(&across)).norm()]
        };
        let is_far = |&[beside, along]: &[f64; 2]| beside > aside || along > ahead;
        let distances: Vec<[f64; 2]> = across.iter().map(away).collect();
        let &[beside, along] = distances.first().filter(|_| distances.iter().all(is_far))?;
        let (value, limit, side) = if beside > aside { (beside, aside, "beside") } else { (along, ahead, "from") };
        let on = Subject::LineString(light.id.0);
        let message = format!(
            "Traffic light {} stands {value:.0} m {side} the stop line at which vehicles obey it (traffic_light {}).",
            light.id, element.id
        );
        let finding = Finding::new("far", on, message).with(Subject::RegulatoryElement(element.id.0), "element");
        Some(finding.measured(value, limit, "m").at(Place::Point(place)))
    });
    far.collect()
}

/// The first and the last point of a line.
fn ends(view: &View, line: &LineString) -> Option<[Spot; 2]> {
    let points = view.points(line);
    Some([spot(points.first()?), spot(points.last()?)])
}
