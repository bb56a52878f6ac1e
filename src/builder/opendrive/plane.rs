//! From the metres of an OpenDRIVE file to those of the map: the file's georeference becomes the map's projector.

use crate::geometry::{Point, Vector};
use crate::projection::{Extent, LonLat, MgrsGrid, Projector, utm};
use crate::xodr::{Georeference, OpenDrive, Place};

/// How the file's metres become those of the map.
pub struct Plane {
    /// The projector of the map.
    pub projector: Projector,
    /// Whether the header's offset was subtracted: added, as the standard says, it leads off the georeference's part of the earth.
    pub offset_turned: bool,
    /// Whether the file's metres begin at the place that its georeference names beside a zone of UTM, which it should not.
    pub from_origin: bool,
    /// A turn about the file's origin, radians, ...
    turn: f64,
    /// ... after these metres are added; the third is height.
    offset: [f64; 3],
    to_map: ToMap,
}

/// From the metres of the georeference to those of the map.
enum ToMap {
    Shift(Vector),
    /// By way of longitude and latitude: the first projector, whose origin lies at these metres of the georeference, back, and the
    /// map's projector.
    Through(Projector, Vector),
}

/// A georeference whose origin lies farther from the map than this, metres, is not the map's: Autoware's places would lose digits.
const FAR: f64 = 100_000.0;
/// Half a side of the box around a file's origin that is looked at where no place is known better, degrees.
const AROUND: f64 = 1e-3;

impl Plane {
    /// The plane of a file whose reference lines lie at these places. `wanted` names the projector that the user wants, given a
    /// place in the middle; `origin` is where the file's origin lies if the file does not say.
    pub fn new(
        file: &OpenDrive,
        places: &[Point],
        origin: Option<LonLat>,
        wanted: Option<&dyn Fn(LonLat) -> Projector>,
    ) -> Self {
        let [x, y, z, turn] = file.header.offset;
        let mut plane = Self {
            projector: Projector::Local,
            offset_turned: false,
            from_origin: false,
            turn,
            offset: [x, y, z],
            to_map: ToMap::Shift(Vector::zeros()),
        };
        let origin =
            origin.map(|at| Georeference::TransverseMercator { lat: at.lat, lon: at.lon, scale: 1.0, shift: [0.0; 2] });
        let Some(georeference) = file.header.plane.georeference.or(origin) else { return plane };
        let (georeference, from_origin) = match from_origin(file, georeference, places) {
            Some(found) => (found, true),
            None => (georeference, false),
        };
        plane.from_origin = from_origin;
        let at = |plane: &Self| places.first().map_or(Point::origin(), |at| plane.turned(*at));
        let here = at(&plane);
        plane.offset = [-x, -y, z];
        // Some exporters write what they have added to the places.
        plane.offset_turned = !georeference.has(here) && georeference.has(at(&plane));
        if !plane.offset_turned {
            plane.offset = [x, y, z];
        }
        let turned: Vec<Point> = places.iter().map(|at| plane.turned(*at)).collect();
        let Some((base, shift)) = base(georeference, &turned) else { return plane };
        let corners = corners(&turned);
        let places: Vec<LonLat> =
            base.inverse_each(&corners.map(|at| at + shift), |_| 0.0).into_iter().flatten().collect();
        let Some(extent) = Extent::of(places.iter().copied()) else { return plane };
        let middle = extent.center();
        let (projector, to_map) = match (wanted, georeference) {
            (Some(wanted), _) => {
                let projector = wanted(middle);
                let same = projector == base;
                (projector, if same { ToMap::Shift(shift) } else { ToMap::Through(base, shift) })
            }
            (None, Georeference::TransverseMercator { .. })
                if corners.iter().any(|at| (at + shift).coords.norm() < FAR) =>
            {
                (base, ToMap::Shift(shift))
            }
            (None, _) => match Projector::for_extent(&extent) {
                Projector::Mgrs(grid) if matches!(georeference, Georeference::Utm { zone, .. } if zone == grid.zone()) => {
                    (Projector::Mgrs(grid), ToMap::Shift(in_square(&base, shift, &grid)))
                }
                other => (other, ToMap::Through(base, shift)),
            },
        };
        plane.projector = projector;
        plane.to_map = to_map;
        plane
    }

    fn turned(&self, at: Point) -> Point {
        let (sin, cos) = self.turn.sin_cos();
        let [x, y, _] = self.offset;
        let at = at + Vector::new(x, y);
        Point::new(cos * at.x - sin * at.y, sin * at.x + cos * at.y)
    }

