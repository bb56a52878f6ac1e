//! The fix that has a traffic light named where it is obeyed: at the stop line that it faces, or on the crosswalk at which it stands.

use std::collections::{BTreeMap, BTreeSet};

use rustc_hash::FxHashMap;

use crate::diagnostic::{Edit, Finding, Subject};
use crate::geometry::{Point, Vector};
use crate::lanelet::index::{MapIndex, StopLine};
use crate::lanelet::{LaneletId, LineString, LineStringId, RoadType};
use crate::text::counted;

use super::lost_members::LostMembers;
use super::stop_line_crossings::{crossings, lanes_that_stop};

/// A light stands no farther (m) beyond its stop line than this ...
const FARTHEST_AHEAD: f64 = 60.0;
/// ... no farther (m) before it, as people draw ...
const FARTHEST_BACK: f64 = 2.0;
/// ... and no farther (m) to the side.
const FARTHEST_BESIDE: f64 = 20.0;
/// Those who see a light look at it within this angle (deg).
const ASKEW: f64 = 45.0;
/// A light for people on foot stands this near (m) to an end of their crosswalk.
const AT_CROSSWALK: f64 = 5.0;

/// Where a light is obeyed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Place {
    StopLine(LineStringId),
    Crosswalk(LaneletId),
}

/// Lights that no element names, by the place where they are obeyed.
pub struct ObeyedLights<'i, 'm> {
    map: &'i MapIndex<'m>,
    places: FxHashMap<LineStringId, Place>,
    together: BTreeMap<Place, Vec<LineStringId>>,
    /// The elements of traffic lights by their stop lines.
    at_line: FxHashMap<LineStringId, Vec<i64>>,
    without_light: LostMembers<'i, 'm>,
}

impl<'i, 'm> ObeyedLights<'i, 'm> {
    /// Finds the place of each light, where the map shows it.
    pub fn new(map: &'i MapIndex<'m>, lights: &[LineStringId]) -> Self {
        let lines = lights.iter().filter_map(|&id| map.map.linestrings.get(id));
        let placed = lines.filter_map(|light| {
            let place = match light.attributes.is("subtype", "red_green") {
                true => crosswalk(map, light).map(Place::Crosswalk),
                false => faced(map, light).map(Place::StopLine),
            };
            Some((light.id, place?))
        });
        let places: FxHashMap<LineStringId, Place> = placed.collect();
        let mut together: BTreeMap<Place, Vec<LineStringId>> = BTreeMap::new();
        for light in lights {
            if let Some(&place) = places.get(light) {
                together.entry(place).or_default().push(*light);
            }
        }
        let mut at_line: FxHashMap<LineStringId, Vec<i64>> = FxHashMap::default();
        for element in map.view().elements("traffic_light").filter(|_| !lights.is_empty()) {
            element.linestrings("ref_line").for_each(|line| at_line.entry(line).or_default().push(element.id.0));
        }
        Self { map, places, together, at_line, without_light: LostMembers::of(map) }
    }

    /// Adds the edits that let the element of the place refer to all its lights; if the place has none, those that create one.
    pub fn named(&self, finding: Finding, light: LineStringId) -> Finding {
        let Some((&place, lights)) = self.places.get(&light).and_then(|place| self.together.get_key_value(place))
        else {
            return finding;
        };
        let about = match place {
            Place::StopLine(line) => Subject::LineString(line.0),
            Place::Crosswalk(lanelet) => Subject::Lanelet(lanelet.0),
        };
        let refers = lights.iter().map(|light| ("refers".into(), Subject::LineString(light.0)));
        let finding = finding.with(about, "where it is obeyed");
        let lanelets = self.obeying(place);
        let elements: Vec<i64> = self.elements(place, &lanelets).into_iter().collect();
        match elements[..] {
            [element] => {
                let on = Subject::RegulatoryElement(element);
                let edits = refers.map(|(role, member)| Edit::AddMember { on, role, member }).collect();
                let title = format!("let {on} refer to {}, obeyed at {about}", counted(lights.len(), "light"));
                finding.fixed_by(title, false, edits)
            }
            [] if !lanelets.is_empty() => {
                let line = matches!(place, Place::StopLine(_)).then(|| ("ref_line".into(), about));
                let referrers: Vec<i64> = lanelets.iter().map(|lanelet| lanelet.0).collect();
                let title = format!("create its element at {about} for {}", counted(referrers.len(), "lanelet"));
                let members = refers.chain(line).collect();
                let edit = Edit::CreateRegulatoryElement { subtype: "traffic_light".into(), members, referrers };
                finding.fixed_by(title, false, vec![edit])
            }
            // Lights for lanes of their own: which one this is only the street tells.
            _ => finding,
        }
    }

