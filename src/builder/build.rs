//! The whole way from OpenStreetMap's elements to a Lanelet2 map with longitude and latitude.

use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::index::reaches;
use crate::lanelet::{Lanelet, LaneletMap};
use crate::osm::{OsmData, Way};
use crate::parallel::InSmallParts;
use crate::projection::{Extent, Extents, LonLat, Projector};
use crate::settings::{MergeSettings, Profile, Settings};
use crate::xodr::OpenDrive;

use super::assemble::{Assembled, assemble};
use super::control::signal_arrows::SignalArrows;
use super::layout::layout_loop::lay_out;
use super::network::unreachable_lanes::without_unreachable_lanes;
use super::network::{
    NetworkError, NetworkOptions, NetworkReading, RoadKey, RoadNetwork, UNMET_ROAD, is_highway, road_network,
};
use super::opendrive::{FileLane, Placing, assemble_opendrive, guesses};
use super::options::{BuildOptions, Inside, Plan};
use super::postprocess::{grade_separation, shared_borders, tier4, turn_signal, user_elements};
use super::streets::consolidate::{MergeOverride, OverrideTarget};
use super::streets::heights::{ElevationTags, elevation_tags};
use super::streets::{Streets, streets};

use std::borrow::Borrow;
use std::collections::BTreeSet;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

/// Why there is no map.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum BuildError {
    /// Nothing to drive on.
    #[error(transparent)]
    Network(#[from] NetworkError),
    /// The input is a Lanelet2 map.
    #[error("the input is a Lanelet2 map already ({lanelets} lanelets); `check` judges it")]
    Lanelet2Map {
        /// Relations with `type=lanelet`.
        lanelets: usize,
    },
    /// No road has a place on earth.
    #[error("no node of a road has a usable latitude and longitude")]
    NoPlace,
    /// An OpenDRIVE file without lanes for vehicles.
    #[error("none of the {roads} roads has a lane for vehicles with a reference line and a width{}", in_brackets(.first))]
    NoLane {
        /// How many roads there are.
        roads: usize,
        /// The first fault of the file, which may be why.
        first: Option<String>,
    },
}

/// How much was built.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct Summary {
    /// Roads between intersections.
    pub roads: usize,
    /// Intersections with an `intersection_area`: Autoware knows no others.
    pub intersections: usize,
    /// Lanelets of all kinds.
    pub lanelets: usize,
    /// Regulatory elements of all kinds.
    pub regulatory_elements: usize,
    /// Values that were guessed because the input lacks them.
    pub guesses: usize,
}

/// A map and what goes beside it.
#[derive(Debug)]
pub struct Built {
    /// The map.
    pub map: LaneletMap,
    /// How its metres relate to degrees.
    pub projector: Projector,
    /// What the map format cannot express.
    pub settings: Settings,
    /// What was guessed, left out or could not be built as it should.
    pub notes: Vec<Finding>,
    /// How much there is.
    pub summary: Summary,
    /// Ids that two elements of this map have; the next build gives them to neither.
    pub contested: Vec<i64>,
    /// Where lanelets stand in the OpenDRIVE file, in order of their ids; none for other inputs.
    pub file_lanes: Vec<FileLane>,
}

/// Builds a map from OpenStreetMap's elements; every point has longitude and latitude.
///
/// # Errors
/// There is nothing to drive on, it has no place on earth, or the elements are a Lanelet2 map.
pub fn build(osm: &OsmData, options: &BuildOptions) -> Result<Built, BuildError> {
    let mut built = uncontested(&options.contested, |contested| {
        let options = BuildOptions { contested: contested.clone(), ..options.clone() };
        plan(osm, &options).map(build_plan)
    })?;
    built.map.place_on_globe(&built.projector);
    Ok(built)
}

/// Builds a map again as long as two elements have the same id, so that neither gets it. Ids are hashes: two polygons have the
/// same id about once among tens of thousands of intersections; other elements about once among ten thousand maps with a million
/// elements each.
///
/// # Errors
/// The errors of `build`.
pub fn uncontested<E>(
    known: &BTreeSet<i64>,
    mut build: impl FnMut(&BTreeSet<i64>) -> Result<Built, E>,
) -> Result<Built, E> {
    const ROUNDS: usize = 4;
    let mut contested = known.clone();
    let mut built = build(&contested)?;
    for _ in 1..ROUNDS {
        if built.contested.is_empty() {
            return Ok(built);
        }
        contested.extend(&built.contested);
        built = build(&contested)?;
    }
    // Two elements have the same key, which should not happen.
    built.map.drop_repeats();
    Ok(built)
}

/// Lays out the streets of OpenStreetMap's elements. Elements that are passed by value are freed as soon as they are read.
///
/// # Errors
/// As [`build`].
pub fn plan(osm: impl Borrow<OsmData> + Send, options: &BuildOptions) -> Result<Plan, BuildError> {
    let read = read(osm.borrow(), options)?;
    Ok(rayon::join(|| laid_out(read, options), || drop(osm)).0)
}

