//! The reference line of a road in the plane, exactly as the standard defines it: the stated length and station are the parameter,
//! whatever the length of the curve is.

use crate::geometry::{Point, Vector};

/// What one record draws, from its own origin along its own x axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// A straight line.
    Line,
    /// An arc, by its curvature, 1/m, left positive.
    Arc(f64),
    /// A clothoid, by the curvatures at its ends.
    Spiral([f64; 2]),
    /// v as a polynomial of u; the station is the length along the curve.
    Poly3([f64; 4]),
    /// u and v as polynomials of a parameter, which runs to 1 or, if `by_length`, to the length of the record.
    ParamPoly3 {
        /// Coefficients of u.
        u: [f64; 4],
        /// Coefficients of v.
        v: [f64; 4],
        /// `pRange="arcLength"`.
        by_length: bool,
    },
}

/// One record of `planView`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanRecord {
    /// The station at which it begins, metres.
    pub start: f64,
    /// Where it begins.
    pub origin: Point,
    /// Its direction there, radians.
    pub heading: f64,
    /// Metres.
    pub length: f64,
    /// Its shape.
    pub shape: Shape,
}

/// A place on a line, and the direction there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Heading {
    /// The place.
    pub point: Point,
    /// Radians, from east, counter-clockwise.
    pub angle: f64,
}

/// Nodes and weights of Gauss and Legendre on -1..1, the positive half.
const GAUSS: [[f64; 2]; 8] = [
    [0.095_012_509_837_637_44, 0.189_450_610_455_068_5],
    [0.281_603_550_779_258_9, 0.182_603_415_044_923_6],
    [0.458_016_777_657_227_4, 0.169_156_519_395_002_5],
    [0.617_876_244_402_643_7, 0.149_595_988_816_576_7],
    [0.755_404_408_355_003, 0.124_628_971_255_533_9],
    [0.865_631_202_387_831_7, 0.095_158_511_682_492_8],
    [0.944_575_023_073_232_6, 0.062_253_523_938_647_9],
    [0.989_400_934_991_649_9, 0.027_152_459_411_754_1],
];

/// The integral of a function from 0 to `end` in this number of parts.
fn integral<const N: usize>(end: f64, parts: usize, of: impl Fn(f64) -> [f64; N]) -> [f64; N] {
    let half = end / parts as f64 / 2.0;
    let mut sum = [0.0; N];
    for part in 0..parts {
        let middle = half * (2 * part + 1) as f64;
        for [node, weight] in GAUSS {
            for at in [middle - half * node, middle + half * node] {
                for (sum, value) in sum.iter_mut().zip(of(at)) {
                    *sum += weight * half * value;
                }
            }
        }
    }
    sum
}

fn polynomial([a, b, c, d]: [f64; 4], at: f64) -> f64 {
    a + at * (b + at * (c + at * d))
}

fn slope([_, b, c, d]: [f64; 4], at: f64) -> f64 {
    b + at * (2.0 * c + at * 3.0 * d)
}

/// A curvature, 1/m, below which an arc is a line.
const STRAIGHT_CURVATURE: f64 = 1e-12;
/// A turn of a spiral, radians, for each part of its integral; ...
const TURN: f64 = 1.0;
/// ... but no more parts than this: a spiral that winds more often is damaged.
const MOST_PARTS: f64 = 1000.0;

impl PlanRecord {
    /// The place at a distance from its begin, metres, and the direction there.
    pub fn at(&self, distance: f64) -> Heading {
        let (u, v, turn) = self.own(distance);
        let (sin, cos) = self.heading.sin_cos();
        Heading { point: self.origin + Vector::new(cos * u - sin * v, sin * u + cos * v), angle: self.heading + turn }
    }

    /// Its own coordinates, and the change of direction.
    fn own(&self, distance: f64) -> (f64, f64, f64) {
        match self.shape {
            Shape::Arc(curvature) if curvature.abs() > STRAIGHT_CURVATURE => {
                let turn = curvature * distance;
                (turn.sin() / curvature, (1.0 - turn.cos()) / curvature, turn)
            }
            Shape::Spiral([from, to]) if self.length > 0.0 => {
                let rate = (to - from) / self.length;
                let turn = |at: f64| at * (from + rate * at / 2.0);
                let most = from.abs() * distance.abs() + rate.abs() * distance * distance;
                let parts = (most / TURN).clamp(0.0, MOST_PARTS) as usize + 1;
                let [u, v] = integral(distance, parts, |at| [turn(at).cos(), turn(at).sin()]);
                (u, v, turn(distance))
            }
            Shape::Poly3(factors) => {
                let u = along(factors, distance);
                (u, polynomial(factors, u), slope(factors, u).atan())
            }
            Shape::ParamPoly3 { u, v, by_length } => {
                let at = if by_length || self.length <= 0.0 { distance } else { distance / self.length };
                (polynomial(u, at), polynomial(v, at), slope(v, at).atan2(slope(u, at)))
            }
            Shape::Line | Shape::Arc(_) | Shape::Spiral(_) => (distance, 0.0, 0.0),
        }
    }
}

