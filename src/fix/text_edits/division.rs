//! Cuts ways and the lanelets between them.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use super::TextEdits;
use super::claims::{Claim, Part};
use crate::diagnostic::{AreaCorner, CutPlace, Division, LaneletCut, WayCut};
use crate::osm::element::{Child, Element};
use crate::osm::{ElementKind, Tags};

/// Tags of a node that lie between those of its neighbours.
const MEASURED: [&str; 3] = ["local_x", "local_y", "ele"];

/// The vertices of ways, by id.
type Vertices = BTreeMap<i64, Vec<i64>>;

/// The ids of the parts of ways in file order, by the way.
type Parts = BTreeMap<i64, Vec<i64>>;

impl TextEdits<'_> {
    /// The elements that a division changes: the ways, those along a segment that gets a new vertex, the lanelets, and the
    /// relations that refer to these.
    pub(super) fn claim_division(&self, division: &Division, claim: &mut Claim) {
        for cut in &division.lanelets {
            let (kind, id) = (ElementKind::Relation, cut.lanelet);
            claim.whole.push((kind, id));
            claim.parts.extend(self.referrers_of((kind, id)).map(|one| (one, Part::Member(kind, id))));
        }
        for cut in &division.ways {
            claim.whole.push((ElementKind::Way, cut.way));
            let segments = cut.places.iter().filter_map(|place| self.segment(cut.way, *place));
            let along = segments.flat_map(|segment| self.ways_along(segment));
            claim.whole.extend(along.map(|way| (ElementKind::Way, way)));
        }
        claim.whole.sort_unstable();
        claim.whole.dedup();
    }

    /// Cuts the ways and lanelets; `None` if anything but these lanelets refers to one of the ways, or if a part would have no
    /// length.
    pub(super) fn divide(&mut self, division: &Division) -> Option<()> {
        let lanelets: BTreeSet<i64> = division.lanelets.iter().map(|cut| cut.lanelet).collect();
        let is_cut = |(kind, id)| kind == ElementKind::Relation && lanelets.contains(&id);
        if !division.ways.iter().all(|cut| self.referrers_of((ElementKind::Way, cut.way)).all(is_cut)) {
            return None;
        }
        let parts = self.cut_ways(&division.ways)?;
        let count = division.ways.first()?.places.len() + 1;
        division.lanelets.iter().try_for_each(|cut| self.cut_lanelet(cut, count, &parts))
    }

    fn cut_ways(&mut self, cuts: &[WayCut]) -> Option<Parts> {
        let mut vertices = Vertices::new();
        let mut made: FxHashMap<([i64; 2], usize), i64> = FxHashMap::default();
        let mut ends: Vec<(i64, Vec<i64>)> = Vec::new();
        for cut in cuts {
            self.vertices(&mut vertices, cut.way)?;
            let mut nodes = Vec::new();
            for place in &cut.places {
                nodes.push(match self.segment(cut.way, *place) {
                    None => *self.osm.way(cut.way)?.nodes.get(place.vertex)?,
                    Some(segment) => self.node_on(segment, place.share, &mut made, &mut vertices)?,
                });
            }
            ends.push((cut.way, nodes));
        }
        let mut parts = Parts::new();
        for (way, nodes) in ends {
            let points = vertices.remove(&way)?;
            parts.insert(way, self.cut_way(way, &points, &nodes)?);
        }
        for (way, points) in vertices {
            self.element_of((ElementKind::Way, way))?.set_vertices(&points);
        }
        Some(parts)
    }

    /// New nodes on segments of ways, as vertices of all ways along them; in the order of the corners.
    pub(super) fn nodes_at(&mut self, corners: &[AreaCorner]) -> Option<Vec<i64>> {
        let (mut vertices, mut made) = (Vertices::new(), FxHashMap::default());
        let mut on = |one: &AreaCorner| self.node_on(one.ends, one.share, &mut made, &mut vertices);
        let nodes: Vec<i64> = corners.iter().map(&mut on).collect::<Option<_>>()?;
        for (way, points) in vertices {
            self.element_of((ElementKind::Way, way))?.set_vertices(&points);
        }
        Some(nodes)
    }

    /// A new node on a segment, as a vertex of all ways along the segment. If ways lie on each other, the node may exist already.
    fn node_on(
        &mut self,
        segment: [i64; 2],
        share: f64,
        made: &mut FxHashMap<([i64; 2], usize), i64>,
        vertices: &mut Vertices,
    ) -> Option<i64> {
        /// Two places are the same if they differ by less than a segment divided by this number.
        const PARTS: f64 = 1000.0;
        let [from, to] = segment;
        let (ends, along) = if from < to { (segment, share) } else { ([to, from], 1.0 - share) };
        let key = (ends, (along * PARTS).round() as usize);
        if let Some(node) = made.get(&key) {
            return Some(*node);
        }
        let node = self.create_node(segment, share)?;
        for way in self.ways_along(segment) {
            // Nodes that were made on the segment before may lie between its ends now.
            let earlier = made.iter().filter(|((other, at), _)| *other == ends && *at < key.1);
            let before = earlier.max_by_key(|((_, at), _)| *at).map_or(ends[0], |(_, node)| *node);
            let later = made.iter().filter(|((other, at), _)| *other == ends && *at > key.1);
            let behind = later.min_by_key(|((_, at), _)| *at).map_or(ends[1], |(_, node)| *node);
            insert_between(self.vertices(vertices, way)?, [before, behind], node);
        }
        made.insert(key, node);
        Some(node)
    }

    /// Cuts a way over these points at these nodes.
    fn cut_way(&mut self, way: i64, points: &[i64], nodes: &[i64]) -> Option<Vec<i64>> {
        let mut places = vec![0];
        for node in nodes {
            let mut found = points.iter().enumerate().filter(|(_, id)| *id == node).map(|(at, _)| at);
            let (Some(at), None) = (found.next(), found.next()) else { return None };
            places.push(at);
        }
        places.push(points.len().checked_sub(1)?);
        if !places.is_sorted_by(|place, next| place < next) {
            return None;
        }
        let mut ids = Vec::new();
        for (from, to) in places.iter().zip(places.iter().skip(1)) {
            let part = points.get(*from..=*to)?;
            let element = self.element_of((ElementKind::Way, way))?;
            if ids.is_empty() {
                element.set_vertices(part);
                ids.push(way);
                continue;
            }
            let mut element = element.clone();
            let id = self.fresh(true)?;
            element.set_attribute("id", &id.to_string());
            element.set_vertices(part);
            self.created.push(((ElementKind::Way, id), element));
            ids.push(id);
        }
        Some(ids)
    }

    /// The vertices of a way as they are to be; at first, as they are.
    fn vertices<'v>(&self, vertices: &'v mut Vertices, way: i64) -> Option<&'v mut Vec<i64>> {
        let known = &self.osm.way(way)?.nodes;
        Some(vertices.entry(way).or_insert_with(|| known.clone()))
    }

    /// The segment on which a place lies; `None` where it is a vertex.
    fn segment(&self, way: i64, place: CutPlace) -> Option<[i64; 2]> {
        let nodes = &self.osm.way(way)?.nodes;
        let pair = [*nodes.get(place.vertex)?, *nodes.get(place.vertex + 1)?];
        (place.share > 0.0).then_some(pair)
    }

    /// The ways that run from one node straight to another, or back.
    pub(super) fn ways_along(&self, [from, to]: [i64; 2]) -> BTreeSet<i64> {
        let near = self.referrers_of((ElementKind::Node, from)).filter(|key| key.0 == ElementKind::Way);
        let runs_along = |way: &i64| {
            let nodes = self.osm.way(*way).map(|way| &way.nodes);
            nodes.is_some_and(|nodes| nodes.windows(2).any(|pair| pair == [from, to] || pair == [to, from]))
        };
        near.map(|key| key.1).filter(runs_along).collect()
    }

    /// A node between two others, with the tags that both have.
    fn create_node(&mut self, [from, to]: [i64; 2], share: f64) -> Option<i64> {
        let osm = self.osm;
        let [a, b] = [osm.node(from)?, osm.node(to)?];
        let between = |a: f64, b: f64| a + (b - a) * share;
        let id = self.fresh(false)?;
        let mut element = Element::new("node", id, "\n  ");
        match a.position.zip(b.position) {
            Some((a, b)) => element.set_place(between(a.lat, b.lat), between(a.lon, b.lon)),
            // What has no latitude and longitude has metres.
            None => ["lat", "lon"].into_iter().for_each(|name| element.set_attribute(name, "")),
        }
        let number = |tags: &Tags, key: &str| tags.get(key)?.trim().parse::<f64>().ok();
        for key in MEASURED {
            if let Some((a, b)) = number(&a.tags, key).zip(number(&b.tags, key)) {
                element.set_tag(key, &format!("{:.4}", between(a, b)));
            }
        }
        for (key, value) in a.tags.iter().filter(|(key, value)| b.tags.get(key) == Some(*value)) {
            if !MEASURED.contains(&key) {
                element.set_tag(key, value);
            }
        }
        self.created.push(((ElementKind::Node, id), element));
        Some(id)
    }

    /// Cuts a lanelet, whose ways are cut already, into this number of pieces.
    fn cut_lanelet(&mut self, cut: &LaneletCut, count: usize, parts: &Parts) -> Option<()> {
        let key = (ElementKind::Relation, cut.lanelet);
        let whole = self.element_of(key)?.clone();
        let mut ids = Vec::new();
        for at in 0..count {
            let mut element = piece(whole.clone(), cut, at, parts);
            if at == cut.stays {
                *self.element_of(key)? = element;
                ids.push(cut.lanelet);
                continue;
            }
            let id = self.fresh(false)?;
            element.set_attribute("id", &id.to_string());
            self.created.push(((ElementKind::Relation, id), element));
            ids.push(id);
        }
        for referrer in self.referrers_of(key).collect::<BTreeSet<_>>() {
            let is_named = |at: usize| {
                let only = cut.elements.iter().find(|(element, _)| *element == referrer.1);
                only.is_none_or(|(_, pieces)| pieces.contains(&at))
            };
            let named: Vec<i64> = ids.iter().enumerate().filter(|(at, _)| is_named(*at)).map(|(_, id)| *id).collect();
            let element = self.element_of(referrer)?;
            let roles = element.roles_of(key);
            for role in roles {
                let new = named.iter().filter(|id| **id != cut.lanelet);
                new.for_each(|id| element.add_member(ElementKind::Relation, *id, &role));
            }
            if !named.contains(&cut.lanelet) {
                element.remove(|child| matches!(child, Child::Member(kind, id, _) if (*kind, *id) == key));
            }
        }
        Some(())
    }
}

