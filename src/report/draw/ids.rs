//! The ids of lanelets, intersection areas and regulatory elements, where they can be read.

use super::canvas::{Canvas, bounding_box};
use super::labels::Labels;
use super::lanes::{centre_line, positions};
use super::style;
use crate::geometry::Point;
use crate::lanelet::{LaneletMap, Target};
use crate::report::levels::Levels;

/// How far behind the middle of a lane its id is, metres.
const BEHIND_ARROW: f64 = 2.5;
/// Where along a lanelet (1) its id may stand, the best place first. The paths of an intersection fan out toward their ends.
const ALONG_TURN: [f64; 7] = [0.68, 0.78, 0.58, 0.88, 0.48, 0.35, 0.22];
/// The same for a plain lane, behind the place [`BEHIND_ARROW`] of its middle.
const ALONG_LANE: [f64; 6] = [0.35, 0.65, 0.2, 0.8, 0.1, 0.9];
/// How far ids of regulatory elements are lifted from their stop line: so many times their height, the best first.
const LIFTS: [f64; 6] = [1.4, -1.4, 3.0, -3.0, 4.6, -4.6];

/// Writes the ids of intersection areas, of lanelets, and of regulatory elements at their stop line. One that finds no room between
/// the others, or whose lanelet lies wholly beneath another, is left out.
pub fn ids(canvas: &mut Canvas, map: &LaneletMap, levels: &Levels, labels: &mut Labels) {
    let height = (canvas.view.scale * 0.6).clamp(5.0, 9.0);
    for polygon in map.polygons.iter().filter(|p| style::area(&p.attributes) == "box") {
        if let Some(middle) = middle(&positions(map, &polygon.points)).filter(|at| canvas.view.sees([at])) {
            labels.write(canvas, "id-area", middle, 0.0, &polygon.id.to_string(), height * 1.3);
        }
    }
    for (lanelet, &level) in map.lanelets.iter().zip(&levels.lanelets) {
        let Some(centre) = centre_line(map, lanelet).filter(|line| canvas.view.sees(line.points())) else { continue };
        let turning = style::turn(&lanelet.attributes).is_some();
        let length = centre.length();
        let shares: &[f64] = if turning { &ALONG_TURN } else { &ALONG_LANE };
        let first = (!turning).then(|| (length * 0.5 + BEHIND_ARROW).min(length));
        let class = if turning { "id-turn" } else { "id-lane" };
        let places = first.into_iter().chain(shares.iter().map(|share| length * share)).map(|along| centre.at(along));
        let view = canvas.view;
        let mut seen = places.filter(|place| view.sees([place]) && !levels.is_covered(*place, level));
        seen.find(|place| labels.write(canvas, class, *place, 0.0, &lanelet.id.to_string(), height));
    }
    for element in &map.regulatory_elements {
        let line = element.members.iter().find_map(|m| match m.target {
            Target::LineString(id) if m.role == "ref_line" || m.role == "refers" => map.linestrings.get(id),
            _ => None,
        });
        let middle = line.and_then(|line| middle(&positions(map, &line.points)));
        let Some(middle) = middle.filter(|at| canvas.view.sees([at])) else { continue };
        let text = element.id.to_string();
        LIFTS.iter().find(|lift| labels.write(canvas, "id-rule", middle, *lift * height, &text, height));
    }
}

/// The middle of the box around some points.
fn middle(points: &[Point]) -> Option<Point> {
    bounding_box(points).map(|(min, max)| nalgebra::center(&min, &max))
}
