//! Builds a road network from features and fills in what they omit.

use crate::builder::BuildOptions;
use crate::builder::network::{IntersectionIx, RoadIx, RoadKey, RoadNetwork};
use crate::builder::tags::cross_section::Customs;
use crate::builder::tags::driving_side;
use crate::diagnostic::Finding;
use crate::geometry::Point;
use crate::osm::Text;

use super::ReadError;
use super::id::FeatureId;
use super::parse::{Parsed, Spanned};
use super::read_intersections::{connections, intersections, restrictions};
use super::read_road::road;
use super::schema::{Feature, IntersectionShape, RoadShape};
use super::values::{Node, Rings, centre, number, points_of};

use rustc_hash::FxHashMap;

/// A network and the features that its roads and intersections come from.
pub struct FileNetwork<'a> {
    pub network: RoadNetwork,
    pub rings: Rings<'a>,
}

/// The names of road ends at which the file has no intersection.
const OPEN_ENDS: [&str; 2] = ["start", "end"];

/// A road feature with its key and the intersections at its ends.
type KeyedRoad<'a> = (RoadKey, &'a Spanned<Feature<RoadShape>>, [IntersectionIx; 2]);

/// Builds the network.
///
/// # Errors
///
/// Two features have the same id or key, or a feature names a road or intersection that is not in the file.
pub fn network<'a>(
    parsed: &'a Parsed,
    options: &BuildOptions,
    notes: &mut Vec<Finding>,
) -> Result<FileNetwork<'a>, ReadError> {
    let place = driving_side::of_place(middle(parsed));
    let header = parsed.header.as_ref();
    let side = options.driving_side.or(header.and_then(|header| header.driving_side)).unwrap_or(place.side);
    let country = header.and_then(|header| header.country.clone()).or(place.country);

    let attached = attached(parsed);
    let ends: Vec<[FeatureId; 2]> = parsed.roads.iter().map(|road| ends(&road.value, &attached)).collect();
    let nodes = nodes(parsed, &ends)?;
    let keyed = keyed_roads(parsed, &ends, &nodes)?;
    let mut lanes: FxHashMap<&FeatureId, Vec<_>> = FxHashMap::default();
    for lane in &parsed.lanes {
        lanes.entry(&lane.value.road).or_default().push(lane);
    }
    let customs = Customs { side, country: country.as_deref(), assume: &options.assume };
    let mut roads = Vec::with_capacity(keyed.len());
    let mut by_id: FxHashMap<&FeatureId, RoadIx> = FxHashMap::default();
    for (i, (key, feature, ends)) in keyed.iter().enumerate() {
        let id = &feature.value.properties.id;
        let own_lanes = lanes.remove(id).unwrap_or_default();
        if by_id.insert(id, RoadIx(i as u32)).is_some() {
            let message = format!("two roads have the id {}", id.0);
            return Err(ReadError::new(feature.offset, message, "give each road an id of its own"));
        }
        roads.push(road(feature, *key, *ends, &own_lanes, &customs, notes)?);
    }
    let intersections = intersections(&nodes, &roads, &by_id)?;
    let restrictions = restrictions(parsed, &by_id)?;
    let connections = connections(parsed, &by_id)?;
    let network =
        RoadNetwork { side, country, roads, intersections, restrictions, connections, ..RoadNetwork::default() };
    let rings = Rings {
        roads: keyed.iter().map(|(_, feature, _)| &feature.value.properties).collect(),
        intersections: nodes.iter().map(|node| node.feature.map(|feature| &feature.value)).collect(),
    };
    Ok(FileNetwork { network, rings })
}

/// The road features sorted by their keys, which are unique.
fn keyed_roads<'a>(
    parsed: &'a Parsed,
    ends: &[[FeatureId; 2]],
    nodes: &[Node<'_>],
) -> Result<Vec<KeyedRoad<'a>>, ReadError> {
    let intersections: FxHashMap<&FeatureId, IntersectionIx> =
        nodes.iter().zip(0..).map(|(node, i)| (&node.id, IntersectionIx(i))).collect();
    let mut keyed: Vec<KeyedRoad<'a>> = Vec::new();
    for (feature, [src, dst]) in parsed.roads.iter().zip(ends) {
        let shape = &feature.value.properties;
        let found = [src, dst].map(|id| intersections.get(id).copied());
        let [Some(src_ix), Some(dst_ix)] = found else {
            let missing = if found[0].is_none() { src } else { dst };
            let message = format!("road {} ends at intersection {}, which is not in the file", shape.id.0, missing.0);
            let help = "add the intersection, or leave src or dst out where the map ends";
            return Err(ReadError::new(feature.offset, message, help));
        };
        let ends = [src_ix, dst_ix];
        keyed.push((key(shape, ends.map(|ix| &nodes[ix.0 as usize])), feature, ends));
    }
    keyed.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.value.properties.id.cmp(&b.1.value.properties.id)));
    make_unique(&mut keyed)?;
    Ok(keyed)
}

/// The middle of the bounding box of all roads.
fn middle(parsed: &Parsed) -> crate::projection::LonLat {
    let points = parsed.roads.iter().flat_map(|road| points_of(&road.value));
    let (low, high) = points
        .fold((Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN)), |(low, high), p| {
            (Point::new(low.x.min(p.x), low.y.min(p.y)), Point::new(high.x.max(p.x), high.y.max(p.y)))
        });
    parsed.projector.inverse(nalgebra::center(&low, &high)).unwrap_or_default()
}

