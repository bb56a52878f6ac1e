//! Which lights hang on which lanelets: Autoware uses one element of a lanelet, so that all of its lights are in one.

use std::collections::BTreeMap;

use crate::builder::ids::Key;
use crate::builder::map::map_builder::MapBuilder;
use crate::lanelet::{LaneletId, LineStringId, Target};

/// A light: its body and its bulbs, and its key.
#[derive(Clone, Copy)]
pub struct Light {
    /// Of the signal.
    pub key: Key,
    /// Body and bulbs.
    pub lines: [LineStringId; 2],
}

/// The lights of the lanelets behind stop lines.
#[derive(Default)]
pub struct HungLights(BTreeMap<LaneletId, (LineStringId, Vec<Light>)>);

impl HungLights {
    /// Whether a lanelet has a light.
    pub fn has(&self, lanelet: LaneletId) -> bool {
        self.0.contains_key(&lanelet)
    }

    /// Hangs a light on a lanelet behind a stop line; the first line of a lanelet stays.
    pub fn hang(&mut self, lanelet: LaneletId, line: LineStringId, light: Light) {
        let (_, lights) = self.0.entry(lanelet).or_insert((line, Vec::new()));
        if lights.iter().all(|known| known.lines != light.lines) {
            lights.push(light);
        }
    }

    /// Hangs the lights of one lanelet on another.
    pub fn hang_alike(&mut self, lanelet: LaneletId, line: LineStringId, other: LaneletId) {
        if let Some((_, lights)) = self.0.get(&other).cloned() {
            lights.into_iter().for_each(|light| self.hang(lanelet, line, light));
        }
    }

    /// Adds an element for the lanelets behind each line that have the same lights.
    pub fn draw(self, assembly: &mut MapBuilder) {
        let lines = |lights: &[Light]| lights.iter().map(|light| light.lines).collect::<Vec<_>>();
        let mut alike: BTreeMap<_, Vec<LaneletId>> = BTreeMap::new();
        for (lanelet, (line, lights)) in &self.0 {
            alike.entry((*line, lines(lights))).or_default().push(*lanelet);
        }
        for ((line, _), lanelets) in alike {
            let lights = lanelets.first().and_then(|lanelet| self.0.get(lanelet)).map_or(&[][..], |(_, lights)| lights);
            let Some((first, others)) = lights.split_first() else { continue };
            let key = others.iter().fold(first.key.number(line.0), |key, light| key.number(light.lines[0].0));
            let member = |role: &'static str, which: usize| {
                lights.iter().map(move |light| (role, Target::LineString(light.lines[which])))
            };
            let ref_line = [("ref_line", Target::LineString(line))];
            let members: Vec<(&str, Target)> =
                member("refers", 0).chain(member("light_bulbs", 1)).chain(ref_line).collect();
            assembly.element(key.word("lights"), "traffic_light", &members, &lanelets);
        }
    }
}
