//! The whole way from OpenStreetMap's elements to a Lanelet2 map with longitude and latitude.

use rayon::prelude::*;

use crate::diagnostic::Finding;
use crate::lanelet::LaneletMap;
use crate::osm::OsmData;
use crate::projection::{Extent, LonLat, Projector};
use crate::settings::Settings;

use super::assemble::{Assembled, assemble};
use super::blinker;
use super::dead_lanes::without_dead_lanes;
use super::road_network::{DrivingSide, Network, NetworkError, NetworkOptions, road_network};
use super::streets::{StreetOptions, Streets, streets};

/// What a user may decide about a build.
#[derive(Clone, Debug, Default)]
pub struct BuildOptions {
    /// Which side people drive on; from the place where absent.
    pub driving_side: Option<DrivingSide>,
    /// How to turn degrees into metres; MGRS or a transverse Mercator, whichever suits the place, where absent.
    pub projector: Option<Projector>,
    /// How roads and intersections are laid out.
    pub streets: StreetOptions,
}

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// Nothing to drive on.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The input is what this program makes.
    #[error("the input is a Lanelet2 map already ({lanelets} lanelets); `check` judges it")]
    Lanelet2Map {
        /// Relations with `type=lanelet`.
        lanelets: usize,
    },
    /// No road has a place on earth.
    #[error("no node of a road has a usable latitude and longitude")]
    NoPlace,
}

/// How much was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Summary {
    /// Roads between intersections.
    pub roads: usize,
    /// Intersections that Autoware knows as such: with an `intersection_area`.
    pub intersections: usize,
    /// Lanelets of all kinds.
    pub lanelets: usize,
    /// Regulatory elements of all kinds.
    pub regulatory_elements: usize,
    /// What the input did not say.
    pub guesses: usize,
}

/// A map and what goes beside it.
#[derive(Debug)]
pub struct Built {
    /// The map; every point has longitude and latitude.
    pub map: LaneletMap,
    /// How its metres relate to degrees.
    pub projector: Projector,
    /// What it cannot say itself.
    pub settings: Settings,
    /// What was guessed, left out or could not be built as it should.
    pub notes: Vec<Finding>,
    /// How much there is.
    pub summary: Summary,
}

/// Streets and the plane they lie in: all that a map is built from.
#[derive(Clone, Debug)]
pub struct Plan {
    /// Roads and intersections on the ground.
    pub streets: Streets,
    /// How their metres relate to degrees.
    pub projector: Projector,
    /// What was guessed or left out.
    pub notes: Vec<Finding>,
    /// How much of that the input did not say.
    pub guesses: usize,
}

/// Builds a map from OpenStreetMap's elements.
pub fn build(osm: &OsmData, options: &BuildOptions) -> Result<Built, BuildError> {
    Ok(build_plan(plan(osm, options)?))
}

/// Lays out the streets of OpenStreetMap's elements.
pub fn plan(osm: &OsmData, options: &BuildOptions) -> Result<Plan, BuildError> {
    let lanelets = osm.relations.iter().filter(|r| r.tags.is("type", "lanelet")).count();
    if lanelets > 0 {
        return Err(BuildError::Lanelet2Map { lanelets });
    }
    let projector = match options.projector {
        Some(projector) => projector,
        None => Projector::for_extent(&extent(osm)?),
    };
    let network_options = NetworkOptions { driving_side: options.driving_side, country: None };
    let to_metres = |places: &[LonLat]| projector.forward_all(places);
    let Network { network, notes } = road_network(osm, &to_metres, &network_options)?;
    Ok(Plan { streets: streets(network, &options.streets), projector, guesses: notes.len(), notes })
}

/// Builds a map from streets.
pub fn build_plan(Plan { streets, projector, mut notes, guesses }: Plan) -> Built {
    let Streets { network, outlines, findings, .. } = streets;
    let network = without_dead_lanes(network);
    notes.extend(findings);
    let Assembled { mut map, settings, notes: more, areas } = assemble(&network, &outlines);
    notes.extend(more);
    blinker::limit(&mut map);
    locate(&mut map, &projector);
    let summary = Summary {
        roads: network.roads.len(),
        intersections: areas,
        lanelets: map.lanelets.len(),
        regulatory_elements: map.regulatory_elements.len(),
        guesses,
    };
    Built { map, projector, settings, notes, summary }
}

/// The box around all nodes of ways that are roads by their tags.
fn extent(osm: &OsmData) -> Result<Extent, BuildError> {
    let roads = osm.ways.iter().filter(|w| w.tags.has("highway"));
    let places = roads.flat_map(|w| &w.nodes).filter_map(|&id| osm.node(id)?.position);
    match Extent::of(places) {
        Some(extent) => Ok(extent),
        None if osm.ways.iter().any(|w| w.tags.has("highway")) => Err(BuildError::NoPlace),
        None => Err(NetworkError::NoRoad { ways: osm.ways.len(), left_out: 0 }.into()),
    }
}

/// Gives every point its longitude and latitude.
fn locate(map: &mut LaneletMap, projector: &Projector) {
    /// Points that one thread takes at a time: some milliseconds of work.
    const CHUNK: usize = 1 << 13;
    map.points.as_mut_slice().par_chunks_mut(CHUNK).for_each(|points| {
        let places: Vec<_> = points.iter().map(|p| p.position).collect();
        let found = projector.inverse_each(&places, |i| points[i].ele.unwrap_or_default());
        for (point, lonlat) in points.iter_mut().zip(found) {
            point.lonlat = lonlat;
        }
    });
}
