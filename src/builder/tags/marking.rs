//! What is painted along the edges of a road's lanes: by its tags, the conventions of the country, and what the lanes are for.

use crate::lanelet::Attributes;
use crate::osm::{Tags, Text};

use super::cross_section::{CrossSection, Strip, StripKind, Travel};

/// Where the line between opposite directions is yellow.
const YELLOW: [&str; 16] =
    ["AR", "BR", "CA", "CL", "CN", "CO", "EC", "KR", "MX", "NO", "PE", "PR", "TH", "TW", "US", "UY"];
/// Where a solid line between opposite directions is painted twice, by manuals such as the MUTCD, § 3B.01.
const TWICE: [&str; 4] = ["CA", "MX", "PR", "US"];
/// A lane each way on less than this, metres, has no line in the middle: the MUTCD, § 3B.01, asks for one from 18 ft on, the
/// British and the Japanese manuals from 5.5 m on.
const LINE_FROM: f64 = 5.5;
/// Tags of OpenStreetMap that say what is painted.
const TAGS: [&str; 3] = ["divider", "overtaking", "lane_markings"];
/// What parts a bicycle lane from the others so that nobody drives over it.
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
/// Tags that tell of bicycles: of both sides, of the left and of the right.
const CYCLEWAYS: [&str; 4] = ["cycleway", "cycleway:both", "cycleway:left", "cycleway:right"];
/// Their value where bicycles use the bus lane.
pub const SHARES: &str = "share_busway";

/// A line of paint, left to right along the road.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Paint {
    /// Nothing is painted.
    Bare,
    /// One line.
    One(Stroke),
    /// Two lines side by side.
    Two([Stroke; 2]),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stroke {
    Solid,
    Dashed,
}

use Stroke::{Dashed, Solid};

impl Paint {
    /// Type and subtype in Lanelet2's words, of a line that runs along the road or, `inverted`, against it.
    fn names(self, inverted: bool) -> [&'static str; 2] {
        let subtype = match self {
            Self::Bare => return ["virtual", ""],
            Self::One(Solid) => "solid",
            Self::One(Dashed) | Self::Two([Dashed, Dashed]) => "dashed",
            Self::Two([Solid, Solid]) => "solid_solid",
            Self::Two([first, _]) if (first == Solid) != inverted => "solid_dashed",
            Self::Two(_) => "dashed_solid",
        };
        ["line_thin", subtype]
    }
}

/// Tags of the border at an edge of a cross-section: kerb, paint between lanes, or the edge of a lane. The border runs along
/// the road's line or, `inverted`, against it.
pub fn marking(section: &CrossSection, edge: usize, tags: &Tags, country: Option<&str>, inverted: bool) -> Attributes {
    let (kerb_left, kerb_right) = section.carriageway();
    if edge == kerb_left || edge == kerb_right {
        return Attributes::of(&[("type", "road_border")]);
    }
    if [true, false].iter().any(|&left| kerb_of_track(section, tags, left) == Some(edge)) {
        return Attributes::of(&[("type", "road_border"), ("lane_change", "no")]);
    }
    let (paint, change, opposed) = match lanes_beside(section, edge) {
        Some([left, right]) if same_way(left, right) => {
            let (paint, change) = between_lanes(may_change(left, right, left.kind == right.kind), tags);
            (paint, change, false)
        }
        Some(sides) => (between_directions(section, sides, tags, country), "no", true),
        None => (Paint::One(Solid), "no", false),
    };
    let [kind, subtype] = paint.names(inverted);
    let mut marking = Attributes::of(&[("type", kind)]);
    if paint != Paint::Bare {
        marking.push("subtype", subtype);
        if opposed && country.is_some_and(|country| YELLOW.contains(&country)) {
            marking.push("color", "yellow");
        }
    }
    marking.push("lane_change", change);
    marking
}

/// The edge at which a bicycle track on one side of a road begins, behind a kerb.
fn kerb_of_track(section: &CrossSection, tags: &Tags, left: bool) -> Option<usize> {
    let is = |i: usize, kind: StripKind| section.strips.get(i).is_some_and(|strip| strip.kind == kind);
    let mut bicycles = (0..section.strips.len()).filter(|&i| is(i, StripKind::Bicycle));
    let track = if left { bicycles.next() } else { bicycles.next_back() }?;
    if section.driven().any(|(i, _)| (i < track) == left) || !is_behind_kerb(tags, left) {
        return None;
    }
    // A verge between kerb and track belongs to the track.
    let verges = |edge: &usize| is(if left { *edge } else { *edge - 1 }, StripKind::Buffer);
    let step = |edge: usize| if left { edge + 1 } else { edge - 1 };
    let mut edge = if left { track + 1 } else { track };
    while edge > 0 && verges(&edge) {
        edge = step(edge);
    }
    Some(edge)
}

