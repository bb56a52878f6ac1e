//! Reads the strips on one side of the lanes: bicycle lane, pedestrian lane, parking, shoulder, sidewalk.

use crate::builder::tags::road_class::DrivingSide;
use crate::builder::tags::values::metres;

use super::flow::Flow;
use super::{Strip, StripKind, Travel, WayFacts};

/// The additional width of a bicycle lane for both directions, metres.
pub(super) const BOTH_WAYS: f64 = 1.0;
/// The default width of a buffer beside a bicycle lane, metres.
pub(super) const BUFFER: f64 = 0.5;
/// The width of diagonal parking, metres.
pub(super) const PARKING_DIAGONAL: f64 = 4.5;
/// The width of perpendicular parking, metres.
pub(super) const PARKING_PERPENDICULAR: f64 = 5.0;

/// The valid widths of strips beside the lanes, metres.
const PLAUSIBLE: std::ops::RangeInclusive<f64> = 0.3..=8.0;

/// The strips on one side of the lanes, each list from the lanes outwards.
#[derive(Debug, Default)]
pub(super) struct SideStrips {
    /// The strips on the carriageway: the tag `width` includes them.
    pub carriageway: Vec<Strip>,
    /// The strips beyond the carriageway.
    pub beyond: Vec<Strip>,
}

/// One side of a way and the names of its tags.
struct WaySide<'a> {
    facts: &'a WayFacts<'a>,
    /// `left` or `right`.
    name: &'static str,
    /// The direction of the traffic beside this side.
    travel: Travel,
    /// Whether this is the near side of a one-way road, or a side of a two-way road.
    near: bool,
}

/// Reads one side: the left side for `Backward`, the right side for `Forward`.
pub(super) fn side_strips(facts: &WayFacts<'_>, flow: Flow, side: Travel) -> SideStrips {
    let right = side == Travel::Forward;
    let side_travel = if right == (facts.side == DrivingSide::Right) { Travel::Forward } else { Travel::Backward };
    let only = match flow {
        Flow::Forward => Some(Travel::Forward),
        Flow::Backward => Some(Travel::Backward),
        _ => None,
    };
    let side = WaySide {
        facts,
        name: if right { "right" } else { "left" },
        travel: only.unwrap_or(side_travel),
        near: only.is_none_or(|only| only == side_travel),
    };
    let mut strips = SideStrips::default();
    side.bicycle(flow, side_travel, &mut strips);
    strips.carriageway.extend(side.pedestrian());
    side.parking(&mut strips);
    // From the carriageway outwards: shoulder, parking bay, bicycle track, sidewalk.
    strips.beyond.sort_by_key(|strip| match strip.kind {
        StripKind::Shoulder => 0,
        StripKind::Parking => 1,
        _ => 2,
    });
    if let Some(shoulder) = side.shoulder() {
        strips.beyond.insert(0, shoulder);
    }
    strips.beyond.extend(side.sidewalk());
    strips
}

