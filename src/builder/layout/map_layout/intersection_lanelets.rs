//! The turning lanelets of one intersection, drawn between its lanes, and the outline around them.

use crate::builder::intersection::area_outline::area_ring::covers;
use crate::builder::intersection::area_outline::{AreaOutline, area_outline};
use crate::builder::intersection::bicycle_lanelets::{
    BicycleLaneEnds, BicycleMovements, BicycleTurns, has_bicycle_lanes,
};
use crate::builder::intersection::conflict::{Conflicts, conflicts, strip_indices};
use crate::builder::intersection::lane_reassignment::reassignments;
use crate::builder::intersection::movement::{joined_arms, movements, movements_instead};
use crate::builder::intersection::movement_types::{Movement, Movements};
use crate::builder::intersection::ring_movements::RingMovements;
use crate::builder::intersection::turn_direction::turn_direction;
use crate::builder::intersection::turning_lanelets::{
    DrawnMovements, TurningLanelet, intersection_key, turning_lanelets,
};
use crate::builder::intersection::undrivable::{UndrivableMovements, undrivable};
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::map_builder::{MapBuilder, MapPart};
use crate::builder::network::approach_control::{Control, sign_at};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::{Intersection, RoadEnd, RoadNetwork, WholeRoundabouts};
use crate::geometry::strip_index::StripIndex;
use crate::geometry::{Point, Polyline, angle_between, polygon};
use crate::lanelet::TurnDirection;
use crate::lanelet::index::JOINING;
use crate::settings::BicycleLanes;

/// Lanelets that share less than this, square metres, only touch.
const TOUCHING: f64 = 0.25;

/// The turning lanelets of one intersection, for vehicles and for bicycles.
pub struct IntersectionLanelets {
    /// Which lane leads to which.
    pub plan: Movements,
    /// The lanelets for vehicles.
    pub drawn: DrawnMovements,
    /// Which of them conflict; `None` before the outline is drawn.
    pub conflicts: Option<Conflicts>,
    /// Bicycle lanes that lead in and out, and the lanelets between them.
    pub bicycles: BicycleMovements,
    /// The outline around all lanelets, if the intersection needs an area.
    pub area: Option<AreaOutline>,
    /// The primitives of the lanelets, which use those of the lanes.
    pub part: MapPart,
    /// Whether the lanelets are those of the round before, so that no lanelet runs over another cut than then.
    pub(in crate::builder::layout) unchanged: bool,
    /// Whether `room_for_turns` has asked how far the turns need cuts set back. It asks once, in the first round without other demands,
    /// and demands elsewhere in the map must not change its answer for this intersection.
    pub(in crate::builder::layout) turns_asked: bool,
    /// The ends of roads that lanelets run over, and how far behind their cuts, metres.
    pub(super) overlapped_ends: Vec<(RoadEnd, f64)>,
    /// Whether the outline depends on where the roads are cut at their other ends.
    pub(super) depends_on_far_cuts: bool,
}

/// An intersection, and what its lanelets are drawn from.
#[derive(Clone, Copy)]
pub struct Site<'a> {
    /// The network.
    pub network: &'a RoadNetwork,
    /// Its whole, round roundabouts.
    pub roundabouts: &'a WholeRoundabouts,
    /// Its turn restrictions.
    pub restrictions: &'a ResolvedRestrictions,
    /// Its lanes.
    pub lanes: &'a Lanes,
    /// The intersection.
    pub intersection: &'a Intersection,
    /// The map so far, with the lanes.
    pub below: &'a MapBuilder<'a>,
    /// How many movements are drawn at most.
    pub most_movements: usize,
}

/// The kerbs of an intersection without an area lie no farther from its lanelets than this, metres: else ground would seem to be part of
/// the street that nobody drives on.
const KERB_ASIDE: f64 = 2.0;

/// To assign the lanes of an intersection otherwise, at most this number of lanelets is drawn anew. Dozens of lanes that all run into each
/// other would be drawn hundreds of times; on 104 extracts of real streets the limit changes nothing.
const MOST_DRAWN_ANEW: usize = 600;

/// The outline around lanelets, with or without bicycle lanelets among them.
struct Outlined {
    part: MapPart,
    area: Option<AreaOutline>,
    bicycles: DrawnMovements,
    /// Whether the bicycle lanelets lie inside the outline; without an outline, whether they cross no other lanelet.
    fits_bicycles: bool,
}

