//! Edits on the files of a map. Fixes that change the same thing are applied in different rounds.

mod division;
mod fresh;
mod ids;
mod opposite;
mod written;

use std::collections::BTreeMap;

use rustc_hash::{FxHashMap, FxHashSet};

use super::element::{Child, Element};
use crate::diagnostic::{Edit, Fix, SourceSpan, Subject};
use crate::osm::{ElementKind, OddityKind, OsmData, Tags};

pub use ids::IdRange;
use ids::Ids;

/// An element of a file: its kind and its id.
pub type Key = (ElementKind, i64);

/// A part of an element that an edit claims.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
enum Part {
    Tag(String),
    Place,
    Vertex(usize),
    Member(ElementKind, i64),
    /// The references to one element, wherever they stand.
    References(Key),
    /// A reference to a new element of this subtype.
    Created(String),
}

/// What one fix needs for itself.
#[derive(Debug, Default)]
struct Claim {
    /// Elements of which nobody else may change or name anything.
    whole: Vec<Key>,
    /// Parts of elements that nobody else may change.
    parts: Vec<(Key, Part)>,
    /// Elements that must stay as they are, since the fix names them.
    named: Vec<Key>,
}

/// What the fixes of this round have claimed.
#[derive(Debug, Default)]
struct Claims {
    whole: FxHashSet<Key>,
    parts: FxHashSet<(Key, Part)>,
    touched: FxHashSet<Key>,
}

impl Claims {
    fn allow(&self, claim: &Claim) -> bool {
        !claim.whole.iter().any(|key| self.touched.contains(key))
            && !claim.parts.iter().any(|part| self.whole.contains(&part.0) || self.parts.contains(part))
            && !claim.named.iter().any(|key| self.whole.contains(key))
    }

    fn add(&mut self, claim: Claim) {
        let Claim { whole, parts, named } = claim;
        self.touched.extend(whole.iter().copied().chain(parts.iter().map(|part| part.0)).chain(named));
        self.whole.extend(whole);
        self.parts.extend(parts);
    }
}

/// Edits on the files that `osm` was read from.
pub struct TextEdits<'a> {
    osm: &'a OsmData,
    /// Edited elements by position; `None` where one is removed.
    edited: BTreeMap<SourceSpan, Option<Element>>,
    /// What the current fix has changed, as it was before.
    journal: Vec<(SourceSpan, Option<Option<Element>>)>,
    created: Vec<(Key, Element)>,
    /// References to be rewritten: who refers, to what, and its new id. They are made at the end, all of one element at once.
    renames: Vec<(Key, Key, i64)>,
    /// Elements with a new id, by their old one.
    renumbered: Vec<(Key, i64)>,
    claims: Claims,
    referrers: FxHashMap<Key, Vec<Key>>,
    /// Elements that name a way in the value of a tag.
    named: FxHashMap<i64, Vec<Key>>,
    /// Positions of elements whose id repeats, in file order.
    repeated: FxHashMap<Key, Vec<&'a SourceSpan>>,
    ids: Ids,
    /// Up to where new ids go, where some were kept for the current fix.
    limit: Option<Ids>,
}

/// Tags whose value is the id of a way.
pub const NAMING: [&str; 2] = [AREA, "traffic_light_id"];

/// The type of an intersection's area, and the tag in which a lanelet names it.
const AREA: &str = "intersection_area";

