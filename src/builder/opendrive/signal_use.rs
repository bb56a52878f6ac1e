//! What signals of a file are for, by their numbers and words, and where lights stand between intersections.

use crate::xodr::{Road, Signal};

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
    if ["274", "274.1"].contains(&kind) {
        let unit = match signal.unit.as_str() {
            "mph" => 1.609_344,
            "m/s" => 3.6,
            _ => 1.0,
        };
        let of_variant = || signal.subkind.rsplit('-').next().and_then(|digits| digits.parse::<f64>().ok());
        let value = signal.value.filter(|value| *value > 0.0).or_else(of_variant).filter(|value| *value > 0.0);
        return value.map_or(SignalUse::Other, |value| SignalUse::Speed(value * unit));
    }
    SignalUse::Other
}

/// Whether words name a stop line: bus stops and buildings have the word, too.
pub fn is_stop_line(words: &str) -> bool {
    ["stopline", "holdingline"].iter().any(|word| words.contains(word))
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
        let limit = Signal { kind: "274".into(), subkind: "274-56".into(), ..Signal::default() };
        assert_eq!(use_of(&limit), SignalUse::Speed(56.0));
    }
}
