//! The ways through one intersection, drawn over its lanes, and the outline around them.

use crate::builder::intersection::area::area_ring::covers;
use crate::builder::intersection::area::{AreaOutline, area_outline};
use crate::builder::intersection::bicycle_lanelets::{
    BicycleLaneEnds, BicycleMovements, BicycleTurns, has_bicycle_lanes,
};
use crate::builder::intersection::conflict::{Conflicts, conflicts, strip_indices};
use crate::builder::intersection::movement::movements;
use crate::builder::intersection::movement_types::Movements;
use crate::builder::intersection::turning_lanelets::{
    DrawnMovements, TurningLanelet, intersection_key, turning_lanelets,
};
use crate::builder::lanes::types::{Arm, Lanes};
use crate::builder::map::map_builder::{MapBuilder, MapPart};
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::network::{Intersection, RoadEnd, RoadNetwork};
use crate::geometry::polygon;
use crate::settings::BicycleLanes;

/// Ways that share less than this, square metres, only touch.
const TOUCHING: f64 = 0.25;

/// The ways through one intersection.
pub struct IntersectionLanelets {
    /// Which lane leads to which.
    pub plan: Movements,
    /// The ways as they lie.
    pub drawn: DrawnMovements,
    /// Which of them get into each other's way; `None` before they are outlined.
    pub conflicts: Option<Conflicts>,
    /// Bicycle lanes that lead in and out, and the ways between them.
    pub cycles: BicycleMovements,
    /// The outline around them, where some do and it is no roundabout.
    pub area: Option<AreaOutline>,
    /// Their primitives, over those of the lanes.
    pub part: MapPart,
    /// Whether they stood in the round before: no way runs over a cut that did not then.
    pub(super) stood: bool,
    /// The ends of roads that they run over, and how far behind their cuts, metres.
    pub(super) over: Vec<(RoadEnd, f64)>,
    /// Whether their outline is another where a road is cut elsewhere at its other end.
    pub(super) leans: bool,
}

impl IntersectionLanelets {
    /// Draws the ways of an intersection over what stands.
    pub fn draw(
        network: &RoadNetwork,
        restricted: &ResolvedRestrictions,
        lanes: &Lanes,
        intersection: &Intersection,
        below: &MapBuilder<'_>,
    ) -> Self {
        let plan = movements(network.side, restricted, lanes, intersection);
        let mut assembly = MapBuilder::over(below);
        assembly.set_ground(lanes.ground_of(intersection, below));
        let drawn = turning_lanelets(&mut assembly, network, lanes, intersection, &plan.all);
        let (cycles, part) = (BicycleMovements::default(), assembly.into_part());
        Self { plan, drawn, conflicts: None, cycles, area: None, part, stood: false, over: Vec::new(), leans: false }
    }

    /// Whether some lead into the intersection over the end of this road, or out of it.
    pub fn lead_over(&self, intersection: &Intersection, at: RoadEnd, bicycles: BicycleLanes) -> bool {
        let arm = intersection.arms.iter().position(|&arm| arm == at);
        let leads = |path: &TurningLanelet| [Some(path.movement.from), Some(path.movement.to)].contains(&arm);
        self.drawn.paths.iter().any(leads) || bicycles == BicycleLanes::Road && self.cycles.paths.iter().any(leads)
    }

    /// Draws the outline around ways that were drawn over `below`, and the ways of bicycles where they fit into it.
    #[must_use]
    pub fn outlined(
        self,
        network: &RoadNetwork,
        restricted: &ResolvedRestrictions,
        lanes: &Lanes,
        intersection: &Intersection,
        below: &MapBuilder<'_>,
    ) -> Self {
        if self.conflicts.is_some() {
            return self;
        }
        let Self { plan, mut drawn, part, stood, over, .. } = self;
        let own = strip_indices(&drawn.paths);
        let conflicts = Some(conflicts(&drawn.paths, &own));
        let roundabout = intersection.arms.iter().any(|at| network.road(at.road).roundabout);
        let crossed = !roundabout && conflicts.iter().flat_map(|found| &found.real).any(|found| !found.is_empty());
        let ridden = has_bicycle_lanes(network, intersection);
        let ends = if ridden {
            BicycleLaneEnds::find(below, network, lanes, intersection)
        } else {
            BicycleLaneEnds::default()
        };
        let tries: &[BicycleTurns] = if ends.is_empty() { &[] } else { &[BicycleTurns::All, BicycleTurns::Straight] };
        if !crossed && tries.is_empty() {
            drawn.done();
            let cycles = BicycleMovements::default();
            return Self {
                plan,
                drawn,
                conflicts,
                cycles,
                area: None,
                part: part.shrunk(),
                stood,
                over,
                leans: ridden,
            };
        }
        let bare = if tries.is_empty() { MapPart::default() } else { part.clone() };
        let arms: Vec<&Arm> = intersection.arms.iter().map(|&at| lanes.arm(at)).collect();
        let islands = &intersection.islands;
        let around = |part: MapPart, add: &dyn Fn(&mut MapBuilder) -> DrawnMovements| {
            let mut assembly = MapBuilder::resume(below, part);
            assembly.set_ground(lanes.ground_of(intersection, below));
            let cycles = add(&mut assembly);
            let key = intersection_key("intersection area", intersection);
            let area = crossed.then(|| {
                if cycles.paths.is_empty() {
                    return area_outline(
                        &mut assembly,
                        key,
                        lanes,
                        &arms,
                        &drawn.bounds,
                        (&drawn.paths, &own),
                        islands,
                    );
                }
                let paths = [&drawn.paths[..], &cycles.paths].concat();
                area_outline(
                    &mut assembly,
                    key,
                    lanes,
                    &arms,
                    &cycles.bounds,
                    (&paths, &strip_indices(&paths)),
                    islands,
                )
            });
            let clear = || cycles.paths.iter().all(|cycle| drawn.paths.iter().all(|path| apart(cycle, path)));
            let covered = area.as_ref().map_or_else(clear, |area| covers(&area.places, &cycles.paths));
            (assembly.into_part(), area, cycles, covered)
        };
        let (mut part, mut area, ..) = around(part, &|_| DrawnMovements::default());
        let mut cycles = BicycleMovements::default();
        for &wanted in tries {
            let add =
                |assembly: &mut MapBuilder| ends.draw(assembly, network, restricted, intersection, wanted, &drawn);
            let (with, outline, ways, covered) = around(bare.clone(), &add);
            let fits = outline.as_ref().zip(area.as_ref()).is_none_or(|(with, without)| with.fits_as_well(without));
            if covered && fits && !ways.paths.is_empty() {
                (part, area, cycles) = (with, outline, BicycleMovements { ends, paths: ways.paths });
                break;
            }
        }
        let leans = ridden || area.as_ref().is_some_and(|area| area.yields);
        drawn.done();
        cycles.paths.iter_mut().for_each(TurningLanelet::drop_outline);
        Self { plan, drawn, conflicts, cycles, area, part: part.shrunk(), stood, over, leans }
    }
}

/// Whether two ways hardly touch: where nothing rules an intersection, no bicycle lane crosses another lane.
fn apart(cycle: &TurningLanelet, path: &TurningLanelet) -> bool {
    polygon::common_area(&cycle.outline, &path.outline) < TOUCHING
}
