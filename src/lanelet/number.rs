//! Numbers in tags, as C's `strtod` and `strtol` read them.

/// The number that a whole text says: blanks before it, an exponent, hexadecimal digits, `nan` and `inf` are taken.
pub fn number(text: &str) -> Option<f64> {
    let text = text.trim_start();
    let hexadecimal = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"));
    match hexadecimal {
        Some(digits) => i64::from_str_radix(digits, 16).ok().map(|value| value as f64),
        None => text.parse().ok(),
    }
}

/// The number at the start of a text.
pub fn leading_number(text: &str) -> Option<f64> {
    let text = text.trim_start();
    let ends = text.char_indices().map(|(at, _)| at).skip(1).chain([text.len()]);
    ends.filter_map(|end| number(&text[..end])).last()
}

/// A speed with its unit as Lanelet2 reads it, in km/h: `60km/h`, `30 mph`, `10 m/s`. `None` without a unit that it knows.
pub fn speed_with_unit(text: &str) -> Option<f64> {
    const UNITS: [(&str, f64); 5] = [("km/h", 1.0), ("kmh", 1.0), ("mph", 1.609344), ("m/s", 3.6), ("mps", 3.6)];
    let (digits, factor) = UNITS.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    Some(number(digits.trim_end())? * factor)
}

/// The integer at the start of a text.
pub fn leading_integer(text: &str) -> Option<i64> {
    let text = text.trim_start();
    let digits = text.strip_prefix(['+', '-']).unwrap_or(text);
    let count = digits.bytes().take_while(u8::is_ascii_digit).count();
    text[..text.len() - digits.len() + count].parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_follows_a_number_does_not_count() {
        assert_eq!(leading_integer(" 12ab"), Some(12));
        assert_eq!(leading_integer("-7"), Some(-7));
        assert_eq!(leading_number("0.45 m"), Some(0.45));
        for none in ["", "abc", "-", "99999999999999999999"] {
            assert_eq!(leading_integer(none), None, "{none}");
        }
        assert_eq!(leading_number("high"), None);
    }

    #[test]
    fn units_are_those_that_lanelet2_knows() {
        assert_eq!(speed_with_unit("60km/h"), Some(60.0));
        assert_eq!(speed_with_unit(" 60 kmh"), Some(60.0));
        assert_eq!(speed_with_unit("10 mps"), Some(36.0));
        assert!(speed_with_unit("30 mph").is_some_and(|speed| (speed - 48.2803).abs() < 1e-4));
        for none in ["60", "60 kph", "60 KM/H", "10 knots", "km/h", "fast mph"] {
            assert_eq!(speed_with_unit(none), None, "{none}");
        }
    }

    #[test]
    fn what_c_takes_is_taken() {
        assert_eq!(number(" 50"), Some(50.0));
        assert_eq!(number("5e1"), Some(50.0));
        assert_eq!(number("0x32"), Some(50.0));
        assert!(number("nan").is_some_and(f64::is_nan));
        for none in ["", "50 km/h", "50 ", "fast"] {
            assert_eq!(number(none), None, "{none}");
        }
    }
}
