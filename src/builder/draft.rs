//! Lanes and the ways through the intersections, drawn until no way runs over the end of a lane.
//!
//! Where each road is cut follows from the outlines, but how far a turn swings out shows only when it is drawn. A road
//! whose cut lies under a turn is cut back behind it, and everything is drawn again: lanes end where the intersection
//! begins, and their end nodes lie on its outline.

use rayon::prelude::*;

use crate::geometry::{Point, Polyline};

use super::area::{AreaOutline, area_outline};
use super::assembly::{Assembly, Part};
use super::conflict::{Conflicts, conflicts};
use super::connection::{ConnectionLines, ROAD_LEFT, carriageway, connection_lines, from_cut, side};
use super::join::Joins;
use super::lanes::{Arm, Lanes, lanes};
use super::movement::{Movements, movements};
use super::paths::{Drawn, Paint, intersection_key, paths};
use super::restricted::Restricted;
use super::road_network::{Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork};
use super::seam::seams;

/// Each round settles what the round before moved; ways grow by less than they give.
const ROUNDS: usize = 4;
/// Where the outline shows that more is needed, so many rounds more,
const ROUNDS_OUTLINED: usize = 8;
/// by so many metres each.
const CLEARING: f64 = 1.0;
/// A way that reaches over a cut by less than this, metres, only touches it.
const TOUCH: f64 = 0.05;
/// A cut lies this far, metres, behind the way that would run over it.
const CLEAR: f64 = 0.2;
/// No road is cut back further than this, metres, beyond its outline for the sake of a way beside it: what reaches
/// further runs along the road and not over its end.
const BACK_MOST: f64 = 12.0;
/// Outlines are looked at in steps of this length, metres.
const STEP: f64 = 0.5;

/// What is drawn of a map before it is known what rules its intersections.
pub struct Draft {
    /// Where roads meet face to face.
    pub joins: Joins,
    /// Where roads are cut.
    pub lines: ConnectionLines,
    /// Lanes, as primitives.
    pub assembly: Assembly<'static>,
    /// Lanes and arms.
    pub lanes: Lanes,
    /// Per intersection which lane leads to which, and the ways; `None` where roads meet face to face or end.
    pub ways: Vec<Option<Ways>>,
}

/// The ways through one intersection.
pub struct Ways {
    /// Which lane leads to which.
    pub plan: Movements,
    /// The ways as they lie.
    pub drawn: Drawn,
    /// Which of them get into each other's way; `None` before they are outlined.
    pub conflicts: Option<Conflicts>,
    /// The outline around them, where some do and it is no roundabout.
    pub area: Option<AreaOutline>,
    /// Their primitives, over those of the lanes.
    pub part: Part,
    /// Whether they stood in the round before: no way runs over a cut that did not then.
    stood: bool,
}

impl Ways {
    /// Draws the ways of an intersection over what stands.
    pub fn draw(
        network: &RoadNetwork,
        restricted: &Restricted,
        lanes: &Lanes,
        intersection: &Intersection,
        below: &Assembly<'_>,
    ) -> Self {
        let plan = movements(network.side, restricted, lanes, intersection);
        let paint = if intersection.arms.len() == 2 { Paint::AsBefore } else { Paint::None };
        let mut assembly = Assembly::over(below);
        assembly.stand_on(lanes.ground_of(intersection, below));
        let drawn = paths(&mut assembly, network, lanes, intersection, &plan.all, paint);
        Self { plan, drawn, conflicts: None, area: None, part: assembly.into_part(), stood: false }
    }

    /// Draws the outline around ways that were drawn over `below`.
    #[must_use]
    pub fn outlined(
        self,
        network: &RoadNetwork,
        lanes: &Lanes,
        intersection: &Intersection,
        below: &Assembly<'_>,
    ) -> Self {
        if self.conflicts.is_some() {
            return self;
        }
        let Drawn { paths, bounds, .. } = &self.drawn;
        let conflicts = conflicts(paths);
        let roundabout = intersection.arms.iter().any(|at| network.road(at.road).roundabout);
        if roundabout || conflicts.real.iter().all(Vec::is_empty) {
            return Self { conflicts: Some(conflicts), ..self };
        }
        let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
        let mut assembly = Assembly::resumed(below, self.part);
        assembly.stand_on(lanes.ground_of(intersection, below));
        let key = intersection_key("intersection area", intersection);
        let area = Some(area_outline(&mut assembly, key, lanes, &arms, bounds, paths));
        Self { conflicts: Some(conflicts), area, part: assembly.into_part(), ..self }
    }
}

