//! Longitude and latitude to metres and back, as Autoware does it.
//!
//! Autoware has five projector types; each is reproduced with its quirks (`map_projection_loader` and the projectors
//! of `autoware_lanelet2_extension`). Heights play a part in [`Projector::LocalCartesian`] only.

mod chebyshev_inverse;
mod engine;
mod enu;
mod exact_utm;
mod infer;
mod info;
mod lon_lat;
mod mgrs;

pub use lon_lat::LonLat;

use crate::geometry::Point;

use engine::Frame;
pub use engine::warm_up;
pub use exact_utm::ExactUtm;
pub use infer::{Explained, Twice, infer, residual, share};
pub use info::{Info, InfoError, VerticalDatum, read_info, write_info};
pub use mgrs::{MgrsError, MgrsGrid};

/// A box of longitudes and latitudes, degrees. East of the antimeridian longitudes are beyond 180 where it reaches over it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Extent {
    /// Its south-western corner.
    pub min: LonLat,
    /// Its north-eastern corner.
    pub max: LonLat,
}

impl Extent {
    /// The smallest box around these places; `None` if there is none.
    pub fn of(places: impl IntoIterator<Item = LonLat>) -> Option<Self> {
        places.into_iter().map(Extents::of).reduce(Extents::with).map(Extents::narrower)
    }

    fn with(self, Self { min, max }: Self) -> Self {
        let min = LonLat { lon: self.min.lon.min(min.lon), lat: self.min.lat.min(min.lat) };
        Self { min, max: LonLat { lon: self.max.lon.max(max.lon), lat: self.max.lat.max(max.lat) } }
    }

    fn width(&self) -> f64 {
        self.max.lon - self.min.lon
    }

    /// All of it.
    pub const EARTH: Self = Self { min: LonLat { lon: -180.0, lat: -90.0 }, max: LonLat { lon: 180.0, lat: 90.0 } };

    /// Whether a place lies in it; its rim belongs to it.
    pub fn contains(&self, place: LonLat) -> bool {
        let lon = self.min.lon..=self.max.lon;
        (lon.contains(&place.lon) || lon.contains(&(place.lon + 360.0)))
            && (self.min.lat..=self.max.lat).contains(&place.lat)
    }

    /// Its middle.
    pub fn center(&self) -> LonLat {
        LonLat { lon: on_earth((self.min.lon + self.max.lon) / 2.0), lat: (self.min.lat + self.max.lat) / 2.0 }
    }
}

/// The boxes around places with longitudes from -180 to 180 and from 0 to 360 degrees: one of them is the smallest.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Extents([Extent; 2]);

impl Extents {
    /// Around one place.
    pub(crate) fn of(place: LonLat) -> Self {
        let east = if place.lon < 0.0 { LonLat { lon: place.lon + 360.0, ..place } } else { place };
        Self([place, east].map(|place| Extent { min: place, max: place }))
    }

    /// Around the places of both; in any order the same.
    pub(crate) fn with(self, Self([other, other_east]): Self) -> Self {
        let Self([own, own_east]) = self;
        Self([own.with(other), own_east.with(other_east)])
    }

    /// The smaller box.
    pub(crate) fn narrower(self) -> Extent {
        let Self([plain, east]) = self;
        if plain.width() > 180.0 && east.width() < plain.width() { east } else { plain }
    }
}

/// A longitude from -180 to 180 degrees.
fn on_earth(lon: f64) -> f64 {
    if lon > 180.0 { lon - 360.0 } else { lon }
}

/// Autoware's scale factor where `map_projector_info.yaml` names none. It is a 32-bit float there, and the difference
/// is 0.7 mm in 100 km.
pub const DEFAULT_SCALE_FACTOR: f32 = 0.9996;

