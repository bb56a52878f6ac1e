//! A requirement, or the list of all of them, as text for a terminal.

use std::fmt::Write;

use crate::requirement::{Fault, Requirement};

/// A requirement in full: what its document says, then its faults and parameters. With a slug, that fault first.
pub fn explain(requirement: &Requirement, slug: Option<&str>) -> String {
    let mut text = String::new();
    if let Some(slug) = slug
        && let Some(fault) = requirement.fault(slug)
    {
        let _ = writeln!(text, "{}\n", one_fault(&requirement.id, slug, fault));
    }
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}  {}", requirement.id, requirement.title);
    let _ = writeln!(text, "{}; check: {}", requirement.category, requirement.check);
    if let Some(why) = &requirement.why {
        let _ = writeln!(text, "{why}");
    }
    let prose = requirement.prose.split_once('\n').map_or("", |(_, rest)| rest);
    let _ = writeln!(text, "\n{}", prose.trim());
    if !requirement.faults.is_empty() {
        let _ = writeln!(text, "\n## Faults\n");
    }
    for (slug, fault) in &requirement.faults {
        let _ = writeln!(text, "{}", one_fault(&requirement.id, slug, fault));
    }
    if !requirement.parameters.is_empty() {
        let _ = writeln!(text, "\n## Parameters\n");
    }
    for (name, parameter) in &requirement.parameters {
        let unit = if parameter.unit == "1" { "" } else { &parameter.unit };
        let _ = writeln!(text, "{name} = {} {unit}\n    {}", parameter.default, parameter.meaning);
    }
    let _ = writeln!(text, "\nSource: {} (edition {})", requirement.source, requirement.edition);
    text
}

fn one_fault(id: &str, slug: &str, fault: &Fault) -> String {
    format!("{}[{id}/{slug}]\n    {}\n    help: {}", fault.severity, fault.meaning, fault.help)
}

/// One line per requirement: number, how far it is checked, how many faults, title.
pub fn list<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> String {
    let mut text = String::new();
    for requirement in requirements {
        let Requirement { id, title, check, .. } = requirement;
        let _ = writeln!(text, "{id:<10} {check:<10} {title}");
    }
    text
}
