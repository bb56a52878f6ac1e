//! Numbers as decimal digits, sixteen at a time: a map is numbers for the most part.

use std::io::Write;

/// The digits that are made at a time.
const AT_ONCE: usize = 16;
/// As many letters `0`.
const ZEROS: u128 = u128::from_ne_bytes([b'0'; AT_ONCE]);
/// Numbers below this have no more digits.
const BEYOND: u64 = 10_000_000_000_000_000;
/// Powers of ten up to the most decimals.
const TENS: [f64; 16] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15];

/// The text of a number with so many decimals (at most 15), -0 as 0.
pub fn fixed(number: f64, decimals: usize) -> String {
    let mut out = Vec::new();
    put_fixed(&mut out, number, decimals);
    String::from_utf8(out).unwrap_or_default()
}

/// Appends a number with so many decimals (at most 15), -0 as 0.
#[inline]
pub(super) fn put_fixed(out: &mut Vec<u8>, number: f64, decimals: usize) {
    /// Whole numbers up to here are exact in a double.
    const EXACT: f64 = 9e15;
    let steps = number.abs() * TENS[decimals.min(15)];
    if steps.is_nan() || steps > EXACT {
        let _ = write!(out, "{number:.decimals$}");
        return;
    }
    // Rounded without `round`, which is a function call where processors may be old.
    put_steps(out, number < 0.0, (steps + 0.5) as u64, decimals);
}

/// Appends a number with as many decimals as it has, -0 as 0.
pub(super) fn put_exact(out: &mut Vec<u8>, number: f64) {
    // Adding 0 turns -0 into 0.
    let number = number + 0.0;
    let millis = if number.abs() < 1e9 { (number.abs() * 1e3 + 0.5) as u64 } else { 0 };
    // Most are whole metres or millimetres, for which the general way is slow.
    if (millis as f64 / 1e3).copysign(number) != number {
        let _ = write!(out, "{number}");
    } else if millis % 1000 == 0 {
        put_steps(out, number < 0.0, millis / 1000, 0);
    } else {
        put_steps(out, number < 0.0, millis, 3);
        let spare = out.iter().rev().take_while(|digit| **digit == b'0').count();
        out.truncate(out.len() - spare);
    }
}

/// Appends a whole number.
#[inline]
pub(super) fn put_integer(out: &mut Vec<u8>, number: i64) {
    if number < 0 {
        out.push(b'-');
    }
    let number = number.unsigned_abs();
    if number < BEYOND {
        return put_steps(out, false, number, 0);
    }
    put_steps(out, false, number / BEYOND, 0);
    put_last(out, digits(number % BEYOND) | ZEROS, AT_ONCE);
}

/// Appends a number of steps, below [`BEYOND`], each a power of ten with so many decimals.
#[inline]
fn put_steps(out: &mut Vec<u8>, below_zero: bool, steps: u64, decimals: usize) {
    if below_zero && steps > 0 {
        out.push(b'-');
    }
    let digits = digits(steps);
    let known = AT_ONCE - digits.trailing_zeros() as usize / 8;
    let whole = known.saturating_sub(decimals).max(1);
    let digits = digits | ZEROS;
    let count = whole + decimals;
    if decimals == 0 {
        put_last(out, digits, whole);
    } else if count < AT_ONCE {
        // The point fits in between, and all is copied at once.
        let text = digits >> (8 * (AT_ONCE - count));
        let before = (1 << (8 * whole)) - 1;
        let point = u128::from(b'.') << (8 * whole);
        put_first(out, text & before | point | (text & !before) << 8, count + 1);
    } else {
        put_last(out, digits << (8 * decimals), whole);
        out.push(b'.');
        put_last(out, digits, decimals);
    }
}

/// Appends the last so many of the digits.
#[inline]
fn put_last(out: &mut Vec<u8>, digits: u128, count: usize) {
    put_first(out, digits >> (8 * (AT_ONCE - count)), count);
}

/// Appends the first so many letters. A fixed number of bytes is copied faster than one that is known late.
#[inline]
fn put_first(out: &mut Vec<u8>, text: u128, count: usize) {
    let end = out.len() + count;
    out.extend_from_slice(&text.to_le_bytes());
    out.truncate(end);
}

/// The sixteen digits of a number below [`BEYOND`], each a byte from 0 to 9, the first the lowest.
#[inline]
fn digits(number: u64) -> u128 {
    u128::from(eight_digits(number / 100_000_000)) | (u128::from(eight_digits(number % 100_000_000)) << 64)
}

/// As [`digits`] for eight: the number is halved thrice, and the halves stand beside each other in one word. To multiply
/// and shift is to divide by a hundred and by ten, for numbers as small as these.
#[inline]
fn eight_digits(number: u64) -> u64 {
    let fours = (number / 10_000) | ((number % 10_000) << 32);
    let hundreds = ((fours * 5243) >> 19) & 0x0000_007f_0000_007f;
    let twos = hundreds | ((fours - 100 * hundreds) << 16);
    let tens = ((twos * 103) >> 10) & 0x000f_000f_000f_000f;
    tens | ((twos - 10 * tens) << 8)
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
