//! `draw --stage`: one step of the builder as a picture, with the points that decided.

use std::cell::OnceCell;

use crate::api::files;
use crate::builder::network::{IntersectionIx, Road, RoadIx};
use crate::builder::streets::consolidate::MergeNote;
use crate::builder::streets::outline::debug_steps::{DebugSteps, trace};
use crate::builder::streets::outline::{MITER_LIMIT, OutlineCase};
use crate::builder::tags::cross_section::StripKind;
use crate::builder::{Plan, build_plan};
use crate::geometry::{Point, Polyline, left_of};
use crate::lanelet::LaneletMap;
use crate::projection::LonLat;
use crate::report::draw;
use crate::report::draw::sketch::{Mark, Sketch, around};
use crate::report::draw::{DrawError, Focus, Options, View};
use crate::report::failure::Failure;

use super::args::{CLEAN, StreetArgs};
use super::draw_args::{DrawArgs, StageArg};
use super::input;
use super::output::{self, Progress};

/// The streets that the arguments name.
pub fn plan(args: &DrawArgs, progress: &Progress) -> Result<Plan, Failure> {
    let input = args.map.as_deref().unwrap_or_else(|| "".as_ref());
    Ok(input::streets(input, &StreetArgs::default(), progress)?.plan)
}

/// Draws one stage of all that the arguments ask for.
pub fn run(args: &DrawArgs) -> Result<u8, Failure> {
    let progress = Progress::start("reading");
    let plan = plan(args, &progress)?;
    progress.next("drawing");
    let [stage] = args.stage[..] else {
        return Err(Failure::new("several stages need several pictures").help("add --each, or give one --stage"));
    };
    let svg = Pictures::new(args, &plan).svg(stage, focus(args, &plan)?)?;
    publish(args, &svg)?;
    drop(progress);
    output::tell(&args.output, &format!("{}\n", output::shown(&args.output)))?;
    Ok(CLEAN)
}

/// Writes a picture in the format that the output's name asks for.
pub fn publish(args: &DrawArgs, svg: &str) -> Result<(), Failure> {
    let extension = args.output.extension().map(|e| e.to_ascii_lowercase());
    match extension.as_ref().and_then(|e| e.to_str()) {
        _ if files::is_stdout(&args.output) => files::write(&args.output, svg.as_bytes()),
        Some("svg") => files::write(&args.output, svg.as_bytes()),
        Some("png") => files::write(&args.output, &draw::rendered(svg).map_err(failure)?),
        _ => Err(Failure::new(format!("{} is neither .svg nor .png", args.output.display()))
            .help("name the picture with one of the two endings")),
    }
}

pub fn failure(error: DrawError) -> Failure {
    Failure::new(error.to_string()).help(error.help())
}

/// The part of the streets that the arguments ask for.
pub fn focus(args: &DrawArgs, plan: &Plan) -> Result<Focus, Failure> {
    if let Some(id) = args.around {
        return around_id(plan, id).ok_or_else(|| {
            Failure::new(format!("the streets have nothing with the id {id}"))
                .help("give the OpenStreetMap id of a node where roads meet, or of a way")
        });
    }
    let Some((lat, lon)) = args.at else { return Ok(Focus::Whole) };
    let place = plan.projector.forward(LonLat { lon, lat }, 0.0).ok_or_else(|| {
        Failure::new(format!("the projection {} does not reach {lat},{lon}", plan.projector.name()))
            .help("use --around ID")
    })?;
    Ok(Focus::Around(place, args.radius))
}

fn around_id(plan: &Plan, id: i64) -> Option<Focus> {
    let network = &plan.streets.network;
    if let Some(at) = network.intersections.iter().position(|i| i.nodes.contains(&id)) {
        return around(&corners(plan, at));
    }
    let roads = network.roads.iter().filter(|road| road.ways.contains(&id));
    around(&roads.flat_map(|road| road.line.points().iter().copied()).collect::<Vec<_>>())
}