/// The u at which a polynomial's curve is so long, by Newton's method.
fn along(factors: [f64; 4], length: f64) -> f64 {
    let speed = |u: f64| slope(factors, u).hypot(1.0);
    let mut u = length;
    for _ in 0..12 {
        let [reached] = integral(u, 8, |at| [speed(at)]);
        let step = (reached - length) / speed(u);
        u -= step;
        if step.abs() < 1e-10 {
            break;
        }
    }
    if u.is_finite() { u } else { length }
}

/// The reference line of a road.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlanView(Vec<PlanRecord>);

impl PlanView {
    /// Records in any order.
    pub fn new(mut records: Vec<PlanRecord>) -> Self {
        records.sort_by(|a, b| a.start.total_cmp(&b.start));
        Self(records)
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// The records, in order.
    pub fn records(&self) -> &[PlanRecord] {
        &self.0
    }

    /// The place at a station, metres, and the direction there.
    pub fn at(&self, station: f64) -> Heading {
        let behind = self.0.partition_point(|record| record.start <= station);
        let record = self.0.get(behind.saturating_sub(1));
        record.map_or(Heading { point: Point::origin(), angle: 0.0 }, |record| record.at(station - record.start))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(length: f64, shape: Shape) -> PlanRecord {
        PlanRecord { start: 0.0, origin: Point::new(10.0, 20.0), heading: std::f64::consts::FRAC_PI_2, length, shape }
    }

    fn near(at: Heading, x: f64, y: f64, degrees: f64) {
        assert!((at.point - Point::new(x, y)).norm() < 1e-6, "{at:?}");
        assert!((at.angle.to_degrees() - degrees).abs() < 1e-4, "{at:?}");
    }

    #[test]
    fn lines_and_arcs() {
        near(record(5.0, Shape::Line).at(5.0), 10.0, 25.0, 90.0);
        let quarter = 10.0 * std::f64::consts::FRAC_PI_2;
        near(record(quarter, Shape::Arc(0.1)).at(quarter), 0.0, 30.0, 180.0);
        near(record(quarter, Shape::Arc(-0.1)).at(quarter), 20.0, 30.0, 0.0);
        near(record(5.0, Shape::Arc(0.0)).at(5.0), 10.0, 25.0, 90.0);
    }

    #[test]
    fn a_clothoid_is_that_of_fresnel() {
        // With curvature s the integrals of cos and sin of s^2/2 up to 1 are 0.9752876883 and 0.1637140489 (tables of Fresnel).
        near(
            record(1.0, Shape::Spiral([0.0, 1.0])).at(1.0),
            10.0 - 0.163_714,
            20.0 + 0.975_287_7,
            90.0 + 28.647_889_757,
        );
        let constant = record(8.0, Shape::Spiral([0.1, 0.1])).at(8.0);
        let arc = record(8.0, Shape::Arc(0.1)).at(8.0);
        assert!((constant.point - arc.point).norm() < 1e-9);
    }

    #[test]
    fn polynomials_in_both_ranges() {
        let (u, v) = ([0.0, 10.0, 0.0, 0.0], [0.0, 0.0, 2.0, 0.0]);
        let normalized = record(10.0, Shape::ParamPoly3 { u, v, by_length: false });
        near(normalized.at(5.0), 9.5, 25.0, 90.0 + 11.309_932_474);
        let u = [0.0, 1.0, 0.0, 0.0];
        near(record(10.0, Shape::ParamPoly3 { u, v, by_length: true }).at(1.0), 8.0, 21.0, 90.0 + 75.963_756_533);
        // The length of v = u over u = 3 is 3 times the root of 2.
        let slanted = record(9.0, Shape::Poly3([0.0, 1.0, 0.0, 0.0]));
        near(slanted.at(3.0 * std::f64::consts::SQRT_2), 7.0, 23.0, 135.0);
    }

    #[test]
    fn the_record_at_a_station_counts() {
        let second = PlanRecord { start: 5.0, origin: Point::new(0.0, 0.0), heading: 0.0, ..record(5.0, Shape::Line) };
        let plan = PlanView::new(vec![second, record(5.0, Shape::Line)]);
        near(plan.at(4.0), 10.0, 24.0, 90.0);
        near(plan.at(7.0), 2.0, 0.0, 0.0);
    }
}
