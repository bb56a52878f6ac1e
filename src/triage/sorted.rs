//! Findings, sorted into those that are reported and those that the user has answered for.

use crate::diagnostic::{Accepted, Diagnostic, Subject};

/// What is left of a run's findings.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sorted {
    /// The findings that count, in the order of the run, then what there is to say of suppressions and the baseline.
    pub left: Vec<Diagnostic>,
    /// How many a suppression took out.
    pub suppressed: usize,
    /// How many the baseline knows.
    pub known: usize,
    /// Those of them for which it gives a reason.
    pub reasons: Vec<Accepted>,
}

/// The element of the file that a primitive is, whatever it means in Lanelet2.
pub(crate) fn element(subject: Subject) -> Option<(crate::osm::ElementKind, i64)> {
    use crate::osm::ElementKind::{Node, Relation, Way};
    Some(match subject {
        Subject::Map => return None,
        Subject::Point(id) | Subject::Node(id) => (Node, id),
        Subject::LineString(id) | Subject::Polygon(id) | Subject::Way(id) => (Way, id),
        Subject::Lanelet(id) | Subject::RegulatoryElement(id) | Subject::Relation(id) => (Relation, id),
    })
}
