//! `rules`: the requirements that maps are held against.

use lanewright::requirement::Requirement;
use lanewright::{rules as table, triage};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use serde_json::Value;

use crate::{errors, json};

/// List the requirements that maps are held against, in the order of Autoware's documents.
///
/// Returns:
///     A list of Rule.
#[pyfunction]
pub fn rules(py: Python<'_>) -> PyResult<Vec<Rule>> {
    let spoilt = |error: &dyn std::fmt::Display| errors::fault(py, &error.to_string());
    let rows = table::table().map_err(|error| spoilt(error))?;
    let own = triage::requirement().map_err(|error| spoilt(error))?;
    Ok(rows.iter().map(|row| &row.requirement).chain([own]).map(|requirement| Rule { requirement }).collect())
}

/// One requirement, with the faults by which a map can break it.
#[pyclass(frozen, module = "lanewright")]
#[derive(Debug)]
pub struct Rule {
    requirement: &'static Requirement,
}

#[pymethods]
impl Rule {
    /// Its number: 'vm-03-08', or the name of a family of checks that no standard asks for: 'load'.
    #[getter]
    fn id(&self) -> &'static str {
        &self.requirement.id
    }

    /// Its title in the standard's list; of a family of checks that no standard asks for, what it is about.
    #[getter]
    fn title(&self) -> &'static str {
        &self.requirement.title
    }

    /// What it asks for in plain words, where the title does not tell.
    #[getter]
    fn subtitle(&self) -> Option<&'static str> {
        self.requirement.subtitle.as_deref()
    }

    /// The chapter of the standard.
    #[getter]
    fn category(&self) -> &'static str {
        &self.requirement.category
    }

    /// How far a program can judge it: 'automatic', 'partial' or 'manual'.
    #[getter]
    fn check(&self) -> String {
        self.requirement.check.to_string()
    }

    /// Why not all of it; None where all of it is judged.
    #[getter]
    fn why(&self) -> Option<&'static str> {
        self.requirement.why.as_deref()
    }

    /// Where the requirement stands.
    #[getter]
    fn source(&self) -> &'static str {
        &self.requirement.source
    }

    /// The faults, in the order of its document.
    #[getter]
    fn faults(&self) -> Vec<Fault> {
        let faults = self.requirement.faults.iter();
        let fault = |(slug, fault): &'static (String, lanewright::requirement::Fault)| Fault {
            code: format!("{}/{slug}", self.requirement.id),
            severity: fault.severity.to_string(),
            meaning: fault.meaning.clone(),
            help: fault.help.clone(),
        };
        faults.map(fault).collect()
    }

    /// What can be set, by name: config={'parameters': {RULE: {NAME: VALUE}}}.
    #[getter]
    fn parameters<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let parameters = PyDict::new(py);
        for (name, parameter) in &self.requirement.parameters {
            let default = value(&parameter.default);
            let (unit, meaning) = (parameter.unit.clone(), parameter.meaning.clone());
            parameters.set_item(name, Parameter { default, unit, meaning })?;
        }
        Ok(parameters)
    }

    /// What is required, why, and how to mend what breaks it: Markdown.
    #[getter]
    fn prose(&self) -> &'static str {
        &self.requirement.prose
    }

    /// All of it as a dictionary that JSON can hold.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let value = serde_json::to_value(self.requirement).map_err(|error| errors::fault(py, &error.to_string()))?;
        json::to_python(py, &value)
    }

    fn __repr__(&self) -> String {
        format!("<Rule {}: {}>", self.requirement.id, self.requirement.title)
    }
}

/// One way to break a requirement.
#[pyclass(frozen, get_all, module = "lanewright")]
#[derive(Clone, Debug)]
pub struct Fault {
    /// The code that findings show: 'vm-03-08/closed'.
    pub code: String,
    /// 'error', 'warning' or 'info', unless settings say otherwise.
    pub severity: String,
    /// What is wrong, in one sentence.
    pub meaning: String,
    /// How to mend it, in one sentence.
    pub help: String,
}

#[pymethods]
impl Fault {
    fn __repr__(&self) -> String {
        format!("<Fault {} [{}]>", self.severity, self.code)
    }
}

/// A number, or a list, that can be set.
#[pyclass(frozen, module = "lanewright")]
#[derive(Clone, Debug)]
pub struct Parameter {
    default: Value,
    unit: String,
    meaning: String,
}

#[pymethods]
impl Parameter {
    /// Its value unless settings say otherwise.
    #[getter]
    fn default<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::to_python(py, &self.default)
    }

    /// Its unit: 'm', 'm2', 'deg', '1' and so on.
    #[getter]
    fn unit(&self) -> &str {
        &self.unit
    }

    /// What it is and why it is as large as it is.
    #[getter]
    fn meaning(&self) -> &str {
        &self.meaning
    }

    fn __repr__(&self) -> String {
        format!("<Parameter {} {}>", self.default, self.unit)
    }
}

fn value(toml: &toml::Value) -> Value {
    serde_json::to_value(toml).unwrap_or(Value::Null)
}
