//! Reads the values of tags as numbers and lists.

use crate::osm::Tags;

const METRES_PER_FOOT: f64 = 0.3048;
const METRES_PER_INCH: f64 = 0.0254;

/// A length in metres from `3`, `3.5 m`, `3,5`, `350 cm`, `10'`, `12'6"`, `10 ft`; `None` if it is none of these or not
/// positive.
pub(crate) fn metres(text: &str) -> Option<f64> {
    let text = text.trim();
    let value = if text.contains(['\'', '"']) { feet_and_inches(text)? } else { with_unit(text)? };
    (value.is_finite() && value > 0.0).then_some(value)
}

fn with_unit(text: &str) -> Option<f64> {
    let split = text.find(|c: char| c.is_ascii_alphabetic()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let metres = match unit.trim() {
        "" | "m" | "metre" | "metres" | "meter" | "meters" => 1.0,
        "cm" => 0.01,
        "ft" | "feet" | "foot" => METRES_PER_FOOT,
        "in" | "inch" | "inches" => METRES_PER_INCH,
        _ => return None,
    };
    Some(number_of(number)? * metres)
}

fn feet_and_inches(text: &str) -> Option<f64> {
    let (feet, rest) = match text.split_once('\'') {
        Some((feet, rest)) => (number_of(feet)?, rest),
        None => (0.0, text),
    };
    let inches = match rest.trim().trim_end_matches('"').trim() {
        "" => 0.0,
        inches => number_of(inches)?,
    };
    Some(feet * METRES_PER_FOOT + inches * METRES_PER_INCH)
}

/// A number with a point or a comma before its decimals.
pub(crate) fn number_of(text: &str) -> Option<f64> {
    let text = text.trim();
    if text.contains('.') { text.parse().ok() } else { text.replacen(',', ".", 1).parse().ok() }
}

/// The length under the first of `keys` that has a valid one, metres.
pub(crate) fn metres_under<'k>(tags: &Tags, keys: impl IntoIterator<Item = &'k str>) -> Option<f64> {
    keys.into_iter().find_map(|key| metres(tags.get(key)?))
}

/// The entries of a `:lanes` value, left to right in the direction of travel.
pub(crate) fn per_lane(value: &str) -> impl Iterator<Item = &str> {
    value.split('|').map(str::trim)
}

/// Whether a value allows access.
pub(crate) fn is_yes(value: &str) -> bool {
    matches!(value, "yes" | "designated" | "official" | "permissive")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_are_read_in_every_common_unit() {
        let near = |text: &str, expected: f64| {
            let value = metres(text).unwrap_or(f64::NAN);
            assert!((value - expected).abs() < 1e-9, "{text}: {value}");
        };
        near("3", 3.0);
        near(" 3.5 m", 3.5);
        near("3,5", 3.5);
        near("350 cm", 3.5);
        near("10'", 3.048);
        near("12'6\"", 3.81);
        near("12' 6\"", 3.81);
        near("6\"", 0.1524);
        near("10 ft", 3.048);
        for bad in ["", "wide", "3 furlongs", "-2", "0", "3;4", "3-4", "nan", "inf", "'", "\""] {
            assert_eq!(metres(bad), None, "{bad}");
        }
    }
}
