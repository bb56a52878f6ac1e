//! What a map contains, in numbers: counts, lengths, widths, curvature, and what of it hangs together.

mod network;
mod spread;

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Serialize;

pub use network::Network;
pub use spread::Spread;

use crate::geometry::{Polyline, angle_between};
use crate::lanelet::index::{HEADING_STEP, Lane, MapIndex, lets_vehicles_in};
use crate::lanelet::{Attributes, LaneletMap};

/// The numbers of one map. Serialises as `stats --format json` prints it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stats {
    /// How many points, linestrings, polygons, lanelets, areas and regulatory elements.
    pub primitives: BTreeMap<&'static str, usize>,
    /// Lanelets by `subtype`.
    pub lanelets: BTreeMap<String, SubtypeStats>,
    /// Linestrings by `type`.
    pub linestrings: BTreeMap<String, usize>,
    /// Polygons by `type`.
    pub polygons: BTreeMap<String, usize>,
    /// Areas by `subtype`.
    pub areas: BTreeMap<String, usize>,
    /// Regulatory elements by `subtype`.
    pub regulatory_elements: BTreeMap<String, usize>,
    /// Width of vehicle lanes in metres, measured every metre.
    pub width: Option<Spread>,
    /// Curvature of the centre lines of vehicle lanes in 1/m, without its sign, measured every metre.
    pub curvature: Option<Spread>,
    /// Length of vehicle lanelets in metres.
    pub length: Option<Spread>,
    /// How the vehicle lanes hang together.
    pub network: Network,
    /// How much there is of what Autoware's planner reads; 0 is what the map lacks.
    pub content: Vec<Content>,
}

/// Lanelets of one subtype.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct SubtypeStats {
    /// How many.
    pub count: usize,
    /// Length of their centre lines, metres.
    pub metres: f64,
}

/// One thing that a map may contain.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Content {
    /// In a few words.
    pub what: &'static str,
    /// How many.
    pub count: usize,
}

impl Stats {
    /// Counts and measures a map.
    pub fn of(index: &MapIndex<'_>) -> Self {
        let map = index.map;
        let vehicle: Vec<&Lane> = index.lanes.iter().filter(|lane| lane.vehicle).collect();
        let centres = || vehicle.iter().filter_map(|lane| lane.center.as_ref());
        Self {
            primitives: primitives(map),
            lanelets: lanelets(index),
            linestrings: tally(map.linestrings.iter().map(|l| &l.attributes), "type"),
            polygons: tally(map.polygons.iter().map(|p| &p.attributes), "type"),
            areas: tally(map.areas.iter().map(|a| &a.attributes), "subtype"),
            regulatory_elements: tally(map.regulatory_elements.iter().map(|r| &r.attributes), "subtype"),
            width: Spread::of(vehicle.iter().flat_map(|lane| widths(lane)).collect()),
            curvature: Spread::of(centres().flat_map(curvatures).collect()),
            length: Spread::of(centres().map(Polyline::length).collect()),
            network: Network::of(index),
            content: content(map),
        }
    }

    /// The numbers as a page for a terminal.
    pub fn text(&self) -> String {
        let mut out = String::new();
        // Writing to a string cannot fail.
        let _ = writeln!(out, "Primitives");
        for (name, count) in &self.primitives {
            let _ = writeln!(out, "  {name:<28}{count:>8}");
        }
        let _ = writeln!(out, "\nLanelets");
        for (subtype, kind) in &self.lanelets {
            let _ = writeln!(out, "  {:<28}{:>8}   {:>9.3} km", word(subtype), kind.count, kind.metres / 1000.0);
        }
        for (title, tally) in [
            ("Linestrings", &self.linestrings),
            ("Polygons", &self.polygons),
            ("Areas", &self.areas),
            ("Regulatory elements", &self.regulatory_elements),
        ] {
            if !tally.is_empty() {
                let _ = writeln!(out, "\n{title}");
            }
            for (name, count) in tally {
                let _ = writeln!(out, "  {:<28}{count:>8}", word(name));
            }
        }
        let _ = writeln!(out, "\nVehicle lanes            least      5 %   median     95 %     most");
        for (name, spread) in
            [("length, m", &self.length), ("width, m", &self.width), ("curvature, 1/m", &self.curvature)]
        {
            if let Some(Spread { min, p5, median, p95, max, .. }) = spread {
                let _ = writeln!(out, "  {name:<19}{min:>9.3}{p5:>9.3}{median:>9.3}{p95:>9.3}{max:>9.3}");
            }
        }
        let _ = write!(out, "\n{}", self.network.text());
        let lacks: Vec<&str> = self.content.iter().filter(|one| one.count == 0).map(|one| one.what).collect();
        let _ = writeln!(out, "\nContains");
        for Content { what, count } in self.content.iter().filter(|one| one.count > 0) {
            let _ = writeln!(out, "  {what:<28}{count:>8}");
        }
        if !lacks.is_empty() {
            let _ = writeln!(out, "\nLacks\n  {}", lacks.join(", "));
        }
        out
    }
}

