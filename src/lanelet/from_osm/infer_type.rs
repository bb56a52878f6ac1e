//! Infers the missing `type` or `subtype` of a relation from its members.

use crate::lanelet::element_roles::role_limits;
use crate::osm::{ElementKind, OsmData, Relation, Text};

/// The `type` of a relation that has none.
pub fn relation_type(relation: &Relation) -> Option<Text> {
    let has = |role: &str| relation.members.iter().any(|member| member.role == role);
    if has("left") && has("right") {
        return Some("lanelet".into());
    }
    let known = relation.tags.get("subtype").is_some_and(|subtype| role_limits(subtype).is_some());
    (known && !relation.members.is_empty()).then(|| "regulatory_element".into())
}

/// The `subtype` of an element that has none, by its roles or by what it refers to.
pub fn subtype(osm: &OsmData, relation: &Relation) -> Option<Text> {
    let has = |role: &str| relation.members.iter().any(|member| member.role == role);
    if has("right_of_way") && has("yield") {
        return Some("right_of_way".into());
    }
    if has("start_line") && has("end_line") {
        return Some("virtual_traffic_light".into());
    }
    let member = relation.members.iter().find(|member| member.role == "refers")?;
    let tags = match member.kind {
        ElementKind::Node => return None,
        ElementKind::Way => &osm.way(member.id)?.tags,
        ElementKind::Relation => &osm.relation(member.id)?.tags,
    };
    match tags.get("type")? {
        "lanelet" if matches!(tags.get("subtype"), Some("crosswalk" | "walkway")) => Some("crosswalk".into()),
        "stop_line" => Some("road_marking".into()),
        // Lights, signs and areas have the same names as their elements.
        kind => role_limits(kind).map(|_| kind.into()),
    }
}