/// Movements, and the lanelets drawn for them.
struct Drawing {
    all: Vec<Movement>,
    drawn: DrawnMovements,
    part: MapPart,
}

impl<'a> Site<'a> {
    /// Draws the lanelets of movements. The list of dropped movements keeps those of earlier drawings.
    fn draw(&self, all: Vec<Movement>, dropped: Vec<Movement>) -> Drawing {
        let mut builder = self.builder(MapPart::default());
        let mut drawn = turning_lanelets(&mut builder, self.network, self.lanes, self.intersection, &all);
        drawn.dropped.extend(dropped);
        drawn.dropped.sort_unstable();
        Drawing { all, drawn, part: builder.into_part() }
    }

    /// Assigns lanes otherwise as long as fewer movements are undrivable then.
    fn reassigned(&self, mut drawing: Drawing) -> Drawing {
        let mut drawings = 0..MOST_DRAWN_ANEW / drawing.all.len().max(1);
        let mut undrivable = UndrivableMovements::of(&drawing.drawn.paths);
        while undrivable.count() > 0 {
            let Self { restrictions, lanes, intersection, .. } = *self;
            let others = reassignments(restrictions, lanes, intersection, &drawing.all, &undrivable);
            let better = others.into_iter().zip(&mut drawings).find_map(|(all, _)| {
                let other = self.draw(all, drawing.drawn.dropped.clone());
                let left = UndrivableMovements::of(&other.drawn.paths);
                let fits = other.drawn.dropped.len() == drawing.drawn.dropped.len();
                (fits && left.count() < undrivable.count()).then_some((other, left))
            });
            let Some(found) = better else { break };
            (drawing, undrivable) = found;
        }
        drawing
    }

    fn builder(&self, part: MapPart) -> MapBuilder<'a> {
        let mut builder = MapBuilder::resume(self.below, part);
        builder.set_ground(self.lanes.ground_of(self.intersection, self.below));
        builder
    }

    /// Draws bicycle lanelets with `add`, and the outline around all lanelets if one is `wanted`, into a part with the other lanelets.
    fn outline(
        &self,
        part: MapPart,
        (drawn, indices): (&DrawnMovements, &[Option<StripIndex>]),
        wanted: bool,
        add: impl FnOnce(&mut MapBuilder) -> DrawnMovements,
    ) -> Outlined {
        let mut builder = self.builder(part);
        let bicycles = add(&mut builder);
        let area = wanted.then(|| {
            // Roads that are not joined end before the intersection.
            let joined = joined_arms(self.network, self.intersection);
            let joined: Vec<usize> = (0..joined.len()).filter(|&arm| joined[arm]).collect();
            let arms: Vec<&Arm> = joined.iter().map(|&arm| self.lanes.arm(self.intersection.arms[arm])).collect();
            let (key, islands) = (intersection_key("intersection area", self.intersection), &self.intersection.islands);
            let mut around = |bounds, paths| area_outline(&mut builder, key, self.lanes, &arms, bounds, paths, islands);
            let mut area = if bicycles.paths.is_empty() {
                around(&drawn.bounds, (&drawn.paths, indices))
            } else {
                let paths = [&drawn.paths[..], &bicycles.paths].concat();
                around(&bicycles.bounds, (&paths, &strip_indices(&paths)))
            };
            area.overrun.iter_mut().chain(&mut area.lost).for_each(|arm| *arm = joined[*arm]);
            area
        });
        let fits_bicycles = match &area {
            Some(area) => covers(&area.places, &bicycles.paths),
            None => bicycles.paths.iter().all(|bicycle| drawn.paths.iter().all(|path| apart(bicycle, path))),
        };
        Outlined { part: builder.into_part(), area, bicycles, fits_bicycles }
    }

    /// Draws the bicycle lanelets that keep their width, and the outline, into a part with the other lanelets.
    fn outline_bicycles(
        &self,
        part: &MapPart,
        drawn: (&DrawnMovements, &[Option<StripIndex>]),
        wanted: bool,
        (ends, turns): (&BicycleLaneEnds, BicycleTurns),
    ) -> Outlined {
        let Site { network, restrictions, intersection, .. } = *self;
        let mut movements = ends.movements(network.side, restrictions, intersection, turns);
        let outline = |movements: &[Movement]| {
            let add = |builder: &mut MapBuilder| ends.draw(builder, network, intersection, movements, drawn.0);
            self.outline(part.clone(), drawn, wanted, add)
        };
        let outlined = outline(&movements);
        let uneven = ends.uneven(&outlined.bicycles);
        if uneven.is_empty() {
            return outlined;
        }
        movements.retain(|movement| !uneven.contains(movement));
        outline(&movements)
    }
}

