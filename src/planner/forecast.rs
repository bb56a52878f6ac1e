//! All that is told of one lanelet.

use serde::Serialize;

use super::attention::{Attention, AttentionEnd, Reason};
use super::crosswalks::{self, CrosswalkStop};
use super::lines::{self, Lines, ReachesIn};
use super::params::{AROUND, Params};
use super::path::Path;
use super::road_network::RoadNetwork;
use super::sides::{self, BlindSpot, Blinker, PrivateRoad, SignLine, TrafficLight};
use crate::lanelet::participants::speed_limit;
use crate::lanelet::{LaneletId, RegulatoryElementId};

/// Speed limit of a lanelet without one, km/h: what Lanelet2 takes in town.
const USUAL_SPEED: f64 = 50.0;

/// What the intersection module does on a lanelet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The lanelet has no `turn_direction`: the module does not run.
    NotInIntersection,
    /// No lanelet conflicts: the module reports an internal error.
    NoConflict,
    /// All that conflict are ignored: it only looks for a blocked exit.
    WatchesNobody,
    /// There are lanes to watch that its path never touches: the module reports an internal error.
    NeverMeets,
    /// The road network begins so close before it that there is no place to stop.
    NoApproach,
    /// Where it would stop, it already stands in the first watched lane: it gives up and stops for nobody.
    StopsTooLate,
    /// It watches, and stops if somebody comes.
    Watches,
}

impl Outcome {
    /// What follows for a lanelet with `turn_direction`.
    fn of(attention: &Attention, first_watched: Option<usize>, lines: &Lines) -> Self {
        if attention.conflicting.is_empty() {
            return Self::NoConflict;
        }
        match (attention.watched.is_empty(), first_watched, lines.default_stop) {
            (true, ..) => Self::WatchesNobody,
            (_, None, _) => Self::NeverMeets,
            (.., None) => Self::NoApproach,
            (.., Some(stop)) if stop.reaches_in == ReachesIn::Yes => Self::StopsTooLate,
            _ => Self::Watches,
        }
    }
}

/// Who of two conflicting lanelets waits, as far as their elements say.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Priority {
    /// The other watches this one, too.
    Both,
    /// Only this one watches the other.
    Mine,
    /// Only the other watches this one.
    Theirs,
    /// Neither watches the other.
    Nobody,
}

/// A lanelet that conflicts.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Watched {
    /// The lanelet.
    pub lanelet: LaneletId,
    /// Its `turn_direction`, as written.
    pub turn: Option<String>,
    /// The traffic light that rules it.
    pub light: Option<RegulatoryElementId>,
    /// Who of the two waits.
    pub waits: Priority,
    /// Why it is ignored; `None`: it is watched.
    #[serde(flatten)]
    pub ignored: Option<Reason>,
    /// The lanelets before it that are watched, too.
    pub before: Vec<LaneletId>,
    /// Where the road network begins before the length is reached: the lanelet, and the metres that are watched of its way.
    pub ends: Vec<(LaneletId, f64)>,
}

/// What Autoware's planner will do on one lanelet.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Forecast {
    /// The lanelet.
    pub lanelet: LaneletId,
    /// Its `turn_direction`.
    pub turn: Option<String>,
    /// The path that was taken: the lanelets before, it, and those behind.
    pub path: Vec<LaneletId>,
    /// Speed limit that counts, km/h.
    pub speed: f64,
    /// What the intersection module does.
    pub outcome: Outcome,
    /// Whom it watches, those first that the path meets first.
    pub watched: Vec<Watched>,
    /// Whom it ignores.
    pub ignored: Vec<Watched>,
    /// The lanelet of `watched` that the path meets first.
    pub first_watched: Option<LaneletId>,
    /// Its lines.
    pub lines: Lines,
    /// The first traffic light of the lanelet.
    pub light: Option<TrafficLight>,
    /// Stop signs on the way.
    pub signs: Vec<SignLine>,
    /// Whether the vehicle merges from private ground.
    pub private: Option<PrivateRoad>,
    /// Crosswalks on the way.
    pub crosswalks: Vec<CrosswalkStop>,
    /// The blinker.
    pub blinker: Option<Blinker>,
    /// The blind side.
    pub blind_spot: Option<BlindSpot>,
}

