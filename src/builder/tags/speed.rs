//! Speed limits from `maxspeed*`, else by class and country.

use crate::osm::Tags;

use super::cross_section::Customs;
use super::road_class::RoadClass;
use super::speed_limits::{limits, parse};
use super::values::per_lane;

/// Service roads and tracks, km/h.
const SERVICE: f64 = 20.0;
/// Motorway ramps, km/h.
const RAMP: f64 = 60.0;

/// Keys of a limit for cars, from the most specific to the least. An advisory speed is none.
const OF_CARS: [&str; 4] = ["maxspeed:motorcar", "maxspeed:motor_vehicle", "maxspeed:vehicle", "maxspeed"];
/// Keys of what a limit follows from.
const ZONES: [&str; 4] = ["maxspeed:type", "source:maxspeed", "zone:maxspeed", "zone:traffic"];

/// The limit forward and backward along the way, km/h.
pub(crate) fn limit(tags: &Tags, class: RoadClass, link: bool, customs: &Customs<'_>) -> [f64; 2] {
    let country = customs.country;
    let read = |key| tags.get(key).and_then(|value| parse(value, country));
    let default = || customs.defaults(class, link).speed.unwrap_or_else(|| default(class, link, country));
    let of_lanes = |suffix: &str| {
        let list = tags.get_joined(["maxspeed:lanes", suffix]).or_else(|| tags.get("maxspeed:lanes"))?;
        per_lane(list).filter_map(|entry| parse(entry, country)).max_by(f64::total_cmp)
    };
    [":forward", ":backward"].map(|suffix| {
        let directed = |key: &str| tags.get_joined([key, suffix]).and_then(|value| parse(value, country));
        let tagged = OF_CARS.into_iter().find_map(|key| directed(key).or_else(|| read(key)));
        let tagged = tagged.or_else(|| of_lanes(suffix)).or_else(|| ZONES.into_iter().find_map(read));
        tagged.unwrap_or_else(default)
    })
}

/// The tag of a limit that tells nothing: `maxspeed=signals`. Words of `source:maxspeed` may be of anything.
pub(crate) fn unread(tags: &Tags, country: Option<&str>) -> Option<String> {
    let is_limit = |key: &str| {
        let stem = key.strip_suffix(":forward").or_else(|| key.strip_suffix(":backward")).unwrap_or(key);
        OF_CARS.contains(&stem) || key == ZONES[0]
    };
    let unknown = |(key, value): &(&str, &str)| {
        let words = ["sign", "signals", "implicit", "variable"];
        is_limit(key) && parse(value, country).is_none() && !(*key == ZONES[0] && words.contains(value))
    };
    tags.iter().find(unknown).map(|(key, value)| format!("{key}={value}"))
}

/// The default limit of a class, km/h.
fn default(class: RoadClass, link: bool, country: Option<&str>) -> f64 {
    let limits = limits(country);
    match class {
        RoadClass::Motorway | RoadClass::Trunk if link => RAMP,
        RoadClass::Motorway => limits.motorway,
        RoadClass::Trunk => limits.trunk,
        RoadClass::LivingStreet => limits.slow,
        RoadClass::Service | RoadClass::Track => SERVICE,
        _ => limits.urban,
    }
}

#[cfg(test)]
mod tests {
    use crate::builder::tags::road_class::DrivingSide;
    use crate::builder::tags::speed_limits::KMH_PER_MPH;

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
    fn zones_have_the_limits_of_their_country() {
        for (value, kmh) in [
            ("CH:trunk", 100.0),
            ("RO:trunk", 100.0),
            ("LV:living_street", 20.0),
            ("RU:living_street", 20.0),
            ("BE-VLG:rural", 70.0),
            ("BE-WAL:rural", 90.0),
            ("JP:national", 60.0),
            ("CZ:pedestrian_zone", 20.0),
            ("UK:nsl_single", 60.0 * KMH_PER_MPH),
            ("BE-XYZ:urban", 50.0),
            ("GB:zone20", 20.0 * KMH_PER_MPH),
            ("DE:zone20", 20.0),
            ("JP:express", 100.0),
            ("CZ:urban_motorway", 80.0),
        ] {
            assert_eq!(of(&[("maxspeed", value)]), [kmh; 2], "{value}");
        }
        let unread = |pairs: &[(&str, &str)]| unread(&pairs.iter().copied().collect(), Some("DE"));
        assert_eq!(unread(&[("maxspeed", "DE:moonlight")]).as_deref(), Some("maxspeed=DE:moonlight"));
        assert_eq!(unread(&[("maxspeed", "30"), ("maxspeed:type", "sign")]), None);
        assert_eq!(unread(&[("source:maxspeed", "survey")]), None);
        let forward = [("maxspeed", "50"), ("maxspeed:forward", "DE:moonlight")];
        assert_eq!(unread(&forward).as_deref(), Some("maxspeed:forward=DE:moonlight"));
    }

    #[test]
    fn the_limit_of_cars_counts_and_advice_does_not() {
        assert_eq!(of(&[("maxspeed", "100"), ("maxspeed:motorcar", "80")]), [80.0; 2]);
        assert_eq!(of(&[("maxspeed:advisory", "30")]), [50.0; 2]);
        assert_eq!(of(&[("maxspeed:lanes", "100|100|80")]), [100.0; 2]);
        assert_eq!(of(&[("maxspeed:lanes:backward", "60|40")]), [50.0, 60.0]);
        assert_eq!(of(&[("maxspeed", "50"), ("maxspeed:lanes", "100|80")]), [50.0; 2]);
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