/// The roads of OpenStreetMap's elements.
struct Read {
    network: RoadNetwork,
    notes: Vec<Finding>,
    spots: ElevationTags,
    projector: Projector,
}

fn read(osm: &OsmData, options: &BuildOptions) -> Result<Read, BuildError> {
    let lanelets = osm.relations.iter().filter(|r| r.tags.is("type", "lanelet")).count();
    if lanelets > 0 {
        return Err(BuildError::Lanelet2Map { lanelets });
    }
    let projector = match options.projector {
        Some(projector) => projector,
        None => Projector::for_extent(&extent(osm)?),
    };
    let network_options = NetworkOptions {
        driving_side: options.driving_side,
        country: options.country.clone(),
        assume: options.assume.clone(),
        roads: options.roads.clone(),
    };
    let to_metres = |places: &[LonLat]| projector.forward_all(places);
    let NetworkReading { network, notes } = road_network(osm, &to_metres, &network_options)?;
    let is_road = |way: &Way| is_highway(way, &options.roads);
    let spots = elevation_tags(osm, &to_metres, is_road, options.terrain.is_none());
    Ok(Read { network, notes, spots, projector })
}

fn laid_out(Read { mut network, mut notes, spots, projector }: Read, options: &BuildOptions) -> Plan {
    let mut wishes: Vec<Finding> = notes.extract_if(.., |note| note.fault == UNMET_ROAD).collect();
    network.beside = options.beside;
    network.markings = options.markings;
    network.fan_out = options.inside.everywhere.fan_out.unwrap_or_default();
    let mut street_options = options.streets.clone();
    street_options
        .consolidate
        .wishes
        .splice(0..0, options.merges.iter().map(|(said, merge)| wish(said, *merge, &projector)));
    street_options.heights.spots = spots;
    if let Some(terrain) = options.terrain.clone() {
        let at = move |points: &[Point]| {
            let places = projector.inverse_each(points, |_| 0.0);
            let known: Vec<LonLat> = places.iter().flatten().copied().collect();
            let mut heights = terrain.at(&known).into_iter();
            places.iter().map(|place| place.and_then(|_| heights.next().flatten())).collect()
        };
        street_options.heights.terrain = Some(Arc::new(at));
    }
    let mut streets = streets(network, &street_options);
    let unmet = (0..options.merges.len()).filter(|i| !streets.merges.iter().any(|note| note.wish == Some(*i)));
    wishes.extend(unmet.map(|i| merge_without_effect(&options.merges[i])));
    wishes.extend(overruled_wishes(&streets, &options.merges));
    streets.findings.extend(wishes);
    let (inside, heights) = (options.inside.clone(), options.streets.heights.clone());
    Plan {
        streets,
        projector,
        guesses: notes.len(),
        notes,
        inside,
        heights,
        profile: options.profile,
        contested: options.contested.clone(),
    }
}

/// The merge or `keep_apart` of a user, in the metres of the map.
fn wish(said: &MergeSettings, merge: bool, projector: &Projector) -> MergeOverride {
    let of = match *said {
        MergeSettings { at: Some([lat, lon]), .. } => {
            // A place that the projection does not reach has no road near it.
            let nowhere = Point::new(f64::INFINITY, f64::INFINITY);
            OverrideTarget::Near(projector.forward(LonLat { lon, lat }, 0.0).unwrap_or(nowhere))
        }
        MergeSettings { way: Some(way), .. } => OverrideTarget::Way(way),
        MergeSettings { ref nodes, .. } => OverrideTarget::Nodes(nodes.clone()),
    };
    MergeOverride { of, merge }
}

/// Findings about roads that the user keeps apart and that lie inside an intersection all the same, because other roads merge the
/// intersections at their ends.
fn overruled_wishes(streets: &Streets, merges: &[(MergeSettings, bool)]) -> Vec<Finding> {
    let intersections = &streets.network.intersections;
    let inside: FxHashSet<RoadKey> = intersections.iter().flat_map(|i| &i.inner).map(|inner| inner.key).collect();
    let overruled = streets.merges.iter().filter(|note| !note.merged && inside.contains(&note.key));
    let told = overruled.filter_map(|note| {
        let (said, _) = merges.get(note.wish?)?;
        let message = format!(
            "{}[[keep_apart]] is overruled for way {}, nodes {} to {}: other roads merge its ends; keep them apart too",
            place_of(said),
            note.key.way,
            note.key.first,
            note.key.last
        );
        Some(Finding::new(MERGE_UNMET, Subject::Way(note.key.way), message).graded(Severity::Warning))
    });
    told.collect()
}

/// The file and line of a user's entry, as the begin of a message.
fn place_of(said: &MergeSettings) -> String {
    said.origin.as_ref().map_or_else(String::new, |origin| format!("{}:{}: ", origin.file, origin.line))
}

/// Slug of the finding about an entry that names no road, or that has no effect.
pub const MERGE_UNMET: &str = "merge-unmet";

