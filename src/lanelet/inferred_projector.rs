//! Which projector a map was made with, where no file beside it says so. `check`, `fix` and `project infer` all ask here.

use rustc_hash::FxHashMap;

use crate::geometry::Point as PlanePoint;
use crate::osm::OsmData;
use crate::projection::{Explained, Extent, LonLat, MgrsGrid, Projector, Twice, infer, share};

/// Local coordinates are explained up to this distance, metres: what editors leave.
const EXPLAINED: f64 = 0.05;
/// A projection that explains this share of the nodes (1) is the map's: the others were moved by degrees or by metres alone.
const NEARLY_ALL: f64 = 0.95;
/// So many nodes show whether MGRS explains the local coordinates.
const SAMPLE: usize = 200;
/// Nodes on both sides of a border between squares that follow each other on a way within this (deg) show that the map crosses it:
/// a slip of the pen moves a node farther.
const CROSSING: f64 = 0.01;
/// Nodes of a way lie this far apart (deg) in no map; in metres they do.
const FAR_APART: f64 = 0.05;
/// So many ways show whether their nodes lie too far apart.
const WAYS: usize = 1000;

/// The projector of a map that does not name one, and what tells it.
#[derive(Clone, Debug, PartialEq)]
pub struct Inferred {
    /// The projector.
    pub projector: Projector,
    /// What tells it.
    pub evidence: Evidence,
}

/// What tells the projector of a map.
#[derive(Clone, Debug, PartialEq)]
pub enum Evidence {
    /// No node has latitude and longitude, or those of nearly all are 0.
    NoDegrees,
    /// Latitudes and longitudes are metres.
    Metres,
    /// It takes the latitudes and longitudes of nearly all nodes to their local coordinates.
    LocalCoordinates,
    /// The map lies in one 100 km square of MGRS, to which Autoware falls back; nothing says that another is meant.
    OneSquare,
    /// The map crosses the border between these squares, which MGRS would fold into one. A transverse Mercator with its origin in the
    /// middle keeps it whole.
    Squares(Vec<MgrsGrid>),
}

/// The projector of a map that does not name one.
pub fn inferred_projector(osm: &OsmData) -> Inferred {
    if written_metres(osm).is_some() {
        return Inferred { projector: Projector::Local, evidence: Evidence::Metres };
    }
    let places: Vec<Option<LonLat>> =
        osm.nodes.iter().map(|node| node.position.filter(|place| *place != LonLat::default())).collect();
    let placed = places.iter().flatten().next();
    let in_metres = || osm.nodes.iter().filter(|node| node.tags.has("local_x") || node.tags.has("local_y")).count();
    // The few nodes that have degrees say nothing of the many that lie at latitude 0, longitude 0.
    let degrees = places.iter().flatten().count();
    if degrees as f64 <= (1.0 - NEARLY_ALL) * places.len() as f64 && in_metres() > degrees {
        return Inferred { projector: Projector::Local, evidence: Evidence::NoDegrees };
    }
    // Near the poles there is no square: any will do, and every node says that it cannot be projected.
    let square = MgrsGrid::of(placed.copied().unwrap_or_default()).or_else(|| MgrsGrid::of(LonLat::default()));
    let mgrs = square.map_or(Projector::Local, Projector::Mgrs);
    if let Some(projector) = of_local_coordinates(osm, mgrs) {
        return Inferred { projector, evidence: Evidence::LocalCoordinates };
    }
    match crossed_squares(osm, &places) {
        Some((squares, extent)) => {
            Inferred { projector: Projector::around(&extent), evidence: Evidence::Squares(squares) }
        }
        None => Inferred { projector: mgrs, evidence: Evidence::OneSquare },
    }
}

/// The projector that takes the degrees of nearly all nodes to their metres.
fn of_local_coordinates(osm: &OsmData, mgrs: Projector) -> Option<Projector> {
    let points = twice(osm);
    if points.is_empty() {
        return None;
    }
    let sample: Vec<Twice> = points.iter().copied().step_by(points.len().div_ceil(SAMPLE)).collect();
    let in_squares = Projector::in_squares(&sample.iter().map(|point| point.place).collect::<Vec<_>>());
    let near = |(point, found): (&Twice, Option<(PlanePoint, MgrsGrid)>)| {
        found.is_some_and(|(at, _)| (at - point.local).norm() <= EXPLAINED)
    };
    let explained = sample.iter().zip(in_squares).filter(|pair| near(*pair)).count();
    if explained as f64 >= NEARLY_ALL * sample.len() as f64 {
        return Some(mgrs);
    }
    explaining(&points)
}

/// The projector that explains nearly all points of which the place is said in degrees and in metres.
pub(super) fn explaining(points: &[Twice]) -> Option<Projector> {
    let is_explained = |one: &Explained| share(points, &one.projector, EXPLAINED) >= NEARLY_ALL;
    Some(infer(points).into_iter().find(is_explained)?.projector)
}

