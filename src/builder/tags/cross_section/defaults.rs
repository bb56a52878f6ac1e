//! What is assumed of a road where its tags are silent: the usual of its class, unless the settings say otherwise.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::settings::{AssumeSettings, Highway};

/// A sidewalk, metres.
pub(crate) const SIDEWALK: f64 = 1.5;

/// What holds for all roads of a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Customs<'a> {
    /// The side people drive on.
    pub side: DrivingSide,
    /// ISO 3166-1 code of the country.
    pub country: Option<&'a str>,
    /// What the user assumes; of two that speak of a road, the first.
    pub assume: &'a [AssumeSettings],
}

impl Customs<'_> {
    /// What is assumed of a road.
    pub fn defaults(&self, class: RoadClass, link: bool) -> Defaults {
        let usual = Defaults::of(class);
        let Some(highway) = (!self.assume.is_empty()).then(|| highway(class, link)) else { return usual };
        let about: Vec<_> = self.assume.iter().filter(|said| said.is_about(highway, self.country)).collect();
        let said = |of: fn(&AssumeSettings) -> Option<f64>| about.iter().find_map(|said| of(said));
        Defaults {
            lanes: about.iter().find_map(|said| said.lanes).map(usize::from),
            speed: said(|s| s.speed),
            lane: said(|s| s.lane_width).unwrap_or(usual.lane),
            bicycle_lane: said(|s| s.bicycle_lane_width).unwrap_or(usual.bicycle_lane),
            bicycle_track: said(|s| s.bicycle_track_width).unwrap_or(usual.bicycle_track),
            parking: said(|s| s.parking_width).unwrap_or(usual.parking),
            shoulder: said(|s| s.shoulder_width).unwrap_or(usual.shoulder),
            pedestrian_lane: said(|s| s.pedestrian_lane_width).unwrap_or(usual.pedestrian_lane),
            sidewalk: said(|s| s.sidewalk_width).unwrap_or(usual.sidewalk),
        }
    }
}

/// What is assumed of a road where its tags are silent. Widths are metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Defaults {
    /// Lanes in each direction, where the user says it.
    pub lanes: Option<usize>,
    /// Speed limit, km/h, where the user says it.
    pub speed: Option<f64>,
    /// A lane for motor vehicles.
    pub lane: f64,
    /// A painted bicycle lane.
    pub bicycle_lane: f64,
    /// A bicycle track behind a kerb.
    pub bicycle_track: f64,
    /// Cars parked along the road.
    pub parking: f64,
    /// A tagged shoulder; that of a motorway or trunk road is wide enough to stop on.
    pub shoulder: f64,
    /// A painted strip for people on foot.
    pub pedestrian_lane: f64,
    /// A sidewalk.
    pub sidewalk: f64,
}

impl Defaults {
    /// The usual of a class.
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
