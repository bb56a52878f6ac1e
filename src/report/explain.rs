//! A requirement, or the list of all of them, as text for a terminal.

use std::fmt::Write;

use super::prose::prose;
use crate::requirement::{Fault, Requirement};

/// A requirement in full, lines at most `width` columns wide: what its document says, then its faults and parameters. With a slug,
/// that fault first.
pub fn explain(requirement: &Requirement, slug: Option<&str>, width: usize) -> String {
    let mut text = String::new();
    if let Some(slug) = slug
        && let Some(fault) = requirement.fault(slug)
    {
        let _ = writeln!(text, "{}\n", one_fault(&requirement.id, slug, fault, width));
    }
    // Writing to a string cannot fail.
    let _ = writeln!(text, "{}  {}", requirement.id, requirement.title);
    if let Some(subtitle) = &requirement.subtitle {
        let _ = writeln!(text, "{subtitle}");
    }
    let _ = writeln!(text, "{}; check: {}", requirement.category, requirement.check);
    if let Some(why) = &requirement.why {
        text += &prose(why, width);
    }
    let body = requirement.prose.split_once('\n').map_or("", |(_, rest)| rest);
    let _ = writeln!(text, "\n{}", prose(body.trim(), width));
    if !requirement.faults.is_empty() {
        let _ = writeln!(text, "## Faults\n");
    }
    for (slug, fault) in &requirement.faults {
        let _ = writeln!(text, "{}", one_fault(&requirement.id, slug, fault, width));
    }
    if !requirement.parameters.is_empty() {
        let _ = writeln!(text, "\n## Parameters\n");
    }
    for (name, parameter) in &requirement.parameters {
        let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
        let _ = writeln!(text, "{name} = {}{unit}\n{}", parameter.default, indented(&parameter.meaning, width));
    }
    let _ = writeln!(text, "\nSource: {} (edition {})", requirement.source, requirement.edition);
    text
}

/// The text, wrapped and four columns in.
fn indented(text: &str, width: usize) -> String {
    textwrap::fill(
        text,
        textwrap::Options::new(width).initial_indent("    ").subsequent_indent("    ").break_words(false),
    )
}

const HEAD: &str = "| rule | title | judged | what is reported |\n|---|---|---|---|\n";

fn rows(text: &mut String, requirements: &[&Requirement]) {
    for Requirement { id, title, subtitle, check, faults, .. } in requirements {
        let faults: Vec<String> = faults.iter().map(|(slug, fault)| format!("`{slug}` ({})", fault.severity)).collect();
        let subtitle = subtitle.as_ref().map(|subtitle| format!("<br>{subtitle}")).unwrap_or_default();
        let _ = writeln!(text, "| [{id}]({id}.md) | {title}{subtitle} | {check} | {} |", faults.join(", "));
    }
}

/// The page that lists all requirements, `rules/README.md`.
pub fn rule_index<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> String {
    let mut text = String::from(
        "# What is checked\n\n\
         One document for each requirement: what is required, why, how to mend it, with pictures. `lanewright explain RULE` prints\n\
         it. This page is written by `make rules`.\n\n\
         ## Requirements of Autoware\n\n\
         The title is that of Autoware's list, or of TIER IV's where Autoware's has none; what it asks for stands below it.\n\n",
    );
    text += HEAD;
    let (standard, ours): (Vec<&Requirement>, Vec<&Requirement>) =
        requirements.into_iter().partition(|one| one.is_of_the_standard());
    rows(&mut text, &standard);
    text +=
        "\n## Map health\n\nWhat no standard asks for, and what loaders and planners stumble over all the same.\n\n";
    text += HEAD;
    rows(&mut text, &ours);
    text += "\n`partial` means that a program can judge only a part; the document says which, and why. The severity is the usual one;\n\
             where the size of a fault grades it, the document says so. Three pages\n\
             are no rules of a map: [triage](triage.md) is about suppressions and baselines, [diff](diff.md) and [merge](merge.md)\n\
             about versions of one.\n";
    text
}

fn one_fault(id: &str, slug: &str, fault: &Fault, width: usize) -> String {
    let mut text = format!("{}[{id}/{slug}]\n{}", fault.severity, indented(&fault.meaning, width));
    let help = format!("help: {}", fault.help);
    for line in [Some(help), fault.fix.as_ref().map(|fix| format!("fix: {fix}"))].into_iter().flatten() {
        text.push('\n');
        text += &indented(&line, width);
    }
    text
}

/// One line per requirement, those of the standard first: number, how far it is checked, title and subtitle.
pub fn list<'a>(requirements: impl IntoIterator<Item = &'a Requirement>) -> String {
    let mut requirements: Vec<&Requirement> = requirements.into_iter().collect();
    requirements.sort_by_key(|one| !one.is_of_the_standard());
    let line = |one: &&Requirement| format!("{:<10} {:<10} {}\n", one.id, one.check, one.full_title());
    requirements.iter().map(line).collect()
}
