//! Traffic lights of two approaches that are exchanged: each element has the bodies of the other, or the lanelets of each approach
//! refer to the element of the other.

use std::collections::BTreeSet;

use nalgebra::Vector3;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, Polyline, Vector, segment_crossing};
use crate::lanelet::Point as PlacedPoint;
use crate::lanelet::index::MapIndex;
use crate::lanelet::index::view::{Seen, Spot, View, spot};
use crate::lanelet::vocabulary::THREE_LAMPS;
use crate::lanelet::{LaneletId, LineStringId, Member, RegulatoryElement, RegulatoryElementId, Target};

use super::stop_line_crossings::lanes_that_stop;

/// Who obeys a light looks at its front within this angle: its cosine, 60 degrees.
pub const FRONT: f64 = 0.5;
/// A light is the one of an approach if it faces it within this angle: its cosine, 45 degrees.
const FACES: f64 = 0.707;
/// A light stands no farther (m) beyond the stop line of its approach than this ...
const AHEAD: f64 = 60.0;
/// ... no farther (m) before it ...
const BACK: f64 = 2.0;
/// ... and no farther (m) to the side.
const BESIDE: f64 = 25.0;

/// Roles of members that belong to the bodies of a light.
const OF_BODIES: [&str; 2] = ["refers", "light_bulbs"];

/// Two elements that are exchanged.
pub struct Exchange {
    /// Both, the lower id first.
    pub elements: [RegulatoryElementId; 2],
    /// The bodies of both.
    pub bodies: BTreeSet<LineStringId>,
    what: &'static str,
    edits: Vec<Edit>,
}

impl Exchange {
    /// As a finding.
    pub fn finding(&self) -> Finding {
        let [one, other] = self.elements;
        let message = match self.what {
            "lights" => format!("traffic_light {one} and {other} have the lights of each other's approach."),
            _ => format!("Lanelets refer to traffic_light {one} and {other} where they obey the other one."),
        };
        let finding = Finding::new("exchanged", Subject::RegulatoryElement(one.0), message);
        let finding = finding.with(Subject::RegulatoryElement(other.0), "the other element");
        let lights = self.bodies.iter().map(|light| Subject::LineString(light.0));
        let finding = lights.fold(finding, |finding, light| finding.with(light, "light"));
        let title = match self.what {
            "lights" => "exchange the lights of both",
            _ => "exchange the references of the lanelets",
        };
        finding.fixed_by(title, false, self.edits.clone())
    }
}

/// A stop line whose middle is this close (m) to an end of a lanelet lies at that end.
const AT_END: f64 = 5.0;

/// From left to right across a lanelet as its driver comes to a stop line: the end at which the line lies; where it lies at none, but crosses the
/// lanelet, there, since a long one may turn far behind it; else the end that is nearer.
pub fn edge_at(map: &MapIndex, seen: &Seen, line: [Spot; 2]) -> Option<Vector3<f64>> {
    edge_of_line(map, seen, line).or_else(|| {
        let [a, b] = nearer_end(seen, line)?;
        Some(spot(b) - spot(a))
    })
}

/// How far the middle of a line is from the middle of an edge, metres.
fn far([a, b]: &[&PlacedPoint; 2], line: [Spot; 2]) -> f64 {
    (nalgebra::center(&spot(a), &spot(b)) - nalgebra::center(&line[0], &line[1])).norm()
}

fn nearer_end<'m>(seen: &Seen<'m>, line: [Spot; 2]) -> Option<[&'m PlacedPoint; 2]> {
    let [start, end] = seen.ends()?;
    Some(if far(&end, line) < far(&start, line) { end } else { start })
}

/// As [`edge_at`]; `None` where the line lies at no end and does not cross the lanelet.
fn edge_of_line(map: &MapIndex, seen: &Seen, line: [Spot; 2]) -> Option<Vector3<f64>> {
    let [a, b] = nearer_end(seen, line)?;
    if far(&[a, b], line) <= AT_END {
        return Some(spot(b) - spot(a));
    }
    let [from, to] = line.map(|spot| Point::new(spot.x, spot.y));
    let center = map.lane_of(seen.id()).and_then(|lane| lane.center.as_ref());
    let mut steps = center.into_iter().flat_map(Polyline::segments);
    let crossed = steps.find(|&(c, d)| segment_crossing(from, to, c, d).is_some());
    crossed.map(|(c, d)| Vector3::new(d.y - c.y, c.x - d.x, 0.0))
}

/// An element with where it is obeyed and where its lights look.
struct Light<'m> {
    element: &'m RegulatoryElement,
    /// The stop line's middle, and the edge of the lanelets that refer to the element, from left to right.
    middle: Point,
    edge: Vector,
    /// Each body with its middle and its direction from left to right.
    bodies: Vec<(LineStringId, Point, Vector)>,
    referrers: BTreeSet<LaneletId>,
    /// The lanelets at its stop lines that would refer to it.
    at_line: BTreeSet<LaneletId>,
}

fn cosine(a: Vector, b: Vector) -> f64 {
    a.dot(&b) / (a.norm() * b.norm())
}

