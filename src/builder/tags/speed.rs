//! Speed limits from `maxspeed*`, else by class and country.

use crate::osm::Tags;

use super::cross_section::Customs;
use super::road_class::RoadClass;
use super::values::number_of;

const KMH_PER_MPH: f64 = 1.609_344;
const KMH_PER_KNOT: f64 = 1.852;

/// Walking pace in Germany and Austria, km/h: `walk` and living streets.
const WALK: f64 = 7.0;
/// The advisory speed of German motorways, km/h: `none`.
const UNLIMITED: f64 = 130.0;
/// Service roads and tracks, km/h.
const SERVICE: f64 = 20.0;
/// Motorway ramps, km/h.
const RAMP: f64 = 60.0;

/// The limits of a country in towns, outside towns and on motorways, km/h.
struct Limits {
    countries: &'static [&'static str],
    urban: f64,
    rural: f64,
    motorway: f64,
}

/// Countries whose limits differ from [`ELSEWHERE`].
const COUNTRIES: [Limits; 12] = [
    Limits { countries: &["DE"], urban: 50.0, rural: 100.0, motorway: UNLIMITED },
    Limits { countries: &["AT"], urban: 50.0, rural: 100.0, motorway: 130.0 },
    Limits { countries: &["FR", "CH", "FI", "NL"], urban: 50.0, rural: 80.0, motorway: 120.0 },
    Limits { countries: &["NO", "SE"], urban: 50.0, rural: 80.0, motorway: 110.0 },
    Limits { countries: &["JP"], urban: 60.0, rural: 60.0, motorway: 100.0 },
    Limits { countries: &["KR"], urban: 50.0, rural: 80.0, motorway: 100.0 },
    Limits { countries: &["TW"], urban: 50.0, rural: 60.0, motorway: 100.0 },
    Limits { countries: &["SG", "HK"], urban: 50.0, rural: 50.0, motorway: 90.0 },
    Limits { countries: &["AU", "NZ"], urban: 50.0, rural: 100.0, motorway: 110.0 },
    Limits {
        countries: &["GB", "GG", "JE", "IM"],
        urban: 30.0 * KMH_PER_MPH,
        rural: 60.0 * KMH_PER_MPH,
        motorway: 70.0 * KMH_PER_MPH,
    },
    Limits {
        countries: &["US", "PR", "VI", "GU"],
        urban: 25.0 * KMH_PER_MPH,
        rural: 55.0 * KMH_PER_MPH,
        motorway: 65.0 * KMH_PER_MPH,
    },
    Limits { countries: &["IN", "TH", "ID", "MY"], urban: 50.0, rural: 80.0, motorway: 100.0 },
];

/// The limits of most countries.
const ELSEWHERE: Limits = Limits { countries: &[], urban: 50.0, rural: 90.0, motorway: 120.0 };

fn limits(country: Option<&str>) -> &'static Limits {
    let known = |limits: &&Limits| country.is_some_and(|country| limits.countries.contains(&country));
    COUNTRIES.iter().find(known).unwrap_or(&ELSEWHERE)
}

/// The limit forward and backward along the way, km/h.
pub(crate) fn limit(tags: &Tags, class: RoadClass, link: bool, customs: &Customs<'_>) -> [f64; 2] {
    let country = customs.country;
    let read = |key| tags.get(key).and_then(|value| parse(value, country));
    let default = || customs.defaults(class, link).speed.unwrap_or_else(|| default(class, link, country));
    let both = ["maxspeed", "maxspeed:type", "source:maxspeed", "zone:maxspeed", "zone:traffic"];
    let both = both.iter().find_map(|key| read(key));
    ["maxspeed:forward", "maxspeed:backward"].map(|key| read(key).or(both).unwrap_or_else(default))
}

