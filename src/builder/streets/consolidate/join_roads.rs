//! Two roads that continue each other without any change become one.
//!
//! OpenStreetMap cuts a way where any tag changes: a name, a surface, a bus route. Where nothing changes that a lane
//! shows, there is no reason for a seam.

use std::borrow::Cow;

use crate::builder::network::{End, Feature, FeatureKind, IntersectionIx, Road, RoadEnd, RoadKey, RoadNetwork};
use crate::builder::tags::cross_section::{CrossSection, Strip, Travel};
use crate::builder::tags::marking;
use crate::builder::tags::road_class::is_priority_road;
use crate::geometry::{Polyline, angle_between};

use super::network_edit::NetworkEdit;

/// Ends of two lines further apart than this (metres) are not one place: `placement` shifts them.
const SAME_PLACE: f64 = 0.01;
/// Roads that turn more than this from one to the other, radians, are not one: 120 degrees.
const SHARPEST: f64 = 2.0 * std::f64::consts::FRAC_PI_3;

/// Joins roads at every intersection of exactly two that are alike.
pub fn join_alike(network: RoadNetwork) -> RoadNetwork {
    let mut edit = NetworkEdit::new(network);
    for at in edit.intersections() {
        join_at(&mut edit, at);
    }
    edit.finish()
}

fn join_at(edit: &mut NetworkEdit, at: IntersectionIx) -> Option<()> {
    let intersection = edit.intersection(at);
    let &[one, two] = intersection.arms.as_slice() else { return None };
    if one.road == two.road
        || intersection.map_edge
        || intersection.signals
        || intersection.circle.is_some()
        || !intersection.inner.is_empty()
    {
        return None;
    }
    // `a` arrives, `b` leaves; both are turned so that their lines run that way.
    let (a_arm, b_arm) = if edit.road(one.road).key <= edit.road(two.road).key { (one, two) } else { (two, one) };
    let [a, b] = [edit.road(a_arm.road), edit.road(b_arm.road)];
    if !alike_either_way(a, b) {
        return None;
    }
    let a = directed(a, a_arm.end == End::End);
    let b = directed(b, b_arm.end == End::Start);
    if !alike(&a, &b) || (a.line.last() - b.line.first()).norm() > SAME_PLACE {
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

/// Whether `b` leads back beside `a`: carriageways of a divided road where the map ends, not one road.
fn doubles_back(a: &Polyline, b: &Polyline) -> bool {
    angle_between(a.direction(a.length()), b.direction(0.0)).abs() > SHARPEST
}

/// The road, its line turned around unless `keep`.
pub fn directed(road: &Road, keep: bool) -> Cow<'_, Road> {
    if keep { Cow::Borrowed(road) } else { Cow::Owned(reversed(road)) }
}

/// The same road with its line turned around.
fn reversed(road: &Road) -> Road {
    let length = road.line.length();
    let mut features: Vec<Feature> = road
        .features
        .iter()
        .map(|f| Feature { station: length - f.station, node: f.node, kind: turned(f.kind) })
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

/// The same cross-section seen against the line.
fn reversed_section(section: &CrossSection) -> CrossSection {
    let strips = section.strips.iter().rev().map(|s| Strip { travel: against(s.travel), ..s.clone() });
    CrossSection { strips: strips.collect() }
}

fn against(travel: Travel) -> Travel {
    match travel {
        Travel::Forward => Travel::Backward,
        Travel::Backward => Travel::Forward,
        Travel::Both => Travel::Both,
    }
}

fn turned(kind: FeatureKind) -> FeatureKind {
    match kind {
        FeatureKind::Crossing { .. } | FeatureKind::Sidewalk => kind,
        FeatureKind::Signals(travel) => FeatureKind::Signals(against(travel)),
        FeatureKind::Stop(travel) => FeatureKind::Stop(against(travel)),
        FeatureKind::GiveWay(travel) => FeatureKind::GiveWay(against(travel)),
        FeatureKind::StopLine(travel) => FeatureKind::StopLine(against(travel)),
    }
}

/// Whether nothing changes from one road to the next that does not depend on which way their lines run.
fn alike_either_way(a: &Road, b: &Road) -> bool {
    let told = |road: &Road| (road.class, road.link, road.roundabout, road.public, road.section.strips.len());
    told(a) == told(b) && a.level == b.level
}

/// Whether nothing changes from one road to the next that a lane shows. Arrows may: they belong to the road's end.
fn alike(a: &Road, b: &Road) -> bool {
    let same_strips = a.section.strips.iter().zip(&b.section.strips).all(|(s, t)| {
        (s.kind, s.travel, s.change) == (t.kind, t.travel, t.change)
            && s.arrows == t.arrows
            && (s.width - t.width).abs() < SAME_PLACE
    });
    alike_either_way(a, b)
        && same_strips
        && a.speed == b.speed
        && marking::alike(&a.tags, &b.tags)
        && is_priority_road(&a.tags) == is_priority_road(&b.tags)
}

fn joined(a: Road, b: Road) -> Option<Road> {
    let length = a.line.length();
    let mut features = a.features;
    for feature in b.features {
        // What stands on the shared node stands on both roads.
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
