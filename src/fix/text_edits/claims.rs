//! What each fix needs for itself, so that two fixes of one round do not change the same thing.

use rustc_hash::FxHashSet;

use super::references::NAMING;
use super::{AREA, Key, TextEdits, key_of};
use crate::diagnostic::{Edit, Subject};
use crate::osm::ElementKind;

/// A part of an element that an edit claims.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(super) enum Part {
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
pub(super) struct Claim {
    /// Elements of which nobody else may change or name anything.
    pub(super) whole: Vec<Key>,
    /// Parts of elements that nobody else may change.
    pub(super) parts: Vec<(Key, Part)>,
    /// Elements that must stay as they are, since the fix names them.
    named: Vec<Key>,
}

/// What the fixes of this round have claimed.
#[derive(Debug, Default)]
pub(super) struct Claims {
    whole: FxHashSet<Key>,
    parts: FxHashSet<(Key, Part)>,
    touched: FxHashSet<Key>,
}

impl Claims {
    pub(super) fn allow(&self, claim: &Claim) -> bool {
        !claim.whole.iter().any(|key| self.touched.contains(key))
            && !claim.parts.iter().any(|part| self.whole.contains(&part.0) || self.parts.contains(part))
            && !claim.named.iter().any(|key| self.whole.contains(key))
    }

    pub(super) fn add(&mut self, claim: Claim) {
        let Claim { whole, parts, named } = claim;
        self.touched.extend(whole.iter().copied().chain(parts.iter().map(|part| part.0)).chain(named));
        self.whole.extend(whole);
        self.parts.extend(parts);
    }
}

impl TextEdits<'_> {
    /// What an edit needs for itself.
    pub(super) fn claim(&self, edit: &Edit, claim: &mut Claim) {
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
                    whole.extend(self.referrers_of(key));
                }
            }
            Edit::RemoveRepeat { on, .. } | Edit::ReverseWay { way: on } => whole.extend(key_of(*on)),
            Edit::Renumber { on, .. } => {
                if let Some(key) = key_of(*on) {
                    whole.push(key);
                    parts.extend(self.referrers_of(key).map(|referrer| (referrer, Part::References(key))));
                    let tagged = self.references.named(key).iter();
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
