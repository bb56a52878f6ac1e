//! Who goes first at a junction: lights, the junction's own priorities, signs of lanes; and which lights change together.

use crate::builder::intersection::turning_lanelets::TurningLanelet;
use crate::builder::network::approach_control::Control;
use crate::builder::network::turn_angle::STRAIGHT_ON;
use crate::builder::tags::road_class::DrivingSide;
use crate::lanelet::right_of_way::{RankedMovement, Turn};
use crate::xodr::{Controller, Junction};

use super::junctions::Site;
use super::signals::Furniture;

impl Site<'_> {
    /// What controls an arm: lights, else signs.
    pub fn control(&self, arm: usize, furniture: &Furniture) -> Control {
        let paths = self.paths.iter().zip(&self.members).filter(|(path, _)| path.movement.from == arm);
        let mut lanes: Vec<usize> = self.arms[arm].into.iter().map(|lane| lane.lane).collect();
        lanes.extend(paths.map(|(_, member)| *member));
        furniture.control(&lanes)
    }

    /// For each way whether it goes first, by the junction's priorities, else by signs of its lanes; `None` where nothing tells.
    pub fn ranks(&self, junction: &Junction, controls: &[Control], furniture: &Furniture) -> Vec<Option<bool>> {
        let lights = controls.contains(&Control::Signals);
        let all: Vec<(&TurningLanelet, usize)> = self.paths.iter().zip(self.members.iter().copied()).collect();
        let lanes = |(path, member): &(&TurningLanelet, usize)| {
            [self.arms[path.movement.from].into[path.movement.in_lane].lane, *member]
        };
        let signed = all.iter().any(|way| furniture.goes_first(&lanes(way)));
        let by_sign: Vec<bool> = all
            .iter()
            .map(|way| match (controls[way.0.movement.from], furniture.control(&lanes(way))) {
                (Control::Signals, _) => true,
                _ if lights => false,
                (_, Control::Stop | Control::GiveWay) => false,
                _ => !signed || furniture.goes_first(&lanes(way)),
            })
            .collect();
        let stated = |way: &(&TurningLanelet, usize), which: usize| {
            let (connecting, incoming) = (way.1, self.arms[way.0.movement.from].into[way.0.movement.in_lane].lane);
            let roads = [connecting, incoming].map(|lane| {
                let lane = self.drawn.lanes[lane].stretch();
                &self.scene.road(lane).id
            });
            junction.priorities.iter().any(|pair| roads.contains(&&pair[which]))
        };
        let by_priority = all.iter().map(|way| match [stated(way, 0), stated(way, 1)] {
            [true, false] => Some(true),
            [false, true] => Some(false),
            _ => None,
        });
        let ranks: Vec<Option<bool>> = match by_sign.contains(&true) && by_sign.contains(&false) {
            true => by_priority.zip(&by_sign).map(|(stated, signed)| stated.or(Some(*signed))).collect(),
            false => by_priority.collect(),
        };
        let differ = ranks.contains(&Some(true)) && ranks.contains(&Some(false));
        if differ { ranks } else { vec![None; ranks.len()] }
    }

    pub fn ranked_movements(
        &self,
        controls: &[Control],
        ranks: &[Option<bool>],
        side: DrivingSide,
    ) -> Vec<RankedMovement> {
        let near = if side == DrivingSide::Left { 1.0 } else { -1.0 };
        let ranked = |(path, rank): (&TurningLanelet, &Option<bool>)| RankedMovement {
            arm: path.movement.from,
            turn: match path.turn * near {
                t if t.abs() <= STRAIGHT_ON => Turn::Straight,
                t if t > 0.0 => Turn::Near,
                _ => Turn::Far,
            },
            signalised: controls[path.movement.from] == Control::Signals,
            controlled: true,
            priority: *rank,
            bicycle: false,
        };
        self.paths.iter().zip(ranks).map(ranked).collect()
    }

    /// The approaches that have green together: those whose lights one controller of the junction changes. None, where there is one
    /// controller only, or where an approach has lights of several, or of none.
    pub fn phases(&self, junction: &Junction, furniture: &Furniture) -> Vec<Vec<usize>> {
        let controllers =
            || junction.controllers.iter().filter_map(|id| self.scene.file.controllers.iter().find(|it| it.id == *id));
        let mut phases: Vec<Vec<usize>> = vec![Vec::new(); controllers().count()];
        for (at, arm) in self.arms.iter().enumerate() {
            let paths = self.paths.iter().zip(&self.members).filter(|(path, _)| path.movement.from == at);
            let lanes: Vec<usize> =
                arm.into.iter().map(|lane| lane.lane).chain(paths.map(|(_, member)| *member)).collect();
            let lights = furniture.lights(&lanes);
            if lights.is_empty() {
                continue;
            }
            let own = |controller: &&Controller| controller.signals.iter().any(|id| lights.contains(id.as_str()));
            let changed: Vec<usize> =
                controllers().enumerate().filter(|(_, controller)| own(controller)).map(|(i, _)| i).collect();
            let [only] = changed[..] else { return Vec::new() };
            phases[only].push(at);
        }
        phases.retain(|phase| !phase.is_empty());
        if phases.len() > 1 { phases } else { Vec::new() }
    }
}
