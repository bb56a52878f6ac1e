//! Traffic lights and signs, as they are beside and over the road.

use super::canvas::Canvas;
use super::lanes::positions;
use crate::geometry::{Vector, left_of};
use crate::lanelet::{LaneletMap, LineString, LineStringId};
use crate::report::levels::Level;

/// Below this many pixels per metre signals are left out.
const DETAIL_SCALE: f64 = 1.5;

/// Draws lights with their lamps on the side they face, and signs.
pub fn signals(canvas: &mut Canvas, level: &Level) {
    if canvas.view.scale < DETAIL_SCALE {
        return;
    }
    let map = level.map;
    for line in &level.lines {
        match line.attributes.get("type") {
            Some("traffic_light") => light(canvas, map, line),
            Some("traffic_sign") => sign(canvas, map, line),
            _ => {}
        }
    }
    // Above the bodies that they belong to.
    for bulbs in level.lines.iter().filter(|line| line.attributes.is("type", "light_bulbs")) {
        arrows(canvas, map, bulbs);
    }
}

/// The arrows of a light, beside it on the side that it faces, as its driver sees them from above.
fn arrows(canvas: &mut Canvas, map: &LaneletMap, bulbs: &LineString) {
    let id = bulbs.attributes.get("traffic_light_id").and_then(|id| id.parse().ok());
    let Some(light) = id.and_then(|id| map.linestrings.get(LineStringId(id))) else { return };
    let points = positions(map, &light.points);
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return };
    let (right, ahead) = (last - first, left_of(last - first));
    let pointed = bulbs.points.iter().filter_map(|&id| {
        let heading = match map.points.get(id)?.attributes().get("arrow")? {
            "left" => -right,
            "right" => right,
            "up" => ahead,
            "up_left" => ahead - right,
            "up_right" => ahead + right,
            _ => return None,
        };
        Some(heading)
    });
    let pointed: Vec<Vector> = pointed.collect();
    let r = (canvas.view.scale * 0.3).clamp(1.4, 5.0);
    let [unit, behind] =
        [right, ahead].map(|v| v.try_normalize(f64::EPSILON).unwrap_or_default() * (r / canvas.view.scale));
    for (i, heading) in pointed.iter().enumerate() {
        let place = nalgebra::center(&first, &last)
            + behind * 2.6
            + unit * (2.6 * (i as f64 - (pointed.len() - 1) as f64 / 2.0));
        canvas.disc("lamp-rim", place, r * 1.25, "");
        let shape = [(1.1, 0.0), (0.0, -0.9), (0.0, -0.35), (-1.0, -0.35), (-1.0, 0.35), (0.0, 0.35), (0.0, 0.9)];
        canvas.stamp(
            "green",
            place,
            *heading,
            &shape.map(|(x, y)| (x * r, y * r)),
            &format!("light_bulbs {}", bulbs.id),
        );
    }
}

/// A light runs from left to right as its driver sees it, so it faces to the right of its own direction.
fn light(canvas: &mut Canvas, map: &LaneletMap, line: &LineString) {
    let points = positions(map, &line.points);
    let (Some(&first), Some(&last)) = (points.first(), points.last()) else { return };
    let along = last - first;
    let middle = nalgebra::center(&first, &last);
    let title = format!("traffic_light {} {}", line.attributes.get("subtype").unwrap_or_default(), line.id);
    canvas.line("lamp-body", &points, &title);
    let r = (canvas.view.scale * 0.3).clamp(1.4, 5.0);
    let facing = -left_of(along);
    let beak: Vec<(f64, f64)> = vec![(2.6 * r, 0.0), (0.0, -1.6 * r), (0.0, 1.6 * r)];
    canvas.stamp("lamp-rim", middle, facing, &beak, &title);
    let lamps: &[&str] = match line.attributes.get("subtype") {
        Some("red_green") => &["red", "green"],
        Some("red") => &["red"],
        Some("white") => &["white"],
        _ => &["red", "yellow", "green"],
    };
    let unit = if along.norm() > 0.0 { along.normalize() } else { Vector::new(1.0, 0.0) };
    let step = 2.1 * r / canvas.view.scale;
    for (i, lamp) in lamps.iter().enumerate() {
        let offset = (i as f64 - (lamps.len() - 1) as f64 / 2.0) * step;
        canvas.disc("lamp-rim", middle + unit * offset, r * 1.25, "");
        canvas.disc(lamp, middle + unit * offset, r * 0.9, &title);
    }
}

fn sign(canvas: &mut Canvas, map: &LaneletMap, line: &LineString) {
    let points = positions(map, &line.points);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return };
    let subtype = line.attributes.get("subtype").unwrap_or_default();
    let r = (canvas.view.scale * 0.5).clamp(3.0, 9.0);
    let octagon: Vec<(f64, f64)> = (0..8)
        .map(|i| (f64::from(i) + 0.5) * std::f64::consts::FRAC_PI_4)
        .map(|angle| (r * angle.cos(), r * angle.sin()))
        .collect();
    let class = if subtype.contains("stop") { "halt" } else { "sign" };
    let middle = nalgebra::center(first, last);
    canvas.stamp(class, middle, Vector::new(1.0, 0.0), &octagon, &format!("traffic_sign {subtype} {}", line.id));
}
