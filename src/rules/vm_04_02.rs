//! vm-04-02: a traffic light hangs left to right as its driver sees it, and has the height of one.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;
use serde::Deserialize;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::Vector;
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Spot, spot};
use crate::lanelet::vocabulary::THREE_LAMPS;
use crate::lanelet::{LineString, LineStringId, RegulatoryElement};

use super::exchanged_lights::{Exchange, FRONT, edge_at, exchanges};
use super::light_places::{below_road, far_from_stop_line, is_near};

/// Referrers whose edges turn away from the first one's by more than this (cosine) do not belong to one light.
const TOGETHER: f64 = 0.707;

/// A driver sees a light from this far, metres. What obeys it lies that near, or is misplaced itself.
const SEEN_FROM: f64 = 150.0;

#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Params {
    min_height: f64,
    max_height: f64,
    off_road: f64,
    below_road: f64,
    aside: f64,
    ahead: f64,
}

pub fn check(map: &MapIndex, params: &Params) -> Vec<Finding> {
    let lights = map.map.linestrings.iter().filter(|line| line.attributes.is("type", "traffic_light"));
    let (usual, reason) = match usual_height(map, params) {
        Some(height) => (height, "as other lights have it"),
        None => (BODY, "that of a body with three lamps"),
    };
    let mut findings: Vec<Finding> = lights.clone().filter_map(|line| height(line, params, (usual, reason))).collect();
    let approaches = approaches(map);
    let outlines: Vec<Finding> = lights.clone().filter_map(|line| outline(map, line, &approaches)).collect();
    let below = |line| below_road(map, line, params.off_road, params.below_road);
    findings.extend(lights.clone().filter_map(below));
    let off_road: Vec<Finding> = lights.filter_map(|line| off_road(map, line, params.off_road)).collect();
    let reach = [params.aside, params.ahead];
    let far = map.view().elements("traffic_light").flat_map(|light| far_from_stop_line(map, light, reach));
    findings.extend(far.filter(|far| !off_road.iter().any(|other| other.subject == far.subject)));
    findings.extend(off_road);
    let exchanges = exchanges(map);
    findings.extend(exchanges.iter().map(Exchange::finding));
    // Of these it is told already, or cannot be told, which way they hang.
    let told = exchanges.iter().flat_map(|one| one.bodies.iter().copied());
    let told = told.chain(outlines.iter().filter_map(|finding| finding.subject.id().map(LineStringId))).collect();
    findings.extend(outlines);
    findings.extend(facing(map, &approaches, &told));
    findings
}

/// A light of which the first and the last point lie above each other, though others stand aside.
fn outline(map: &MapIndex, light: &LineString, approaches: &[Approach]) -> Option<Finding> {
    /// Narrower than any lamp, metres.
    const NARROW: f64 = 0.1;
    let points: Vec<_> = map.map.points.get_each(light.points.iter().copied()).map(|it| (it.id, spot(it))).collect();
    let (&(_, first), &(_, last)) = (points.first()?, points.last()?);
    let apart = |a: Spot, b: Spot| (a - b).xy().norm();
    let is_wide = points.iter().any(|&(_, place)| apart(place, first) > NARROW);
    if !is_wide || apart(first, last) >= NARROW {
        return None;
    }
    let message = format!(
        "Traffic light {} is drawn as an outline: its first and last point lie above each other, and Autoware takes these two for its \
         left and right end.",
        light.id
    );
    let finding = Finding::new("outline", Subject::LineString(light.id.0), message);
    // Its lower edge, from left to right as those see it who obey it.
    let edges = points.windows(2).map(|pair| [pair[0], pair[1]]).filter(|[a, b]| apart(a.1, b.1) > NARROW);
    let lower = edges.min_by(|a, b| (a[0].1.z + a[1].1.z).total_cmp(&(b[0].1.z + b[1].1.z)))?;
    let seen = approaches.iter().find(|approach| approach.bodies.iter().any(|body| body.id == light.id));
    let across = seen.and_then(|approach| cosine(*approach.edges.first()?, lower[1].1 - lower[0].1));
    let [from, to] = lower.map(|(id, _)| id.0);
    let ordered = match across.map(Sight::of) {
        Some(Sight::Front) => vec![from, to],
        Some(Sight::Back) => vec![to, from],
        Some(Sight::Side) | None => return Some(finding),
    };
    let edits = vec![Edit::SetVertices { way: finding.subject, points: ordered }];
    Some(finding.fixed_by("let it run along its lower edge alone, from left to right", false, edits))
}

/// The height of a body with three lamps of 30 cm, metres.
const BODY: f64 = 1.0;

/// The middle one of the heights that lights of this map have, metres.
fn usual_height(map: &MapIndex, params: &Params) -> Option<f64> {
    let lights = map.map.linestrings.iter().filter(|line| line.attributes.is("type", "traffic_light"));
    let said = lights.filter_map(|line| crate::lanelet::number::number(line.attributes.get("height")?));
    let mut known: Vec<f64> = said.filter(|height| (params.min_height..=params.max_height).contains(height)).collect();
    known.sort_by(f64::total_cmp);
    known.get(known.len() / 2).copied()
}

