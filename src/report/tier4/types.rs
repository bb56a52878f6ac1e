//! A validator and an issue, as the result file of the existing validator names them.

use serde_json::{Value, json};

use crate::diagnostic::{Diagnostic, Severity, Subject};

/// One validator, as far as the result is concerned.
#[derive(Clone, Debug)]
pub struct Validator<'a> {
    /// `mapping.intersection.road_markings`.
    pub name: &'a str,
    /// Its issue codes up to the number: `Intersection.RoadMarkings`.
    pub code: String,
    /// The requirement under which it is shown where the user has no set.
    pub requirement: &'a str,
}

/// One line of a validator's issues.
#[derive(Clone, Debug, PartialEq)]
pub struct Issue {
    /// How bad it is.
    pub severity: Severity,
    /// The word for the primitive's kind.
    pub primitive: &'static str,
    /// Its id.
    pub id: i64,
    /// `Intersection.RoadMarkings-001`.
    pub code: String,
    /// What is wrong.
    pub message: String,
}

impl Issue {
    pub(super) fn of(diagnostic: &Diagnostic) -> Option<Self> {
        let subject = diagnostic.finding.subject;
        let primitive = match subject {
            Subject::Map | Subject::Node(_) | Subject::Way(_) | Subject::Relation(_) => "primitive",
            _ => subject.kind(),
        };
        Some(Self {
            severity: diagnostic.severity,
            primitive,
            id: subject.id().unwrap_or_default(),
            code: diagnostic.finding.peer.as_ref()?.to_string(),
            message: diagnostic.finding.message.clone(),
        })
    }

    /// An issue of the run itself.
    pub(super) fn general(code: &str, message: String) -> Self {
        Self { severity: Severity::Error, primitive: "primitive", id: 0, code: code.to_owned(), message }
    }

    pub(super) fn to_json(&self) -> Value {
        let severity = match self.severity {
            Severity::Error => "Error",
            Severity::Warning => "Warning",
            Severity::Info => "info",
        };
        json!({
            "severity": severity, "primitive": self.primitive, "id": self.id, "issue_code": self.code,
            "message": self.message,
        })
    }
}
