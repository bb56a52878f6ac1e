//! Findings as GeoJSON (RFC 7946): drop the file on a web map, QGIS or JOSM and see where they are.

use std::io::{self, Write};

use serde_json::{Value, json};

use crate::diagnostic::{Place, Subject};
use crate::geometry::Point;
use crate::lanelet::{
    Bound, Lanelet, LaneletId, LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElementId, Target,
};
use crate::projection::LonLat;

use super::{Entry, Report, Unproject, split_code};

/// Decimals of a degree: a tenth of a millimetre.
const DECIMALS: i32 = 9;

/// Writes one feature for every finding, in the order of the run: the place that the rule names, else the primitive.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn write(report: &Report<'_>, out: &mut dyn Write) -> io::Result<()> {
    writeln!(out, "{{\"type\":\"FeatureCollection\",\"features\":[")?;
    let (entries, referrers) = (report.entries(), report.referrers());
    for (at, entry) in entries.iter().enumerate() {
        let chain = referrers.chain(report.map, entry.subject());
        serde_json::to_writer(&mut *out, &feature(report, entry, &chain))?;
        writeln!(out, "{}", if at + 1 < entries.len() { "," } else { "" })?;
    }
    writeln!(out, "]}}")
}

/// One feature for every finding, in the order of the run: what [`write()`] writes.
pub fn features(report: &Report<'_>) -> Vec<Value> {
    let (entries, referrers) = (report.entries(), report.referrers());
    let of_entry = |entry: &Entry<'_>| feature(report, entry, &referrers.chain(report.map, entry.subject()));
    entries.iter().map(of_entry).collect()
}

/// One feature for every lanelet, in the map's order: its outline, with the tags as properties. Points without longitude and
/// latitude get them by `unproject`.
pub fn lanelets(map: &LaneletMap, unproject: Unproject<'_>) -> Vec<Value> {
    let ring = |lanelet: &Lanelet| {
        let right: Vec<Point> = map.bound_points(lanelet.right).map(|point| point.position).collect();
        let left = map.bound_points(lanelet.left).map(|point| point.position);
        unproject(&left.chain(right.into_iter().rev()).collect::<Vec<_>>()).and_then(ring_of)
    };
    let of_lanelet = |lanelet: &Lanelet| {
        let tags = lanelet.attributes.iter().map(|(key, value)| (key.to_string(), json!(value.to_string())));
        let mut properties = serde_json::Map::from_iter([("id".to_owned(), json!(lanelet.id.0))]);
        properties.extend(tags);
        json!({ "type": "Feature", "id": lanelet.id.0, "geometry": ring(lanelet), "properties": properties })
    };
    map.lanelets.iter().map(of_lanelet).collect()
}

/// A place in the plane as GeoJSON geometry; `null` where it is none.
pub fn place(place: &Place, unproject: Unproject<'_>) -> Value {
    let found = match place {
        Place::Unknown => None,
        Place::Point(point) => unproject(&[*point]).and_then(|places| point_of(&places)),
        Place::Line(points) => unproject(points).and_then(|places| line_of(&places)),
        Place::Polygon(ring) => unproject(ring).and_then(ring_of),
    };
    found.unwrap_or(Value::Null)
}

fn feature(report: &Report<'_>, entry: &Entry<'_>, chain: &[Subject]) -> Value {
    let diagnostic = entry.diagnostic;
    let finding = &diagnostic.finding;
    let (rule, slug) = split_code(&diagnostic.code);
    json!({
        "type": "Feature",
        "id": entry.fingerprint,
        "geometry": geometry(report, entry),
        "properties": {
            "code": diagnostic.code,
            "rule": rule,
            "slug": slug,
            "severity": diagnostic.severity,
            "primitive": finding.subject.kind(),
            "id": finding.subject.id(),
            "referrers": chain.iter().map(Subject::to_string).collect::<Vec<_>>(),
            "related": finding.related.iter().map(|one| format!("{} ({})", one.subject, one.part)).collect::<Vec<_>>(),
            "message": finding.message,
            "help": diagnostic.help,
            "fix": finding.fix.as_ref().map(|fix| &fix.title),
            "value": finding.measure.map(|measure| measure.value),
            "limit": finding.measure.map(|measure| measure.limit),
            "unit": finding.measure.map(|measure| measure.unit),
            "file": entry.position.map(|at| at.name),
            "line": entry.position.map(|at| at.line),
            "column": entry.position.map(|at| at.column),
            "lat": diagnostic.lonlat.map(|at| at.lat),
            "lon": diagnostic.lonlat.map(|at| at.lon),
            "x": diagnostic.local.map(|at| at.x),
            "y": diagnostic.local.map(|at| at.y),
            "marker-color": match diagnostic.severity {
                crate::diagnostic::Severity::Error => "#d7263d",
                crate::diagnostic::Severity::Warning => "#f49d37",
                crate::diagnostic::Severity::Info => "#3f88c5",
            },
        },
    })
}

