//! Where on earth a file lies: the words of its `geoReference` as far as maps need them.

use crate::geometry::Point;

/// The plane of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Georeference {
    /// A transverse Mercator: origin (degrees), scale, and what is added there (metres).
    TransverseMercator {
        /// Degrees.
        lat: f64,
        /// Degrees.
        lon: f64,
        /// Scale on the central meridian.
        scale: f64,
        /// False easting and northing, metres.
        shift: [f64; 2],
    },
    /// A zone of UTM, 1 to 60.
    Utm {
        /// 1 to 60.
        zone: u8,
        /// What is added to eastings and to northings from the equator, metres.
        added: [f64; 2],
    },
}

/// What a file says of its plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Plane {
    /// Its plane, if it is known.
    pub georeference: Option<Georeference>,
    /// Latitude and longitude beside a zone of UTM, degrees: they mean nothing there, unless a tool has taken them for its origin.
    pub beside_zone: Option<[f64; 2]>,
    /// Whether heights are above a geoid.
    pub on_geoid: bool,
    /// What was guessed, or why the words are of no use, one sentence.
    pub note: Option<String>,
}

/// The scale of UTM on its central meridians, ...
const UTM_SCALE: f64 = 0.9996;
/// ... and what it adds, metres: to eastings, and to northings in the south.
const UTM_EAST: f64 = 500_000.0;
const UTM_SOUTH: f64 = 10_000_000.0;

/// Places farther than this from the origin of a transverse Mercator, metres, are not its own.
const FARTHEST: f64 = 5_000_000.0;

/// Reads the words of a `geoReference`.
pub fn georeference(words: &str) -> Plane {
    let mut plane = Plane { on_geoid: words.contains("+geoidgrids"), ..Plane::default() };
    let words = words.trim();
    if words.is_empty() {
        return plane;
    }
    if let Some(code) = epsg(words) {
        plane.georeference = utm_of(code);
        if plane.georeference.is_none() {
            plane.note =
                Some(format!("the georeference EPSG:{code} is not one of UTM, so the map has no place on earth"));
        }
        return plane;
    }
    let value = |key: &str| {
        let part =
            words.split_whitespace().find_map(|part| part.strip_prefix('+')?.split_once('=').filter(|p| p.0 == key));
        part.map(|(_, value)| value)
    };
    let number = |key: &str| value(key).and_then(|value| value.parse::<f64>().ok()).filter(|number| number.is_finite());
    let has = |key: &str| words.split_whitespace().any(|part| part == key);
    let mercator = || {
        let (lat, lon) = (number("lat_0").unwrap_or(0.0), number("lon_0")?);
        let scale = number("k").or_else(|| number("k_0")).unwrap_or(1.0);
        let shift = [number("x_0").unwrap_or(0.0), number("y_0").unwrap_or(0.0)];
        let on_earth = (-90.0..=90.0).contains(&lat) && (-180.0..=180.0).contains(&lon) && scale > 0.0;
        // A survey often names the zone of UTM in this way.
        let zone = (lon + 183.0) / 6.0;
        let is_utm =
            lat == 0.0 && (scale - UTM_SCALE).abs() < 1e-9 && zone.fract() == 0.0 && (1.0..=60.0).contains(&zone);
        let found = match is_utm {
            true => Georeference::Utm { zone: zone as u8, added: [shift[0] - UTM_EAST, shift[1]] },
            false => Georeference::TransverseMercator { lat, lon, scale, shift },
        };
        on_earth.then_some(found)
    };
    match value("proj") {
        Some("tmerc" | "etmerc") => plane.georeference = mercator(),
        Some("utm") => {
            let zone = number("zone").filter(|zone| (1.0..=60.0).contains(zone)).map(|zone| zone as u8);
            let guessed = number("lon_0").map(|lon| (((lon + 180.0) / 6.0).floor().rem_euclid(60.0)) as u8 + 1);
            if zone.is_none() {
                plane.note =
                    guessed.map(|zone| format!("the georeference is UTM without a zone: zone {zone} by its lon_0"));
            }
            let utm = |zone| utm(zone, has("+south"));
            plane.georeference = zone.or(guessed).map(utm);
            plane.beside_zone = zone.and(number("lat_0").zip(number("lon_0"))).map(|(lat, lon)| [lat, lon]);
        }
        None if number("lat_0").is_some() => {
            plane.georeference = mercator();
            plane.note =
                Some("the georeference names no projection: a transverse Mercator at its lat_0 and lon_0".into());
        }
        _ => {}
    }
    if plane.georeference.is_none() {
        let shown: String = words.chars().take(80).collect();
        plane.note =
            Some(format!("the georeference `{shown}` is none of tmerc and UTM, so the map has no place on earth"));
    }
    plane
}

