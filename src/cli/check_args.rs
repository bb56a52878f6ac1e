//! The arguments of `check`.

use std::path::PathBuf;

use super::args::output_file;
use crate::api::{ConfigSource, Configuration};
use crate::diagnostic::Severity;
use crate::report::FailOn;
use crate::settings::Profile;
use clap::{Args, ValueEnum};

/// Check a Lanelet2 map against Autoware's requirements
#[derive(Debug, Args)]
pub struct CheckArgs {
    /// .osm files, directories of .osm files, or map directories with map_projector_info.yaml: each is a map of its own
    #[arg(value_name = "MAP", required = true)]
    pub maps: Vec<PathBuf>,
    /// How findings are shown
    #[arg(long, value_enum, default_value_t = FormatArg::Text)]
    pub format: FormatArg,
    /// Least severity of findings that text, full, concise and --report show; text and full count the others [default:
    /// warning, or what --fail-on names; concise: info]
    #[arg(long, value_enum, value_name = "SEVERITY")]
    pub show: Option<SeverityArg>,
    /// Requirement set of the existing validator (--format tier4): which validators count, and in which order
    #[arg(long, value_name = "SET.json")]
    pub requirements: Option<PathBuf>,
    /// Exclusion list of the existing validator (--format tier4): issues to leave out
    #[arg(long, value_name = "LIST.json")]
    pub exclusions: Option<PathBuf>,
    /// Parameters of the existing validator (--profile tier4), in place of those that it ships
    #[arg(long, value_name = "PARAMS.yaml")]
    pub parameters: Option<PathBuf>,
    /// Least severity of a finding that makes the exit code 1
    #[arg(long, value_enum, default_value_t = FailOnArg::Error)]
    pub fail_on: FailOnArg,
    /// More warnings than this make the exit code 1, too
    #[arg(long, value_name = "N")]
    pub max_warnings: Option<usize>,
    /// Count the findings of each code instead of showing them
    #[arg(long)]
    pub statistics: bool,
    /// Most findings of one code that json and junit show; all are counted, 0 shows all
    #[arg(long, value_name = "N", default_value_t = 1000)]
    pub max_per_code: usize,
    #[command(flatten)]
    pub config: ConfigArgs,
    /// Fail on findings only that this file does not list
    #[arg(long, value_name = "FILE")]
    pub baseline: Option<PathBuf>,
    /// Write all findings into a baseline; the exit code is 0
    #[arg(long, value_name = "FILE", value_parser = output_file)]
    pub write_baseline: Option<PathBuf>,
    /// Write a report to look at: one HTML page with the findings on the map
    #[arg(long, value_name = "FILE", value_parser = output_file, conflicts_with = "write_baseline")]
    pub report: Option<PathBuf>,
    /// An earlier report; the new one tells which findings are new, the same, gone
    #[arg(long, value_name = "REPORT", requires = "report")]
    pub compare: Option<PathBuf>,
    /// Mend first what can be mended safely, in place
    #[arg(long, conflicts_with_all = ["watch", "write_baseline"])]
    pub fix: bool,
    /// With --fix: make fixes that need review afterwards, too
    #[arg(long, requires = "fix")]
    pub r#unsafe: bool,
    /// Check again whenever a file changes, until Ctrl-C
    #[arg(long, conflicts_with = "write_baseline")]
    pub watch: bool,
}

impl CheckArgs {
    /// The least severity that is shown: infos are counted, unless the user asked for them or they make the run fail.
    pub fn least_shown(&self) -> Severity {
        match (self.show, self.fail_on) {
            (Some(show), _) => show.into(),
            (None, FailOnArg::Info) => Severity::Info,
            (None, _) => Severity::Warning,
        }
    }
}

/// What is judged, and how.
#[derive(Debug, Default, Args)]
pub struct ConfigArgs {
    /// Whose reading of the requirements counts: ours, or that of TIER IV's existing validator
    #[arg(long, value_enum)]
    pub profile: Option<ProfileArg>,
    /// Only these rules or faults: vm-03, vm-03-08, vm-03-08/edge-not-border, load
    #[arg(long, value_name = "PREFIX", value_delimiter = ',')]
    pub select: Vec<String>,
    /// Not these rules or faults
    #[arg(long, value_name = "PREFIX", value_delimiter = ',')]
    pub ignore: Vec<String>,
    /// A file to read instead of lanewright.toml, or one key of it: 'parameters.vm-03-08.spike=2'
    #[arg(long, value_name = "FILE|KEY=VALUE")]
    pub config: Vec<String>,
    /// Read no lanewright.toml
    #[arg(long)]
    pub isolated: bool,
}

impl ConfigArgs {
    /// As the library wants them.
    pub fn configuration(&self) -> Configuration {
        Configuration {
            profile: self.profile.map(Into::into),
            select: self.select.clone(),
            ignore: self.ignore.clone(),
            sources: self.config.iter().map(|argument| ConfigSource::guess("--config", argument)).collect(),
            isolated: self.isolated,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ProfileArg {
    Ours,
    Tier4,
}

impl From<ProfileArg> for Profile {
    fn from(profile: ProfileArg) -> Self {
        match profile {
            ProfileArg::Ours => Self::Ours,
            ProfileArg::Tier4 => Self::Tier4,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SeverityArg {
    Error,
    Warning,
    Info,
}

impl From<SeverityArg> for Severity {
    fn from(severity: SeverityArg) -> Self {
        match severity {
            SeverityArg::Error => Self::Error,
            SeverityArg::Warning => Self::Warning,
            SeverityArg::Info => Self::Info,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FailOnArg {
    Info,
    Warning,
    Error,
    Never,
}

impl From<FailOnArg> for FailOn {
    fn from(limit: FailOnArg) -> Self {
        match limit {
            FailOnArg::Info => Self::Info,
            FailOnArg::Warning => Self::Warning,
            FailOnArg::Error => Self::Error,
            FailOnArg::Never => Self::Never,
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FormatArg {
    /// The worst first, like findings in one entry with the first places, and what to do next
    Text,
    /// Every finding by itself, the worst first: file, line, snippet and help
    Full,
    /// Every finding in a line, in the order of the rules
    Concise,
    /// For programs: docs/report.schema.json
    Json,
    /// SARIF 2.1.0, for code scanning
    Sarif,
    /// Annotations of GitHub Actions
    Github,
    /// GitLab's code quality report
    Gitlab,
    /// A test case for every rule
    Junit,
    /// Findings as features on the map
    Geojson,
    /// Result file of the existing validator, with --profile tier4: docs/tier4.md
    Tier4,
}
