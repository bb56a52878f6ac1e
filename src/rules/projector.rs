//! projector: the file beside the map names the projector that the map was made with.

use serde::Deserialize;

use crate::diagnostic::{Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::{Condition, InfoError, InfoFault};

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    far_origin: f64,
    lost_origin: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    // Which projector the map needs shows once its latitudes stand in their place.
    if map.faults.iter().any(|fault| matches!(fault.condition, Condition::ExchangedDegrees { .. })) {
        return Vec::new();
    }
    let faults = map.faults.iter().filter_map(|fault| match &fault.condition {
        Condition::ProjectorInfo(fault) => finding(fault, params),
        _ => None,
    });
    faults.collect()
}

fn finding(fault: &InfoFault, params: &Params) -> Option<Finding> {
    let found = |slug, message: String| Finding::new(slug, Subject::Map, message);
    Some(match fault {
        InfoFault::Missing { needed: Some(needed), .. } if needed.name() == "Local" => found(
            "missing",
            "No map_projector_info.yaml stands beside the map, whose points have no latitude and longitude: Local."
                .to_owned(),
        ),
        InfoFault::Missing { needed: Some(needed), squares } if !squares.is_empty() => {
            let names: Vec<String> = squares.iter().map(ToString::to_string).collect();
            let message = format!(
                "No map_projector_info.yaml stands beside the map, which lies in {} MGRS squares ({}); Autoware would fold them into one. It is judged as {needed}.",
                names.len(),
                names.join(", ")
            );
            found("missing", message)
        }
        InfoFault::Missing { needed: Some(needed), .. } => found(
            "missing",
            format!("No map_projector_info.yaml stands beside the map, whose local_x, local_y are those of {needed}."),
        ),
        InfoFault::Missing { needed: None, .. } => {
            found("missing", "No map_projector_info.yaml stands beside the map.".to_owned()).graded(Severity::Warning)
        }
        InfoFault::Misnamed { found: name } => {
            found("misnamed", format!("The file {name} is not read; Autoware looks for map_projector_info.yaml."))
        }
        InfoFault::Unusable(error) => {
            let slug = match error {
                InfoError::Line { .. } | InfoError::Linked => "syntax",
                InfoError::Missing { .. } => "key",
                InfoError::Type { .. } => "type",
                InfoError::Value { .. } | InfoError::Grid(_) => "value",
            };
            found(slug, format!("map_projector_info.yaml: {error}."))
        }
        InfoFault::Unread { key, meant } => {
            found("unread", format!("map_projector_info.yaml: nobody reads `{key}`; is `{meant}` meant?"))
        }
        InfoFault::AtOdds { said, meant } => {
            found("at-odds", format!("map_projector_info.yaml says {said}, but local_x, local_y are those of {meant}."))
        }
        InfoFault::OtherGrid { said, meant } => {
            found("other-grid", format!("map_projector_info.yaml says MGRS {said}, but the map lies in {meant}."))
        }
        InfoFault::FarOrigin { distance } if *distance <= params.far_origin => return None,
        InfoFault::FarOrigin { distance } => {
            let message = format!("The origin of map_projector_info.yaml lies {:.0} km from the map.", distance / 1e3);
            let lost = *distance > params.lost_origin;
            let severity = if lost { Severity::Error } else { Severity::Warning };
            found("far-origin", message).measured(*distance, params.far_origin, "m").graded(severity)
        }
    })
}
