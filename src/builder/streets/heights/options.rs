//! Options of heights, and how finely they are sampled.

use crate::builder::network::Road;
use crate::builder::tags::road_class::RoadClass;
use crate::geometry::Point;

use super::elevation_tags::ElevationTags;

use std::sync::Arc;

/// Height from one level to the next, metres: 4.5 m of clearance, usual in most countries, and the deck.
pub const STOREY: f64 = 6.0;
/// Heights are averaged over this distance to either side, metres, so that the grade changes gradually.
pub(super) const ROUNDED: f64 = 15.0;

/// Distance between the samples of a road's height, metres.
pub(super) const SAMPLE_STEP: f64 = 5.0;
/// [`ROUNDED`] in steps.
pub(super) const ROUNDED_SAMPLES: usize = (ROUNDED / SAMPLE_STEP) as usize;
/// Smaller differences in height get no vertex, metres.
pub(super) const TOLERANCE: f64 = 0.02;

/// Options and sources of heights.
#[derive(Clone)]
pub struct HeightOptions {
    /// Height of the ground if it is unknown, metres.
    pub ground: f64,
    /// Height from one level to the next, metres.
    pub storey: f64,
    /// Steepest ramp, metres per metre; if absent, by the class of the road.
    pub grade: Option<f64>,
    /// Steepest road on steep ground, metres per metre; if absent, by the class of the road.
    pub steepest: Option<f64>,
    /// Heights of nodes, from `ele`.
    pub spots: ElevationTags,
    /// A terrain model.
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
    /// Steepest ramp of a road, metres per metre: by class as in design manuals.
    pub(super) fn grade_of(&self, road: &Road) -> f64 {
        let usual = match road.class {
            RoadClass::Motorway | RoadClass::Trunk if !road.link => 0.05,
            RoadClass::Motorway | RoadClass::Trunk | RoadClass::Primary => 0.07,
            RoadClass::Secondary | RoadClass::Tertiary => 0.08,
            _ => 0.12,
        };
        self.grade.unwrap_or(usual)
    }

    /// Steepest road on steep ground, metres per metre: by class about the steepest that exist.
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

/// Heights at points of the local plane, metres; `None` where unknown.
pub type Surface = dyn Fn(&[Point]) -> Vec<Option<f64>> + Send + Sync;
