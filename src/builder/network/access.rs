//! Which ways carry motor vehicles, and who may use them.

use crate::builder::tags::admission::{Admitted, OF_CARS, OneWay, admission, admits_buses, closed_by, stated};
use crate::builder::tags::cross_section::Travel;
use crate::builder::tags::road_class::RoadClass;
use crate::osm::{Tags, Way};

/// A way that becomes one or more roads.
#[derive(Clone, Copy)]
pub(super) struct Drivable<'a> {
    pub way: &'a Way,
    pub class: RoadClass,
    pub link: bool,
    pub access: Access,
    /// The only direction in which vehicles pass, where a node closes the other.
    pub only: Option<Travel>,
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
    LeftOut(String),
    /// Not a road for motor vehicles.
    NoRoad,
}

/// Whether `way` becomes a road.
pub(super) fn classify(way: &Way) -> AccessVerdict<'_> {
    let tags = &way.tags;
    let Some((class, link)) = tags.get("highway").and_then(class) else {
        return shared_path(tags).or_else(|| bus_path(tags)).map_or(AccessVerdict::NoRoad, AccessVerdict::LeftOut);
    };
    if tags.is("area", "yes") {
        return AccessVerdict::LeftOut("it is an area (area=yes), not a line".into());
    }
    if way.nodes.len() < 2 {
        return AccessVerdict::LeftOut("it has fewer than two nodes".into());
    }
    if let Some(told) = no_road_now(tags) {
        return AccessVerdict::LeftOut(told);
    }
    if let Some((key, value)) = IMPASSABLE.iter().find(|(key, value)| tags.is(key, value)) {
        return AccessVerdict::LeftOut(format!("no car gets through ({key}={value})"));
    }
    if let Some(key) = OUT_OF_USE.iter().find(|key| tags.is(key, "yes")) {
        return AccessVerdict::LeftOut(format!(
            "it is out of use ({key}=yes); to build it, give it `{key} = \"no\"` under [[road]] in lanewright.toml"
        ));
    }
    let admitted = admission(tags, class, link);
    let access = match admitted.most() {
        Admitted::Public => Access::Public,
        Admitted::Private => Access::Private,
        Admitted::Buses => Access::Bus,
        Admitted::Nobody if admitted.one_way == OneWay::Reversible => {
            return AccessVerdict::LeftOut(REVERSIBLE.into());
        }
        Admitted::Nobody => {
            return AccessVerdict::LeftOut(format!("motor vehicles are not admitted ({})", closed_by(tags)));
        }
    };
    AccessVerdict::Road(Drivable { way, class, link, access, only: None })
}

/// Why a way for people or bicycles that admits motor vehicles, too, is left out; `None` for other ways.
fn shared_path(tags: &Tags) -> Option<String> {
    let highway = tags.get("highway").filter(|highway| PATHS.contains(highway))?;
    let (key, value) = OF_CARS.into_iter().take(3).find_map(|key| Some((key, tags.get(key)?)))?;
    (stated(tags, &[key]) >= Some(Admitted::Private)).then(|| {
        format!(
            "highway={highway} is no road, though cars may use it ({key}={value}); to build it as a private road, give it \
             `highway = \"service\"`, `{key} = \"private\"` and a `maxspeed` under [[road]] in lanewright.toml, or to build all of its \
             kind, `shared_paths = true`"
        )
    })
}

/// Why a way for people or bicycles that admits buses, too, is left out; `None` for other ways.
fn bus_path(tags: &Tags) -> Option<String> {
    let highway = tags.get("highway").filter(|highway| PATHS.contains(highway))?;
    let (key, value) = ["bus", "psv"].into_iter().find_map(|key| Some((key, tags.get(key)?)))?;
    admits_buses(tags).then(|| {
        format!(
            "highway={highway} is no road, though buses may use it ({key}={value}); to build it for buses, give it \
             `highway = \"busway\"` under [[road]] in lanewright.toml"
        )
    })
}

/// Whether a way for people or bicycles admits motor vehicles, too.
pub(super) fn is_shared_path(tags: &Tags) -> bool {
    shared_path(tags).is_some()
}

/// Ways of people and bicycles.
const PATHS: [&str; 5] = ["pedestrian", "footway", "cycleway", "path", "bridleway"];

/// Tags of ways that no car gets through.
const IMPASSABLE: [(&str, &str); 3] = [("smoothness", "impassable"), ("impassable", "yes"), ("status", "impassable")];

/// Tags of roads that nobody uses any more, or that are gone. Keys such as `disused:highway` beside `highway` tell what a road was.
const OUT_OF_USE: [&str; 6] = ["disused", "abandoned", "razed", "demolished", "removed", "destroyed"];

/// Why a way is no road today, though `highway` says so: it is being built, planned, or a ferry. Small works leave it open.
fn no_road_now(tags: &Tags) -> Option<String> {
    let told = |key: &str, open: &[&str]| {
        let value = tags.get(key).filter(|value| !open.contains(value))?;
        Some((key.to_owned(), value.to_owned()))
    };
    let works = told("construction", &["no", "minor", "widening"]).map(|it| (it, "it is being built"));
    let works = works.or_else(|| Some((told("proposed", &["no"])?, "it is planned")));
    let ferry = || tags.is("route", "ferry").then(|| (("route".into(), "ferry".into()), "it is a ferry"));
    works.or_else(ferry).map(|((key, value), why)| format!("{why} ({key}={value})"))
}

/// Why a reversible road is left out.
const REVERSIBLE: &str = "its direction changes with the hours (oneway=reversible), and a map has none; to build it for one \
                          direction, give it `oneway = \"yes\"` or `\"-1\"` under [[road]] in lanewright.toml";

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