/// Where the vehicle stops on one lanelet: what a forecast tells of it, and no more.
#[derive(Clone, Debug, PartialEq)]
pub struct Stopping {
    /// What the intersection module does.
    pub outcome: Outcome,
    /// The lanelet that is met first of those that are watched, by its position.
    pub first_watched: Option<usize>,
    /// Its lines, without those that lie farther back than the vehicle is long, and without the stuck area.
    pub lines: Lines,
}

impl RoadNetwork<'_, '_> {
    /// Where the vehicle stops on a lanelet with `turn_direction`; a small part of the work of [`Self::forecast`].
    pub fn stopping(&self, at: usize, attention: &Attention, params: &Params) -> Option<Stopping> {
        let path = Path::over(self, at, &[], [params.stopping_reach(), 0.0], params)?;
        let speed = self.speed(at) / 3.6;
        let (lines, first_watched) = lines::for_traffic(self, &path, &attention.watched, speed, params);
        Some(Stopping { outcome: Outcome::of(attention, first_watched, &lines), first_watched, lines })
    }

    /// Speed limit that counts on a lanelet, km/h.
    fn speed(&self, at: usize) -> f64 {
        let tags = &self.seen(at).lanelet.attributes;
        speed_limit(tags, "vehicle").filter(|speed| *speed > 0.0).unwrap_or(USUAL_SPEED)
    }

    /// What the planner will do on a lanelet, on a route if one is given; `None` where the lanelet has no middle to drive along.
    pub fn forecast(&self, at: usize, route: &[usize], params: &Params) -> Option<Forecast> {
        let path = Path::over(self, at, route, AROUND, params)?;
        let speed = self.speed(at);
        let metres_per_second = speed / 3.6;
        let turn = self.turn(at);
        let attention = turn.map(|_| self.attention(at, params)).unwrap_or_default();
        let found = lines::find(self, &path, &attention.watched, &attention.conflicting, metres_per_second, params);
        let outcome = match turn {
            None => Outcome::NotInIntersection,
            Some(_) => Outcome::of(&attention, found.first_watched, &found.lines),
        };
        let reasons = attention.ignored.iter();
        Some(Forecast {
            lanelet: self.id(at),
            turn: self.seen(at).tag("turn_direction").map(str::to_owned),
            path: self.ids(&path.lanelets),
            speed,
            outcome,
            watched: attention.watched.iter().map(|&one| self.watched(at, one, None, &attention, params)).collect(),
            ignored: reasons.map(|one| self.watched(at, one.lanelet, Some(one.reason), &attention, params)).collect(),
            first_watched: found.first_watched.map(|one| self.id(one)),
            lines: found.lines,
            light: sides::light(self, &path, params),
            signs: sides::signs(self, &path, params),
            private: turn.and_then(|_| sides::private(self, &path, found.first_conflicting, params)),
            crosswalks: crosswalks::find(self, &path, params),
            blinker: sides::blinker(self, &path, metres_per_second, params),
            blind_spot: sides::blind_spot(self, at, params),
        })
    }

    /// One lanelet that conflicts with another.
    fn watched(
        &self,
        at: usize,
        other: usize,
        ignored: Option<Reason>,
        attention: &Attention,
        params: &Params,
    ) -> Watched {
        let back = self.turn(other).is_some() && self.watches(other, at, params);
        let waits = match (ignored.is_none(), back) {
            (true, true) => Priority::Both,
            (true, false) => Priority::Mine,
            (false, true) => Priority::Theirs,
            (false, false) => Priority::Nobody,
        };
        let length = if ignored.is_none() { params.attention_area_length } else { 0.0 };
        let reach = self.reach(other, length, &attention.own);
        let ends = reach.ends.iter().filter(|_| ignored.is_none());
        Watched {
            lanelet: self.id(other),
            turn: self.seen(other).tag("turn_direction").map(str::to_owned),
            light: self.light(other).map(|light| light.id),
            waits,
            ignored,
            before: if ignored.is_none() { self.ids(&reach.before) } else { Vec::new() },
            ends: ends.map(|&AttentionEnd { lanelet, after }| (self.id(lanelet), after)).collect(),
        }
    }
}
