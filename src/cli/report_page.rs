//! `check --report`: the findings as a page to look at.

use std::fs;
use std::path::Path;

use crate::report::Report;
use crate::report::failure::Failure;
use crate::report::html::{Earlier, Page, html};
use crate::requirement::Requirement;
use crate::rules;

use super::check_args::CheckArgs;
use crate::api::files;

/// Writes the page, and compares it with an earlier one where the user named one.
pub fn write(file: &Path, (args, map): (&CheckArgs, &Path), report: &Report<'_>) -> Result<(), Failure> {
    let earlier = args.compare.as_deref().map(read_earlier).transpose()?;
    let title = title(map);
    let (path, requirements) = (only_file(report), requirements(report)?);
    let page = Page {
        title: &title,
        path: path.as_deref(),
        requirements: &requirements,
        earlier: earlier.as_ref(),
        origin: None,
    };
    let failed = |what: &dyn std::fmt::Display| Failure::new(format!("cannot write {}: {what}", file.display()));
    let text = html(report, &page).map_err(|error| failed(&error))?;
    files::write(file, text.as_bytes())
}

/// How a map is called.
pub fn title(map: &Path) -> String {
    let name = std::path::absolute(map).ok().and_then(|path| Some(path.file_name()?.to_string_lossy().into_owned()));
    name.unwrap_or_else(|| "map".to_owned())
}

/// The standard's requirements, then those that only this run speaks of.
pub fn requirements<'a>(report: &Report<'a>) -> Result<Vec<&'a Requirement>, Failure> {
    let rows = rules::table().map_err(|error| Failure::new(error.to_string()))?;
    let mut all: Vec<&Requirement> = rows.iter().map(|row| &row.requirement).collect();
    let others: Vec<&Requirement> =
        report.requirements.iter().copied().filter(|one| !all.iter().any(|known| known.id == one.id)).collect();
    all.extend(others);
    Ok(all)
}

/// The map's file for an editor to open; none where the map has more than one.
pub fn only_file(report: &Report<'_>) -> Option<String> {
    let mut names = report.sources.names();
    let name = names.next().filter(|_| names.next().is_none())?;
    Some(std::path::absolute(name).ok()?.to_string_lossy().into_owned())
}

fn read_earlier(file: &Path) -> Result<Earlier, Failure> {
    let name = file.display();
    let text =
        fs::read_to_string(file).map_err(|error| Failure::new(format!("cannot read the report {name}: {error}")))?;
    Earlier::read(&text).map_err(|error| {
        Failure::new(format!("{name}: {error}")).help("give a file that an earlier `check --report FILE` wrote")
    })
}
