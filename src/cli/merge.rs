//! `merge`: cells or several maps in, one map out; with `--base`, two versions of a map in, and one with what both have changed out.

use std::io::{Error, Write};
use std::path::{Path, PathBuf};

use crate::api::{
    Joined, MergeOptions, MergedMap, config, conflict_page, conflict_requirement, files, merge, merge_settings_files,
    merge_versions, settings_of_theirs,
};
use crate::diagnostic::{Severity, Subject};
use crate::report::failure::Failure;
use crate::report::html::{Page, html};
use crate::report::{HarmlessJson, Report, sentence, visible_lines};
use crate::three_way::{Conflict, Taken, renumbered_settings};

use super::args::{CLEAN, output_file};
use super::output::{self, Progress};
use super::{input, report_page};
use clap::{Args, ValueEnum};
use serde::Serialize;

/// Put the cells of a divided map together, or several maps into one; or merge what two versions of a map have changed
#[derive(Debug, Args)]
#[command(
    after_help = "With --base, exit code 1 if something contradicts, or is wrong that was right on both sides; docs/merge.md"
)]
pub struct MergeArgs {
    /// Maps: .osm files, single cells, directories of .osm files, or map directories, divided or not; with --base OURS and THEIRS
    #[arg(required = true)]
    pub maps: Vec<PathBuf>,
    /// Directory for lanelet2_map.osm and copies of map_projector_info.yaml and lanewright.toml; made if it is not there. With
    /// --base and maps that are files, a file
    #[arg(short, long, value_name = "DIR", value_parser = output_file)]
    pub output: PathBuf,
    /// Give elements other ids that share theirs with another element of a map before
    #[arg(long)]
    pub renumber: bool,
    /// What both versions were made from: merges by element and meaning what each has changed
    #[arg(long, value_name = "MAP", conflicts_with = "renumber")]
    pub base: Option<PathBuf>,
    /// Where the map belongs, where that is not where ours is, as for git: the settings and the projector file beside it count
    #[arg(long, value_name = "FILE", requires = "base")]
    pub path: Option<PathBuf>,
    /// Do not look for findings that neither version has
    #[arg(long, requires = "base")]
    pub no_check: bool,
    /// Write what contradicts and what is found anew on the merged map, too: one HTML page to look at
    #[arg(long, value_name = "FILE", requires = "base", conflicts_with = "no_check", value_parser = output_file)]
    pub report: Option<PathBuf>,
    /// How it is told what came of it
    #[arg(long, value_enum, default_value_t = MergeFormat::Text, requires = "base")]
    pub format: MergeFormat,
}

/// How a merge is told.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum MergeFormat {
    #[default]
    Text,
    Json,
}

/// Exit code where somebody has to look at the result.
pub const CONFLICTS: u8 = 1;

/// Puts the maps together and says what came of it.
pub fn run(args: &MergeArgs) -> Result<u8, Failure> {
    if let Some(base) = &args.base {
        return run_versions(args, base);
    }
    let progress = Progress::start("reading");
    let joined = merge(&args.maps, &args.output, args.renumber, &|doing| progress.next(doing))?;
    drop(progress);
    let Joined { elements: [nodes, ways, relations], renumbered, settings_left_out } = joined;
    let mut counts = vec![(nodes, "node", "nodes"), (ways, "way", "ways"), (relations, "relation", "relations")];
    counts.extend((renumbered > 0).then_some((renumbered, "element has another id", "elements have other ids")));
    let mut text = format!("{}\n{}", output::shown(&args.output), input::counts(&counts));
    if settings_left_out {
        text += "warning: the maps have different settings; no lanewright.toml was written\n";
    }
    output::tell(&args.output, &text)?;
    Ok(CLEAN)
}

/// Merges two versions and says what contradicts.
fn run_versions(args: &MergeArgs, base: &Path) -> Result<u8, Failure> {
    let [ours, theirs] = &args.maps[..] else {
        return Err(Failure::new(format!("--base merges two versions, and {} are given", args.maps.len()))
            .help("lanewright merge --base BASE OURS THEIRS -o OUT"));
    };
    if args.path.as_deref().and_then(Path::file_name).is_some_and(|name| name == config::NAME) {
        return run_settings(args, [base, ours, theirs]);
    }
    let progress = Progress::start("reading");
    let options = MergeOptions { place: args.path.clone(), unchecked: args.no_check, ..MergeOptions::default() };
    let mut merged = merge_versions([base, ours, theirs], &options, &|doing| progress.next(doing))?;
    if let Some(place) = args.path.as_deref().filter(|_| !merged.merged.renumbered.is_empty()) {
        for settings in settings_of_theirs(place) {
            merged.conflicts.extend(renumbered_settings(&settings, &merged.merged.new_ids));
        }
    }
    progress.next("writing");
    merged.write(&args.output)?;
    // Whoever lets git merge has no other place for it.
    let of_git = || args.path.as_deref().filter(|_| merged.needs_a_look()).and_then(conflict_page);
    let page = args.report.clone().or_else(of_git).filter(|_| merged.checked.is_some());
    if let Some(page) = &page {
        report(page, args.path.as_deref().unwrap_or(&args.output), &merged)?;
    }
    drop(progress);
    let of = args.path.as_deref().unwrap_or(&args.output);
    output::print_beside(Some(&args.output), |out| match args.format {
        MergeFormat::Text => {
            let page = page.as_ref().filter(|_| args.report.is_none());
            let page = page.map_or_else(String::new, |page| format!("to look at: {}\n", page.display()));
            out.write_all(visible_lines(&format!("{}{page}", text(of, &merged))).as_bytes())
        }
        MergeFormat::Json => {
            let told = MergeOutcome::of(&merged);
            writeln!(HarmlessJson::new(out), "{}", serde_json::to_string_pretty(&told).map_err(Error::other)?)
        }
    })?;
    Ok(if merged.needs_a_look() { CONFLICTS } else { CLEAN })
}