/// The outline of an intersection, or its place where it has none.
pub fn corners(plan: &Plan, at: usize) -> Vec<Point> {
    let ring = &plan.streets.outlines.intersections[at].ring;
    if ring.is_empty() { vec![plan.streets.network.intersections[at].position] } else { ring.clone() }
}

/// Streets to draw, and the map that they become once it is asked for.
pub struct Pictures<'a> {
    args: &'a DrawArgs,
    plan: &'a Plan,
    map: OnceCell<LaneletMap>,
}

impl<'a> Pictures<'a> {
    pub fn new(args: &'a DrawArgs, plan: &'a Plan) -> Self {
        Self { args, plan, map: OnceCell::new() }
    }

    /// A stage as an SVG document.
    pub fn svg(&self, stage: StageArg, focus: Focus) -> Result<String, Failure> {
        let Self { args, plan, map } = self;
        let title = args.map.as_ref().map_or_else(String::new, |map| map.display().to_string());
        if stage == StageArg::Movements {
            let map = map.get_or_init(|| build_plan((*plan).clone()).map);
            let options = Options { focus, scale: args.scale, ids: args.ids, title, ..Options::default() };
            return draw::svg(map, &[], &options).map_err(failure);
        }
        let view = view(plan, focus, args.scale)?;
        Ok(sketch(plan, stage, Some(view), args.ids).svg(view, &title))
    }
}

/// The part of the plane that a focus shows, the same for every stage.
pub fn view(plan: &Plan, focus: Focus, scale: Option<f64>) -> Result<View, Failure> {
    let all = if focus == Focus::Whole { sketch(plan, StageArg::Outline, None, false) } else { Sketch::default() };
    all.view(focus, scale).map_err(failure)
}

/// What a stage shows within a view; everything without one.
pub fn sketch(plan: &Plan, stage: StageArg, view: Option<View>, ids: bool) -> Sketch {
    let stage_of = Stage { plan, view, ids };
    let mut sketch = Sketch::default();
    match stage {
        StageArg::Thicken => stage_of.thicken(&mut sketch),
        StageArg::Collide => stage_of.collide(&mut sketch),
        StageArg::Trim => stage_of.trim(&mut sketch),
        StageArg::Outline | StageArg::Movements => stage_of.outline(&mut sketch),
        StageArg::Consolidate => stage_of.consolidate(&mut sketch),
        StageArg::Lanes => stage_of.lanes(&mut sketch),
    }
    if ids {
        sketch.push("ids", stage_of.ids());
    }
    sketch
}

struct Stage<'a> {
    plan: &'a Plan,
    view: Option<View>,
    ids: bool,
}

fn line(class: &'static str, points: &[Point], title: &str) -> Mark {
    Mark::Line { class, points: points.to_vec(), title: title.to_owned() }
}

fn spot(class: &'static str, at: Point, title: String) -> Mark {
    Mark::Spot { class, at, title }
}

