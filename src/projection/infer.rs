//! Which projection a map was made with: the one that takes its degrees to its metres.

use nalgebra::{Matrix2, Vector2};

use crate::geometry::Point;

use super::{LonLat, MgrsGrid, Projector};

/// A point whose place is said twice.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Twice {
    /// In degrees.
    pub place: LonLat,
    /// Ellipsoidal height, metres.
    pub ele: f64,
    /// `local_x`, `local_y`, metres.
    pub local: Point,
}

/// How well a projection explains a map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Explained {
    /// The projection, with its origin where it has one.
    pub projector: Projector,
    /// The largest distance between the metres it gives and those of the map, metres.
    pub residual: f64,
}

/// Points that an origin is fitted to; more make it slower, not better.
const FITTED: usize = 200;
/// Steps of a fit: each squares the error.
const STEPS: usize = 12;
/// For differences, degrees: 0.1 m.
const NUDGE: f64 = 1e-6;

/// All of Autoware's projections that have degrees, the best first.
pub fn infer(points: &[Twice]) -> Vec<Explained> {
    let Some(first) = points.first() else { return Vec::new() };
    let sample: Vec<Twice> = points.iter().copied().step_by(points.len().div_ceil(FITTED)).collect();
    let start = start(&sample);
    let fits: [fn(LonLat) -> Projector; 4] = [
        |origin| Projector::LocalCartesianUtm { origin },
        Projector::transverse_mercator,
        |origin| Projector::TransverseMercator { origin, scale_factor: 1.0 },
        |origin| Projector::LocalCartesian { origin },
    ];
    let fitted = fits.iter().map(|of| of(fit(&sample, start, *of)));
    let mut found: Vec<Explained> = MgrsGrid::of(first.place)
        .map(Projector::Mgrs)
        .into_iter()
        .chain(fitted)
        .map(|projector| Explained { projector, residual: residual(points, &projector) })
        .collect();
    // Within a millimetre they are equal, and the one with less to choose comes first: an origin can imitate MGRS.
    let millimetres = |one: &Explained| (one.residual * 1e3).round();
    found.sort_by(|a, b| millimetres(a).total_cmp(&millimetres(b)));
    found
}

/// The largest distance between what a projection says and what the map says, metres; infinite where it does not reach.
pub fn residual(points: &[Twice], projector: &Projector) -> f64 {
    distances(points, projector).into_iter().fold(0.0, f64::max)
}

/// The share of the points (1) of which a projection says what the map says, up to a distance (m).
pub fn share(points: &[Twice], projector: &Projector, distance: f64) -> f64 {
    let near = distances(points, projector).into_iter().filter(|far| *far <= distance).count();
    near as f64 / points.len().max(1) as f64
}

/// The distance between what a projection says of each point and what the map says, metres; infinite where it does not reach.
fn distances(points: &[Twice], projector: &Projector) -> Vec<f64> {
    let places: Vec<LonLat> = points.iter().map(|point| point.place).collect();
    let said = projector.forward_each(&places, |i| points[i].ele);
    let far = |(point, said): (&Twice, Option<Point>)| said.map_or(f64::INFINITY, |said| (said - point.local).norm());
    points.iter().zip(said).map(far).collect()
}

/// Where the metres are about 0, if one degree is as long as at the first point.
fn start(points: &[Twice]) -> LonLat {
    const METRES_PER_DEGREE: f64 = 111_200.0;
    let first = points[0];
    let parallel = METRES_PER_DEGREE * first.place.lat.to_radians().cos().max(0.01);
    let lat = first.place.lat - first.local.y / METRES_PER_DEGREE;
    let lon = first.place.lon - first.local.x / parallel;
    LonLat { lon: lon.clamp(-180.0, 180.0), lat: lat.clamp(-89.0, 89.0) }
}

/// The origin with the least squares, by Gauss and Newton.
fn fit(points: &[Twice], start: LonLat, of: fn(LonLat) -> Projector) -> LonLat {
    let places: Vec<LonLat> = points.iter().map(|point| point.place).collect();
    let has_zones = matches!(of(start), Projector::LocalCartesianUtm { .. });
    let errors = |origin: LonLat| -> Option<Vec<Vector2<f64>>> {
        // Without zones all meridians are alike: the Earth is turned, since PROJ takes long for a plane on another meridian.
        let turn = if has_zones { 0.0 } else { start.lon - origin.lon };
        let turned = |place: &LonLat| LonLat { lon: place.lon + turn, ..*place };
        let places: Vec<LonLat> = places.iter().map(turned).collect();
        let said = of(turned(&origin)).forward_each(&places, |i| points[i].ele);
        said.into_iter().zip(points).map(|(said, point)| said.map(|said| said - point.local)).collect()
    };
    let mut origin = start;
    for _ in 0..STEPS {
        let east = LonLat { lon: origin.lon + NUDGE, ..origin };
        let north = LonLat { lat: origin.lat + NUDGE, ..origin };
        let (Some(here), Some(east), Some(north)) = (errors(origin), errors(east), errors(north)) else { break };
        let (mut normal, mut right) = (Matrix2::zeros(), Vector2::zeros());
        for ((here, east), north) in here.iter().zip(&east).zip(&north) {
            let slope = Matrix2::from_columns(&[(east - here) / NUDGE, (north - here) / NUDGE]);
            normal += slope.transpose() * slope;
            right += slope.transpose() * here;
        }
        let Some(step) = normal.try_inverse().map(|inverse| inverse * right) else { break };
        origin =
            LonLat { lon: (origin.lon - step.x).clamp(-180.0, 180.0), lat: (origin.lat - step.y).clamp(-89.9, 89.9) };
        if step.norm() < 1e-12 {
            break;
        }
    }
    // What a fit leaves behind the twelfth decimal, a tenth of a micrometre, is noise; adding 0 turns -0 into 0.
    let round = |degrees: f64| (degrees * 1e12).round() / 1e12 + 0.0;
    LonLat { lon: round(origin.lon), lat: round(origin.lat) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn town(middle: LonLat) -> impl Iterator<Item = LonLat> {
        (0..49).map(move |i| LonLat {
            lon: middle.lon + f64::from(i % 7) * 0.003,
            lat: middle.lat + f64::from(i / 7) * 0.002,
        })
    }

    #[test]
    fn each_projection_is_found_with_its_origin() {
        for middle in [LonLat { lon: 139.78, lat: 35.62 }, LonLat { lon: -70.6, lat: -33.4 }] {
            let origin = LonLat { lon: middle.lon - 0.01, lat: middle.lat + 0.02 };
            let grid = MgrsGrid::of(middle).unwrap();
            for projector in [
                Projector::Mgrs(grid),
                Projector::LocalCartesianUtm { origin },
                Projector::transverse_mercator(origin),
                Projector::LocalCartesian { origin },
            ] {
                let ele = |i: usize| 20.0 + i as f64;
                let places: Vec<LonLat> = town(middle).collect();
                let local = projector.forward_each(&places, ele);
                let points: Vec<Twice> = places
                    .iter()
                    .zip(local)
                    .enumerate()
                    .map(|(i, (&place, local))| Twice { place, ele: ele(i), local: local.unwrap() })
                    .collect();
                let best = infer(&points)[0];
                assert_eq!(best.projector.name(), projector.name());
                assert!(best.residual < 1e-6, "{projector:?}: {best:?}");
                assert!(residual(&points, &projector) < 1e-9);
            }
        }
    }

    #[test]
    fn nothing_is_explained_by_nothing() {
        assert_eq!(infer(&[]), []);
    }
}
