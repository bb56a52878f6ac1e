//! Turns the content of a file into the map that Autoware's loader makes of it, and reports what the loader rejects or changes.

mod areas;
mod duplicate_ids;
mod file_level;
mod infer_type;
mod missing_bound;
mod nodes;
mod relation_type;
mod relations;

use crate::diagnostic::{SourceSpan, Subject};
use crate::osm::{ElementKind, OsmData, Relation, Way};
use crate::projection::Projector;

use super::fault::{Condition, LoadFault};
use super::{LaneletMap, LineString, LineStringId, PointId, Polygon, PolygonId};
pub use nodes::positions;
pub use relation_type::is_area;
use std::borrow::Cow;

use rustc_hash::FxHashMap;

/// A map and what was wrong with it.
#[derive(Clone, Debug, Default)]
pub struct Loaded {
    /// What Autoware would hold in memory, without the lanelets and elements that it holds as empty dummies.
    pub map: LaneletMap,
    /// Faults of nodes in file order, of ways and relations by their ids, and of the file as a whole.
    pub faults: Vec<LoadFault>,
}

/// Autoware reads the highest number before the first dot; higher than this it warns or refuses.
pub const SUPPORTED_FORMAT_VERSION: u32 = 2;

/// Simulates Autoware's loader. A reference that does not resolve is reported as a fault and left out of the map.
pub fn from_osm(osm: &OsmData, projector: &Projector) -> Loaded {
    let repeated = repeated(osm);
    let repeats = duplicate_ids::DuplicateIds::of(osm, &repeated);
    let local = *projector == Projector::Local;
    let firsts = firsts(osm, &repeated);
    let off_earth = osm.oddities.iter().filter_map(|odd| Some((odd.element?.1, odd.off_earth?))).collect();
    let mut loader = Loader { osm, loaded: Loaded::default(), repeated, firsts, repeats, local, off_earth };
    loader.loaded.map.format_version = osm.meta.as_ref().and_then(|m| m.format_version.clone());
    loader.loaded.map.local = local;
    loader.nodes(projector);
    loader.ways();
    loader.relations();
    loader.infer_missing_bounds();
    loader.file_level_faults();
    loader.loaded
}

struct Loader<'a> {
    osm: &'a OsmData,
    loaded: Loaded,
    /// The positions of elements that share an id within one file.
    repeated: FxHashMap<(ElementKind, i64), Vec<SourceSpan>>,
    /// The first relation of each id that several share.
    firsts: FxHashMap<i64, &'a Relation>,
    repeats: duplicate_ids::DuplicateIds<'a>,
    local: bool,
    /// Latitude and longitude of nodes that lie nowhere on Earth.
    off_earth: FxHashMap<i64, [f64; 2]>,
}

impl<'a> Loader<'a> {
    /// The relation whose tags the loader takes for an id: the first.
    fn relation(&self, id: i64) -> Option<&'a Relation> {
        self.firsts.get(&id).copied().or_else(|| self.osm.relation(id))
    }

    fn fault(&mut self, subject: Subject, span: &SourceSpan, condition: Condition) {
        self.loaded.faults.push(LoadFault { subject, span: Some(span.clone()), condition });
    }

    /// Reports what is wrong with an id, whatever the kind of element; each repeated id once.
    fn id(&mut self, kind: ElementKind, id: i64, subject: Subject, span: &SourceSpan) {
        if id <= 0 {
            self.fault(subject, span, Condition::IdNotPositive);
        }
        if let Some(spans) = self.repeated.get(&(kind, id))
            && spans.first() == Some(span)
        {
            let spans = spans.clone();
            let repeat = self.repeats.last(kind, id);
            self.fault(subject, span, Condition::DuplicateId { kind, spans, repeat });
        }
        let earlier: &[ElementKind] = match kind {
            ElementKind::Node => &[],
            ElementKind::Way => &[ElementKind::Node],
            ElementKind::Relation => &[ElementKind::Node, ElementKind::Way],
        };
        let kinds: Vec<ElementKind> = earlier.iter().copied().filter(|k| self.osm.contains(*k, id)).collect();
        if !kinds.is_empty() {
            self.fault(subject, span, Condition::IdReused { kinds });
        }
    }

    fn ways(&mut self) {
        let mut ways: Vec<&Way> = self.osm.ways.iter().collect();
        ways.sort_by_key(|way| way.id);
        ways.into_iter().for_each(|way| self.way(way));
        self.drop_replaced_ways();
    }

    /// Of a line and a polygon with one id, only the last in the file loads.
    fn drop_replaced_ways(&mut self) {
        let repeated = self.repeated.iter().filter(|((kind, _), _)| *kind == ElementKind::Way);
        let last: FxHashMap<i64, &SourceSpan> =
            repeated.filter_map(|(&(_, id), spans)| Some((id, spans.last()?))).collect();
        if last.is_empty() {
            return;
        }
        let stays = |id: i64, span: &Option<SourceSpan>| last.get(&id).is_none_or(|last| span.as_ref() == Some(*last));
        self.loaded.map.linestrings.retain(|line| stays(line.id.0, &line.span));
        self.loaded.map.polygons.retain(|polygon| stays(polygon.id.0, &polygon.span));
    }

    fn way(&mut self, way: &Way) {
        let area = is_area(&way.tags);
        let subject = if area { Subject::Polygon(way.id) } else { Subject::LineString(way.id) };
        self.id(ElementKind::Way, way.id, subject, &way.span);
        if area && way.id > i64::from(i32::MAX) {
            self.fault(subject, &way.span, Condition::PolygonIdTooLarge);
        }
        // Every node has become a point.
        let mut points = self.loaded.map.points.cursor();
        let missing: Vec<i64> = way.nodes.iter().copied().filter(|&id| points.get(PointId(id)).is_none()).collect();
        for &id in &missing {
            let condition = Condition::MissingReference { kind: ElementKind::Node, id, role: None };
            self.fault(subject, &way.span, condition);
        }
        if way.nodes.is_empty() {
            self.fault(subject, &way.span, Condition::WayWithoutNodes);
        }
        if way.nodes.is_empty() || !missing.is_empty() {
            return;
        }
        let points = way.nodes.iter().copied().map(PointId).collect();
        let (attributes, span) = (way.tags.clone(), Some(way.span.clone()));
        if area {
            let id = PolygonId(way.id);
            self.loaded.map.polygons.insert(Polygon { id, points, attributes, span });
        } else {
            let id = LineStringId(way.id);
            self.loaded.map.linestrings.insert(LineString { id, points, attributes, span });
        }
    }
}

