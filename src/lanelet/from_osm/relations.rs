//! Relations become lanelets and regulatory elements, in the loader's order: lanelets need bounds, elements need
//! lanelets, and in the end lanelets get their elements.

use crate::diagnostic::Subject;
use crate::geometry::Point as PlanePoint;
use crate::lanelet::align::{align, crosses_only_as_used, opposed};
use crate::lanelet::element_roles::{is_sign, role_limits};
use crate::lanelet::vocabulary;
use crate::lanelet::{
    AreaId, Bound, BoundRole, Condition, Lanelet, LaneletId, LaneletMap, LineStringId, LoadFault, Member, PointId,
    PolygonId, RegulatoryElement, RegulatoryElementId, Target,
};
use crate::osm;
use crate::osm::{ElementKind, Relation, Text};

use super::relation_type::RelationType;
use super::{Loader, infer_type, merged};

/// The bounds of all lanelets may have so many points together, each as often as a lanelet uses it, ...
const MOST_POINTS: usize = 300_000;
/// ... or so many times those of the map. People draw a line for the lanelets on its two sides; where one line of thousands of points
/// bounds hundreds of lanelets, each of them would be judged along all of it.
const MOST_USES: usize = 20;

/// What the loader makes of a member of a regulatory element.
enum Resolved {
    /// In the map.
    Here(Target),
    /// Known to the loader, though only as an empty dummy.
    Dummy(Target),
    /// Dropped.
    Gone,
}

/// What the loader takes as a bound of a lanelet.
enum Border {
    /// A line of two points or more.
    Line(LineStringId),
    /// A line that a lanelet cannot use, or an empty dummy in its place.
    Unusable(LineStringId),
}

impl Border {
    const fn line(&self) -> LineStringId {
        match self {
            Self::Line(id) | Self::Unusable(id) => *id,
        }
    }
}

