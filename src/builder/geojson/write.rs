//! Writes streets as GeoJSON, one feature per line.

use std::io::{self, Write};
use std::ops::Range;

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::network::{
    End, Feature as Furniture, FeatureKind, InnerRoad, Intersection, IntersectionIx, Island, LaneConnection, Road,
    RoadEnd, RoadIx, RoadKey, RoadNetwork, TurnRestriction,
};
use crate::builder::streets::outline::{MITER_LIMIT, Outline, OutlineCase, Outlines};
use crate::builder::tags::cross_section::{CrossSection, Strip, StripKind};
use crate::geometry::{Point, Polyline, curve};
use crate::osm::Text;
use crate::parallel::InSmallParts;
use crate::projection::{LonLat, Projector};

use super::encoding::{EncodedPositions, rounded};
use super::header::Header;
use super::id::{FeatureId, FeaturePlace};
use super::schema::{
    ArmShape, ConnectionShape, EndShape, Feature, FurnitureKind, FurnitureShape, Geometry, InnerShape,
    IntersectionShape, IslandShape, LaneShape, Levels, Placed, RestrictionShape, RoadShape, StripShape, Type,
};

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A position has no longitude and latitude.
    #[error("the projection {0} has no longitude and latitude for some of the streets")]
    OutOfReach(&'static str),
    /// A number is not finite.
    #[error("a number of the streets cannot be written: {0}")]
    Number(#[from] serde_json::Error),
    /// The output failed.
    #[error(transparent)]
    Output(#[from] io::Error),
}

/// The number of roads or intersections that one thread encodes at a time.
const CHUNK: usize = 16;
/// The number of chunks that are encoded while the batch before is written.
const BATCH: usize = 32;
/// The text between two features.
const SEPARATOR: &[u8] = b",\n";
/// Lengths and widths that `build` does not read are rounded to a tenth of a millimetre.
const PER_METRE: f64 = 1e4;

/// Writes the file. `projector` turns metres into longitude and latitude.
///
/// # Errors
///
/// The output fails, a number is not finite, or a position lies outside the projection.
pub fn write(
    network: &RoadNetwork,
    outlines: &Outlines,
    projector: &Projector,
    mut out: impl Write + Send,
) -> Result<(), WriteError> {
    let restrictions = by_intersection(network, &network.restrictions, |restriction| restriction.from);
    let connections = by_intersection(network, &network.connections, |connection| connection.from);
    let ids = network.roads.par_iter().in_small_parts().map(|road| road_id(&road.key)).collect();
    let streets = &Streets { network, outlines, projector, ids, restrictions, connections };
    out.write_all(b"{\"type\":\"FeatureCollection\",\"lanewright\":")?;
    out.write_all(&serde_json::to_vec(&Header::new(network, projector))?)?;
    out.write_all(b",\"features\":[\n")?;
    let roads = chunks(network.roads.len()).map(Chunk::Roads);
    let chunks: Vec<Chunk> = roads.chain(chunks(network.intersections.len()).map(Chunk::Intersections)).collect();
    // One batch is written while the next is encoded. The two sets of buffers are used in turn.
    let [mut ready, mut next] = [(); 2].map(|()| vec![Vec::new(); BATCH]);
    let mut count = 0;
    for batch in chunks.chunks(BATCH) {
        let encode =
            || batch.par_iter().in_small_parts().zip(&mut next).try_for_each(|(chunk, out)| streets.put(chunk, out));
        let (written, encoded) = rayon::join(|| ready[..count].iter().try_for_each(|text| out.write_all(text)), encode);
        written?;
        encoded?;
        std::mem::swap(&mut ready, &mut next);
        count = batch.len();
    }
    if let Some(last) = ready[..count].last_mut() {
        last.truncate(last.len() - SEPARATOR.len());
    }
    ready[..count].iter().try_for_each(|text| out.write_all(text))?;
    out.write_all(b"\n]}\n")?;
    Ok(out.flush()?)
}

/// Features that one thread encodes at a time.
enum Chunk {
    Roads(Range<usize>),
    Intersections(Range<usize>),
}

fn chunks(count: usize) -> impl Iterator<Item = Range<usize>> {
    (0..count).step_by(CHUNK).map(move |start| start..(start + CHUNK).min(count))
}

/// The streets to write. Restrictions and lane connections are sorted by the intersection at which they begin.
struct Streets<'a> {
    network: &'a RoadNetwork,
    outlines: &'a Outlines,
    projector: &'a Projector,
    /// The id of each road.
    ids: Vec<FeatureId>,
    restrictions: FxHashMap<IntersectionIx, Vec<&'a TurnRestriction>>,
    connections: FxHashMap<IntersectionIx, Vec<&'a LaneConnection>>,
}

/// The items of each intersection, sorted. An item belongs to the intersection at the road end where it begins.
fn by_intersection<'a, T: Ord>(
    network: &RoadNetwork,
    items: &'a [T],
    from: impl Fn(&T) -> RoadEnd,
) -> FxHashMap<IntersectionIx, Vec<&'a T>> {
    let mut found: FxHashMap<IntersectionIx, Vec<&T>> = FxHashMap::default();
    for item in items {
        let RoadEnd { road, end } = from(item);
        found.entry(network.road(road).intersection(end)).or_default().push(item);
    }
    found.values_mut().for_each(|items| items.sort_unstable());
    found
}