impl<'a> TextEdits<'a> {
    /// Without edits.
    pub fn new(osm: &'a OsmData) -> Self {
        let mut referrers: FxHashMap<Key, Vec<Key>> = FxHashMap::default();
        for way in &osm.ways {
            for node in &way.nodes {
                referrers.entry((ElementKind::Node, *node)).or_default().push((ElementKind::Way, way.id));
            }
        }
        for relation in &osm.relations {
            for member in &relation.members {
                let list = referrers.entry((member.kind, member.id)).or_default();
                list.push((ElementKind::Relation, relation.id));
            }
        }
        let ways = osm.ways.iter().map(|way| ((ElementKind::Way, way.id), &way.tags));
        let tagged = ways.chain(osm.relations.iter().map(|one| ((ElementKind::Relation, one.id), &one.tags)));
        let mut named: FxHashMap<i64, Vec<Key>> = FxHashMap::default();
        for (key, tags) in tagged {
            for id in NAMING.iter().filter_map(|name| tags.get(name)?.parse().ok()) {
                named.entry(id).or_default().push(key);
            }
        }
        Self {
            osm,
            edited: BTreeMap::new(),
            journal: Vec::new(),
            created: Vec::new(),
            renames: Vec::new(),
            renumbered: Vec::new(),
            claims: Claims::default(),
            referrers,
            named,
            repeated: repeated(osm),
            ids: Ids::last_of(osm),
            limit: None,
        }
    }

    /// Makes all edits of a fix, or none of them; gives back the elements that it creates. `None` where another fix has a claim on what it needs, or where the map
    /// is not as the fix takes it to be.
    pub fn apply(&mut self, fix: &Fix) -> Option<Vec<Key>> {
        let mut claim = Claim::default();
        for edit in &fix.edits {
            self.claim(edit, &mut claim);
        }
        if !self.claims.allow(&claim) {
            return None;
        }
        self.journal.clear();
        let (created, renames, renumbered) = (self.created.len(), self.renames.len(), self.renumbered.len());
        let ids = self.ids;
        if !fix.edits.iter().all(|edit| self.edit(edit).is_some()) {
            for (span, element) in self.journal.drain(..).rev() {
                match element {
                    Some(element) => self.edited.insert(span, element),
                    None => self.edited.remove(&span),
                };
            }
            self.created.truncate(created);
            self.renames.truncate(renames);
            self.renumbered.truncate(renumbered);
            self.ids = ids;
            return None;
        }
        self.claims.add(claim);
        Some(self.created.iter().skip(created).map(|(key, _)| *key).collect())
    }

    /// What an edit needs for itself.
    fn claim(&self, edit: &Edit, claim: &mut Claim) {
        let Claim { whole, parts, named } = claim;
        let mut part = |on: Subject, part: Part| parts.extend(key_of(on).map(|key| (key, part)));
        match edit {
            Edit::SetTag { on, key, .. } | Edit::RemoveTag { on, key } => part(*on, Part::Tag(key.to_string())),
            Edit::SetPlace { point, .. } => part(Subject::Point(*point), Part::Place),
            Edit::PlaceBetween { point, from, to, .. } => {
                part(Subject::Point(*point), Part::Place);
                named.extend([from, to].map(|id| (ElementKind::Node, *id)));
            }
            Edit::AddMember { on, member, .. }
            | Edit::RemoveMember { on, member, .. }
            | Edit::SetRole { on, member, .. } => {
                if let Some((kind, id)) = key_of(*member) {
                    part(*on, Part::Member(kind, id));
                    named.push((kind, id));
                }
            }
            Edit::InsertVertex { way, position, point } => {
                part(*way, Part::Vertex(*position));
                named.push((ElementKind::Node, *point));
            }
            Edit::RemoveVertex { way, position } => part(*way, Part::Vertex(*position)),
            Edit::SetVertices { way, points } => {
                whole.extend(key_of(*way));
                named.extend(points.iter().map(|id| (ElementKind::Node, *id)));
            }
            Edit::MergePoints { from, to } => {
                let from = (ElementKind::Node, *from);
                whole.extend([from, (ElementKind::Node, *to)]);
                parts.extend(self.referrers_of(from).map(|referrer| (referrer, Part::References(from))));
            }
            Edit::ReplaceWay { lanelet, to, .. } => {
                whole.push((ElementKind::Relation, *lanelet));
                named.push((ElementKind::Way, *to));
            }
            Edit::Remove { subject } => {
                if let Some(key) = key_of(*subject) {
                    whole.push(key);
                    whole.extend(self.referrers.get(&key).into_iter().flatten());
                }
            }
            Edit::RemoveRepeat { on, .. } | Edit::ReverseWay { way: on } => whole.extend(key_of(*on)),
            Edit::Renumber { on, .. } => {
                if let Some(key) = key_of(*on) {
                    whole.push(key);
                    parts.extend(self.referrers_of(key).map(|referrer| (referrer, Part::References(key))));
                    let tagged = self.named.get(&key.1).into_iter().flatten().filter(|_| key.0 == ElementKind::Way);
                    parts.extend(tagged.flat_map(|one| NAMING.map(|name| (*one, Part::Tag(name.to_owned())))));
                }
            }
            Edit::CreateStopLine { .. } | Edit::CreateRegulatoryElement { .. } | Edit::CreateArea { .. } => {
                claim_for_created(edit, claim);
            }
            Edit::CreateOpposite { lanelet, .. } => whole.push((ElementKind::Relation, *lanelet)),
            Edit::Divide(division) => self.claim_division(division, claim),
        }
    }

