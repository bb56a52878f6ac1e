//! The country of a place, and the side of the road people drive on there.

use country_boundaries::{BOUNDARIES_ODBL_360X180, CountryBoundaries, LatLon};

use crate::osm::Text;
use crate::projection::LonLat;

use super::road_network::DrivingSide;

/// ISO 3166 codes of the countries and territories where people drive on the left, ascending. A territory that
/// drives on the other side than its country has an entry of its own kind in [`side_of`].
const LEFT: [&str; 76] = [
    "AG", "AI", "AU", "BB", "BD", "BM", "BN", "BS", "BT", "BW", "CC", "CK", "CX", "CY", "DM", "FJ", "FK", "GB", "GD",
    "GG", "GS", "GY", "HK", "ID", "IE", "IM", "IN", "JE", "JM", "JP", "KE", "KI", "KN", "KY", "LC", "LK", "LS", "MO",
    "MS", "MT", "MU", "MV", "MW", "MY", "MZ", "NA", "NF", "NP", "NR", "NU", "NZ", "PG", "PK", "PN", "SB", "SC", "SG",
    "SH", "SR", "SZ", "TC", "TH", "TK", "TL", "TO", "TT", "TV", "TZ", "UG", "VC", "VG", "VI", "WS", "ZA", "ZM", "ZW",
];

/// Where a network lies.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Country {
    /// ISO 3166-1 alpha-2 code; `None` at sea.
    pub country: Option<Text>,
    /// The side people drive on; the right where no country is known.
    pub side: DrivingSide,
}

/// The country of `place` and its driving side.
pub fn of_place(place: LonLat) -> Country {
    let ids: Vec<Text> =
        match (CountryBoundaries::from_reader(BOUNDARIES_ODBL_360X180), LatLon::new(place.lat, place.lon)) {
            (Ok(boundaries), Ok(position)) => boundaries.ids(position).into_iter().map(Text::from).collect(),
            _ => Vec::new(),
        };
    let side = side_of(ids.iter().map(Text::as_str));
    // Subdivisions come as `US-VI`; the country is the part before the hyphen.
    let country = ids.iter().filter_map(|id| id.split('-').next()).next().map(Text::from);
    Country { country, side }
}

/// The driving side of a place with these ISO 3166 codes, of a country or of its parts.
pub fn side_of<'a>(ids: impl Iterator<Item = &'a str>) -> DrivingSide {
    let mut side = DrivingSide::Right;
    for id in ids {
        let left = match id.split_once('-') {
            // Territories under their country's code.
            Some((country, part)) => left(country) || matches!(id, "US-VI" | "CN-HK" | "CN-MO") && left(part),
            None => left(id),
        };
        if left {
            side = DrivingSide::Left;
        }
    }
    side
}

fn left(id: &str) -> bool {
    LEFT.binary_search(&id).is_ok()
}
