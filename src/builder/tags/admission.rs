//! Who may drive a way in each of its directions: access tags and one-way tags.
//!
//! A key with a direction (`motor_vehicle:backward`) is more specific than the same key without one, and less specific than a key
//! for fewer vehicles (`motorcar`). So do the routing engines read them.

use crate::osm::Tags;

use super::road_class::{RoadClass, is_roundabout};

/// The motor vehicles that may pass, from none to all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Admitted {
    /// No car and no bus.
    Nobody,
    /// Buses only.
    Buses,
    /// Residents, staff, deliveries.
    Private,
    /// All.
    Public,
}

/// Who may drive along a way and against it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Admission {
    /// Along the way.
    pub forward: Admitted,
    /// Against the way.
    pub backward: Admitted,
    /// The signed direction of cars.
    pub one_way: OneWay,
}

impl Admission {
    /// The most that either direction admits.
    pub fn most(self) -> Admitted {
        self.forward.max(self.backward)
    }
}

/// The directions that `oneway` and its like allow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum OneWay {
    /// Both.
    No,
    /// Along the way.
    Forward,
    /// Against the way.
    Backward,
    /// One at a time, changing every few minutes, as at road works.
    Alternating,
    /// One at a time, changing with the hours of the day.
    Reversible,
}

impl OneWay {
    /// Whether it allows to drive along the way, or against it.
    fn allows(self, along: bool) -> bool {
        match self {
            Self::No | Self::Alternating => true,
            Self::Forward => along,
            Self::Backward => !along,
            Self::Reversible => false,
        }
    }
}

/// Access keys that bind cars, from the most specific to the least.
pub(crate) const OF_CARS: [&str; 4] = ["motorcar", "motor_vehicle", "vehicle", "access"];
/// Access keys of buses.
const OF_BUSES: [&str; 2] = ["bus", "psv"];
/// Keys whose values `opposite` and `opposite_lane` say that buses drive against a one-way road.
pub(crate) const OPPOSITE: [&str; 6] = ["busway", "busway:left", "busway:right", "busway:both", "psv", "bus"];

/// Who may drive a way of this class.
pub(crate) fn admission(tags: &Tags, class: RoadClass, link: bool) -> Admission {
    // Ramps of motorways are tagged: some are driven both ways.
    let implied = class == RoadClass::Motorway && !link || is_roundabout(tags);
    let implied = if implied { OneWay::Forward } else { OneWay::No };
    let signed = |keys: &[&str]| keys.iter().find_map(|key| one_way(tags.get(key)?)).unwrap_or(implied);
    let of_cars = signed(&["oneway:motorcar", "oneway:motor_vehicle", "oneway:vehicle", "oneway"]);
    let of_buses = signed(&["oneway:bus", "oneway:psv", "oneway:motor_vehicle", "oneway:vehicle", "oneway"]);
    let opposite = OPPOSITE.iter().any(|key| tags.is(key, "opposite"));
    let toward = |along: bool| {
        let named = |key: &str| tags.get_joined([key, suffix(along)]).and_then(of_value) > Some(Admitted::Nobody);
        match by_access(tags, along) {
            Admitted::Nobody => Admitted::Nobody,
            admitted if admitted > Admitted::Buses && of_cars.allows(along) => admitted,
            _ if of_buses.allows(along) || opposite && !of_cars.allows(along) || OF_BUSES.into_iter().any(named) => {
                Admitted::Buses
            }
            _ => Admitted::Nobody,
        }
    };
    Admission { forward: toward(true), backward: toward(false), one_way: of_cars }
}

/// The tags that close a way to motor vehicles, as `access=no`.
pub(crate) fn closed_by(tags: &Tags) -> String {
    let is_about = |key: &str| {
        let stem = key.strip_suffix(":forward").or_else(|| key.strip_suffix(":backward")).unwrap_or(key);
        OF_CARS.contains(&stem) || OF_BUSES.contains(&stem) || key == "service" || stem.starts_with("oneway")
    };
    let told = tags.iter().filter(|(key, _)| is_about(key) && *key != "oneway:bicycle");
    told.map(|(key, value)| format!("{key}={value}")).collect::<Vec<_>>().join(", ")
}

fn suffix(along: bool) -> &'static str {
    if along { ":forward" } else { ":backward" }
}

/// Whom the access tags admit in one direction.
fn by_access(tags: &Tags, along: bool) -> Admitted {
    let stated = |key: &str| {
        let directed = tags.get_joined([key, suffix(along)]).and_then(of_value);
        directed.or_else(|| tags.get(key).and_then(of_value))
    };
    let buses = OF_BUSES.into_iter().find_map(stated).map(|admitted| admitted > Admitted::Nobody);
    if tags.is("highway", "busway") {
        return if buses == Some(false) { Admitted::Nobody } else { Admitted::Buses };
    }
    match (OF_CARS.into_iter().find_map(stated), tags.get("service")) {
        (Some(Admitted::Nobody), _) | (None, Some("emergency_access")) if buses == Some(true) => Admitted::Buses,
        (None, Some("emergency_access")) => Admitted::Nobody,
        // Without access tags these lead to private ground.
        (None, Some("driveway" | "parking_aisle")) => Admitted::Private,
        (None, _) => Admitted::Public,
        (Some(admitted), _) => admitted,
    }
}

/// Whom the first of these keys with a known value admits; buses have tags of their own.
pub(crate) fn stated(tags: &Tags, keys: &[&str]) -> Option<Admitted> {
    let admitted = keys.iter().find_map(|key| tags.get(key).and_then(of_value))?;
    Some(if admitted == Admitted::Nobody && admits_buses(tags) { Admitted::Buses } else { admitted })
}

/// Whether the tags name buses among those who may pass.
pub(crate) fn admits_buses(tags: &Tags) -> bool {
    OF_BUSES.iter().find_map(|key| tags.get(key).and_then(of_value)) > Some(Admitted::Nobody)
}

/// Whom the value of an access tag admits; of a list the most. `None` for values that tell nothing of cars.
pub(crate) fn of_value(value: &str) -> Option<Admitted> {
    value.split(';').filter_map(|word| of_word(word.trim())).max()
}

fn of_word(word: &str) -> Option<Admitted> {
    Some(match word {
        "yes" | "designated" | "official" | "permissive" | "public" | "allowed" => Admitted::Public,
        "private" | "destination" | "permit" | "customers" | "delivery" | "residents" | "employees" | "students"
        | "staff" | "visitors" => Admitted::Private,
        "bus" | "psv" => Admitted::Buses,
        // Those whose vehicles are no cars, or no cars of everybody.
        "no" | "use_sidepath" | "dismount" | "agricultural" | "forestry" | "military" | "emergency"
        | "emergency_vehicle" | "restricted" | "service" | "foot" | "bicycle" | "taxi" | "share_taxi" | "minibus"
        | "impassable" => Admitted::Nobody,
        _ => return None,
    })
}

/// The direction that a value of `oneway` allows.
fn one_way(value: &str) -> Option<OneWay> {
    Some(match value {
        "yes" | "true" | "1" => OneWay::Forward,
        "-1" | "reverse" => OneWay::Backward,
        "no" | "false" | "0" => OneWay::No,
        "alternating" => OneWay::Alternating,
        "reversible" => OneWay::Reversible,
        _ => return None,
    })
}