impl<'m> Light<'m> {
    fn of(map: &MapIndex, view: &View<'m>, element: &'m RegulatoryElement) -> Option<Self> {
        let flat = |spot: Spot| Point::new(spot.x, spot.y);
        let line = view.points(view.lines(element, "ref_line").next()?);
        let middle = nalgebra::center(&flat(spot(line.first()?)), &flat(spot(line.last()?)));
        let seen = view.referrers(element.id).iter().map(|&at| &view.lanelets[at]);
        let ends = [spot(line.first()?), spot(line.last()?)];
        // The line of another approach lies at none of them: who obeys the light comes to their starts.
        let starts = || {
            let [[a, b], _] = seen.clone().find_map(Seen::ends)?;
            Some(spot(b) - spot(a))
        };
        let edge = seen.clone().find_map(|seen| edge_of_line(map, seen, ends)).or_else(starts)?.xy();
        let bodies = view.lines(element, "refers").filter(|line| line.attributes.is("subtype", THREE_LAMPS));
        let bodies = bodies.filter_map(|body| {
            let points = view.points(body);
            let [a, b] = [flat(spot(points.first()?)), flat(spot(points.last()?))];
            Some((body.id, nalgebra::center(&a, &b), b - a))
        });
        let bodies: Vec<_> = bodies.collect();
        let at_line = element.linestrings("ref_line").flat_map(|line| lanes_that_stop(map, line));
        let light = Self {
            element,
            middle,
            edge,
            bodies,
            referrers: seen.map(|seen| seen.id()).collect(),
            at_line: at_line.map(|lane| map.lanes[lane].id).collect(),
        };
        (!light.bodies.is_empty()).then_some(light)
    }

    /// Whether none of its lights shows its front to those who refer to it.
    fn is_seen_by_nobody(&self) -> bool {
        self.bodies.iter().all(|(_, _, along)| cosine(self.edge, *along) < FRONT)
    }

    /// Whether all its lights stand across the approach.
    fn is_sideways(&self) -> bool {
        self.bodies.iter().all(|(_, _, along)| cosine(self.edge, *along).abs() < FRONT)
    }

    /// Whether the lights of another element face the approach of this one.
    fn is_faced_by(&self, other: &Self) -> bool {
        let rightward = self.edge.normalize();
        let forward = Vector::new(-rightward.y, rightward.x);
        other.bodies.iter().all(|(_, at, along)| {
            let from = at - self.middle;
            cosine(self.edge, *along) > FACES
                && (-BACK..=AHEAD).contains(&from.dot(&forward))
                && from.dot(&rightward).abs() <= BESIDE
        })
    }

    /// Whether its stop line lies before the lanelets that refer to another element, and none of them refers to it.
    fn stops_those_of(&self, other: &Self) -> bool {
        !self.at_line.is_empty()
            && self.at_line.is_disjoint(&self.referrers)
            && self.at_line.iter().all(|lanelet| other.referrers.contains(lanelet))
    }
}

/// The elements of a map that are exchanged in pairs. What could be exchanged with several others is left out.
pub fn exchanges(map: &MapIndex) -> Vec<Exchange> {
    let view = map.view();
    let lights: Vec<Light> = view.elements("traffic_light").filter_map(|one| Light::of(map, view, one)).collect();
    let wrong: Vec<&Light> = lights.iter().filter(|light| light.is_seen_by_nobody()).collect();
    let mut pairs: Vec<(usize, usize, Exchange)> = Vec::new();
    for (x, one) in wrong.iter().enumerate() {
        for (y, other) in wrong.iter().enumerate().skip(x + 1) {
            let references = one.stops_those_of(other) && other.stops_those_of(one);
            let sideways = one.is_sideways() && other.is_sideways();
            let lights = sideways && one.is_faced_by(other) && other.is_faced_by(one);
            if references || lights {
                pairs.push((x, y, exchange([one, other], references)));
            }
        }
    }
    let times = |at: usize| pairs.iter().filter(|(x, y, _)| *x == at || *y == at).count();
    let is_sole: Vec<bool> = pairs.iter().map(|(x, y, _)| times(*x) == 1 && times(*y) == 1).collect();
    pairs.into_iter().zip(is_sole).filter(|(_, is_sole)| *is_sole).map(|((.., one), _)| one).collect()
}

fn exchange([one, other]: [&Light; 2], references: bool) -> Exchange {
    let edits = match references {
        true => [referring(one, other), referring(other, one)].concat(),
        false => [with_bodies(one.element, other.element), with_bodies(other.element, one.element)].concat(),
    };
    let mut elements = [one.element.id, other.element.id];
    elements.sort_unstable();
    let bodies = one.bodies.iter().chain(&other.bodies).map(|(id, ..)| *id).collect();
    Exchange { elements, bodies, what: if references { "references" } else { "lights" }, edits }
}

/// The edits that let the lanelets of one element refer to the other.
fn referring(one: &Light, other: &Light) -> Vec<Edit> {
    let [old, new] = [one, other].map(|light| Subject::RegulatoryElement(light.element.id.0));
    let role = || "regulatory_element".into();
    let edits = one.referrers.iter().flat_map(|lanelet| {
        let on = Subject::Lanelet(lanelet.0);
        [Edit::RemoveMember { on, role: role(), member: old }, Edit::AddMember { on, role: role(), member: new }]
    });
    edits.collect()
}

/// The edits that give an element the bodies and bulbs of another in place of its own.
fn with_bodies(element: &RegulatoryElement, other: &RegulatoryElement) -> Vec<Edit> {
    let on = Subject::RegulatoryElement(element.id.0);
    let bodies = |element: &RegulatoryElement| -> Vec<Member> {
        let is_body = |member: &&Member| OF_BODIES.contains(&member.role.as_str());
        element.members.iter().filter(is_body).cloned().collect()
    };
    let subject = |target: Target| match target {
        Target::Point(id) => Subject::Point(id.0),
        Target::LineString(id) => Subject::LineString(id.0),
        Target::Polygon(id) => Subject::Polygon(id.0),
        Target::Lanelet(id) => Subject::Lanelet(id.0),
    };
    let removed =
        bodies(element).into_iter().map(|one| Edit::RemoveMember { on, role: one.role, member: subject(one.target) });
    let added =
        bodies(other).into_iter().map(|one| Edit::AddMember { on, role: one.role, member: subject(one.target) });
    removed.chain(added).collect()
}
