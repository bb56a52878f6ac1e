//! Which ways carry motor vehicles, and who may use them.

use crate::builder::tags::road_class::RoadClass;
use crate::osm::{Tags, Way};

/// A way that becomes one or more roads.
#[derive(Clone, Copy)]
pub(super) struct Drivable<'a> {
    pub way: &'a Way,
    pub class: RoadClass,
    pub link: bool,
    pub access: Access,
}

/// Which motor vehicles may use a way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Access {
    /// All.
    Public,
    /// Residents, staff, deliveries.
    Private,
    /// Buses only.
    Bus,
}

/// Whether a way becomes a road.
pub(super) enum AccessVerdict<'a> {
    Road(Drivable<'a>),
    /// A road by its class that is left out for this reason.
    LeftOut(&'static str),
    /// Not a road for motor vehicles.
    NoRoad,
}

/// Whether `way` becomes a road.
pub(super) fn classify(way: &Way) -> AccessVerdict<'_> {
    let tags = &way.tags;
    let Some((class, link)) = tags.get("highway").and_then(class) else { return AccessVerdict::NoRoad };
    if tags.is("area", "yes") {
        return AccessVerdict::LeftOut("it is an area (area=yes), not a line");
    }
    if way.nodes.len() < 2 {
        return AccessVerdict::LeftOut("it has fewer than two nodes");
    }
    match access(tags) {
        Some(access) => AccessVerdict::Road(Drivable { way, class, link, access }),
        None => AccessVerdict::LeftOut("motor vehicles are not admitted (access tags)"),
    }
}

/// The class of a `highway` value, and whether it is a link; `None` if the value is not for motor vehicles.
pub(crate) fn class(highway: &str) -> Option<(RoadClass, bool)> {
    let (stem, link) = match highway.strip_suffix("_link") {
        Some(stem) => (stem, true),
        None => (highway, false),
    };
    let class = match stem {
        "motorway" => RoadClass::Motorway,
        "trunk" => RoadClass::Trunk,
        "primary" => RoadClass::Primary,
        "secondary" => RoadClass::Secondary,
        "tertiary" => RoadClass::Tertiary,
        "unclassified" | "road" | "busway" => RoadClass::Unclassified,
        "residential" => RoadClass::Residential,
        "living_street" => RoadClass::LivingStreet,
        "service" => RoadClass::Service,
        "track" => RoadClass::Track,
        _ => return None,
    };
    let can_be_link = class <= RoadClass::Tertiary;
    (!link || can_be_link).then_some((class, link))
}

/// Which motor vehicles the tags of a way admit; `None` for none.
fn access(tags: &Tags) -> Option<Access> {
    if tags.is("highway", "busway") {
        return Some(Access::Bus);
    }
    match stated(tags, &["motorcar", "motor_vehicle", "vehicle", "access"]) {
        Some(access) => access,
        // Without access tags these lead to private ground.
        None if matches!(tags.get("service"), Some("driveway" | "parking_aisle")) => Some(Access::Private),
        None => Some(Access::Public),
    }
}

/// Which motor vehicles the first of these tags admits, if there is one: `Some(None)` for none.
pub(super) fn stated(tags: &Tags, keys: &[&str]) -> Option<Option<Access>> {
    let value = keys.iter().find_map(|key| tags.get(key))?;
    Some(match value.split(';').next().unwrap_or(value).trim() {
        "no" | "use_sidepath" | "dismount" => admits_buses(tags).then_some(Access::Bus),
        "private" | "destination" | "permit" | "customers" | "delivery" | "residents" | "employees" | "students"
        | "agricultural" | "forestry" | "military" | "emergency" | "restricted" => Some(Access::Private),
        _ => Some(Access::Public),
    })
}

/// Whether the tags name buses among those who may pass.
pub(super) fn admits_buses(tags: &Tags) -> bool {
    ["bus", "psv"].iter().any(|key| matches!(tags.get(key), Some("yes" | "designated" | "official")))
}
