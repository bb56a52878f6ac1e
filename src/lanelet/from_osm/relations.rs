//! Relations become lanelets and regulatory elements, in the loader's order: lanelets need bounds, elements need
//! lanelets, and in the end lanelets get their elements.

use crate::diagnostic::Subject;
use crate::geometry::Point as PlanePoint;
use crate::lanelet::align::{align, opposed};
use crate::lanelet::limits::{is_sign, role_limits};
use crate::lanelet::{
    Bound, BoundRole, Condition, Lanelet, LaneletId, LineStringId, Member, PointId, PolygonId, RegulatoryElement,
    RegulatoryElementId, Target,
};
use crate::osm;
use crate::osm::{ElementKind, Relation, Text};

use super::relation_type::RelationType;
use super::{Loader, infer_type, merged};

/// What a member of a regulatory element turns out to be.
enum Resolved {
    /// In the map.
    Here(Target),
    /// Known to the loader, though only as an empty dummy.
    Dummy(Target),
    /// Not a member at all.
    Gone,
}

impl Loader<'_> {
    pub(super) fn relations(&mut self) {
        let relations = merged(self.osm, &self.repeated);
        for relation in &relations {
            self.relation_faults(relation);
            if RelationType::of(&relation.tags) == RelationType::Lanelet {
                self.lanelet(relation);
            }
        }
        for relation in &relations {
            if RelationType::of(&relation.tags) == RelationType::RegulatoryElement {
                self.regulatory_element(relation);
            }
        }
        for relation in &relations {
            if RelationType::of(&relation.tags) == RelationType::Lanelet {
                self.link(relation);
            }
        }
    }

    fn relation_faults(&mut self, relation: &Relation) {
        let subject = subject_of(relation);
        self.id(ElementKind::Relation, relation.id, subject, &relation.span);
        if RelationType::of(&relation.tags) == RelationType::Unknown {
            let found = relation.tags.get("type").map(Text::from);
            let meant = infer_type::relation_type(relation).filter(|_| found.is_none());
            self.fault(subject, &relation.span, Condition::UnknownRelationType { found, meant });
        }
        for member in &relation.members {
            if !self.osm.contains(member.kind, member.id) {
                let (kind, id, role) = (member.kind, member.id, Some(member.role.clone()));
                self.fault(subject, &relation.span, Condition::MissingReference { kind, id, role });
            }
        }
    }

    fn lanelet(&mut self, relation: &Relation) {
        let left = self.bound(relation, BoundRole::Left);
        let right = self.bound(relation, BoundRole::Right);
        let centerline = self.bound(relation, BoundRole::Centerline);
        let (Some(left), Some(right)) = (left, right) else { return };
        let lines = [self.line(left), self.line(right)];
        let (left_inverted, right_inverted) = align(&lines[0], &lines[1]);
        let id = LaneletId(relation.id);
        let subject = Subject::Lanelet(relation.id);
        let [mut left_line, mut right_line] = lines;
        if left_inverted {
            left_line.reverse();
        }
        if right_inverted {
            right_line.reverse();
        }
        if opposed(&left_line, &right_line) {
            let condition =
                Condition::BoundsOpposed { left: (left.0, left_inverted), right: (right.0, right_inverted) };
            self.fault(subject, &relation.span, condition);
        } else if left_inverted && right_inverted {
            let condition = Condition::BothBoundsTurned { left: left.0, right: right.0 };
            self.fault(subject, &relation.span, condition);
        }
        self.loaded.map.lanelets.insert(Lanelet {
            id,
            left: Bound { line: left, inverted: left_inverted },
            right: Bound { line: right, inverted: right_inverted },
            centerline,
            regulatory_elements: Vec::new(),
            attributes: relation.tags.clone(),
            span: Some(relation.span.clone()),
        });
    }

    pub(super) fn line(&self, id: LineStringId) -> Vec<PlanePoint> {
        let map = &self.loaded.map;
        let points = map.linestrings.get(id).map_or(&[][..], |l| &l.points);
        points.iter().filter_map(|p| map.points.get(*p)).map(|p| p.position).collect()
    }

    /// The one line of a role, if it is there and usable; every other case is a fault.
    fn bound(&mut self, relation: &Relation, role: BoundRole) -> Option<LineStringId> {
        let subject = Subject::Lanelet(relation.id);
        // The loader has already dropped what is missing.
        let members: Vec<&osm::Member> =
            relation.members.iter().filter(|m| m.role == role.as_str() && self.osm.contains(m.kind, m.id)).collect();
        let &[member] = members.as_slice() else {
            if role != BoundRole::Centerline || !members.is_empty() {
                let (count, ways) = (members.len(), members.iter().map(|m| m.id).collect());
                self.fault(subject, &relation.span, Condition::BoundCount { role, count, ways, meant: None });
            }
            return None;
        };
        let (kind, way) = (member.kind, member.id);
        let map = &self.loaded.map;
        let condition = if kind != ElementKind::Way {
            Condition::BoundIsNotWay { role, kind, id: way }
        } else if let Some(line) = map.linestrings.get(LineStringId(way)) {
            if line.points.len() >= 2 {
                return Some(line.id);
            }
            Condition::BoundTooShort { role, way }
        } else if map.polygons.contains(PolygonId(way)) {
            Condition::BoundIsPolygon { role, way }
        } else {
            Condition::BoundDropped { role, way }
        };
        self.fault(subject, &relation.span, condition);
        None
    }

    fn regulatory_element(&mut self, relation: &Relation) {
        let subject = Subject::RegulatoryElement(relation.id);
        let Some(subtype) = relation.tags.get("subtype").map(Text::from) else {
            let meant = infer_type::subtype(self.osm, relation);
            return self.fault(subject, &relation.span, Condition::WithoutSubtype { meant });
        };
        let mut members = Vec::new();
        let mut known: Vec<(Text, Target)> = Vec::new();
        for member in &relation.members {
            let role = || member.role.clone();
            match self.resolve(relation, member) {
                Resolved::Here(target) => {
                    known.push((role(), target));
                    members.push(Member { role: role(), target });
                }
                Resolved::Dummy(target) => {
                    known.push((role(), target));
                    let (kind, id, role) = (member.kind, member.id, role());
                    self.fault(subject, &relation.span, Condition::MemberDropped { kind, id, role });
                }
                Resolved::Gone => {}
            }
        }
        if self.creates(relation, &subtype, &known) {
            self.loaded.map.regulatory_elements.insert(RegulatoryElement {
                id: RegulatoryElementId(relation.id),
                subtype,
                members,
                attributes: relation.tags.clone(),
                span: Some(relation.span.clone()),
            });
        }
    }

    fn resolve(&mut self, relation: &Relation, member: &osm::Member) -> Resolved {
        let (osm, map, id) = (self.osm, &self.loaded.map, member.id);
        if !osm.contains(member.kind, id) {
            return Resolved::Gone;
        }
        let here = |exists: bool, target| if exists { Resolved::Here(target) } else { Resolved::Dummy(target) };
        match member.kind {
            ElementKind::Node => here(map.points.contains(PointId(id)), Target::Point(PointId(id))),
            ElementKind::Way if map.polygons.contains(PolygonId(id)) => Resolved::Here(Target::Polygon(PolygonId(id))),
            ElementKind::Way => {
                let line = LineStringId(id);
                here(map.linestrings.contains(line), Target::LineString(line))
            }
            ElementKind::Relation => {
                let Some(target) = osm.relation(id) else { return Resolved::Gone };
                let role = member.role.clone();
                let condition = match RelationType::of(&target.tags) {
                    RelationType::Lanelet => {
                        return here(map.lanelets.contains(LaneletId(id)), Target::Lanelet(LaneletId(id)));
                    }
                    RelationType::Multipolygon => return Resolved::Gone,
                    RelationType::RegulatoryElement => Condition::MemberIsRegulatoryElement { id, role },
                    RelationType::Unknown => {
                        let found = target.tags.get("type").map(Text::from);
                        Condition::MemberOfUnknownType { id, role, found }
                    }
                };
                self.fault(Subject::RegulatoryElement(relation.id), &relation.span, condition);
                Resolved::Gone
            }
        }
    }

    /// Whether the constructor of the subtype takes these members.
    fn creates(&mut self, relation: &Relation, subtype: &Text, members: &[(Text, Target)]) -> bool {
        let subject = Subject::RegulatoryElement(relation.id);
        let Some(limits) = role_limits(subtype) else {
            let condition = Condition::UnknownSubtype { subtype: subtype.clone() };
            self.fault(subject, &relation.span, condition);
            return false;
        };
        let before = self.loaded.faults.len();
        let count = |role: &str, holds: &dyn Fn(Target) -> bool| {
            members.iter().filter(|(r, target)| r == role && holds(*target)).count()
        };
        for &limit in limits {
            let count = count(limit.role, &|target| limit.kind.holds(target));
            if count < limit.min || limit.max.is_some_and(|max| count > max) {
                let condition = Condition::MemberCount { subtype: subtype.clone(), limit, count };
                self.fault(subject, &relation.span, condition);
            }
        }
        if is_sign(subtype) && !relation.tags.has("sign_type") {
            let signs = |(role, target): &(Text, Target)| match target {
                Target::LineString(LineStringId(id)) | Target::Polygon(PolygonId(id)) if role == "refers" => Some(*id),
                _ => None,
            };
            let sign = members.iter().find_map(signs);
            if !sign.and_then(|id| self.osm.way(id)).is_some_and(|way| way.tags.has("subtype")) {
                let condition = Condition::SignWithoutType { subtype: subtype.clone(), sign };
                self.fault(subject, &relation.span, condition);
            }
        }
        if subtype == "all_way_stop" {
            let lanelets = count("yield", &|target| matches!(target, Target::Lanelet(_)));
            let stop_lines = count("ref_line", &|target| matches!(target, Target::LineString(_)));
            if stop_lines > 0 && stop_lines != lanelets {
                let condition = Condition::StopLinesPerLanelet { lanelets, stop_lines };
                self.fault(subject, &relation.span, condition);
            }
        }
        self.loaded.faults.len() == before
    }

    /// Tells a lanelet its regulatory elements.
    fn link(&mut self, relation: &Relation) {
        let subject = Subject::Lanelet(relation.id);
        let mut elements = Vec::new();
        for member in relation.members.iter().filter(|m| m.role == "regulatory_element") {
            let (kind, id) = (member.kind, member.id);
            if !self.osm.contains(kind, id) {
                continue;
            }
            let target = self.osm.relation(id).filter(|_| kind == ElementKind::Relation);
            let is_element = target.is_some_and(|t| RelationType::of(&t.tags) == RelationType::RegulatoryElement);
            if !is_element {
                self.fault(subject, &relation.span, Condition::NotRegulatoryElement { kind, id });
            } else if self.loaded.map.regulatory_elements.contains(RegulatoryElementId(id)) {
                elements.push(RegulatoryElementId(id));
            } else {
                let role = member.role.clone();
                self.fault(subject, &relation.span, Condition::MemberDropped { kind, id, role });
            }
        }
        if let Some(lanelet) = self.loaded.map.lanelets.get_mut(LaneletId(relation.id)) {
            lanelet.regulatory_elements = elements;
        }
    }
}

fn subject_of(relation: &Relation) -> Subject {
    match RelationType::of(&relation.tags) {
        RelationType::Lanelet => Subject::Lanelet(relation.id),
        RelationType::RegulatoryElement => Subject::RegulatoryElement(relation.id),
        RelationType::Multipolygon | RelationType::Unknown => Subject::Relation(relation.id),
    }
}