impl WaySide<'_> {
    /// The value of `prefix:left` (or `right`), else `prefix:both`, with an optional subkey.
    fn get(&self, prefix: &str, subkey: &str) -> Option<&str> {
        let tags = self.facts.tags;
        let on = |side: &str| tags.get_joined([prefix, ":", side, subkey]);
        on(self.name).or_else(|| on("both"))
    }

    /// The width under `prefix:left:width`, `prefix:both:width` or `prefix:width`, metres.
    fn width(&self, prefix: &str) -> Option<f64> {
        let on_side = self.get(prefix, ":width").and_then(metres);
        on_side
            .or_else(|| self.facts.tags.get_joined([prefix, ":width"]).and_then(metres))
            .filter(|width| PLAUSIBLE.contains(width))
    }

    fn strip(&self, kind: StripKind, tagged: Option<f64>, default: f64) -> Strip {
        Strip::plain(kind, self.travel, tagged.unwrap_or(default), tagged.is_none())
    }

    fn bicycle(&self, flow: Flow, side_travel: Travel, strips: &mut SideStrips) {
        let all = self.facts.tags.get("cycleway");
        let value = match (self.get("cycleway", ""), all) {
            (Some(value), _) => value,
            // On a one-way road `opposite_*` lies on the far side, other values on the near side.
            (None, Some(value)) if value.starts_with("opposite") != self.near || !flow.is_oneway() => value,
            _ => return,
        };
        let on_carriageway = match value {
            "lane" | "opposite_lane" => true,
            "track" | "opposite_track" => false,
            _ => return,
        };
        let travel = self.bicycle_travel(flow, side_travel, value);
        let usual = &self.facts.usual;
        let one_way = if on_carriageway { usual.bicycle_lane } else { usual.bicycle_track };
        let default = if travel == Travel::Both { one_way + BOTH_WAYS } else { one_way };
        let lane = Strip { travel, ..self.strip(StripKind::Bicycle, self.width("cycleway"), default) };
        let list = if on_carriageway { &mut strips.carriageway } else { &mut strips.beyond };
        let (inner, outer) = if self.name == "right" { ("left", "right") } else { ("right", "left") };
        list.extend(self.buffer(inner));
        list.push(lane);
        list.extend(self.buffer(outer));
    }

    /// The direction of bicycles: by `oneway` of the cycleway, seen along the way; else with the traffic beside it. On a one-way
    /// road with `oneway:bicycle=no`, bicycles ride against the traffic on the far side, else on the only track.
    fn bicycle_travel(&self, flow: Flow, side_travel: Travel, value: &str) -> Travel {
        let tags = self.facts.tags;
        // A tag for both sides does not give a direction along the way.
        let one_side = tags.get_joined(["cycleway:", self.name, ":oneway"]);
        match one_side.or_else(|| self.get("cycleway", ":oneway")).or_else(|| tags.get("cycleway:oneway")) {
            Some("no") => return Travel::Both,
            Some("-1") if one_side.is_some() || flow.is_oneway() => return Travel::Backward,
            Some("yes" | "1") if one_side.is_some() && !value.starts_with("opposite") => return Travel::Forward,
            _ => {}
        }
        let against = flow.is_oneway() && tags.is("oneway:bicycle", "no");
        let other = if self.name == "left" { "cycleway:right" } else { "cycleway:left" };
        let only_one = !["cycleway:both", other].iter().any(|key| tags.get(key).is_some_and(is_for_bicycles));
        match value {
            _ if value.starts_with("opposite") && flow.is_oneway() => self.travel.reversed(),
            _ if value.starts_with("opposite") || against && !self.near => side_travel,
            "track" if against && only_one => Travel::Both,
            _ => self.travel,
        }
    }

    /// A painted buffer on one edge of the bicycle lane.
    fn buffer(&self, edge: &str) -> Option<Strip> {
        let on_edge = if edge == "left" { ":buffer:left" } else { ":buffer:right" };
        let value = [on_edge, ":buffer:both", ":buffer"].iter().find_map(|subkey| self.get("cycleway", subkey))?;
        if value == "no" {
            return None;
        }
        let width = metres(value).filter(|width| PLAUSIBLE.contains(width));
        Some(self.strip(StripKind::Buffer, width, BUFFER))
    }

    fn parking(&self, strips: &mut SideStrips) {
        let (place, orientation) = match self.get("parking", "") {
            Some(place) => (place, self.get("parking", ":orientation").unwrap_or("parallel")),
            None => {
                let Some(kind) = self.get("parking:lane", "") else { return };
                let place = self.get("parking:lane", &format!(":{kind}")).unwrap_or("lane");
                match kind {
                    "parallel" | "diagonal" | "perpendicular" => (place, kind),
                    "marked" => ("lane", "parallel"),
                    _ => return,
                }
            }
        };
        let default = match orientation {
            "diagonal" => PARKING_DIAGONAL,
            "perpendicular" => PARKING_PERPENDICULAR,
            _ => self.facts.usual.parking,
        };
        let width = self.width("parking").or_else(|| self.width("parking:lane"));
        let strip = self.strip(StripKind::Parking, width, default);
        match place {
            "lane" | "yes" | "on_street" | "painted_area_only" | "marked" => strips.carriageway.push(strip),
            "half_on_kerb" => strips.carriageway.push(Strip { width: strip.width / 2.0, ..strip }),
            "street_side" | "lay_by" => strips.beyond.push(strip),
            _ => {}
        }
    }

    /// Whether this side has a strip: by `KEY:left`, `KEY:both`, or `KEY` with the name of the side. `yes` on a one-way road means
    /// the near side.
    fn has(&self, key: &str) -> bool {
        match (self.get(key, ""), self.facts.tags.get(key)) {
            (Some(value), _) => value != "no",
            (None, Some("both")) => true,
            (None, Some("yes")) => self.near,
            (None, Some(value)) => value == self.name,
            (None, None) => false,
        }
    }

    fn pedestrian(&self) -> Option<Strip> {
        let (width, default) = (self.width("pedestrian_lane"), self.facts.usual.pedestrian_lane);
        self.has("pedestrian_lane").then(|| self.strip(StripKind::Pedestrian, width, default))
    }

    fn shoulder(&self) -> Option<Strip> {
        let (width, default) = (self.width("shoulder"), self.facts.usual.shoulder);
        self.has("shoulder").then(|| self.strip(StripKind::Shoulder, width, default))
    }

    fn sidewalk(&self) -> Option<Strip> {
        let exists = match (self.get("sidewalk", ""), self.facts.tags.get("sidewalk")) {
            (Some(value), _) => value == "yes",
            (None, Some("both" | "yes")) => true,
            (None, Some(value)) => value == self.name,
            (None, None) => false,
        };
        exists.then(|| self.strip(StripKind::Sidewalk, self.width("sidewalk"), self.facts.usual.sidewalk))
    }
}

/// Whether a value of `cycleway` means a lane or track.
fn is_for_bicycles(value: &str) -> bool {
    matches!(value, "lane" | "track" | "opposite_lane" | "opposite_track")
}
