//! `map_projector_info.yaml`: which projector a map was made with, and what in it Autoware does not read as it is meant.

use std::fmt::Write as _;

use saphyr_parser::{Event, Parser, ScalarStyle};

use crate::text::nearest;

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
    #[error("`{key}` is missing{}{}",
        .projector.map(|p| format!("; projector_type {p} needs it")).unwrap_or_default(),
        .found.as_ref().map(|f| format!("; `{f}` is not read")).unwrap_or_default())]
    Missing {
        /// `map_origin.latitude`, ...
        key: &'static str,
        /// The type that needs it, where the type is known.
        projector: Option<&'static str>,
        /// A key that is there and may be meant.
        found: Option<String>,
    },
    /// A projector type that Autoware does not know, or knows in other letters.
    #[error("unknown projector_type `{found}`{}", .meant.map(|m| format!("; Autoware writes `{m}`")).unwrap_or_default())]
    Type {
        /// As written.
        found: String,
        /// The type that is most like it.
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
    /// A link to a file about something else.
    #[error("the link leads to a file that names no projector; put the file itself here to see what is wrong with it")]
    Linked,
    /// A grid that does not exist.
    #[error("mgrs_grid: {0}")]
    Grid(#[from] MgrsError),
}

/// The `projector_type` values.
const TYPES: [&str; 5] = ["MGRS", "LocalCartesianUTM", "TransverseMercator", "LocalCartesian", "Local"];

/// The keys that Autoware reads.
const KEYS: [&str; 6] =
    ["projector_type", "vertical_datum", "mgrs_grid", "map_origin.latitude", "map_origin.longitude", "scale_factor"];

/// What a `map_projector_info.yaml` says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Info {
    /// The projector, if all that it needs can be read, even in another spelling than Autoware's.
    pub projector: Option<Projector>,
    /// What heights are measured from.
    pub datum: VerticalDatum,
    /// Why Autoware does not read it like this.
    pub errors: Vec<InfoError>,
    /// Unknown keys, each with the optional key that it resembles most.
    pub unread: Vec<(String, &'static str)>,
}

/// Reads the text of a `map_projector_info.yaml`. Unknown keys are ignored, as Autoware does.
pub fn read_info(text: &str) -> Info {
    let keys = match Keys::read(text) {
        Ok(keys) => keys,
        Err(error) => return Info { errors: vec![error], ..Info::default() },
    };
    let mut info = Info::default();
    if let Some(name) = info.keep(keys.projector_type()) {
        info.judge(&keys, name);
    }
    info
}

impl Info {
    /// The value, or else the error is noted.
    fn keep<T>(&mut self, read: Result<T, InfoError>) -> Option<T> {
        read.map_err(|error| self.errors.push(error)).ok()
    }

    /// Whether the text does not even name a type of projector, nor one like it.
    pub fn is_of_something_else(&self) -> bool {
        self.errors.iter().any(|error| {
            matches!(
                error,
                InfoError::Line { .. }
                    | InfoError::Missing { key: "projector_type", .. }
                    | InfoError::Type { meant: None, .. }
            )
        })
    }

    fn judge(&mut self, keys: &Keys, name: &'static str) {
        if keys.get("projector_type") != Some(name) {
            let found = keys.get("projector_type").unwrap_or_default().to_owned();
            self.errors.push(InfoError::Type { found, meant: Some(name) });
        }
        let missing = |key| InfoError::Missing { key, projector: Some(name), found: keys.like(key) };
        let datum = match keys.get("vertical_datum") {
            Some("WGS84") => Ok(VerticalDatum::Wgs84),
            Some("EGM2008") => Ok(VerticalDatum::Egm2008),
            Some(found) => {
                let found = found.to_owned();
                Err(InfoError::Value { key: "vertical_datum", found, expected: "WGS84 or EGM2008" })
            }
            None if name == "Local" => Ok(VerticalDatum::default()),
            None => Err(missing("vertical_datum")),
        };
        self.datum = self.keep(datum).unwrap_or_default();
        let mut origin = || {
            let of = |key, limit| keys.number(key, limit).and_then(|number| number.ok_or_else(|| missing(key)));
            let lat = self.keep(of("map_origin.latitude", 90.0));
            let lon = self.keep(of("map_origin.longitude", 180.0));
            Some(LonLat { lat: lat?, lon: lon? })
        };
        self.projector = match name {
            "MGRS" => {
                let grid = keys.get("mgrs_grid").ok_or_else(|| missing("mgrs_grid"));
                self.keep(grid.and_then(|grid| Ok(grid.parse()?))).map(Projector::Mgrs)
            }
            "LocalCartesianUTM" => origin().map(|origin| Projector::LocalCartesianUtm { origin }),
            "TransverseMercator" => {
                let origin = origin();
                let scale_factor = self.keep(keys.scale_factor()).unwrap_or(DEFAULT_SCALE_FACTOR);
                origin.map(|origin| Projector::TransverseMercator { origin, scale_factor })
            }
            "LocalCartesian" => origin().map(|origin| Projector::LocalCartesian { origin }),
            _ => Some(Projector::Local),
        };
        let lacking: Vec<&str> = self.errors.iter().filter_map(InfoError::lacking).collect();
        let unread = keys.0.iter().filter(|(key, _)| !KEYS.contains(&key.as_str()));
        let unread = unread.filter_map(|(key, _)| Some((key.clone(), nearest(key, KEYS)?)));
        self.unread = unread.filter(|(_, meant)| !lacking.contains(meant) && keys.get(meant).is_none()).collect();
    }
}

impl InfoError {
    fn lacking(&self) -> Option<&str> {
        match self {
            Self::Missing { key, .. } => Some(key),
            _ => None,
        }
    }
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
        let text = text.trim_start_matches('\u{feff}');
        let (mut keys, mut path, mut lists) = (Vec::new(), Vec::new(), 0);
        let (mut depth, mut key): (usize, Option<String>) = (0, None);
        for event in Parser::new_from_str(text) {
            let (event, span) = event.map_err(|error| no_key(text, error.marker().line()))?;
            match event {
                Event::SequenceStart(..) => lists += 1,
                Event::SequenceEnd => {
                    lists -= 1;
                    if lists == 0 {
                        key = None;
                    }
                }
                // No known key has a list as its value.
                _ if lists > 0 => {}
                Event::MappingStart(..) => {
                    depth += 1;
                    path.extend(key.take());
                }
                Event::MappingEnd => {
                    depth -= 1;
                    path.pop();
                }
                Event::Scalar(..) | Event::Alias(_) if depth == 0 => return Err(no_key(text, span.start.line())),
                Event::Scalar(value, style, ..) => match key.take() {
                    None => key = Some(value.into_owned()),
                    // A key without a value.
                    Some(_) if style == ScalarStyle::Plain && (value.is_empty() || value == "~") => {}
                    Some(last) => {
                        let names = path.iter().map(String::as_str).chain([last.as_str()]);
                        keys.push((names.collect::<Vec<_>>().join("."), value.into_owned()));
                    }
                },
                _ => {}
            }
        }
        Ok(Self(keys))
    }

    fn get(&self, key: &str) -> Option<&str> {
        self.0.iter().find(|(k, _)| k == key).map(|(_, v)| v.as_str())
    }

    /// The type, or the one that is most like it.
    fn projector_type(&self) -> Result<&'static str, InfoError> {
        let key = "projector_type";
        let missing = || InfoError::Missing { key, projector: None, found: self.like(key) };
        let found = self.get(key).ok_or_else(missing)?;
        let unknown = || InfoError::Type { found: found.to_owned(), meant: None };
        nearest(found, TYPES).ok_or_else(unknown)
    }

    /// A key that is probably meant for a missing one: misspelt, or without the level above.
    fn like(&self, key: &str) -> Option<String> {
        let last = key.rsplit('.').next().unwrap_or(key);
        let others = || self.0.iter().map(|(other, _)| other.as_str()).filter(|other| !KEYS.contains(other));
        let inner = others().find(|other| other.rsplit('.').next() == Some(last));
        inner.or_else(|| nearest(key, others())).map(str::to_owned)
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

/// The error of the first line without a key, or else of the line where the parser stopped.
fn no_key(text: &str, stopped: usize) -> InfoError {
    let lines = || text.lines().map(str::trim).enumerate();
    let is_plain = |line: &str| !line.is_empty() && !line.starts_with(['#', '-', '.', '%', '{', '}']);
    let has_key = |line: &str| line.contains(": ") || line.ends_with(':');
    let first = lines().find(|(_, line)| is_plain(line) && !has_key(line));
    let first = first.or_else(|| lines().take(stopped).filter(|(_, line)| !line.is_empty()).last());
    first.map_or(InfoError::Line { line: stopped, text: String::new() }, |(at, line)| InfoError::Line {
        line: at + 1,
        text: line.to_owned(),
    })
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
                assert_eq!(read_info(&text), Info { projector: Some(projector), datum, ..Info::default() }, "{text}");
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
        assert_eq!(read_info(text), Info { projector: Some(expected), ..Info::default() });
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let says = |text: &str| read_info(text).errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
        assert_eq!(says("projector_type: local\n"), "unknown projector_type `local`; Autoware writes `Local`");
        assert_eq!(says("projector_type: UTM\n"), "unknown projector_type `UTM`");
        assert_eq!(says("vertical_datum: WGS84\n"), "`projector_type` is missing");
        assert_eq!(
            says("projector_type: MGRS\nvertical_datum: WGS84\nmgrs_grid:\n"),
            "`mgrs_grid` is missing; projector_type MGRS needs it"
        );
        assert_eq!(
            says("projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_origin:\n  latitude: 1\nlongitude: 2\n"),
            "`map_origin.longitude` is missing; projector_type LocalCartesian needs it; `longitude` is not read"
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
        let open = "projector_type: MGRS\nmap_origin: {latitude: 1\n";
        assert_eq!(says(open), "line 2: expected `key: value`, found `map_origin: {latitude: 1`");
        assert_eq!(says("projector_type MGRS\n"), "line 1: expected `key: value`, found `projector_type MGRS`");
        assert_eq!(
            says("projector_type: Local\nvertical_datum: WGS85\n"),
            "`vertical_datum: WGS85` is not WGS84 or EGM2008"
        );
    }

    #[test]
    fn what_was_meant_is_read_all_the_same() {
        let info = read_info("projector_type: local\n");
        assert_eq!((info.projector, info.errors.len()), (Some(Projector::Local), 1));
        let origin = "map_origin:\n  latitude: 35.6762\n  longitude: 139.6503\n";
        let info = read_info(&format!("projector_type: TransverseMercator\n{origin}scalefactor: 1\n"));
        assert_eq!(info.projector, Some(Projector::transverse_mercator(ORIGIN)));
        assert_eq!(info.unread, [("scalefactor".to_owned(), "scale_factor")]);
        let missing = InfoError::Missing { key: "vertical_datum", projector: Some("TransverseMercator"), found: None };
        assert_eq!(info.errors, [missing]);
        let info = read_info(
            "projector_type: LocalCartesian\nvertical_datum: WGS84\nmap_orgin:\n  latitude: 1\n  longitude: 2\n",
        );
        assert_eq!((info.projector, info.errors.len(), info.unread.len()), (None, 2, 0));
    }
}
