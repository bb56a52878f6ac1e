//! Settings: from every `lanewright.toml` on the way up from the map, and from the command line above them.

use std::fs;
use std::path::{Path, PathBuf};

use crate::report::failure::Failure;
use crate::requirement::Requirement;
use crate::rules;
use crate::settings::{Document, Settings};
use crate::triage;

use super::check_args::ConfigArgs;

/// Its name, beside the map or above it.
const NAME: &str = "lanewright.toml";

/// The settings for a map in this directory.
pub fn settings(home: &Path, args: &ConfigArgs) -> Result<Settings, Failure> {
    settings_from(above(home).into_iter().filter(|file| file.is_file()).collect(), args)
}

/// The settings of these files, the nearest first, unless the arguments name others.
pub fn settings_from(found: Vec<PathBuf>, args: &ConfigArgs) -> Result<Settings, Failure> {
    let (files, keys): (Vec<&String>, Vec<&String>) = args.config.iter().partition(|one| is_file(one));
    let files = match (files.is_empty(), args.isolated) {
        (false, _) => files.into_iter().rev().map(PathBuf::from).collect(),
        (true, true) => Vec::new(),
        (true, false) => found,
    };
    let mut settings = Settings::default();
    for key in keys.into_iter().rev() {
        settings = settings.over(of_key(key)?);
    }
    for file in files {
        settings = settings.over(of_file(&file)?);
    }
    above_all(args, settings)
}

/// Where a `lanewright.toml` may stand for a map in this directory, the nearest first.
pub fn above(home: &Path) -> Vec<PathBuf> {
    let Ok(home) = std::path::absolute(home) else { return Vec::new() };
    home.ancestors().map(|directory| directory.join(NAME)).collect()
}

fn is_file(argument: &str) -> bool {
    !argument.contains('=') || Path::new(argument).is_file()
}

/// `--select` and `--ignore` above everything else. What is selected here, a file leaves out by a longer prefix only;
/// what is left out here adds to what files leave out.
fn above_all(args: &ConfigArgs, beneath: Settings) -> Result<Settings, Failure> {
    let some = |list: &[String]| (!list.is_empty()).then(|| list.to_vec());
    let own = Settings {
        select: some(&args.select),
        ignore: some(&args.ignore),
        profile: args.profile.map(Into::into),
        ..Settings::default()
    };
    // To know all rules takes as long as to read a small map.
    let named = own.select.is_some() || own.ignore.is_some();
    if let Some(unknown) = if named { rules::vet(&own, &requirements()?) } else { None } {
        return Err(Failure::new(unknown.message).help(unknown.help));
    }
    let theirs = beneath.ignore.iter().flatten().filter(|prefix| !args.select.contains(prefix));
    let ignore: Vec<String> = theirs.chain(&args.ignore).cloned().collect();
    Ok(Settings { ignore: some(&ignore), ..own.over(beneath) })
}

fn of_key(argument: &str) -> Result<Settings, Failure> {
    match Document::parse("--config", argument) {
        Ok(document) => vetted(document),
        Err(error) => Err(Failure::new(format!("--config {argument}: {}", error.message.trim_end())).help(
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
    match Document::parse(&name, &text) {
        Ok(document) => vetted(document),
        Err(error) => {
            let help = error.help.unwrap_or_else(|| "docs/configuration.md shows every key".to_owned());
            Err(Failure::new(format!("{name}: {}", error.message.trim_end())).help(help).at(&name, &text, error.offset))
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