    fn replace_way(&mut self, lanelet: i64, from: i64, to: i64) -> Option<()> {
        let other = |child: &Child| match child {
            Child::Member(ElementKind::Way, id, role) if *id == from => {
                Some(Child::Member(ElementKind::Way, to, role.clone()))
            }
            _ => None,
        };
        self.element(Subject::Relation(lanelet))?.replace(other).then_some(())
    }

    fn set_vertices(&mut self, way: Subject, points: &[i64]) -> Option<()> {
        if self.borders_area(key_of(way)?) {
            return None;
        }
        self.element(way)?.set_vertices(points);
        Some(())
    }

    /// Whether a way is part of the outline of a multipolygon, which has to stay closed: no rule knows of it.
    fn borders_area(&self, way: Key) -> bool {
        let is_area = |(kind, id): Key| {
            let relation = (kind == ElementKind::Relation).then(|| self.osm.relation(id)).flatten();
            relation.is_some_and(|relation| relation.tags.is("type", "multipolygon"))
        };
        way.0 == ElementKind::Way && self.referrers_of(way).any(is_area)
    }

    /// The elements that are made of one: of a node the ways over it and the lanelets between these.
    pub fn made_of(&self, key: Key) -> Vec<Key> {
        let mut users: Vec<Key> = self.referrers_of(key).collect();
        if key.0 == ElementKind::Node {
            users.extend(self.referrers_of(key).flat_map(|way| self.referrers_of(way)));
        }
        users
    }