/// Whether an arm ends on the same nodes at the same places.
fn same_cut(a: &Arm, of_a: &Assembly, b: &Arm, of_b: &Assembly) -> bool {
    let places = || a.cut.iter().all(|&node| of_a.position(node) == of_b.position(node));
    a.inward == b.inward && a.cut == b.cut && places()
}

impl Draft {
    /// Draws until no way runs over the end of a lane, as far as the roads have room. `kept` are the stations between
    /// which the outlines leave each road.
    pub fn new(network: &RoadNetwork, kept: &[[f64; 2]], restricted: &Restricted) -> Self {
        let mut back = vec![[0.0; 2]; network.roads.len()];
        let mut draft = Self::drawn(network, kept, restricted, &back, None);
        for _ in 0..ROUNDS {
            if !draft.cut_back(network, &mut back) {
                break;
            }
            draft = Self::drawn(network, kept, restricted, &back, Some(draft));
        }
        draft = draft.outlined(network);
        for _ in 0..ROUNDS_OUTLINED {
            if !draft.cut_clear(network, &mut back) {
                break;
            }
            draft = Self::drawn(network, kept, restricted, &back, Some(draft)).outlined(network);
        }
        draft
    }

    /// Draws everything; of what was drawn `before`, what would come out the same.
    fn drawn(
        network: &RoadNetwork,
        kept: &[[f64; 2]],
        restricted: &Restricted,
        back: &[[f64; 2]],
        before: Option<Self>,
    ) -> Self {
        let mut joins = Joins::find(network);
        let lines = connection_lines(network, kept, |ix| joins.joined(ix), back);
        joins.beside(seams(network, &lines));
        let mut assembly = Assembly::default();
        let lanes = lanes(&mut assembly, network, &lines, &mut joins);
        let (mut ways, before) = match before {
            Some(Self { ways, lanes, assembly, .. }) => (ways, Some((lanes, assembly))),
            None => (Vec::new(), None),
        };
        ways.resize_with(network.intersections.len(), || None);
        let stays = |at: &RoadEnd| {
            let same = |(old, places): &(Lanes, Assembly)| same_cut(old.arm(*at), places, lanes.arm(*at), &assembly);
            before.as_ref().is_some_and(same)
        };
        let ways = ways
            .into_par_iter()
            .enumerate()
            .map(|(i, old)| {
                let intersection = &network.intersections[i];
                let passed = intersection.arms.len() >= 2 && !joins.joined(IntersectionIx(i as u32));
                let old = old.filter(|_| intersection.arms.iter().all(stays));
                passed.then(|| match old {
                    Some(ways) => Ways { stood: true, ..ways },
                    None => Ways::draw(network, restricted, &lanes, intersection, &assembly),
                })
            })
            .collect();
        Self { joins, lines, assembly, lanes, ways }
    }

    /// Outlines the ways of every intersection.
    fn outlined(mut self, network: &RoadNetwork) -> Self {
        let drawn = std::mem::take(&mut self.ways).into_par_iter().zip(&network.intersections);
        let Self { assembly, lanes, .. } = &self;
        let ways = drawn.map(|(ways, at)| Some(ways?.outlined(network, lanes, at, assembly))).collect();
        Self { ways, ..self }
    }

    /// The ends of roads whose lanes do not end on the outline around the ways there: some way runs over them.
    pub fn overrun<'a>(&'a self, network: &'a RoadNetwork) -> impl Iterator<Item = RoadEnd> + 'a {
        network.intersections.iter().zip(&self.ways).flat_map(|(at, ways)| {
            let area = ways.as_ref().and_then(|ways| ways.area.as_ref());
            area.into_iter().flat_map(|area| area.overrun.iter().map(|&arm| at.arms[arm]))
        })
    }

