//! Settings: from every `lanewright.toml` on the way up from the map, and from the caller above them.

use std::fs;
use std::path::{Path, PathBuf};

use super::files::is_link;
use crate::report::failure::Failure;
use crate::requirement::Requirement;
use crate::rules;
use crate::settings::{Document, Profile, Settings};
use crate::text::nearest;
use crate::triage;

/// Its name, beside the map or above it.
pub(crate) const NAME: &str = "lanewright.toml";

/// What a caller says of settings. The default reads every `lanewright.toml` beside the input and above it.
#[derive(Clone, Debug, Default)]
pub struct Configuration {
    /// Whose reading of the requirements counts.
    pub profile: Option<Profile>,
    /// Only these rules or faults: `vm-03`, `vm-03-08`, `vm-03-08/edge-not-border`, `load`; all where empty.
    pub select: Vec<String>,
    /// Not these rules or faults.
    pub ignore: Vec<String>,
    /// Files to read instead of every `lanewright.toml`, and single keys above all files; the last one counts most.
    pub sources: Vec<ConfigSource>,
    /// Whether to read no `lanewright.toml` that is not named.
    pub isolated: bool,
}

/// One source of settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConfigSource {
    /// A file like `lanewright.toml`.
    File(PathBuf),
    /// Keys and values in TOML.
    Text {
        /// What messages call it.
        name: String,
        /// Such as `parameters.vm-03-08.spike = 2`.
        text: String,
    },
    /// The text of a file like `lanewright.toml`, above all files; messages show its lines.
    Document {
        /// What messages call it.
        name: String,
        /// All of it.
        text: String,
    },
}

impl ConfigSource {
    /// A file, or `KEY=VALUE`: what names no file and has a `=` is keys; messages call them by `name`.
    pub fn guess(name: &str, argument: &str) -> Self {
        if !argument.contains('=') || Path::new(argument).is_file() {
            return Self::File(argument.into());
        }
        Self::Text { name: name.to_owned(), text: argument.to_owned() }
    }
}

/// The settings for a map in this directory.
pub(super) fn settings(home: &Path, said: &Configuration) -> Result<Settings, Failure> {
    settings_from(above(home).into_iter().filter(|file| file.is_file()).collect(), said)
}

/// The settings of these files, the nearest first, unless the caller names others.
pub(super) fn settings_from(found: Vec<PathBuf>, said: &Configuration) -> Result<Settings, Failure> {
    let named = said.sources.iter().rev();
    let files: Vec<&PathBuf> = named
        .clone()
        .filter_map(|source| match source {
            ConfigSource::File(file) => Some(file),
            ConfigSource::Text { .. } | ConfigSource::Document { .. } => None,
        })
        .collect();
    let files = match (files.is_empty(), said.isolated) {
        (false, _) => files.into_iter().cloned().collect(),
        (true, true) => Vec::new(),
        (true, false) => found,
    };
    let mut settings = Settings::default();
    for source in named {
        settings = match source {
            ConfigSource::File(_) => settings,
            ConfigSource::Text { name, text } => settings.over(of_keys(name, text)?),
            ConfigSource::Document { name, text } => settings.over(of_text(name, text)?),
        };
    }
    for file in files {
        settings = settings.over(of_file(&file)?);
    }
    above_all(said, settings)
}

/// The settings of a text that stands for a `lanewright.toml` beside the map, beneath what the caller says.
pub(super) fn settings_of(beside: Option<&str>, said: &Configuration) -> Result<Settings, Failure> {
    let files = said.sources.iter().any(|source| matches!(source, ConfigSource::File(_)));
    let own = settings_from(Vec::new(), said)?;
    match beside.filter(|_| !files && !said.isolated) {
        Some(text) => Ok(own.over(of_text(NAME, text)?)),
        None => Ok(own),
    }
}