/// A tag's value as a terminal may show it.
fn word(value: &str) -> String {
    if value.is_empty() { "(none)".to_owned() } else { super::visible(value).into_owned() }
}

fn primitives(map: &LaneletMap) -> BTreeMap<&'static str, usize> {
    BTreeMap::from([
        ("points", map.points.len()),
        ("linestrings", map.linestrings.len()),
        ("polygons", map.polygons.len()),
        ("lanelets", map.lanelets.len()),
        ("areas", map.areas.len()),
        ("regulatory elements", map.regulatory_elements.len()),
    ])
}

fn tally<'a>(all: impl Iterator<Item = &'a Attributes>, key: &str) -> BTreeMap<String, usize> {
    let mut counts = BTreeMap::new();
    for attributes in all {
        *counts.entry(attributes.get(key).unwrap_or_default().to_owned()).or_default() += 1;
    }
    counts
}

fn lanelets(index: &MapIndex<'_>) -> BTreeMap<String, SubtypeStats> {
    let mut kinds = BTreeMap::<String, SubtypeStats>::new();
    for lanelet in &index.map.lanelets {
        let kind = kinds.entry(lanelet.attributes.get("subtype").unwrap_or_default().to_owned()).or_default();
        kind.count += 1;
        let center = index.lane_of(lanelet.id).and_then(|lane| lane.center.as_ref());
        kind.metres += center.map_or(0.0, Polyline::length);
    }
    kinds
}

/// Distances between the bounds at as many places along the lane as it has metres.
fn widths(lane: &Lane) -> Vec<f64> {
    let (Some(left), Some(right)) = (lane.border(0), lane.border(1)) else { return Vec::new() };
    let count = pieces(left.length().max(right.length())) + 1;
    let (left, right) = (left.resampled_to(count), right.resampled_to(count));
    left.points().iter().zip(right.points()).map(|(l, r)| (l - r).norm()).collect()
}

/// Change of heading per metre between pieces of a metre.
fn curvatures(center: &Polyline) -> Vec<f64> {
    let even = center.resampled_to(pieces(center.length()) + 1);
    let segments: Vec<_> = even.segments().map(|(a, b)| b - a).collect();
    let bends = segments.windows(2).filter_map(|pair| {
        let [a, b] = pair else { return None };
        let length = (a.norm() + b.norm()) / 2.0;
        (length > Polyline::MERGE).then(|| angle_between(*a, *b).abs() / length)
    });
    bends.collect()
}

/// How many pieces of about a metre a length has; broken coordinates must not cost memory.
fn pieces(length: f64) -> usize {
    const MOST: f64 = 10_000.0;
    (length / HEADING_STEP).round().clamp(1.0, MOST) as usize
}

fn content(map: &LaneletMap) -> Vec<Content> {
    let lines = |kind: &str| map.linestrings.iter().filter(|l| l.attributes.is("type", kind)).count();
    let polygons = |kind: &str| map.polygons.iter().filter(|p| p.attributes.is("type", kind)).count();
    let rules = |subtype: &str| map.regulatory_elements.iter().filter(|r| r.subtype == subtype).count();
    let tagged = |key: &str| map.lanelets.iter().filter(|l| l.attributes.has(key)).count();
    let says = |key: &str, value: &str| map.lanelets.iter().filter(|l| l.attributes.is(key, value)).count();
    let subtype = |value: &str| map.lanelets.iter().filter(|l| l.attributes.is("subtype", value)).count();
    let all = [
        ("heights", map.points.iter().filter(|p| p.ele().is_some()).count()),
        ("speed limits", tagged("speed_limit")),
        ("turn directions", tagged("turn_direction")),
        ("intersection areas", polygons("intersection_area")),
        ("rights of way", rules("right_of_way")),
        ("traffic lights", rules("traffic_light")),
        ("light bulbs", lines("light_bulbs")),
        ("stop lines", lines("stop_line")),
        ("traffic signs", rules("traffic_sign")),
        ("crosswalks", subtype("crosswalk")),
        ("crosswalk rules", rules("crosswalk")),
        ("road shoulders", subtype("road_shoulder")),
        ("bicycle lanes", subtype("bicycle_lane")),
        ("pedestrian lanes", subtype("pedestrian_lane")),
        ("road borders", lines("road_border")),
        ("detection areas", rules("detection_area")),
        ("no stopping areas", rules("no_stopping_area")),
        ("no parking areas", rules("no_parking_area")),
        ("speed bumps", rules("speed_bump")),
        ("virtual traffic lights", rules("virtual_traffic_light")),
        ("roundabout elements", rules("roundabout")),
        ("lanes to reverse in", says("direction_change", "yes")),
        ("lanes not to drive in", says("no_drivable_lane", "yes")),
        ("areas to cross", map.areas.iter().filter(|area| lets_vehicles_in(area)).count()),
        ("landmarks", polygons("pose_marker")),
        ("obstacle removal areas", polygons("obstacle_removal_area")),
    ];
    all.into_iter().map(|(what, count)| Content { what, count }).collect()
}

#[cfg(test)]
mod tests;
