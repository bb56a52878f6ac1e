//! `check`: a map in, findings and a verdict out.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

use crate::diagnostic::{Diagnostic, Severity};
use crate::lanelet::index::{MapIndex, Thresholds};
use crate::projection::LonLat;
use crate::report::failure::Failure;
use crate::report::{Report, Sources, Totals};
use crate::rules::Config;
use crate::triage::{Baseline, Sorted};
use crate::{report, rules, triage};

use super::check_args::{CheckArgs, FormatArg};
use super::load::Loaded;
use super::screen::Progress;
use super::{CLEAN, files, fix, page, screen, tier4, watch};

/// Checks the map and prints what was found, once or until somebody ends it.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    if args.statistics && !matches!(args.format, FormatArg::Text | FormatArg::Concise) {
        return Err(
            Failure::new("--statistics is for text and concise").help("`--format json` has the counts in `totals`")
        );
    }
    tier4::vet(args)?;
    if args.fix {
        fix::in_place(&args.map, &args.config, args.r#unsafe)?;
    }
    if args.watch { watch::run(args) } else { once(args) }
}

/// Checks the map and prints what was found.
pub fn once(args: &CheckArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let loaded = Loaded::read(&args.map, &args.config)?;
    let baseline = args.baseline.as_deref().map(read_baseline).transpose()?;
    progress.next("checking");
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings, Thresholds::default());
    let mut config = Config::from(&loaded.settings);
    config.peer_parameters = args.parameters.as_deref().map(tier4::parameters).transpose()?;
    let found = run_rules(&index, &config)?;
    let sorted = triage::sort(found, &loaded.settings, &loaded.osm, &loaded.map, baseline.as_ref());
    drop(progress);
    if let Some(file) = &args.write_baseline {
        return write_baseline(file, &loaded, &sorted);
    }
    if args.format == FormatArg::Tier4 {
        return tier4::print(args, &loaded, &sorted);
    }
    print(args, &loaded, &sorted)?;
    let warnings = sorted.left.iter().filter(|one| one.severity == Severity::Warning).count();
    if let Some(most) = args.max_warnings.filter(|&most| warnings > most) {
        screen::complain(&format!("{warnings} warnings; --max-warnings allows {most}\n"));
        return Ok(1);
    }
    Ok(report::exit_code(&sorted.left, args.fail_on.into()))
}

/// What the loader and the rules say about a map.
pub fn judge(loaded: &Loaded) -> Result<Vec<Diagnostic>, Failure> {
    let index = MapIndex::new(&loaded.map, &loaded.faults, &loaded.settings, Thresholds::default());
    run_rules(&index, &Config::from(&loaded.settings))
}

fn run_rules(index: &MapIndex, config: &Config) -> Result<Vec<Diagnostic>, Failure> {
    rules::run(index, config).map_err(|error| Failure::new(error.to_string()))
}

fn print(args: &CheckArgs, loaded: &Loaded, sorted: &Sorted) -> Result<(), Failure> {
    with_report(loaded, sorted, |report| {
        let report = Report { cap: (args.max_per_code > 0).then_some(args.max_per_code), ..*report };
        let report = Report { fail_on: args.fail_on.into(), ..report };
        shown(args, &report)
    })
}

/// What a run found, with all that shows it.
pub fn with_report<T>(loaded: &Loaded, sorted: &Sorted, show: impl FnOnce(&Report<'_>) -> T) -> T {
    let sources = Sources::new(loaded.osm.sources.iter().map(|s| (s.name.as_str(), s.text.as_str())));
    let mut requirements = rules::selected(&Config::from(&loaded.settings));
    if sorted.suppressed + sorted.known > 0 || sorted.left.iter().any(|one| one.code.starts_with("triage/")) {
        requirements.extend(triage::requirement().ok());
    }
    let to_globe =
        |points: &[_]| -> Option<Vec<LonLat>> { loaded.projector.inverse_each(points, |_| 0.0).into_iter().collect() };
    let root = repository();
    show(&Report {
        requirements: &requirements,
        suppressed: sorted.suppressed,
        known: sorted.known,
        unproject: Some(&to_globe),
        root: root.as_deref(),
        ..Report::new(&sorted.left, &sources, &loaded.map)
    })
}

fn shown(args: &CheckArgs, report: &Report<'_>) -> Result<(), Failure> {
    screen::print_with(|out| match args.format {
        FormatArg::Text | FormatArg::Concise => people(args, report, out),
        FormatArg::Json => report::json::write(report, out),
        FormatArg::Sarif => report::sarif::write(report, out),
        FormatArg::Github => report::github::write(report, out),
        FormatArg::Gitlab => report::gitlab::write(report, out),
        FormatArg::Junit => report::junit::write(report, out),
        FormatArg::Geojson => report::geojson::write(report, out),
        FormatArg::Tier4 => Ok(()),
    })?;
    match &args.report {
        Some(file) => page::write(file, args, report),
        None => Ok(()),
    }
}

/// The formats for people end with a line that sums up.
fn people(args: &CheckArgs, report: &Report<'_>, out: &mut dyn Write) -> std::io::Result<()> {
    let found = report.diagnostics;
    if args.statistics {
        Totals::of(found).write(out)?;
        writeln!(out, "{}", report::summary(found))?;
    } else if args.format == FormatArg::Concise {
        report::concise(out, found, report.sources)?;
        writeln!(out, "{}", report::summary(found))?;
    } else {
        report::text(out, report, screen::stdout_style())?;
    }
    let left_out = [(report.suppressed, "suppressed"), (report.known, "known from the baseline")];
    let left_out: Vec<String> =
        left_out.iter().filter(|(count, _)| *count > 0).map(|(count, why)| format!("{count} {why}")).collect();
    if left_out.is_empty() { Ok(()) } else { writeln!(out, "left out: {}", left_out.join(", ")) }
}

fn read_baseline(file: &Path) -> Result<Baseline, Failure> {
    let name = file.display();
    let text = fs::read_to_string(file).map_err(|error| {
        Failure::new(format!("cannot read the baseline {name}: {error}")).help("--write-baseline FILE makes one")
    })?;
    Baseline::parse(&text)
        .map_err(|error| Failure::new(format!("{name}: {error}")).help("--write-baseline FILE writes it anew"))
}

fn write_baseline(file: &Path, loaded: &Loaded, sorted: &Sorted) -> Result<u8, Failure> {
    // What triage says is about suppressions; they are mended, not remembered.
    let found: Vec<Diagnostic> = sorted.left.iter().filter(|one| !one.code.starts_with("triage/")).cloned().collect();
    let baseline = Baseline::of(&found);
    let mut text = Vec::new();
    let failed = |what: String| Failure::new(format!("cannot write the baseline {}: {what}", file.display()));
    baseline.write(&mut text).map_err(|error| failed(error.to_string()))?;
    files::write(file, &text)?;
    let map = loaded.osm.sources.first().map_or("", |source| &source.name);
    screen::print(&format!("{}: {} findings of {map} written\n", file.display(), baseline.len()))?;
    Ok(CLEAN)
}

/// The root of the repository that we run in; without one, the directory itself.
fn repository() -> Option<PathBuf> {
    let here = std::env::current_dir().ok()?;
    let root = here.ancestors().find(|directory| directory.join(".git").exists());
    Some(root.unwrap_or(&here).to_path_buf())
}
