//! Defaults for missing tags: how wide lanes are, by class, and what the settings assume. How many lanes there are, `lanes` tells.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::settings::{AssumeSettings, Highway};

/// The width of a sidewalk, metres.
pub(crate) const SIDEWALK: f64 = 1.5;

/// What all roads of a region have in common.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Customs<'a> {
    /// The driving side.
    pub side: DrivingSide,
    /// ISO 3166-1 code of the country.
    pub country: Option<&'a str>,
    /// The assumptions of the user. The first that applies to a road counts.
    pub assume: &'a [AssumeSettings],
}

impl Customs<'_> {
    /// The defaults of a road.
    pub fn defaults(&self, class: RoadClass, link: bool) -> Defaults {
        let usual = Defaults::of(class);
        let Some(highway) = (!self.assume.is_empty()).then(|| highway(class, link)) else { return usual };
        let settings: Vec<_> = self.assume.iter().filter(|entry| entry.is_about(highway, self.country)).collect();
        let first = |of: fn(&AssumeSettings) -> Option<f64>| settings.iter().find_map(|entry| of(entry));
        Defaults {
            lanes: settings.iter().find_map(|entry| entry.lanes).map(usize::from),
            speed: first(|s| s.speed),
            lane: first(|s| s.lane_width).unwrap_or(usual.lane),
            bicycle_lane: first(|s| s.bicycle_lane_width).unwrap_or(usual.bicycle_lane),
            bicycle_track: first(|s| s.bicycle_track_width).unwrap_or(usual.bicycle_track),
            parking: first(|s| s.parking_width).unwrap_or(usual.parking),
            shoulder: first(|s| s.shoulder_width).unwrap_or(usual.shoulder),
            pedestrian_lane: first(|s| s.pedestrian_lane_width).unwrap_or(usual.pedestrian_lane),
            sidewalk: first(|s| s.sidewalk_width).unwrap_or(usual.sidewalk),
        }
    }
}

/// The defaults of a road for missing tags. Widths are metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defaults {
    /// The number of lanes in each direction, if the user sets it.
    pub lanes: Option<usize>,
    /// The speed limit, km/h, if the user sets it.
    pub speed: Option<f64>,
    /// A lane for motor vehicles.
    pub lane: f64,
    /// A painted bicycle lane.
    pub bicycle_lane: f64,
    /// A bicycle track behind a kerb.
    pub bicycle_track: f64,
    /// Parallel parking.
    pub parking: f64,
    /// A shoulder. On a motorway or trunk road a vehicle can stop on it.
    pub shoulder: f64,
    /// A painted lane for people on foot.
    pub pedestrian_lane: f64,
    /// A sidewalk.
    pub sidewalk: f64,
}

impl Defaults {
    /// The defaults of a class.
    pub fn of(class: RoadClass) -> Self {
        let lane = match class {
            RoadClass::Motorway | RoadClass::Trunk => 3.5,
            RoadClass::Service | RoadClass::Track => 2.75,
            _ => 3.0,
        };
        Self {
            lanes: None,
            speed: None,
            lane,
            bicycle_lane: 1.5,
            bicycle_track: 2.0,
            parking: 2.2,
            shoulder: if class <= RoadClass::Trunk { 2.5 } else { 1.0 },
            pedestrian_lane: 1.5,
            sidewalk: SIDEWALK,
        }
    }
}

/// The value of `highway` for a class.
fn highway(class: RoadClass, link: bool) -> Highway {
    match (class, link) {
        (RoadClass::Motorway, false) => Highway::Motorway,
        (RoadClass::Motorway, true) => Highway::MotorwayLink,
        (RoadClass::Trunk, false) => Highway::Trunk,
        (RoadClass::Trunk, true) => Highway::TrunkLink,
        (RoadClass::Primary, false) => Highway::Primary,
        (RoadClass::Primary, true) => Highway::PrimaryLink,
        (RoadClass::Secondary, false) => Highway::Secondary,
        (RoadClass::Secondary, true) => Highway::SecondaryLink,
        (RoadClass::Tertiary, false) => Highway::Tertiary,
        (RoadClass::Tertiary, true) => Highway::TertiaryLink,
        (RoadClass::Unclassified, _) => Highway::Unclassified,
        (RoadClass::Residential, _) => Highway::Residential,
        (RoadClass::LivingStreet, _) => Highway::LivingStreet,
        (RoadClass::Service, _) => Highway::Service,
        (RoadClass::Track, _) => Highway::Track,
    }
}
