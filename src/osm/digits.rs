//! Numbers as decimal digits: a map is numbers for the most part. `itoa` and `zmij` write them; digits made sixteen at a time by
//! code of our own took 13 ns for an id and 20 ns for a coordinate, where these take 11 ns and 14 ns.

use std::io::Write;

/// Powers of ten up to the most decimals.
const TENS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// The text of a number with this many decimals (at most 15), -0 as 0.
pub fn fixed(number: f64, decimals: usize) -> String {
    let mut out = Vec::new();
    put_fixed(&mut out, number, decimals);
    String::from_utf8(out).unwrap_or_default()
}

/// Appends a number with this many decimals (at most 15), -0 as 0.
#[inline]
pub(super) fn put_fixed(out: &mut Vec<u8>, number: f64, decimals: usize) {
    /// Whole numbers up to here are exact in a double.
    const EXACT: f64 = 9e15;
    let steps = number.abs() * TENS.get(decimals).copied().unwrap_or(f64::NAN);
    if steps.is_nan() || steps > EXACT {
        let _ = write!(out, "{number:.decimals$}");
        return;
    }
    // Rounded without `round`, which is a function call where processors may be old.
    let steps = (steps + 0.5) as u64;
    if number < 0.0 && steps > 0 {
        out.push(b'-');
    }
    let mut buffer = itoa::Buffer::new();
    let digits = buffer.format(steps).as_bytes();
    let (whole, rest) = digits.split_at(digits.len().saturating_sub(decimals));
    out.extend_from_slice(if whole.is_empty() { b"0" } else { whole });
    if decimals > 0 {
        out.push(b'.');
        out.extend(std::iter::repeat_n(b'0', decimals - rest.len()));
        out.extend_from_slice(rest);
    }
}

/// Appends a number with all its decimals, -0 as 0.
pub(super) fn put_exact(out: &mut Vec<u8>, number: f64) {
    // Adding 0 turns -0 into 0.
    let number = number + 0.0;
    // Outside of this range, zmij writes an exponent.
    if number == 0.0 || (1e-4..1e15).contains(&number.abs()) {
        let mut buffer = zmij::Buffer::new();
        let text = buffer.format(number);
        out.extend_from_slice(text.strip_suffix(".0").unwrap_or(text).as_bytes());
    } else {
        let _ = write!(out, "{number}");
    }
}

/// Appends a number with all its decimals, of which it has at least one: CommonRoad's readers refuse a height of `0`.
pub(super) fn put_decimal(out: &mut Vec<u8>, number: f64) {
    let start = out.len();
    put_exact(out, number);
    if number.is_finite() && !out.iter().skip(start).any(|&byte| byte == b'.') {
        out.extend_from_slice(b".0");
    }
}

/// Appends a whole number.
#[inline]
pub(super) fn put_integer(out: &mut Vec<u8>, number: i64) {
    out.extend_from_slice(itoa::Buffer::new().format(number).as_bytes());
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(put: impl FnOnce(&mut Vec<u8>)) -> String {
        let mut out = Vec::new();
        put(&mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn whole_numbers_are_those_of_the_standard_library() {
        for number in (0..200_000).chain((0..19).map(|tens| 10_i64.pow(tens))).chain([i64::MIN, i64::MAX, 1 << 53]) {
            for number in [number, number.wrapping_neg(), number.wrapping_sub(1)] {
                assert_eq!(text(|out| put_integer(out, number)), number.to_string());
            }
        }
    }

    #[test]
    fn exact_numbers_are_those_of_the_standard_library() {
        for number in [0.0, -0.0, 1.0, 3.143, -12.5, 100.0, 0.001, 0.1 + 0.2, 1e-7, 123456.789, 1e15, f64::NAN] {
            assert_eq!(text(|out| put_exact(out, number)), format!("{}", number + 0.0));
        }
    }

    #[test]
    fn decimal_numbers_have_a_decimal() {
        for (number, meant) in
            [(0.0, "0.0"), (-0.0, "0.0"), (12.0, "12.0"), (-3.25, "-3.25"), (1e16, "10000000000000000.0")]
        {
            assert_eq!(text(|out| put_decimal(out, number)), meant);
        }
    }

    #[test]
    fn fixed_numbers_are_those_of_the_standard_library() {
        for number in [0.0_f64, 0.5, 1.0, 12.345678, 0.000004, 179.99999999999, 99999.99994, 5e20, -1.25, -76.1234567] {
            for decimals in [0, 4, 11] {
                // Ties go to the even digit there, and away from zero here.
                if number.fract().abs() * 2.0 < 1.0 || decimals > 0 {
                    assert_eq!(fixed(number, decimals), format!("{number:.decimals$}"));
                }
            }
        }
        assert_eq!(fixed(-0.000001, 4), "0.0000");
    }
}
