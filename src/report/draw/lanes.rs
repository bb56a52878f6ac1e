//! Surfaces, markings and direction arrows.

use crate::geometry::{Point, Polyline, polygon};
use crate::lane_stitching::{Colour, Kind, Strokes};
use crate::lanelet::index::lets_vehicles_in;
use crate::lanelet::{Lanelet, LaneletMap, LineString, RoadType};
use crate::report::levels::Level;

use super::canvas::Canvas;
use super::style;
use super::style::Stroke;

/// Below this many pixels per metre, arrows and invisible bounds are left out: they would only be noise.
const DETAIL_SCALE: f64 = 1.5;
/// A zebra's stripe and the gap behind it, metres each; half a metre is common all over the world.
const ZEBRA_STRIPE: f64 = 0.5;
/// One arrow on a plain lane every so many metres.
const ARROW_SPACING: f64 = 25.0;
/// Points along a centre line, metres apart.
const CENTRE_STEP: f64 = 0.8;

/// Fills the areas of polygons of one kind.
pub fn polygons(canvas: &mut Canvas, level: &Level, intersections: bool) {
    for polygon in &level.polygons {
        let class = style::area(&polygon.attributes);
        if (class == "box") == intersections {
            let ring = positions(level.map, &polygon.points);
            let kind = polygon.attributes.get("type").unwrap_or("polygon");
            canvas.area(class, &ring, &format!("{kind} {}", polygon.id));
        }
    }
}

/// Fills the areas: those that vehicles may cross as a road would be, the others as ground.
pub fn areas(canvas: &mut Canvas, level: &Level) {
    for area in &level.areas {
        let class = if lets_vehicles_in(area) { style::PASSAGE } else { "lot" };
        let kind = area.attributes.get("subtype").map_or_else(|| "area".to_owned(), |kind| format!("area, {kind}"));
        canvas.area(class, &positions(level.map, &area.points), &format!("{kind} {}", area.id));
    }
}

/// Fills the ground within closed kerbs in intersections.
pub fn islands(canvas: &mut Canvas, level: &Level) {
    let intersections = level.polygons.iter().filter(|polygon| style::area(&polygon.attributes) == "box");
    let rings: Vec<Vec<Point>> = intersections.map(|polygon| positions(level.map, &polygon.points)).collect();
    for line in &level.lines {
        let is_closed = line.points.len() > 3 && line.points.first() == line.points.last();
        if is_closed && matches!(style::stroke(&line.attributes), Stroke::True(Kind::Kerb, _)) {
            let kerb = positions(level.map, &line.points);
            let is_inside = |ring: &Vec<Point>| kerb.first().is_some_and(|place| polygon::contains(ring, *place));
            if rings.iter().any(is_inside) {
                canvas.area("ground", &kerb, &format!("island {}", line.id));
            }
        }
    }
}

/// Fills all lanelets but crosswalks; turns as the road they run over.
pub fn surfaces(canvas: &mut Canvas, level: &Level) {
    for lanelet in level.lanelets.iter().filter(|l| !is_crosswalk(l)) {
        let class =
            if style::turn(&lanelet.attributes).is_some() { "road" } else { style::surface(&lanelet.attributes) };
        canvas.area(&format!("{class} seam"), &level.map.outline(lanelet), &title(lanelet));
    }
}

/// Lays the hues of the turns over the road; where turns cross, both shine through.
pub fn turns(canvas: &mut Canvas, level: &Level) {
    for lanelet in level.lanelets.iter().filter(|l| style::turn(&l.attributes).is_some()) {
        canvas.area(style::surface(&lanelet.attributes), &level.map.outline(lanelet), &title(lanelet));
    }
}

/// Draws the crosswalks, which lie on top of everything that drives.
pub fn crosswalks(canvas: &mut Canvas, level: &Level) {
    for lanelet in level.lanelets.iter().filter(|l| is_crosswalk(l)) {
        canvas.area(style::surface(&lanelet.attributes), &level.map.outline(lanelet), &title(lanelet));
        zebra(canvas, level.map, lanelet);
    }
}

fn is_crosswalk(lanelet: &Lanelet) -> bool {
    RoadType::of(&lanelet.attributes) == RoadType::Crosswalk
}

/// The stripes of a crosswalk: each reaches from bound to bound.
fn zebra(canvas: &mut Canvas, map: &LaneletMap, lanelet: &Lanelet) {
    if canvas.view.scale < DETAIL_SCALE || !canvas.view.sees(&map.outline(lanelet)) {
        return;
    }
    let bounds = (Polyline::new(map.bound_line(lanelet.left)), Polyline::new(map.bound_line(lanelet.right)));
    let (Some(left), Some(right)) = bounds else { return };
    let length = left.length().max(right.length());
    let pairs = (length / ZEBRA_STRIPE).floor().clamp(1.0, MAX_STEPS) as usize;
    let (left, right) = (left.resampled_to(pairs + 1), right.resampled_to(pairs + 1));
    for i in (0..pairs).step_by(2) {
        let (l, r) = (left.points(), right.points());
        canvas.area("zebra", &[l[i], l[i + 1], r[i + 1], r[i]], "");
    }
}

