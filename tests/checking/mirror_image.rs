//! A mirrored map, with traffic on the other side, has the same findings: no rule treats left and right differently.

use std::path::Path;

use lanewright::diagnostic::{Diagnostic, Severity};
use lanewright::geometry::Point;
use lanewright::lanelet::{
    Bound, Condition, Lanelet, LaneletMap, LoadFault, Loaded, Primitive, PrimitiveLayer, TurnDirection,
};
use lanewright::settings::{Settings, Side};

use crate::common::judging::{judge, load};
use crate::common::needs::shared;
use crate::common::{hand_made_maps, rule_maps};

/// The mirrored map: east becomes west, left bounds become right ones, left turns right turns.
fn mirrored(loaded: &Loaded) -> Loaded {
    let map = &loaded.map;
    let points = changed(&map.points, |point| {
        point.position = Point::new(-point.position.x, point.position.y);
    });
    // The way of a light runs from left to right as its driver sees it.
    let linestrings = changed(&map.linestrings, |line| {
        if line.attributes.is("type", "traffic_light") || line.attributes.is("subtype", "red_yellow_green") {
            line.points.reverse();
        }
    });
    let lanelets = changed(&map.lanelets, |lanelet: &mut Lanelet| {
        let Lanelet { left, right, attributes, .. } = lanelet;
        std::mem::swap::<Bound>(left, right);
        let turn = attributes.get("turn_direction").and_then(TurnDirection::parse);
        let turn = match turn {
            Some(TurnDirection::Left) => TurnDirection::Right,
            Some(TurnDirection::Right) => TurnDirection::Left,
            _ => return,
        };
        attributes.set("turn_direction", turn.as_str());
    });
    // Outlines stay clockwise.
    let areas = changed(&map.areas, |area| {
        area.points.reverse();
        area.outer.reverse();
        area.outer.iter_mut().for_each(|line| line.inverted = !line.inverted);
    });
    let faults = loaded.faults.iter().cloned().map(|fault| match fault.condition {
        Condition::BoundsOpposed { left, right } => {
            LoadFault { condition: Condition::BoundsOpposed { left: right, right: left }, ..fault }
        }
        _ => fault,
    });
    let faults = faults.collect();
    Loaded { map: LaneletMap { points, linestrings, lanelets, areas, ..map.clone() }, faults }
}

fn changed<T: Primitive + Clone>(shelf: &PrimitiveLayer<T>, change: impl Fn(&mut T)) -> PrimitiveLayer<T> {
    let mut shelf_of_changed = PrimitiveLayer::default();
    for item in shelf {
        let mut item = item.clone();
        change(&mut item);
        shelf_of_changed.insert(item);
    }
    shelf_of_changed
}

/// What must be the same: fault, severity, subject. Measures may differ by the last digits.
fn essence(diagnostics: &[Diagnostic]) -> Vec<(String, Severity, String)> {
    let mut all: Vec<_> =
        diagnostics.iter().map(|d| (d.code.clone(), d.severity, d.finding.subject.to_string())).collect();
    all.sort();
    all
}

fn holds(path: &Path) {
    let (_, loaded) = load(path);
    let mirror = mirrored(&loaded);
    for [side, other] in [[Side::Auto, Side::Auto], [Side::Left, Side::Right], [Side::Right, Side::Left]] {
        let settings = |side| Settings { driving_side: Some(side), ..Settings::default() };
        let (here, there) = (judge(&loaded, &settings(side)), judge(&mirror, &settings(other)));
        assert_eq!(essence(&here), essence(&there), "{} driving {side:?}", path.display());
    }
}

#[test]
fn every_map_of_the_rules_is_the_same_in_the_mirror() {
    let maps = rule_maps("");
    assert!(maps.len() > 150, "only {} maps", maps.len());
    maps.iter().for_each(|path| holds(path));
}

#[test]
fn every_official_map_is_the_same_in_the_mirror() {
    let sample = shared("corpus/conformance/map/sample_map.osm");
    hand_made_maps().iter().chain(&sample).for_each(|path| holds(path));
}
