//! Edits on the files of a map. Fixes that change the same thing are applied in different rounds.

mod claims;
mod created;
mod division;
mod edit_claims;
mod format_version;
mod ids;
mod new_ids;
mod references;
mod renumbered;
mod written;

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Fix, SourceSpan, Subject};
use crate::element_edits::{edit_element, edited_element};
use crate::osm::element::{Child, Element};
use crate::osm::{ElementKind, OsmData, Tags};

pub use crate::element_edits::{Key, key_of};
use claims::{Claim, Claims};
pub use ids::IdRange;
use ids::Ids;
pub use references::NAMING;
use references::{References, repeated};

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
    references: References,
    /// Positions of elements whose id repeats, in file order.
    repeated: FxHashMap<Key, Vec<&'a SourceSpan>>,
    ids: Ids,
    /// Up to where new ids go, where some were kept for the current fix.
    limit: Option<Ids>,
}

impl<'a> TextEdits<'a> {
    /// Without edits.
    pub fn new(osm: &'a OsmData) -> Self {
        Self {
            osm,
            edited: BTreeMap::new(),
            journal: Vec::new(),
            created: Vec::new(),
            renames: Vec::new(),
            renumbered: Vec::new(),
            claims: Claims::default(),
            references: References::of(osm),
            repeated: repeated(osm),
            ids: Ids::last_of(osm),
            limit: None,
        }
    }

    /// Makes all edits of a fix, or none of them; gives back the elements that it creates. `None` where another fix has a claim on
    /// what it needs, or where the map is not as the fix takes it to be.
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

    fn set_vertices(&mut self, way: Subject, points: &[i64]) -> Option<()> {
        self.leave_outlines(key_of(way)?)?;
        self.element(way)?.set_vertices(points);
        Some(())
    }

    /// Gives the multipolygons along a way a copy of it, so that their outlines stay as they are when it changes: no rule knows of them.
    fn leave_outlines(&mut self, way: Key) -> Option<()> {
        let areas: Vec<Key> = self.areas_along(way).collect();
        if areas.is_empty() {
            return Some(());
        }
        let mut copy = self.element_of(way)?.clone();
        let id = self.fresh(true)?;
        copy.set_attribute("id", &id.to_string());
        self.created.push(((ElementKind::Way, id), copy));
        for area in areas {
            self.element_of(area)?.replace(|child| match child {
                Child::Member(kind, member, role) if (*kind, *member) == way => {
                    Some(Child::Member(ElementKind::Way, id, role.clone()))
                }
                _ => None,
            });
        }
        Some(())
    }

    /// The multipolygons of which a way is part of the outline.
    pub(super) fn areas_along(&self, way: Key) -> impl Iterator<Item = Key> + '_ {
        let is_area = |(kind, id): &Key| {
            let relation = (*kind == ElementKind::Relation).then(|| self.osm.relation(*id)).flatten();
            relation.is_some_and(|relation| relation.tags.is("type", "multipolygon"))
        };
        self.referrers_of(way).filter(move |key| way.0 == ElementKind::Way && is_area(key))
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
        self.references.referrers(key).iter().copied()
    }

    /// Makes one edit; `None` where it cannot be made.
    fn edit(&mut self, edit: &Edit) -> Option<()> {
        if let Some(only) = edited_element(edit) {
            return edit_element(self.element(only)?, edit);
        }
        match edit {
            Edit::MergePoints { from, to } => self.merge(*from, *to)?,
            Edit::SetVertices { way, points } => self.set_vertices(*way, points)?,
            Edit::ReverseWay { way } => self.element(*way)?.reverse_vertices(),
            Edit::Remove { subject } => self.remove(key_of(*subject)?)?,
            Edit::SetPlace { point, place } => self.element(Subject::Point(*point))?.set_place(place.lat, place.lon),
            Edit::PlaceBetween { point, from, to, share } => self.place_between(*point, [*from, *to], *share)?,
            Edit::CreateMarking { points, lanelets } => {
                let line = self.create_stop_line(points)?;
                self.create("road_marking", &[("refers".into(), Subject::LineString(line))], lanelets)?;
            }
            Edit::CreateStopLine { points, element } => {
                let line = self.create_stop_line(points)?;
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
            Edit::CreateArea { points, corners, lanelets } => self.create_area(points, corners, lanelets)?,
            Edit::CreateOpposite { lanelet, elements } => self.create_opposite(*lanelet, elements)?,
            Edit::Divide(division) => self.divide(division)?,
            Edit::SetFormatVersion { version } => self.set_format_version(version)?,
            // One of those above.
            _ => return None,
        }
        Some(())
    }

    fn merge(&mut self, from: i64, to: i64) -> Option<()> {
        let key = (ElementKind::Node, from);
        for referrer in self.referrers_of(key).collect::<Vec<_>>() {
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

    /// Removes an element, and all references to it. A way that is part of the outline of a multipolygon stays that.
    fn remove(&mut self, key: Key) -> Option<()> {
        let areas: Vec<Key> = self.areas_along(key).collect();
        for referrer in self.referrers_of(key).filter(|one| !areas.contains(one)).collect::<Vec<_>>() {
            // One that was itself removed refers to nothing.
            if let Some(element) = self.element_of(referrer) {
                element.remove(|child| match child {
                    Child::Vertex(id) => (ElementKind::Node, *id) == key,
                    Child::Member(kind, id, _) => (*kind, *id) == key,
                    _ => false,
                });
            }
        }
        if areas.is_empty() { self.drop(key) } else { Some(()) }
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
}