fn merge_without_effect((said, merge): &(MergeSettings, bool)) -> Finding {
    let key = if *merge { "merge" } else { "keep_apart" };
    let place = place_of(said);
    let message = match said {
        MergeSettings { at: Some([lat, lon]), .. } => format!("no road lies at {lat}, {lon}"),
        MergeSettings { way: Some(way), .. } => format!("no road is made from way {way}"),
        MergeSettings { nodes, .. } => {
            let nodes: Vec<String> = nodes.iter().map(ToString::to_string).collect();
            format!("no road between two intersections lies between the nodes {}", nodes.join(", "))
        }
    };
    Finding::new(MERGE_UNMET, Subject::Map, format!("{place}[[{key}]] does nothing: {message}"))
        .graded(Severity::Warning)
}

/// Builds a map from streets. Its points have no longitude and latitude before [`LaneletMap::place_on_globe`].
pub fn build_plan(Plan { streets, projector, mut notes, guesses, inside, heights, profile, contested }: Plan) -> Built {
    let Streets { network, outlines, merges, findings } = streets;
    // Only `outlines.kept` is needed from here on.
    drop(outlines.intersections);
    let (network, kept, unreachable) = without_unreachable_lanes(network, outlines.kept);
    notes.extend(findings);
    notes.extend(unreachable);
    let apart = merges.iter().filter(|note| note.wish.is_some() && !note.merged).map(|note| note.key).collect();
    let (layout, more) = lay_out(network, kept, &apart, &heights, contested);
    notes.extend(more);
    let assembled = assemble(layout, &SignalArrows::new(&inside, &projector));
    finished(assembled, projector, (notes, guesses), &inside, profile)
}

/// Subtypes of the lanelets that vehicles drive on.
const ROADS: [&str; 2] = ["road", "bus_lane"];

/// Builds a map from an OpenDRIVE file: its lanes are those of the file.
///
/// # Errors
/// There is no lane for vehicles in it.
pub fn build_opendrive(file: &OpenDrive, options: &BuildOptions, placing: Placing) -> Result<Built, BuildError> {
    let mut built = uncontested(&options.contested, |contested| {
        let options = BuildOptions { contested: contested.clone(), ..options.clone() };
        let (assembled, projector, file_lanes) = assemble_opendrive(file, &options, placing);
        let driven = |lanelet: &Lanelet| ROADS.iter().any(|subtype| lanelet.attributes.is("subtype", subtype));
        if !assembled.map.lanelets.iter().any(driven) {
            let first = assembled.notes.iter().find(|note| note.severity != Some(Severity::Info));
            return Err(BuildError::NoLane { roads: file.roads.len(), first: first.map(|note| note.message.clone()) });
        }
        let guesses = guesses(&assembled.notes);
        let built = finished(assembled, projector, (Vec::new(), guesses), &options.inside, options.profile);
        Ok(Built { file_lanes, ..built })
    })?;
    built.map.place_on_globe(&built.projector);
    Ok(built)
}

/// What only the whole map tells.
fn finished(
    assembled: Assembled,
    projector: Projector,
    (mut notes, guesses): (Vec<Finding>, usize),
    inside: &Inside,
    profile: Profile,
) -> Built {
    let Assembled { mut map, mut settings, notes: more, areas, roads } = assembled;
    notes.extend(more);
    shared_borders::share_borders(&mut map);
    let reaches = reaches(&map);
    turn_signal::limit_turn_signals(&mut map, &reaches);
    grade_separation::ignore_other_levels(&mut map, &reaches);
    drop(reaches);
    notes.extend(user_elements::draw(&mut map, &projector, inside, &mut settings));
    settings.sort();
    if profile == Profile::Tier4 {
        tier4::suit_validator(&mut map, &mut settings);
    }
    let summary = Summary {
        roads,
        intersections: areas,
        lanelets: map.lanelets.len(),
        regulatory_elements: map.regulatory_elements.len(),
        guesses,
    };
    let contested = map.repeated_ids();
    Built { map, projector, settings, notes, summary, contested, file_lanes: Vec::new() }
}

fn in_brackets(text: &Option<String>) -> String {
    text.as_ref().map(|text| format!(" ({text})")).unwrap_or_default()
}

/// The box around all nodes of ways that are roads by their tags.
fn extent(osm: &OsmData) -> Result<Extent, BuildError> {
    let roads = osm.ways.par_iter().in_small_parts().filter(|w| w.tags.has("highway"));
    let around = |w: &Way| {
        let places = w.nodes.iter().filter_map(|&id| osm.node(id)?.position);
        places.map(Extents::of).reduce(Extents::with)
    };
    match roads.filter_map(around).reduce_with(Extents::with) {
        Some(extents) => Ok(extents.narrower()),
        None if osm.ways.iter().any(|w| w.tags.has("highway")) => Err(BuildError::NoPlace),
        None => Err(NetworkError::NoRoad { ways: osm.ways.len(), left_out: 0, first: None }.into()),
    }
}