    fn referrers_of(&self, key: Key) -> impl Iterator<Item = Key> + '_ {
        self.referrers.get(&key).into_iter().flatten().copied()
    }

    /// Makes one edit; `None` where it cannot be made.
    fn edit(&mut self, edit: &Edit) -> Option<()> {
        let done = |done: bool| done.then_some(());
        match edit {
            Edit::SetTag { on, key, value } => self.element(*on)?.set_tag(key, value),
            Edit::RemoveTag { on, key } => {
                let tag = Child::Tag(key.to_string());
                done(self.element(*on)?.remove(|child| *child == tag))?;
            }
            Edit::AddMember { on, role, member } => {
                let (kind, id) = key_of(*member)?;
                self.element(*on)?.add_member(kind, id, role);
            }
            Edit::RemoveMember { on, role, member } => {
                let (kind, id) = key_of(*member)?;
                let member = Child::Member(kind, id, role.to_string());
                done(self.element(*on)?.remove(|child| *child == member))?;
            }
            Edit::SetRole { on, member, from, to } => {
                let (kind, id) = key_of(*member)?;
                let [from, to] = [from, to].map(|role| Child::Member(kind, id, role.to_string()));
                done(self.element(*on)?.replace(|child| (*child == from).then(|| to.clone())))?;
            }
            Edit::MergePoints { from, to } => self.merge(*from, *to)?,
            Edit::InsertVertex { way, position, point } => {
                done(self.element(*way)?.insert_vertex(*position, *point))?;
            }
            Edit::RemoveVertex { way, position } => done(self.element(*way)?.remove_vertex(*position))?,
            Edit::SetVertices { way, points } => self.set_vertices(*way, points)?,
            Edit::ReplaceWay { lanelet, from, to } => self.replace_way(*lanelet, *from, *to)?,
            Edit::ReverseWay { way } => self.element(*way)?.reverse_vertices(),
            Edit::Remove { subject } => self.remove(key_of(*subject)?)?,
            Edit::SetPlace { point, place } => self.element(Subject::Point(*point))?.set_place(place.lat, place.lon),
            Edit::PlaceBetween { point, from, to, share } => self.place_between(*point, [*from, *to], *share)?,
            Edit::CreateStopLine { points, element } => {
                let line = self.create_way(points, &[("type", "stop_line"), ("subtype", "solid")])?;
                self.element(*element)?.add_member(ElementKind::Way, line, "ref_line");
            }
            Edit::RemoveRepeat { on, nth } => {
                let span = self.nth(key_of(*on)?, *nth)?;
                self.element_at(&span)?;
                self.edited.insert(span, None);
            }
            Edit::Renumber { on, nth, referrers } => self.renumber(key_of(*on)?, *nth, referrers.as_deref())?,
            Edit::CreateRegulatoryElement { subtype, members, referrers } => {
                self.create(subtype, members, referrers)?
            }
            Edit::CreateArea { points, lanelets } => self.create_area(points, lanelets)?,
            Edit::CreateOpposite { lanelet, elements } => self.create_opposite(*lanelet, elements)?,
            Edit::Divide(division) => self.divide(division)?,
        }
        Some(())
    }

    fn merge(&mut self, from: i64, to: i64) -> Option<()> {
        let key = (ElementKind::Node, from);
        for referrer in self.referrers.get(&key).cloned().unwrap_or_default() {
            let element = self.element_of(referrer)?;
            element.replace(|child| match child {
                Child::Vertex(id) if *id == from => Some(Child::Vertex(to)),
                Child::Member(ElementKind::Node, id, role) if *id == from => {
                    Some(Child::Member(ElementKind::Node, to, role.clone()))
                }
                _ => None,
            });
            element.drop_repeats();
        }
        self.drop(key)
    }

    fn drop(&mut self, key: Key) -> Option<()> {
        let span = self.span(key)?.clone();
        self.element_at(&span)?;
        self.edited.insert(span, None);
        Some(())
    }

    /// Gives one element of this id another one, and says so in those that refer to it: in all, or in these.
    fn renumber(&mut self, key: Key, nth: usize, referrers: Option<&[Subject]>) -> Option<()> {
        let (kind, id) = key;
        let fresh = self.fresh(kind == ElementKind::Way)?;
        let span = self.nth(key, nth)?;
        self.element_at(&span)?.set_attribute("id", &fresh.to_string());
        let told: Vec<Key> = match referrers {
            Some(some) => some.iter().filter_map(|one| key_of(*one)).collect(),
            None => self.referrers.get(&key).cloned().unwrap_or_default(),
        };
        self.renumbered.push((key, fresh));
        self.renames.extend(told.into_iter().map(|referrer| (referrer, key, fresh)));
        let named = self.named.get(&id).filter(|_| kind == ElementKind::Way && referrers.is_none());
        for key in named.cloned().unwrap_or_default() {
            let osm = self.osm;
            let tags = match key.0 {
                ElementKind::Way => osm.way(key.1).map(|one| &one.tags),
                _ => osm.relation(key.1).map(|one| &one.tags),
            }?;
            for name in NAMING.into_iter().filter(|name| tags.get(name).is_some_and(|value| value == id.to_string())) {
                self.element_of(key)?.set_tag(name, &fresh.to_string());
            }
        }
        Some(())
    }

    fn remove(&mut self, key: Key) -> Option<()> {
        if self.borders_area(key) {
            return None;
        }
        for referrer in self.referrers.get(&key).cloned().unwrap_or_default() {
            // One that was itself removed refers to nothing.
            if let Some(element) = self.element_of(referrer) {
                element.remove(|child| match child {
                    Child::Vertex(id) => (ElementKind::Node, *id) == key,
                    Child::Member(kind, id, _) => (*kind, *id) == key,
                    _ => false,
                });
            }
        }
        self.drop(key)
    }

    fn create(&mut self, subtype: &str, members: &[(crate::osm::Text, Subject)], referrers: &[i64]) -> Option<()> {
        let id = self.fresh(false)?;
        let mut element = Element::new("relation", id, "\n  ");
        for (role, member) in members {
            let (kind, id) = key_of(*member)?;
            element.add_member(kind, id, role);
        }
        element.set_tag("type", "regulatory_element");
        element.set_tag("subtype", subtype);
        self.created.push(((ElementKind::Relation, id), element));
        for referrer in referrers {
            let lanelet = self.element(Subject::Relation(*referrer))?;
            lanelet.add_member(ElementKind::Relation, id, "regulatory_element");
        }
        Some(())
    }

    /// A way of its own; its id fits 32 bits, with which Autoware reads that of an area.
    fn create_way(&mut self, points: &[i64], tags: &[(&str, &str)]) -> Option<i64> {
        let id = self.fresh(true)?;
        let mut element = Element::new("way", id, "\n  ");
        points.iter().for_each(|point| element.add_vertex(*point));
        tags.iter().for_each(|(key, value)| element.set_tag(key, value));
        self.created.push(((ElementKind::Way, id), element));
        Some(id)
    }

    /// Moves a point by latitude and longitude where the others have them, and by local coordinates and height where all three do.
    fn place_between(&mut self, point: i64, ends: [i64; 2], share: f64) -> Option<()> {
        let osm = self.osm;
        let [from, to] = [osm.node(ends[0])?, osm.node(ends[1])?];
        let between = |a: f64, b: f64| a + (b - a) * share;
        let places = from.position.zip(to.position);
        let own = &osm.node(point)?.tags;
        if places.is_none() && !(own.has("local_x") && own.has("local_y")) {
            return None;
        }
        let element = self.element(Subject::Point(point))?;
        if let Some((a, b)) = places {
            element.set_place(between(a.lat, b.lat), between(a.lon, b.lon));
        }
        for key in ["local_x", "local_y", "ele"].into_iter().filter(|key| own.has(key)) {
            let number = |tags: &Tags| tags.get(key)?.trim().parse::<f64>().ok();
            if let Some((a, b)) = number(&from.tags).zip(number(&to.tags)) {
                element.set_tag(key, &format!("{:.4}", between(a, b)));
            }
        }
        Some(())
    }

    fn create_area(&mut self, points: &[i64], lanelets: &[i64]) -> Option<()> {
        let id = self.create_way(points, &[("type", AREA), ("area", "yes")])?;
        for lanelet in lanelets {
            self.element(Subject::Lanelet(*lanelet))?.set_tag(AREA, &id.to_string());
        }
        Some(())
    }

    fn element(&mut self, subject: Subject) -> Option<&mut Element> {
        self.element_of(key_of(subject)?)
    }

    /// The element to edit; `None` if it is removed, or not in the files.
    fn element_of(&mut self, key: Key) -> Option<&mut Element> {
        let span = self.span(key)?.clone();
        self.element_at(&span)
    }

    fn element_at(&mut self, span: &SourceSpan) -> Option<&mut Element> {
        self.journal.push((span.clone(), self.edited.get(span).cloned()));
        if !self.edited.contains_key(span) {
            let source = &self.osm.sources.get(span.file as usize)?.text;
            let (start, end) = (usize::try_from(span.start).ok()?, usize::try_from(span.end).ok()?);
            let before = source.get(..start)?;
            // The line end, too; a file in one line has none.
            let blanks = before.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']).len();
            let element = Element::parse(source.get(start..end)?, before.get(blanks..)?)?;
            self.edited.insert(span.clone(), Some(element));
        }
        self.edited.get_mut(span)?.as_mut()
    }

    /// The position of an element; the last one, where an id repeats.
    fn span(&self, (kind, id): Key) -> Option<&'a SourceSpan> {
        match kind {
            ElementKind::Node => self.osm.node(id).map(|node| &node.span),
            ElementKind::Way => self.osm.way(id).map(|way| &way.span),
            ElementKind::Relation => self.osm.relation(id).map(|relation| &relation.span),
        }
    }

    /// The position of the nth element of an id, in file order.
    fn nth(&self, key: Key, nth: usize) -> Option<SourceSpan> {
        match self.repeated.get(&key) {
            Some(spans) => spans.get(nth).copied().cloned(),
            None => self.span(key).filter(|_| nth == 0).cloned(),
        }
    }

    /// The new ids of the elements that have one, by kind and old id.
    pub fn renumbered(&self) -> FxHashMap<Key, i64> {
        self.renumbered.iter().copied().collect()
    }

    /// Rewrites the references to elements that have a new id.
    fn rename(&mut self) {
        let mut renames: FxHashMap<Key, FxHashMap<Key, i64>> = FxHashMap::default();
        for (referrer, old, fresh) in self.renames.drain(..) {
            renames.entry(referrer).or_default().insert(old, fresh);
        }
        for (referrer, fresh) in renames {
            let Some(element) = self.element_of(referrer) else { continue };
            element.replace(|child| match child {
                Child::Vertex(old) => Some(Child::Vertex(*fresh.get(&(ElementKind::Node, *old))?)),
                Child::Member(kind, old, role) => Some(Child::Member(*kind, *fresh.get(&(*kind, *old))?, role.clone())),
                _ => None,
            });
        }
    }
}

