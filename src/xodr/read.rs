//! From the elements of a file to roads, junctions, signals and objects. What breaks the standard is told, and the rest is read.

use crate::geometry::Point;
use crate::text::Text;

use super::cubic::{Cubic, Cubics};
use super::damage::damage;
use super::document::{Document, Ix};
use super::error::{Oddity, XodrError};
use super::furniture::{Corner, Object, Signal, SignalReference, Validity};
use super::georeference::georeference;
use super::junction::{Connection, Controller, Junction, JunctionKind};
use super::plan_view::{PlanRecord, PlanView, Shape};
use super::road::{Lane, Road, RoadEnd, RoadLink, RoadMark, Section};
use super::surface::{LaneHeights, Shapes};
use super::{Header, OpenDrive};

/// Reads the text of an OpenDRIVE file.
///
/// # Errors
///
/// Where it is not well-formed XML, is cut off, or has another root.
pub fn read(text: &str) -> Result<OpenDrive, XodrError> {
    let document = Document::read(text)?;
    let mut reading = Reading { document: &document, oddities: Vec::new() };
    let root = document.root();
    let header = reading.header();
    let mut roads: Vec<Road> = Vec::new();
    let mut known = std::collections::BTreeSet::new();
    for ix in document.children(root, "road") {
        let road = reading.road(ix);
        if known.insert(road.id.clone()) {
            roads.push(road);
        } else {
            reading.odd(ix, format!("road {} is there twice: the second one is left out", road.id));
        }
    }
    let junctions = document.children(root, "junction").map(|ix| reading.junction(ix)).collect();
    let controllers = document.children(root, "controller").map(|ix| reading.controller(ix)).collect();
    Ok(OpenDrive { header, roads, junctions, controllers, oddities: reading.oddities })
}

/// The largest number that has a meaning: metres across the earth.
const LARGEST: f64 = 1e9;
/// The most that one record of a reference line turns, radians: a ramp of thirty turns.
const MOST_TURN: f64 = 60.0 * std::f64::consts::PI;

struct Reading<'a> {
    document: &'a Document,
    oddities: Vec<Oddity>,
}