/// `null` where nothing is known about the place, which RFC 7946 allows.
fn geometry(report: &Report<'_>, entry: &Entry<'_>) -> Value {
    let diagnostic = entry.diagnostic;
    let place = report.unproject.map(|unproject| place(&diagnostic.finding.place, unproject));
    let place = place.filter(|geometry| !geometry.is_null());
    let own = || of_subject(report.map, diagnostic.finding.subject);
    let spot = || diagnostic.lonlat.and_then(|at| point_of(&[at]));
    place.or_else(own).or_else(spot).unwrap_or(Value::Null)
}

pub(super) fn of_subject(map: &LaneletMap, subject: Subject) -> Option<Value> {
    match subject {
        Subject::Point(id) | Subject::Node(id) => point_of(&places(map, &[PointId(id)])),
        Subject::LineString(id) => line_of(&line_places(map, LineStringId(id))),
        Subject::Polygon(id) => ring_of(places(map, &map.polygons.get(PolygonId(id))?.points)),
        Subject::Lanelet(id) => {
            let lanelet = map.lanelets.get(LaneletId(id))?;
            let mut ring = bound_places(map, lanelet.left);
            ring.extend(bound_places(map, lanelet.right).into_iter().rev());
            ring_of(ring)
        }
        Subject::RegulatoryElement(id) => {
            let element = map.regulatory_elements.get(RegulatoryElementId(id))?;
            let lines = element.members.iter().filter_map(|member| match member.target {
                Target::LineString(id) => Some(line_places(map, id)),
                _ => None,
            });
            let lines: Vec<Value> = lines.filter(|line| line.len() > 1).map(|line| coordinates(&line)).collect();
            (!lines.is_empty()).then(|| json!({ "type": "MultiLineString", "coordinates": lines }))
        }
        Subject::Map | Subject::Way(_) | Subject::Relation(_) => None,
    }
}

fn places(map: &LaneletMap, points: &[PointId]) -> Vec<LonLat> {
    points.iter().filter_map(|&id| map.points.get(id)?.lonlat()).collect()
}

fn line_places(map: &LaneletMap, id: LineStringId) -> Vec<LonLat> {
    map.linestrings.get(id).map_or(Vec::new(), |line| places(map, &line.points))
}

fn bound_places(map: &LaneletMap, bound: Bound) -> Vec<LonLat> {
    map.bound_points(bound).filter_map(|point| point.lonlat()).collect()
}

fn point_of(places: &[LonLat]) -> Option<Value> {
    places.first().filter(|at| is_place(at)).map(|&at| json!({ "type": "Point", "coordinates": position(at) }))
}

pub(super) fn line_of(places: &[LonLat]) -> Option<Value> {
    match places {
        [] => None,
        [_] => point_of(places),
        _ if !places.iter().all(is_place) => None,
        _ => Some(json!({ "type": "LineString", "coordinates": coordinates(places) })),
    }
}

/// A ring runs counter-clockwise and repeats its first place.
fn ring_of(mut places: Vec<LonLat>) -> Option<Value> {
    if places.len() > 1 && places.first() == places.last() {
        places.pop();
    }
    if places.len() < 3 {
        return line_of(&places);
    }
    let doubled: f64 = (0..places.len())
        .map(|i| (places[i], places[(i + 1) % places.len()]))
        .map(|(a, b)| {
            (a.lon - places[0].lon) * (b.lat - places[0].lat) - (b.lon - places[0].lon) * (a.lat - places[0].lat)
        })
        .sum();
    if doubled < 0.0 {
        places.reverse();
    }
    places.push(places[0]);
    places.iter().all(is_place).then(|| json!({ "type": "Polygon", "coordinates": [coordinates(&places)] }))
}

/// JSON has no word for what is not a number.
fn is_place(at: &LonLat) -> bool {
    at.lon.is_finite() && at.lat.is_finite()
}

fn coordinates(places: &[LonLat]) -> Value {
    places.iter().map(|&at| position(at)).collect()
}

fn position(at: LonLat) -> Value {
    let rounded = |degrees: f64| (degrees * 10_f64.powi(DECIMALS)).round() / 10_f64.powi(DECIMALS);
    json!([rounded(at.lon), rounded(at.lat)])
}
