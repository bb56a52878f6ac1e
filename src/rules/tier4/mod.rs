//! The profile `tier4`: the rules read as the existing validator reads them, so that a team can swap the tool.
//!
//! Nothing is required here that a document of `rules/` does not say. Where the validator measures a requirement in
//! another way, a reading of this folder does so, and its issues come out as faults of our rules; `validators.toml` holds
//! which. What both judge alike is judged by the rule itself.

mod areas;
mod centerline;
mod elements;
mod facing;
mod lanes;
mod layer;
mod neighbours;
mod section;
mod validator;
mod walkway;
mod yields;

use rayon::prelude::*;

use crate::diagnostic::{Diagnostic, Finding, Severity};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::View;
use crate::lanelet::placed::placed;
use crate::parallel::InSmallParts;

use super::{Config, ConfigError, Row, load};
use validator::issue;
pub use validator::{Issue, Params, PeerSeverity, Validator, missing, validators};

/// A requirement as the existing validator reads it.
type Reading = fn(&View, &Params) -> Vec<Issue>;

/// Validators with a reading of their own.
const READINGS: &[(&str, Reading)] = &[
    ("mapping.intersection.intersection_area_dangling_reference", areas::dangling_reference),
    ("mapping.intersection.intersection_area_tagging", areas::tagging),
    ("mapping.intersection.turn_direction_tagging", areas::turn_direction),
    ("mapping.intersection.lanelet_border_type", areas::border_type),
    ("mapping.intersection.lanelet_division", areas::division),
    ("mapping.intersection.intersection_area_validity", areas::validity),
    ("mapping.intersection.intersection_area_segment_type", areas::segment_type),
    ("mapping.intersection.right_of_way_with_traffic_lights", yields::with_traffic_lights),
    ("mapping.intersection.right_of_way_without_traffic_lights", yields::without_traffic_lights),
    ("mapping.intersection.road_markings", elements::road_markings),
    ("mapping.intersection.regulatory_element_details_for_virtual_traffic_lights", elements::virtual_traffic_lights),
    ("mapping.intersection.virtual_traffic_light_line_order", section::line_order),
    ("mapping.intersection.right_of_way_for_virtual_traffic_lights", yields::for_virtual_traffic_lights),
    ("mapping.intersection.virtual_traffic_light_section_overlap", section::section_overlap),
    ("mapping.intersection.turn_signal_distance_overlap", elements::turn_signal),
    ("mapping.lane.centerline_geometry", centerline::geometry),
    ("mapping.lane.border_sharing", lanes::border_sharing),
    ("mapping.lane.lane_change_attribute", neighbours::lane_change),
    ("mapping.lane.lateral_subtype_connection", neighbours::lateral),
    ("mapping.traffic_light.correct_facing", facing::facing),
    ("mapping.lane.local_coordinates_declaration", elements::local_coordinates),
    ("mapping.lane.walkway_intersection", walkway::walkways),
];

