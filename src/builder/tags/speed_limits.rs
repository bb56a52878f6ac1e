//! Values of `maxspeed`, and the usual speed limits of countries, for roads without a tagged limit and for zones such as `RO:trunk`.
//!
//! The figures are those of OpenStreetMap's page "Default speed limits" (revision of October 2023), without the conditions that
//! depend on lanes, weight or weather; for trunk roads and motorways also those of the routing engine OSRM (`profiles/car.lua`).

use super::values::number_of;

pub(super) const KMH_PER_MPH: f64 = 1.609_344;
const KMH_PER_KNOT: f64 = 1.852;

/// Walking pace, km/h: `walk`, and living streets of countries that give no figure.
const WALK: f64 = 7.0;
/// The advisory speed of German motorways, km/h: `none`.
const UNLIMITED: f64 = 130.0;
/// Cycle streets, km/h, in all countries with a figure but one.
const CYCLE_STREET: f64 = 30.0;

/// The limits of some countries, km/h.
pub(super) struct Limits {
    /// ISO 3166 codes, of countries or of their parts.
    pub places: &'static [&'static str],
    pub urban: f64,
    pub rural: f64,
    /// Expressways that are no motorways.
    pub trunk: f64,
    pub motorway: f64,
    /// Living streets and pedestrian zones.
    pub slow: f64,
}

const fn row(places: &'static [&'static str], [urban, rural, trunk, motorway, slow]: [f64; 5]) -> Limits {
    Limits { places, urban, rural, trunk, motorway, slow }
}

/// Urban, rural, trunk, motorway, slow.
const COUNTRIES: [Limits; 40] = [
    row(&["DE"], [50.0, 100.0, 100.0, UNLIMITED, WALK]),
    row(&["AT"], [50.0, 100.0, 100.0, 130.0, WALK]),
    row(&["CH", "LI"], [50.0, 80.0, 100.0, 120.0, 20.0]),
    row(&["FR"], [50.0, 80.0, 110.0, 130.0, 20.0]),
    row(&["NL"], [50.0, 80.0, 100.0, 120.0, 15.0]),
    row(&["BE-VLG"], [50.0, 70.0, 120.0, 120.0, 20.0]),
    row(&["BE-BRU"], [30.0, 70.0, 120.0, 120.0, 20.0]),
    row(&["BE", "BE-WAL"], [50.0, 90.0, 120.0, 120.0, 20.0]),
    row(&["LU"], [50.0, 90.0, 90.0, 130.0, 20.0]),
    row(&["ES"], [50.0, 90.0, 90.0, 120.0, 20.0]),
    row(&["PT"], [50.0, 90.0, 100.0, 120.0, 20.0]),
    row(&["IT", "GR", "HR"], [50.0, 90.0, 110.0, 130.0, WALK]),
    row(&["SI"], [50.0, 90.0, 110.0, 130.0, 10.0]),
    row(&["PL"], [50.0, 90.0, 120.0, 140.0, 20.0]),
    row(&["CZ", "HU", "UA"], [50.0, 90.0, 110.0, 130.0, 20.0]),
    row(&["SK"], [50.0, 90.0, 130.0, 130.0, 20.0]),
    row(&["RO"], [50.0, 90.0, 100.0, 130.0, 20.0]),
    row(&["BG"], [50.0, 90.0, 120.0, 140.0, 20.0]),
    row(&["RS"], [50.0, 80.0, 100.0, 120.0, 10.0]),
    row(&["TR"], [50.0, 90.0, 110.0, 120.0, 20.0]),
    row(&["RU", "BY"], [60.0, 90.0, 90.0, 110.0, 20.0]),
    row(&["LV"], [50.0, 90.0, 110.0, 110.0, 20.0]),
    row(&["LT"], [50.0, 90.0, 120.0, 130.0, 20.0]),
    row(&["EE"], [50.0, 90.0, 90.0, 110.0, 20.0]),
    row(&["FI"], [50.0, 80.0, 100.0, 120.0, 20.0]),
    row(&["SE"], [50.0, 70.0, 90.0, 110.0, WALK]),
    row(&["NO"], [50.0, 80.0, 80.0, 110.0, WALK]),
    row(&["DK"], [50.0, 80.0, 80.0, 130.0, 15.0]),
    row(
        &["GB", "GG", "JE", "IM"],
        [30.0 * KMH_PER_MPH, 60.0 * KMH_PER_MPH, 60.0 * KMH_PER_MPH, 70.0 * KMH_PER_MPH, WALK],
    ),
    row(&["IE"], [50.0, 80.0, 100.0, 120.0, WALK]),
    row(
        &["US", "PR", "VI", "GU"],
        [25.0 * KMH_PER_MPH, 55.0 * KMH_PER_MPH, 55.0 * KMH_PER_MPH, 65.0 * KMH_PER_MPH, WALK],
    ),
    row(&["JP"], [60.0, 60.0, 60.0, 100.0, WALK]),
    row(&["KR"], [50.0, 80.0, 80.0, 100.0, WALK]),
    row(&["TW"], [50.0, 60.0, 60.0, 100.0, WALK]),
    row(&["SG", "HK"], [50.0, 50.0, 50.0, 90.0, WALK]),
    row(&["AU"], [50.0, 100.0, 100.0, 110.0, WALK]),
    row(&["NZ"], [50.0, 100.0, 100.0, 110.0, 10.0]),
    row(&["ZA"], [60.0, 100.0, 100.0, 120.0, WALK]),
    row(&["AR"], [40.0, 110.0, 120.0, 130.0, WALK]),
    row(&["IN", "TH", "ID", "MY"], [50.0, 80.0, 80.0, 100.0, WALK]),
];

