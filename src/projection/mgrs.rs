//! The 100 km squares of the Military Grid Reference System, as Autoware names them (`54SUE`), and their UTM zones.

use crate::geometry::{Point, Vector};

use super::LonLat;
use super::engine::Frame;

use std::fmt;
use std::str::FromStr;

/// Side of a square, metres.
pub(super) const SQUARE: f64 = 100_000.0;
/// Rows repeat after this many squares.
const ROWS: i16 = 20;
/// Latitude bands of 8 degrees from 80 degrees south; the last one has 12.
const BANDS: &[u8] = b"CDEFGHJKLMNPQRSTUVWX";
/// Letters of the columns, eight for each of three consecutive zones.
const COLUMNS: [&[u8]; 3] = [b"STUVWXYZ", b"ABCDEFGH", b"JKLMNPQR"];
/// Letters of the rows.
const ROW_LETTERS: &[u8] = b"ABCDEFGHJKLMNPQRSTUV";
/// Mean length of one degree of a meridian in UTM, metres; only to find the right one of the repeating rows.
const METRES_PER_DEGREE: f64 = 110_900.0;

/// A 100 km square.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct MgrsGrid {
    zone: u8,
    band: u8,
    column: u8,
    row: i16,
}

/// Why a text is not the name of a square.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{0}` is not an MGRS 100 km square; expected zone, band and two letters such as 54SUE")]
pub struct MgrsError(pub String);

impl MgrsGrid {
    /// The square of a place; `None` beyond 80 degrees south and 84 degrees north.
    pub fn of(place: LonLat) -> Option<Self> {
        utm_of(&[place]).pop().flatten().map(|utm| utm.square())
    }

    /// The UTM zone, 1..=60.
    pub const fn zone(&self) -> u8 {
        self.zone
    }

    /// UTM easting and northing of its south-western corner, metres; northings go below zero in the south.
    pub fn corner(&self) -> Vector {
        Vector::new(f64::from(self.column) * SQUARE, f64::from(self.row) * SQUARE)
    }

    /// Whether both name the same square; a square that two latitude bands share has two names.
    pub fn same_square(&self, other: &Self) -> bool {
        (self.zone, self.column, self.row) == (other.zone, other.column, other.row)
    }
}

impl fmt::Display for MgrsGrid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let letter = |letters: &[u8], at: usize| char::from(letters.get(at).copied().unwrap_or(b'?'));
        let row = (self.row + row_shift(self.zone)).rem_euclid(ROWS) as usize;
        let column = letter(columns(self.zone), usize::from(self.column).wrapping_sub(1));
        let band = letter(BANDS, usize::from(self.band));
        write!(f, "{}{band}{column}{}", self.zone, letter(ROW_LETTERS, row))
    }
}

impl FromStr for MgrsGrid {
    type Err = MgrsError;

    fn from_str(name: &str) -> Result<Self, MgrsError> {
        parse(name).ok_or_else(|| MgrsError(name.to_owned()))
    }
}

fn parse(name: &str) -> Option<MgrsGrid> {
    let digits = name.bytes().take_while(u8::is_ascii_digit).count();
    let (number, letters) = name.split_at_checked(digits)?;
    let zone: u8 = number.parse().ok().filter(|z| (1..=60).contains(z))?;
    let &[band, column, row] = letters.as_bytes() else { return None };
    let find = |letters: &[u8], letter: u8| letters.iter().position(|l| *l == letter);
    let band = find(BANDS, band)?;
    let column = find(columns(zone), column)? as u8 + 1;
    let row = find(ROW_LETTERS, row)? as i16 - row_shift(zone);
    // Of the rows with this letter, the one nearest to the middle of the band; a band is less than half a cycle high.
    let half_height = if band + 1 == BANDS.len() { 6.0 } else { 4.0 };
    let middle = (-80.0 + 8.0 * band as f64 + half_height) * METRES_PER_DEGREE / SQUARE;
    let cycles = ((middle - f64::from(row) - 0.5) / f64::from(ROWS)).round() as i16;
    Some(MgrsGrid { zone, band: band as u8, column, row: row + cycles * ROWS })
}

fn columns(zone: u8) -> &'static [u8] {
    COLUMNS[usize::from(zone % 3)]
}

/// Rows of even zones begin five letters later.
fn row_shift(zone: u8) -> i16 {
    if zone.is_multiple_of(2) { 5 } else { 0 }
}

/// A place in its own UTM zone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Utm {
    zone: u8,
    band: u8,
    at: Point,
}

impl Utm {
    /// Easting and northing modulo 100 km.
    pub(super) fn in_square(&self) -> Point {
        // False northing of the south is a multiple of 100 km, so it makes no difference here.
        Point::new(self.at.x.rem_euclid(SQUARE), self.at.y.rem_euclid(SQUARE))
    }

