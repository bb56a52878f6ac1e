//! What a user may say about a run, held against the rules there are.

use std::collections::BTreeMap;

use crate::diagnostic::{Severity, nearest};
use crate::requirement::{DocumentError, Requirement};
use crate::settings::{Profile, Selection, Settings, Step, covers, most_specific};

/// What a user may say about the run. The default runs everything as the documents say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Config {
    /// The codes that are wanted.
    pub selection: Selection,
    /// Parameters other than the documents', by rule.
    pub parameters: BTreeMap<String, toml::Table>,
    /// Severities other than the documents', by prefix of the code.
    pub severity: BTreeMap<String, Severity>,
    /// Whose reading of the requirements counts.
    pub profile: Profile,
    /// Parameters of the existing validator in place of its own, by validator; all that a user's file says.
    pub peer_parameters: Option<BTreeMap<String, toml::Table>>,
}

/// Why the rules could not run as the user wants.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// A document is spoilt.
    #[error(transparent)]
    Document(#[from] DocumentError),
    /// A parameter of the wrong type.
    #[error("parameters of {rule}: {message}")]
    Parameter {
        /// The rule.
        rule: String,
        /// What is wrong.
        message: String,
    },
}

impl From<&Settings> for Config {
    fn from(settings: &Settings) -> Self {
        Self {
            selection: settings.selection(),
            parameters: settings.parameters.clone(),
            severity: settings.severity.clone(),
            profile: settings.profile.unwrap_or_default(),
            peer_parameters: None,
        }
    }
}

impl Config {
    /// Whether a rule can have findings that are wanted.
    pub(super) fn wants_rule(&self, requirement: &Requirement) -> bool {
        let code = |slug: &str| format!("{}/{slug}", requirement.id);
        requirement.faults.iter().any(|(slug, _)| self.selection.wants(&code(slug)))
    }

    /// What the user says of a code.
    pub(super) fn severity(&self, code: &str) -> Option<Severity> {
        let said = self.severity.iter().map(|(prefix, &severity)| (prefix.as_str(), severity));
        most_specific(code, said).map(|(_, severity)| severity)
    }
}

/// A word of the settings that names nothing.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unknown<'a> {
    /// Where it stands in the settings.
    pub path: Vec<Step<'a>>,
    /// What is wrong.
    pub message: String,
    /// A way out.
    pub help: String,
}

/// Holds the rules, faults and parameters that settings name against those of `requirements`; the first that is not
/// there.
pub fn vet<'a>(settings: &'a Settings, requirements: &[&Requirement]) -> Option<Unknown<'a>> {
    let list = |key: &'static str, list: &'a Option<Vec<String>>| {
        let codes = list.iter().flatten().enumerate();
        codes.map(move |(at, code)| (vec![Step::Key(key), Step::Index(at)], code.as_str()))
    };
    let severities = settings.severity.keys().map(|code| (vec![Step::Key("severity"), Step::Key(code)], code.as_str()));
    let suppressed = settings.suppress.iter().enumerate().map(|(at, suppression)| {
        (vec![Step::Key("suppress"), Step::Index(at), Step::Key("code")], suppression.code.as_str())
    });
    let codes = list("select", &settings.select).chain(list("ignore", &settings.ignore));
    codes
        .chain(severities)
        .chain(suppressed)
        .find_map(|(path, code)| unknown_code(path, code, requirements))
        .or_else(|| settings.parameters.iter().find_map(|(rule, table)| unknown_parameter(rule, table, requirements)))
}

fn unknown_code<'a>(path: Vec<Step<'a>>, code: &str, requirements: &[&Requirement]) -> Option<Unknown<'a>> {
    let mut known: Vec<String> = Vec::new();
    for requirement in requirements {
        known.push(requirement.id.clone());
        known.extend(requirement.faults.iter().map(|(slug, _)| format!("{}/{slug}", requirement.id)));
    }
    if !code.is_empty() && known.iter().any(|one| covers(code, one)) {
        return None;
    }
    let help = match nearest(code, known.iter().map(String::as_str)) {
        Some(word) => format!("did you mean `{word}`?"),
        None => "`lanewright rules` lists the rules, `lanewright explain RULE` the faults of one".to_owned(),
    };
    Some(Unknown { path, message: format!("there is no rule or fault `{code}`"), help })
}

fn unknown_parameter<'a>(rule: &'a str, table: &'a toml::Table, requirements: &[&Requirement]) -> Option<Unknown<'a>> {
    let path = vec![Step::Key("parameters"), Step::Key(rule)];
    let Some(requirement) = requirements.iter().find(|requirement| requirement.id == rule) else {
        let help = match nearest(rule, requirements.iter().map(|requirement| requirement.id.as_str())) {
            Some(word) => format!("did you mean `{word}`?"),
            None => "`lanewright rules` lists them".to_owned(),
        };
        return Some(Unknown { path, message: format!("there is no rule `{rule}`"), help });
    };
    let name = table.keys().find(|name| !requirement.parameters.contains_key(*name))?;
    let known: Vec<&str> = requirement.parameters.keys().map(String::as_str).collect();
    let help = match nearest(name, known.iter().copied()) {
        Some(word) => format!("did you mean `{word}`?"),
        None if known.is_empty() => format!("{rule} has no parameters"),
        None => format!("it has {}", known.join(", ")),
    };
    let path = [path, vec![Step::Key(name)]].concat();
    Some(Unknown { path, message: format!("{rule} has no parameter `{name}`"), help })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Document;

    fn said(text: &str) -> Option<(usize, String, String)> {
        let requirements: Vec<&Requirement> =
            super::super::table().unwrap().iter().map(|row| &row.requirement).collect();
        let document = Document::parse("a.toml", text).unwrap();
        let unknown = vet(&document.settings, &requirements)?;
        Some((document.offset(&unknown.path), unknown.message, unknown.help))
    }

    #[test]
    fn what_names_nothing_is_said_with_its_place() {
        assert_eq!(
            said("select = [\"vm-03\", \"vm-03-08/lane-node-missing\"]\n[parameters.vm-03-08]\nspike = 2\n"),
            None
        );
        let text = "ignore = [\"vm-03-08\", \"vm-03-08/closd\"]\n";
        let (offset, message, help) = said(text).unwrap();
        assert_eq!(offset, text.find("\"vm-03-08/closd").unwrap());
        assert_eq!(message, "there is no rule or fault `vm-03-08/closd`");
        assert_eq!(help, "did you mean `vm-03-08/closed`?");
        let text = "[parameters.vm-03-08]\nspik = 2\n";
        assert_eq!(
            said(text).unwrap(),
            (22, "vm-03-08 has no parameter `spik`".into(), "did you mean `spike`?".into())
        );
        assert_eq!(said("[severity]\nvm-08 = \"info\"\n").unwrap().0, 11);
        assert!(said("[[suppress]]\ncode = \"x\"\nprimitive = \"map\"\n").is_some());
    }
}
