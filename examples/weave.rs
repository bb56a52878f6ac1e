//! Weaves the lanes of streets and draws them: `weave INPUT.osm OUT.png [EAST NORTH REACH]`, the last three in metres
//! from the middle of the streets. Then edits every lane once and says how long that took.

use std::fmt::Write;
use std::path::PathBuf;
use std::time::Instant;

use lanewright::builder::single_lanes::single_lanes;
use lanewright::builder::{BuildOptions, plan};
use lanewright::geometry::Point;
use lanewright::osm::read_file;
use lanewright::report::draw::rendered;
use lanewright::weave::{Colour, LaneEnd, Meeting, Weave};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args_os().skip(1);
    let mut path = || arguments.next().map(PathBuf::from).ok_or("usage: weave INPUT.osm OUT.png [EAST NORTH REACH]");
    let (input, output) = (path()?, path()?);
    let numbers: Vec<f64> = arguments.filter_map(|number| number.to_str()?.parse().ok()).collect();
    let streets = plan(&read_file(&input)?, &BuildOptions::default())?.streets;
    let lanes = single_lanes(&streets.network, &streets.outlines.kept);
    let start = Instant::now();
    let mut weave = Weave::new(lanes.clone());
    let whole = start.elapsed();
    std::fs::write(output, rendered(&picture(&weave, &numbers))?)?;
    let joints = weave.iter().filter(|(id, _)| matches!(weave.meeting(*id, LaneEnd::End), Some(Meeting::Joined(_))));
    println!("{} lanes with {} joints woven in {whole:.1?}", lanes.len(), joints.count());
    let count = u32::try_from(lanes.len())?.max(1);
    let start = Instant::now();
    let anew: usize = lanes.into_iter().map(|(id, lane)| weave.set(id, lane).len()).sum();
    println!("{anew} woven anew in as many edits, one in {:.1?}", start.elapsed() / count);
    Ok(())
}

fn picture(weave: &Weave, numbers: &[f64]) -> String {
    let places = || weave.iter().flat_map(|(_, lane)| lane.outline());
    let fold = |of: fn(&Point) -> f64| {
        let (low, high) = places().map(of).fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        [(low + high) / 2.0, (high - low) / 2.0]
    };
    let ([x, wide], [y, high]) = (fold(|p| p.x), fold(|p| p.y));
    let (x, y, reach) = match numbers {
        [east, north, reach] => (x + east, y + north, *reach),
        _ => (x, y, wide.max(high)),
    };
    let mut svg = format!(
        "<svg xmlns='http://www.w3.org/2000/svg' width='1400' height='1400' viewBox='{} {} {} {}'>\
         <rect x='{0}' y='{1}' width='{2}' height='{3}' fill='#e8ebe4'/>",
        -reach,
        -reach,
        2.0 * reach,
        2.0 * reach
    );
    let path = |points: &[Point]| {
        points.iter().fold(String::new(), |mut path, p| {
            let _ = write!(path, "{:.3},{:.3} ", p.x - x, y - p.y);
            path
        })
    };
    for (_, lane) in weave.iter() {
        let outline = path(lane.outline());
        let _ = write!(svg, "<polygon points='{outline}' fill='#6a717b' stroke='#c05' stroke-width='0.04'/>");
    }
    for stroke in weave.iter().flat_map(|(_, lane)| lane.strokes().iter()) {
        let colour = match stroke.colour {
            Colour::White => "#fff",
            Colour::Yellow => "#fc3",
            Colour::Grey => "#24282d",
            Colour::Magenta => "#f0f",
        };
        let (line, breadth) = (path(stroke.line), stroke.breadth);
        let _ = write!(svg, "<polyline points='{line}' fill='none' stroke='{colour}' stroke-width='{breadth}'/>");
    }
    svg + "</svg>"
}