/// Whether bicycles on one side of a road ride behind a kerb, or what else holds cars back.
fn is_behind_kerb(tags: &Tags, left: bool) -> bool {
    let (side, toward_lanes) = if left { ("left", "right") } else { ("right", "left") };
    let of = |keys: &[[&str; 2]]| {
        let sides = [[":", side], [":", "both"], ["", ""]];
        let mut found = sides.into_iter().flat_map(|[colon, side]| {
            keys.iter().filter_map(move |[key, edge]| tags.get_joined(["cycleway", colon, side, key, edge]))
        });
        found.next()
    };
    let parted = of(&[[":separation:", toward_lanes], [":separation:", "both"], [":separation", ""]]);
    matches!(of(&[["", ""]]), Some("track" | "opposite_track"))
        || parted.is_some_and(|parted| parted.split(';').any(|one| BARRIERS.contains(&one.trim())))
}

/// Tags of the border between two lanes of an approach just before its stop line, where those lanes are changed only if
/// `change:lanes` says so; `None` where that makes no difference.
pub fn before_stop(section: &CrossSection, edge: usize, tags: &Tags, inverted: bool) -> Option<Attributes> {
    let [left, right] = lanes_beside(section, edge).filter(|[left, right]| same_way(left, right))?;
    let [rest, there] =
        [left.kind == right.kind, false].map(|usual| between_lanes(may_change(left, right, usual), tags));
    let (paint, change) = there;
    let [kind, subtype] = paint.names(inverted);
    let marking = Attributes::of(&[("type", kind), ("subtype", subtype), ("lane_change", change)]);
    (paint != rest.0).then_some(marking)
}

/// The lanes on the left and on the right of an edge; `None` where there are not two.
fn lanes_beside(section: &CrossSection, edge: usize) -> Option<[&Strip; 2]> {
    let driven = |i: usize| section.strips.get(i).filter(|s| matches!(s.kind, StripKind::Drive | StripKind::Bus));
    Some([driven(edge.checked_sub(1)?)?, driven(edge)?])
}

fn same_way(left: &Strip, right: &Strip) -> bool {
    left.travel == right.travel && left.travel != Travel::Both
}

/// Between lanes of one direction: dashed on the side from which one may change.
fn between_lanes(change: [bool; 2], tags: &Tags) -> (Paint, &'static str) {
    let paint = match change {
        [true, true] => Paint::One(Dashed),
        [true, false] => Paint::Two([Dashed, Solid]),
        [false, true] => Paint::Two([Solid, Dashed]),
        [false, false] => Paint::One(Solid),
    };
    let paint = if tags.is("lane_markings", "no") { Paint::Bare } else { paint };
    (paint, if change == [true, true] { "yes" } else { "no" })
}

/// Whether one may change from the left strip (along the line) to the right one, and back: by `change:lanes`, else as usual.
fn may_change(left: &Strip, right: &Strip, usual: bool) -> [bool; 2] {
    let [to_right, to_left] = match left.travel {
        Travel::Backward => [left.change[0], right.change[1]],
        _ => [left.change[1], right.change[0]],
    };
    [to_right.unwrap_or(usual), to_left.unwrap_or(usual)]
}

/// Between opposite directions: by `divider`, `overtaking` and `lane_markings`. Where these are silent nobody overtakes,
/// and a narrow road has no line; it is doubled where the country does so, and between directions of several lanes each.
fn between_directions(section: &CrossSection, sides: [&Strip; 2], tags: &Tags, country: Option<&str>) -> Paint {
    let twice = country.is_some_and(|country| TWICE.contains(&country));
    let solid = if twice { Paint::Two([Solid, Solid]) } else { Paint::One(Solid) };
    if let Some(paint) = tags.get("divider").and_then(divider) {
        return paint;
    }
    // Whoever may overtake has the dashed line on the own side.
    let overtaking = |travel: Travel| Paint::Two(sides.map(|side| if side.travel == travel { Dashed } else { Solid }));
    match (tags.get("overtaking"), tags.get("lane_markings")) {
        (Some("no"), _) => return solid,
        (Some("yes" | "both"), _) => return Paint::One(Dashed),
        (Some("forward"), _) => return overtaking(Travel::Forward),
        (Some("backward"), _) => return overtaking(Travel::Backward),
        (_, Some("no")) => return Paint::Bare,
        (_, None) if is_narrow(section) => return Paint::Bare,
        _ => {}
    }
    // A lane in the middle for those who turn off: entered over dashes, not crossed from it.
    if twice && sides.iter().any(|side| side.travel == Travel::Both) {
        return overtaking(Travel::Both);
    }
    let lanes = |travel: Travel| section.driven().filter(|(_, strip)| strip.travel == travel).count();
    let several = lanes(Travel::Forward) > 1 && lanes(Travel::Backward) > 1;
    if several { Paint::Two([Solid, Solid]) } else { solid }
}