/// Most pieces one line is cut into, however long bad data makes it.
const MAX_STEPS: f64 = 10_000.0;

/// Draws every linestring by its type: bounds, kerbs, stop lines.
pub fn markings(canvas: &mut Canvas, level: &Level) {
    let (over, under): (Vec<_>, Vec<_>) =
        level.lines.iter().partition(|l| matches!(style::stroke(&l.attributes), Stroke::Single("stop")));
    for line in under.into_iter().chain(over) {
        marking(canvas, level.map, line);
    }
}

fn marking(canvas: &mut Canvas, map: &LaneletMap, line: &LineString) {
    let points = positions(map, &line.points);
    let kind = line.attributes.get("type").unwrap_or("linestring");
    let title = match line.attributes.get("subtype") {
        Some(subtype) => format!("{kind} {subtype} {}", line.id),
        None => format!("{kind} {}", line.id),
    };
    match style::stroke(&line.attributes) {
        Stroke::Single("virtual") if canvas.view.scale < DETAIL_SCALE => {}
        Stroke::Single(class) => canvas.line(class, &points, &title),
        Stroke::True(kind, class) => {
            let strokes = Strokes::along(&points, kind);
            let yellow = strokes.iter().any(|stroke| stroke.colour == Colour::Yellow);
            let class = if yellow { format!("{class} {}", style::YELLOW) } else { class.to_owned() };
            canvas.lines(&class, strokes.iter().map(|stroke| stroke.line), &title);
        }
        Stroke::Elsewhere => {}
    }
}

/// Draws where traffic goes: the whole path of a turn, small arrows on a plain lane.
pub fn arrows(canvas: &mut Canvas, level: &Level) {
    if canvas.view.scale < DETAIL_SCALE {
        return;
    }
    let map = level.map;
    for lanelet in &level.lanelets {
        let walked = matches!(
            RoadType::of(&lanelet.attributes),
            RoadType::Crosswalk | RoadType::Walkway | RoadType::PedestrianLane | RoadType::Shoulder
        );
        if walked || !canvas.view.sees(&map.outline(lanelet)) {
            continue;
        }
        let Some(centre) = centre_line(map, lanelet) else { continue };
        let class = style::arrow(&lanelet.attributes);
        canvas.line(&format!("path {class}"), centre.points(), &title(lanelet));
        let length = centre.length();
        let stations: Vec<f64> = if class == "plain" {
            let count = (length / ARROW_SPACING).round().clamp(1.0, MAX_STEPS) as usize;
            (0..count).map(|i| length * (i as f64 + 0.5) / count as f64).collect()
        } else {
            // Off the middle, where all paths of an intersection cross.
            vec![length * 0.8]
        };
        for station in stations {
            tip(canvas, &centre, station, class);
        }
    }
}

fn tip(canvas: &mut Canvas, centre: &Polyline, station: f64, class: &str) {
    let s = (canvas.view.scale * 0.55).clamp(2.5, 16.0);
    let shape: &[(f64, f64)] = &[(1.3 * s, 0.0), (-0.9 * s, -0.8 * s), (-0.45 * s, 0.0), (-0.9 * s, 0.8 * s)];
    canvas.stamp(&format!("tip {class}"), centre.at(station), centre.direction(station), shape, "");
}

/// The midpoints between both bounds, evenly cut.
pub fn centre_line(map: &LaneletMap, lanelet: &Lanelet) -> Option<Polyline> {
    let left = Polyline::new(map.bound_line(lanelet.left))?;
    let right = Polyline::new(map.bound_line(lanelet.right))?;
    let pieces = (left.length().max(right.length()) / CENTRE_STEP).ceil().clamp(1.0, MAX_STEPS) as usize;
    let (left, right) = (left.resampled_to(pieces + 1), right.resampled_to(pieces + 1));
    Polyline::new(left.points().iter().zip(right.points()).map(|(l, r)| nalgebra::center(l, r)))
}

/// Where the points of a way lie.
pub fn positions(map: &LaneletMap, ids: &[crate::lanelet::PointId]) -> Vec<Point> {
    ids.iter().filter_map(|&id| map.points.get(id)).map(|p| p.position).collect()
}

fn title(lanelet: &Lanelet) -> String {
    let mut title = format!("lanelet {}", lanelet.id);
    for key in ["subtype", "turn_direction", "speed_limit"] {
        if let Some(value) = lanelet.attributes.get(key) {
            title.push_str(" · ");
            title.push_str(value);
        }
    }
    for id in &lanelet.regulatory_elements {
        title.push_str(&format!(" · rule {id}"));
    }
    title
}