/// One of Autoware's ways to turn longitude and latitude into metres, by `projector_type`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projector {
    /// UTM coordinates modulo 100 km, in the zone of each point itself. The grid serves the way back only.
    Mgrs(MgrsGrid),
    /// UTM coordinates in the zone of the origin, relative to the origin.
    LocalCartesianUtm {
        /// Where east and north are 0.
        origin: LonLat,
    },
    /// A transverse Mercator of its own, with the origin on the central meridian.
    TransverseMercator {
        /// Where east and north are 0.
        origin: LonLat,
        /// Scale on the central meridian.
        scale_factor: f32,
    },
    /// East, north, up in the tangent plane at the origin; the only one in which heights move a point sideways.
    LocalCartesian {
        /// Where east, north and up are 0.
        origin: LonLat,
    },
    /// No projection: `local_x` and `local_y` are the coordinates.
    Local,
}

/// Its type with what it needs to know: `MGRS 54SUE`.
impl std::fmt::Display for Projector {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())?;
        // A millimetre is enough to read; adding 0 turns -0 into 0.
        let degrees = |degrees: f64| (degrees * 1e8).round() / 1e8 + 0.0;
        match *self {
            Self::Mgrs(grid) => write!(f, " {grid}"),
            Self::Local => Ok(()),
            Self::TransverseMercator { origin, scale_factor } => {
                write!(f, ", origin {:.8}, {:.8}, scale {scale_factor}", degrees(origin.lat), degrees(origin.lon))
            }
            Self::LocalCartesianUtm { origin } | Self::LocalCartesian { origin } => {
                write!(f, ", origin {:.8}, {:.8}", degrees(origin.lat), degrees(origin.lon))
            }
        }
    }
}

/// How far a built map reaches beyond the nodes of its input, metres.
const EXTENT_MARGIN: f64 = 100.0;

/// Length of one degree of a meridian where it is shortest, metres.
const METRES_PER_DEGREE: f64 = 110_574.0;

/// Decimals of the origin that [`Projector::for_extent`] chooses: 1e-4 degrees is 11 m, enough for a name to read.
const ORIGIN_STEPS_PER_DEGREE: f64 = 1e4;

impl Projector {
    /// MGRS with the way back through this 100 km square.
    pub const fn mgrs(grid: MgrsGrid) -> Self {
        Self::Mgrs(grid)
    }

    /// A transverse Mercator with Autoware's default scale.
    pub const fn transverse_mercator(origin: LonLat) -> Self {
        Self::TransverseMercator { origin, scale_factor: DEFAULT_SCALE_FACTOR }
    }

    /// For a new map: MGRS where the box, with a margin of 100 m, fits one 100 km square, else a transverse Mercator with
    /// its origin in the middle of the box.
    pub fn for_extent(extent: &Extent) -> Self {
        let center = extent.center();
        let (lat, cos) = (EXTENT_MARGIN / METRES_PER_DEGREE, center.lat.to_radians().cos().max(0.01));
        let lon = lat / cos;
        // Parallels bend in the plane, so the middles of the sides are looked at too.
        let lons = [extent.min.lon - lon, center.lon, on_earth(extent.max.lon + lon)];
        let lats = [extent.min.lat - lat, center.lat, extent.max.lat + lat];
        let places: Vec<LonLat> = lons.iter().flat_map(|&lon| lats.map(|lat| LonLat { lon, lat })).collect();
        let squares: Vec<Option<MgrsGrid>> = Self::squares(&places);
        match MgrsGrid::of(center) {
            // A square that two latitude bands share has two names, and Autoware warns of each point whose name is another.
            Some(grid) if squares.iter().all(|square| *square == Some(grid)) => Self::Mgrs(grid),
            _ => Self::around(extent),
        }
    }

    /// A transverse Mercator with its origin in the middle of the box.
    pub fn around(extent: &Extent) -> Self {
        let center = extent.center();
        // Adding 0 turns -0 into 0.
        let round = |degrees: f64| (degrees * ORIGIN_STEPS_PER_DEGREE).round() / ORIGIN_STEPS_PER_DEGREE + 0.0;
        Self::transverse_mercator(LonLat { lon: round(center.lon), lat: round(center.lat) })
    }