/// What an edit that makes a new element needs of those that are there.
fn claim_for_created(edit: &Edit, claim: &mut Claim) {
    let Claim { parts, named, .. } = claim;
    match edit {
        Edit::CreateStopLine { points, element } => {
            parts.extend(key_of(*element).map(|key| (key, Part::Created("stop_line".to_owned()))));
            named.extend(points.iter().map(|id| (ElementKind::Node, *id)));
        }
        Edit::CreateRegulatoryElement { subtype, referrers, members } => {
            // A lanelet has an element for each crosswalk that it crosses, and one of each other kind.
            let crosswalk = members.iter().find(|(role, _)| subtype == "crosswalk" && role == "refers");
            let created = Part::Created(match crosswalk.and_then(|(_, member)| member.id()) {
                Some(id) => format!("{subtype} {id}"),
                None => subtype.to_string(),
            });
            parts.extend(referrers.iter().map(|id| ((ElementKind::Relation, *id), created.clone())));
            named.extend(members.iter().filter_map(|(_, member)| key_of(*member)));
        }
        Edit::CreateArea { points, lanelets } => {
            let tag = Part::Tag(AREA.to_owned());
            parts.extend(lanelets.iter().map(|id| ((ElementKind::Relation, *id), tag.clone())));
            named.extend(points.iter().map(|id| (ElementKind::Node, *id)));
        }
        _ => {}
    }
}

