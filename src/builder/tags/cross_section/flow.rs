//! Whether a way is one-way: by `oneway`, its class and roundabouts; and the direction that access tags close to cars.

use crate::builder::tags::admission::{Admitted, OPPOSITE, OneWay, admission};

use super::{StripKind, Travel, WayFacts};

/// The directions of motor traffic on a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flow {
    /// Both directions, each on its own side.
    TwoWay,
    /// Only along the way.
    Forward,
    /// Only against the way.
    Backward,
    /// One direction at a time, on all lanes.
    Alternating,
}

impl Flow {
    /// Whether all motor traffic runs in one direction.
    pub fn is_oneway(self) -> bool {
        matches!(self, Self::Forward | Self::Backward)
    }

    /// The direction against which all motor traffic runs.
    pub fn against(self) -> Option<Travel> {
        match self {
            Self::Forward => Some(Travel::Backward),
            Self::Backward => Some(Travel::Forward),
            _ => None,
        }
    }
}

/// The flow of a way by its one-way tags. Buses may drive against it.
pub(super) fn flow(facts: &WayFacts<'_>) -> Flow {
    match admission(facts.tags, facts.class, facts.link).one_way {
        OneWay::Forward => Flow::Forward,
        OneWay::Backward => Flow::Backward,
        OneWay::Alternating | OneWay::Reversible => Flow::Alternating,
        OneWay::No => Flow::TwoWay,
    }
}

/// The use of the lanes in the only direction that access tags close to cars, forward or backward: of buses, or nobody's.
pub(super) fn closed_direction(facts: &WayFacts<'_>) -> Option<(Travel, StripKind)> {
    let admitted = admission(facts.tags, facts.class, facts.link);
    let open = if facts.bus_road { Admitted::Buses } else { Admitted::Private };
    let use_of = |admitted| if admitted == Admitted::Buses { StripKind::Bus } else { StripKind::Buffer };
    match (admitted.forward >= open, admitted.backward >= open) {
        (true, false) => Some((Travel::Backward, use_of(admitted.backward))),
        (false, true) => Some((Travel::Forward, use_of(admitted.forward))),
        // A lane against the traffic: who tags it without `oneway` means a one-way road.
        _ if OPPOSITE.iter().any(|key| facts.tags.is(key, "opposite_lane")) && !facts.tags.has("oneway") => {
            Some((Travel::Backward, StripKind::Bus))
        }
        _ => None,
    }
}

/// Whether only buses may drive in this direction.
pub(super) fn is_for_buses(facts: &WayFacts<'_>, travel: Travel) -> bool {
    let admitted = admission(facts.tags, facts.class, facts.link);
    let toward = if travel == Travel::Forward { admitted.forward } else { admitted.backward };
    toward == Admitted::Buses
}