    /// The value of `projector_type`.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Mgrs(_) => "MGRS",
            Self::LocalCartesianUtm { .. } => "LocalCartesianUTM",
            Self::TransverseMercator { .. } => "TransverseMercator",
            Self::LocalCartesian { .. } => "LocalCartesian",
            Self::Local => "Local",
        }
    }

    /// East and north of a place at ellipsoidal height `ele` (metres); `None` where the projection does not reach, and
    /// always for [`Projector::Local`].
    pub fn forward(&self, place: LonLat, ele: f64) -> Option<Point> {
        self.forward_each(&[place], |_| ele).pop().flatten()
    }

    /// East and north of many places at height 0, in order. A place the projection does not reach comes to lie at the
    /// origin, as in Autoware's loader.
    pub fn forward_all(&self, places: &[LonLat]) -> Vec<Point> {
        self.forward_each(places, |_| 0.0).into_iter().map(Option::unwrap_or_default).collect()
    }

    /// As [`Projector::forward`] for many places, with the height of each by its index.
    pub fn forward_each(&self, places: &[LonLat], ele: impl Fn(usize) -> f64) -> Vec<Option<Point>> {
        match *self {
            Self::Mgrs(_) => Self::in_squares(places).into_iter().map(|p| p.map(|(p, _)| p)).collect(),
            Self::LocalCartesianUtm { origin } => {
                let frame = mgrs::zone_of(origin).map(|zone| Frame::Utm { zone });
                Self::relative(frame, origin, places)
            }
            Self::TransverseMercator { origin, scale_factor } => {
                Self::relative(Some(Frame::Mercator { meridian: origin.lon, scale_factor }), origin, places)
            }
            Self::LocalCartesian { origin } => {
                places.iter().enumerate().map(|(i, &place)| Some(enu::forward(origin, place, ele(i)))).collect()
            }
            Self::Local => vec![None; places.len()],
        }
    }

    fn relative(frame: Option<Frame>, origin: LonLat, places: &[LonLat]) -> Vec<Option<Point>> {
        let Some((frame, offset)) = frame.and_then(|f| Some((f, f.offset(origin)?))) else {
            return vec![None; places.len()];
        };
        frame.forward(places).into_iter().map(|p| p.map(|p| p - offset)).collect()
    }

    /// The place of a point in the plane, at height 0 where heights matter; `None` where there is none, and always for
    /// [`Projector::Local`].
    pub fn inverse(&self, point: Point) -> Option<LonLat> {
        self.inverse_each(&[point], |_| 0.0).pop().flatten()
    }

    /// As [`Projector::inverse`] for many points, with the ellipsoidal height of each (metres) by its index.
    pub fn inverse_each(&self, points: &[Point], ele: impl Fn(usize) -> f64) -> Vec<Option<LonLat>> {
        let planar = |frame: Option<Frame>, offset: Option<nalgebra::Vector2<f64>>| match (frame, offset) {
            (Some(frame), Some(offset)) => {
                let shifted: Vec<Point> = points.iter().map(|p| p + offset).collect();
                frame.inverse(&shifted)
            }
            _ => vec![None; points.len()],
        };
        match *self {
            Self::Mgrs(grid) => planar(Some(Frame::Utm { zone: grid.zone() }), Some(grid.corner())),
            Self::LocalCartesianUtm { origin } => {
                let frame = mgrs::zone_of(origin).map(|zone| Frame::Utm { zone });
                planar(frame, frame.and_then(|f| f.offset(origin)))
            }
            Self::TransverseMercator { origin, scale_factor } => {
                let frame = Frame::Mercator { meridian: origin.lon, scale_factor };
                planar(Some(frame), frame.offset(origin))
            }
            Self::LocalCartesian { origin } => {
                points.iter().enumerate().map(|(i, &point)| enu::inverse(origin, point, ele(i))).collect()
            }
            Self::Local => vec![None; points.len()],
        }
    }

    /// The 100 km square of each place; `None` beyond 80 degrees south and 84 degrees north.
    pub fn squares(places: &[LonLat]) -> Vec<Option<MgrsGrid>> {
        Self::in_squares(places).into_iter().map(|p| p.map(|(_, square)| square)).collect()
    }

    /// Each place in its 100 km square: metres from the square's south-western corner, and the square.
    pub fn in_squares(places: &[LonLat]) -> Vec<Option<(Point, MgrsGrid)>> {
        mgrs::utm_of(places).into_iter().map(|utm| utm.map(|u| (u.in_square(), u.square()))).collect()
    }
}

