//! What lifts the surface of a road off its plane: lateral shapes, and heights of lanes.

use super::cubic::Cubics;

/// Lateral shapes of a road: cross-sections at stations, between which the surface is interpolated.
#[derive(Clone, Debug, Default)]
pub struct Shapes(Vec<(f64, Cubics)>);

impl Shapes {
    /// From the stations of cross-sections, metres, each with heights by the offset to the left, metres; in any order.
    pub fn new(mut sections: Vec<(f64, Cubics)>) -> Self {
        sections.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(sections)
    }

    /// The stations of the cross-sections, metres.
    pub fn stations(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|(station, _)| *station)
    }

    /// The height above the plane at a station and an offset to the left, all in metres.
    pub fn at(&self, station: f64, offset: f64) -> f64 {
        between(&self.0, station, |heights| heights.at(offset, offset))
    }
}

/// Heights of a lane's surface above the plane of its road.
#[derive(Clone, Debug, Default)]
pub struct LaneHeights(Vec<(f64, [f64; 2])>);

impl LaneHeights {
    /// From distances from the begin of the section, each with the heights of the inner and the outer border, all in metres; in any
    /// order.
    pub fn new(mut heights: Vec<(f64, [f64; 2])>) -> Self {
        heights.sort_by(|a, b| a.0.total_cmp(&b.0));
        Self(heights)
    }

    /// The distances from the begin of the section at which heights are said, metres.
    pub fn starts(&self) -> impl Iterator<Item = f64> + '_ {
        self.0.iter().map(|(start, _)| *start)
    }

    /// The height of the inner or the outer border so far from the begin of the section, metres.
    pub fn at(&self, distance: f64, outer: bool) -> f64 {
        between(&self.0, distance, |[inner, at_outer]| if outer { *at_outer } else { *inner })
    }
}

/// A value at a station, between those at the stations before and behind; 0 where there is none.
fn between<T>(known: &[(f64, T)], station: f64, value: impl Fn(&T) -> f64) -> f64 {
    let behind = known.partition_point(|(start, _)| *start <= station);
    let Some((from, before)) = known.get(behind.saturating_sub(1)) else { return 0.0 };
    let before = value(before);
    match known.get(behind).filter(|_| behind > 0) {
        Some((to, after)) => before + (value(after) - before) * (station - from) / (to - from),
        None => before,
    }
}

#[cfg(test)]
mod tests {
    use super::super::cubic::Cubic;
    use super::*;

    #[test]
    fn shapes_are_interpolated_between_their_stations() {
        let slope = |b: f64| Cubics::new(vec![Cubic { start: -10.0, factors: [-10.0 * b, b, 0.0, 0.0] }]);
        let shapes = Shapes::new(vec![(20.0, slope(0.04)), (0.0, slope(0.02))]);
        assert!((shapes.at(0.0, 5.0) - 0.1).abs() < 1e-12);
        assert!((shapes.at(10.0, 5.0) - 0.15).abs() < 1e-12);
        assert!((shapes.at(90.0, -5.0) + 0.2).abs() < 1e-12);
        assert_eq!(Shapes::default().at(0.0, 5.0), 0.0);
    }

    #[test]
    fn heights_of_a_lane_rise_from_one_to_the_next() {
        let heights = LaneHeights::new(vec![(0.0, [0.0, 0.1]), (10.0, [0.0, 0.3])]);
        assert!((heights.at(5.0, true) - 0.2).abs() < 1e-12);
        assert_eq!([heights.at(5.0, false), heights.at(50.0, true), heights.at(-1.0, true)], [0.0, 0.3, 0.1]);
    }
}