    /// What is left of a road between its cuts, metres.
    pub fn left(&self, road: RoadIx) -> f64 {
        let [from, to] = self.lines.kept[road.0 as usize];
        to - from
    }

    /// Raises the distances in `back` for the ends of roads that ways run over; `false` if no road has room.
    fn cut_clear(&self, network: &RoadNetwork, back: &mut [[f64; 2]]) -> bool {
        let mut raised = false;
        for at in self.overrun(network) {
            let (road, side) = (at.road.0 as usize, side(at.end));
            if self.left(at.road) >= ROAD_LEFT + CLEARING {
                let now = from_cut(self.lines.least[road], at.end, self.lines.kept[road][side]);
                back[road][side] = now + CLEARING;
                raised = true;
            }
        }
        raised
    }

    /// Raises the distances in `back` so that every cut lies behind the ways that run over it; `false` if all do.
    fn cut_back(&self, network: &RoadNetwork, back: &mut [[f64; 2]]) -> bool {
        let reached = |(intersection, ways): (&Intersection, &Option<Ways>)| {
            let ways = ways.as_ref().filter(|ways| intersection.arms.len() > 2 && !ways.stood)?;
            let depth = |&at: &RoadEnd| (at, self.depth(network, intersection, at, &ways.drawn));
            Some(intersection.arms.iter().map(depth).collect::<Vec<_>>())
        };
        let reached: Vec<_> = network.intersections.par_iter().zip(&self.ways).filter_map(reached).collect();
        let mut raised = false;
        for (at, depth) in reached.into_iter().flatten() {
            let (road, side) = (at.road.0 as usize, side(at.end));
            let now = from_cut(self.lines.least[road], at.end, self.lines.kept[road][side]);
            let wanted = (now + depth + CLEAR).min(BACK_MOST);
            if depth > TOUCH && wanted > back[road][side] + TOUCH {
                back[road][side] = wanted;
                raised = true;
            }
        }
        raised
    }

    /// How far behind the cut of a road the ways of its intersection reach.
    fn depth(&self, network: &RoadNetwork, intersection: &Intersection, at: RoadEnd, drawn: &Drawn) -> f64 {
        let road = network.road(at.road);
        let kept = self.lines.kept[at.road.0 as usize];
        let cut = self.lanes.arm(at);
        let places: Vec<Point> = cut.cut.iter().map(|&id| self.assembly.position(id)).collect();
        let (Some(&right), Some(&left)) = (places.first(), places.last()) else { return 0.0 };
        let reach = (left - right).norm() + BACK_MOST;
        let (first, last) = carriageway(&road.section);
        let (left, right) = (road.section.edge(first), road.section.edge(last));
        // What lies beside the part in question lies within this of the cut's end.
        let near = BACK_MOST + 2.0 * left.abs().max(right.abs()) + TOUCH;
        let beyond = |p: &Point| {
            if (p - places[0]).norm() > near {
                return 0.0;
            }
            let foot = road.line.project(*p);
            let level = ((p - foot.point).norm() - foot.offset.abs()).abs() < TOUCH;
            let within = foot.offset < left - TOUCH && foot.offset > right + TOUCH;
            let depth = from_cut(kept, at.end, foot.station);
            if level && within && depth < BACK_MOST { depth } else { 0.0 }
        };
        let own = |arm: usize| intersection.arms[arm] == at;
        drawn
            .paths
            .iter()
            // What begins or ends here lies on the cut; it reaches behind it only where it turns back.
            .filter(|path| !(own(path.movement.from) || own(path.movement.to)) || path.turn.abs() > 90.0)
            .filter(|path| path.outline.iter().any(|p| (p - places[0]).norm() < reach))
            .filter_map(|path| Polyline::new(path.outline.iter().chain(path.outline.first()).copied()))
            .flat_map(|ring| ring.resampled(STEP).points().to_vec())
            .map(|p| beyond(&p))
            .fold(0.0, f64::max)
    }
}
