//! `draw --stage … --each`: a page with pictures of every intersection, a row each, a column for every stage.

use std::fmt::Write;

use crate::builder::Plan;
use crate::report::draw;
use crate::report::draw::sketch::around;
use crate::report::failure::Failure;
use crate::report::html::escape;

use super::args::CLEAN;
use super::draw_args::DrawArgs;
use super::output::{self, Progress};
use super::stage::{self, Pictures};
use crate::api::files;

/// Look of the page.
const STYLE: &str = "body{font:15px system-ui,sans-serif;margin:1.5em;background:#f6f6f3;color:#1d2024}\
    section{margin-bottom:2em}figure{display:inline-block;margin:0 1em 0 0}img{max-width:44vw;max-height:80vh;\
    border:1px solid #c5c9c2}figcaption{font-size:13px}.wide img{max-width:94vw}h2{font-size:16px}";

/// Draws the stages of every intersection.
pub fn run(args: &DrawArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let plan = stage::plan(args, &progress)?;
    progress.next("drawing");
    let count = write(args, &plan, &progress)?;
    drop(progress);
    output::print(&format!("{}: {count} intersections\n", output::shown(&args.output.join("index.html"))))?;
    Ok(CLEAN)
}

/// The beginning of a page of pictures; the title is taken as it is.
pub fn head(title: &str) -> String {
    format!("<!doctype html><meta charset=\"utf-8\"><title>{title}</title><style>{STYLE}</style><h1>{title}</h1>\n")
}

/// Writes pictures of all intersections that join three roads or more, or several nodes; returns how many there are.
fn write(args: &DrawArgs, plan: &Plan, progress: &Progress) -> Result<usize, Failure> {
    let network = &plan.streets.network;
    let shown = |i: &usize| network.intersections[*i].arms.len() >= 3 || network.intersections[*i].nodes.len() > 1;
    let all: Vec<usize> = (0..network.intersections.len()).filter(shown).collect();
    let title = args
        .map
        .as_ref()
        .and_then(|map| map.file_name())
        .map_or_else(String::new, |name| escape(&name.display().to_string()));
    let mut page = head(&title);
    let pictures = Pictures::new(args, plan);
    for (done, &at) in all.iter().enumerate() {
        progress.next(&format!("drawing {} of {}", done + 1, all.len()));
        let intersection = &network.intersections[at];
        let node = intersection.nodes.first().copied().unwrap_or_default();
        let outline = &plan.streets.outlines.intersections[at];
        let _ = writeln!(
            page,
            "<section id=\"{node}\"><h2>node {node}: {:?}, {} roads, {} nodes</h2>",
            outline.case,
            intersection.arms.len(),
            intersection.nodes.len()
        );
        for &what in &args.stage {
            let name = format!("{node}-{}.png", what.name());
            let focus = around(&stage::corners(plan, at)).unwrap_or_default();
            let svg = pictures.svg(what, focus)?;
            let png = draw::rendered(&svg).map_err(stage::failure)?;
            files::publish(&args.output, &[(&name, &png)])?;
            let _ = writeln!(
                page,
                "<figure><a href=\"{name}\"><img loading=\"lazy\" src=\"{name}\"></a><figcaption>{}</figcaption></figure>",
                what.name()
            );
        }
        page.push_str("</section>\n");
    }
    files::publish(&args.output, &[("index.html", page.as_bytes())])?;
    Ok(all.len())
}
