//! How large a regulatory element may be: as far as its members reach, and the lanelets that refer to it.

use crate::diagnostic::{Finding, Subject};
use crate::lanelet::index::view::View;
use crate::lanelet::{RegulatoryElement, TargetKind};

/// Diagonal (m) of an element by its lines in these roles and the lanelets that refer to it; `None` where none of them has a place.
pub(super) fn diagonal_of_lines(view: &View, element: &RegulatoryElement, roles: &[&str]) -> Option<f64> {
    view.diagonal_of(element, |member| roles.contains(&member.role.as_str()) && TargetKind::Line.holds(member.target))
}

/// The finding that an element spreads over too many metres. An element that is nowhere has no size that could be small enough.
pub(super) fn too_large(
    fault: &'static str,
    element: &RegulatoryElement,
    diagonal: Option<f64>,
    limit: f64,
) -> Option<Finding> {
    let (id, subtype) = (element.id, &element.subtype);
    let about = |message| Finding::new(fault, Subject::RegulatoryElement(id.0), message);
    let Some(diagonal) = diagonal else {
        return Some(about(format!("{subtype} {id} is nowhere: no lanelet refers to it, and no member of it counts.")));
    };
    let message = || format!("{subtype} {id} and its lanelets spread over {diagonal:.0} m.");
    (diagonal > limit).then(|| about(message()).measured(diagonal, limit, "m"))
}