/// A piece of a lanelet, by its number in the direction of travel.
fn piece(mut element: Element, cut: &LaneletCut, at: usize, parts: &Parts) -> Element {
    element.replace(|child| match child {
        Child::Member(ElementKind::Way, way, role) => {
            let parts = parts.get(way)?;
            let number = if cut.against.contains(way) { parts.len().checked_sub(at + 1)? } else { at };
            let id = *parts.get(number)?;
            (id != *way).then(|| Child::Member(ElementKind::Way, id, role.clone()))
        }
        _ => None,
    });
    element.remove(|child| match child {
        Child::Member(ElementKind::Relation, id, _) => {
            cut.elements.iter().any(|(element, pieces)| element == id && !pieces.contains(&at))
        }
        Child::Tag(key) => cut.tags.iter().any(|(tag, pieces)| tag.as_str() == key.as_str() && !pieces.contains(&at)),
        _ => false,
    });
    element
}

/// Puts a node between two that follow each other, wherever they do.
fn insert_between(points: &mut Vec<i64>, [a, b]: [i64; 2], node: i64) {
    let before = std::mem::take(points);
    for point in before {
        let between = points.last().is_some_and(|last| [*last, point] == [a, b] || [*last, point] == [b, a]);
        points.extend(between.then_some(node));
        points.push(point);
    }
}