impl Reading<'_> {
    fn odd(&mut self, ix: Ix, message: String) {
        self.oddities.push(Oddity { line: self.document.line(ix), message });
    }

    fn text(&self, ix: Ix, key: &str) -> Text {
        self.document.get(ix, key).map(Text::from).unwrap_or_default()
    }

    /// A number; `None` where it is not said, or not a number, which is told.
    fn said(&mut self, ix: Ix, key: &str) -> Option<f64> {
        let word = self.document.get(ix, key)?;
        match word.parse::<f64>() {
            Ok(number) if number.abs() <= LARGEST => Some(number),
            _ => {
                let name = self.document.name(ix);
                let word: String = word.chars().take(40).collect();
                self.odd(ix, format!("<{name} {key}=\"{word}\"> is not a number of use: it is taken for 0"));
                None
            }
        }
    }

    fn number(&mut self, ix: Ix, key: &str) -> f64 {
        self.said(ix, key).unwrap_or(0.0)
    }

    fn numbers<const N: usize>(&mut self, ix: Ix, keys: [&str; N]) -> [f64; N] {
        keys.map(|key| self.number(ix, key))
    }

    fn lane_id(&self, ix: Ix, key: &str) -> Option<i64> {
        self.document.get(ix, key)?.parse().ok().filter(|id: &i64| id.abs() < 10_000)
    }

    fn header(&mut self) -> Header {
        let document = self.document;
        let Some(ix) = document.child(document.root(), "header") else { return Header::default() };
        let words = document.child(ix, "geoReference");
        let plane = words.map(|words| georeference(document.text(words))).unwrap_or_default();
        if let (Some(words), Some(note)) = (words, &plane.note) {
            self.odd(words, note.clone());
        }
        let offset = document.child(ix, "offset").map(|offset| self.numbers(offset, ["x", "y", "z", "hdg"]));
        Header { line: document.line(words.unwrap_or(ix)), plane, offset: offset.unwrap_or_default() }
    }

    fn cubics(&mut self, parts: impl IntoIterator<Item = Ix>, start: &str) -> Cubics {
        let mut cubics = Vec::new();
        for ix in parts {
            let start = self.number(ix, start);
            cubics.push(Cubic { start, factors: self.numbers(ix, ["a", "b", "c", "d"]) });
        }
        Cubics::new(cubics)
    }

    fn road(&mut self, ix: Ix) -> Road {
        let document = self.document;
        let id = self.text(ix, "id");
        let records: Vec<PlanRecord> =
            document.descend(ix, &["planView", "geometry"]).into_iter().map(|it| self.record(it)).collect();
        let mut length = self.number(ix, "length");
        let reach = records.iter().map(|record| record.start + record.length).fold(0.0, f64::max);
        if length <= 0.0 && reach > 0.0 {
            self.odd(ix, format!("road {id} has no length: that of its reference line, {reach:.3} m, is taken"));
            length = reach;
        }
        if records.is_empty() {
            self.odd(ix, format!("road {id} has no reference line (planView): it is left out"));
        }
        let mut speeds = Vec::new();
        for kind in document.children(ix, "type") {
            let start = self.number(kind, "s");
            let limit = document.child(kind, "speed").and_then(|it| self.speed(it));
            // A type without a limit ends the one of the type before (ASAM OpenDRIVE 1.8, road type).
            speeds.push((start, limit));
        }
        speeds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let links = ["predecessor", "successor"].map(|side| self.road_link(ix, side));
        let mut road = Road {
            line: document.line(ix),
            length,
            junction: document.get(ix, "junction").filter(|id| *id != "-1").map(Text::from),
            left_hand: document.get(ix, "rule").is_some_and(|rule| rule.eq_ignore_ascii_case("LHT")),
            links,
            plan: PlanView::new(records),
            elevation: self.cubics(document.descend(ix, &["elevationProfile", "elevation"]), "s"),
            superelevation: self.cubics(document.descend(ix, &["lateralProfile", "superelevation"]), "s"),
            shapes: self.shapes(ix),
            lane_offset: self.cubics(document.descend(ix, &["lanes", "laneOffset"]), "s"),
            speeds,
            kind: document.child(ix, "type").map(|kind| self.text(kind, "type")).unwrap_or_default(),
            id,
            ..Road::default()
        };
        self.sections(ix, &mut road);
        if let Some(damage) = damage(&road) {
            self.odd(ix, format!("road {} {damage}: it is left out", road.id));
            road.plan = PlanView::default();
        }
        for (parent, child) in [("signals", "signal"), ("signals", "signalReference"), ("objects", "object")] {
            for it in document.descend(ix, &[parent, child]) {
                match child {
                    "signal" => road.signals.push(self.signal(it)),
                    "object" => road.objects.push(self.object(it)),
                    _ => road.references.push(SignalReference {
                        id: self.text(it, "id"),
                        line: document.line(it),
                        at: self.numbers(it, ["s", "t"]),
                        validity: self.validity(it),
                    }),
                }
            }
        }
        road
    }

    /// Cross-sections: polynomials of one station are one.
    fn shapes(&mut self, ix: Ix) -> Shapes {
        let mut parts: Vec<(f64, Ix)> = Vec::new();
        for shape in self.document.descend(ix, &["lateralProfile", "shape"]) {
            parts.push((self.number(shape, "s"), shape));
        }
        parts.sort_by(|a, b| a.0.total_cmp(&b.0));
        let sections = parts.chunk_by(|a, b| a.0 == b.0).filter_map(|parts| {
            let (station, _) = parts.first()?;
            Some((*station, self.cubics(parts.iter().map(|part| part.1), "t")))
        });
        Shapes::new(sections.collect())
    }

    fn road_link(&mut self, ix: Ix, side: &str) -> Option<RoadLink> {
        let document = self.document;
        let link = document.child(document.child(ix, "link")?, side)?;
        let id = Text::from(document.get(link, "elementId")?);
        if let Some(station) = document.get(link, "elementS") {
            let message =
                format!("a road branches off road {id} at s={station}, within it: no lane of the map leads there");
            self.odd(link, message);
            return None;
        }
        match document.get(link, "elementType") {
            Some("junction") => Some(RoadLink::Junction(id)),
            _ => Some(RoadLink::Road(id, self.contact(link))),
        }
    }

    fn contact(&self, ix: Ix) -> Option<RoadEnd> {
        match self.document.get(ix, "contactPoint") {
            Some("start") => Some(RoadEnd::Start),
            Some("end") => Some(RoadEnd::End),
            _ => None,
        }
    }

    fn record(&mut self, ix: Ix) -> PlanRecord {
        let document = self.document;
        let [start, x, y, heading, length] = self.numbers(ix, ["s", "x", "y", "hdg", "length"]);
        let shapes = ["line", "arc", "spiral", "poly3", "paramPoly3"];
        let shape = document.all_children(ix).find(|child| shapes.contains(&document.name(*child)));
        let shape = match shape.map(|shape| (shape, document.name(shape))) {
            Some((it, "arc")) => Shape::Arc(self.number(it, "curvature")),
            Some((it, "spiral")) => Shape::Spiral(self.numbers(it, ["curvStart", "curvEnd"])),
            Some((it, "poly3")) => Shape::Poly3(self.numbers(it, ["a", "b", "c", "d"])),
            Some((it, "paramPoly3")) => Shape::ParamPoly3 {
                u: self.numbers(it, ["aU", "bU", "cU", "dU"]),
                v: self.numbers(it, ["aV", "bV", "cV", "dV"]),
                by_length: document.get(it, "pRange") == Some("arcLength"),
            },
            Some(_) => Shape::Line,
            None => {
                self.odd(ix, "a <geometry> has no shape: it is taken for a line".to_owned());
                Shape::Line
            }
        };
        let curvature = match shape {
            Shape::Arc(curvature) => curvature.abs(),
            Shape::Spiral([from, to]) => from.abs().max(to.abs()),
            _ => 0.0,
        };
        let winds = curvature * length > MOST_TURN;
        if winds {
            self.odd(ix, "a <geometry> winds more than thirty times: it is taken for a line".to_owned());
        }
        let shape = if winds { Shape::Line } else { shape };
        PlanRecord { start, origin: Point::new(x, y), heading, length, shape }
    }

    /// km/h; `None` where it says that there is no limit, or nothing of use.
    fn speed(&mut self, ix: Ix) -> Option<f64> {
        let max = self.document.get(ix, "max")?.parse::<f64>().ok().filter(|max| *max > 0.0 && *max < LARGEST)?;
        let unit = match self.document.get(ix, "unit") {
            Some("mph") => 1.609_344,
            Some("km/h" | "kmh" | "kph") => 1.0,
            _ => 3.6,
        };
        Some(max * unit)
    }

    fn sections(&mut self, ix: Ix, road: &mut Road) {
        let document = self.document;
        let mut sections: Vec<(f64, Ix)> = Vec::new();
        for section in document.descend(ix, &["lanes", "laneSection"]) {
            sections.push((self.number(section, "s").clamp(0.0, road.length.max(0.0)), section));
        }
        sections.sort_by(|a, b| a.0.total_cmp(&b.0));
        let ends: Vec<f64> = sections.iter().skip(1).map(|(s, _)| *s).chain([road.length]).collect();
        for ((start, ix), end) in sections.into_iter().zip(ends) {
            let mut section = Section { span: [start, end.max(start)], ..Section::default() };
            for side in ["left", "center", "right"] {
                for it in document.descend(ix, &[side, "lane"]) {
                    match self.lane_id(it, "id") {
                        Some(0) => section.centre_marks = self.marks(it),
                        Some(id) if section.lane(id).is_none() => section.lanes.push(self.lane(it, id)),
                        _ => self.odd(it, format!("a lane of road {} has no id of its own: it is left out", road.id)),
                    }
                }
            }
            section.lanes.sort_by_key(|lane| std::cmp::Reverse(lane.id));
            road.sections.push(section);
        }
    }

    fn lane(&mut self, ix: Ix, id: i64) -> Lane {
        let document = self.document;
        let links = ["predecessor", "successor"].map(|side| {
            let links = document.descend(ix, &["link", side]);
            links.into_iter().filter_map(|link| self.lane_id(link, "id")).collect::<Vec<i64>>()
        });
        let mut speeds = Vec::new();
        for speed in document.children(ix, "speed") {
            speeds.push((self.number(speed, "sOffset"), self.speed(speed)));
        }
        speeds.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut access = Vec::new();
        for it in document.children(ix, "access") {
            let denied = document.get(it, "rule") == Some("deny");
            let words = document.get(it, "restriction").map(Text::from).into_iter();
            let inner = document.children(it, "restriction").map(|it| self.text(it, "type"));
            access.extend(words.chain(inner).map(|word| (!denied, word)));
        }
        let mut heights = Vec::new();
        for height in document.children(ix, "height") {
            heights.push((self.number(height, "sOffset"), self.numbers(height, ["inner", "outer"])));
        }
        let kind = self.text(ix, "type");
        let direction = document.get(ix, "direction");
        Lane {
            id,
            reversed: direction == Some("reversed"),
            both_ways: direction == Some("both") || kind == "bidirectional",
            kind,
            widths: self.cubics(document.children(ix, "width").collect::<Vec<_>>(), "sOffset"),
            borders: self.cubics(document.children(ix, "border").collect::<Vec<_>>(), "sOffset"),
            heights: LaneHeights::new(heights),
            links,
            speeds,
            marks: self.marks(ix),
            access,
        }
    }

    fn marks(&mut self, lane: Ix) -> Vec<RoadMark> {
        let document = self.document;
        let mut marks: Vec<RoadMark> = Vec::new();
        for ix in document.children(lane, "roadMark") {
            marks.push(RoadMark {
                start: self.number(ix, "sOffset"),
                kind: self.text(ix, "type"),
                color: self.text(ix, "color"),
                weight: self.text(ix, "weight"),
                lane_change: self.text(ix, "laneChange"),
            });
        }
        marks.sort_by(|a, b| a.start.total_cmp(&b.start));
        marks
    }

    fn validity(&mut self, ix: Ix) -> Validity {
        let document = self.document;
        let facing = match document.get(ix, "orientation") {
            Some("+") => 1,
            Some("-") => -1,
            _ => 0,
        };
        let ranges = document.children(ix, "validity");
        let range = |it| Some([self.lane_id(it, "fromLane")?, self.lane_id(it, "toLane")?]);
        Validity { facing, lanes: ranges.filter_map(range).collect() }
    }

    fn signal(&mut self, ix: Ix) -> Signal {
        let document = self.document;
        Signal {
            id: self.text(ix, "id"),
            line: document.line(ix),
            at: self.numbers(ix, ["s", "t"]),
            lift: self.number(ix, "zOffset"),
            turn: self.number(ix, "hOffset"),
            size: self.numbers(ix, ["width", "height"]).map(|size| size.max(0.0)),
            name: self.text(ix, "name"),
            kind: self.text(ix, "type"),
            subkind: self.text(ix, "subtype"),
            country: self.text(ix, "country"),
            dynamic: document.get(ix, "dynamic") == Some("yes"),
            value: document.get(ix, "value").and_then(|value| value.parse().ok()),
            unit: self.text(ix, "unit"),
            validity: self.validity(ix),
            dependencies: document.children(ix, "dependency").map(|it| self.text(it, "id")).collect(),
        }
    }

    fn object(&mut self, ix: Ix) -> Object {
        let document = self.document;
        let outlines = document.children(ix, "outline").collect::<Vec<_>>().into_iter();
        let outlines = outlines.chain(document.descend(ix, &["outlines", "outline"]));
        let mut rings = Vec::new();
        for outline in outlines {
            let mut corners = Vec::new();
            for corner in document.all_children(outline) {
                match document.name(corner) {
                    "cornerRoad" => corners.push(Corner::Road(self.numbers(corner, ["s", "t", "dz"]))),
                    "cornerLocal" => corners.push(Corner::Local(self.numbers(corner, ["u", "v", "z"]))),
                    _ => {}
                }
            }
            rings.push(corners);
        }
        Object {
            id: self.text(ix, "id"),
            line: document.line(ix),
            at: self.numbers(ix, ["s", "t"]),
            lift: self.number(ix, "zOffset"),
            turn: self.number(ix, "hdg"),
            size: self.numbers(ix, ["length", "width"]),
            name: self.text(ix, "name"),
            kind: self.text(ix, "type"),
            subkind: self.text(ix, "subtype"),
            validity: self.validity(ix),
            outlines: rings,
        }
    }

    fn junction(&mut self, ix: Ix) -> Junction {
        let document = self.document;
        let mut junction = Junction {
            id: self.text(ix, "id"),
            line: document.line(ix),
            kind: match document.get(ix, "type") {
                Some("direct") => JunctionKind::Direct,
                Some("virtual") => JunctionKind::Virtual,
                Some("crossing") => JunctionKind::Crossing,
                _ => JunctionKind::Common,
            },
            ..Junction::default()
        };
        for it in document.children(ix, "connection") {
            let lanes = document.children(it, "laneLink");
            let pair = |link| Some([self.lane_id(link, "from")?, self.lane_id(link, "to")?]);
            junction.connections.push(Connection {
                line: document.line(it),
                incoming: self.text(it, "incomingRoad"),
                connecting: Text::from(
                    document.get(it, "linkedRoad").or(document.get(it, "connectingRoad")).unwrap_or(""),
                ),
                contact: self.contact(it),
                lanes: lanes.filter_map(pair).collect(),
            });
        }
        junction.controllers = document.children(ix, "controller").map(|it| self.text(it, "id")).collect();
        let priorities = document.children(ix, "priority");
        junction.priorities = priorities.map(|it| ["high", "low"].map(|key| self.text(it, key))).collect();
        junction
    }

    fn controller(&mut self, ix: Ix) -> Controller {
        let signals = self.document.children(ix, "control").map(|it| self.text(it, "signalId"));
        Controller { id: self.text(ix, "id"), signals: signals.collect() }
    }
}