impl Loader<'_> {
    pub(super) fn relations(&mut self) {
        let relations = merged(self.osm, &self.repeated);
        let most = MOST_POINTS.max(MOST_USES * self.loaded.map.points.len());
        let (mut points, mut left_out) = (0, Vec::<&Relation>::new());
        for relation in &relations {
            self.relation_faults(relation);
            if RelationType::of(&relation.tags) == RelationType::Lanelet {
                points += self.points_of_bounds(relation);
                if points <= most {
                    self.lanelet(relation);
                } else {
                    self.unusable(relation, [LineStringId(relation.id); 2], None);
                    left_out.push(relation);
                }
            }
        }
        if let Some(first) = left_out.first() {
            let condition = Condition::BoundsTooLong { lanelets: left_out.len(), most };
            self.fault(Subject::Lanelet(first.id), &first.span, condition);
        }
        for relation in &relations {
            if RelationType::of(&relation.tags) == RelationType::Multipolygon
                && let Some(area) = self.area(relation)
            {
                self.loaded.map.areas.insert(area);
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
        let of = match RelationType::of(&relation.tags) {
            RelationType::Lanelet => Some("lanelet"),
            RelationType::Multipolygon => Some("multipolygon"),
            RelationType::RegulatoryElement => relation.tags.get("subtype"),
            RelationType::Unknown => None,
        };
        let roles = of.and_then(vocabulary::roles);
        for member in &relation.members {
            if let (Some(of), Some(roles)) = (of, roles)
                && !roles.iter().any(|role| *role == member.role)
            {
                let (kind, id, role) = (member.kind, member.id, member.role.clone());
                self.fault(subject, &relation.span, Condition::UnreadRole { of: of.into(), kind, id, role });
            }
            if !self.osm.contains(member.kind, member.id) {
                let (kind, id, role) = (member.kind, member.id, Some(member.role.clone()));
                self.fault(subject, &relation.span, Condition::MissingReference { kind, id, role });
            }
        }
    }

    fn lanelet(&mut self, relation: &Relation) {
        let id = LaneletId(relation.id);
        let bounds = [BoundRole::Left, BoundRole::Right].map(|role| self.bound(relation, role));
        let centerline = match self.centerline(relation) {
            Some(Border::Line(line)) => Some(line),
            Some(Border::Unusable(line)) => {
                self.loaded.map.dummies.centerlines.push((id, line));
                None
            }
            None => None,
        };
        let [Border::Line(left), Border::Line(right)] = bounds else {
            return self.unusable(relation, bounds.map(|border| border.line()), centerline);
        };
        let lines = [self.line(left), self.line(right)];
        let (left_inverted, right_inverted) = align(&lines[0], &lines[1]);
        let subject = Subject::Lanelet(relation.id);
        let [mut left_line, mut right_line] = lines;
        if left_inverted {
            left_line.reverse();
        }
        if right_inverted {
            right_line.reverse();
        }
        // Bounds that both stay or both turn run as they were drawn, be it as those of a tight turn around.
        let runs_as_drawn = left_inverted == right_inverted && !crosses_only_as_used(&left_line, &right_line);
        if opposed(&left_line, &right_line) && !runs_as_drawn {
            let condition =
                Condition::BoundsOpposed { left: (left.0, left_inverted), right: (right.0, right_inverted) };
            self.fault(subject, &relation.span, condition);
        } else if left_inverted && right_inverted {
            let condition = Condition::BothBoundsTurned { left: left.0, right: right.0 };
            self.fault(subject, &relation.span, condition);
        }
        let bounds = [Bound { line: left, inverted: left_inverted }, Bound { line: right, inverted: right_inverted }];
        self.loaded.map.lanelets.insert(bounded(relation, bounds, centerline));
    }

    /// Keeps a lanelet for those that refer to it, without looking at its bounds.
    fn unusable(&mut self, relation: &Relation, lines: [LineStringId; 2], centerline: Option<LineStringId>) {
        let bounds = lines.map(|line| Bound { line, inverted: false });
        self.loaded.map.dummies.lanelets.push(bounded(relation, bounds, centerline));
    }

    /// How many points the lines of a lanelet have.
    fn points_of_bounds(&self, relation: &Relation) -> usize {
        let lines =
            relation.members.iter().filter_map(|member| self.loaded.map.linestrings.get(LineStringId(member.id)));
        lines.map(|line| line.points.len()).sum()
    }

    pub(super) fn line(&self, id: LineStringId) -> Vec<PlanePoint> {
        self.loaded.map.bound_line(Bound { line: id, inverted: false })
    }

    /// The members of a role, without those that are missing: the loader has already dropped them.
    fn members_of<'r>(&self, relation: &'r Relation, role: BoundRole) -> Vec<&'r osm::Member> {
        relation.members.iter().filter(|m| m.role == role.as_str() && self.osm.contains(m.kind, m.id)).collect()
    }

    fn centerline(&mut self, relation: &Relation) -> Option<Border> {
        let some = !self.members_of(relation, BoundRole::Centerline).is_empty();
        some.then(|| self.bound(relation, BoundRole::Centerline))
    }

    /// The one line of a role; if it is not there or not usable, that is a fault.
    fn bound(&mut self, relation: &Relation, role: BoundRole) -> Border {
        let subject = Subject::Lanelet(relation.id);
        let members = self.members_of(relation, role);
        // Where there is no line, the dummy has the id of the lanelet.
        let nothing = Border::Unusable(LineStringId(relation.id));
        let &[member] = members.as_slice() else {
            let (count, ways) = (members.len(), members.iter().map(|m| m.id).collect());
            self.fault(subject, &relation.span, Condition::BoundCount { role, count, ways, meant: None });
            return nothing;
        };
        let (kind, way) = (member.kind, member.id);
        let map = &self.loaded.map;
        let mut unusable = Border::Unusable(LineStringId(way));
        let condition = if kind != ElementKind::Way {
            unusable = nothing;
            Condition::BoundIsNotWay { role, kind, id: way }
        } else if let Some(line) = map.linestrings.get(LineStringId(way)) {
            if line.points.len() >= 2 {
                return Border::Line(line.id);
            }
            Condition::BoundTooShort { role, way }
        } else if map.polygons.contains(PolygonId(way)) {
            Condition::BoundIsPolygon { role, way }
        } else {
            Condition::BoundDropped { role, way }
        };
        self.fault(subject, &relation.span, condition);
        unusable
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
        let before = self.loaded.faults.len();
        let created = self.creates(relation, &subtype, &known);
        let held = self.loaded.faults[before..].iter().all(|fault| fault.condition.is_unsaid());
        let whole: Vec<Member> = known.into_iter().map(|(role, target)| Member { role, target }).collect();
        let dummies = &mut self.loaded.map.dummies;
        let id = RegulatoryElementId(relation.id);
        let (attributes, span) = (relation.tags.clone(), Some(relation.span.clone()));
        if created {
            if whole.len() > members.len() {
                dummies.members.push((id, whole));
            }
            let element = RegulatoryElement { id, subtype, members, attributes, span };
            self.loaded.map.regulatory_elements.insert(element);
        } else if held {
            dummies.elements.push(RegulatoryElement { id, subtype, members: whole, attributes, span });
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
                let Some(target) = self.relation(id) else { return Resolved::Gone };
                let role = member.role.clone();
                let condition = match RelationType::of(&target.tags) {
                    RelationType::Lanelet => {
                        return here(map.lanelets.contains(LaneletId(id)), Target::Lanelet(LaneletId(id)));
                    }
                    RelationType::Multipolygon if map.areas.contains(AreaId(id)) => return Resolved::Gone,
                    RelationType::Multipolygon => {
                        let kind = member.kind;
                        Condition::MemberDropped { kind, id, role }
                    }
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
            let has = |role: &str| relation.members.iter().any(|member| member.role == role);
            let condition =
                Condition::UnknownSubtype { subtype: subtype.clone(), has_bounds: has("left") && has("right") };
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
        if is_sign(subtype) {
            let signs = |(role, target): &(Text, Target)| match target {
                Target::LineString(LineStringId(id)) | Target::Polygon(PolygonId(id)) if role == "refers" => Some(*id),
                _ => None,
            };
            let sign = members.iter().find_map(signs);
            // The subtype of the sign counts before the tag of the element.
            let typed = match sign {
                Some(id) => self.osm.way(id).is_some_and(|way| way.tags.has("subtype")),
                None => relation.tags.has("sign_type"),
            };
            if !typed {
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
        // Of several stop lines of a right of way the first one counts.
        let loads = |fault: &LoadFault| {
            matches!(&fault.condition, Condition::MemberCount { count, .. } if *count > 0)
                && fault.condition.is_unsaid()
        };
        let is_created = self.loaded.faults[before..].iter().all(loads);
        if !is_created && relation.members.is_empty() {
            self.loaded.faults.truncate(before);
            self.fault(subject, &relation.span, Condition::WithoutMembers { subtype: subtype.clone() });
        }
        is_created
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
            let target = self.relation(id).filter(|_| kind == ElementKind::Relation);
            let is_element = target.is_some_and(|t| RelationType::of(&t.tags) == RelationType::RegulatoryElement);
            if !is_element {
                let meant = target.filter(|t| !t.tags.has("type")).and_then(infer_type::relation_type);
                let untyped = meant.is_some_and(|meant| meant == "regulatory_element");
                self.fault(subject, &relation.span, Condition::NotRegulatoryElement { kind, id, untyped });
            } else if self.loaded.map.regulatory_elements.contains(RegulatoryElementId(id)) {
                elements.push(RegulatoryElementId(id));
            } else {
                let dummies = &mut self.loaded.map.dummies;
                // Relations come by their ids.
                if dummies.elements.binary_search_by_key(&id, |element| element.id.0).is_ok() {
                    dummies.references.push((LaneletId(relation.id), RegulatoryElementId(id)));
                }
                let role = member.role.clone();
                self.fault(subject, &relation.span, Condition::MemberDropped { kind, id, role });
            }
        }
        let id = LaneletId(relation.id);
        let LaneletMap { lanelets, dummies, .. } = &mut self.loaded.map;
        if let Some(lanelet) = lanelets.get_mut(id) {
            lanelet.regulatory_elements = elements;
        } else if let Ok(at) = dummies.lanelets.binary_search_by_key(&id, |lanelet| lanelet.id) {
            dummies.lanelets[at].regulatory_elements = elements;
        }
    }
}

/// A lanelet with these bounds, left and right, and no elements yet.
fn bounded(relation: &Relation, [left, right]: [Bound; 2], centerline: Option<LineStringId>) -> Lanelet {
    Lanelet {
        id: LaneletId(relation.id),
        left,
        right,
        centerline,
        regulatory_elements: Vec::new(),
        attributes: relation.tags.clone(),
        span: Some(relation.span.clone()),
    }
}

fn subject_of(relation: &Relation) -> Subject {
    match RelationType::of(&relation.tags) {
        RelationType::Lanelet => Subject::Lanelet(relation.id),
        RelationType::RegulatoryElement => Subject::RegulatoryElement(relation.id),
        RelationType::Multipolygon | RelationType::Unknown => Subject::Relation(relation.id),
    }
}