/// The limits of most countries.
const ELSEWHERE: Limits = row(&[], [50.0, 90.0, 90.0, 120.0, WALK]);

/// The limits of a country or a part of one, by its ISO 3166 code; a part without own limits has those of its country.
pub(super) fn limits(place: Option<&str>) -> &'static Limits {
    let known = |code: &str| COUNTRIES.iter().find(|limits| limits.places.contains(&code));
    place.and_then(|code| known(code).or_else(|| known(code.split('-').next()?))).unwrap_or(&ELSEWHERE)
}

/// The limit of a zone in a country, km/h, as `urban`; `None` if the word is unknown.
fn of_zone(zone: &str, place: Option<&str>) -> Option<f64> {
    // Mappers write UK for the country with the code GB.
    let place = place.map(|code| if code == "UK" { "GB" } else { code });
    let limits = limits(place);
    Some(match zone {
        "urban" | "nsl_restricted" => limits.urban,
        "rural" | "national" | "nsl_single" => limits.rural,
        "motorway" | "nsl_dual" | "express" => limits.motorway,
        // Fast roads in towns have a limit of their own there.
        "urban_motorway" | "urban_trunk" if place == Some("CZ") => 80.0,
        "trunk" | "expressway" | "motorroad" => limits.trunk,
        "living_street" | "pedestrian_zone" | "shared_zone" => limits.slow,
        "walk" => WALK,
        "bicycle_road" | "cycle_street" | "cyclestreet" => CYCLE_STREET,
        _ => return None,
    })
}

/// A value in km/h: a number with a unit, a word, or a zone such as `DE:urban`.
pub(super) fn parse(value: &str, country: Option<&str>) -> Option<f64> {
    // The lowest of several limits applies.
    if value.contains(';') {
        return value.split(';').filter_map(|part| parse(part, country)).min_by(f64::total_cmp);
    }
    let value = value.trim();
    match value {
        "walk" => return Some(WALK),
        "none" | "unlimited" => return Some(UNLIMITED),
        _ => {}
    }
    if let Some((place, zone)) = value.split_once(':') {
        return zone_limit(zone, Some(place));
    }
    let split = value.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(value.len());
    let (number, unit) = value.split_at(split);
    let kmh = match unit.trim() {
        "" | "km/h" | "kmh" | "kph" | "kmph" => 1.0,
        "mph" => KMH_PER_MPH,
        "knots" => KMH_PER_KNOT,
        _ => return zone_limit(value, country),
    };
    let speed = number_of(number)? * kmh;
    (speed.is_finite() && speed > 0.0 && speed < 400.0).then_some(speed)
}

/// Whether the signs of a country tell miles an hour.
fn signs_mph(place: &str) -> bool {
    matches!(place.split('-').next(), Some("GB" | "UK" | "GG" | "JE" | "IM" | "US" | "PR" | "VI" | "GU"))
}

/// The limit of a zone: a word, or a number as `zone30`.
fn zone_limit(zone: &str, place: Option<&str>) -> Option<f64> {
    of_zone(zone, place).or_else(|| {
        let number = zone.strip_prefix("zone").map(|rest| rest.trim_start_matches(':')).unwrap_or(zone);
        let unit = if place.is_some_and(signs_mph) { KMH_PER_MPH } else { 1.0 };
        number_of(number).filter(|speed| (1.0..=130.0).contains(speed)).map(|speed| speed * unit)
    })
}