impl Streets<'_> {
    /// Replaces `out` by the text of a chunk, with a separator after each feature.
    fn put(&self, chunk: &Chunk, out: &mut Vec<u8>) -> Result<(), WriteError> {
        out.clear();
        match chunk {
            Chunk::Roads(range) => self.put_roads(range.clone(), out),
            Chunk::Intersections(range) => self.put_intersections(range.clone(), out),
        }
    }

    fn put_roads(&self, range: Range<usize>, out: &mut Vec<u8>) -> Result<(), WriteError> {
        let mut roads: Vec<(Feature<RoadShape>, Edges)> = Vec::with_capacity(range.len());
        // Neighbouring lanes share an edge, and the road shares its outermost edges: each is projected and encoded once.
        let mut points: Vec<Point> = Vec::new();
        for i in range.clone() {
            let road = &self.network.roads[i];
            let [from, to] = self.outlines.kept[i];
            let line = road.line.cut(from, to);
            let edges = (0..=road.section.strips.len()).map(|edge| {
                let edge = line.as_ref()?.offset(road.section.edge(edge), MITER_LIMIT)?;
                let before = points.len();
                points.extend(curve::untangled(edge.points()));
                Some(before..points.len())
            });
            roads.push((self.road(RoadIx(i as u32), road, line.as_ref()), edges.collect()));
        }
        let mut places: Vec<&mut FeaturePlace> = Vec::new();
        roads.iter_mut().for_each(|(road, _)| road.each_place(&mut |p| places.push(p)));
        to_degrees(self.projector, places)?;
        let mut positions = EncodedPositions::default();
        degrees(self.projector, &points).try_for_each(|place| Ok::<(), WriteError>(positions.push(place?)?))?;
        for (i, (road, edges)) in range.zip(roads) {
            let between =
                |left: usize, right: usize| Some((&positions, [edges[left].as_ref()?, edges[right].as_ref()?]));
            let last = edges.len() - 1;
            put(out, &road, between(0, last))?;
            for lane in 0..last {
                put(out, &Feature::new(self.lane(i, lane), None), between(lane, lane + 1))?;
            }
        }
        Ok(())
    }

    fn put_intersections(&self, range: Range<usize>, out: &mut Vec<u8>) -> Result<(), WriteError> {
        let mut features: Vec<Feature<IntersectionShape>> =
            range.map(|i| self.intersection(IntersectionIx(i as u32), &self.outlines.intersections[i])).collect();
        let mut places: Vec<&mut FeaturePlace> = Vec::new();
        features.iter_mut().for_each(|feature| feature.each_place(&mut |p| places.push(p)));
        to_degrees(self.projector, places)?;
        features.iter().try_for_each(|feature| put(out, feature, None))?;
        Ok(())
    }

    fn road(&self, ix: RoadIx, road: &Road, line: Option<&Polyline>) -> Feature<RoadShape> {
        let [from, to] = self.outlines.kept[ix.0 as usize];
        let half = road.half_width();
        let ends = [End::Start, End::End].map(|end| self.end(ix, end));
        let shape = RoadShape {
            kind: Type::Road,
            id: self.id(ix),
            src: Some(intersection_id(self.network, road.from)),
            dst: Some(intersection_id(self.network, road.to)),
            osm_ids: road.ways.clone(),
            drive: true,
            layer: Some(Levels::One(road.level)),
            width: Some(rounded_metres(half * 2.0)),
            length: Some(rounded_metres(line.map_or(0.0, Polyline::length))),
            trim_start: Some(rounded_metres(from)),
            trim_end: Some(rounded_metres(road.line.length() - to)),
            oblivion: line.is_none(),
            ends: ends.into(),
            name: road.name.clone(),
            class: Some(road.class),
            link: road.link,
            roundabout: road.roundabout,
            public: road.public,
            speed: Some(road.speed),
            key: Some(road.key.into()),
            centerline: places(road.line.points()),
            heights: road.heights.clone(),
            kept: Some([from, to]),
            furniture: road.features.iter().map(furniture).collect(),
            tags: road.tags.clone(),
        };
        Feature::new(shape, None)
    }

    /// The cut across one end of a road. Its left end, seen looking into the intersection, comes first.
    fn end(&self, ix: RoadIx, end: End) -> EndShape {
        let intersection = self.network.road(ix).intersection(end);
        let cuts = &self.outlines.intersections[intersection.0 as usize].cuts;
        let cut = cuts.iter().find(|cut| cut.at == RoadEnd { road: ix, end });
        EndShape {
            int: Some(intersection_id(self.network, intersection)),
            pts: cut.map_or_else(Vec::new, |cut| places(&[cut.left, cut.right])),
        }
    }

    fn id(&self, road: RoadIx) -> FeatureId {
        self.ids[road.0 as usize].clone()
    }

    fn lane(&self, road: usize, index: usize) -> LaneShape {
        let (id, road) = (self.ids[road].clone(), &self.network.roads[road]);
        let Strip { kind, travel, width, arrows, change, width_guessed, speed, bicycles } =
            road.section.strips[index].clone();
        LaneShape {
            kind: Type::Lane,
            id: Some(FeatureId(Text::from(format!("{}:{index}", id.0)))),
            road: id,
            index: Some(index as u32),
            drive: for_motor_traffic(kind),
            layer: Some(Levels::One(road.level)),
            strip: kind,
            travel: Some(travel),
            width: Some(width),
            width_guessed,
            arrows,
            change,
            speed,
            bicycles,
        }
    }

    fn intersection(&self, ix: IntersectionIx, outline: &Outline) -> Feature<IntersectionShape> {
        let network = self.network;
        let intersection: &Intersection = network.intersection(ix);
        let mut layers: Vec<f64> = intersection.arms.iter().map(|arm| network.road(arm.road).level).collect();
        layers.sort_by(f64::total_cmp);
        layers.dedup();
        let restrictions = self.restrictions.get(&ix).into_iter().flatten();
        let connections = self.connections.get(&ix).into_iter().flatten();
        let shape = IntersectionShape {
            kind: Type::Intersection,
            id: intersection_id(network, ix),
            roads: intersection.arms.iter().map(|arm| self.id(arm.road)).collect(),
            drive: true,
            layer: Some(Levels::Several(layers)),
            case: Some(outline.case),
            terminal: intersection.arms.len() < 2,
            fallback: outline.case == OutlineCase::Fallback,
            merged_from: intersection.nodes.clone(),
            map_edge: Some(intersection.map_edge),
            signals: intersection.signals,
            all_way_stop: intersection.all_way_stop,
            circle: intersection.circle.clone(),
            position: Some(place(intersection.position)),
            arms: intersection.arms.iter().map(|arm| self.arm(*arm)).collect(),
            passages: passages(intersection),
            inner: inner(intersection),
            restrictions: restrictions.map(|r| self.restriction(r)).collect(),
            connections: connections.map(|c| self.connection(c)).collect(),
            islands: intersection.islands.iter().map(island).collect(),
        };
        Feature::new(shape, polygon(&outline.ring))
    }

    fn arm(&self, RoadEnd { road, end }: RoadEnd) -> ArmShape {
        ArmShape { road: self.id(road), end }
    }

    fn connection(&self, connection: &LaneConnection) -> ConnectionShape {
        ConnectionShape {
            relation: connection.relation,
            from: self.arm(connection.from),
            to: self.arm(connection.to),
            lanes: connection.lanes.clone(),
        }
    }

    fn restriction(&self, restriction: &TurnRestriction) -> RestrictionShape {
        RestrictionShape {
            relation: restriction.relation,
            from: self.arm(restriction.from),
            via: restriction.via.iter().map(|via| self.id(*via)).collect(),
            to: self.arm(restriction.to),
            only: restriction.only,
        }
    }
}