/// Where a `lanewright.toml` may stand for a map in this directory, the nearest first.
pub(crate) fn above(home: &Path) -> Vec<PathBuf> {
    let Ok(home) = std::path::absolute(home) else { return Vec::new() };
    home.ancestors().map(|directory| directory.join(NAME)).collect()
}

/// What is selected and left out by the caller, above everything else. What is selected here, a file leaves out by a longer prefix only;
/// what is left out here adds to what files leave out.
fn above_all(said: &Configuration, beneath: Settings) -> Result<Settings, Failure> {
    let some = |list: &[String]| (!list.is_empty()).then(|| list.to_vec());
    let own = Settings {
        select: some(&said.select),
        ignore: some(&said.ignore),
        profile: said.profile,
        ..Settings::default()
    };
    // To know all rules takes as long as to read a small map.
    let named = own.select.is_some() || own.ignore.is_some();
    if let Some(unknown) = if named { rules::vet(&own, &requirements()?) } else { None } {
        return Err(Failure::new(unknown.message).help(unknown.help));
    }
    let theirs = beneath.ignore.iter().flatten().filter(|prefix| !said.select.contains(prefix));
    let ignore: Vec<String> = theirs.chain(&said.ignore).cloned().collect();
    Ok(Settings { ignore: some(&ignore), ..own.over(beneath) })
}

fn of_keys(name: &str, text: &str) -> Result<Settings, Failure> {
    match Document::parse(name, text) {
        Ok(document) => vetted(document),
        Err(error) => Err(Failure::new(format!("{name} {text}: {}", error.message.trim_end())).help(
            error
                .help
                .unwrap_or_else(|| format!("KEY=VALUE is TOML: words stand in quotes, {name} 'select=[\"vm-03\"]'")),
        )),
    }
}

fn of_file(file: &Path) -> Result<Settings, Failure> {
    let name = std::env::current_dir().ok().and_then(|here| Some(file.strip_prefix(here).ok()?.to_path_buf()));
    let name = name.as_deref().unwrap_or(file).display().to_string();
    let text = fs::read_to_string(file).map_err(|error| {
        let help = match file_meant(file) {
            Some(meant) => format!("did you mean {meant}? --config takes a file or KEY=VALUE"),
            None => "--config takes a file or KEY=VALUE".to_owned(),
        };
        Failure::new(format!("cannot read {name}: {error}")).about(&name).help(help)
    })?;
    let read = of_text(&name, &text);
    if is_link(file) && read.is_err() {
        // Its lines may be nobody's business: the link may have come with a map.
        let failure = Failure::new(format!("{name} leads to a file that is no lanewright.toml")).about(&name);
        return Err(failure.help("put the settings here instead of a link, to see what is wrong with them"));
    }
    read
}

/// The file in the same folder with nearly the same name.
fn file_meant(file: &Path) -> Option<String> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let entries = fs::read_dir(folder).ok()?.filter_map(Result::ok).filter(|entry| entry.path().is_file());
    let mut names: Vec<String> = entries.filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort_unstable();
    let meant = file.with_file_name(nearest(file.file_name()?.to_str()?, names.iter().map(String::as_str))?);
    let here = std::env::current_dir().ok();
    let short = here.as_deref().and_then(|here| meant.strip_prefix(here).ok());
    Some(short.unwrap_or(&meant).display().to_string())
}

fn of_text(name: &str, text: &str) -> Result<Settings, Failure> {
    match Document::parse(name, text) {
        Ok(document) => vetted(document),
        Err(error) => {
            let help = error.help.unwrap_or_else(|| "docs/configuration.md shows every key".to_owned());
            Err(Failure::new(format!("{name}: {}", error.message.trim_end())).help(help).at(name, text, error.offset))
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

/// The requirements that findings of `check` may be about.
pub(crate) fn requirements() -> Result<Vec<&'static Requirement>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(error.to_string());
    let rows = rules::table().map_err(|error| failed(error))?;
    let own = triage::requirement().map_err(|error| failed(error))?;
    Ok(rows.iter().map(|row| &row.requirement).chain([own]).collect())
}
