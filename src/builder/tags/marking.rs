//! The paint along the edges of lanes: by tags, the country, and the kinds of the lanes.

use crate::lanelet::Attributes;
use crate::lanelet::lane_change::SIDES;
use crate::osm::{Tags, Text};

use super::cross_section::{CrossSection, Strip, StripKind, Travel};
use super::side_strips::are_parted;

/// Countries in which the line between opposite directions is yellow.
const YELLOW: [&str; 16] =
    ["AR", "BR", "CA", "CL", "CN", "CO", "EC", "KR", "MX", "NO", "PE", "PR", "TH", "TW", "US", "UY"];
/// Countries in which a solid line between opposite directions is double (MUTCD, section 3B.01).
const DOUBLE: [&str; 4] = ["CA", "MX", "PR", "US"];
/// The smallest width, metres, of a road with a line between two lanes: 18 ft in the MUTCD, section 3B.01, and 5.5 m in the
/// British and Japanese manuals.
const MIN_WIDTH_WITH_LINE: f64 = 5.5;
/// Tags about paint.
const TAGS: [&str; 3] = ["divider", "overtaking", "lane_markings"];
/// Separations of a bicycle lane that cars cannot cross.
const BARRIERS: [&str; 11] = [
    "kerb",
    "separation_kerb",
    "jersey_barrier",
    "guard_rail",
    "fence",
    "structure",
    "planter",
    "grass_verge",
    "ditch",
    "hedge",
    "tree_row",
];
/// Tags about bicycles.
const CYCLEWAYS: [&str; 4] = ["cycleway", "cycleway:both", "cycleway:left", "cycleway:right"];
/// The value for bicycles on the bus lane.
pub const SHARES: &str = "share_busway";