    /// The lanelets that obey a light of the place.
    fn obeying(&self, place: Place) -> BTreeSet<LaneletId> {
        match place {
            Place::StopLine(line) => {
                lanes_that_stop(self.map, line).into_iter().map(|lane| self.map.lanes[lane].id).collect()
            }
            Place::Crosswalk(lanelet) => BTreeSet::from([lanelet]),
        }
    }

    /// The traffic light elements of the place.
    fn elements(&self, place: Place, lanelets: &BTreeSet<LaneletId>) -> BTreeSet<i64> {
        let mut elements: BTreeSet<i64> = self.without_light.of_lanelets("traffic_light", lanelets).collect();
        match place {
            Place::StopLine(line) => elements.extend(self.at_line.get(&line).into_iter().flatten()),
            Place::Crosswalk(id) => elements.extend(self.map.elements(id, "traffic_light").map(|light| light.id.0)),
        }
        elements
    }
}

/// The nearest stop line of lanes that lead toward a light and see it hang from left to right.
fn faced(map: &MapIndex, light: &LineString) -> Option<LineStringId> {
    let [left, right] = ends(map, light)?;
    let (at, rightward) = (nalgebra::center(&left, &right), (right - left).try_normalize(f64::EPSILON)?);
    let view = Vector::new(-rightward.y, rightward.x);
    let reach = Vector::repeat(FARTHEST_AHEAD);
    let from = |line: &StopLine| at - nalgebra::center(&line.ends[0], &line.ends[1]);
    let is_ahead = |line: &StopLine| {
        let (ahead, beside) = (from(line).dot(&view), from(line).dot(&rightward).abs());
        (-FARTHEST_BACK..=FARTHEST_AHEAD).contains(&ahead) && beside <= FARTHEST_BESIDE
    };
    let is_seen = |line: &StopLine| {
        crossings(map, line, 0.0).into_iter().any(|one| {
            let center = map.lanes[one.lane].center.as_ref();
            center.is_some_and(|center| center.direction(one.station).dot(&view) > ASKEW.to_radians().cos())
        })
    };
    let near = map.stop_lines_near(at - reach, at + reach).into_iter().filter(|line| is_ahead(line) && is_seen(line));
    let nearest = near.min_by(|a, b| from(a).norm().total_cmp(&from(b).norm()).then(a.way.cmp(&b.way)));
    nearest.map(|line| line.way)
}

/// The crosswalk that ends nearest to a light.
fn crosswalk(map: &MapIndex, light: &LineString) -> Option<LaneletId> {
    let [left, right] = ends(map, light)?;
    let at = nalgebra::center(&left, &right);
    let reach = Vector::repeat(AT_CROSSWALK);
    let near = map.lanes_near(at - reach, at + reach).into_iter().map(|lane| &map.lanes[lane]);
    let far = near.filter(|lane| lane.kind == RoadType::Crosswalk).map(|lane| {
        let ends = [&lane.start, &lane.end].map(|end| (end.middle() - at).norm());
        (ends[0].min(ends[1]), lane.id)
    });
    let nearest = far.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    nearest.filter(|(far, _)| *far <= AT_CROSSWALK).map(|(_, id)| id)
}

fn ends(map: &MapIndex, light: &LineString) -> Option<[Point; 2]> {
    let place = |id| map.map.points.get(id).map(|point| point.position);
    Some([place(*light.points.first()?)?, place(*light.points.last()?)?])
}