/// Writes a feature and a separator. `polygon` is its geometry if it has none yet: the ground between two edges.
fn put(
    out: &mut Vec<u8>,
    feature: &impl serde::Serialize,
    polygon: Option<(&EncodedPositions, [&Range<usize>; 2])>,
) -> serde_json::Result<()> {
    serde_json::to_writer(&mut *out, feature)?;
    if let Some((positions, edges)) = polygon {
        positions.put_polygon(out, edges);
    }
    out.extend(SEPARATOR);
    Ok(())
}

/// Turns metres into degrees, all at once.
fn to_degrees(projector: &Projector, places: Vec<&mut FeaturePlace>) -> Result<(), WriteError> {
    let points: Vec<Point> = places.iter().map(|FeaturePlace([x, y])| Point::new(*x, *y)).collect();
    places.into_iter().zip(degrees(projector, &points)).try_for_each(|(place, found)| {
        let LonLat { lon, lat } = found?;
        *place = FeaturePlace([lon, lat].map(rounded));
        Ok(())
    })
}

/// The longitudes and latitudes of points.
fn degrees(projector: &Projector, points: &[Point]) -> impl Iterator<Item = Result<LonLat, WriteError>> {
    let name = projector.name();
    projector.inverse_each(points, |_| 0.0).into_iter().map(move |found| found.ok_or(WriteError::OutOfReach(name)))
}

