//! A draft of one network made over into that of another that followed from it, some of whose intersections were merged:
//! only what changes is drawn again.

use rustc_hash::FxHashMap;

use crate::builder::intersection::movement::movements;
use crate::builder::lanes::gore::gore_corners;
use crate::builder::lanes::lane_ends::connection_lines;
use crate::builder::lanes::road_continuation::Continuations;
use crate::builder::lanes::road_cut::ConnectionLines;
use crate::builder::lanes::road_lanes::{redraw, release};
use crate::builder::lanes::types::Arm;
use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::network_diff::{NetworkDiff, NetworkSnapshot};
use crate::builder::network::turn_restrictions::ResolvedRestrictions;
use crate::builder::network::{End, Intersection, IntersectionIx, RoadEnd, RoadIx, RoadNetwork, Stations};
use crate::geometry::{Point, Vector};
use crate::lanelet::PointId;

use super::MapLayout;

/// The direction in which a road ends, and the nodes on which its lanes do.
type CutAt = (Vector, Vec<(PointId, Point)>);

fn cut_at(arm: &Arm, assembly: &MapBuilder) -> CutAt {
    (arm.inward, arm.cut.iter().map(|&node| (node, assembly.position(node))).collect())
}

impl MapLayout {
    /// The draft of a network that followed from the one `before`, of which this is the draft, drawn until no way runs over the
    /// end of a lane. `kept` are the stations between which the outlines leave each road.
    #[must_use]
    pub fn renewed(
        self,
        origins: &NetworkDiff,
        before: (&NetworkSnapshot, &ResolvedRestrictions),
        network: &RoadNetwork,
        kept: &[Stations],
        restricted: &ResolvedRestrictions,
    ) -> Self {
        self.followed(origins, before, network, kept, restricted).cleared(network, restricted)
    }

    /// Draws the roads that end elsewhere than before, and the ways at their ends. Ways that are as they were before stand.
    fn followed(
        self,
        origins: &NetworkDiff,
        (was, ruled): (&NetworkSnapshot, &ResolvedRestrictions),
        network: &RoadNetwork,
        kept: &[Stations],
        restricted: &ResolvedRestrictions,
    ) -> Self {
        let roads = || (0..network.roads.len()).map(RoadIx::new);
        let back: Vec<[f64; 2]> = roads().map(|road| self.back_in(origins, network, road)).collect();
        let Self { joins: met, lines: before, mut assembly, lanes, ways: mut known, needs, .. } = self;
        let mut joins = Continuations::find(network);
        let needs = needs.renewed(origins, network, kept, |ix| joins.joined(ix));
        let stops = vec![[false; 2]; network.roads.len()];
        let untouched = |ix: &RoadIx| {
            let road = network.road(*ix);
            [road.from, road.to].iter().all(|&at| origins.untouched(at).is_some())
        };
        let cut_before = |road: RoadIx| Some(road).filter(untouched).map(|road| before.cut(origins.of(road)));
        let lines = connection_lines(network, &needs, &back, &stops, cut_before);
        joins.set_gore_corners(gore_corners(network, &lines));
        let elsewhere = joins.take_over(&met, origins);
        let cut = |lines: &ConnectionLines, road: RoadIx| lines.kept[road];
        let moves = |road: &RoadIx| elsewhere.contains(road) || cut(&before, origins.of(*road)) != cut(&lines, *road);
        let moved: Vec<RoadIx> = roads().filter(moves).collect();
        release(&mut assembly, &joins, &lanes, origins.gone());
        let mut lanes = lanes.reindexed(origins);
        let ends = moved.iter().flat_map(|&road| End::BOTH.map(|end| RoadEnd { road, end }));
        let ends: FxHashMap<RoadEnd, CutAt> = ends.map(|at| (at, cut_at(lanes.arm(at), &assembly))).collect();
        redraw(&mut assembly, network, &lines, &mut joins, &mut lanes, &moved);
        let standing = |(i, at): (u32, &Intersection)| {
            let old = origins.untouched(IntersectionIx(i))?;
            let mut ways = known[old].take()?;
            let again = || at.arms.iter().filter_map(|at| Some((lanes.arm(*at), ends.get(at)?)));
            if again().any(|(arm, before)| cut_at(arm, &assembly) != *before) {
                return None;
            }
            let asked = again().next().is_some() || restricted.concern(&at.arms) || ruled.concern(was.arms(old));
            let same = !asked || ways.plan == movements(network.side, restricted, &lanes, at);
            ways.stood = true;
            same.then_some(ways)
        };
        let ways = (0..).zip(&network.intersections).map(standing).collect();
        Self { joins, lines, assembly, lanes, ways, back, stops, needs }.complete(network, restricted)
    }

    /// How far the ends of a road are cut back for ways that run over them, but where intersections have been merged.
    fn back_in(&self, origins: &NetworkDiff, network: &RoadNetwork, road: RoadIx) -> [f64; 2] {
        let back = self.back[origins.of(road)];
        let stays = |end: End| origins.of_intersection(network.road(road).intersection(end)).is_some();
        End::BOTH.map(|end| if stays(end) { back[end] } else { 0.0 })
    }
}