/// The intersections that list a road in `roads`, by the road's id.
fn attached(parsed: &Parsed) -> FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>> {
    let mut found: FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>> = FxHashMap::default();
    for intersection in &parsed.intersections {
        for road in &intersection.value.properties.roads {
            found.entry(road).or_default().push(&intersection.value);
        }
    }
    found
}

/// The intersections at both ends of a road: `src` and `dst`; else the intersection that lists the road and is nearer to this
/// end than to the other; else an intersection at the edge of the map.
fn ends(
    road: &Feature<RoadShape>,
    attached: &FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>>,
) -> [FeatureId; 2] {
    let shape = &road.properties;
    if let (Some(src), Some(dst)) = (&shape.src, &shape.dst) {
        return [src.clone(), dst.clone()];
    }
    let line = points_of(road);
    let in_file = [&shape.src, &shape.dst];
    let candidates = attached.get(&shape.id).map_or(&[][..], Vec::as_slice);
    let nearer = |end: usize| {
        let other = in_file[1 - end].as_ref();
        let (here, there) = if end == 0 { (line.first()?, line.last()?) } else { (line.last()?, line.first()?) };
        candidates
            .iter()
            .filter(|i| Some(&i.properties.id) != other)
            .filter_map(|i| Some((centre(i)?, &i.properties.id)))
            .filter(|(p, _)| (p - here).norm() <= (p - there).norm())
            .min_by(|a, b| (a.0 - here).norm().total_cmp(&(b.0 - here).norm()))
            .map(|(_, id)| id.clone())
    };
    [0, 1].map(|end| in_file[end].clone().or_else(|| nearer(end)).unwrap_or_else(|| open_end(shape, end)))
}

/// The id of the intersection at an end of a road where the map ends.
fn open_end(road: &RoadShape, end: usize) -> FeatureId {
    FeatureId(Text::from(format!("{} {}", road.id.0, OPEN_ENDS[end])))
}

/// All intersections at which a road ends, sorted by their smallest node.
fn nodes<'a>(parsed: &'a Parsed, ends: &[[FeatureId; 2]]) -> Result<Vec<Node<'a>>, ReadError> {
    let mut features: FxHashMap<&FeatureId, &Spanned<Feature<IntersectionShape>>> = FxHashMap::default();
    for feature in &parsed.intersections {
        let id = &feature.value.properties.id;
        if features.insert(id, feature).is_some() {
            let message = format!("two intersections have the id {}", id.0);
            return Err(ReadError::new(feature.offset, message, "give each intersection an id of its own"));
        }
    }
    let open_ends = parsed.roads.iter().zip(ends).flat_map(|(road, ends)| {
        let is_open = move |&end: &usize| ends[end] == open_end(&road.value.properties, end);
        [0, 1].into_iter().filter(is_open).map(|end| ends[end].clone())
    });
    let used: std::collections::BTreeSet<&FeatureId> = ends.iter().flatten().collect();
    let named = used.into_iter().filter_map(|id| features.get(id)).copied();
    let mut nodes: Vec<Node<'a>> = named
        .map(|feature| {
            let shape = &feature.value.properties;
            let mut nodes = shape.merged_from.clone();
            nodes.sort_unstable();
            if nodes.is_empty() {
                nodes.push(shape.id.0.parse().unwrap_or_else(|_| number("intersection", &shape.id.0)));
            }
            Node { id: shape.id.clone(), nodes, feature: Some(feature) }
        })
        .collect();
    nodes.extend(open_ends.filter(|id| !features.contains_key(id)).map(|id| Node {
        nodes: vec![number("intersection", &id.0)],
        id,
        feature: None,
    }));
    nodes.sort_by(|a, b| a.nodes.cmp(&b.nodes).then_with(|| a.id.cmp(&b.id)));
    Ok(nodes)
}

/// The key of a road: the property, else by its way and the nodes at its ends.
fn key(shape: &RoadShape, ends: [&Node<'_>; 2]) -> RoadKey {
    let [first, last] = ends.map(|node| node.nodes.first().copied().unwrap_or_default());
    let way = || shape.osm_ids.first().copied().unwrap_or_else(|| number("road", &shape.id.0));
    shape.key.map_or_else(|| RoadKey { way: way(), first, last, turn: 0 }, RoadKey::from)
}

/// Numbers the roads that have the same key. Two keys of the file must not be the same.
fn make_unique(keyed: &mut [KeyedRoad<'_>]) -> Result<(), ReadError> {
    let mut turn = 0;
    for i in 1..keyed.len() {
        let same = RoadKey { turn: 0, ..keyed[i].0 } == RoadKey { turn: 0, ..keyed[i - 1].0 };
        let feature = keyed[i].1;
        let shape = &feature.value.properties;
        if !same {
            turn = 0;
        } else if shape.key.is_none() {
            turn = keyed[i - 1].0.turn.max(turn) + 1;
            keyed[i].0.turn = turn;
        } else if keyed[i].0 <= keyed[i - 1].0 {
            let message = format!("road {} has the key of another", shape.id.0);
            return Err(ReadError::new(feature.offset, message, "leave `key` out, or number the roads by its `turn`"));
        }
    }
    Ok(())
}
