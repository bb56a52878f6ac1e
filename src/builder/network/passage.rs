//! Who passes a node, by its barrier and its access tags.

use crate::builder::tags::admission::{Admitted, OF_CARS, admits_buses, of_value};
use crate::builder::tags::cross_section::Travel;
use crate::osm::Tags;

/// Who passes a node that is not open to all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Passage {
    /// No motor vehicle.
    Nobody,
    Buses,
    /// Cars in this direction of the way only.
    OneWay(Travel),
    /// Residents, staff, deliveries: a gate to private ground.
    Private,
    /// All that may use the road: a gate.
    Gate,
}

impl Passage {
    /// Whether the road goes on past it for some, on a piece of its own.
    pub fn is_of_some(self) -> bool {
        matches!(self, Self::Buses | Self::OneWay(_))
    }

    /// Whether the road leads on to some cars.
    pub fn is_gate(self) -> bool {
        matches!(self, Self::Private | Self::Gate)
    }
}

/// Who passes a node; `None` for all.
pub(super) fn passage(tags: &Tags) -> Option<Passage> {
    let [along, against] = [":forward", ":backward"].map(|suffix| passage_toward(tags, suffix));
    let is_closed = |passage| matches!(passage, Some(Passage::Nobody | Passage::Buses));
    match (is_closed(along), is_closed(against)) {
        (false, true) => Some(Passage::OneWay(Travel::Forward)),
        (true, false) => Some(Passage::OneWay(Travel::Backward)),
        (true, true) if along != against => Some(Passage::Buses),
        _ => along.or(against),
    }
}

/// Who passes a node along or against the way on which it lies.
fn passage_toward(tags: &Tags, suffix: &str) -> Option<Passage> {
    let barrier = tags.get("barrier");
    // Beside another feature `access` tells of that, such as the entrance of a building.
    let keys = if barrier.is_some() || is_plain(tags) { &OF_CARS[..] } else { &OF_CARS[..3] };
    let directed = |key: &str| tags.get_joined([key, suffix]).and_then(of_value);
    let stated = keys.iter().find_map(|key| directed(key).or_else(|| tags.get(key).and_then(of_value)));
    let buses = || admits_buses(tags) || ["bus", "psv"].iter().any(|key| directed(key) > Some(Admitted::Nobody));
    match stated {
        Some(Admitted::Nobody) if !buses() => Some(Passage::Nobody),
        Some(Admitted::Nobody | Admitted::Buses) => Some(Passage::Buses),
        Some(Admitted::Private) => barrier.map(|_| Passage::Private),
        Some(Admitted::Public) => barrier.filter(|kind| is_gate(kind)).map(|_| Passage::Gate),
        // Nobody opens it for those who pass by.
        None if barrier.is_some() && tags.is("locked", "yes") => {
            Some(if buses() { Passage::Buses } else { Passage::Nobody })
        }
        // It sinks for those who have a permit.
        None if tags.is("bollard", "rising") && !buses() => Some(Passage::Private),
        // A fence of sound for cattle.
        None if matches!(tags.get("sensory"), Some("audible" | "audio")) => None,
        // Made for the wheels of buses.
        None if matches!(barrier, Some("bus_trap" | "sump_buster")) => Some(Passage::Buses),
        None if barrier.is_some_and(closes) || barrier == Some("kerb") && tags.is("kerb", "raised") => {
            Some(if buses() { Passage::Buses } else { Passage::Nobody })
        }
        None => barrier.filter(|kind| is_gate(kind)).map(|_| Passage::Gate),
    }
}

/// Whether a node has tags of access only, apart from those that tell of the data.
fn is_plain(tags: &Tags) -> bool {
    let is_access = |key: &str| {
        let own = [
            "bus",
            "psv",
            "taxi",
            "hov",
            "emergency",
            "goods",
            "hgv",
            "tourist_bus",
            "coach",
            "motorcycle",
            "moped",
            "mofa",
            "foot",
            "bicycle",
            "horse",
            "locked",
            "note",
            "fixme",
            "source",
            "name",
        ];
        let stem = key.strip_suffix(":forward").or_else(|| key.strip_suffix(":backward")).unwrap_or(key);
        OF_CARS.contains(&stem) || own.contains(&stem)
    };
    tags.iter().all(|(key, _)| is_access(key))
}

/// Whether no car passes a barrier of this kind unless its access tags say so.
fn closes(barrier: &str) -> bool {
    matches!(
        barrier,
        "barrier_board"
            | "berm"
            | "block"
            | "bollard"
            | "boulder"
            | "chain"
            | "concrete"
            | "concrete_block"
            | "cycle_barrier"
            | "debris"
            | "ditch"
            | "fence"
            | "flowerpot"
            | "full-height_turnstile"
            | "guard_rail"
            | "half-height_turnstile"
            | "handrail"
            | "hedge"
            | "hedge_bank"
            | "horse_stile"
            | "jersey_barrier"
            | "kissing_gate"
            | "log"
            | "motorcycle_barrier"
            | "planter"
            | "retaining_wall"
            | "rock"
            | "rope"
            | "stile"
            | "tank_trap"
            | "tree"
            | "turnstile"
            | "tyres"
            | "wall"
            | "wicket_gate"
            | "wire_fence"
    )
}

/// Whether a barrier of this kind opens for those who may pass.
fn is_gate(barrier: &str) -> bool {
    matches!(
        barrier,
        "gate" | "hampshire_gate" | "lift_gate" | "sally_port" | "sliding_beam" | "sliding_gate" | "swing_gate" | "yes"
    )
}
