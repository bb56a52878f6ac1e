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
    let _ = writeln!(text, "\n{}", without_pictures(prose.trim()));
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

/// A terminal shows no pictures: it says where they are.
fn without_pictures(prose: &str) -> String {
    let lines = prose.lines().map(|line| match line.strip_prefix("![").and_then(|rest| rest.split_once("](")) {
        Some((what, path)) => format!("[{what}: rules/{}]", path.trim_end_matches(')')),
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// The page that lists all requirements, `rules/README.md`.
pub fn rule_index<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> String {
    let mut text = String::from(
        "# What is checked\n\n\
         One document for each requirement: what is required, why, how to mend it, with pictures. `lanewright explain RULE` prints\n\
         it. This page is written by `make rules`.\n\n\
         | rule | title | judged | what is reported |\n|---|---|---|---|\n",
    );
    for Requirement { id, title, check, faults, .. } in requirements {
        let faults: Vec<String> = faults.iter().map(|(slug, fault)| format!("`{slug}` ({})", fault.severity)).collect();
        let _ = writeln!(text, "| [{id}]({id}.md) | {title} | {check} | {} |", faults.join(", "));
    }
    text += "\n`partial` means that a program can judge only a part; the document says which, and why. The severity is the usual one;\n\
             where the size of a fault grades it, the document says so. Two pages\n\
             are no rules of a map: [triage](triage.md) is about suppressions and baselines, [diff](diff.md) about two maps.\n";
    text
}

fn one_fault(id: &str, slug: &str, fault: &Fault) -> String {
    let fix = fault.fix.as_ref().map(|fix| format!("\n    fix: {fix}")).unwrap_or_default();
    format!("{}[{id}/{slug}]\n    {}\n    help: {}{fix}", fault.severity, fault.meaning, fault.help)
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
