//! The validators of the existing tool, their parameters, and the issues that they find.

use std::collections::BTreeMap;
use std::sync::LazyLock;

use serde::Deserialize;

use crate::diagnostic::{Severity, Subject};

/// What a reading finds.
#[derive(Debug)]
pub struct Issue {
    pub(super) number: u16,
    pub(super) subject: Subject,
    pub(super) message: String,
}

/// An issue of this number.
pub(super) fn issue(number: u16, subject: Subject, message: String) -> Issue {
    Issue { number, subject, message }
}

/// One validator of the existing tool.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Validator {
    /// `mapping.intersection.road_markings`.
    pub name: String,
    /// The requirement under which it is; `None` where the tool names none.
    pub requirement: Option<String>,
    /// Severity and fault of ours by the last three digits of the issue code.
    pub issues: BTreeMap<String, (PeerSeverity, String)>,
    /// Parameters: the value of the tool's own file, and the value where a user's file lacks it.
    #[serde(default)]
    pub parameters: BTreeMap<String, [toml::Value; 2]>,
    /// What the rule has to know beyond them to judge as the tool does.
    #[serde(default)]
    pub(super) settings: toml::Table,
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
pub struct Params(pub(super) toml::Table);

impl Params {
    pub(super) fn new(validator: &Validator, given: Option<&BTreeMap<String, toml::Table>>) -> Self {
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

    pub(super) fn number(&self, name: &str) -> f64 {
        let value = self.0.get(name);
        value.and_then(|value| value.as_float().or_else(|| Some(value.as_integer()? as f64))).unwrap_or_default()
    }

    pub(super) fn word(&self, name: &str) -> &str {
        self.0.get(name).and_then(toml::Value::as_str).unwrap_or_default()
    }

    pub(super) fn words(&self, name: &str) -> Vec<String> {
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
