//! `explain` and `rules`: the standard, for people.

use crate::report::failure::Failure;
use crate::report::{self, diff};
use crate::requirement::Requirement;
use crate::rules;
use crate::text::nearest;
use crate::triage;

use super::args::CLEAN;
use super::check_args::ProfileArg;
use super::output;

use clap::ValueEnum;
use serde_json::{Value, json};

/// Prints one rule in full; with a finding's code, that fault first. `VM-03-08`, `vm-3-8` and a fault's word alone will do.
pub fn explain(said: &str) -> Result<u8, Failure> {
    let all = documents()?;
    let code = normal(said);
    let (id, slug) = code.split_once('/').map_or((code.as_str(), None), |(id, slug)| (id, Some(slug)));
    let Some(requirement) = all.iter().find(|one| one.id == id) else {
        return explain_fault(&all, said, &code);
    };
    if let Some(slug) = slug
        && requirement.fault(slug).is_none()
    {
        let known: Vec<&str> = requirement.faults.iter().map(|(slug, _)| slug.as_str()).collect();
        let meant = nearest(slug, known.iter().copied());
        let meant = meant.map(|slug| format!("did you mean `{}/{slug}`? ", requirement.id)).unwrap_or_default();
        return Err(Failure::new(format!("{} has no fault `{slug}`", requirement.id))
            .help(format!("{meant}it has {}", known.join(", "))));
    }
    print(requirement, slug)
}

/// Where no rule has the name: the rule that has a fault of this name, if it is the only one.
fn explain_fault(all: &[&Requirement], said: &str, slug: &str) -> Result<u8, Failure> {
    let with_fault: Vec<&&Requirement> = all.iter().filter(|one| one.fault(slug).is_some()).collect();
    match with_fault.as_slice() {
        [only] => print(only, Some(slug)),
        [] => {
            let ids = all.iter().map(|one| one.id.clone());
            let codes = all.iter().flat_map(|one| one.faults.iter().map(|(slug, _)| format!("{}/{slug}", one.id)));
            let slugs = all.iter().flat_map(|one| one.faults.iter().map(|(slug, _)| slug.clone()));
            let words: Vec<String> = ids.chain(codes).chain(slugs).collect();
            let meant = nearest(slug, words.iter().map(String::as_str));
            let meant = meant.map(|word| format!("did you mean `{word}`? ")).unwrap_or_default();
            Err(Failure::new(format!("there is no rule `{said}`"))
                .help(format!("{meant}`lanewright rules` lists them; give vm-03-08, for example")))
        }
        several => {
            let codes: Vec<String> = several.iter().map(|one| format!("{}/{slug}", one.id)).collect();
            Err(Failure::new(format!("`{slug}` is a fault of several rules"))
                .help(format!("give one of {}", codes.join(", "))))
        }
    }
}

fn print(requirement: &Requirement, slug: Option<&str>) -> Result<u8, Failure> {
    output::print(&report::explain(requirement, slug, output::stdout_style().width))?;
    Ok(CLEAN)
}

/// Every document: the rules, then those of triage and `diff`.
fn documents() -> Result<Vec<&'static Requirement>, Failure> {
    let table = rules::table().map_err(|error| Failure::new(error.to_string()))?;
    let others = [triage::requirement(), diff::requirement()].into_iter().flatten();
    Ok(table.iter().map(|row| &row.requirement).chain(others).collect())
}

/// Small letters, and numbers of two digits where a requirement's number has fewer.
fn normal(said: &str) -> String {
    let said = said.trim().to_lowercase();
    let (id, slug) = said.split_once('/').map_or((said.as_str(), None), |(id, slug)| (id, Some(slug)));
    let id = match id.split(['-', '_', '.']).collect::<Vec<_>>().as_slice() {
        ["vm", chapter, number]
            if [chapter, number].iter().all(|part| part.bytes().all(|byte| byte.is_ascii_digit())) =>
        {
            format!("vm-{chapter:0>2}-{number:0>2}")
        }
        _ => id.to_owned(),
    };
    slug.map_or(id.clone(), |slug| format!("{id}/{slug}"))
}

/// How rules are listed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ListFormatArg {
    /// Number and title, by chapter.
    Text,
    /// For programs: every rule with its faults, their severities and help, and its parameters.
    Json,
}

/// Prints the list of rules, or that of the existing tool's validators.
pub fn rules(profile: Option<ProfileArg>, format: ListFormatArg) -> Result<u8, Failure> {
    if profile == Some(ProfileArg::Tier4) {
        let names = rules::tier4::validators().iter();
        if format == ListFormatArg::Json {
            let list =
                names.map(|one| json!({ "name": one.name, "code": one.code(), "requirement": one.shown_under() }));
            return list_as_json(&list.collect());
        }
        let lines: String = names.map(|one| format!("{}  {}\n", one.name, one.shown_under())).collect();
        output::print(&lines)?;
        return Ok(CLEAN);
    }
    let table = rules::table().map_err(|error| Failure::new(error.to_string()))?;
    if format == ListFormatArg::Json {
        let all = table.iter().map(|row| &row.requirement).chain(triage::requirement().ok());
        return list_as_json(&all.map(in_json).collect());
    }
    output::print(&report::list(table.iter().map(|row| &row.requirement).chain(triage::requirement().ok())))?;
    Ok(CLEAN)
}

/// A rule for programs: its document's block, each fault with the code that a finding shows.
fn in_json(rule: &Requirement) -> Value {
    let faults: Vec<Value> = rule
        .faults
        .iter()
        .map(|(slug, fault)| {
            json!({
                "code": format!("{}/{slug}", rule.id),
                "severity": fault.severity,
                "meaning": fault.meaning,
                "help": fault.help,
                "fix": fault.fix,
                "peer": fault.peer,
            })
        })
        .collect();
    json!({
        "id": rule.id,
        "title": rule.title,
        "subtitle": rule.subtitle,
        "category": rule.category,
        "check": rule.check,
        "source": rule.source,
        "edition": rule.edition,
        "parameters": rule.parameters,
        "faults": faults,
    })
}

fn list_as_json(list: &Vec<Value>) -> Result<u8, Failure> {
    let text = serde_json::to_string_pretty(list).map_err(|error| Failure::new(error.to_string()))?;
    output::print(&format!("{text}\n"))?;
    Ok(CLEAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_may_be_written_loosely() {
        for said in ["VM-03-08", "vm-3-8", "vm_3_8", " vm-03-8 "] {
            assert_eq!(normal(said), "vm-03-08", "{said}");
        }
        assert_eq!(normal("VM-3-8/Invalid"), "vm-03-08/invalid");
        assert_eq!(normal("health/dead-end"), "health/dead-end");
    }
}
