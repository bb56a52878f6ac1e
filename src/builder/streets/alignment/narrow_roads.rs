//! Narrows roads that still overlap side by side, if their widths were guessed.
//!
//! A default width is an average: where the drawing leaves less room, the lanes are narrower. Tagged widths stay, and no lane
//! becomes narrower than its class needs.

use crate::builder::network::{IntersectionIx, Road, RoadNetwork, Stations};
use crate::builder::streets::outline::{overlap, overlapping};
use crate::builder::tags::cross_section::{CrossSection, Strip, StripKind, minimum_lane_width};
use crate::builder::tags::road_class::RoadClass;
use crate::diagnostic::{Finding, Place, Severity, Subject};

/// Steps of the bisection for the widest cross-section that fits.
const HALVINGS: usize = 5;

/// The network with overlapping roads narrowed, and a finding for each road that lost width. `kept` has the stations between
/// which each road remains.
#[must_use]
pub fn narrow_roads(mut network: RoadNetwork, kept: &[Stations]) -> (RoadNetwork, Vec<Finding>) {
    let before: Vec<f64> = network.roads.iter().map(|road| road.section.width()).collect();
    let kept = with_dead_ends(&network, kept);
    for roads in overlapping(&network, &kept) {
        narrow_pair(&mut network, &kept, roads);
    }
    let findings = network.roads.iter().zip(before).filter_map(|(road, before)| finding(road, before)).collect();
    (network, findings)
}

/// The stations with the dead ends included: they are as wide as their road.
fn with_dead_ends(network: &RoadNetwork, kept: &[Stations]) -> Vec<Stations> {
    let ends = |end: IntersectionIx| network.intersection(end).arms.len() == 1;
    let extended = |(road, [from, to]): (&Road, &Stations)| {
        [if ends(road.from) { 0.0 } else { *from }, if ends(road.to) { road.line.length() } else { *to }]
    };
    network.roads.iter().zip(kept).map(extended).collect()
}

/// Narrows two roads, or one of them if that is enough, by the least that separates them; not at all if nothing does.
fn narrow_pair(network: &mut RoadNetwork, kept: &[Stations], roads: [usize; 2]) {
    let old = roads.map(|road| network.roads[road].section.clone());
    let mut separates = |shares: [f64; 2]| {
        for ((road, old), share) in roads.into_iter().zip(&old).zip(shares) {
            let Road { section, class, .. } = &mut network.roads[road];
            *section = narrow(old, *class, share);
        }
        !overlap(network, kept, roads)
    };
    if !separates([1.0; 2]) {
        separates([0.0; 2]);
        return;
    }
    let (mut too_little, mut enough) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let share = f64::midpoint(too_little, enough);
        if separates([share; 2]) { enough = share } else { too_little = share }
    }
    // If one road ends at the other, only the width of the other counts.
    if !separates([enough, 0.0]) && !separates([0.0, enough]) {
        separates([enough; 2]);
    }
}

/// How much narrower a strip may become, metres.
fn room_of(strip: &Strip, class: RoadClass) -> f64 {
    if strip.width_guessed { (strip.width - least(strip.kind, class)).max(0.0) } else { 0.0 }
}

/// Least width of a strip, metres.
fn least(kind: StripKind, class: RoadClass) -> f64 {
    match kind {
        StripKind::Drive => minimum_lane_width(class),
        StripKind::Bus => minimum_lane_width(class).max(2.75),
        StripKind::Parking => 1.8,
        StripKind::Bicycle | StripKind::Pedestrian | StripKind::Sidewalk => 1.0,
        StripKind::Shoulder | StripKind::Buffer => 0.2,
    }
}

/// The section narrowed by this share of what its strips can spare.
fn narrow(section: &CrossSection, class: RoadClass, share: f64) -> CrossSection {
    let mut section = section.clone();
    for strip in &mut section.strips {
        strip.width -= share * room_of(strip, class);
    }
    section
}

fn finding(road: &Road, before: f64) -> Option<Finding> {
    let (way, after) = (road.key.way, road.section.width());
    if after == before {
        return None;
    }
    let message = format!(
        "way {way} is made {after:.2} m wide instead of {before:.2} m, a guess, because of the road drawn beside it"
    );
    let middle = road.line.at(road.line.length() / 2.0);
    Some(Finding::new("width-narrowed", Subject::Way(way), message).at(Place::Point(middle)).graded(Severity::Info))
}
