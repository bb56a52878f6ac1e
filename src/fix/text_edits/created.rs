//! Creates new elements.

use super::TextEdits;
use super::references::AREA;
use crate::diagnostic::{AreaCorner, Subject};
use crate::element_edits::key_of;
use crate::osm::element::{Child, Element};
use crate::osm::{ElementKind, Text};

impl TextEdits<'_> {
    pub(super) fn create(&mut self, subtype: &str, members: &[(Text, Subject)], referrers: &[i64]) -> Option<()> {
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
    pub(super) fn create_way(&mut self, points: &[i64], tags: &[(&str, &str)]) -> Option<i64> {
        let id = self.fresh(true)?;
        let mut element = Element::new("way", id, "\n  ");
        points.iter().for_each(|point| element.add_vertex(*point));
        tags.iter().for_each(|(key, value)| element.set_tag(key, value));
        self.created.push(((ElementKind::Way, id), element));
        Some(id)
    }

    pub(super) fn create_stop_line(&mut self, points: &[i64]) -> Option<i64> {
        self.create_way(points, &[("type", "stop_line"), ("subtype", "solid")])
    }

    pub(super) fn create_area(&mut self, points: &[i64], corners: &[AreaCorner], lanelets: &[i64]) -> Option<()> {
        let mut points = points.to_vec();
        let nodes = self.nodes_at(corners)?;
        for (corner, node) in corners.iter().zip(nodes).rev() {
            points.insert(corner.before.min(points.len()), node);
        }
        let id = self.create_way(&points, &[("type", AREA), ("area", "yes")])?;
        for lanelet in lanelets {
            self.element(Subject::Lanelet(*lanelet))?.set_tag(AREA, &id.to_string());
        }
        Some(())
    }

    /// The lanelet of the other direction, between the bounds of one that was for both: a copy of it. `None` where there is no such lanelet, or no id is left.
    pub(super) fn create_opposite(&mut self, lanelet: i64, elements: &[i64]) -> Option<()> {
        let mut element = self.element_of((ElementKind::Relation, lanelet))?.clone();
        let id = self.fresh(false)?;
        element.set_attribute("id", &id.to_string());
        element.set_tag("one_way", "yes");
        element.replace(|child| match child {
            Child::Member(ElementKind::Way, way, role) => {
                let other = match role.as_str() {
                    "left" => "right",
                    "right" => "left",
                    _ => return None,
                };
                Some(Child::Member(ElementKind::Way, *way, other.to_owned()))
            }
            _ => None,
        });
        element.remove(|child| match child {
            Child::Member(ElementKind::Way, _, role) => role == "centerline",
            Child::Member(ElementKind::Relation, id, _) => !elements.contains(id),
            Child::Tag(key) => key == "turn_direction",
            _ => false,
        });
        self.created.push(((ElementKind::Relation, id), element));
        Some(())
    }
}
