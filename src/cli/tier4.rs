//! The files of the existing validator, for `check --profile tier4 --format tier4`.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use crate::diagnostic::Severity;
use crate::report::failure::Failure;
use crate::report::tier4::{Exclusions, FormatError, Outcome, RequirementSet, Validator};
use crate::report::{FailOn, HarmlessJson, sentence, visible};
use crate::rules;
use crate::settings::Profile;
use crate::triage::Sorted;

use super::check_args::{CheckArgs, FormatArg};
use super::output;
use crate::api::Loaded;

use saphyr::{LoadableYamlNode, Yaml};

/// Holds that the files are given where they mean something.
pub fn vet(args: &CheckArgs) -> Result<(), Failure> {
    if args.format != FormatArg::Tier4 && (args.requirements.is_some() || args.exclusions.is_some()) {
        return Err(Failure::new("--requirements and --exclusions are for --format tier4")
            .help("`lanewright.toml` says the same to the other formats: select, ignore, suppress"));
    }
    Ok(())
}

fn validators() -> Vec<Validator<'static>> {
    let all = rules::tier4::validators().iter();
    all.map(|one| Validator { name: &one.name, code: one.code(), requirement: one.shown_under() }).collect()
}

/// Prints the result file on standard output; what the loader stumbles over, which that file has no place for, on
/// standard error.
pub fn print(args: &CheckArgs, map: &Path, loaded: &Loaded, sorted: &Sorted) -> Result<u8, Failure> {
    if loaded.settings.profile != Some(Profile::Tier4) {
        return Err(Failure::new("--format tier4 shows the findings of --profile tier4").help(
            "add --profile tier4, or `profile = \"tier4\"` to lanewright.toml; our own findings: --format json",
        ));
    }
    let known = validators();
    let set = match &args.requirements {
        None => RequirementSet::of_all(&known),
        Some(file) => {
            let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
            read(file, |text| RequirementSet::parse(&name, text, &known))?
        }
    };
    let exclusions = match &args.exclusions {
        None => Exclusions::default(),
        Some(file) => read(file, |text| Exclusions::parse(text, &known))?,
    };
    let outcome = Outcome::new(&sorted.left, &known, &set, &exclusions, map);
    output::print_with(|out| outcome.write(&mut HarmlessJson::new(out)))?;
    let mut broken = false;
    for said in sorted.left.iter().filter(|said| said.finding.peer.is_none()) {
        broken |= said.severity == Severity::Error;
        output::complain(&format!("{}: {}\n", said.severity, visible(&sentence(said))));
    }
    Ok(u8::from(broken || fails(args, &outcome)))
}

fn fails(args: &CheckArgs, outcome: &Outcome) -> bool {
    let count = |severity| outcome.counts.get(&severity).copied().unwrap_or_default();
    let limit = match args.fail_on.into() {
        FailOn::Error => Some(Severity::Error),
        FailOn::Warning => Some(Severity::Warning),
        FailOn::Info => Some(Severity::Info),
        FailOn::Never => None,
    };
    let bad =
        outcome.counts.iter().any(|(severity, count)| *count > 0 && limit.is_some_and(|limit| *severity >= limit));
    bad || args.max_warnings.is_some_and(|most| count(Severity::Warning) > most)
}

fn read<T>(file: &Path, parse: impl Fn(&str) -> Result<T, FormatError>) -> Result<T, Failure> {
    parse(&text(file)?).map_err(|error| wrong(file, &error))
}

fn text(file: &Path) -> Result<String, Failure> {
    fs::read_to_string(file).map_err(|error| Failure::new(format!("cannot read {}: {error}", file.display())))
}

fn wrong(file: &Path, what: &dyn std::fmt::Display) -> Failure {
    Failure::new(format!("{}: {what}", file.display())).help("docs/tier4.md shows what the file looks like")
}

/// Reads a parameters file: for every validator its parameters. It replaces the tool's own file as a whole.
pub fn parameters(file: &Path) -> Result<BTreeMap<String, toml::Table>, Failure> {
    let documents = Yaml::load_from_str(&text(file)?).map_err(|error| wrong(file, &error))?;
    let sections = documents.first().and_then(Yaml::as_mapping);
    let sections = sections.ok_or_else(|| wrong(file, &"expected `validator:` with `parameter: value` beneath"))?;
    let mut all = BTreeMap::new();
    for (name, values) in sections {
        let name = name.as_str().ok_or_else(|| wrong(file, &"a validator's name is no text"))?;
        let values = values.as_mapping().into_iter().flatten();
        let table = values.filter_map(|(key, value)| Some((key.as_str()?.to_owned(), plain(value)?)));
        all.insert(name.to_owned(), table.collect());
    }
    for (validator, parameter) in rules::tier4::missing(&all) {
        output::complain(&format!(
            "{}: {validator} has no {parameter} that can be used; the tool's fallback holds\n",
            output::shown(file)
        ));
    }
    Ok(all)
}

/// A value that a parameter can have; `None` for what none has.
fn plain(value: &Yaml<'_>) -> Option<toml::Value> {
    let list = || Some(toml::Value::Array(value.as_vec()?.iter().filter_map(plain).collect()));
    value
        .as_bool()
        .map(toml::Value::from)
        .or_else(|| value.as_integer().map(toml::Value::from))
        .or_else(|| value.as_floating_point().map(toml::Value::from))
        .or_else(|| value.as_str().map(toml::Value::from))
        .or_else(list)
}
