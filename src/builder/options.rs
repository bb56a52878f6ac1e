//! What a user may decide about a build, and the streets that a map is built from.

use crate::diagnostic::Finding;
use crate::geometry::Point;
use crate::projection::{LonLat, Projector};
use crate::settings::{
    AssumeSettings, BesideSettings, InsideSettings, IntersectionSettings, LightSettings, MarkingSettings,
    MergeSettings, Place, Profile, RoadSettings,
};
use crate::terrain::Terrain;

use super::streets::heights::HeightOptions;
use super::streets::{StreetOptions, Streets};
use super::tags::driving_side::Country;
use super::tags::road_class::DrivingSide;

use std::collections::BTreeSet;
use std::sync::Arc;

/// What a user wants drawn inside intersections.
#[derive(Clone, Debug, Default)]
pub struct Inside {
    /// In all of them.
    pub everywhere: InsideSettings,
    /// How traffic lights look.
    pub lights: LightSettings,
    /// In single ones.
    pub intersections: Vec<IntersectionSettings>,
}

/// A place in metres; far away from everything where the projection does not reach it.
pub fn metres(projector: &Projector, [lat, lon]: Place) -> Point {
    projector.forward(LonLat { lon, lat }, 0.0).unwrap_or(Point::new(f64::MAX.sqrt(), f64::MAX.sqrt()))
}

/// What a user may decide about a build.
#[derive(Clone, Debug, Default)]
pub struct BuildOptions {
    /// Which side people drive on; from the place where absent.
    pub driving_side: Option<DrivingSide>,
    /// The country of all data that these are a part of; from the place where absent.
    pub country: Option<Country>,
    /// How to turn degrees into metres; MGRS or a transverse Mercator, whichever suits the place, where absent.
    pub projector: Option<Projector>,
    /// How roads and intersections are laid out.
    pub streets: StreetOptions,
    /// The ground; level where absent.
    pub terrain: Option<Arc<Terrain>>,
    /// What is drawn beside the lanes for cars.
    pub beside: BesideSettings,
    /// What is drawn inside intersections.
    pub inside: Inside,
    /// What is painted where the tags are silent.
    pub markings: MarkingSettings,
    /// What is assumed of roads where the input is silent.
    pub assume: Vec<AssumeSettings>,
    /// Tags that stand in the place of OpenStreetMap's. A file of streets has its lanes already.
    pub roads: Vec<RoadSettings>,
    /// Whose reading of the requirements the map follows where readings differ.
    pub profile: Profile,
    /// Roads that the user decided to merge (`true`) or to keep apart. A file of streets is merged already.
    pub merges: Vec<(MergeSettings, bool)>,
    /// Ids that two elements want, so that neither gets them.
    pub contested: BTreeSet<i64>,
}

/// Streets and the plane they lie in: all that a map is built from.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Roads and intersections on the ground.
    pub streets: Streets,
    /// How their metres relate to degrees.
    pub projector: Projector,
    /// What was guessed or left out.
    pub notes: Vec<Finding>,
    /// How much of that the input did not say.
    pub guesses: usize,
    /// What is to be drawn inside intersections.
    pub inside: Inside,
    /// How steep roads may be.
    pub heights: HeightOptions,
    /// Whose reading of the requirements the map follows.
    pub profile: Profile,
    /// Ids that two elements want, so that neither gets them.
    pub contested: BTreeSet<i64>,
}