impl IntersectionLanelets {
    /// Draws the lanelets of an intersection for vehicles.
    pub fn draw(site: Site) -> Self {
        let Site { network, lanes, intersection, .. } = site;
        let mut plan = movements(network, site.restrictions, lanes, intersection, site.most_movements);
        let mut drawing = site.draw(plan.all, Vec::new());
        if let Some(all) = movements_instead(lanes, intersection, &drawing.all, &drawing.drawn.dropped) {
            drawing = site.draw(all, drawing.drawn.dropped);
        }
        let arms = intersection.arms.iter().map(|at| lanes.arm(*at));
        let ends = arms.flat_map(|arm| arm.into.iter().chain(&arm.out)).flat_map(|lane| lane.places);
        let roads = intersection.arms.iter().map(|at| network.road(at.road).place(at.end));
        let inner = intersection.inner.iter().flat_map(|inner| inner.line.points()).copied();
        let needless = undrivable(&drawing.drawn.paths, ends.chain(roads).chain(inner));
        if !needless.is_empty() {
            drawing.all.retain(|movement| !needless.contains(movement));
            drawing = site.draw(drawing.all, [drawing.drawn.dropped, needless].concat());
        }
        let (drawn, part);
        Drawing { all: plan.all, drawn, part } = site.reassigned(drawing);
        Self {
            plan,
            drawn,
            conflicts: None,
            bicycles: BicycleMovements::default(),
            area: None,
            part,
            unchanged: false,
            turns_asked: false,
            overlapped_ends: Vec::new(),
            depends_on_far_cuts: false,
        }
    }

    /// Whether a lanelet leads into the intersection, or out of it, over the end of this road.
    pub fn lead_over(&self, intersection: &Intersection, at: RoadEnd, bicycles: BicycleLanes) -> bool {
        let arm = intersection.arms.iter().position(|&arm| arm == at);
        let leads = |path: &TurningLanelet| [Some(path.movement.from), Some(path.movement.to)].contains(&arm);
        self.drawn.paths.iter().any(leads) || bicycles == BicycleLanes::Road && self.bicycles.paths.iter().any(leads)
    }

    /// Draws the outline around the lanelets, and bicycle lanelets if they fit into it.
    #[must_use]
    pub fn outlined(mut self, site: Site) -> Self {
        if self.conflicts.is_some() {
            return self;
        }
        let Site { network, roundabouts, lanes, intersection, below, .. } = site;
        let rings = RingMovements { roundabouts, lanes, at: intersection, paths: &self.drawn.paths };
        let indices = strip_indices(&self.drawn.paths);
        let conflicts = conflicts(&self.drawn.paths, &indices);
        let ruled = intersection.signals || intersection.all_way_stop || is_signed(network, intersection);
        let crossed = (self.drawn.paths.iter().zip(&conflicts.real)).any(|(path, found)| {
            let mut others = found.iter().map(|&other| &self.drawn.paths[other]);
            // Vehicles leave a roundabout or join it by its rules: Autoware reads a roundabout element, and no area. Lights rule
            // instead of them.
            let by_rules = |it: &TurningLanelet| !intersection.signals && rings.of(it).is_some();
            let crosses = |it: &TurningLanelet| ruled || !joins_along(path, it);
            leaves_private_ground(network, intersection, path) && others.len() > 0
                || !by_rules(path) && (turns_off(&self.drawn.paths, path) || others.any(crosses))
        });
        self.conflicts = Some(conflicts);
        self.depends_on_far_cuts = has_bicycle_lanes(network, intersection);
        let ends = match self.depends_on_far_cuts {
            true => BicycleLaneEnds::find(below, network, lanes, intersection),
            false => BicycleLaneEnds::default(),
        };
        let tries: &[BicycleTurns] = if ends.is_empty() { &[] } else { &[BicycleTurns::All, BicycleTurns::Straight] };
        if crossed || !tries.is_empty() {
            let bare = if tries.is_empty() { MapPart::default() } else { self.part.clone() };
            let (drawn, part) = ((&self.drawn, &indices[..]), std::mem::take(&mut self.part));
            let mut outlined = site.outline(part, drawn, crossed, |_| DrawnMovements::default());
            for &turns in tries {
                let with = site.outline_bicycles(&bare, drawn, crossed, (&ends, turns));
                let areas = with.area.as_ref().zip(outlined.area.as_ref());
                let fits = areas.is_none_or(|(with, without)| with.fits_as_well(without));
                if with.fits_bicycles && fits && !with.bicycles.paths.is_empty() {
                    outlined = with;
                    break;
                }
            }
            (self.part, self.area) = (outlined.part, outlined.area);
            if !outlined.bicycles.paths.is_empty() {
                self.bicycles = BicycleMovements { ends, paths: outlined.bicycles.paths };
            }
        }
        if self.area.is_none() {
            self.add_kerbs(site, &indices);
        }
        self.depends_on_far_cuts |= self.area.as_ref().is_some_and(|area| area.yields);
        self.drawn.drop_outlines();
        self.bicycles.paths.iter_mut().for_each(TurningLanelet::drop_outline);
        self.part = self.part.shrunk();
        self
    }
}

