//! `draw --compare`: two versions side by side, and the intersections that changed.

use std::fmt::Write;
use std::fs;
use std::path::Path;

use crate::builder::Plan;
use crate::builder::geojson::is_json;
use crate::geometry::{Point, Polyline};
use crate::report::draw::sketch::{Mark, beside};
use crate::report::draw::{self, Focus, Options, bounding_box};
use crate::report::failure::Failure;
use crate::report::visible;

use super::args::{CLEAN, StreetArgs};
use super::draw_args::{DrawArgs, StageArg};
use super::output::{self, Progress};
use super::{input, stage};
use crate::api::Loaded;

/// Outlines that lie apart by no more than this, metres, have not changed.
const SAME_OUTLINE: f64 = 0.05;
/// The most intersections that are listed.
const LISTED: usize = 200;

/// One version of a place.
enum Version {
    Streets(Box<Plan>),
    Map(Box<Loaded>),
}

/// What identifies an intersection, and its outline.
struct Shape {
    nodes: Vec<i64>,
    ring: Vec<Point>,
}

/// Draws both versions of the same part.
pub fn run(args: &DrawArgs, old: &Path, new: &Path) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let (before, after) = (read(old, &progress)?, read(new, &progress)?);
    progress.next("comparing");
    let (shapes_before, shapes_after) = (shapes(&before), shapes(&after));
    let changes = changes(&shapes_before, &shapes_after);
    let focus = focus(args, &after, &changes)?;
    let picture = match (&before, &after) {
        (Version::Streets(before), Version::Streets(after)) if before.projector == after.projector => {
            let stage = args.stage.first().copied().unwrap_or(StageArg::Outline);
            let view = stage::view(after, focus, args.scale)?;
            let side = |plan: &Plan, shapes: &[Shape], path: &Path| {
                let mut sketch = stage::sketch(plan, stage, Some(view), args.ids);
                let changed = shapes.iter().filter(|s| changes.iter().any(|c| c.touches(s)));
                let marks = changed.map(|s| Mark::Area {
                    class: "outline changed",
                    ring: s.ring.clone(),
                    title: format!("node {:?} changed", s.nodes),
                });
                sketch.push("changed", marks.collect());
                sketch.svg(view, &path.display().to_string())
            };
            beside(&side(before, &shapes_before, old), &side(after, &shapes_after, new), view)
        }
        (Version::Map(before), Version::Map(after)) if before.projector == after.projector => {
            let options = Options { focus, scale: args.scale, ids: args.ids, ..Options::default() };
            let view = draw::view(&after.map, &options).map_err(stage::failure)?;
            let [left, right] = [before, after].map(|version| draw::svg_of(&version.map, &[], view, &options));
            beside(&left, &right, view)
        }
        (Version::Streets(_), Version::Map(_)) | (Version::Map(_), Version::Streets(_)) => {
            return Err(Failure::new("one is a Lanelet2 map and the other is not").help("compare two of one kind"));
        }
        _ => {
            return Err(Failure::new("the two lie in the planes of different projections")
                .help("make both with the same --projector"));
        }
    };
    stage::publish(args, &picture)?;
    drop(progress);
    output::tell(&args.output, &list(args, &changes, [shapes_before.len(), shapes_after.len()]))?;
    Ok(CLEAN)
}

fn read(path: &Path, progress: &Progress) -> Result<Version, Failure> {
    let is_map = path.is_dir() || {
        let bytes = fs::read(path).unwrap_or_default();
        !is_json(&bytes) && holds(&bytes, b"lanelet")
    };
    Ok(match is_map {
        true => Version::Map(Box::new(Loaded::read(path, &Default::default())?)),
        false => Version::Streets(Box::new(input::streets(path, &StreetArgs::default(), progress)?.plan)),
    })
}

/// Whether a text has a tag of this value.
fn holds(text: &[u8], value: &[u8]) -> bool {
    let tag = [b"v=\"".as_slice(), value, b"\""].concat();
    text.windows(tag.len()).any(|window| window == tag)
}

fn shapes(version: &Version) -> Vec<Shape> {
    match version {
        Version::Streets(plan) => {
            let outlines = plan.streets.outlines.intersections.iter();
            let both = plan.streets.network.intersections.iter().zip(outlines);
            both.map(|(i, outline)| Shape { nodes: i.nodes.clone(), ring: outline.ring.clone() }).collect()
        }
        Version::Map(loaded) => {
            let areas = loaded.map.polygons.iter().filter(|p| p.attributes.is("type", "intersection_area"));
            let place = |id: &_| loaded.map.points.get(*id).map(|p| p.position);
            let ring = |points: &[_]| points.iter().filter_map(place).collect();
            areas.map(|area| Shape { nodes: vec![area.id.0], ring: ring(&area.points) }).collect()
        }
    }
}

