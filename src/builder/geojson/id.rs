//! The id and the position of a feature.

use crate::osm::Text;
use serde::Serialize;

/// Longitude and latitude in degrees in the file; metres before writing and after reading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeaturePlace(pub [f64; 2]);

/// The id of a feature: text. A number is read as text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct FeatureId(pub Text);