impl IntersectionLanelets {
    /// Draws the kerbs between the roads of an intersection without an area, such as a fork, where the outline around its lanelets leads
    /// along the ends of all roads.
    fn add_kerbs(&mut self, site: Site, indices: &[Option<StripIndex>]) {
        if site.intersection.arms.len() < 3 || self.drawn.paths.is_empty() {
            return;
        }
        let outlined = site.outline(self.part.clone(), (&self.drawn, indices), true, |_| DrawnMovements::default());
        let Some(outline) = outlined.area else { return };
        let lanelets = self.drawn.paths.iter().filter_map(|path| Polyline::new(path.outline.iter().copied()));
        let lanelets: Vec<Polyline> = lanelets.collect();
        let is_beside = |place: Point| lanelets.iter().any(|lanelet| lanelet.distance(place) <= KERB_ASIDE);
        let closed = outline.places.iter().zip(outline.places.iter().cycle().skip(1));
        let hugs = closed.into_iter().all(|(a, b)| is_beside(*a) && is_beside(nalgebra::center(a, b)));
        if hugs && outline.overrun.is_empty() && outline.lost.is_empty() {
            self.depends_on_far_cuts |= outline.yields;
            self.part = outlined.part;
        }
    }
}

/// Whether a stop or give-way sign stands before the intersection.
fn is_signed(network: &RoadNetwork, intersection: &Intersection) -> bool {
    intersection.arms.iter().any(|arm| sign_at(network.road(arm.road), arm.end) != Control::None)
}

/// Whether two lanelets join one road side by side, as from a ramp or where a lane ends, so that neither crosses the other.
fn joins_along(path: &TurningLanelet, other: &TurningLanelet) -> bool {
    path.movement.to == other.movement.to && angle_between(path.heading, other.heading).abs().to_degrees() <= JOINING
}

/// Whether a lanelet leads from private ground onto a public road: Autoware needs its turn direction.
fn leaves_private_ground(network: &RoadNetwork, intersection: &Intersection, path: &TurningLanelet) -> bool {
    let public = [path.movement.from, path.movement.to].map(|arm| network.road(intersection.arms[arm].road).public);
    public == [false, true]
}

/// Whether vehicles turn off on a lanelet while others go on from the same road: Autoware signals the turn by its `turn_direction`.
fn turns_off(paths: &[TurningLanelet], path: &TurningLanelet) -> bool {
    let goes_elsewhere =
        |it: &TurningLanelet| it.movement.from == path.movement.from && it.movement.to != path.movement.to;
    turn_direction(path) != TurnDirection::Straight && paths.iter().any(goes_elsewhere)
}

/// Whether a bicycle lanelet and another lanelet at most touch: in an intersection without an area they must not cross.
fn apart(cycle: &TurningLanelet, path: &TurningLanelet) -> bool {
    polygon::common_area(&cycle.outline, &path.outline) < TOUCHING
}