/// Whether a road has a lane each way, known to be too narrow for a line between them.
fn is_narrow(section: &CrossSection) -> bool {
    let lanes: Vec<&Strip> = section.driven().map(|(_, strip)| strip).collect();
    let known = lanes.len() == 2 && lanes.iter().all(|lane| !lane.width_guessed);
    known && lanes.iter().map(|lane| lane.width).sum::<f64>() < LINE_FROM
}

/// The paint that `divider` names, left to right along the way.
fn divider(value: &str) -> Option<Paint> {
    let stroke = |name: &str| match name.trim() {
        "solid_line" => Some(Solid),
        "dashed_line" => Some(Dashed),
        _ => None,
    };
    match value.split_once(';') {
        Some((left, right)) => Some(Paint::Two([stroke(left)?, stroke(right)?])),
        None if value == "no" => Some(Paint::Bare),
        None if value == "double_solid_line" => Some(Paint::Two([Solid, Solid])),
        None => Some(Paint::One(stroke(value)?)),
    }
}

/// Whether two roads are painted alike, and their bus lanes open to the same, as far as their tags tell.
pub fn alike(a: &Tags, b: &Tags) -> bool {
    TAGS.iter().all(|key| a.get(key) == b.get(key))
        && CYCLEWAYS.iter().all(|key| a.is(key, SHARES) == b.is(key, SHARES))
        && [true, false].iter().all(|&left| is_behind_kerb(a, left) == is_behind_kerb(b, left))
}

/// The tags of a road whose line is turned around.
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

    /// A road of driven lanes between sidewalks, `<` against its line and `>` along it, `=` both ways, left to right.
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

    /// Subtype (type, if there is none), colour and `lane_change` at the right edge of a lane.
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
    fn a_narrow_road_has_no_line_in_the_middle() {
        let between = |width: f64, guessed: bool, text: &[(&str, &str)]| {
            let lane = |travel| Strip::plain(StripKind::Drive, travel, width, guessed);
            let section = CrossSection { strips: vec![lane(Travel::Backward), lane(Travel::Forward)] };
            let marking = marking(&section, 1, &text.iter().copied().collect(), Some("GB"), false);
            marking.get("subtype").or(marking.get("type")).map(str::to_owned)
        };
        assert_eq!(between(2.5, false, &[]).as_deref(), Some("virtual"));
        assert_eq!(between(2.5, true, &[]).as_deref(), Some("solid"), "a guess says nothing");
        assert_eq!(between(2.75, false, &[]).as_deref(), Some("solid"));
        assert_eq!(between(2.5, false, &[("lane_markings", "yes")]).as_deref(), Some("solid"));
        assert_eq!(between(2.5, false, &[("divider", "dashed_line")]).as_deref(), Some("dashed"));
    }

    #[test]
    fn tags_say_what_is_painted_in_the_middle() {
        let said = |tags: &[(&str, &str)]| painted("<>", 0, tags, "FR");
        assert_eq!(said(&[("overtaking", "yes")]), "dashed no");
        assert_eq!(said(&[("overtaking", "no")]), "solid no");
        assert_eq!(said(&[("overtaking", "forward")]), "solid_dashed no");
        assert_eq!(said(&[("overtaking", "backward")]), "dashed_solid no");
        assert_eq!(painted("><", 0, &[("overtaking", "forward")], "GB"), "dashed_solid no");
        assert_eq!(said(&[("divider", "dashed_line;solid_line")]), "dashed_solid no");
        assert_eq!(said(&[("divider", "double_solid_line")]), "solid_solid no");
        assert_eq!(said(&[("divider", "kerb"), ("lane_markings", "no")]), "virtual no");
    }

    #[test]
    fn lanes_of_one_direction_are_crossed_over_dashes() {
        assert_eq!(painted(">>", 0, &[], "US"), "dashed yes");
        assert_eq!(painted(">>", 0, &[("lane_markings", "no")], "US"), "virtual yes");
        let mut one_sided = section("<<");
        // Of the outer lane, left along the line, one may not change to the inner one, which lies to its left.
        one_sided.strips[1].change = [Some(false), None];
        let subtype = |inverted: bool| {
            let marking = marking(&one_sided, 2, &Tags::default(), None, inverted);
            marking.get("subtype").map(str::to_owned)
        };
        assert_eq!(subtype(false).as_deref(), Some("solid_dashed"));
        assert_eq!(subtype(true).as_deref(), Some("dashed_solid"), "seen in the direction of the lanes");
    }

    #[test]
    fn the_kerb_of_a_track_lies_toward_the_lanes() {
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
