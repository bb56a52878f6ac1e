//! Positive numbers with 64 binary digits, as `long double` has on x86. Results that another program computed with `long double`
//! are the same to the last digit only if they are computed with the same number of digits.

/// The number of binary digits of a mantissa.
const DIGITS: u32 = 64;

/// The number `mantissa` times two to the power of `exponent`. The highest bit of a mantissa is set unless it is zero, so that
/// the derived order is that of the numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Extended {
    exponent: i32,
    mantissa: u64,
}

impl Extended {
    /// Zero.
    pub const ZERO: Self = Self { exponent: i32::MIN, mantissa: 0 };

    /// The number nearest to `digits` times two to the power of `exponent`; of two equally near, the even one. `more` tells
    /// whether digits other than zero follow.
    fn rounded(digits: u128, exponent: i32, more: bool) -> Self {
        let excess = u128::BITS - DIGITS;
        let shift = digits.leading_zeros();
        if shift == u128::BITS {
            return Self::ZERO;
        }
        let digits = digits << shift;
        let exponent = exponent - shift.cast_signed() + excess.cast_signed();
        let (high, low) = ((digits >> excess) as u64, digits as u64);
        let half = 1_u64 << (excess - 1);
        let up = low > half || (low == half && (more || high % 2 == 1));
        match high.checked_add(u64::from(up)) {
            Some(mantissa) => Self { exponent, mantissa },
            None => Self { exponent: exponent + 1, mantissa: 1 << (DIGITS - 1) },
        }
    }

    /// The quotient; `None` if `by` is zero.
    pub fn over(self, by: Self) -> Option<Self> {
        let [own, by_digits] = [self, by].map(|one| u128::from(one.mantissa));
        let whole = own << DIGITS;
        let (first, rest) = (whole.checked_div(by_digits)?, (whole % by_digits) << 2);
        // Two additional digits decide how the quotient is rounded.
        let quotient = (first << 2) | (rest / by_digits);
        let exponent = self.exponent.saturating_sub(by.exponent).saturating_sub(DIGITS.cast_signed() + 2);
        Some(Self::rounded(quotient, exponent, !rest.is_multiple_of(by_digits)))
    }
}

impl std::ops::Add for Extended {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        let (high, low) = (self.max(other), self.min(other));
        if low == Self::ZERO {
            return high;
        }
        let room = DIGITS - 2;
        let [a, b] = [high, low].map(|one| u128::from(one.mantissa) << room);
        let apart = u32::try_from(high.exponent - low.exponent).unwrap_or(u32::MAX);
        let moved = b.checked_shr(apart).unwrap_or(0);
        let more = moved.checked_shl(apart) != Some(b);
        Self::rounded(a + moved, high.exponent - room.cast_signed(), more)
    }
}

impl std::ops::Mul for Extended {
    type Output = Self;

    fn mul(self, by: Self) -> Self {
        let product = u128::from(self.mantissa) * u128::from(by.mantissa);
        Self::rounded(product, self.exponent.saturating_add(by.exponent), false)
    }
}

impl From<f64> for Extended {
    /// Converts a number that is neither negative nor infinite.
    fn from(value: f64) -> Self {
        let bits = value.abs().to_bits();
        let exponent = i32::from((bits >> 52) as u16);
        let fraction = bits & ((1 << 52) - 1);
        let digits = if exponent == 0 { fraction } else { fraction | (1 << 52) };
        Self::rounded(u128::from(digits), exponent.max(1) - 1075, false)
    }
}

impl From<Extended> for f64 {
    fn from(value: Extended) -> Self {
        // In two steps: the power alone may be too small for a double.
        let half = value.exponent / 2;
        value.mantissa as Self * 2_f64.powi(half) * 2_f64.powi(value.exponent - half)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_double_holds_stays_as_it_is() {
        for value in [0.0, 1.0, 0.1, 85_726.303_699_999_12, 1e-300, 1e300] {
            assert_eq!(f64::from(Extended::from(value)), value);
        }
    }

    /// Values of `long double` on x86, times two to the power of 64.
    #[test]
    fn digits_beyond_those_of_a_double_are_kept() {
        let [third, tenth] = [3.0, 10.0].map(|by| Extended::from(1.0).over(Extended::from(by)).unwrap());
        assert_eq!((third.mantissa, third.exponent), (0xaaaa_aaaa_aaaa_aaab, -65));
        assert_eq!((tenth.mantissa, tenth.exponent), (0xcccc_cccc_cccc_cccd, -67));
        let sum = Extended::from(1.0) + Extended::from(2_f64.powi(-60));
        assert_eq!(sum.mantissa, (1 << 63) + 8);
        assert_eq!(
            (Extended::from(1.0) + Extended::from(2_f64.powi(-64))).mantissa,
            1 << 63,
            "a half goes to the even one"
        );
        assert_eq!((third * Extended::from(3.0)).mantissa, 1 << 63);
        assert!(third > Extended::from(1.0 / 3.0) && tenth < Extended::from(0.1));
        assert_eq!(Extended::from(1.0).over(Extended::ZERO), None);
        assert_eq!(Extended::ZERO.over(Extended::from(3.0)), Some(Extended::ZERO));
        assert_eq!(Extended::ZERO * third, Extended::ZERO);
    }
}
