//! Joins two roads that continue each other if their lanes are the same.
//!
//! OpenStreetMap splits a way where any tag changes: a name, a surface, a bus route.

use std::borrow::Cow;

use crate::builder::network::{End, Feature, IntersectionIx, Road, RoadEnd, RoadKey, RoadNetwork};
use crate::builder::tags::cross_section::{CrossSection, Strip, Travel};
use crate::builder::tags::marking;
use crate::builder::tags::road_class::is_priority_road;
use crate::geometry::{Polyline, angle_between};

use super::network_edit::NetworkEdit;

/// The largest distance between the ends of two lines that continue each other, metres: `placement` may shift them.
const SAME_PLACE: f64 = 0.01;
/// The largest turn from one road to the next, radians: 120 degrees.
const SHARPEST: f64 = 2.0 * std::f64::consts::FRAC_PI_3;

/// Joins the two roads of every intersection that has only these, if their lanes are the same.
pub fn join_alike(network: RoadNetwork) -> RoadNetwork {
    let mut edit = NetworkEdit::new(network);
    let forbidden = edit.forbidden_joints();
    for ix in edit.intersections().filter(|ix| !forbidden.contains(ix)) {
        join_at(&mut edit, ix);
    }
    edit.finish()
}

fn join_at(edit: &mut NetworkEdit, ix: IntersectionIx) -> Option<()> {
    let intersection = edit.intersection(ix);
    let &[one, two] = intersection.arms.as_slice() else { return None };
    if one.road == two.road
        || intersection.map_edge
        || intersection.signals
        || intersection.circle.is_some()
        || !intersection.inner.is_empty()
    {
        return None;
    }
    // `a` leads here and `b` away; their lines are turned that way.
    let (a_arm, b_arm) = if edit.road(one.road).key <= edit.road(two.road).key { (one, two) } else { (two, one) };
    let [a, b] = [edit.road(a_arm.road), edit.road(b_arm.road)];
    if !same_class(a, b) {
        return None;
    }
    let a = directed(a, a_arm.end == End::End);
    let b = directed(b, b_arm.end == End::Start);
    if !same_lanes(&a, &b) || (a.line.last() - b.line.first()).norm() > SAME_PLACE {
        return None;
    }
    if doubles_back(&a.line, &b.line) {
        return None;
    }
    let road = joined(a.into_owned(), b.into_owned())?;
    edit.join([a_arm.road, b_arm.road], road, |end: RoadEnd| match end {
        end if end == a_arm || end == b_arm => None,
        end if end.road == a_arm.road => Some(End::Start),
        _ => Some(End::End),
    });
    Some(())
}

/// Whether `b` leads back beside `a`, like the carriageways of a dual carriageway at the edge of the map.
fn doubles_back(a: &Polyline, b: &Polyline) -> bool {
    angle_between(a.direction(a.length()), b.direction(0.0)).abs() > SHARPEST
}

/// The road, its line turned around unless `keep`.
pub fn directed(road: &Road, keep: bool) -> Cow<'_, Road> {
    if keep { Cow::Borrowed(road) } else { Cow::Owned(reversed(road)) }
}

/// The road with its line turned around.
fn reversed(road: &Road) -> Road {
    let length = road.line.length();
    let mut features: Vec<Feature> = road
        .features
        .iter()
        .map(|f| Feature { station: length - f.station, node: f.node, kind: f.kind.map_travel(Travel::reversed) })
        .collect();
    features.reverse();
    Road {
        key: RoadKey { first: road.key.last, last: road.key.first, ..road.key },
        from: road.to,
        to: road.from,
        line: road.line.reversed(),
        heights: road.heights.iter().rev().copied().collect(),
        section: reversed_section(&road.section),
        speed: [road.speed[1], road.speed[0]],
        features,
        tags: marking::turned(&road.tags),
        ..road.clone()
    }
}

/// The cross-section as seen against the line.
fn reversed_section(section: &CrossSection) -> CrossSection {
    let strips = section.strips.iter().rev().map(|s| Strip { travel: s.travel.reversed(), ..s.clone() });
    CrossSection { strips: strips.collect() }
}

/// Whether two roads agree in all that does not depend on the direction of their lines.
fn same_class(a: &Road, b: &Road) -> bool {
    let class = |road: &Road| (road.class, road.link, road.roundabout, road.public, road.section.strips.len());
    class(a) == class(b) && a.level == b.level
}

/// Whether the lanes of two roads are the same.
fn same_lanes(a: &Road, b: &Road) -> bool {
    let same_strips = a.section.strips.iter().zip(&b.section.strips).all(|(s, t)| {
        (s.kind, s.travel, s.change) == (t.kind, t.travel, t.change)
            && s.arrows == t.arrows
            && s.speed == t.speed
            && s.bicycles == t.bicycles
            && (s.width - t.width).abs() < SAME_PLACE
    });
    same_class(a, b)
        && same_strips
        && a.speed == b.speed
        && marking::alike(&a.tags, &b.tags)
        && is_priority_road(&a.tags) == is_priority_road(&b.tags)
}

fn joined(a: Road, b: Road) -> Option<Road> {
    let length = a.line.length();
    let mut features = a.features;
    for feature in b.features {
        // Both roads have the features of the shared node.
        if !features.iter().any(|f| f.node == feature.node && f.kind == feature.kind) {
            features.push(Feature { station: feature.station + length, ..feature });
        }
    }
    let mut ways = a.ways;
    ways.extend(b.ways);
    ways.dedup();
    Some(Road {
        key: RoadKey { last: b.key.last, ..a.key },
        ways,
        line: Polyline::new(a.line.points().iter().chain(b.line.points()).copied())?,
        to: b.to,
        features,
        ..a
    })
}