/// The default limit of a class, km/h.
fn default(class: RoadClass, link: bool, country: Option<&str>) -> f64 {
    let limits = limits(country);
    match class {
        RoadClass::Motorway | RoadClass::Trunk if link => RAMP,
        RoadClass::Motorway => limits.motorway,
        RoadClass::Trunk => limits.rural,
        RoadClass::LivingStreet => WALK,
        RoadClass::Service | RoadClass::Track => SERVICE,
        _ => limits.urban,
    }
}

/// A value in km/h: a number with a unit, a word, or a zone such as `DE:urban`.
fn parse(value: &str, country: Option<&str>) -> Option<f64> {
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
        return of_zone(zone, Some(place.split('-').next().unwrap_or(place)));
    }
    let split = value.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(value.len());
    let (number, unit) = value.split_at(split);
    let kmh = match unit.trim() {
        "" | "km/h" | "kmh" | "kph" => 1.0,
        "mph" => KMH_PER_MPH,
        "knots" => KMH_PER_KNOT,
        _ => return of_zone(value, country),
    };
    let speed = number_of(number)? * kmh;
    (speed.is_finite() && speed > 0.0 && speed < 400.0).then_some(speed)
}

fn of_zone(zone: &str, country: Option<&str>) -> Option<f64> {
    let limits = limits(country);
    match zone {
        "urban" | "nsl_restricted" => Some(limits.urban),
        "rural" | "nsl_single" => Some(limits.rural),
        "motorway" | "nsl_dual" => Some(limits.motorway),
        "trunk" => Some(limits.rural),
        "living_street" | "walk" => Some(WALK),
        "bicycle_road" => Some(30.0),
        _ => {
            let number = zone.strip_prefix("zone").map(|rest| rest.trim_start_matches(':')).unwrap_or(zone);
            number_of(number).filter(|speed| (1.0..=130.0).contains(speed))
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::tags::road_class::DrivingSide;

    use super::*;

    fn customs(country: Option<&str>) -> Customs<'_> {
        Customs { side: DrivingSide::Right, country, assume: &[] }
    }

    fn of(pairs: &[(&str, &str)]) -> [f64; 2] {
        limit(&pairs.iter().copied().collect(), RoadClass::Residential, false, &customs(Some("DE")))
    }

    #[test]
    fn units_words_and_zones() {
        assert_eq!(of(&[("maxspeed", "30")]), [30.0; 2]);
        assert_eq!(of(&[("maxspeed", "30 mph")]), [30.0 * KMH_PER_MPH; 2]);
        assert_eq!(of(&[("maxspeed", "10 knots")]), [18.52; 2]);
        assert_eq!(of(&[("maxspeed", "walk")]), [7.0; 2]);
        assert_eq!(of(&[("maxspeed", "none")]), [130.0; 2]);
        assert_eq!(of(&[("maxspeed", "DE:rural")]), [100.0; 2]);
        assert_eq!(of(&[("maxspeed", "FR:rural")]), [80.0; 2]);
        assert_eq!(of(&[("maxspeed:type", "DE:zone30")]), [30.0; 2]);
        assert_eq!(of(&[("source:maxspeed", "DE:zone:20")]), [20.0; 2]);
        assert_eq!(of(&[("maxspeed:type", "GB:nsl_single")]), [60.0 * KMH_PER_MPH; 2]);
        assert_eq!(of(&[("maxspeed", "50;30")]), [30.0; 2]);
    }

    #[test]
    fn directions_may_have_different_limits() {
        assert_eq!(of(&[("maxspeed", "50"), ("maxspeed:backward", "30")]), [50.0, 30.0]);
    }

    #[test]
    fn an_invalid_value_gives_the_default() {
        for value in ["signals", "fast", "-30", "nan", "1e9", ""] {
            assert_eq!(of(&[("maxspeed", value)]), [50.0; 2], "{value}");
        }
        let motorway = |country| limit(&Tags::new(), RoadClass::Motorway, false, &customs(country))[0];
        assert_eq!(motorway(Some("JP")), 100.0);
        assert_eq!(motorway(None), 120.0);
    }
}
