//! `check`: a map in, findings and a verdict out.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::api::{Checked, Loaded, config, load, read_baseline, write_baseline as write_baseline_file};
use crate::diagnostic::{Accepted, Severity};
use crate::report::failure::Failure;
use crate::report::{self, HarmlessJson, Next, Report, Totals, visible};
use crate::triage::Suppressions;

use super::args::{CLEAN, FAILED};
use super::check_args::{CheckArgs, FormatArg};
use super::output::{self, Progress};
use super::watch::Watched;
use super::{fix, report_page, tier4};

/// Checks maps and prints what was found, once or until somebody ends it.
pub fn run(args: &CheckArgs) -> Result<u8, Failure> {
    let for_people = matches!(args.format, FormatArg::Text | FormatArg::Full | FormatArg::Concise);
    if args.show.is_some() && args.report.is_none() && !for_people {
        return Err(Failure::new(
            "--show is for text, full, concise and --report; the other formats have every finding",
        ));
    }
    if args.statistics && !for_people {
        return Err(Failure::new("--statistics is for text, full and concise")
            .help("`--format json` has the counts in `totals`"));
    }
    tier4::vet(args)?;
    if args.watch { watch(args) } else { all(args) }
}

/// Checks every map; the exit code is the worst.
fn all(args: &CheckArgs) -> Result<u8, Failure> {
    if let [map] = args.maps.as_slice() {
        return mended(args, map);
    }
    vet_several(args)?;
    let mut worst = CLEAN;
    for map in &args.maps {
        if matches!(args.format, FormatArg::Text | FormatArg::Full) {
            output::print(&format!("{}\n", output::shown(map)))?;
        }
        // A map that cannot be read does not hide what the others have.
        worst = worst.max(mended(args, map).unwrap_or_else(|failure| {
            output::tell_failure(&failure);
            FAILED
        }));
    }
    Ok(worst)
}

/// Holds that what is asked for makes sense for several maps.
fn vet_several(args: &CheckArgs) -> Result<(), Failure> {
    let lines = matches!(args.format, FormatArg::Text | FormatArg::Full | FormatArg::Concise | FormatArg::Github);
    if !lines || args.report.is_some() || args.write_baseline.is_some() || args.baseline.is_some() {
        return Err(Failure::new("one file of results is about one map, and several maps are given").help(
            "give one map, or leave out --report, the baseline and formats other than text, full, concise and github",
        ));
    }
    Ok(())
}

/// Checks a map, after it was mended where that is asked for.
fn mended(args: &CheckArgs, map: &Path) -> Result<u8, Failure> {
    if args.fix {
        fix::in_place(map, &args.config, args.r#unsafe, args.least_shown())?;
    }
    once(args, map)
}

/// Checks until somebody ends it. A map that cannot be read is told and waited for: it may be half saved.
fn watch(args: &CheckArgs) -> Result<u8, Failure> {
    let [map] = args.maps.as_slice() else {
        return Err(Failure::new("--watch is for one map").help("start it once for each map"));
    };
    let more = args.config.config.iter().map(PathBuf::from).chain(args.baseline.clone());
    let watched = Watched::new(map, more);
    loop {
        // Taken before the run, so that a change during it is seen.
        let before = watched.stamps();
        if let Err(failure) = once(args, map) {
            output::tell_failure(&failure);
        }
        output::complain(&format!("watching {}; Ctrl-C ends\n", output::shown(map)));
        watched.wait(before);
        output::clear()?;
    }
}

/// Checks the map and prints what was found.
fn once(args: &CheckArgs, map: &Path) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let mut loaded = Loaded::read(map, &args.config.configuration())?;
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
    tell_left_out(args, map);
    if args.format == FormatArg::Tier4 {
        return tier4::print(args, map, &checked.loaded, sorted);
    }
    print(args, map, &checked)?;
    let warnings = sorted.left.iter().filter(|one| one.severity == Severity::Warning).count();
    if let Some(most) = args.max_warnings.filter(|&most| warnings > most) {
        output::complain(&format!("{warnings} warnings; --max-warnings allows {most}\n"));
        return Ok(1);
    }
    Ok(report::exit_code(&sorted.left, args.fail_on.into()))
}

