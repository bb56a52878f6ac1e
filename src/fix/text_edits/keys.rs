//! Elements of a file by kind and id.

use crate::diagnostic::Subject;
use crate::osm::ElementKind;

/// An element of a file: its kind and its id.
pub type Key = (ElementKind, i64);

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