fn repeated(osm: &OsmData) -> FxHashMap<Key, Vec<&SourceSpan>> {
    let twice = osm.oddities.iter().filter(|odd| odd.kind == OddityKind::DuplicateId).filter_map(|odd| odd.element);
    let mut spans: FxHashMap<Key, Vec<&SourceSpan>> = twice.map(|key| (key, Vec::new())).collect();
    let nodes = osm.nodes.iter().map(|one| ((ElementKind::Node, one.id), &one.span));
    let ways = osm.ways.iter().map(|one| ((ElementKind::Way, one.id), &one.span));
    let relations = osm.relations.iter().map(|one| ((ElementKind::Relation, one.id), &one.span));
    for (key, span) in nodes.chain(ways).chain(relations) {
        if let Some(list) = spans.get_mut(&key) {
            list.push(span);
        }
    }
    spans
}

/// The element of the file that a subject is.
pub fn key_of(subject: Subject) -> Option<Key> {
    match subject {
        Subject::Map => None,
        Subject::Point(id) | Subject::Node(id) => Some((ElementKind::Node, id)),
        Subject::LineString(id) | Subject::Polygon(id) | Subject::Way(id) => Some((ElementKind::Way, id)),
        Subject::Lanelet(id) | Subject::RegulatoryElement(id) | Subject::Relation(id) => {
            Some((ElementKind::Relation, id))
        }
    }
}
