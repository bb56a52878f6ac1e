//! `check`: a map in, findings and a verdict out.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::api::{Checked, Loaded, read_baseline};
use crate::diagnostic::Severity;
use crate::report::failure::Failure;
use crate::report::{self, HarmlessJson, Next, Report, Totals, visible};
use crate::triage::Suppressions;

use super::args::CLEAN;
use super::check_args::{CheckArgs, FormatArg};
use super::output::{self, Progress};
use super::watch::Watched;
use super::{fix, report_page, tier4};

/// Checks the map and prints what was found, once or until somebody ends it.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    if args.show.is_some() && args.report.is_none() && !matches!(args.format, FormatArg::Text | FormatArg::Full) {
        return Err(Failure::new("--show is for text, full and --report; the other formats have every finding"));
    }
    if args.statistics && !matches!(args.format, FormatArg::Text | FormatArg::Full | FormatArg::Concise) {
        return Err(Failure::new("--statistics is for text, full and concise")
            .help("`--format json` has the counts in `totals`"));
    }
    tier4::vet(args)?;
    if args.fix {
        fix::in_place(&args.map, &args.config, args.r#unsafe, args.least_shown())?;
    }
    if args.watch { watch(args) } else { once(args) }
}

/// Checks until somebody ends it. A map that cannot be read is told and waited for: it may be half saved.
fn watch(args: &CheckArgs) -> Result<u8, Failure> {
    let more = args.config.config.iter().map(PathBuf::from).chain(args.baseline.clone());
    let watched = Watched::new(&args.map, more);
    loop {
        // Taken before the run, so that a change during it is seen.
        let before = watched.stamps();
        if let Err(failure) = once(args) {
            output::tell_failure(&failure);
        }
        output::complain(&format!("watching {}; Ctrl-C ends\n", output::shown(&args.map)));
        watched.wait(before);
        output::clear()?;
    }
}

/// Checks the map and prints what was found.
fn once(args: &CheckArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let mut loaded = Loaded::read(args.map.as_path(), &args.config.configuration())?;
    let suppressions = Suppressions::of(&loaded.settings, &loaded.osm);
    // Only fixes ask for the elements again; rules ask the map.
    loaded.osm.forget_elements();
    let baseline = args.baseline.as_deref().map(|file| read_baseline(&file.into())).transpose()?;
    progress.next("checking");
    let peer_parameters = args.parameters.as_deref().map(tier4::parameters).transpose()?;
    let checked = Checked::judge(loaded, suppressions, peer_parameters, baseline.as_ref())?;
    drop(progress);
    if let Some(file) = &args.write_baseline {
        return write_baseline(file, &checked);
    }
    let sorted = &checked.sorted;
    if args.format == FormatArg::Tier4 {
        return tier4::print(args, &checked.loaded, sorted);
    }
    print(args, &checked)?;
    let warnings = sorted.left.iter().filter(|one| one.severity == Severity::Warning).count();
    if let Some(most) = args.max_warnings.filter(|&most| warnings > most) {
        output::complain(&format!("{warnings} warnings; --max-warnings allows {most}\n"));
        return Ok(1);
    }
    Ok(report::exit_code(&sorted.left, args.fail_on.into()))
}

fn print(args: &CheckArgs, checked: &Checked) -> Result<(), Failure> {
    checked.with_report(|report| {
        let report = Report { cap: (args.max_per_code > 0).then_some(args.max_per_code), ..*report };
        let report = Report { fail_on: args.fail_on.into(), show: args.least_shown(), ..report };
        shown(args, &report, checked)
    })
}

fn shown(args: &CheckArgs, report: &Report<'_>, checked: &Checked) -> Result<(), Failure> {
    output::print_beside(args.report.as_deref(), |out| match args.format {
        FormatArg::Text | FormatArg::Full | FormatArg::Concise => people(args, report, checked, out),
        FormatArg::Json => report::json::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Sarif => report::sarif::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Github => report::github::write(report, out),
        FormatArg::Gitlab => report::gitlab::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Junit => report::junit::write(report, out),
        FormatArg::Geojson => report::geojson::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Tier4 => Ok(()),
    })?;
    match &args.report {
        Some(file) => report_page::write(file, args, report),
        None => Ok(()),
    }
}

/// The formats for people say how much was found and how much was left out.
fn people(args: &CheckArgs, report: &Report<'_>, checked: &Checked, out: &mut dyn Write) -> io::Result<()> {
    let found = report.diagnostics;
    if args.statistics {
        Totals::of(found).write(out)?;
        writeln!(out, "{}", report::summary(found))?;
    } else if args.format == FormatArg::Concise {
        report::concise(out, found, report.sources)?;
        writeln!(out, "{}", report::summary(found))?;
    } else if args.format == FormatArg::Full {
        report::full(out, report, output::stdout_style())?;
    } else {
        let page = args.report.as_ref().map(|file| file.to_string_lossy());
        let (map, fixable) = (args.map.to_string_lossy(), checked.loaded.is_editable());
        let next = Next { map: &map, fixable, page: page.as_deref() };
        report::text(out, report, &next, output::stdout_style())?;
    }
    let left_out = [(report.suppressed, "suppressed"), (report.known, "known from the baseline")];
    let left_out: Vec<String> =
        left_out.iter().filter(|(count, _)| *count > 0).map(|(count, why)| format!("{count} {why}")).collect();
    if left_out.is_empty() { Ok(()) } else { writeln!(out, "left out: {}", left_out.join(", ")) }
}

fn write_baseline(file: &Path, checked: &Checked) -> Result<u8, Failure> {
    checked.write_baseline(file)?;
    let map = checked.loaded.osm.sources.first().map_or("", |source| &source.name);
    output::tell(
        file,
        &format!("{}: {} findings of {} written\n", output::shown(file), checked.baseline().len(), visible(map)),
    )?;
    Ok(CLEAN)
}