fn height(line: &LineString, params: &Params, (usual, reason): (f64, &str)) -> Option<Finding> {
    let (id, subject) = (line.id, Subject::LineString(line.id.0));
    let Some(said) = line.attributes.get("height") else {
        let finding = Finding::new("height-missing", subject, format!("Traffic light {id} has no height."));
        let edits = vec![Edit::SetTag { on: subject, key: "height".into(), value: usual.to_string().into() }];
        return Some(finding.fixed_by(format!("set height={usual}, {reason}"), false, edits));
    };
    // What is no number is read as one that cannot be.
    let height = crate::lanelet::number::leading_number(said).unwrap_or(-1.0);
    let (low, high) = (params.min_height, params.max_height);
    (height < low || height > high).then(|| {
        let message = format!("height={said} of traffic light {id} is outside {low} to {high} m.");
        let limit = if height < low { low } else { high };
        let finding = Finding::new("height-range", subject, message).measured(height, limit, "m");
        let metres = height / 100.0;
        if metres < low || metres > high {
            return finding;
        }
        let value = metres.to_string();
        let edits = vec![Edit::SetTag { on: subject, key: "height".into(), value: value.as_str().into() }];
        finding.fixed_by(format!("set height={value}: it stands there in centimetres"), false, edits)
    })
}

/// A light for vehicles that stands farther than this, metres, from every lanelet that they may drive on, though one that obeys it lies
/// in the same part of the map.
fn off_road(map: &MapIndex, light: &LineString, most: f64) -> Option<Finding> {
    if !light.attributes.is("subtype", THREE_LAMPS) {
        return None;
    }
    let view = map.view();
    let places = view.places(light);
    let middle = nalgebra::center(places.first()?, places.last()?);
    let is_near = |at: usize| is_near(map, at, middle, most);
    let around = |reach: f64| {
        let reach = Vector::repeat(reach);
        map.lanes_near(middle - reach, middle + reach).into_iter().filter(|&at| map.lanes[at].vehicle)
    };
    if around(most).any(is_near) {
        return None;
    }
    let names = |element: &RegulatoryElement| element.linestrings("refers").any(|id| id == light.id);
    let obeys = |at: usize| map.elements(map.lanes[at].id, "traffic_light").any(names);
    let id = light.id;
    let message = format!("Traffic light {id} stands more than {most} m from every lanelet for vehicles.");
    around(SEEN_FROM).any(obeys).then(|| Finding::new("off-road", Subject::LineString(id.0), message))
}

/// Which side of a light somebody sees.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    Front,
    Back,
    Side,
}

impl Sight {
    fn of(cosine: f64) -> Self {
        match cosine {
            _ if cosine > FRONT => Self::Front,
            _ if cosine < -FRONT => Self::Back,
            _ => Self::Side,
        }
    }
}

/// A traffic light element with what is held against each other.
struct Approach<'m> {
    element: &'m RegulatoryElement,
    /// The edges, left to right, at which the lanelets that obey it come to the stop line.
    edges: Vec<Vector3<f64>>,
    /// Its lights for vehicles.
    bodies: Vec<&'m LineString>,
}

/// Those of a map with a stop line and lanelets.
fn approaches<'m>(map: &'m MapIndex) -> Vec<Approach<'m>> {
    let view = map.view();
    let of_light = |element: &'m RegulatoryElement| {
        let line = view.lines(element, "ref_line").next().map(|line| view.points(line)).unwrap_or_default();
        let (a, b) = line.first().zip(line.last())?;
        let obey = view.referrers(element.id).iter().map(|&at| &view.lanelets[at]);
        let edges: Vec<_> = obey.filter_map(|seen| edge_at(map, seen, [spot(a), spot(b)])).collect();
        let bodies = view.lines(element, "refers").filter(|line| line.attributes.is("subtype", THREE_LAMPS));
        (!edges.is_empty()).then(|| Approach { element, edges, bodies: bodies.collect() })
    };
    view.elements("traffic_light").filter_map(of_light).collect()
}

/// Which way the lights hang, seen from where the lanelets that obey them come to the stop line; of those in `told` something else is said.
fn facing(map: &MapIndex, approaches: &[Approach], told: &BTreeSet<LineStringId>) -> Vec<Finding> {
    let view = map.view();
    let mut findings = Vec::new();
    let mut seen_from: BTreeMap<LineStringId, Vec<Sight>> = BTreeMap::new();
    for Approach { element: light, edges, bodies } in approaches {
        let Some((&first, others)) = edges.split_first() else { continue };
        let astray =
            others.iter().filter(|other| cosine(first, **other).is_some_and(|cosine| cosine < TOGETHER)).count();
        for body in bodies {
            let id = body.id;
            for _ in 0..astray {
                let message =
                    format!("Traffic light {id} of {} rules lanelets that start in different directions.", light.id);
                findings.push(
                    Finding::new("directions", Subject::LineString(id.0), message)
                        .with(Subject::RegulatoryElement(light.id.0), "element"),
                );
            }
            let points = view.points(body);
            let along = points.first().zip(points.last()).map(|(a, b)| spot(b) - spot(a));
            let Some(cosine) = along.and_then(|along| cosine(first, along)) else { continue };
            seen_from.entry(id).or_default().push(Sight::of(cosine));
        }
    }
    for (id, seen) in seen_from.into_iter().filter(|(id, _)| !told.contains(id)) {
        let subject = Subject::LineString(id.0);
        let all = |sight: Sight| seen.iter().all(|one| *one == sight);
        if all(Sight::Front) {
            continue;
        }
        findings.push(if all(Sight::Back) {
            let message = format!("Traffic light {id} hangs right to left for those who obey it.");
            let edits = vec![Edit::ReverseWay { way: subject }];
            Finding::new("reversed", subject, message).fixed_by("turn the way around", false, edits)
        } else if seen.contains(&Sight::Front) {
            let message = format!("Traffic light {id} shows its front to some who obey it and not to others.");
            Finding::new("both-ways", subject, message)
        } else {
            let message = format!("Traffic light {id} stands across the approach of those who obey it.");
            Finding::new("sideways", subject, message)
        });
    }
    findings
}

fn cosine(a: Vector3<f64>, b: Vector3<f64>) -> Option<f64> {
    Some(a.dot(&b) / (a.norm() * b.norm())).filter(|cosine| cosine.is_finite())
}
