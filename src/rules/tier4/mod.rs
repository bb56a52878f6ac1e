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
mod right_of_way;
mod section;
mod walkway;

use std::collections::BTreeMap;
use std::sync::LazyLock;

use rayon::prelude::*;
use serde::Deserialize;

use crate::diagnostic::{Diagnostic, Finding, Severity, Subject};
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::View;
use crate::lanelet::placed::placed;
use crate::parallel::Finely;

use super::{Config, ConfigError, Row};

/// What a reading finds.
#[derive(Debug)]
pub struct Issue {
    number: u16,
    subject: Subject,
    message: String,
}

fn issue(number: u16, subject: Subject, message: String) -> Issue {
    Issue { number, subject, message }
}

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
    ("mapping.intersection.right_of_way_with_traffic_lights", right_of_way::with_traffic_lights),
    ("mapping.intersection.right_of_way_without_traffic_lights", right_of_way::without_traffic_lights),
    ("mapping.intersection.road_markings", elements::road_markings),
    ("mapping.intersection.regulatory_element_details_for_virtual_traffic_lights", elements::virtual_traffic_lights),
    ("mapping.intersection.virtual_traffic_light_line_order", section::line_order),
    ("mapping.intersection.right_of_way_for_virtual_traffic_lights", right_of_way::for_virtual_traffic_lights),
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

/// One validator of the existing tool.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validator {
    /// `mapping.intersection.road_markings`.
    pub name: String,
    /// The requirement under which it stands; `None` where the tool names none.
    pub requirement: Option<String>,
    /// Severity and fault of ours by the last three digits of the issue code.
    pub issues: BTreeMap<String, (PeerSeverity, String)>,
    /// Parameters: the value of the tool's own file, and the value where a user's file lacks it.
    #[serde(default)]
    pub parameters: BTreeMap<String, [toml::Value; 2]>,
    /// What the rule has to know beyond them to judge as the tool does.
    #[serde(default)]
    settings: toml::Table,
}

/// A severity in the tool's own spelling.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
pub enum PeerSeverity {
    /// `Error`
    Error,
    /// `Warning`
    Warning,
    /// `info`
    #[serde(rename = "info")]
    Info,
}

impl From<PeerSeverity> for Severity {
    fn from(severity: PeerSeverity) -> Self {
        match severity {
            PeerSeverity::Error => Self::Error,
            PeerSeverity::Warning => Self::Warning,
            PeerSeverity::Info => Self::Info,
        }
    }
}

impl Validator {
    /// The part of its issue codes before the number: `Intersection.RoadMarkings`.
    pub fn code(&self) -> String {
        let upper = |word: &str| -> String {
            let mut letters = word.chars();
            letters.next().map(|first| first.to_ascii_uppercase()).into_iter().chain(letters).collect()
        };
        let parts = self.name.split('.').skip(1).map(|part| part.split('_').map(upper).collect::<String>());
        parts.collect::<Vec<_>>().join(".")
    }

    /// The requirement under which results are shown.
    pub fn shown_under(&self) -> &str {
        self.requirement.as_deref().unwrap_or(&self.name)
    }
}

/// All validators, in the order of the tool's requirement set.
pub fn validators() -> &'static [Validator] {
    #[derive(Deserialize)]
    struct Table {
        validator: Vec<Validator>,
    }
    static TABLE: LazyLock<Vec<Validator>> = LazyLock::new(|| {
        // A test holds that the table parses.
        toml::from_str::<Table>(include_str!("validators.toml")).map(|table| table.validator).unwrap_or_default()
    });
    &TABLE
}

/// The parameters of one validator.
#[derive(Clone, Debug, Default)]
pub struct Params(toml::Table);

impl Params {
    fn new(validator: &Validator, given: Option<&BTreeMap<String, toml::Table>>) -> Self {
        let own = given.map(|given| given.get(&validator.name));
        let values = validator.parameters.iter().map(|(name, [shipped, fallback])| {
            let value = match own {
                None => shipped,
                // The user's file replaces the tool's as a whole; what it lacks, or misspells, falls back.
                Some(own) => {
                    own.and_then(|own| own.get(name)).filter(|value| fits(value, fallback)).unwrap_or(fallback)
                }
            };
            (name.clone(), value.clone())
        });
        Self(values.collect())
    }

    fn number(&self, name: &str) -> f64 {
        let value = self.0.get(name);
        value.and_then(|value| value.as_float().or_else(|| Some(value.as_integer()? as f64))).unwrap_or_default()
    }

    fn word(&self, name: &str) -> &str {
        self.0.get(name).and_then(toml::Value::as_str).unwrap_or_default()
    }

    fn words(&self, name: &str) -> Vec<String> {
        let list = self.0.get(name).and_then(toml::Value::as_array);
        list.into_iter().flatten().filter_map(|value| value.as_str().map(str::to_owned)).collect()
    }
}

/// The parameters that a user's file lacks, or gives a value that cannot be one: validator and name.
pub fn missing(given: &BTreeMap<String, toml::Table>) -> Vec<(&'static str, &'static str)> {
    let all = validators().iter().flat_map(|one| one.parameters.iter().map(move |entry| (one, entry)));
    let lacking = all.filter(|(validator, (name, [_, fallback]))| {
        let value = given.get(&validator.name).and_then(|own| own.get(*name));
        !value.is_some_and(|value| fits(value, fallback))
    });
    lacking.map(|(validator, (name, _))| (validator.name.as_str(), name.as_str())).collect()
}

/// Whether a value can stand in for another.
fn fits(value: &toml::Value, other: &toml::Value) -> bool {
    let numeric = |value: &toml::Value| value.is_float() || value.is_integer();
    value.same_type(other) || (numeric(value) && numeric(other))
}

/// Runs every validator over the map, in parallel, after the rule that says what does not load. The findings come in the
/// order of the table, within a validator by number, then by subject.
pub fn run(map: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, ConfigError> {
    let rows = super::table().map_err(Clone::clone)?;
    let loading = rows.iter().filter(|row| row.requirement.id == "load");
    let loading = loading.map(|row| super::run_row(map, config, row));
    let mut found = loading.collect::<Result<Vec<_>, ConfigError>>()?.concat();
    let Some(placed) = placed(map.map) else {
        found.extend(validate(map, config)?);
        return Ok(found);
    };
    let index = MapIndex::new(&placed, map.faults, map.settings, map.thresholds);
    found.extend(validate(&index, config)?.into_iter().map(|one| {
        // What is found is shown where the map has it, not where the validator's loader puts it.
        let at = crate::lanelet::locate::locate(map.map, one.finding.subject, &one.finding.place);
        Diagnostic { span: at.span, lonlat: at.lonlat, local: at.local, ..one }
    }));
    Ok(found)
}

/// What the validators find, in the order of the table.
fn validate(map: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, ConfigError> {
    let view = map.view();
    let rows = super::table().map_err(Clone::clone)?;
    let mut found: Vec<Vec<Diagnostic>> = Vec::new();
    found.par_extend(READINGS.par_iter().finely().map(|&(name, reading)| read(map, view, config, name, reading)));
    let by_rule = rows.par_iter().finely().map(|row| apply(map, config, row));
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
