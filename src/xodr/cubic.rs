//! Cubic polynomials, each valid from a station on: heights, widths, offsets.

/// One polynomial.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cubic {
    /// The station, metres, from which on it is valid and at which its parameter is 0.
    pub start: f64,
    /// Coefficients of the powers 0 to 3 of the distance from `start`.
    pub factors: [f64; 4],
}

impl Cubic {
    /// Its value at a station, metres.
    pub fn at(&self, station: f64) -> f64 {
        let d = station - self.start;
        let [a, b, c, e] = self.factors;
        a + d * (b + d * (c + d * e))
    }
}

/// Polynomials in order of their stations.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Cubics(Vec<Cubic>);

impl Cubics {
    /// In any order.
    pub fn new(mut parts: Vec<Cubic>) -> Self {
        parts.sort_by(|a, b| a.start.total_cmp(&b.start));
        Self(parts)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The stations at which polynomials begin, metres.
    pub fn starts(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|cubic| cubic.start)
    }

    /// The value at a station, metres, of the polynomial that is valid at the station `pick`; 0 where there is none.
    pub fn at(&self, station: f64, pick: f64) -> f64 {
        let behind = self.0.partition_point(|cubic| cubic.start <= pick);
        self.0.get(behind.saturating_sub(1)).map_or(0.0, |cubic| cubic.at(station))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_that_begins_last_before_a_station_is_valid() {
        let cubics = Cubics::new(vec![
            Cubic { start: 10.0, factors: [5.0, 0.0, 1.0, 0.0] },
            Cubic { start: 0.0, factors: [1.0, 2.0, 0.0, 0.0] },
        ]);
        assert_eq!(cubics.at(3.0, 3.0), 7.0);
        assert_eq!(cubics.at(12.0, 12.0), 9.0);
        assert_eq!(cubics.at(10.0, 9.9), 21.0, "the limit from before");
        assert_eq!(cubics.at(-1.0, -1.0), -1.0, "the first one reaches back");
        assert_eq!(Cubics::default().at(1.0, 1.0), 0.0);
    }
}
