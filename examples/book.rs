//! Lays out the documentation site for mdBook: `cargo run --example book -- DIR`; `make docs` then builds it.
//!
//! The pages keep their places, so that a link works in the repository and on the site alike. A rule's page is made
//! from its document: the `toml` block becomes tables.

use std::error::Error;
use std::fmt::Write;
use std::fs;
use std::path::{Path, PathBuf};

use lanewright::report::diff;
use lanewright::requirement::Requirement;
use lanewright::{rules, triage};

/// Chapters in reading order: title, file in `docs/`.
const PAGES: [(&str, &str); 20] = [
    ("Start in five minutes", "start.md"),
    ("Maps in CI", "ci.md"),
    ("The command line", "cli.md"),
    ("Looking at a map while it changes", "view.md"),
    ("A review that ends in a map", "review.md"),
    ("Maps in cells", "divided_maps.md"),
    ("Countries: many machines", "scale.md"),
    ("The Python module", "python.md"),
    ("Configuration", "configuration.md"),
    ("Output formats", "formats.md"),
    ("Lanes from tags", "lanes.md"),
    ("Lanes through edits", "lane_stitching.md"),
    ("Architecture", "architecture.md"),
    ("Terms", "terms.md"),
    ("How fast it is", "benchmarks.md"),
    ("How often a finding is right", "precision.md"),
    ("Adding a rule", "add_a_rule.md"),
    ("Adding an input format", "add_an_input_format.md"),
    ("Changes", "changelog.md"),
    ("Contributing", "../CONTRIBUTING.md"),
];

const BOOK: &str = r#"[book]
title = "lanewright"
description = "Lanelet2 maps for Autoware: built from OpenStreetMap, checked, mended"
language = "en"

[build]
build-dir = "html"

[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
smart-punctuation = false
"#;

fn main() -> Result<(), Box<dyn Error>> {
    let out = PathBuf::from(std::env::args_os().nth(1).ok_or("give the directory to lay the book out in")?);
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    if out.exists() {
        fs::remove_dir_all(&out)?;
    }
    let source = out.join("src");
    for part in ["README.md", "CONTRIBUTING.md", "NOTICE", "LICENSE-MIT", "LICENSE-APACHE", "docs", "rules"] {
        copy(&root.join(part), &source.join(part))?;
    }
    let pages = listed(root)?;
    fs::write(out.join("book.toml"), BOOK)?;
    let mut summary = String::from("# Summary\n\n[lanewright](README.md)\n\n# Guide\n\n");
    for (title, path) in &pages {
        writeln!(summary, "- [{title}]({path})")?;
    }
    summary += "\n# Rules\n\n- [What is checked](rules/README.md)\n";
    let table = rules::table()?;
    for requirement in table.iter().map(|row| &row.requirement).chain(triage::requirement()).chain(diff::requirement())
    {
        writeln!(summary, "- [{} {}](rules/{}.md)", requirement.id, requirement.title, requirement.id)?;
        fs::write(source.join("rules").join(format!("{}.md", requirement.id)), page(requirement)?)?;
    }
    fs::write(source.join("SUMMARY.md"), summary)?;
    Ok(())
}

/// The guide's pages: those of [`PAGES`] in their order, then the others in `docs/` by name.
fn listed(root: &Path) -> Result<Vec<(String, String)>, Box<dyn Error>> {
    let path = |file: &str| file.strip_prefix("../").map_or_else(|| format!("docs/{file}"), str::to_owned);
    let mut pages: Vec<(String, String)> =
        PAGES.iter().map(|(title, file)| ((*title).to_owned(), path(file))).collect();
    let mut others: Vec<PathBuf> =
        fs::read_dir(root.join("docs"))?.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>()?;
    others.retain(|other| other.extension().is_some_and(|extension| extension == "md"));
    others.sort();
    for other in others {
        let name = path(&other.file_name().unwrap_or_default().to_string_lossy());
        if !pages.iter().any(|(_, page)| *page == name) {
            let text = fs::read_to_string(&other)?;
            let title = text.lines().find_map(|line| line.strip_prefix("# ")).unwrap_or(&name).to_owned();
            pages.push((title, name));
        }
    }
    Ok(pages)
}

fn copy(from: &Path, to: &Path) -> Result<(), Box<dyn Error>> {
    if from.is_dir() {
        fs::create_dir_all(to)?;
        for entry in fs::read_dir(from)? {
            let entry = entry?;
            copy(&entry.path(), &to.join(entry.file_name()))?;
        }
    } else {
        fs::create_dir_all(to.parent().unwrap_or(to))?;
        fs::copy(from, to)?;
    }
    Ok(())
}

/// A rule's page: its prose, then what its document's `toml` block holds, as tables.
fn page(requirement: &Requirement) -> Result<String, std::fmt::Error> {
    let Requirement { id, title, category, check, why, source, edition, parameters, faults, prose, .. } = requirement;
    let prose = prose.trim_start().split_once('\n').map_or("", |(_, rest)| rest);
    let mut page = format!("# {id}: {title}\n\n*{category}; check: {check}*\n\n");
    if let Some(why) = why {
        writeln!(page, "> {why}\n")?;
    }
    writeln!(page, "{}\n", prose.trim())?;
    if !faults.is_empty() {
        page += "## Faults\n\n| code | severity | what is wrong | how to mend it |\n|---|---|---|---|\n";
        for (slug, fault) in faults {
            let peer = if fault.peer.is_empty() { String::new() } else { format!(" ({})", fault.peer.join(", ")) };
            writeln!(
                page,
                "| `{id}/{slug}`{peer} | {} | {} | {} |",
                fault.severity,
                cell(&fault.meaning),
                cell(&fault.help)
            )?;
        }
        page.push('\n');
    }
    if !parameters.is_empty() {
        page += "## Parameters\n\n| name | default | unit | meaning |\n|---|---|---|---|\n";
        for (name, parameter) in parameters {
            let (default, unit) = (cell(&parameter.default.to_string()), &parameter.unit);
            writeln!(page, "| `parameters.{id}.{name}` | {default} | {unit} | {} |", cell(&parameter.meaning))?;
        }
        page.push('\n');
    }
    if source.starts_with("https://") {
        writeln!(page, "[Source]({source}), edition {edition}")?;
    } else {
        writeln!(page, "Source: {source}, edition {edition}")?;
    }
    Ok(page)
}

/// Plain text inside a table; what stands between backquotes is code and stays.
fn cell(text: &str) -> String {
    let text = text.replace('|', "\\|").replace('\n', " ");
    let parts = text.split('`').enumerate();
    parts
        .map(|(i, part)| if i % 2 == 0 { part.replace('<', "&lt;") } else { part.to_owned() })
        .collect::<Vec<_>>()
        .join("`")
}
