//! The country of a place and its driving side.

use std::sync::LazyLock;

use country_boundaries::{BOUNDARIES_ODBL_60X30, CountryBoundaries, LatLon};

use crate::osm::Text;
use crate::projection::LonLat;

use super::road_class::DrivingSide;

/// ISO 3166 codes of countries and territories that drive on the left, ascending.
const LEFT: [&str; 76] = [
    "AG", "AI", "AU", "BB", "BD", "BM", "BN", "BS", "BT", "BW", "CC", "CK", "CX", "CY", "DM", "FJ", "FK", "GB", "GD",
    "GG", "GS", "GY", "HK", "ID", "IE", "IM", "IN", "JE", "JM", "JP", "KE", "KI", "KN", "KY", "LC", "LK", "LS", "MO",
    "MS", "MT", "MU", "MV", "MW", "MY", "MZ", "NA", "NF", "NP", "NR", "NU", "NZ", "PG", "PK", "PN", "SB", "SC", "SG",
    "SH", "SR", "SZ", "TC", "TH", "TK", "TL", "TO", "TT", "TV", "TZ", "UG", "VC", "VG", "VI", "WS", "ZA", "ZM", "ZW",
];

/// Territories that drive on the right in a country that drives on the left: Gibraltar, British Indian Ocean Territory.
const RIGHT_PARTS: [&str; 2] = ["GI", "IO"];

/// The country of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Country {
    /// ISO 3166-1 alpha-2 code; `None` at sea.
    pub country: Option<Text>,
    /// The driving side; right if the country is unknown.
    pub side: DrivingSide,
}

/// Unpacked once. Its borders are accurate to ten metres. Data in smaller cells answer faster, but take several times as long to
/// unpack and megabytes of memory, and a map asks once.
static BOUNDARIES: LazyLock<Option<CountryBoundaries>> =
    LazyLock::new(|| CountryBoundaries::from_reader(BOUNDARIES_ODBL_60X30).ok());

/// Unpacks the borders, so that the first query is fast.
pub fn warm_up() {
    LazyLock::force(&BOUNDARIES);
}

/// The country of `place` and its driving side.
pub fn of_place(place: LonLat) -> Country {
    let ids: Vec<Text> = match (&*BOUNDARIES, LatLon::new(place.lat, place.lon)) {
        (Some(boundaries), Ok(position)) => boundaries.ids(position).into_iter().map(Text::from).collect(),
        _ => Vec::new(),
    };
    let side = side_of(ids.iter().map(Text::as_str));
    // The smallest area comes first. A subdivision such as `US-VI` begins with the code of its country.
    let country = ids.iter().find(|id| !id.contains('-')).cloned();
    let country = country.or_else(|| ids.first().and_then(|id| id.split('-').next()).map(Text::from));
    Country { country, side }
}

/// The driving side of a place with these ISO 3166 codes, of a country or of its parts.
pub fn side_of<'a>(ids: impl IntoIterator<Item = &'a str>) -> DrivingSide {
    let left = |id: &str| LEFT.binary_search(&id).is_ok();
    let on_left = |id: &str| match id.split_once('-') {
        // Territories of countries that drive on the right.
        Some(("US" | "CN", part @ ("VI" | "HK" | "MO"))) => left(part),
        Some((country, _)) => left(country),
        None => left(id),
    };
    let mut side = DrivingSide::Right;
    for id in ids {
        if RIGHT_PARTS.contains(&id) {
            return DrivingSide::Right;
        }
        if on_left(id) {
            side = DrivingSide::Left;
        }
    }
    side
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(lat: f64, lon: f64) -> (Option<String>, DrivingSide) {
        let place = of_place(LonLat { lon, lat });
        (place.country.map(|c| c.to_string()), place.side)
    }

    #[test]
    fn the_table_is_sorted() {
        assert!(LEFT.is_sorted());
    }

    #[test]
    fn places_on_either_side() {
        let (left, right) = (DrivingSide::Left, DrivingSide::Right);
        for (name, lat, lon, country, side) in [
            ("Tokyo", 35.68, 139.76, "JP", left),
            ("London", 51.5, -0.12, "GB", left),
            ("Sydney", -33.87, 151.2, "AU", left),
            ("Cape Town", -33.92, 18.42, "ZA", left),
            ("Delhi", 28.61, 77.2, "IN", left),
            ("Hong Kong", 22.3, 114.17, "HK", left),
            ("Frederiksted", 17.71, -64.88, "VI", left),
            ("Nicosia", 35.16, 33.36, "CY", left),
            ("Berlin", 52.5, 13.4, "DE", right),
            ("Shenzhen", 22.55, 114.1, "CN", right),
            ("San Juan", 18.44, -66.07, "PR", right),
            ("Gibraltar", 36.14, -5.35, "GI", right),
            ("Rangoon", 16.8, 96.15, "MM", right),
        ] {
            assert_eq!(at(lat, lon), (Some(country.to_owned()), side), "{name}");
        }
        assert_eq!(at(-40.0, -20.0), (None, right));
        assert_eq!(at(f64::NAN, 500.0), (None, right));
    }
}
