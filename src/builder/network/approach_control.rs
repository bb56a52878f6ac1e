//! What controls an arm of an intersection, and the sign that stands before an end of a road.

use crate::builder::tags::cross_section::Travel;

use super::{End, FeatureKind, Road};

/// A sign on a road belongs to the intersection up to this distance, metres, from the road's end.
const SIGN_REACH: f64 = 40.0;

/// What controls an arm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Control {
    /// Lights.
    Signals,
    /// A stop sign.
    Stop,
    /// A give-way sign.
    GiveWay,
    /// Nothing.
    None,
}

impl Control {
    /// The subtype of its sign; Autoware halts at `stop_sign` and passes others.
    pub fn sign(self) -> Option<&'static str> {
        match self {
            Self::Stop => Some("stop_sign"),
            Self::GiveWay => Some("give_way"),
            Self::Signals | Self::None => None,
        }
    }
}

/// The sign before an end of a road.
pub fn sign_at(road: &Road, end: End) -> Control {
    let length = road.line.length();
    let into = end.inbound();
    let mut control = Control::None;
    for feature in &road.features {
        let depth = if end == End::Start { feature.station } else { length - feature.station };
        let (travel, kind) = match feature.kind {
            FeatureKind::Stop(travel) => (travel, Control::Stop),
            FeatureKind::GiveWay(travel) => (travel, Control::GiveWay),
            _ => continue,
        };
        let faces = travel == into || (travel == Travel::Both && depth <= length / 2.0);
        if faces && depth <= SIGN_REACH && control != Control::Stop {
            control = kind;
        }
    }
    control
}