/// Merges three versions of a `lanewright.toml`, which git merges as a file of its own.
fn run_settings(args: &MergeArgs, files: [&Path; 3]) -> Result<u8, Failure> {
    let (text, conflicts) = merge_settings_files(files)?;
    files::write(&args.output, text.as_bytes())?;
    output::print_beside(Some(&args.output), |out| {
        let told: String = conflicts.iter().map(Conflict::text).collect();
        out.write_all(visible_lines(&told).as_bytes())
    })?;
    Ok(if conflicts.is_empty() { CLEAN } else { CONFLICTS })
}

/// Writes the page that shows findings on the merged map, with the conflicts among them.
fn report(file: &Path, map: &Path, merged: &MergedMap) -> Result<(), Failure> {
    let Some(checked) = &merged.checked else { return Ok(()) };
    let failed = |what: &dyn std::fmt::Display| Failure::new(format!("cannot write {}: {what}", file.display()));
    let findings = merged.findings();
    let own = conflict_requirement().map_err(|error| failed(&error))?;
    let text = checked.with_report(|all| {
        let report = Report { diagnostics: &findings, ..*all };
        let requirements = report_page::requirements(&report)?;
        let requirements: Vec<_> = requirements.into_iter().chain([own]).collect();
        let title = report_page::title(map);
        let page = Page { title: &title, path: None, requirements: &requirements, earlier: None, origin: None };
        html(&report, &page).map_err(|error| failed(&error))
    })?;
    files::write(file, text.as_bytes())
}

/// What came of a merge, for people: what was merged, new ids, what contradicts, what is found that neither side had.
pub fn text(of: &Path, map: &MergedMap) -> String {
    let Taken { added, changed, combined, removed } = map.merged.taken;
    let mut text = String::new();
    if !output::is_quiet() {
        let counts = [
            (added, "element added", "elements added"),
            (changed, "element changed", "elements changed"),
            (combined, "element changed by both", "elements changed by both"),
            (removed, "element removed", "elements removed"),
        ];
        let counts: Vec<_> = counts.into_iter().filter(|(count, ..)| *count > 0).collect();
        text += &format!("{}\n{}", output::shown(of), input::counts(&counts));
        if counts.is_empty() {
            text += "  nothing to merge\n";
        }
    }
    for (subject, new) in &map.merged.renumbered {
        text += &format!("{subject} of theirs is {new} now, because ours has another one of that id\n");
    }
    for conflict in &map.conflicts {
        text += &conflict.text();
    }
    for found in map.new_findings.iter().filter(|found| found.severity > Severity::Info) {
        text += &format!("new {}[{}]: {}\n", found.severity, found.code, sentence(found));
    }
    let infos = map.new_findings.iter().filter(|found| found.severity == Severity::Info).count();
    if infos > 0 {
        text += &format!("{} that neither side had\n", crate::text::counted(infos, "info"));
    }
    let conflicts = map.conflicts.len();
    if conflicts > 0 {
        text += &format!("{}; the result has what is marked\n", crate::text::counted(conflicts, "conflict"));
    }
    text
}

/// What came of a merge, for programs.
#[derive(Serialize)]
struct MergeOutcome<'a> {
    schema_version: u32,
    taken: Taken,
    conflicts: &'a [Conflict],
    renumbered: Vec<Renumbered>,
    new_findings: Vec<NewFinding<'a>>,
}

#[derive(Serialize)]
struct Renumbered {
    subject: Subject,
    new_id: i64,
}

#[derive(Serialize)]
struct NewFinding<'a> {
    code: &'a str,
    severity: Severity,
    subject: Subject,
    message: &'a str,
    at: Option<crate::projection::LonLat>,
}

impl<'a> MergeOutcome<'a> {
    fn of(map: &'a MergedMap) -> Self {
        let renumbered = map.merged.renumbered.iter().map(|&(subject, new_id)| Renumbered { subject, new_id });
        let found = map.new_findings.iter().map(|found| NewFinding {
            code: &found.code,
            severity: found.severity,
            subject: found.finding.subject,
            message: &found.finding.message,
            at: found.lonlat,
        });
        Self {
            schema_version: 1,
            taken: map.merged.taken,
            conflicts: &map.conflicts,
            renumbered: renumbered.collect(),
            new_findings: found.collect(),
        }
    }
}