/// Runs every validator over the map, in parallel, after the rule that says what does not load. The findings come in the
/// order of the table, within a validator by number, then by subject.
///
/// # Errors
///
/// If a parameter that the user gives has the wrong type.
pub fn run(map: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, ConfigError> {
    let rows = super::table().map_err(Clone::clone)?;
    let loading = rows.iter().filter(|row| row.requirement.id == "load");
    let loading = loading.map(|row| super::run_row(map, config, row));
    let mut found = loading.collect::<Result<Vec<_>, ConfigError>>()?.concat();
    // What the validator's loader does not tell of is no error to it.
    let unsaid = load::unsaid(map);
    for one in &mut found {
        let said = !unsaid.contains(&(one.finding.subject, one.finding.message.clone()));
        if !said && config.severity(&one.code).is_none() {
            one.severity = Severity::Warning;
        }
    }
    let Some(placed) = placed(map.map) else {
        found.extend(validate(map, config)?);
        return Ok(found);
    };
    let index = MapIndex::new(&placed, map.faults, map.settings);
    found.extend(validate(&index, config)?.into_iter().map(|one| {
        // What is found is shown where the map has it, not where the validator's loader puts it.
        let at = crate::lanelet::locate::locate(map.map, one.finding.subject, &one.finding.place);
        // What did not load has no place but there.
        if at.span.is_none() { one } else { Diagnostic { span: at.span, lonlat: at.lonlat, local: at.local, ..one } }
    }));
    Ok(found)
}

/// What the validators find, in the order of the table.
fn validate(map: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, ConfigError> {
    let view = map.view();
    let rows = super::table().map_err(Clone::clone)?;
    let mut found: Vec<Vec<Diagnostic>> = Vec::new();
    found.par_extend(
        READINGS.par_iter().in_small_parts().map(|&(name, reading)| read(map, view, config, name, reading)),
    );
    let by_rule = rows.par_iter().in_small_parts().map(|row| apply(map, config, row));
    found.extend(by_rule.collect::<Result<Vec<_>, _>>()?);
    let mut found: Vec<Diagnostic> = found.into_iter().flatten().collect();
    let place = |one: &Diagnostic| {
        let code = one.finding.peer.as_deref().and_then(|code| code.split('-').next());
        validators().iter().position(|validator| Some(validator.code().as_str()) == code)
    };
    found.sort_by_cached_key(|one| {
        (place(one), one.finding.peer.clone(), one.finding.subject, one.finding.message.clone())
    });
    Ok(found)
}

/// What a reading finds.
fn read(map: &MapIndex, view: &View, config: &Config, name: &str, reading: Reading) -> Vec<Diagnostic> {
    let Some(validator) = validators().iter().find(|validator| validator.name == name) else { return Vec::new() };
    let params = Params::new(validator, config.peer_parameters.as_ref());
    let issues = reading(view, &params).into_iter();
    issues.filter_map(|issue| diagnostic(map, config, validator, issue)).collect()
}

/// What a rule finds, with the parameters of the validators that it answers for: those without a reading.
fn apply(map: &MapIndex, config: &Config, row: &Row) -> Result<Vec<Diagnostic>, ConfigError> {
    let rule = row.requirement.id.as_str();
    let served = || {
        let all = validators().iter().filter(|validator| READINGS.iter().all(|(name, _)| *name != validator.name));
        all.filter(|validator| validator.issues.values().any(|(_, code)| code.split('/').next() == Some(rule)))
    };
    let Some(predicate) = row.predicate.filter(|_| served().next().is_some()) else { return Ok(Vec::new()) };
    let mut params = row.requirement.defaults();
    for validator in served() {
        params.extend(Params::new(validator, config.peer_parameters.as_ref()).0);
        params.extend(validator.settings.clone());
    }
    let findings = predicate(map, params)
        .map_err(|error| ConfigError::Parameter { rule: rule.to_owned(), message: error.message().to_owned() })?;
    let found = findings.into_iter().filter_map(|finding| {
        let code = format!("{rule}/{}", finding.fault);
        let (validator, digits) = served().find_map(|validator| {
            let own = validator.issues.iter().find(|(_, (_, fault))| *fault == code);
            own.map(|(digits, _)| (validator, digits))
        })?;
        complete(map, config, validator, digits, finding)
    });
    Ok(found.collect())
}

/// An issue of a reading as a finding of ours.
fn diagnostic(map: &MapIndex, config: &Config, validator: &'static Validator, issue: Issue) -> Option<Diagnostic> {
    let digits = format!("{:03}", issue.number);
    let (_, code) = validator.issues.get(&digits)?;
    let (_, fault) = code.split_once('/')?;
    complete(map, config, validator, &digits, Finding::new(fault, issue.subject, issue.message))
}

/// A finding with its code, severity, help and places.
fn complete(
    map: &MapIndex,
    config: &Config,
    validator: &Validator,
    digits: &str,
    mut finding: Finding,
) -> Option<Diagnostic> {
    let (severity, code) = validator.issues.get(digits).filter(|(_, code)| config.selection.wants(code))?;
    finding.peer = Some(format!("{}-{digits}", validator.code()).into());
    let found = crate::lanelet::locate::locate(map.map, finding.subject, &finding.place);
    Some(Diagnostic {
        code: code.clone(),
        severity: config.severity(code).unwrap_or((*severity).into()),
        help: super::find(code).and_then(|rule| rule.fault(finding.fault)).map(|fault| fault.help.clone()),
        span: found.span,
        lonlat: found.lonlat,
        local: found.local,
        finding,
    })
}
