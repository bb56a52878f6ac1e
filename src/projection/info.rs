//! `map_projector_info.yaml`: which projector a map was made with. Two levels of `key: value`, so no YAML crate.

use std::fmt::Write as _;

use super::{DEFAULT_SCALE_FACTOR, LonLat, MgrsError, Projector};

/// What heights are measured from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum VerticalDatum {
    /// The ellipsoid: Autoware's default.
    #[default]
    Wgs84,
    /// The geoid EGM2008.
    Egm2008,
}

impl VerticalDatum {
    /// The value of `vertical_datum`.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Wgs84 => "WGS84",
            Self::Egm2008 => "EGM2008",
        }
    }
}

/// Why a `map_projector_info.yaml` cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InfoError {
    /// A line that is not `key: value`.
    #[error("line {line}: expected `key: value`, found `{text}`")]
    Line {
        /// From 1.
        line: usize,
        /// As written.
        text: String,
    },
    /// A key that the projector needs is not there.
    #[error("`{key}` is missing{}", .projector.map(|p| format!("; projector_type {p} needs it")).unwrap_or_default())]
    Missing {
        /// `map_origin.latitude`, ...
        key: &'static str,
        /// The type that needs it, where the type is known.
        projector: Option<&'static str>,
    },
    /// A projector type that Autoware does not know, or knows in other letters.
    #[error("unknown projector_type `{found}`{}", .meant.map(|m| format!("; did you mean `{m}`?")).unwrap_or_default())]
    Type {
        /// As written.
        found: String,
        /// The type that is the same but for case.
        meant: Option<&'static str>,
    },
    /// A value that is not a number, or is out of range.
    #[error("`{key}: {found}` is not {expected}")]
    Value {
        /// The key.
        key: &'static str,
        /// As written.
        found: String,
        /// What it has to be.
        expected: &'static str,
    },
    /// A grid that does not exist.
    #[error("mgrs_grid: {0}")]
    Grid(#[from] MgrsError),
}

impl InfoError {
    /// A way out, in one line.
    pub const fn help(&self) -> &'static str {
        match self {
            Self::Line { .. } => "map_projector_info.yaml has lines such as `projector_type: MGRS`",
            Self::Missing { .. } => "add the key; Autoware's map loader needs it too",
            Self::Type { .. } => {
                "Autoware knows MGRS, LocalCartesianUTM, TransverseMercator, LocalCartesian and Local, in exactly these letters"
            }
            Self::Value { .. } => "correct the value",
            Self::Grid(_) => "the grid is the name of the 100 km square that holds the map",
        }
    }
}

/// The `projector_type` values.
const TYPES: [&str; 5] = ["MGRS", "LocalCartesianUTM", "TransverseMercator", "LocalCartesian", "Local"];

/// Reads the text of a `map_projector_info.yaml`. Unknown keys are passed over, as Autoware does.
pub fn read_info(text: &str) -> Result<(Projector, VerticalDatum), InfoError> {
    let keys = Keys::read(text)?;
    let found = keys.get("projector_type").ok_or(InfoError::Missing { key: "projector_type", projector: None })?;
    let Some(name) = TYPES.into_iter().find(|t| *t == found) else {
        let meant = TYPES.into_iter().find(|t| t.eq_ignore_ascii_case(found));
        return Err(InfoError::Type { found: found.to_owned(), meant });
    };
    let missing = |key| InfoError::Missing { key, projector: Some(name) };
    let datum = match keys.get("vertical_datum") {
        Some("WGS84") => VerticalDatum::Wgs84,
        Some("EGM2008") => VerticalDatum::Egm2008,
        Some(found) => {
            let found = found.to_owned();
            return Err(InfoError::Value { key: "vertical_datum", found, expected: "WGS84 or EGM2008" });
        }
        None if name == "Local" => VerticalDatum::default(),
        None => return Err(missing("vertical_datum")),
    };
    let origin = || {
        let of = |key, limit| keys.number(key, limit)?.ok_or_else(|| missing(key));
        Ok::<_, InfoError>(LonLat { lat: of("map_origin.latitude", 90.0)?, lon: of("map_origin.longitude", 180.0)? })
    };
    let projector = match name {
        "MGRS" => Projector::Mgrs(keys.get("mgrs_grid").ok_or_else(|| missing("mgrs_grid"))?.parse()?),
        "LocalCartesianUTM" => Projector::LocalCartesianUtm { origin: origin()? },
        "TransverseMercator" => Projector::TransverseMercator { origin: origin()?, scale_factor: keys.scale_factor()? },
        "LocalCartesian" => Projector::LocalCartesian { origin: origin()? },
        _ => Projector::Local,
    };
    Ok((projector, datum))
}