/// The relations as the loader keeps them, by ids: the first of each id, with the members of all of that id. Where an element
/// stands in a file, or in which cell, must not matter to what is found.
fn merged<'a>(osm: &'a OsmData, repeated: &FxHashMap<(ElementKind, i64), Vec<SourceSpan>>) -> Vec<Cow<'a, Relation>> {
    let mut kept: Vec<Cow<'a, Relation>> = Vec::with_capacity(osm.relations.len());
    let mut first_of: FxHashMap<i64, usize> = FxHashMap::default();
    for relation in &osm.relations {
        match first_of.get(&relation.id) {
            None => {
                if repeated.contains_key(&(ElementKind::Relation, relation.id)) {
                    first_of.insert(relation.id, kept.len());
                }
                kept.push(Cow::Borrowed(relation));
            }
            Some(&at) => kept[at].to_mut().members.extend(relation.members.iter().cloned()),
        }
    }
    kept.sort_by_key(|relation| relation.id);
    kept
}

/// The first relation of each id that several share.
fn firsts<'a>(
    osm: &'a OsmData,
    repeated: &FxHashMap<(ElementKind, i64), Vec<SourceSpan>>,
) -> FxHashMap<i64, &'a Relation> {
    if repeated.is_empty() {
        return FxHashMap::default();
    }
    let of_repeated = osm.relations.iter().filter(|one| repeated.contains_key(&(ElementKind::Relation, one.id)));
    of_repeated.rev().map(|relation| (relation.id, relation)).collect()
}

/// The ids that occur twice within one file. Maps in several files may repeat what lies on their borders.
fn repeated(osm: &OsmData) -> FxHashMap<(ElementKind, i64), Vec<SourceSpan>> {
    use crate::osm::OddityKind;
    let mut spans: FxHashMap<(ElementKind, i64), Vec<SourceSpan>> = osm
        .oddities
        .iter()
        .filter(|o| o.kind == OddityKind::DuplicateId)
        .filter_map(|o| o.element)
        .map(|element| (element, Vec::new()))
        .collect();
    if spans.is_empty() {
        return spans;
    }
    let nodes = osm.nodes.iter().map(|n| (ElementKind::Node, n.id, &n.span));
    let ways = osm.ways.iter().map(|w| (ElementKind::Way, w.id, &w.span));
    let relations = osm.relations.iter().map(|r| (ElementKind::Relation, r.id, &r.span));
    for (kind, id, span) in nodes.chain(ways).chain(relations) {
        if let Some(spans) = spans.get_mut(&(kind, id)) {
            spans.push(span.clone());
        }
    }
    spans.retain(|_, spans| spans.windows(2).any(|pair| pair[0].file == pair[1].file));
    spans
}

#[cfg(test)]
mod tests;
