//! Settings: from every `lanewright.toml` on the way up from the map, and from the command line above them.

use std::fs;
use std::path::{Path, PathBuf};

use lanewright::report::failure::Failure;
use lanewright::requirement::Requirement;
use lanewright::rules;
use lanewright::settings::{Document, Settings};
use lanewright::triage;

use super::check_args::ConfigArgs;

/// Its name, beside the map or above it.
const NAME: &str = "lanewright.toml";

/// The settings for a map in this directory.
pub fn settings(home: &Path, args: &ConfigArgs) -> Result<Settings, Failure> {
    let (files, keys): (Vec<&String>, Vec<&String>) = args.config.iter().partition(|one| is_file(one));
    let files = match (files.is_empty(), args.isolated) {
        (false, _) => files.into_iter().rev().map(PathBuf::from).collect(),
        (true, true) => Vec::new(),
        (true, false) => above(home).into_iter().filter(|file| file.is_file()).collect(),
    };
    let mut settings = of_command_line(args)?;
    for key in keys.into_iter().rev() {
        settings = beneath(settings, of_key(key)?);
    }
    for file in files {
        settings = beneath(settings, of_file(&file)?);
    }
    Ok(settings)
}

/// Where a `lanewright.toml` may stand for a map in this directory, the nearest first.
pub fn above(home: &Path) -> Vec<PathBuf> {
    let Ok(home) = std::path::absolute(home) else { return Vec::new() };
    home.ancestors().map(|directory| directory.join(NAME)).collect()
}

fn is_file(argument: &str) -> bool {
    !argument.contains('=') || Path::new(argument).is_file()
}

/// `--select` and `--ignore`. What is selected here may be left out further below by a longer prefix only.
fn of_command_line(args: &ConfigArgs) -> Result<Settings, Failure> {
    let some = |list: &[String]| (!list.is_empty()).then(|| list.to_vec());
    let settings = Settings { select: some(&args.select), ignore: some(&args.ignore), ..Settings::default() };
    match rules::vet(&settings, &requirements()?) {
        None => Ok(settings),
        Some(unknown) => Err(Failure::new(unknown.message.clone()).help(unknown.help.clone())),
    }
}

/// `outer` beneath what is nearer; what both leave out adds up.
fn beneath(near: Settings, outer: Settings) -> Settings {
    let ignore = near.ignore.clone();
    let selected = near.select.clone().unwrap_or_default();
    let mut both = near.over(outer.clone());
    if let (Some(own), Some(theirs)) = (ignore, outer.ignore) {
        both.ignore = Some([own, theirs].concat());
    }
    if let Some(ignore) = &mut both.ignore {
        ignore.retain(|prefix| !selected.contains(prefix));
    }
    both
}

fn of_key(argument: &str) -> Result<Settings, Failure> {
    match Document::parse("--config", argument) {
        Ok(document) => vetted(document),
        Err((_, error)) => Err(Failure::new(format!("--config {argument}: {}", error.message.trim_end())).help(
            error.help.unwrap_or_else(|| {
                "KEY=VALUE is TOML: words stand in quotes, --config 'select=[\"vm-03\"]'".to_owned()
            }),
        )),
    }
}

fn of_file(file: &Path) -> Result<Settings, Failure> {
    let name = std::env::current_dir().ok().and_then(|here| Some(file.strip_prefix(here).ok()?.to_path_buf()));
    let name = name.as_deref().unwrap_or(file).display().to_string();
    let text = fs::read_to_string(file).map_err(|error| {
        Failure::new(format!("cannot read {name}: {error}")).help("--config takes a file or KEY=VALUE")
    })?;
    match Document::parse(name, text) {
        Ok(document) => vetted(document),
        Err((document, error)) => {
            let help = error.help.unwrap_or_else(|| "docs/configuration.md shows every key".to_owned());
            Err(Failure::new(format!("{}: {}", document.name, error.message.trim_end())).help(help).at(
                &document.name,
                &document.text,
                error.offset,
            ))
        }
    }
}

fn vetted(document: Document) -> Result<Settings, Failure> {
    if let Some(unknown) = rules::vet(&document.settings, &requirements()?) {
        return Err(Failure::new(format!("{}: {}", document.name, unknown.message)).help(unknown.help).at(
            &document.name,
            &document.text,
            document.offset(&unknown.path),
        ));
    }
    Ok(document.settings)
}

fn requirements() -> Result<Vec<&'static Requirement>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(error.to_string());
    let rows = rules::table().map_err(|error| failed(error))?;
    let own = triage::requirement().map_err(|error| failed(error))?;
    Ok(rows.iter().map(|row| &row.requirement).chain([own]).collect())
}
