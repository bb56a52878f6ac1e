//! The verbs and their arguments, as clap reads them.

mod args;
mod build;
mod check;
mod check_args;
mod compare;
mod cut;
mod diff;
mod draw;
mod draw_args;
mod explain;
mod fix;
mod fix_pictures;
mod fix_summary;
mod fmt;
mod gallery;
mod geometry;
mod git;
mod input;
mod interactive;
mod memory;
mod merge;
mod outcome;
mod output;
mod packaging;
mod planner;
mod project;
mod report_page;
mod split;
mod stage;
mod stats;
mod tier4;
mod view;
mod watch;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::api::{files, load};
use crate::builder::tags::driving_side;
use crate::osm;
use crate::projection;
use crate::report::failure::Failure;
use args::{CLEAN, FAILED};
use check_args::{CheckArgs, ProfileArg};
use clap::{CommandFactory, Parser, Subcommand};

/// Builds Autoware-ready Lanelet2 maps from OpenStreetMap and checks any Lanelet2 map.
#[derive(Debug, Parser)]
#[command(version, about, max_term_width = 100, arg_required_else_help = true)]
#[command(after_help = "Exit code: 0 clean, 1 findings of severity error (see check --fail-on), 2 the run failed.")]
struct Cli {
    #[command(subcommand)]
    verb: Verb,
    /// Most bytes that the files of a map may take in memory, unpacked: 500MB, 20GB [default: a quarter of the memory]
    #[arg(long, global = true, value_name = "SIZE", value_parser = args::size)]
    max_input: Option<u64>,
    /// Show no progress, and say nothing of what was done or written: findings and errors alone
    #[arg(short, long, global = true)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Verb {
    Build(build::BuildArgs),
    Geometry(geometry::GeometryArgs),
    Check(CheckArgs),
    Draw(draw_args::DrawArgs),
    Fix(fix::FixArgs),
    Fmt(fmt::FmtArgs),
    Split(split::SplitArgs),
    Cut(cut::CutArgs),
    Merge(merge::MergeArgs),
    Diff(diff::DiffArgs),
    GitSetup(git::GitSetupArgs),
    GitText(git::GitTextArgs),
    /// Find the projection that a map was made with, or convert the map to another
    #[command(subcommand)]
    Project(project::ProjectVerb),
    Stats(stats::StatsArgs),
    Planner(planner::PlannerArgs),
    View(view::ViewArgs),
    /// Show what a rule requires, why, and how to mend a map that breaks it
    Explain {
        /// Number of the rule, or a code that a finding shows: vm-03-08, vm-03-08/lane-node-missing
        rule: String,
    },
    /// List the rules
    Rules {
        /// With tier4: the validators of TIER IV's existing tool, each with its requirement
        #[arg(long, value_enum)]
        profile: Option<ProfileArg>,
        /// How they are listed
        #[arg(long, value_enum, default_value_t = explain::ListFormatArg::Text)]
        format: explain::ListFormatArg,
    },
    /// Print the completions of a shell
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Write the manual pages
    Man {
        /// Directory for lanewright.1 and a page for each verb; made if it is not there
        dir: PathBuf,
    },
}

/// Runs on one of the threads that share the work: no other is waited for where there is none to share. This thread, which would
/// only wait, meanwhile unpacks what every layout of streets asks for first.
fn shared(run: impl FnOnce() -> Result<u8, Failure> + Send) -> Result<u8, Failure> {
    memory::keep(memory::KEPT_LONG_MS);
    let mut result = Ok(CLEAN);
    rayon::in_place_scope(|threads| {
        threads.spawn(|_| result = run());
        projection::warm_up();
        driving_side::warm_up();
    });
    result
}

impl Verb {
    /// The maps that are read.
    fn maps(&self) -> Vec<&Path> {
        match self {
            Self::Build(args) => args.keep.iter().map(PathBuf::as_path).collect(),
            Self::Check(args) => args.maps.iter().map(PathBuf::as_path).collect(),
            Self::Draw(args) => args.map.iter().chain(args.compare.iter().flatten()).map(PathBuf::as_path).collect(),
            Self::Fix(args) => vec![&args.map],
            Self::Fmt(args) => vec![&args.map],
            Self::Split(args) => vec![&args.map],
            Self::Merge(args) => args.maps.iter().chain(&args.base).map(PathBuf::as_path).collect(),
            Self::Diff(args) => vec![&args.old, &args.new],
            Self::Project(verb) => vec![verb.map()],
            Self::Stats(args) => vec![&args.map],
            Self::Planner(args) => vec![&args.map],
            Self::View(args) => vec![&args.map],
            _ => Vec::new(),
        }
    }
}

/// Completes what a run has left half-moved that was killed, before a map is read.
fn completed(verb: &Verb) -> Result<(), Failure> {
    for map in verb.maps() {
        let home = load::home(map);
        if files::complete(home)? {
            output::complain(&format!(
                "{}: an earlier run was killed while it moved its files here; they are all in their places now\n",
                output::shown(home)
            ));
        }
    }
    Ok(())
}

/// Runs the program with the arguments of the process.
pub fn run() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Runs the program with these arguments, the first of which is its own name, and gives its exit code.
pub fn run_with(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let verb = match Cli::try_parse_from(arguments) {
        Ok(Cli { verb, max_input, quiet }) => {
            max_input.into_iter().for_each(osm::limit_input);
            output::keep_quiet(quiet);
            verb
        }
        Err(asked) => {
            // Help and version are asked for; there is nobody to tell that they could not be printed.
            let _ = asked.print();
            return if asked.use_stderr() { FAILED } else { CLEAN };
        }
    };
    let work = || completed(&verb).and_then(|()| run_verb(verb));
    let result = outcome::of(work);
    result.unwrap_or_else(|failure| {
        output::tell_failure(&failure);
        FAILED
    })
}

/// Runs a verb and gives its exit code.
fn run_verb(verb: Verb) -> Result<u8, Failure> {
    match verb {
        Verb::Build(args) => shared(|| build::run(&args)),
        Verb::Geometry(args) => shared(|| geometry::run(&args)),
        Verb::Check(args) => check::run(&args),
        Verb::Draw(args) => draw::run(&args),
        Verb::Fix(args) => fix::run(&args),
        Verb::Fmt(args) => fmt::run(&args),
        Verb::Split(args) => split::run(&args),
        Verb::Cut(args) => cut::run(&args),
        Verb::Merge(args) => merge::run(&args),
        Verb::Project(verb) => project::run(&verb),
        Verb::Diff(args) => diff::run(&args),
        Verb::GitSetup(args) => git::setup(&args),
        Verb::GitText(args) => git::text(&args),
        Verb::Stats(args) => stats::run(&args),
        Verb::Planner(args) => planner::run(&args),
        Verb::View(args) => view::run(args),
        Verb::Explain { rule } => explain::explain(&rule),
        Verb::Rules { profile, format } => explain::rules(profile, format),
        Verb::Completions { shell } => packaging::completions(shell, Cli::command()),
        Verb::Man { dir } => packaging::man(&dir, Cli::command()),
    }
}