/// The squares of a map that crosses a border between some, most nodes first, and its extent.
fn crossed_squares(osm: &OsmData, places: &[Option<LonLat>]) -> Option<(Vec<MgrsGrid>, Extent)> {
    let extent = Extent::of(places.iter().flatten().copied())?;
    let corners = [extent.min.lon, extent.center().lon, extent.max.lon]
        .into_iter()
        .flat_map(|lon| [extent.min.lat, extent.center().lat, extent.max.lat].map(|lat| LonLat { lon, lat }));
    let names = |places: &[LonLat]| -> Vec<Option<MgrsGrid>> {
        Projector::in_squares(places).into_iter().map(|found| found.map(|(_, square)| square)).collect()
    };
    let of_corners = names(&corners.collect::<Vec<_>>());
    if of_corners.windows(2).all(|pair| pair[0] == pair[1]) {
        return None;
    }
    let all: Vec<LonLat> = places.iter().map(|place| place.unwrap_or_default()).collect();
    let squares: Vec<Option<MgrsGrid>> =
        names(&all).into_iter().zip(places).map(|(square, place)| square.filter(|_| place.is_some())).collect();
    let at =
        |id: i64| Some((places.get(osm.node_position(id)?)?.as_ref()?, squares.get(osm.node_position(id)?)?.as_ref()?));
    let crosses = |pair: &[i64]| {
        let [Some((a, one)), Some((b, other))] = [at(pair[0]), at(pair[1])] else { return false };
        !one.same_square(other) && (a.lat - b.lat).abs() <= CROSSING && (a.lon - b.lon).abs() <= CROSSING
    };
    if !osm.ways.iter().any(|way| way.nodes.windows(2).any(crosses)) {
        return None;
    }
    let mut counted: Vec<(usize, MgrsGrid)> = Vec::new();
    for square in squares.into_iter().flatten() {
        match counted.iter_mut().find(|(_, known)| known.same_square(&square)) {
            Some((count, _)) => *count += 1,
            None => counted.push((1, square)),
        }
    }
    counted.sort_by_key(|(count, _)| std::cmp::Reverse(*count));
    Some((counted.into_iter().map(|(_, square)| square).collect(), extent))
}

/// No coordinate or height is larger than this (m), ten times the Earth's girth: what is reckoned from such numbers would be none.
pub(super) const FARTHEST: f64 = 4e8;

/// Where the nodes lie, in metres, if their latitudes and longitudes are metres: those of most of them are not on Earth, or the nodes
/// of a way would lie kilometres apart.
pub(super) fn written_metres(osm: &OsmData) -> Option<Vec<PlanePoint>> {
    if osm.nodes.is_empty() || osm.nodes.iter().any(|node| node.tags.has("local_x")) {
        return None;
    }
    let off_earth: FxHashMap<i64, [f64; 2]> =
        osm.oddities.iter().filter_map(|odd| Some((odd.element?.1, odd.off_earth?))).collect();
    let apart = || {
        let at = |id: &i64| osm.node(*id).and_then(|node| node.position);
        let pairs = osm.ways.iter().take(WAYS).flat_map(|way| way.nodes.windows(2));
        let far: Vec<bool> = pairs
            .filter_map(|pair| Some((at(&pair[0])?, at(&pair[1])?)))
            .map(|(a, b)| (a.lat - b.lat).abs() + (a.lon - b.lon).abs() > FAR_APART)
            .collect();
        2 * far.iter().filter(|far| **far).count() > far.len()
    };
    if 2 * off_earth.len() <= osm.nodes.len() && !apart() {
        return None;
    }
    let place = |node: &crate::osm::Node| {
        let written = node.position.map(|place| [place.lat, place.lon]).or_else(|| off_earth.get(&node.id).copied());
        let written = written.filter(|metres| metres.iter().all(|number| number.abs() <= FARTHEST));
        written.map_or_else(PlanePoint::origin, |[north, east]| PlanePoint::new(east, north))
    };
    Some(osm.nodes.iter().map(place).collect())
}

/// The nodes whose place is said in degrees and in metres.
pub fn twice(osm: &OsmData) -> Vec<Twice> {
    let number = |text: Option<&str>| text?.trim().parse().ok().filter(|number: &f64| number.is_finite());
    let both = osm.nodes.iter().filter_map(|node| {
        let place = node.position.filter(|place| *place != LonLat::default())?;
        let local = [number(node.tags.get("local_x"))?, number(node.tags.get("local_y"))?];
        let ele = number(node.tags.get("ele")).unwrap_or(0.0);
        Some(Twice { place, ele, local: local.into() })
    });
    both.collect()
}