impl Stage<'_> {
    fn sees(&self, points: &[Point]) -> bool {
        self.view.is_none_or(|view| view.sees(points))
    }

    fn roads(&self) -> impl Iterator<Item = (usize, &Road)> {
        let roads = self.plan.streets.network.roads.iter().enumerate();
        roads.filter(|(_, road)| self.sees(road.line.points()))
    }

    fn intersections(&self) -> impl Iterator<Item = usize> {
        (0..self.plan.streets.network.intersections.len()).filter(|at| self.sees(&corners(self.plan, *at)))
    }

    fn traces(&self) -> Vec<DebugSteps> {
        let network = &self.plan.streets.network;
        self.intersections().map(|at| trace(network, IntersectionIx::new(at))).collect()
    }

    fn thicken(&self, sketch: &mut Sketch) {
        let (mut edges, mut centres) = (Vec::new(), Vec::new());
        for (_, road) in self.roads() {
            let half = road.half_width();
            let title = title(road);
            for offset in [half, -half] {
                edges.extend(road.line.offset(offset, MITER_LIMIT).map(|edge| line("edge", edge.points(), &title)));
            }
            centres.push(line("centre", road.line.points(), &title));
        }
        sketch.push("edges", edges);
        sketch.push("centres", centres);
        let network = &self.plan.streets.network;
        let nodes = self.intersections().map(|at| {
            let intersection = &network.intersections[at];
            spot("node", intersection.position, format!("node {:?}", intersection.nodes))
        });
        sketch.push("nodes", nodes.collect());
        sketch.key.extend([("edge", "edge"), ("centre", "centre line")]);
    }

    fn collide(&self, sketch: &mut Sketch) {
        self.thicken(sketch);
        let (mut feet, mut hits) = (Vec::new(), Vec::new());
        for hit in self.traces().iter().flat_map(|trace| &trace.hits) {
            for (foot, decides) in hit.feet.iter().zip(hit.decides) {
                if decides {
                    feet.push(line("foot", &[hit.point, *foot], ""));
                }
            }
            let class = if hit.decides.contains(&true) { "decides" } else { "hit" };
            hits.push(spot(class, hit.point, "edges collide".to_owned()));
        }
        sketch.push("feet", feet);
        sketch.push("collisions", hits);
        sketch.key.extend([("hit", "collision"), ("decides", "the one that decides")]);
    }

    fn trim(&self, sketch: &mut Sketch) {
        self.thicken(sketch);
        let network = &self.plan.streets.network;
        let (mut bars, mut words) = (Vec::new(), Vec::new());
        for arm in self.traces().iter().flat_map(|trace| &trace.arms) {
            let half = network.road(arm.at.road).half_width();
            for (class, trim) in [("wanted", arm.wanted), ("least", arm.least)] {
                bars.push(line(class, &bar(&arm.line, trim, half), &format!("{class}: {trim:.1} m")));
            }
            if self.ids {
                words.push(Mark::Words {
                    at: arm.line.at(arm.wanted + 2.0),
                    text: format!("{:.1} {:.1}", arm.least, arm.wanted),
                });
            }
        }
        sketch.push("trims", bars);
        sketch.push("cuts", self.cuts());
        sketch.push("metres", words);
        sketch.key.extend([("least", "least"), ("wanted", "with kerbs"), ("cut", "cut")]);
    }

    fn cuts(&self) -> Vec<Mark> {
        let outlines = &self.plan.streets.outlines.intersections;
        let cuts = self.intersections().flat_map(|at| &outlines[at].cuts);
        cuts.map(|cut| line("cut", &[cut.left, cut.right], "cut")).collect()
    }

    fn ribbons(&self) -> Vec<Mark> {
        let ribbons = self.roads().filter_map(|(i, road)| {
            let half = road.half_width();
            let ring = ribbon(self.kept(i, road)?.as_ref(), half, -half)?;
            Some(Mark::Area { class: "carriage", ring, title: title(road) })
        });
        ribbons.collect()
    }

    fn kept(&self, index: usize, road: &Road) -> Option<Option<Polyline>> {
        let [from, to] = *self.plan.streets.outlines.kept.get(index)?;
        Some(road.line.cut(from, to))
    }

    fn outline_areas(&self) -> Vec<Mark> {
        let streets = &self.plan.streets;
        let areas = self.intersections().map(|at| {
            let (outline, intersection) = (&streets.outlines.intersections[at], &streets.network.intersections[at]);
            let class = match outline.case {
                OutlineCase::Fallback => "outline fallback",
                _ if intersection.nodes.len() > 1 => "outline merged",
                _ => "outline",
            };
            let title = format!("node {:?} · {:?}", intersection.nodes, outline.case);
            Mark::Area { class, ring: outline.ring.clone(), title }
        });
        areas.collect()
    }

    fn outline(&self, sketch: &mut Sketch) {
        sketch.push("roads", self.ribbons());
        sketch.push("outlines", self.outline_areas());
        let outlines = &self.plan.streets.outlines.intersections;
        let kerbs = self.intersections().flat_map(|at| &outlines[at].corners).filter(|c| c.len() > 1);
        sketch.push("kerbs", kerbs.map(|corner| line("kerb", corner, "kerb")).collect());
        sketch.push("cuts", self.cuts());
    }

    fn consolidate(&self, sketch: &mut Sketch) {
        let streets = &self.plan.streets;
        sketch.push("roads", self.ribbons());
        sketch.push("outlines", self.outline_areas());
        let (mut lines, mut words) = (Vec::new(), Vec::new());
        let mut say = |class, points: &Polyline, note: Option<&MergeNote>| {
            let title = note.map_or_else(|| "inside a merged intersection".to_owned(), ToString::to_string);
            lines.push(line(class, points.points(), &title));
            if let Some(note) = note {
                let reason = format!("{:?} {:.1} m", note.reason, note.left);
                words.push(Mark::Words { at: points.at(points.length() / 2.0), text: reason });
            }
        };
        let note_of = |key| {
            let at = streets.merges.partition_point(|note| note.key < key);
            streets.merges.get(at).filter(|note| note.key == key)
        };
        for at in self.intersections() {
            for inner in &streets.network.intersections[at].inner {
                say("in", &inner.line, note_of(inner.key));
            }
        }
        for (_, road) in self.roads() {
            if let Some(note) = note_of(road.key).filter(|note| !note.merged) {
                say("out", &road.line, Some(note));
            }
        }
        sketch.push("decisions", lines);
        sketch.push("reasons", words);
        sketch.key.extend([("in", "merged"), ("out", "kept apart")]);
    }

    fn lanes(&self, sketch: &mut Sketch) {
        sketch.push("outlines", self.outline_areas());
        let strips = self.roads().flat_map(|(i, road)| {
            let line = self.kept(i, road).flatten();
            let strip = move |(s, strip): (usize, &crate::builder::tags::cross_section::Strip)| {
                let ring = ribbon(line.as_ref(), road.section.edge(s), road.section.edge(s + 1))?;
                let title = format!("{} · {:?} {:?} {:.2} m", title(road), strip.kind, strip.travel, strip.width);
                Some(Mark::Area { class: strip_class(strip.kind), ring, title })
            };
            road.section.strips.iter().enumerate().filter_map(strip).collect::<Vec<_>>()
        });
        sketch.push("strips", strips.collect());
        sketch.push("cuts", self.cuts());
        sketch.key.extend([("strip-drive", "drive"), ("strip-bus", "bus"), ("strip-bicycle", "bicycle")]);
        sketch.key.extend([("strip-parking", "parking"), ("strip-sidewalk", "sidewalk")]);
    }

    fn ids(&self) -> Vec<Mark> {
        let network = &self.plan.streets.network;
        let nodes = self.intersections().filter_map(|at| {
            let intersection = &network.intersections[at];
            Some(Mark::Words { at: intersection.position, text: intersection.nodes.first()?.to_string() })
        });
        let roads = self.roads().map(|(i, _)| {
            let road = network.road(RoadIx::new(i));
            Mark::Words { at: road.line.at(road.line.length() / 2.0), text: road.key.way.to_string() }
        });
        nodes.chain(roads).collect()
    }
}

fn title(road: &Road) -> String {
    let name = road.name.as_deref().unwrap_or_default();
    format!("way {} {name}", road.key.way)
}

/// The line across a road at a station.
fn bar(line: &Polyline, station: f64, half: f64) -> [Point; 2] {
    let across = left_of(line.direction(station)) * half;
    [line.at(station) + across, line.at(station) - across]
}

/// The ground between two offsets of a line.
fn ribbon(line: Option<&Polyline>, left: f64, right: f64) -> Option<Vec<Point>> {
    let mut ring = line?.offset(left, MITER_LIMIT)?.points().to_vec();
    ring.extend(line?.offset(right, MITER_LIMIT)?.points().iter().rev());
    Some(ring)
}

fn strip_class(kind: StripKind) -> &'static str {
    match kind {
        StripKind::Drive => "strip strip-drive",
        StripKind::Bus => "strip strip-bus",
        StripKind::Bicycle => "strip strip-bicycle",
        StripKind::Parking => "strip strip-parking",
        StripKind::Pedestrian => "strip strip-pedestrian",
        StripKind::Shoulder => "strip strip-shoulder",
        StripKind::Sidewalk => "strip strip-sidewalk",
        StripKind::Buffer => "strip strip-buffer",
    }
}
