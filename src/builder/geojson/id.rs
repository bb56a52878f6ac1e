//! The id and the place of a feature.

use crate::osm::Text;
use serde::Serialize;

/// Longitude and latitude in degrees; metres until the file is written and after it is read.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FeaturePlace(pub [f64; 2]);

/// The id of a feature: text, or a number that is read as text.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
pub struct FeatureId(pub Text);