/// East and north in a zone of UTM, 1 to 60, metres; northings go below zero in the south.
pub fn utm(zone: u8, places: &[LonLat]) -> Vec<Option<Point>> {
    engine::Frame::Utm { zone }.forward(places)
}

#[cfg(test)]
mod tests {
    use super::*;

    const HERE: LonLat = LonLat { lon: 138.80395805753, lat: 35.22470252585 };

    fn projectors() -> Vec<Projector> {
        vec![
            Projector::mgrs("54SUE".parse().unwrap()),
            Projector::LocalCartesianUtm { origin: LonLat { lon: 138.8, lat: 35.2 } },
            Projector::transverse_mercator(LonLat { lon: 138.9, lat: 35.3 }),
            Projector::LocalCartesian { origin: LonLat { lon: 138.79, lat: 35.21 } },
        ]
    }

    #[test]
    fn mgrs_is_what_the_official_map_says() {
        let p = Projector::mgrs("54SUE".parse().unwrap()).forward(HERE, 100.0).unwrap();
        assert!((p - Point::new(140.383, 171.9777)).norm() < 1e-3, "{p}");
    }

    #[test]
    fn there_and_back_again_to_a_tenth_of_a_millimetre_with_eleven_decimals() {
        for projector in projectors() {
            for (x, y, ele) in [(140.383, 171.9777, 100.0), (3000.0, 9000.5, -12.0), (0.5, 0.25, 0.0)] {
                let there = Point::new(x, y);
                let place = projector.inverse_each(&[there], |_| ele)[0].unwrap();
                let written = |v: f64| format!("{v:.11}").parse::<f64>().unwrap();
                let place = LonLat { lon: written(place.lon), lat: written(place.lat) };
                let back = projector.forward(place, ele).unwrap();
                assert!((back - there).norm() < 1e-4, "{} {there} {back}", projector.name());
            }
        }
    }

    #[test]
    fn the_way_back_is_that_of_proj_to_a_tenth_of_the_last_digit_written() {
        let frames =
            [Frame::Utm { zone: 54 }, Frame::Mercator { meridian: HERE.lon, scale_factor: DEFAULT_SCALE_FACTOR }];
        for (frame, north) in frames.into_iter().flat_map(|frame| [0.0, 3_900_000.0, 8_000_000.0].map(|y| (frame, y))) {
            let spread = |i: u32, prime: u32| f64::from(i.wrapping_mul(prime) % 20_011);
            let points: Vec<Point> =
                (0..2000).map(|i| Point::new(320_000.0 + spread(i, 7919), north + spread(i, 104_729))).collect();
            for (own, proj) in frame.inverse(&points).into_iter().zip(frame.inverse_by_proj(&points)) {
                let (own, proj) = (own.unwrap(), proj.unwrap());
                assert!((own.lon - proj.lon).abs() < 1e-12 && (own.lat - proj.lat).abs() < 1e-12, "{own:?} {proj:?}");
            }
        }
    }

    #[test]
    fn origin_is_zero_and_scale_is_that_of_the_loader() {
        let origin = LonLat { lon: 8.4, lat: 49.0 };
        for projector in [
            Projector::LocalCartesianUtm { origin },
            Projector::transverse_mercator(origin),
            Projector::LocalCartesian { origin },
        ] {
            assert!(projector.forward(origin, 0.0).unwrap().coords.norm() < 1e-6);
        }
        let south = Projector::transverse_mercator(origin).forward(LonLat { lon: 8.4, lat: 48.0 }, 0.0).unwrap();
        let unscaled = Projector::TransverseMercator { origin, scale_factor: 1.0 };
        let one = unscaled.forward(LonLat { lon: 8.4, lat: 48.0 }, 0.0).unwrap();
        assert!((south.y / one.y - f64::from(0.9996_f32)).abs() < 1e-12);
    }

