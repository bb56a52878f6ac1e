//! `draw`: a map and its findings as a picture.

use lanewright::projection::LonLat;
use lanewright::report;
use lanewright::report::draw::{self, DrawError, Focus, Options};
use lanewright::report::failure::Failure;

use super::load::Loaded;
use super::screen::{self, Progress};
use super::{CLEAN, DrawArgs, check, compare, files, stage};

/// Draws the map into a file.
pub fn run(args: &DrawArgs) -> Result<u8, Failure> {
    if let Some([old, new]) = args.compare.as_deref() {
        return compare::run(args, old, new);
    }
    if !args.stage.is_empty() {
        return stage::run(args);
    }
    let map = args.map.as_deref().unwrap_or_else(|| "".as_ref());
    let extension = args.output.extension().map(|e| e.to_ascii_lowercase());
    let paint = match extension.as_ref().and_then(|e| e.to_str()) {
        Some("svg") => |map: &_, found: &[_], options: &_| draw::svg(map, found, options).map(String::into_bytes),
        Some("png") => |map: &_, found: &[_], options: &_| draw::png(map, found, options),
        _ => {
            return Err(Failure::new(format!("{} is neither .svg nor .png", args.output.display()))
                .help("name the picture with one of the two endings"));
        }
    };
    let progress = Progress::start("reading");
    let loaded = Loaded::read(map, &Default::default())?;
    progress.next("checking");
    let found = if args.no_findings { Vec::new() } else { check::judge(&loaded)? };
    progress.next("drawing");
    let options =
        Options { focus: focus(args, &loaded)?, scale: args.scale, ids: args.ids, title: map.display().to_string() };
    let picture =
        paint(&loaded.map, &found, &options).map_err(|e: DrawError| Failure::new(e.to_string()).help(e.help()))?;
    let name = args.output.file_name().and_then(|n| n.to_str()).unwrap_or("picture");
    let dir = args.output.parent().filter(|dir| !dir.as_os_str().is_empty());
    files::publish(dir.unwrap_or_else(|| ".".as_ref()), &[(name, &picture)])?;
    drop(progress);
    let drawn = if args.no_findings { String::new() } else { format!(" ({})", report::summary(&found)) };
    screen::print(&format!("{}{drawn}\n", args.output.display()))?;
    Ok(CLEAN)
}

/// The part of the map that the arguments ask for.
pub fn focus(args: &DrawArgs, loaded: &Loaded) -> Result<Focus, Failure> {
    if let Some(id) = args.around {
        return Ok(Focus::Primitive(id));
    }
    let Some((lat, lon)) = args.at else { return Ok(Focus::Whole) };
    let place = loaded.projector.forward(LonLat { lon, lat }, 0.0).ok_or_else(|| {
        Failure::new(format!("the projection {} of this map does not reach {lat},{lon}", loaded.projector.name()))
            .help("use --around ID")
    })?;
    Ok(Focus::Around(place, args.radius))
}
