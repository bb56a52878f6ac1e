//! Many numbers as a few.

use serde::Serialize;

/// Least, middle and most of a list of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Spread {
    /// How many numbers.
    pub count: usize,
    /// The least.
    pub min: f64,
    /// A twentieth is smaller.
    pub p5: f64,
    /// Half are smaller.
    pub median: f64,
    /// A twentieth is larger.
    pub p95: f64,
    /// The most.
    pub max: f64,
    /// Their mean.
    pub mean: f64,
}

impl Spread {
    /// Of the finite numbers; `None` if there is none.
    pub fn of(mut values: Vec<f64>) -> Option<Self> {
        values.retain(|v| v.is_finite());
        values.sort_unstable_by(f64::total_cmp);
        let count = values.len();
        let at = |share: f64| values.get(((count.checked_sub(1)? as f64) * share).round() as usize).copied();
        Some(Self {
            count,
            min: at(0.0)?,
            p5: at(0.05)?,
            median: at(0.5)?,
            p95: at(0.95)?,
            max: at(1.0)?,
            mean: values.iter().sum::<f64>() / count as f64,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_strays_do_not_matter() {
        let spread = Spread::of(vec![3.0, f64::NAN, 1.0, 2.0, f64::INFINITY]).unwrap();
        assert_eq!((spread.count, spread.min, spread.median, spread.max, spread.mean), (3, 1.0, 2.0, 3.0, 2.0));
        assert_eq!(Spread::of(Vec::new()), None);
    }
}
