//! Creates the lanelet of the other direction between the bounds of one that was for both.

use crate::osm::ElementKind;

use super::TextEdits;
use crate::fix::element::Child;

impl TextEdits<'_> {
    /// Makes it of a copy; `None` where there is no such lanelet, or no id is left.
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
