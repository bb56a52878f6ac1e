//! What each edit claims.

use super::TextEdits;
use super::claims::{Claim, Part};
use super::references::{AREA, NAMING};
use crate::diagnostic::{Edit, Subject};
use crate::element_edits::key_of;
use crate::osm::ElementKind;

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
                if let Some((kind, id)) = key_of(*way) {
                    whole.push((kind, id));
                    parts.extend(self.areas_along((kind, id)).map(|area| (area, Part::Member(kind, id))));
                }
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
            Edit::Divide(division) => self.claim_division(division, claim),
            _ => self.claim_for_created(edit, claim),
        }
    }

    /// What an edit that makes a new element needs of those that are there.
    fn claim_for_created(&self, edit: &Edit, claim: &mut Claim) {
        let Claim { whole, parts, named } = claim;
        match edit {
            Edit::CreateStopLine { points, element } => {
                parts.extend(key_of(*element).map(|key| (key, Part::Created("stop_line".to_owned()))));
                named.extend(points.iter().map(|id| (ElementKind::Node, *id)));
            }
            Edit::CreateMarking { points, lanelets } => {
                let created = Part::Created("road_marking".to_owned());
                parts.extend(lanelets.iter().map(|id| ((ElementKind::Relation, *id), created.clone())));
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
            Edit::CreateArea { points, corners, lanelets } => {
                let along = corners.iter().flat_map(|one| self.ways_along(one.ends));
                whole.extend(along.map(|way| (ElementKind::Way, way)));
                named.extend(corners.iter().flat_map(|one| one.ends).map(|id| (ElementKind::Node, id)));
                let tag = Part::Tag(AREA.to_owned());
                parts.extend(lanelets.iter().map(|id| ((ElementKind::Relation, *id), tag.clone())));
                named.extend(points.iter().map(|id| (ElementKind::Node, *id)));
            }
            Edit::CreateOpposite { lanelet, .. } => whole.push((ElementKind::Relation, *lanelet)),
            // No other fix changes the head of a file.
            _ => {}
        }
    }
}