    #[test]
    fn utm_relative_to_an_origin_crosses_zones_and_the_equator() {
        let origin = LonLat { lon: 11.9999, lat: -0.0001 };
        let projector = Projector::LocalCartesianUtm { origin };
        let p = projector.forward(LonLat { lon: 12.0001, lat: 0.0001 }, 0.0).unwrap();
        assert!((p.x - 22.3).abs() < 0.1 && (p.y - 22.1).abs() < 0.1, "{p}");
    }

    #[test]
    fn heights_move_points_sideways_in_the_tangent_plane_only() {
        let origin = LonLat { lon: 138.8, lat: 35.2 };
        let enu = Projector::LocalCartesian { origin };
        let far = LonLat { lon: 138.9, lat: 35.2 };
        assert!(enu.forward(far, 1000.0).unwrap().x > enu.forward(far, 0.0).unwrap().x + 1.0);
        let utm = Projector::LocalCartesianUtm { origin };
        assert_eq!(utm.forward(far, 1000.0), utm.forward(far, 0.0));
    }

    #[test]
    fn extent_decides_the_projector() {
        let around = |lon: f64, lat: f64, d: f64| Extent {
            min: LonLat { lon: lon - d, lat: lat - d },
            max: LonLat { lon: lon + d, lat: lat + d },
        };
        assert!(matches!(Projector::for_extent(&around(139.3, 35.6, 0.01)), Projector::Mgrs(_)));
        // The squares 54SUE and 54SVE meet at 400 km east.
        assert!(matches!(
            Projector::for_extent(&around(139.9, 35.2, 0.01)),
            Projector::TransverseMercator { origin, .. } if origin == LonLat { lon: 139.9, lat: 35.2 }
        ));
        assert!(matches!(Projector::for_extent(&around(6.0, 50.0, 0.01)), Projector::TransverseMercator { .. }));
        // One square, but south of 40 degrees it has another name.
        assert!(matches!(Projector::for_extent(&around(116.3, 40.0, 0.01)), Projector::TransverseMercator { .. }));
        assert!(matches!(Projector::for_extent(&around(116.3, 40.1, 0.01)), Projector::Mgrs(_)));
        let empty: [LonLat; 0] = [];
        assert_eq!(Extent::of(empty), None);
    }

    #[test]
    fn a_map_over_the_antimeridian_has_its_origin_inside() {
        let [west, east] = [179.98, -179.99].map(|lon| LonLat { lon, lat: -16.8 });
        let extent = Extent::of([east, west]).unwrap();
        assert!(extent.contains(west) && extent.contains(east) && !extent.contains(LonLat { lon: 0.0, lat: -16.8 }));
        assert!((extent.center().lon - 179.995).abs() < 1e-9);
        let projector = Projector::for_extent(&extent);
        let [a, b] = [west, east].map(|place| projector.forward(place, 0.0).unwrap());
        assert!((b.x - a.x - 0.03 * 106_600.0).abs() < 10.0, "{projector:?} {a} {b}");
    }

    #[test]
    fn same_result_in_one_batch_and_one_by_one() {
        let places: Vec<LonLat> = (0..20_000).map(|i| LonLat { lon: 136.0 + f64::from(i) * 1e-3, lat: 35.0 }).collect();
        for projector in projectors() {
            let all = projector.forward_all(&places);
            for i in (0..places.len()).step_by(997) {
                assert_eq!(projector.forward(places[i], 0.0), Some(all[i]));
            }
        }
    }

    #[test]
    fn unreachable_places_are_none() {
        let pole = LonLat { lon: 0.0, lat: 89.0 };
        assert_eq!(Projector::mgrs("54SUE".parse().unwrap()).forward(pole, 0.0), None);
        assert_eq!(Projector::Local.forward(HERE, 0.0), None);
        assert_eq!(Projector::Local.inverse(Point::new(1.0, 2.0)), None);
        let bad = Projector::transverse_mercator(LonLat { lon: 0.0, lat: 0.0 });
        assert_eq!(bad.inverse(Point::new(f64::NAN, 0.0)), None);
    }
}