/// The text of a `map_projector_info.yaml`.
pub fn write_info(projector: &Projector, datum: VerticalDatum) -> String {
    let mut text = format!("projector_type: {}\nvertical_datum: {}\n", projector.name(), datum.as_str());
    let origin = match *projector {
        Projector::Mgrs(grid) => {
            // Writing to a String cannot fail.
            let _ = writeln!(text, "mgrs_grid: {grid}");
            None
        }
        Projector::LocalCartesianUtm { origin }
        | Projector::TransverseMercator { origin, .. }
        | Projector::LocalCartesian { origin } => Some(origin),
        Projector::Local => None,
    };
    if let Some(LonLat { lon, lat }) = origin {
        let _ = writeln!(text, "map_origin:\n  latitude: {lat:?}\n  longitude: {lon:?}");
    }
    match *projector {
        Projector::TransverseMercator { scale_factor, .. } if scale_factor != DEFAULT_SCALE_FACTOR => {
            let _ = writeln!(text, "scale_factor: {scale_factor:?}");
        }
        _ => {}
    }
    text
}

/// Keys with their values; those of an inner level as `outer.inner`.
struct Keys(Vec<(String, String)>);

impl Keys {
    fn read(text: &str) -> Result<Self, InfoError> {
        let mut keys = Vec::new();
        let mut outer = String::new();
        for (number, written) in text.trim_start_matches('\u{feff}').lines().enumerate() {
            let line = without_comment(written).trim_end();
            let content = line.trim_start();
            if content.is_empty() || content == "---" || content == "..." || content.starts_with('%') {
                continue;
            }
            let bad = || InfoError::Line { line: number + 1, text: written.trim().to_owned() };
            let (key, value) = content.split_once(':').ok_or_else(bad)?;
            if !value.is_empty() && !value.starts_with([' ', '\t']) || line.starts_with('\t') {
                return Err(bad());
            }
            let (key, value) = (unquoted(key.trim()), value.trim());
            let inner = content.len() < line.len();
            if !inner {
                outer = if value.is_empty() { format!("{key}.") } else { String::new() };
            }
            match value.strip_prefix('{').map(|v| v.strip_suffix('}')) {
                Some(None) => return Err(bad()),
                Some(Some(flow)) => {
                    for pair in flow.split(',') {
                        let (k, v) = pair.split_once(':').ok_or_else(bad)?;
                        keys.push((format!("{key}.{}", unquoted(k.trim())), unquoted(v.trim()).to_owned()));
                    }
                }
                None if value.is_empty() => {}
                None => {
                    let prefix = if inner { outer.as_str() } else { "" };
                    keys.push((format!("{prefix}{key}"), unquoted(value).to_owned()));
                }
            }
        }
        Ok(Self(keys))
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    fn number(&self, key: &'static str, limit: f64) -> Result<Option<f64>, InfoError> {
        let Some(found) = self.get(key) else { return Ok(None) };
        match found.parse::<f64>() {
            Ok(value) if value.abs() <= limit => Ok(Some(value)),
            _ => Err(InfoError::Value { key, found: found.to_owned(), expected: "a number of degrees" }),
        }
    }

    fn scale_factor(&self) -> Result<f32, InfoError> {
        let Some(found) = self.get("scale_factor") else { return Ok(DEFAULT_SCALE_FACTOR) };
        match found.parse::<f32>() {
            Ok(value) if value > 0.0 && value.is_finite() => Ok(value),
            _ => Err(InfoError::Value { key: "scale_factor", found: found.to_owned(), expected: "a number above 0" }),
        }
    }
}

/// `#` opens a comment at the start of a line or behind a blank; no value here has one in quotes.
fn without_comment(line: &str) -> &str {
    let opens = |&(at, _): &(usize, &str)| at == 0 || line[..at].ends_with([' ', '\t']);
    line.match_indices('#').find(opens).map_or(line, |(at, _)| &line[..at])
}

fn unquoted(text: &str) -> &str {
    let inside = |quote| text.strip_prefix(quote).and_then(|t: &str| t.strip_suffix(quote));
    inside('"').or_else(|| inside('\'')).unwrap_or(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORIGIN: LonLat = LonLat { lon: 139.6503, lat: 35.6762 };

    #[test]
    fn what_is_written_is_read() {
        for projector in [
            Projector::mgrs("54SUE".parse().unwrap()),
            Projector::LocalCartesianUtm { origin: ORIGIN },
            Projector::transverse_mercator(ORIGIN),
            Projector::TransverseMercator { origin: LonLat { lon: 8.0, lat: -33.0 }, scale_factor: 1.0 },
            Projector::LocalCartesian { origin: ORIGIN },
            Projector::Local,
        ] {
            for datum in [VerticalDatum::Wgs84, VerticalDatum::Egm2008] {
                let text = write_info(&projector, datum);
                assert_eq!(read_info(&text), Ok((projector, datum)), "{text}");
            }
        }
        let text = write_info(&Projector::transverse_mercator(ORIGIN), VerticalDatum::Wgs84);
        let expected = "projector_type: TransverseMercator\nvertical_datum: WGS84\nmap_origin:\n  latitude: 35.6762\n  longitude: 139.6503\n";
        assert_eq!(text, expected);
    }

    #[test]
    fn comments_quotes_flow_and_order_do_not_matter() {
        let text = "\u{feff}# made by hand\r\n---\r\nmap_origin: {latitude: 35.6762, longitude: 139.6503} # Tokyo\r\n\r\nextra: 1\r\nscale_factor: 0.5\r\nvertical_datum: 'WGS84'\r\nprojector_type: \"TransverseMercator\"\r\n";
        let expected = Projector::TransverseMercator { origin: ORIGIN, scale_factor: 0.5 };
        assert_eq!(read_info(text), Ok((expected, VerticalDatum::Wgs84)));
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let says = |text: &str| read_info(text).unwrap_err().to_string();
        assert_eq!(says("projector_type: local\n"), "unknown projector_type `local`; did you mean `Local`?");
        assert_eq!(says("projector_type: UTM\n"), "unknown projector_type `UTM`");
        assert_eq!(says("vertical_datum: WGS84\n"), "`projector_type` is missing");
        assert_eq!(
            says("projector_type: MGRS\nvertical_datum: WGS84\n"),
            "`mgrs_grid` is missing; projector_type MGRS needs it"
        );
        assert_eq!(
            says("projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_origin:\n  latitude: 1\nlongitude: 2\n"),
            "`map_origin.longitude` is missing; projector_type LocalCartesian needs it"
        );
        assert!(
            says("projector_type: MGRS\nvertical_datum: WGS84\nmgrs_grid: 99XXX\n").starts_with("mgrs_grid: `99XXX`")
        );
        assert_eq!(
            says(
                "projector_type: TransverseMercator\nvertical_datum: WGS84\nscale_factor: 0\nmap_origin:\n  latitude: 1\n  longitude: 2\n"
            ),
            "`scale_factor: 0` is not a number above 0"
        );
        assert_eq!(says("projector_type MGRS\n"), "line 1: expected `key: value`, found `projector_type MGRS`");
        assert_eq!(
            says("projector_type: MGRS\nvertical_datum: WGS85\n"),
            "`vertical_datum: WGS85` is not WGS84 or EGM2008"
        );
    }
}
