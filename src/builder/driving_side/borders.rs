//! The countries at a place, by the borders that come with the crate `country_boundaries`.
//!
//! The crate makes lists of the borders of all the world before it answers, which takes longer than to read a small map.
//! Here, all but the one cell of the raster that holds the place is passed over.

use country_boundaries::BOUNDARIES_ODBL_360X180;

use crate::projection::LonLat;

/// The version of the format that is read here.
const VERSION: u64 = 2;
/// The last of the steps from one side of a cell to the other.
const LAST_STEP: f64 = 65535.0;

/// The ISO 3166 codes of the countries at a place, and of their parts, the smallest area first.
pub fn ids(place: LonLat) -> Vec<&'static str> {
    let on_earth = (-90.0..=90.0).contains(&place.lat) && (-180.0..=180.0).contains(&place.lon);
    on_earth.then(|| read(Reader(BOUNDARIES_ODBL_360X180), place)).flatten().unwrap_or_default()
}

fn read(mut file: Reader, LonLat { lon, lat }: LonLat) -> Option<Vec<&'static str>> {
    if file.number::<2>()? != VERSION {
        return None;
    }
    let sizes: Option<Vec<_>> =
        (0..file.number::<4>()?).map(|_| Some((file.text()?, f64::from_bits(file.number::<8>()?)))).collect();
    let (sizes, columns, cells) = (sizes?, file.number::<4>()?, file.number::<4>()?);
    let (width, height) = (columns as f64, cells.checked_div(columns)? as f64);
    // The eastern end of the raster is its western one.
    let lon = if lon == 180.0 { -180.0 } else { lon };
    let column = ((width * (180.0 + lon) / 360.0).floor() as u64).min(columns - 1);
    let row = ((height * (90.0 - lat) / 180.0).ceil() as u64).saturating_sub(1);
    let (west, south) = (-180.0 + 360.0 * column as f64 / width, 90.0 - 180.0 * (row as f64 + 1.0) / height);
    let steps = |degrees: f64| (degrees * LAST_STEP) as u16;
    let at = [steps((lon - west) * width / 360.0), steps((lat - south) * height / 180.0)].map(i64::from);
    for _ in 0..row * columns + column {
        file.skip_cell()?;
    }
    let mut ids = file.ids_in_cell(at)?;
    let size = |id: &str| sizes.iter().find(|(of, _)| *of == id).map_or(0.0, |(_, size)| *size);
    ids.sort_by(|a, b| size(a).total_cmp(&size(b)));
    Some(ids)
}

/// What is left of the file, whose numbers stand the most significant byte first.
struct Reader(&'static [u8]);

impl Reader {
    fn bytes(&mut self, count: usize) -> Option<&'static [u8]> {
        let (taken, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(taken)
    }

    fn number<const BYTES: usize>(&mut self) -> Option<u64> {
        Some(self.bytes(BYTES)?.iter().fold(0, |number, byte| number << 8 | u64::from(*byte)))
    }

    fn text(&mut self) -> Option<&'static str> {
        let length = self.number::<2>()? as usize;
        std::str::from_utf8(self.bytes(length)?).ok()
    }

    /// The corners of a ring, each in steps to the east and to the north.
    fn ring(&mut self) -> Option<&'static [u8]> {
        let corners = self.number::<4>()? as usize;
        self.bytes(4 * corners)
    }

    /// Passes over a cell: the areas that hold it whole, and those with a border in it.
    fn skip_cell(&mut self) -> Option<()> {
        for _ in 0..self.number::<1>()? {
            let length = self.number::<2>()? as usize;
            self.bytes(length)?;
        }
        for _ in 0..self.number::<1>()? {
            let length = self.number::<2>()? as usize;
            self.bytes(length)?;
            for _ in 0..2 {
                for _ in 0..self.number::<1>()? {
                    self.ring()?;
                }
            }
        }
        Some(())
    }

    /// The areas of a cell that hold a place of it: first those that do not hold all of the cell.
    fn ids_in_cell(&mut self, at: [i64; 2]) -> Option<Vec<&'static str>> {
        let whole: Option<Vec<&str>> = (0..self.number::<1>()?).map(|_| self.text()).collect();
        let (whole, mut ids) = (whole?, Vec::new());
        for _ in 0..self.number::<1>()? {
            let id = self.text()?;
            let mut around = 0;
            // Outer rings, and those of holes.
            for one in [1, -1] {
                for _ in 0..self.number::<1>()? {
                    around += if winds_around(self.ring()?, at) { one } else { 0 };
                }
            }
            ids.extend((around > 0).then_some(id));
        }
        ids.extend(whole);
        Some(ids)
    }
}

/// Whether a ring goes around a place: it does so as often as it passes north of it in one direction more than in the other.
fn winds_around(ring: &[u8], [x, y]: [i64; 2]) -> bool {
    let corner = |bytes: &[u8]| [0, 2].map(|i| i64::from(bytes[i]) << 8 | i64::from(bytes[i + 1]));
    let corners = || ring.chunks_exact(4).map(corner);
    let Some(mut before) = corners().next_back() else { return false };
    let mut turns = 0;
    for behind in corners() {
        let ([ax, ay], [bx, by]) = (before, behind);
        let left = (bx - ax) * (y - ay) - (x - ax) * (by - ay);
        turns += match (ay <= y, by <= y) {
            (true, false) if left > 0 => 1,
            (false, true) if left < 0 => -1,
            _ => 0,
        };
        before = behind;
    }
    turns != 0
}

#[cfg(test)]
mod tests {
    use country_boundaries::{CountryBoundaries, LatLon};

    use super::*;

    #[test]
    fn says_what_the_crate_says() {
        let known = CountryBoundaries::from_reader(BOUNDARIES_ODBL_360X180).unwrap();
        let somewhere = (0..500)
            .map(|i| LonLat { lon: f64::from(i * 7919 % 3607) / 10.0 - 180.0, lat: f64::from(i * 31 % 179) - 89.3 });
        let borders =
            [(-180.0, 66.0), (180.0, 66.5), (6.02, 50.77), (7.0, 50.0), (32.9, 35.0), (0.0, 90.0), (0.0, -90.0)];
        let borders = borders.map(|(lon, lat)| LonLat { lon, lat });
        for place in somewhere.chain(borders) {
            assert_eq!(ids(place), known.ids(LatLon::new(place.lat, place.lon).unwrap()), "{place:?}");
        }
    }
}