fn epsg(words: &str) -> Option<u32> {
    let lower = words.to_ascii_lowercase();
    let code = lower.strip_prefix("epsg:").or_else(|| lower.split("+init=epsg:").nth(1))?;
    code.split_whitespace().next()?.parse().ok()
}

/// The zones of UTM on WGS 84 and ETRS89.
fn utm_of(code: u32) -> Option<Georeference> {
    let utm = |zone: u32, south| utm(zone as u8, south);
    match code {
        32601..=32660 => Some(utm(code - 32600, false)),
        32701..=32760 => Some(utm(code - 32700, true)),
        25828..=25838 => Some(utm(code - 25800, false)),
        _ => None,
    }
}

fn utm(zone: u8, south: bool) -> Georeference {
    Georeference::Utm { zone, added: [0.0, if south { UTM_SOUTH } else { 0.0 }] }
}

impl Georeference {
    /// Whether metres of it lie on the part of the earth that it is for: near its origin, or in its zone.
    pub fn has(&self, at: Point) -> bool {
        match *self {
            Self::TransverseMercator { shift: [x, y], .. } => (at.x - x).hypot(at.y - y) < FARTHEST,
            Self::Utm { added: [east, north], .. } => {
                let of_south = north > UTM_SOUTH / 2.0;
                let [east, north] = [at.x - UTM_EAST - east, at.y - north];
                east.abs() < UTM_EAST && north.abs() < UTM_SOUTH && (north < 0.0) == of_south
            }
        }
    }

    /// The scale on the central meridian.
    pub fn scale(&self) -> f64 {
        match self {
            Self::TransverseMercator { scale, .. } => *scale,
            Self::Utm { .. } => UTM_SCALE,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_of_real_files() {
        let tmerc = "+proj=tmerc +lat_0=37.4 +lon_0=-122.1 +k=1 +x_0=5 +y_0=0 +datum=WGS84 +geoidgrids=egm96_15.gtx";
        let plane = georeference(tmerc);
        let expected = Georeference::TransverseMercator { lat: 37.4, lon: -122.1, scale: 1.0, shift: [5.0, 0.0] };
        assert_eq!((plane.georeference, plane.on_geoid, plane.note), (Some(expected), true, None));
        assert_eq!(georeference("epsg:25833").georeference, Some(utm(33, false)));
        let zone = georeference("+proj=utm +zone=32 +ellps=GRS80 +units=m +no_defs");
        assert_eq!(zone.georeference, Some(utm(32, false)));
    }

    #[test]
    fn a_zone_of_utm_by_other_words_is_one() {
        let zone = georeference("+proj=tmerc +lat_0=0 +lon_0=9 +k=0.9996 +x_0=-174000 +y_0=-5405000 +datum=WGS84");
        assert_eq!(zone.georeference, Some(Georeference::Utm { zone: 32, added: [-674_000.0, -5_405_000.0] }));
        let other = georeference("+proj=tmerc +lat_0=0 +lon_0=10 +k=0.9996");
        assert!(matches!(other.georeference, Some(Georeference::TransverseMercator { .. })));
    }

    #[test]
    fn a_zone_has_places_of_its_own_half_of_the_earth() {
        let (north, south) = (utm(16, false), utm(16, true));
        assert!(north.has(Point::new(667_000.0, 3_878_000.0)) && !north.has(Point::new(-667_000.0, -3_878_000.0)));
        assert!(south.has(Point::new(667_000.0, 6_122_000.0)) && !south.has(Point::new(667_000.0, 13_878_000.0)));
    }

    #[test]
    fn what_is_guessed_is_told() {
        let carla = georeference("+lat_0=4.9000000000000000e+1 +lon_0=8.0e+0");
        assert!(matches!(carla.georeference, Some(Georeference::TransverseMercator { lat: 49.0, lon: 8.0, .. })));
        assert!(carla.note.is_some());
        let zoneless = georeference("+proj=utm +lat_0=37.35 +lon_0=-122.08 +k_0=1");
        assert_eq!(zoneless.georeference, Some(utm(10, false)));
        assert!(zoneless.note.is_some());
        for useless in ["+proj=merc +lon_0=3", "epsg:4326", "nonsense"] {
            let plane = georeference(useless);
            assert!(plane.georeference.is_none() && plane.note.is_some(), "{useless}");
        }
        assert_eq!(georeference("  "), Plane::default());
    }
}
