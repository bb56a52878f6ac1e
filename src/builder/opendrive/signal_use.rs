//! What signals of a file are for, by their numbers and words, and where lights stand between intersections.

use crate::xodr::{Object, Road, Signal};

/// Lights for vehicles in OpenDRIVE's own list of signals.
const VEHICLE_LIGHTS: [&str; 6] = ["1000001", "1000008", "1000009", "1000010", "1000011", "1000012"];
/// Lights for people on foot.
const WALK_LIGHTS: [&str; 1] = ["1000002"];
/// Stop lines by number: in the lists of Germany and of those countries that take them over.
const STOP_LINES: [&str; 1] = ["294"];
/// Numbers and words of stop signs, ...
const STOP_SIGNS: [&str; 3] = ["206", "R1-1", "R1"];
/// ... and of give-way signs.
const GIVE_WAY_SIGNS: [&str; 2] = ["205", "R1-2"];
/// Signs of roads that go first: at the next junction, and at all.
const PRIORITY_SIGNS: [&str; 2] = ["301", "306"];
/// Signs of speed limits: Germany's numbers, and that of the United States.
const SPEED_SIGNS: [&str; 2] = ["274", "274.1"];
const MILES_SIGN: &str = "R2-1";
/// Units of speed limits, km/h.
const MILES_PER_HOUR: f64 = 1.609_344;
const METRES_PER_SECOND: f64 = 3.6;
/// Lanes are cut at stop lines, and those of several lanes that lie this close, metres, at one of them.
pub const AT_CUT: f64 = 1.0;
/// A light farther than this before the end of its road, metres, stands between intersections, ...
const BEFORE_END: f64 = 40.0;
/// ... unless it is so near to the road's begin, metres, that it hangs behind an intersection.
const BEHIND_BEGIN: f64 = 15.0;

/// What a signal is for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SignalUse {
    /// Lights for vehicles.
    VehicleLight,
    /// Lights for people on foot.
    WalkLight,
    /// A stop line on the ground.
    StopLine,
    /// A stop sign.
    Stop,
    /// A give-way sign.
    GiveWay,
    /// A sign of a road that goes first.
    Priority,
    /// A speed limit, km/h.
    Speed(f64),
    /// Something that the map does not show.
    Other,
}

/// What a signal is for, by its number and its words.
pub fn use_of(signal: &Signal) -> SignalUse {
    let kind = signal.kind.as_str();
    let words = signal.words();
    if VEHICLE_LIGHTS.contains(&kind) {
        return SignalUse::VehicleLight;
    }
    if WALK_LIGHTS.contains(&kind) {
        return SignalUse::WalkLight;
    }
    if STOP_LINES.contains(&kind) || is_stop_line(&words) {
        return SignalUse::StopLine;
    }
    if signal.dynamic {
        // Lights without a number of the list.
        let light = words.contains("light") && !words.contains("pedestrian");
        return if light && ["", "-1", "none"].contains(&kind) { SignalUse::VehicleLight } else { SignalUse::Other };
    }
    if STOP_SIGNS.contains(&kind) {
        return SignalUse::Stop;
    }
    if GIVE_WAY_SIGNS.contains(&kind) {
        return SignalUse::GiveWay;
    }
    if PRIORITY_SIGNS.contains(&kind) {
        return SignalUse::Priority;
    }
    if SPEED_SIGNS.contains(&kind) || kind == MILES_SIGN {
        let value = signal.value.filter(|value| *value > 0.0).or_else(|| of_variant(signal));
        let unit = if is_in_metres(signal) { METRES_PER_SECOND } else { unit_of(signal) };
        return value.map_or(SignalUse::Other, |value| SignalUse::Speed(value * unit));
    }
    SignalUse::Other
}

/// The speed limit that the variant of a sign says, km/h: as a number, or by Germany's list up to 2017, in which 274-51 is 10 km/h and
/// 274-63 is 130 km/h. The sign of a zone without a variant is that of 30 km/h.
fn of_variant(signal: &Signal) -> Option<f64> {
    const OLD_NUMBERS: std::ops::RangeInclusive<f64> = 51.0..=63.0;
    const ZONE: f64 = 30.0;
    let number = match signal.subkind.rsplit_once('-') {
        Some(("", _)) => None,
        Some((_, number)) => number.parse().ok(),
        None => signal.subkind.parse::<f64>().ok(),
    };
    let number = number.filter(|number| *number > 0.0);
    match (signal.kind.as_str(), number) {
        ("274", Some(number)) if OLD_NUMBERS.contains(&number) && number % 10.0 != 0.0 => Some((number - 50.0) * 10.0),
        ("274.1", None) => Some(ZONE),
        _ => number,
    }
}

/// The unit of a sign's speed limit, km/h.
fn unit_of(signal: &Signal) -> f64 {
    match signal.unit.as_str() {
        "mph" => MILES_PER_HOUR,
        "m/s" => METRES_PER_SECOND,
        "" if signal.kind == MILES_SIGN => MILES_PER_HOUR,
        _ => 1.0,
    }
}