    /// The places and heights in the map of places of the file.
    pub fn to_map(&self, places: &[Place]) -> Vec<(Point, f64)> {
        let turned = places.iter().map(|[x, y, _]| self.turned(Point::new(*x, *y)));
        let plane: Vec<Point> = match &self.to_map {
            ToMap::Shift(shift) => turned.map(|at| at + shift).collect(),
            ToMap::Through(base, shift) => {
                let at: Vec<Point> = turned.map(|at| at + shift).collect();
                let on_earth = base.inverse_each(&at, |_| 0.0);
                let on_earth: Vec<LonLat> = on_earth.into_iter().map(Option::unwrap_or_default).collect();
                self.projector.forward_all(&on_earth)
            }
        };
        plane.into_iter().zip(places).map(|(at, [.., z])| (at, z + self.offset[2])).collect()
    }

    /// The direction in the map of a direction in the file, radians.
    pub fn angle(&self, angle: f64) -> f64 {
        angle + self.turn
    }
}

/// The georeference of a file that names a place beside its zone of UTM, if its metres begin there: as they stand, they lie far from it.
fn from_origin(file: &OpenDrive, georeference: Georeference, places: &[Point]) -> Option<Georeference> {
    /// Metres from an origin lie no farther than this, and metres of UTM no nearer to it, if they are not its own.
    const METRES_FROM_ORIGIN: f64 = 1_000_000.0;
    /// Such places are corners of MGRS squares, of so many metres, which tools find this well.
    const SQUARE: f64 = 100_000.0;
    const FOUND: f64 = 1.0;
    /// Half the breadth of a zone, degrees, with what reaches over.
    const HALF_ZONE: f64 = 3.5;
    let (Georeference::Utm { zone, added: [east, north] }, Some([lat, lon])) =
        (georeference, file.header.plane.beside_zone)
    else {
        return None;
    };
    // One elsewhere has been left by whoever made the georeference from another.
    let of_zone = (lon - (f64::from(zone) * 6.0 - 183.0)).abs() <= HALF_ZONE;
    let known = utm(zone, &[LonLat { lon, lat }]).pop().flatten().filter(|_| of_zone)?;
    let corner = known.map(|it| (it / SQUARE).round() * SQUARE);
    let known = if (known - corner).norm() <= FOUND { corner } else { known };
    let [x, y, ..] = file.header.offset;
    let here = *places.first()? + Vector::new(x, y);
    let apart = (here - known).norm() > METRES_FROM_ORIGIN && here.coords.norm() < METRES_FROM_ORIGIN;
    apart.then_some(Georeference::Utm { zone, added: [east - known.x, north - known.y] })
}

/// A projector for the metres of a georeference, and what is added to them to be those of the projector.
fn base(georeference: Georeference, places: &[Point]) -> Option<(Projector, Vector)> {
    match georeference {
        Georeference::TransverseMercator { lat, lon, scale, shift: [x, y] } => {
            let origin = LonLat { lon, lat };
            Some((Projector::TransverseMercator { origin, scale_factor: scale as f32 }, Vector::new(-x, -y)))
        }
        Georeference::Utm { zone, added: [east, north] } => {
            // An origin on the equator where the zone's middle is: 500 km east there.
            let middle = LonLat { lon: f64::from(zone) * 6.0 - 183.0, lat: 0.0 };
            let first = Projector::LocalCartesianUtm { origin: middle };
            let at = corners(places).into_iter().next()? - Vector::new(500_000.0 + east, north);
            first.inverse(at)?;
            let known = utm(zone, &[middle]).pop().flatten()?;
            Some((first, Vector::new(-known.x - east, -known.y - north)))
        }
    }
}

/// What is added to the metres of a georeference to be metres in a square of MGRS; the base projector's own origin is left out.
fn in_square(base: &Projector, shift: Vector, grid: &MgrsGrid) -> Vector {
    let origin = match base {
        Projector::LocalCartesianUtm { origin } => utm(grid.zone(), &[*origin]).pop().flatten(),
        _ => None,
    };
    shift + origin.map_or_else(Vector::zeros, |origin| origin.coords) - grid.corner()
}

/// The corners of the box around places.
fn corners(places: &[Point]) -> [Point; 4] {
    let first = places.first().copied().unwrap_or(Point::origin());
    let widen = |[low, high]: [Point; 2], at: &Point| {
        [Point::new(low.x.min(at.x), low.y.min(at.y)), Point::new(high.x.max(at.x), high.y.max(at.y))]
    };
    let [low, high] = places.iter().fold([first, first + Vector::new(AROUND, AROUND)], widen);
    [low, Point::new(high.x, low.y), high, Point::new(low.x, high.y)]
}
