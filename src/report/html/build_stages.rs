//! How a map comes to be, as a page shows it: the stages of the builder, and the input that hands may change.

use serde_json::{Value, json};

use super::data::relative;
use super::plane::Frame;
use crate::geometry::Point;
use crate::report::draw::sketch::{Mark, Sketch};

/// A stage of the builder.
#[derive(Clone, Debug, Default)]
pub struct Stage {
    /// `trim`.
    pub name: String,
    /// What it is, in a few words.
    pub title: String,
    /// What is drawn; empty where the map itself is.
    pub sketch: Sketch,
}

/// A way of the input.
#[derive(Clone, Debug)]
pub struct InputWay {
    /// Its id.
    pub id: i64,
    /// Its nodes, by their number in [`BuildStages::nodes`].
    pub nodes: Vec<usize>,
    /// Its tags.
    pub tags: Vec<(String, String)>,
}

/// A road between two intersections, or inside one.
#[derive(Clone, Debug)]
pub struct InputRoad {
    /// Id of its way.
    pub way: i64,
    /// The nodes at its ends.
    pub ends: [i64; 2],
    /// Whether it lies inside an intersection.
    pub merged: bool,
    /// What decided, where there was something to decide.
    pub why: Option<String>,
}

/// Streets in the making.
#[derive(Clone, Debug, Default)]
pub struct BuildStages {
    /// The stages in their order.
    pub stages: Vec<Stage>,
    /// The nodes of the input's roads: id and place in the map's metres.
    pub nodes: Vec<(i64, Point)>,
    /// The input's roads.
    pub ways: Vec<InputWay>,
    /// What became of them.
    pub roads: Vec<InputRoad>,
    /// Milliseconds that all of it took.
    pub took: u64,
    /// Where only the surroundings of a place were built: the box's corners, and how many ways of how many.
    pub part: Option<([Point; 2], [usize; 2])>,
}

/// A build_stages as the page reads it. Ids are texts: JavaScript's numbers do not hold all of them.
pub fn page_build_stages(build_stages: &BuildStages, frame: &Frame) -> Value {
    let stages = build_stages.stages.iter().map(|Stage { name, title, sketch }| {
        let layers = sketch.layers.iter().map(|(name, marks)| {
            let marks: Vec<Value> = marks.iter().map(|mark| of_mark(mark, frame)).collect();
            json!({ "name": name, "marks": marks })
        });
        json!({ "name": name, "title": title, "layers": layers.collect::<Vec<_>>(), "key": sketch.key })
    });
    let nodes = build_stages.nodes.iter().map(|(id, at)| {
        let [x, y] = relative(*at, frame);
        json!([id.to_string(), x, y])
    });
    let ways =
        build_stages.ways.iter().map(|way| json!({ "id": way.id.to_string(), "nodes": way.nodes, "tags": way.tags }));
    let roads = build_stages.roads.iter().map(|road| {
        let InputRoad { way, ends, merged, why } = road;
        let ends = ends.map(|id| id.to_string());
        json!({ "way": way.to_string(), "ends": ends, "merged": merged, "why": why })
    });
    let part = build_stages.part.map(|(corners, [ways, of])| {
        let [low, high] = corners.map(|corner| relative(corner, frame));
        json!({ "box": [low[0], low[1], high[0], high[1]], "ways": ways, "of": of })
    });
    json!({
        "stages": stages.collect::<Vec<_>>(),
        "nodes": nodes.collect::<Vec<_>>(),
        "ways": ways.collect::<Vec<_>>(),
        "roads": roads.collect::<Vec<_>>(),
        "took": build_stages.took,
        "part": part,
    })
}

/// Kind, class, what a pointer over it shows, and x, y, x, y, …
fn of_mark(mark: &Mark, frame: &Frame) -> Value {
    let flat = |points: &[Point]| points.iter().flat_map(|p| relative(*p, frame)).collect::<Vec<f64>>();
    match mark {
        Mark::Area { class, ring, title } => json!(["area", class, title, flat(ring)]),
        Mark::Line { class, points, title } => json!(["line", class, title, flat(points)]),
        Mark::Spot { class, at, title } => json!(["spot", class, title, flat(&[*at])]),
        Mark::Words { at, text } => json!(["words", "words", text, flat(&[*at])]),
    }
}