/// Whether a speed limit is one in metres per second though another unit is stated, as CommonRoad's exporter writes it: it is no whole
/// number, and a multiple of five once it is converted.
pub fn is_in_metres(signal: &Signal) -> bool {
    /// So much may be lost by rounding, km/h.
    const ROUNDING: f64 = 0.02;
    let is_multiple = |speed: f64, of: f64| (speed / of - (speed / of).round()).abs() * of <= ROUNDING;
    signal.value.is_some_and(|value| {
        let (whole, converted) = (is_multiple(value, 1.0), value * METRES_PER_SECOND);
        let limit = is_multiple(converted, 5.0) || is_multiple(converted / MILES_PER_HOUR, 5.0);
        value > 0.0 && signal.unit != "m/s" && !whole && limit
    })
}

/// Whether words name a stop line: bus stops and buildings have the word, too.
pub fn is_stop_line(words: &str) -> bool {
    ["stopline", "holdingline"].iter().any(|word| words.contains(word))
}

/// The stations of a road's stop lines, metres.
pub fn stop_stations(road: &Road) -> Vec<f64> {
    let signals = road.signals.iter().filter(|signal| use_of(signal) == SignalUse::StopLine);
    let objects = road.objects.iter().filter(|object| is_stop_line(&object.words()));
    let all = signals.map(|signal| signal.at[0]).chain(objects.map(|object| middle(road, object)));
    let mut all: Vec<f64> = all.collect();
    all.sort_by(f64::total_cmp);
    all
}

/// The station of the middle of a line, metres.
pub fn middle(road: &Road, object: &Object) -> f64 {
    let Some(ring) = object.ring(road) else { return object.at[0] };
    // Against the reference line there: lines are short.
    let at = road.plan.at(object.at[0]);
    let count = ring.len().max(1) as f64;
    let along: f64 =
        ring.iter().map(|[x, y, _]| (x - at.point.x) * at.angle.cos() + (y - at.point.y) * at.angle.sin()).sum();
    object.at[0] + along / count
}

/// Whether a light at a station stands between intersections for vehicles in a direction: 1 along the road, -1 against it.
pub fn is_between(road: &Road, station: f64, direction: i8) -> bool {
    let (gone, left) = if direction > 0 { (station, road.length - station) } else { (road.length - station, station) };
    left > BEFORE_END && gone > BEHIND_BEGIN
}

/// The stations of lights for vehicles between intersections, metres: lanes are split there.
pub fn lights_between(road: &Road) -> impl Iterator<Item = f64> + '_ {
    let lights = road.signals.iter().filter(|signal| use_of(signal) == SignalUse::VehicleLight);
    let between = |signal: &&Signal| {
        let station = signal.at[0];
        [1, -1].into_iter().any(|way| signal.validity.facing != -way && is_between(road, station, way))
    };
    lights.filter(between).map(|signal| signal.at[0])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_words_tell_what_a_signal_is_for() {
        let signal = |kind: &str, name: &str, dynamic| {
            use_of(&Signal { kind: kind.into(), name: name.into(), dynamic, ..Signal::default() })
        };
        assert_eq!(signal("1000001", "", true), SignalUse::VehicleLight);
        assert_eq!(signal("-1", "Signal_3Light_Post01", true), SignalUse::VehicleLight);
        assert_eq!(signal("-1", "Stop Line", false), SignalUse::StopLine);
        assert_eq!(signal("-1", "BusStop", false), SignalUse::Other);
        assert_eq!(signal("206", "", false), SignalUse::Stop);
        assert_eq!(signal("306", "", false), SignalUse::Priority);
    }

    #[test]
    fn speed_limits_have_their_units_and_those_in_metres_are_known() {
        let limit = |kind: &str, value: f64, unit: &str| {
            let signal = Signal { kind: kind.into(), value: Some(value), unit: unit.into(), ..Signal::default() };
            let SignalUse::Speed(limit) = use_of(&signal) else { panic!("{signal:?} is no speed limit") };
            (limit.round(), is_in_metres(&signal))
        };
        assert_eq!(limit("274", 30.0, ""), (30.0, false));
        assert_eq!(limit("274", 8.333_333, "km/h"), (30.0, true));
        assert_eq!(limit("274", 8.333_333, "m/s"), (30.0, false));
        assert_eq!(limit("R2-1", 30.0, ""), (48.0, false));
        assert_eq!(limit("R2-1", 13.4112, "km/h"), (48.0, true));
        assert_eq!(limit("274", 18.64, "mph"), (30.0, false));
    }

    #[test]
    fn variants_of_speed_signs_tell_their_limits() {
        let limit = |kind: &str, variant: &str| {
            use_of(&Signal { kind: kind.into(), subkind: variant.into(), value: Some(-1.0), ..Signal::default() })
        };
        assert_eq!(limit("274", "30"), SignalUse::Speed(30.0));
        assert_eq!(limit("274", "274-50"), SignalUse::Speed(50.0));
        assert_eq!(limit("274", "57"), SignalUse::Speed(70.0));
        assert_eq!(limit("274", "274-56"), SignalUse::Speed(60.0));
        assert_eq!(limit("274", "-1"), SignalUse::Other);
        assert_eq!(limit("274.1", "-1"), SignalUse::Speed(30.0));
        assert_eq!(limit("274.1", "20"), SignalUse::Speed(20.0));
    }
}