fn rounded_metres(metres: f64) -> f64 {
    (metres * PER_METRE).round() / PER_METRE
}

fn place(p: Point) -> FeaturePlace {
    FeaturePlace([p.x, p.y])
}

fn places(points: &[Point]) -> Vec<FeaturePlace> {
    points.iter().copied().map(place).collect()
}

/// The polygon of a clockwise ring that is not closed. GeoJSON (RFC 7946, 3.1.6) wants it closed and counter-clockwise.
fn polygon(ring: &[Point]) -> Option<Geometry> {
    let mut closed = Vec::with_capacity(ring.len() + 1);
    closed.extend(ring.iter().rev().copied().map(place));
    closed.push(*closed.first()?);
    (closed.len() > 3).then_some(Geometry::Polygon(vec![closed]))
}

/// The edges of a road's cross-section from left to right, as ranges of points; `None` if an edge has no points.
type Edges = Vec<Option<Range<usize>>>;

/// The id of a road in the file.
pub fn road_id(key: &RoadKey) -> FeatureId {
    FeatureId(Text::from(key.to_string()))
}

/// The id of an intersection in the file: its smallest node id.
pub fn intersection_id(network: &RoadNetwork, ix: IntersectionIx) -> FeatureId {
    let node = network.intersection(ix).nodes.first();
    FeatureId(node.map_or_else(|| Text::from(format!("#{}", ix.0)), |node| Text::from(node.to_string())))
}

/// The pairs of arms between which traffic passes, as indices of arms.
fn passages(intersection: &Intersection) -> Option<Vec<[usize; 2]>> {
    let index = |end: &RoadEnd| intersection.arms.iter().position(|arm| arm == end);
    let passages = intersection.passages.as_ref()?;
    Some(passages.iter().filter_map(|(from, to)| Some([index(from)?, index(to)?])).collect())
}

fn for_motor_traffic(kind: StripKind) -> bool {
    matches!(kind, StripKind::Drive | StripKind::Bus | StripKind::Parking | StripKind::Shoulder)
}

fn furniture(feature: &Furniture) -> FurnitureShape {
    let (kind, travel, crossing) = match feature.kind {
        FeatureKind::Crossing { signals, marked } => (FurnitureKind::Crossing, None, Some([signals, marked])),
        FeatureKind::Signals(travel) => (FurnitureKind::Signals, Some(travel), None),
        FeatureKind::MidBlockSignals(travel) => (FurnitureKind::MidBlockSignals, Some(travel), None),
        FeatureKind::Stop(travel) => (FurnitureKind::Stop, Some(travel), None),
        FeatureKind::GiveWay(travel) => (FurnitureKind::GiveWay, Some(travel), None),
        FeatureKind::StopLine(travel) => (FurnitureKind::StopLine, Some(travel), None),
        FeatureKind::Sidewalk => (FurnitureKind::Sidewalk, None, None),
    };
    let [signals, marked] = [0, 1].map(|i| crossing.map(|c| c[i]));
    FurnitureShape { kind, station: feature.station, node: feature.node, travel, signals, marked }
}

fn inner(intersection: &Intersection) -> Vec<InnerShape> {
    let shape = |inner: &InnerRoad| InnerShape {
        key: inner.key.into(),
        osm_ids: inner.ways.clone(),
        centerline: places(inner.line.points()),
        lanes: strips(&inner.section),
        roundabout: inner.roundabout,
    };
    intersection.inner.iter().map(shape).collect()
}

fn island(island: &Island) -> IslandShape {
    IslandShape { osm_id: island.way, ring: places(&island.ring) }
}

fn strips(section: &CrossSection) -> Vec<StripShape> {
    let shape = |s: &Strip| StripShape {
        strip: s.kind,
        travel: s.travel,
        width: s.width,
        width_guessed: s.width_guessed,
        arrows: s.arrows,
        change: s.change,
        speed: s.speed,
        bicycles: s.bicycles,
    };
    section.strips.iter().map(shape).collect()
}
