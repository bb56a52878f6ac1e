//! Which ways carry motor vehicles, and who may use them.

use crate::builder::tags::road_class::RoadClass;
use crate::osm::{Tags, Way};

/// A way that becomes one or more roads.
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

/// Which motor vehicles the most specific access tag admits; `None` for none.
fn access(tags: &Tags) -> Option<Access> {
    if tags.is("highway", "busway") {
        return Some(Access::Bus);
    }
    let value = ["motorcar", "motor_vehicle", "vehicle", "access"].iter().find_map(|key| tags.get(key));
    match value.map(|value| value.split(';').next().unwrap_or(value).trim()) {
        Some("no" | "use_sidepath" | "dismount") => admits_buses(tags).then_some(Access::Bus),
        Some(
            "private" | "destination" | "permit" | "customers" | "delivery" | "residents" | "employees" | "students"
            | "agricultural" | "forestry" | "military" | "emergency" | "restricted",
        ) => Some(Access::Private),
        // Without access tags these lead to private ground.
        None if matches!(tags.get("service"), Some("driveway" | "parking_aisle")) => Some(Access::Private),
        _ => Some(Access::Public),
    }
}

fn admits_buses(tags: &Tags) -> bool {
    ["bus", "psv"].iter().any(|key| matches!(tags.get(key), Some("yes" | "designated" | "official")))
}