/// What became of some intersections.
struct Change {
    nodes: Vec<i64>,
    what: String,
    around: Vec<Point>,
}

impl Change {
    fn touches(&self, shape: &Shape) -> bool {
        shape.nodes.iter().any(|node| self.nodes.contains(node))
    }
}

/// The intersections that differ, in order of their smallest node.
fn changes(old: &[Shape], new: &[Shape]) -> Vec<Change> {
    let index = |shapes: &[Shape]| {
        let nodes = shapes.iter().enumerate().flat_map(|(i, s)| s.nodes.iter().map(move |node| (*node, i)));
        nodes.collect::<std::collections::BTreeMap<i64, usize>>()
    };
    let (of_old, of_new) = (index(old), index(new));
    let mut changes = Vec::new();
    for shape in new {
        let before: std::collections::BTreeSet<usize> =
            shape.nodes.iter().filter_map(|node| of_old.get(node).copied()).collect();
        let what = match before.iter().collect::<Vec<_>>()[..] {
            [] => Some("new".to_owned()),
            [only] if old[*only].nodes == shape.nodes => moved(&old[*only].ring, &shape.ring),
            [_] => Some("made of other nodes".to_owned()),
            ref several => Some(format!("merged: were {}", several.len())),
        };
        let around = before.iter().flat_map(|i| &old[*i].ring).chain(&shape.ring).copied().collect();
        changes.extend(what.map(|what| Change { nodes: shape.nodes.clone(), what, around }));
    }
    let gone = old.iter().filter(|shape| !shape.nodes.iter().any(|node| of_new.contains_key(node)));
    changes.extend(gone.map(|s| Change { nodes: s.nodes.clone(), what: "gone".to_owned(), around: s.ring.clone() }));
    changes.sort_by(|a, b| a.nodes.cmp(&b.nodes));
    changes
}

/// How far two outlines lie apart, if that is to be seen.
fn moved(old: &[Point], new: &[Point]) -> Option<String> {
    let closed = |ring: &[Point]| Polyline::new(ring.iter().chain(ring.first()).copied());
    match (closed(old), closed(new)) {
        (Some(a), Some(b)) => {
            let farthest =
                |points: &[Point], line: &Polyline| points.iter().map(|p| line.distance(*p)).fold(0.0, f64::max);
            let apart = farthest(old, &b).max(farthest(new, &a));
            (apart > SAME_OUTLINE).then(|| format!("its outline moved by {apart:.2} m"))
        }
        (None, None) => None,
        (None, Some(_)) => Some("it has an outline now".to_owned()),
        (Some(_), None) => Some("it has no outline any more".to_owned()),
    }
}

/// What the user asks for, else all that changed.
fn focus(args: &DrawArgs, version: &Version, changes: &[Change]) -> Result<Focus, Failure> {
    match version {
        Version::Streets(plan) if args.around.is_some() || args.at.is_some() => stage::focus(args, plan),
        Version::Map(loaded) if args.around.is_some() || args.at.is_some() => args.focus(loaded),
        _ => {
            /// White around what changed, metres.
            const MARGIN: f64 = 15.0;
            let changed = bounding_box(changes.iter().flat_map(|change| &change.around));
            Ok(changed.map_or(Focus::Whole, |(min, max)| {
                let radius = (max.x - min.x).max(max.y - min.y) / 2.0 + MARGIN;
                Focus::Around(middle(min, max), radius)
            }))
        }
    }
}

/// The place midway between two.
fn middle(a: Point, b: Point) -> Point {
    a + (b - a) / 2.0
}

fn list(args: &DrawArgs, changes: &[Change], [old, new]: [usize; 2]) -> String {
    let mut text =
        format!("{}: {} of {old} intersections changed, now {new}\n", output::shown(&args.output), changes.len());
    for change in changes.iter().take(LISTED) {
        let nodes: Vec<String> = change.nodes.iter().map(ToString::to_string).collect();
        let _ = writeln!(text, "  {}: {}", nodes.join(" "), visible(&change.what));
    }
    if changes.len() > LISTED {
        let _ = writeln!(text, "  and {} more", changes.len() - LISTED);
    }
    text
}