/// Says that findings may be explained by settings beside the map that were left out.
fn tell_left_out(args: &CheckArgs, map: &Path) {
    let beside = load::home(map).join(config::NAME);
    if args.config.isolated && beside.is_file() {
        output::complain(&format!(
            "{} was left out (--isolated): what it says of this map explains some findings\n",
            output::shown(&beside)
        ));
    }
}

fn print(args: &CheckArgs, map: &Path, checked: &Checked) -> Result<(), Failure> {
    checked.with_report(|report| {
        let report = Report { cap: (args.max_per_code > 0).then_some(args.max_per_code), ..*report };
        let report = Report { fail_on: args.fail_on.into(), show: args.least_shown(), ..report };
        shown(args, map, &report, checked)
    })
}

fn shown(args: &CheckArgs, map: &Path, report: &Report<'_>, checked: &Checked) -> Result<(), Failure> {
    output::print_beside(args.report.as_deref(), |out| match args.format {
        FormatArg::Text | FormatArg::Full | FormatArg::Concise => people((args, map), report, checked, out),
        FormatArg::Json => report::json::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Sarif => report::sarif::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Github => report::github::write(report, out),
        FormatArg::Gitlab => report::gitlab::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Junit => report::junit::write(report, out),
        FormatArg::Geojson => report::geojson::write(report, &mut HarmlessJson::new(out)),
        FormatArg::Tier4 => Ok(()),
    })?;
    match &args.report {
        Some(file) => report_page::write(file, (args, map), report),
        None => Ok(()),
    }
}

/// The formats for people say how much was found and how much was left out.
fn people(
    (args, map): (&CheckArgs, &Path),
    report: &Report<'_>,
    checked: &Checked,
    out: &mut dyn Write,
) -> io::Result<()> {
    let found = report.diagnostics;
    if args.statistics {
        Totals::of(found).write(out)?;
        writeln!(out, "{}", report::summary(found))?;
    } else if args.format == FormatArg::Concise {
        let least = args.show.map_or(Severity::Info, Severity::from);
        report::concise(out, found.iter().filter(|one| one.severity >= least), report.sources)?;
        writeln!(out, "{}", report::summary(found))?;
    } else if args.format == FormatArg::Full {
        report::full(out, report, output::stdout_style())?;
    } else {
        let page = args.report.as_ref().map(|file| file.to_string_lossy());
        let (map, fixable) = (map.to_string_lossy(), checked.loaded.is_editable());
        let next = Next { map: &map, fixable, page: page.as_deref() };
        report::text(out, report, &next, output::stdout_style())?;
    }
    let left_out = [(report.suppressed, "suppressed"), (report.known, "known from the baseline")];
    let left_out: Vec<String> =
        left_out.iter().filter(|(count, _)| *count > 0).map(|(count, why)| format!("{count} {why}")).collect();
    if !left_out.is_empty() {
        writeln!(out, "left out: {}", left_out.join(", "))?;
    }
    for Accepted { found, reason } in &checked.sorted.reasons {
        writeln!(out, "  {} on {}: {}", found.code, found.finding.subject, visible(reason))?;
    }
    Ok(())
}

fn write_baseline(file: &Path, checked: &Checked) -> Result<u8, Failure> {
    let mut baseline = checked.baseline();
    // What was rejected in a review keeps its reason; a file that is no baseline is written over, as it was asked for.
    if let Some(earlier) = file.is_file().then(|| read_baseline(&file.into()).ok()).flatten() {
        baseline = baseline.with_reasons_of(&earlier);
    }
    write_baseline_file(&baseline, file)?;
    let map = checked.loaded.osm.sources.first().map_or("", |source| &source.name);
    let count = baseline.len();
    output::tell(file, &format!("{}: {count} findings of {} written\n", output::shown(file), visible(map)))?;
    Ok(CLEAN)
}
