//! Reuse: the layout of a network becomes that of another that followed from it; only what changes is drawn again.

use rustc_hash::FxHashMap;

use crate::builder::intersection::movement::movements;
use crate::builder::lanes::gore::gore_corners;
use crate::builder::lanes::lane_ends::connection_lines;
use crate::builder::lanes::road_continuation::Continuations;
use crate::builder::lanes::road_lanes::redraw;
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::network_diff::{NetworkDiff, NetworkSnapshot};
use crate::builder::network::resolved_restrictions::ResolvedRestrictions;
use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::diagnostic::Finding;
use crate::geometry::{Point, Vector};
use crate::lanelet::PointId;

use super::Layout;

/// The direction in which a road ends, and the nodes on which its lanes do.
type CutAt = (Vector, Vec<(PointId, Point)>);

fn cut_at(arm: &Arm, assembly: &MapBuilder) -> CutAt {
    (arm.inward, arm.cut.iter().map(|&node| (node, assembly.position(node))).collect())
}

impl Layout {
    /// The layout of what became of the network when some of its intersections were merged, or are not merged any more: only roads
    /// that are new or end elsewhere than before and the lanelets at their ends are drawn again. `before` is what this network was,
    /// `kept` are the stations between which the outlines leave each road of the new one, `back` is how far its ends are cut back at
    /// least, metres. Also gives the restrictions that cannot be expressed.
    pub(in crate::builder::layout) fn followed(
        self,
        (before, diff): (&NetworkSnapshot, &NetworkDiff),
        network: RoadNetwork,
        (kept, back): (&[Stations], Vec<[f64; 2]>),
    ) -> (Self, Vec<Finding>) {
        let mut roads: Vec<RoadIx> = (0..network.roads.len()).map(RoadIx::new).collect();
        let (restrictions, notes) = ResolvedRestrictions::new(&network);
        let Self {
            restrictions: old_restrictions,
            joins: met,
            lines: was,
            mut assembly,
            lanes,
            ways: mut known,
            needs,
            ..
        } = self;
        let mut joins = Continuations::find(&network);
        let needs = needs.renewed(diff, &network, kept, |ix| joins.joined(ix));
        let stops = vec![[false; 2]; network.roads.len()];
        let cut_before = |ix: RoadIx| {
            let road = network.road(ix);
            let is_untouched = [road.from, road.to].iter().all(|&at| diff.untouched(at).is_some());
            diff.of(ix).filter(|_| is_untouched).map(|old| was.cut(old))
        };
        let lines = connection_lines(&network, &needs, &back, &stops, cut_before);
        joins.set_gore_corners(gore_corners(&network, &lines));
        let elsewhere = joins.take_over(&met, diff);
        let stays = |road: &RoadIx| diff.of(*road).is_some_and(|old| was.kept[old] == lines.kept[*road]);
        roads.retain(|road| elsewhere.contains(road) || !stays(road));
        let mut lanes = lanes.reindexed(diff);
        let ends = roads.iter().flat_map(|&road| End::BOTH.map(|end| RoadEnd { road, end }));
        let ends: FxHashMap<RoadEnd, CutAt> = ends.map(|at| (at, cut_at(lanes.arm(at), &assembly))).collect();
        redraw(&mut assembly, &network, &lines, &mut joins, &mut lanes, &roads);
        let standing = |(i, at): (usize, &Intersection)| {
            let old = diff.untouched(IntersectionIx::new(i))?;
            let mut ways = known[old].take()?;
            let redrawn: Vec<_> = at.arms.iter().filter_map(|at| Some((lanes.arm(*at), ends.get(at)?))).collect();
            if redrawn.iter().any(|(arm, before)| cut_at(arm, &assembly) != **before) {
                return None;
            }
            let restricted = restrictions.concern(&at.arms) || old_restrictions.concern(before.arms(old));
            let asked = !redrawn.is_empty() || restricted;
            (ways.stood, ways.turns_asked) = (true, true);
            (!asked || ways.plan == movements(network.side, &restrictions, &lanes, at)).then_some(ways)
        };
        let ways = network.intersections.iter().enumerate().map(standing).collect();
        let mut layout = Self { network, restrictions, joins, lines, assembly, lanes, ways, back, stops, needs };
        layout.draw_lanelets();
        (layout, notes)
    }

    /// How far the ends of roads are cut back at least in what became of the network, metres: as far as before, but where
    /// intersections have been merged.
    pub(in crate::builder::layout) fn kept_setbacks(&self, diff: &NetworkDiff, network: &RoadNetwork) -> Vec<[f64; 2]> {
        let of_road = |(road, old): (RoadIx, Option<RoadIx>)| {
            let back = old.map_or([0.0; 2], |old| self.back[old]);
            let stays = |end: End| diff.of_intersection(network.road(road).intersection(end)).is_some();
            End::BOTH.map(|end| if stays(end) { back[end] } else { 0.0 })
        };
        diff.roads().map(of_road).collect()
    }
}
