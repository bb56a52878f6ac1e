//! The header of the file: its projector, country and driving side.

use serde::{Deserialize, Serialize};

use crate::builder::network::RoadNetwork;
use crate::builder::tags::road_class::DrivingSide;
use crate::osm::Text;
use crate::projection::{LonLat, Projector};

/// Version of the file format.
pub const FORMAT: u32 = 1;

/// The member `lanewright` of the collection.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Header {
    pub format: u32,
    pub driving_side: Option<DrivingSide>,
    pub country: Option<Text>,
    pub projector: Option<ProjectorShape>,
}

impl Header {
    pub fn new(network: &RoadNetwork, projector: &Projector) -> Self {
        Self {
            format: FORMAT,
            driving_side: Some(network.side),
            country: network.country.clone(),
            projector: ProjectorShape::of(projector),
        }
    }
}

/// A projector as in `map_projector_info.yaml`.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(tag = "projector_type")]
pub enum ProjectorShape {
    #[serde(rename = "MGRS")]
    Mgrs {
        mgrs_grid: Text,
    },
    #[serde(rename = "LocalCartesianUTM")]
    LocalCartesianUtm {
        map_origin: Origin,
    },
    TransverseMercator {
        map_origin: Origin,
        scale_factor: f32,
    },
    LocalCartesian {
        map_origin: Origin,
    },
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Origin {
    pub latitude: f64,
    pub longitude: f64,
}

impl From<LonLat> for Origin {
    fn from(LonLat { lon, lat }: LonLat) -> Self {
        Self { latitude: lat, longitude: lon }
    }
}

impl From<Origin> for LonLat {
    fn from(Origin { latitude, longitude }: Origin) -> Self {
        Self { lon: longitude, lat: latitude }
    }
}

impl ProjectorShape {
    fn of(projector: &Projector) -> Option<Self> {
        Some(match *projector {
            Projector::Mgrs(grid) => Self::Mgrs { mgrs_grid: grid.to_string().into() },
            Projector::LocalCartesianUtm { origin } => Self::LocalCartesianUtm { map_origin: origin.into() },
            Projector::TransverseMercator { origin, scale_factor } => {
                Self::TransverseMercator { map_origin: origin.into(), scale_factor }
            }
            Projector::LocalCartesian { origin } => Self::LocalCartesian { map_origin: origin.into() },
            Projector::Local => return None,
        })
    }

    /// The projector.
    ///
    /// # Errors
    ///
    /// The MGRS grid does not exist.
    pub fn projector(&self) -> Result<Projector, String> {
        Ok(match self {
            Self::Mgrs { mgrs_grid } => Projector::mgrs(mgrs_grid.parse().map_err(|e| format!("mgrs_grid: {e}"))?),
            Self::LocalCartesianUtm { map_origin } => Projector::LocalCartesianUtm { origin: (*map_origin).into() },
            Self::TransverseMercator { map_origin, scale_factor } => {
                Projector::TransverseMercator { origin: (*map_origin).into(), scale_factor: *scale_factor }
            }
            Self::LocalCartesian { map_origin } => Projector::LocalCartesian { origin: (*map_origin).into() },
        })
    }
}