    /// The square it lies in.
    pub(super) fn square(&self) -> MgrsGrid {
        let (column, row) = ((self.at.x / SQUARE).floor(), (self.at.y / SQUARE).floor());
        MgrsGrid { zone: self.zone, band: self.band, column: column as u8, row: row as i16 }
    }
}

/// Index of the latitude band.
fn band_of(lat: f64) -> Option<u8> {
    (-80.0..84.0).contains(&lat).then(|| (((lat + 80.0) / 8.0).floor() as u8).min(BANDS.len() as u8 - 1))
}

/// Each place in its own zone; `None` beyond 80 degrees south and 84 degrees north.
pub(crate) fn utm_of(places: &[LonLat]) -> Vec<Option<Utm>> {
    let zones: Vec<Option<u8>> = places.iter().map(|&p| zone_of(p)).collect();
    let mut utm = vec![None; places.len()];
    let mut left = zones.clone();
    while let Some(zone) = left.iter().flatten().next().copied() {
        let of_zone: Vec<usize> = (0..places.len()).filter(|&i| zones[i] == Some(zone)).collect();
        let chosen: Vec<LonLat> = of_zone.iter().map(|&i| places[i]).collect();
        for (&i, at) in of_zone.iter().zip(Frame::Utm { zone }.forward(&chosen)) {
            utm[i] = at.zip(band_of(places[i].lat)).map(|(at, band)| Utm { zone, band, at });
            left[i] = None;
        }
    }
    utm
}

/// The UTM zone, with the exceptions of Norway and Svalbard; `None` beyond 80 degrees south and 84 degrees north.
pub(crate) fn zone_of(place: LonLat) -> Option<u8> {
    const NORWAY: usize = 17;
    const SVALBARD: usize = 19;
    let band = usize::from(band_of(place.lat)?);
    let lon = place.lon.floor().rem_euclid(360.0) as i32;
    let lon = if lon >= 180 { lon - 360 } else { lon };
    let zone = (lon + 186) / 6;
    let zone = match band {
        NORWAY if zone == 31 && lon >= 3 => 32,
        SVALBARD if (0..42).contains(&lon) => 2 * ((lon + 183) / 12) + 1,
        _ => zone,
    };
    u8::try_from(zone).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_of_known_places() {
        for (lon, lat, name) in [
            (138.80395805753, 35.22470252585, "54SUE"), // Fuji speedway
            (139.7454, 35.6586, "54SUE"),               // Tokyo tower
            (8.4243, 49.0035, "32UMV"),                 // Karlsruhe
            (151.2153, -33.8568, "56HLH"),              // Sydney opera
            (-74.0445, 40.6892, "18TWL"),               // Statue of Liberty
            (5.3221, 60.3913, "32VKN"),                 // Bergen: zone 32 in spite of its longitude
            (15.6356, 78.2232, "33XWG"),                // Longyearbyen
            (18.4241, -33.9249, "34HBH"),               // Cape Town
            (103.8198, 1.3521, "48NUG"),                // Singapore
        ] {
            let grid = MgrsGrid::of(LonLat { lon, lat }).unwrap();
            assert_eq!(grid.to_string(), name);
            assert_eq!(name.parse::<MgrsGrid>().unwrap(), grid);
        }
    }

    #[test]
    fn every_square_reads_as_it_is_written() {
        for zone in 0..60 {
            for step in 0..164 {
                let place = LonLat { lon: -177.0 + 6.0 * f64::from(zone) + 0.7, lat: -79.9 + f64::from(step) };
                let grid = MgrsGrid::of(place).unwrap();
                assert_eq!(grid.to_string().parse::<MgrsGrid>().unwrap(), grid, "{place:?}");
            }
        }
    }

    #[test]
    fn other_words_are_refused() {
        for word in
            ["", "54", "54SU", "54SUEE", "61SUE", "0SUE", "54IUE", "54SAE", "54SUW", "54sue", "99XXX", "５４SUE"]
        {
            assert_eq!(word.parse::<MgrsGrid>(), Err(MgrsError(word.to_owned())));
        }
    }

    #[test]
    fn zones_at_their_borders() {
        for (lon, lat, zone) in [(-180.0, 0.0, 1), (180.0, 0.0, 1), (179.99, 0.0, 60), (6.0, 0.0, 32), (5.999, 0.0, 31)]
        {
            assert_eq!(zone_of(LonLat { lon, lat }), Some(zone));
        }
        assert_eq!(zone_of(LonLat { lon: 0.0, lat: 84.0 }), None);
        assert_eq!(zone_of(LonLat { lon: f64::NAN, lat: f64::NAN }), None);
    }
}
