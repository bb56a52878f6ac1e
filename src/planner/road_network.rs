//! The lanelets of a map as Autoware's routing graph for vehicles connects them.

use super::params::Params;
use crate::geometry::polygon::contains;
use crate::geometry::{Point, Polyline, Vector};
use crate::lanelet::index::routing_graph::{Graph, Rules};
use crate::lanelet::index::view::{Seen, View};
use crate::lanelet::index::{center_line, extent};
use crate::lanelet::{LaneletId, LaneletMap, RegulatoryElement, TurnDirection};

/// A map with its routing graph for vehicles. Lanelets go by their position in [`View::lanelets`].
#[derive(Debug)]
pub struct RoadNetwork<'v, 'm> {
    /// The lanelets.
    pub view: &'v View<'m>,
    /// How they are connected.
    pub graph: Graph<'v, 'm>,
}

/// Why there is no route.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRoute {
    /// No lanelet has the id.
    #[error("the map has no lanelet {0}")]
    NoSuchLanelet(i64),
    /// No vehicle may pass it.
    #[error("lanelet {0} is none for vehicles")]
    NotForVehicles(i64),
    /// Nothing leads there without changing lanes.
    #[error("no way leads from lanelet {0} to lanelet {1} without changing lanes")]
    NotConnected(i64, i64),
}

/// Slack, metres: lanelets that overlap another reach seldom farther.
const SLACK: f64 = 100.0;

/// So much of a map as decides what the planner will do on one lanelet: all that overlaps it, and as far from there as the modules look.
/// `None` if no lanelet has the id.
pub fn surroundings<'m>(map: &'m LaneletMap, lanelet: LaneletId, params: &Params) -> Option<View<'m>> {
    let own = extent(&map.outline(map.lanelets.get(lanelet)?));
    let grown = |[low, high]: [Point; 2], by: f64| [low - Vector::repeat(by), high + Vector::repeat(by)];
    let mut reached = grown(own, SLACK);
    loop {
        let view = View::between(map, grown(reached, params.looks_back()));
        let overlapping = view.near(own, 0.0).into_iter().map(|at| view.lanelets[at].extent);
        let needed = overlapping.fold(reached, |[low, high], [a, b]| [low.inf(&a), high.sup(&b)]);
        if needed == reached {
            return Some(view);
        }
        reached = needed;
    }
}

impl<'v, 'm> RoadNetwork<'v, 'm> {
    /// Connects the lanelets of a map.
    pub fn new(view: &'v View<'m>) -> Self {
        Self { view, graph: Graph::new(view, Rules::Car) }
    }

    /// The lanelet of an id, if vehicles may pass it.
    ///
    /// # Errors
    ///
    /// If there is none, or it is none for vehicles.
    pub fn lanelet(&self, id: i64) -> Result<usize, NoRoute> {
        let at = self.view.position(LaneletId(id)).ok_or(NoRoute::NoSuchLanelet(id))?;
        if self.graph.passes(at) { Ok(at) } else { Err(NoRoute::NotForVehicles(id)) }
    }

    /// The lanelets for vehicles that lie at a place, in file order.
    pub fn at(&self, place: Point) -> Vec<usize> {
        let near = self.view.near([place, place], 0.0).into_iter();
        near.filter(|&at| self.graph.passes(at) && contains(&self.seen(at).outline, place)).collect()
    }

    /// The shortest way between two lanelets without changing lanes, both included.
    ///
    /// # Errors
    ///
    /// If there is no such way.
    pub fn route(&self, from: i64, to: i64) -> Result<Vec<usize>, NoRoute> {
        let path = self.graph.path(self.lanelet(from)?, self.lanelet(to)?);
        path.ok_or(NoRoute::NotConnected(from, to))
    }

    pub(super) fn seen(&self, at: usize) -> &'v Seen<'m> {
        &self.view.lanelets[at]
    }

    pub(super) fn id(&self, at: usize) -> LaneletId {
        self.seen(at).id()
    }

    /// Its `turn_direction`, if it is one of the three words that modules know.
    pub fn turn(&self, at: usize) -> Option<TurnDirection> {
        TurnDirection::parse(self.seen(at).tag("turn_direction")?)
    }

    /// The line that Autoware drives along: the map's own, else midway between the bounds.
    pub(super) fn center(&self, at: usize) -> Option<Polyline> {
        let seen = self.seen(at);
        let own = seen.lanelet.centerline.and_then(|id| self.view.map.linestrings.get(id));
        if let Some(line) = own.and_then(|line| Polyline::new(self.view.places(line))) {
            return Some(line);
        }
        let places = |points: &[&crate::lanelet::Point]| points.iter().map(|p| p.position).collect::<Vec<_>>();
        center_line(&places(&seen.left), &places(&seen.right))
    }

    /// Its length along that line, metres.
    pub(super) fn length(&self, at: usize) -> f64 {
        self.center(at).map_or(0.0, |line| line.length())
    }

    /// The elements of a subtype that a lanelet refers to.
    pub(super) fn elements<'a>(
        &'a self,
        at: usize,
        subtype: &'a str,
    ) -> impl Iterator<Item = &'m RegulatoryElement> + 'a {
        self.view.elements_of(self.seen(at), subtype)
    }

    /// The traffic light that decides for the modules: the first of the lanelet, if it has a stop line.
    pub(super) fn light(&self, at: usize) -> Option<&'m RegulatoryElement> {
        self.elements(at, "traffic_light").next().filter(|light| light.linestrings("ref_line").next().is_some())
    }

    /// The lanelet that has the outer bound of another as its inner one, and that counts.
    pub(super) fn beside(&self, at: usize, on_left: bool, counts: impl Fn(usize) -> bool) -> Option<usize> {
        let lanelet = self.seen(at).lanelet;
        let own = if on_left { lanelet.left } else { lanelet.right };
        let near = self.view.near(self.seen(at).extent, 0.1);
        near.into_iter().find(|&other| {
            let beside = self.seen(other).lanelet;
            other != at && own == (if on_left { beside.right } else { beside.left }) && counts(other)
        })
    }

    /// The lanelet before another that a vehicle most likely comes from: no turn before a turn, then by id.
    pub(super) fn likely_previous(&self, at: usize) -> Option<usize> {
        self.likely(self.graph.previous(at))
    }

    /// The lanelet that a vehicle most likely goes on to.
    pub(super) fn likely_following(&self, at: usize) -> Option<usize> {
        self.likely(self.graph.following(at))
    }

    fn likely(&self, among: Vec<usize>) -> Option<usize> {
        let turns = |at: usize| !matches!(self.turn(at), None | Some(TurnDirection::Straight));
        among.into_iter().min_by_key(|&at| (turns(at), self.id(at)))
    }
}
