//! Features to a road network, with what they leave out filled in.

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

/// What the features are, beside the network: the shapes of its intersections and the ends of its roads, as the file
/// has them.
pub struct FileNetwork<'a> {
    pub network: RoadNetwork,
    pub rings: Rings<'a>,
}

/// Where a road meets nothing that the file names.
const LOOSE: [&str; 2] = ["start", "end"];

/// A road with its key, and the intersections at its ends.
type Keyed<'a> = (RoadKey, &'a Spanned<Feature<RoadShape>>, [IntersectionIx; 2]);

/// Puts the network together.
pub fn network<'a>(
    parsed: &'a Parsed,
    options: &BuildOptions,
    notes: &mut Vec<Finding>,
) -> Result<FileNetwork<'a>, ReadError> {
    let place = driving_side::of_place(middle(parsed));
    let head = parsed.head.as_ref();
    let side = options.driving_side.or(head.and_then(|head| head.driving_side)).unwrap_or(place.side);
    let country = head.and_then(|head| head.country.clone()).or(place.country);

    let attached = attached(parsed);
    let ends: Vec<[FeatureId; 2]> = parsed.roads.iter().map(|road| ends(&road.it, &attached)).collect();
    let nodes = nodes(parsed, &ends)?;
    let at: FxHashMap<&FeatureId, IntersectionIx> =
        nodes.iter().zip(0..).map(|(node, i)| (&node.id, IntersectionIx(i))).collect();
    let mut lanes: FxHashMap<&FeatureId, Vec<_>> = FxHashMap::default();
    for lane in &parsed.lanes {
        lanes.entry(&lane.it.road).or_default().push(lane);
    }

    let mut keyed: Vec<Keyed<'_>> = Vec::new();
    for (site, [src, dst]) in parsed.roads.iter().zip(&ends) {
        let ends = [src, dst].map(|id| at.get(id).copied());
        let [Some(src_ix), Some(dst_ix)] = ends else {
            let lost = if ends[0].is_none() { src } else { dst };
            let message =
                format!("road {} ends at intersection {}, which is not in the file", site.it.properties.id.0, lost.0);
            return Err(ReadError::new(
                site.offset,
                message,
                "add the intersection, or leave src or dst out where the map ends",
            ));
        };
        keyed.push((
            key(&site.it.properties, [&nodes[src_ix.0 as usize], &nodes[dst_ix.0 as usize]]),
            site,
            [src_ix, dst_ix],
        ));
    }
    keyed.sort_by(|a, b| a.0.cmp(&b.0).then_with(|| a.1.it.properties.id.cmp(&b.1.it.properties.id)));
    tell_apart(&mut keyed)?;

    let customs = Customs { side, country: country.as_deref(), assume: &options.assume };
    let mut roads = Vec::with_capacity(keyed.len());
    let mut by_id: FxHashMap<&FeatureId, RoadIx> = FxHashMap::default();
    for (i, (key, site, ends)) in keyed.iter().enumerate() {
        let id = &site.it.properties.id;
        let own = lanes.remove(id).unwrap_or_default();
        if by_id.insert(id, RoadIx(i as u32)).is_some() {
            let message = format!("two roads have the id {}", id.0);
            return Err(ReadError::new(site.offset, message, "give each road an id of its own"));
        }
        roads.push(road(site, *key, *ends, &own, &customs, notes)?);
    }
    let intersections = intersections(&nodes, &roads, &by_id)?;
    let restrictions = restrictions(parsed, &by_id)?;
    let connections = connections(parsed, &by_id)?;
    let network =
        RoadNetwork { side, country, roads, intersections, restrictions, connections, ..RoadNetwork::default() };
    let rings = Rings {
        roads: keyed.iter().map(|(_, site, _)| &site.it.properties).collect(),
        intersections: nodes.iter().map(|node| node.feature.map(|feature| &feature.it)).collect(),
    };
    Ok(FileNetwork { network, rings })
}

/// The middle of the box around all roads.
fn middle(parsed: &Parsed) -> crate::projection::LonLat {
    let points = parsed.roads.iter().flat_map(|road| points_of(&road.it));
    let (low, high) = points
        .fold((Point::new(f64::MAX, f64::MAX), Point::new(f64::MIN, f64::MIN)), |(low, high), p| {
            (Point::new(low.x.min(p.x), low.y.min(p.y)), Point::new(high.x.max(p.x), high.y.max(p.y)))
        });
    parsed.projector.inverse(nalgebra::center(&low, &high)).unwrap_or_default()
}

/// The intersections that name a road, by the road's id.
fn attached(parsed: &Parsed) -> FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>> {
    let mut found: FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>> = FxHashMap::default();
    for intersection in &parsed.intersections {
        for road in &intersection.it.properties.roads {
            found.entry(road).or_default().push(&intersection.it);
        }
    }
    found
}

