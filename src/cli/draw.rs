//! `draw`: a map and its findings as a picture, or its lines as GeoJSON.

use std::io::{BufWriter, Write};

use crate::diagnostic::Diagnostic;
use crate::report;
use crate::report::draw;
use crate::report::draw::Options;
use crate::report::failure::Failure;

use super::args::CLEAN;
use super::draw_args::DrawArgs;
use super::output::{self, Progress};
use super::{compare, gallery, stage};
use crate::api::files;
use crate::api::{Along, Loaded, forecasts, judged};
use crate::rules::Config;

/// Draws the map into a file.
pub fn run(args: &DrawArgs) -> Result<u8, Failure> {
    if let Some([old, new]) = args.compare.as_deref() {
        return compare::run(args, old, new);
    }
    if !args.stage.is_empty() {
        return if args.each { gallery::run(args) } else { stage::run(args) };
    }
    let map = args.map.as_deref().unwrap_or_else(|| "".as_ref());
    let extension = args.output.extension().map(|e| e.to_ascii_lowercase());
    let as_what = match extension.as_ref().and_then(|e| e.to_str()) {
        _ if files::is_stdout(&args.output) => Format::Svg,
        Some("svg") => Format::Svg,
        Some("png") => Format::Png,
        Some("geojson") => Format::GeoJson,
        _ => {
            return Err(Failure::new(format!("{} is none of .svg, .png, .geojson", args.output.display()))
                .help("name the picture with one of the three endings"));
        }
    };
    let progress = Progress::start("reading");
    let loaded = Loaded::read(map, &Default::default())?;
    progress.next("checking");
    // Strokes have no place for findings; `check --format geojson` has.
    let unfound = args.no_findings || as_what == Format::GeoJson || !args.planner.is_empty();
    let found = if unfound { Vec::new() } else { judged(&loaded, &Config::from(&loaded.settings))? };
    let shown: Vec<Diagnostic> = found.iter().filter(|one| one.severity >= args.show.into()).cloned().collect();
    progress.next("drawing");
    let forecasts = match args.planner.is_empty() {
        true => Vec::new(),
        false => forecasts(&loaded, &Along::Lanelets(args.planner.clone()), &args.parameters.read()?)?,
    };
    let title = map.display().to_string();
    let options = Options {
        focus: args.focus(&loaded)?,
        scale: args.scale,
        ids: args.ids,
        title,
        forecasts,
        ..Options::default()
    };
    let picture = match as_what {
        Format::Svg => draw::svg(&loaded.map, &shown, &options).map(String::into_bytes),
        Format::Png => draw::png(&loaded.map, &shown, &options),
        Format::GeoJson => return strokes(args, &loaded, &options, progress),
    };
    let picture = picture.map_err(stage::failure)?;
    files::write(&args.output, &picture)?;
    drop(progress);
    let left_out = match found.len() - shown.len() {
        0 => String::new(),
        count => format!("; {count} are not drawn, --show info draws them"),
    };
    let drawn = if unfound { String::new() } else { format!(" ({}{left_out})", report::summary(&found)) };
    output::tell(&args.output, &format!("{}{drawn}\n", output::shown(&args.output)))?;
    Ok(CLEAN)
}

/// What is written.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Format {
    Svg,
    Png,
    GeoJson,
}

/// Writes the lines of the map as GeoJSON, without holding them in memory.
fn strokes(args: &DrawArgs, loaded: &Loaded, options: &Options, progress: Progress) -> Result<u8, Failure> {
    let seen = draw::view(&loaded.map, options).map_err(stage::failure)?;
    files::write_by(&args.output, |file| {
        let mut out = BufWriter::new(file);
        draw::geojson(&loaded.map, &loaded.projector, &seen, &mut out)?;
        out.flush()
    })?;
    drop(progress);
    output::tell(&args.output, &format!("{}\n", output::shown(&args.output)))?;
    Ok(CLEAN)
}
