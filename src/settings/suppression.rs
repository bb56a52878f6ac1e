//! A finding that the map's owner answers for: which, on what, and why.

use serde::{Deserialize, Serialize};

use crate::diagnostic::Subject;

/// The position of a suppression.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// Name of the file.
    pub file: String,
    /// From 1.
    pub line: usize,
}

/// The kind of a primitive, in the words of reports.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PrimitiveKind {
    /// The map as a whole; it has no id.
    Map,
    /// A node that is a Lanelet2 point.
    Point,
    /// A way without `area=yes`.
    Linestring,
    /// A way with `area=yes`.
    Polygon,
    /// A relation with `type=lanelet`.
    Lanelet,
    /// A relation with `type=regulatory_element`.
    #[serde(rename = "regulatory element", alias = "regulatory_element")]
    RegulatoryElement,
    /// Any node.
    Node,
    /// Any way.
    Way,
    /// Any relation.
    Relation,
}

impl PrimitiveKind {
    /// A primitive of this kind; the map if no id is given.
    pub fn subject(self, id: Option<i64>) -> Subject {
        match (self, id) {
            (Self::Map, _) | (_, None) => Subject::Map,
            (Self::Point, Some(id)) => Subject::Point(id),
            (Self::Linestring, Some(id)) => Subject::LineString(id),
            (Self::Polygon, Some(id)) => Subject::Polygon(id),
            (Self::Lanelet, Some(id)) => Subject::Lanelet(id),
            (Self::RegulatoryElement, Some(id)) => Subject::RegulatoryElement(id),
            (Self::Node, Some(id)) => Subject::Node(id),
            (Self::Way, Some(id)) => Subject::Way(id),
            (Self::Relation, Some(id)) => Subject::Relation(id),
        }
    }
}

impl From<Subject> for PrimitiveKind {
    fn from(subject: Subject) -> Self {
        match subject {
            Subject::Map => Self::Map,
            Subject::Point(_) => Self::Point,
            Subject::LineString(_) => Self::Linestring,
            Subject::Polygon(_) => Self::Polygon,
            Subject::Lanelet(_) => Self::Lanelet,
            Subject::RegulatoryElement(_) => Self::RegulatoryElement,
            Subject::Node(_) => Self::Node,
            Subject::Way(_) => Self::Way,
            Subject::Relation(_) => Self::Relation,
        }
    }
}

/// One id or several.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(untagged)]
enum Ids {
    One(i64),
    Many(Vec<i64>),
}

/// One `[[suppress]]` of `lanewright.toml`.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Suppression {
    /// Prefix of the codes: a rule, or rule and slug.
    pub code: String,
    /// Kind of the primitive.
    pub primitive: PrimitiveKind,
    /// Its id, or several; none for the map.
    id: Option<Ids>,
    /// Why the finding is right to be there.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// Its position in the file; `None` unless read from a document.
    #[serde(skip)]
    pub origin: Option<Origin>,
}

impl Suppression {
    /// Whether the id of its primitive is missing.
    pub(super) fn is_without_id(&self) -> bool {
        self.id.is_none() && self.primitive != PrimitiveKind::Map
    }

    /// The primitives it is about.
    pub fn subjects(&self) -> Vec<Subject> {
        let ids: &[i64] = match &self.id {
            None => return vec![self.primitive.subject(None)],
            Some(Ids::One(id)) => std::slice::from_ref(id),
            Some(Ids::Many(ids)) => ids,
        };
        ids.iter().map(|&id| self.primitive.subject(Some(id))).collect()
    }
}
