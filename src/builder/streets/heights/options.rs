//! What may be decided about heights, and how finely they are sampled.

use crate::builder::network::Road;
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::Point;

use super::elevation_tags::ElevationTags;

use std::sync::Arc;

/// Height from one level to the next, metres: 4.5 m of clearance, as most countries ask for, and the deck.
pub const STOREY: f64 = 6.0;
/// Heights are averaged over this distance, metres, to either side, so that the grade does not change at once.
pub(super) const ROUNDED: f64 = 15.0;

/// Distance, metres, between the places of a road at which its height is worked out.
pub(super) const STEP: f64 = 5.0;
/// As many steps.
pub(super) const REACH: usize = (ROUNDED / STEP) as usize;
/// A road's line gets no vertex for what changes its height by less than this, metres.
pub(super) const TOLERANCE: f64 = 0.02;

/// What heights are made from.
#[derive(Clone)]
pub struct HeightOptions {
    /// Height of the ground where nothing is known of it, metres.
    pub ground: f64,
    /// Height from one level to the next, metres.
    pub storey: f64,
    /// Steepest ramp, metres per metre; by the class of the road where absent.
    pub grade: Option<f64>,
    /// Steepest road, metres per metre, where the ground is steeper than a ramp may be; by the class where absent.
    pub steepest: Option<f64>,
    /// Heights that the input's nodes give.
    pub spots: ElevationTags,
    /// The ground by a terrain model.
    pub terrain: Option<Arc<Surface>>,
}

impl Default for HeightOptions {
    fn default() -> Self {
        Self {
            ground: 0.0,
            storey: STOREY,
            grade: None,
            steepest: None,
            spots: ElevationTags::default(),
            terrain: None,
        }
    }
}

impl std::fmt::Debug for HeightOptions {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HeightOptions")
            .field("ground", &self.ground)
            .field("storey", &self.storey)
            .field("grade", &self.grade)
            .field("steepest", &self.steepest)
            .field("terrain", &self.terrain.is_some())
            .finish_non_exhaustive()
    }
}

impl HeightOptions {
    /// Steepest ramp on a road, metres per metre: what design manuals allow for the class.
    pub(super) fn grade_of(&self, road: &Road) -> f64 {
        let usual = match road.class {
            RoadClass::Motorway | RoadClass::Trunk if !road.link => 0.05,
            RoadClass::Motorway | RoadClass::Trunk | RoadClass::Primary => 0.07,
            RoadClass::Secondary | RoadClass::Tertiary => 0.08,
            _ => 0.12,
        };
        self.grade.unwrap_or(usual)
    }

    /// Steepest road of a class, metres per metre, on ground that is steep: about the steepest that exist.
    pub(super) fn steepest_of(&self, road: &Road) -> f64 {
        let usual = match road.class {
            RoadClass::Motorway | RoadClass::Trunk if !road.link => 0.1,
            RoadClass::Motorway | RoadClass::Trunk | RoadClass::Primary => 0.15,
            RoadClass::Secondary | RoadClass::Tertiary => 0.2,
            _ => 0.3,
        };
        self.steepest.unwrap_or(usual).max(self.grade_of(road))
    }
}

/// Heights at places of the plane, metres; `None` where nothing is known.
pub type Surface = dyn Fn(&[Point]) -> Vec<Option<f64>> + Send + Sync;
