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
    /// In all intersections.
    pub everywhere: InsideSettings,
    /// How traffic lights look.
    pub lights: LightSettings,
    /// In single intersections.
    pub intersections: Vec<IntersectionSettings>,
}

/// A place in metres; a place far away from all roads if the projection does not reach it.
pub fn metres(projector: &Projector, [lat, lon]: Place) -> Point {
    projector.forward(LonLat { lon, lat }, 0.0).unwrap_or(Point::new(f64::MAX.sqrt(), f64::MAX.sqrt()))
}

/// What a user may decide about a build.
#[derive(Clone, Debug, Default)]
pub struct BuildOptions {
    /// The side on which people drive; without it, that of the country in which the data lies.
    pub driving_side: Option<DrivingSide>,
    /// The country; without it, that in which the data lies. A tile has the country of the whole data.
    pub country: Option<Country>,
    /// How degrees become metres; without it, MGRS, or a transverse Mercator if the data does not fit one square.
    pub projector: Option<Projector>,
    /// How roads and intersections are laid out.
    pub streets: StreetOptions,
    /// The ground; without it, the ground is level.
    pub terrain: Option<Arc<Terrain>>,
    /// What is drawn beside the lanes for cars.
    pub beside: BesideSettings,
    /// What is drawn inside intersections.
    pub inside: Inside,
    /// What is painted where the tags do not tell.
    pub markings: MarkingSettings,
    /// What is assumed of roads where the tags do not tell.
    pub assume: Vec<AssumeSettings>,
    /// Tags that replace those of OpenStreetMap. A file of streets ignores them.
    pub roads: Vec<RoadSettings>,
    /// Whose reading of the requirements the map follows.
    pub profile: Profile,
    /// Roads that the user merges (`true`) or keeps apart (`false`). A file of streets ignores them.
    pub merges: Vec<(MergeSettings, bool)>,
    /// Ids that no element gets, because two elements have the same hash.
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
    /// How many of the notes are guesses.
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
