//! `explain` and `rules`: the standard, for people.

use crate::report::failure::Failure;
use crate::report::{self, diff};
use crate::rules;
use crate::settings::covers;
use crate::triage;

use super::args::CLEAN;
use super::check_args::ProfileArg;
use super::output;

/// Prints one rule in full; with a finding's code, that fault first.
pub fn explain(code: &str) -> Result<u8, Failure> {
    let triage = || triage::requirement().ok().filter(|one| covers(&one.id, code));
    let changes = || diff::requirement().ok().filter(|one| covers(&one.id, code));
    let requirement = rules::find(code).or_else(triage).or_else(changes).ok_or_else(|| {
        Failure::new(format!("there is no rule `{code}`"))
            .help("`lanewright rules` lists them; give vm-03-08, for example")
    })?;
    let slug = code.split_once('/').map(|(_, slug)| slug);
    if let Some(slug) = slug
        && requirement.fault(slug).is_none()
    {
        let known: Vec<&str> = requirement.faults.iter().map(|(slug, _)| slug.as_str()).collect();
        return Err(Failure::new(format!("{} has no fault `{slug}`", requirement.id))
            .help(format!("it has {}", known.join(", "))));
    }
    output::print(&report::explain(requirement, slug))?;
    Ok(CLEAN)
}

/// Prints the list of rules, or that of the existing tool's validators.
pub fn rules(profile: Option<ProfileArg>) -> Result<u8, Failure> {
    if profile == Some(ProfileArg::Tier4) {
        let names = rules::tier4::validators().iter();
        let lines: String = names.map(|one| format!("{}  {}\n", one.name, one.shown_under())).collect();
        output::print(&lines)?;
        return Ok(CLEAN);
    }
    let table = rules::table().map_err(|error| Failure::new(error.to_string()))?;
    output::print(&report::list(table.iter().map(|row| &row.requirement).chain(triage::requirement().ok())))?;
    Ok(CLEAN)
}