/// The intersections at both ends of a road: as it says; else those that name it, each at the end it is nearer to;
/// else one of its own, where the map ends.
fn ends(
    road: &Feature<RoadShape>,
    attached: &FxHashMap<&FeatureId, Vec<&Feature<IntersectionShape>>>,
) -> [FeatureId; 2] {
    let shape = &road.properties;
    if let (Some(src), Some(dst)) = (&shape.src, &shape.dst) {
        return [src.clone(), dst.clone()];
    }
    let line = points_of(road);
    let said = [&shape.src, &shape.dst];
    let known = attached.get(&shape.id).map_or(&[][..], Vec::as_slice);
    let nearer = |end: usize| {
        let other = said[1 - end].as_ref();
        let (here, there) = if end == 0 { (line.first()?, line.last()?) } else { (line.last()?, line.first()?) };
        let candidates = known.iter().filter(|i| Some(&i.properties.id) != other);
        candidates
            .filter_map(|i| Some((centre(i)?, &i.properties.id)))
            .filter(|(p, _)| (p - here).norm() <= (p - there).norm())
            .min_by(|a, b| (a.0 - here).norm().total_cmp(&(b.0 - here).norm()))
            .map(|(_, id)| id.clone())
    };
    [0, 1].map(|end| {
        let loose = || FeatureId(Text::from(format!("{} {}", shape.id.0, LOOSE[end])));
        said[end].clone().or_else(|| nearer(end)).unwrap_or_else(loose)
    })
}

/// All intersections at which a road ends, and those where the map ends, in order of their smallest node.
fn nodes<'a>(parsed: &'a Parsed, ends: &[[FeatureId; 2]]) -> Result<Vec<Node<'a>>, ReadError> {
    let mut features: FxHashMap<&FeatureId, &Spanned<Feature<IntersectionShape>>> = FxHashMap::default();
    for feature in &parsed.intersections {
        let id = &feature.it.properties.id;
        if features.insert(id, feature).is_some() {
            let message = format!("two intersections have the id {}", id.0);
            return Err(ReadError::new(feature.offset, message, "give each intersection an id of its own"));
        }
    }
    let loose = parsed.roads.iter().zip(ends).flat_map(|(road, ends)| {
        let name = |end: usize| FeatureId(Text::from(format!("{} {}", road.it.properties.id.0, LOOSE[end])));
        [0, 1].into_iter().filter(move |&end| ends[end] == name(end)).map(|end| ends[end].clone())
    });
    let used: std::collections::BTreeSet<&FeatureId> = ends.iter().flatten().collect();
    let named = used.into_iter().filter_map(|id| features.get(id)).copied();
    let mut nodes: Vec<Node<'a>> = named
        .map(|feature| {
            let shape = &feature.it.properties;
            let mut nodes = shape.merged_from.clone();
            nodes.sort_unstable();
            if nodes.is_empty() {
                nodes.push(shape.id.0.parse().unwrap_or_else(|_| number("intersection", &shape.id.0)));
            }
            Node { id: shape.id.clone(), nodes, feature: Some(feature) }
        })
        .collect();
    nodes.extend(loose.filter(|id| !features.contains_key(id)).map(|id| Node {
        nodes: vec![number("intersection", &id.0)],
        id,
        feature: None,
    }));
    nodes.sort_by(|a, b| a.nodes.cmp(&b.nodes).then_with(|| a.id.cmp(&b.id)));
    Ok(nodes)
}

/// What tells a road from all others: as the file says, else from the ways and nodes it is made of.
fn key(shape: &RoadShape, ends: [&Node<'_>; 2]) -> RoadKey {
    let [first, last] = ends.map(|node| node.nodes.first().copied().unwrap_or_default());
    shape.key.map_or_else(
        || {
            let way = shape.osm_ids.first().copied().unwrap_or_else(|| number("road", &shape.id.0));
            RoadKey { way, first, last, turn: 0 }
        },
        RoadKey::from,
    )
}

/// Numbers the roads that have the same key; those that say their key must not.
fn tell_apart(keyed: &mut [Keyed<'_>]) -> Result<(), ReadError> {
    let mut turn = 0;
    for i in 1..keyed.len() {
        let same = RoadKey { turn: 0, ..keyed[i].0 } == RoadKey { turn: 0, ..keyed[i - 1].0 };
        let (site, said) = (keyed[i].1, keyed[i].1.it.properties.key.is_some());
        if !same {
            turn = 0;
        } else if !said {
            turn = keyed[i - 1].0.turn.max(turn) + 1;
            keyed[i].0.turn = turn;
        } else if keyed[i].0 <= keyed[i - 1].0 {
            let message = format!("road {} has the key of another", site.it.properties.id.0);
            return Err(ReadError::new(site.offset, message, "leave `key` out, or number the roads by its `turn`"));
        }
    }
    Ok(())
}
