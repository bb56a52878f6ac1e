//! From tags to strips.

use crate::builder::road_network::{DrivingSide, RoadClass, is_roundabout};
use crate::diagnostic::{Finding, Severity, Subject};
use crate::osm::Tags;

use super::{Arrows, CrossSection, Strip, StripKind, Travel, default_lane_width};

/// A cross-section and where it lies beside OpenStreetMap's line.
#[derive(Clone, Debug)]
pub(crate) struct Layout {
    /// What lies across the road, along the way's direction.
    pub section: CrossSection,
    /// How far the middle of the section lies left of the way's line, metres.
    pub shift: f64,
}

/// Reads the cross-section of a way.
pub(crate) fn layout(
    way: i64,
    tags: &Tags,
    class: RoadClass,
    link: bool,
    bus_road: bool,
    side: DrivingSide,
    notes: &mut Vec<Finding>,
) -> Layout {
    let oneway = match tags.get("oneway") {
        Some("yes" | "true" | "1") => Some(Travel::Forward),
        Some("-1" | "reverse") => Some(Travel::Backward),
        None if class == RoadClass::Motorway || is_roundabout(tags) => Some(Travel::Forward),
        _ => None,
    };
    let number = |key| tags.get(key).and_then(|v: &str| v.parse::<usize>().ok()).map(|n| n.clamp(1, 12));
    let lanes = number("lanes");
    if lanes.is_none() {
        let message = format!("way {way} has no lanes tag; the number is assumed from its class");
        notes.push(Finding::new("lanes-guessed", Subject::Way(way), message).graded(Severity::Info));
    }
    let (forward, backward) = match oneway {
        Some(travel) => {
            let n = lanes.unwrap_or(if class <= RoadClass::Trunk && !link { 2 } else { 1 });
            if travel == Travel::Forward { (n, 0) } else { (0, n) }
        }
        None => {
            let total = lanes.unwrap_or(2).max(2);
            let backward = number("lanes:backward").unwrap_or(total / 2).min(total - 1);
            (total - backward, backward)
        }
    };
    let strip = |travel| Strip {
        kind: if bus_road { StripKind::Bus } else { StripKind::Drive },
        travel,
        width: default_lane_width(class),
        arrows: Arrows::NONE,
        change: [None, None],
        width_guessed: true,
    };
    let (left, right) = match side {
        DrivingSide::Right => ((Travel::Backward, backward), (Travel::Forward, forward)),
        DrivingSide::Left => ((Travel::Forward, forward), (Travel::Backward, backward)),
    };
    let strips = [left, right].into_iter().flat_map(|(travel, n)| (0..n).map(move |_| travel)).map(strip).collect();
    Layout { section: CrossSection { strips }, shift: 0.0 }
}