/// The paint along an edge. Of two lines the left one, seen along the road, comes first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum EdgePaint {
    /// No paint.
    None,
    /// One line.
    One(LineStyle),
    /// Two lines side by side.
    Two([LineStyle; 2]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum LineStyle {
    Solid,
    Dashed,
}

use LineStyle::{Dashed, Solid};

impl EdgePaint {
    /// Lanelet2's type and subtype of a linestring that runs along the road or, if `inverted`, against it.
    fn names(self, inverted: bool) -> [&'static str; 2] {
        let subtype = match self {
            Self::None => return ["virtual", ""],
            Self::One(Solid) => "solid",
            Self::One(Dashed) | Self::Two([Dashed, Dashed]) => "dashed",
            Self::Two([Solid, Solid]) => "solid_solid",
            Self::Two([first, _]) if (first == Solid) != inverted => "solid_dashed",
            Self::Two(_) => "dashed_solid",
        };
        ["line_thin", subtype]
    }
}

/// The Lanelet2 tags of the border at an edge of a cross-section: kerb or paint. The border runs along the road's line or, if
/// `inverted`, against it.
pub fn marking(section: &CrossSection, edge: usize, tags: &Tags, country: Option<&str>, inverted: bool) -> Attributes {
    let (kerb_left, kerb_right) = section.carriageway();
    if edge == kerb_left || edge == kerb_right {
        return Attributes::of(&[("type", "road_border")]);
    }
    let is_track = [true, false].iter().any(|&left| kerb_of_track(section, tags, left) == Some(edge));
    if is_track || lies_between_shoulders(section, edge) {
        return Attributes::of(&[("type", "road_border"), ("lane_change", "no")]);
    }
    let (paint, change, opposed) = match lanes_beside(section, edge) {
        Some([left, right]) if same_way(left, right) => {
            let change = may_change(left, right, left.kind == right.kind);
            (between_lanes(change, tags), change, false)
        }
        Some(sides) => (between_directions(section, sides, tags, country), [false, false], true),
        None => (EdgePaint::One(Solid), [false, false], false),
    };
    let [kind, subtype] = paint.names(inverted);
    let mut marking = Attributes::of(&[("type", kind)]);
    if paint != EdgePaint::None {
        marking.push("subtype", subtype);
        if opposed && country.is_some_and(|country| YELLOW.contains(&country)) {
            marking.push("color", "yellow");
        }
    }
    tell_change(&mut marking, change, inverted);
    marking
}

/// Says who may change lanes over a border: from its left to its right and back, along the road. Beside `lane_change` Lanelet2 reads
/// neither the tags of the sides nor the paint, so that a border open to one side has the tags of the sides alone.
fn tell_change(marking: &mut Attributes, [to_right, to_left]: [bool; 2], inverted: bool) {
    let said = |open: bool| if open { "yes" } else { "no" };
    if to_right == to_left {
        marking.push("lane_change", said(to_right));
        return;
    }
    let [left, right] = if inverted { [to_right, to_left] } else { [to_left, to_right] };
    for (key, open) in SIDES.into_iter().zip([left, right]) {
        marking.push(key, said(open));
    }
}

/// The Lanelet2 tags of a bound inside an intersection, where nothing is painted and vehicles keep their lane.
pub fn unpainted() -> Attributes {
    Attributes::of(&[("type", "virtual"), ("lane_change", "no")])
}

/// Whether an edge parts two shoulders in the middle of a road.
fn lies_between_shoulders(section: &CrossSection, edge: usize) -> bool {
    let left = edge.checked_sub(1).and_then(|at| section.strips.get(at));
    left.zip(section.strips.get(edge)).is_some_and(|(left, right)| are_parted(left, right))
}

/// The edge of the kerb before a bicycle track on one side of a road.
fn kerb_of_track(section: &CrossSection, tags: &Tags, left: bool) -> Option<usize> {
    let is_bicycle = |strip: &Strip| strip.kind == StripKind::Bicycle;
    let strips = &section.strips;
    let track = if left { strips.iter().position(is_bicycle) } else { strips.iter().rposition(is_bicycle) }?;
    if section.driven().any(|(i, _)| (i < track) == left) || !is_behind_kerb(tags, left) {
        return None;
    }
    // A verge between kerb and track lies behind the kerb.
    let is_verge = |strip: &&Strip| strip.kind == StripKind::Buffer;
    Some(match left {
        true => track + 1 + strips.iter().skip(track + 1).take_while(is_verge).count(),
        false => track - strips.iter().take(track).rev().take_while(is_verge).count(),
    })
}

/// Whether a kerb or another barrier separates the bicycle lane on one side of a road from cars.
fn is_behind_kerb(tags: &Tags, left: bool) -> bool {
    let (side, toward_lanes) = if left { ("left", "right") } else { ("right", "left") };
    let value = |keys: &[[&str; 2]]| {
        let sides = [[":", side], [":", "both"], ["", ""]];
        let mut found = sides.into_iter().flat_map(|[colon, side]| {
            keys.iter().filter_map(move |[key, edge]| tags.get_joined(["cycleway", colon, side, key, edge]))
        });
        found.next()
    };
    let separation = value(&[[":separation:", toward_lanes], [":separation:", "both"], [":separation", ""]]);
    matches!(value(&[["", ""]]), Some("track" | "opposite_track"))
        || separation.is_some_and(|value| value.split(';').any(|one| BARRIERS.contains(&one.trim())))
}

/// The Lanelet2 tags of the border between two lanes just before a stop line, where lane changes are forbidden unless
/// `change:lanes` allows them; `None` if the paint is the same as elsewhere.
pub fn before_stop(section: &CrossSection, edge: usize, tags: &Tags, inverted: bool) -> Option<Attributes> {
    let [left, right] = lanes_beside(section, edge).filter(|[left, right]| same_way(left, right))?;
    let change = may_change(left, right, false);
    let elsewhere = between_lanes(may_change(left, right, left.kind == right.kind), tags);
    let paint = between_lanes(change, tags);
    let [kind, subtype] = paint.names(inverted);
    let mut marking = Attributes::of(&[("type", kind), ("subtype", subtype)]);
    tell_change(&mut marking, change, inverted);
    (paint != elsewhere).then_some(marking)
}

/// The lanes to the left and to the right of an edge; `None` if there is none on one side.
fn lanes_beside(section: &CrossSection, edge: usize) -> Option<[&Strip; 2]> {
    let driven = |i: usize| section.strips.get(i).filter(|s| s.kind.is_driven());
    Some([driven(edge.checked_sub(1)?)?, driven(edge)?])
}

fn same_way(left: &Strip, right: &Strip) -> bool {
    left.travel == right.travel && left.travel != Travel::Both
}

/// The paint between lanes of one direction, dashed on the side from which vehicles may change.
fn between_lanes(change: [bool; 2], tags: &Tags) -> EdgePaint {
    let paint = match change {
        [true, true] => EdgePaint::One(Dashed),
        [true, false] => EdgePaint::Two([Dashed, Solid]),
        [false, true] => EdgePaint::Two([Solid, Dashed]),
        [false, false] => EdgePaint::One(Solid),
    };
    if tags.is("lane_markings", "no") { EdgePaint::None } else { paint }
}

/// Whether vehicles may change from the left strip (seen along the line) to the right one, and back: by `change:lanes`, else
/// `default`.
fn may_change(left: &Strip, right: &Strip, default: bool) -> [bool; 2] {
    let [to_right, to_left] = match left.travel {
        Travel::Backward => [left.change[0], right.change[1]],
        _ => [left.change[1], right.change[0]],
    };
    [to_right.unwrap_or(default), to_left.unwrap_or(default)]
}

/// The paint between opposite directions: by `divider`, `overtaking` and `lane_markings`. Without these tags overtaking is
/// forbidden, and a narrow road has no line. The line is double in some countries, and between directions of several lanes.
fn between_directions(section: &CrossSection, sides: [&Strip; 2], tags: &Tags, country: Option<&str>) -> EdgePaint {
    let double = country.is_some_and(|country| DOUBLE.contains(&country));
    let solid = if double { EdgePaint::Two([Solid, Solid]) } else { EdgePaint::One(Solid) };
    if let Some(paint) = tags.get("divider").and_then(divider) {
        return paint;
    }
    // The dashed line is on the side of the traffic that may overtake.
    let overtaking =
        |travel: Travel| EdgePaint::Two(sides.map(|side| if side.travel == travel { Dashed } else { Solid }));
    match (tags.get("overtaking"), tags.get("lane_markings")) {
        (Some("no"), _) => return solid,
        (Some("yes" | "both"), _) => return EdgePaint::One(Dashed),
        (Some("forward"), _) => return overtaking(Travel::Forward),
        (Some("backward"), _) => return overtaking(Travel::Backward),
        (_, Some("no")) => return EdgePaint::None,
        (_, None) if is_narrow(section) => return EdgePaint::None,
        _ => {}
    }
    // A centre turn lane: vehicles enter it over dashes.
    if double && sides.iter().any(|side| side.travel == Travel::Both) {
        return overtaking(Travel::Both);
    }
    let lanes = |travel: Travel| section.driven().filter(|(_, strip)| strip.travel == travel).count();
    let several = lanes(Travel::Forward) > 1 && lanes(Travel::Backward) > 1;
    if several { EdgePaint::Two([Solid, Solid]) } else { solid }
}

/// Whether a road has two lanes of known width that are too narrow for a line between them.
fn is_narrow(section: &CrossSection) -> bool {
    let lanes: Vec<&Strip> = section.driven().map(|(_, strip)| strip).collect();
    let known = lanes.len() == 2 && lanes.iter().all(|lane| !lane.width_guessed);
    known && lanes.iter().map(|lane| lane.width).sum::<f64>() < MIN_WIDTH_WITH_LINE
}

/// The paint of a value of `divider`, left to right along the way.
fn divider(value: &str) -> Option<EdgePaint> {
    let stroke = |name: &str| match name.trim() {
        "solid_line" => Some(Solid),
        "dashed_line" => Some(Dashed),
        _ => None,
    };
    match value.split_once(';') {
        Some((left, right)) => Some(EdgePaint::Two([stroke(left)?, stroke(right)?])),
        None if value == "no" => Some(EdgePaint::None),
        None if value == "double_solid_line" => Some(EdgePaint::Two([Solid, Solid])),
        None => Some(EdgePaint::One(stroke(value)?)),
    }
}

/// Whether two roads have the same tags about paint, bus lanes and bicycle tracks.
pub fn alike(a: &Tags, b: &Tags) -> bool {
    TAGS.iter().all(|key| a.get(key) == b.get(key))
        && CYCLEWAYS.iter().all(|key| a.is(key, SHARES) == b.is(key, SHARES))
        && [true, false].iter().all(|&left| is_behind_kerb(a, left) == is_behind_kerb(b, left))
}

/// The tags of a road of which the line is reversed.
pub fn turned(tags: &Tags) -> Tags {
    let value = |key: &str, value: &str| match (key, value, value.split_once(';')) {
        ("overtaking", "forward", _) => "backward".to_owned(),
        ("overtaking", "backward", _) => "forward".to_owned(),
        ("divider", _, Some((left, right))) => format!("{right};{left}"),
        _ => value.to_owned(),
    };
    let other_side = |word: &str| match word {
        "left" => "right".to_owned(),
        "right" => "left".to_owned(),
        _ => word.to_owned(),
    };
    let mut turned = Tags::default();
    for (key, old) in tags.iter() {
        match key {
            _ if key.starts_with("cycleway:") => {
                let words: Vec<String> = key.split(':').map(other_side).collect();
                turned.push(Text::from(words.join(":")), old);
            }
            _ if TAGS.contains(&key) => turned.push(key, Text::from(value(key, old))),
            _ => turned.push(key, old),
        }
    }
    turned
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A road of lanes between sidewalks, left to right: `<` against its line, `>` along it, `=` both directions.
    fn section(lanes: &str) -> CrossSection {
        let walk = Strip::plain(StripKind::Sidewalk, Travel::Both, 1.5, false);
        let travel = |c: char| match c {
            '<' => Travel::Backward,
            '>' => Travel::Forward,
            _ => Travel::Both,
        };
        let lane = |c: char| Strip::plain(StripKind::Drive, travel(c), 3.0, false);
        let strips = [walk.clone()].into_iter().chain(lanes.chars().map(lane)).chain([walk]);
        CrossSection { strips: strips.collect() }
    }

    /// The subtype (or type), colour and `lane_change` at the right edge of a lane.
    fn painted(lanes: &str, lane: usize, tags: &[(&str, &str)], country: &str) -> String {
        let marking = marking(&section(lanes), lane + 2, &tags.iter().copied().collect(), Some(country), false);
        let of = |key: &str| marking.get(key).map(str::to_owned);
        [of("subtype").or_else(|| of("type")), of("color"), of("lane_change")]
            .into_iter()
            .flatten()
            .collect::<Vec<_>>()
            .join(" ")
    }

    #[test]
    fn the_middle_of_a_road_follows_the_country() {
        assert_eq!(painted("<>", 0, &[], "DE"), "solid no");
        assert_eq!(painted("<<>>", 1, &[], "DE"), "solid_solid no");
        assert_eq!(painted("<>", 0, &[], "US"), "solid_solid yellow no");
        assert_eq!(painted("><", 0, &[], "TH"), "solid yellow no");
        assert_eq!(painted("<=>", 0, &[], "US"), "solid_dashed yellow no");
        assert_eq!(painted("<=>", 1, &[], "US"), "dashed_solid yellow no");
        assert_eq!(painted("<>", 1, &[], "US"), "road_border");
    }

    #[test]
    fn two_shoulders_in_the_middle_are_parted_by_a_border() {
        let kinds = [StripKind::Shoulder, StripKind::Drive, StripKind::Shoulder];
        let side = |travel| kinds.map(|kind| Strip::plain(kind, travel, 3.0, false));
        let section = CrossSection { strips: [side(Travel::Backward), side(Travel::Forward)].concat() };
        let kind = |edge| marking(&section, edge, &Tags::new(), Some("DE"), false).get("type").map(str::to_owned);
        assert_eq!([2, 3, 4].map(kind).map(Option::unwrap), ["line_thin", "road_border", "line_thin"]);
    }

    #[test]
    fn a_narrow_road_has_no_line_in_the_middle() {
        let between = |width: f64, guessed: bool, text: &[(&str, &str)]| {
            let lane = |travel| Strip::plain(StripKind::Drive, travel, width, guessed);
            let section = CrossSection { strips: vec![lane(Travel::Backward), lane(Travel::Forward)] };
            let marking = marking(&section, 1, &text.iter().copied().collect(), Some("GB"), false);
            marking.get("subtype").or(marking.get("type")).map(str::to_owned)
        };
        assert_eq!(between(2.5, false, &[]).as_deref(), Some("virtual"));
        assert_eq!(between(2.5, true, &[]).as_deref(), Some("solid"), "a default width does not count");
        assert_eq!(between(2.75, false, &[]).as_deref(), Some("solid"));
        assert_eq!(between(2.5, false, &[("lane_markings", "yes")]).as_deref(), Some("solid"));
        assert_eq!(between(2.5, false, &[("divider", "dashed_line")]).as_deref(), Some("dashed"));
    }

    #[test]
    fn tags_decide_the_paint_in_the_middle() {
        let paint = |tags: &[(&str, &str)]| painted("<>", 0, tags, "FR");
        assert_eq!(paint(&[("overtaking", "yes")]), "dashed no");
        assert_eq!(paint(&[("overtaking", "no")]), "solid no");
        assert_eq!(paint(&[("overtaking", "forward")]), "solid_dashed no");
        assert_eq!(paint(&[("overtaking", "backward")]), "dashed_solid no");
        assert_eq!(painted("><", 0, &[("overtaking", "forward")], "GB"), "dashed_solid no");
        assert_eq!(paint(&[("divider", "dashed_line;solid_line")]), "dashed_solid no");
        assert_eq!(paint(&[("divider", "double_solid_line")]), "solid_solid no");
        assert_eq!(paint(&[("divider", "kerb"), ("lane_markings", "no")]), "virtual no");
    }

    #[test]
    fn lanes_of_one_direction_have_dashes_between_them() {
        assert_eq!(painted(">>", 0, &[], "US"), "dashed yes");
        assert_eq!(painted(">>", 0, &[("lane_markings", "no")], "US"), "virtual yes");
        let mut one_sided = section("<<");
        // Vehicles may not change from the outer lane to the inner lane on its left.
        one_sided.strips[1].change = [Some(false), None];
        let said = |inverted: bool| {
            let marking = marking(&one_sided, 2, &Tags::default(), None, inverted);
            let of = |key: &str| marking.get(key).unwrap_or("-").to_owned();
            ["subtype", "lane_change", "lane_change:left", "lane_change:right"].map(of).join(" ")
        };
        assert_eq!(said(false), "solid_dashed - yes no");
        assert_eq!(said(true), "dashed_solid - no yes", "seen in the direction of the lanes");
    }

    #[test]
    fn the_kerb_of_a_track_lies_between_track_and_lanes() {
        let strip = |kind| Strip::plain(kind, Travel::Forward, 1.0, false);
        let kinds = [StripKind::Bicycle, StripKind::Buffer, StripKind::Drive, StripKind::Drive, StripKind::Bicycle];
        let section = CrossSection { strips: kinds.map(strip).to_vec() };
        let kerbs = |tags: &[(&str, &str)]| {
            let tags: Tags = tags.iter().copied().collect();
            [true, false].map(|left| kerb_of_track(&section, &tags, left))
        };
        assert_eq!(kerbs(&[("cycleway:both", "track")]), [Some(2), Some(4)]);
        assert_eq!(kerbs(&[("cycleway:left", "track"), ("cycleway:right", "lane")]), [Some(2), None]);
        assert_eq!(kerbs(&[("cycleway", "lane"), ("cycleway:right:separation:left", "bump;kerb")]), [None, Some(4)]);
        assert_eq!(kerbs(&[("cycleway:both", "lane"), ("cycleway:both:separation", "flex_post")]), [None, None]);
        let turned = turned(&[("cycleway:right:separation:left", "kerb")].into_iter().collect());
        assert_eq!(turned.get("cycleway:left:separation:right"), Some("kerb"));
    }

    #[test]
    fn a_road_turned_around_is_painted_as_before() {
        let tags: Tags = [("overtaking", "forward"), ("divider", "solid_line;dashed_line")].into_iter().collect();
        let turned = turned(&tags);
        assert_eq!(
            (turned.get("overtaking"), turned.get("divider")),
            (Some("backward"), Some("dashed_line;solid_line"))
        );
        assert!(!alike(&tags, &turned) && alike(&tags, &tags));
    }
}
