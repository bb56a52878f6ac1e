//! Every group of tags, each driving on the right and, mirrored, on the left.

use crate::builder::tags::road_class::{DrivingSide, RoadClass};
use crate::diagnostic::Finding;
use crate::osm::Tags;

use super::*;

mod spellings;

/// The tables of widths in `docs/lanes.md`.
fn width_tables() -> String {
    use super::sides::*;
    let usual = Defaults::of(RoadClass::Residential);
    let mut text = String::from("| class | lane | least lane |\n|---|---|---|\n");
    for (name, class) in [
        ("motorway", RoadClass::Motorway),
        ("trunk", RoadClass::Trunk),
        ("primary", RoadClass::Primary),
        ("secondary", RoadClass::Secondary),
        ("tertiary", RoadClass::Tertiary),
        ("unclassified, road", RoadClass::Unclassified),
        ("residential", RoadClass::Residential),
        ("living_street", RoadClass::LivingStreet),
        ("service", RoadClass::Service),
        ("track", RoadClass::Track),
    ] {
        text += &format!("| {name} | {} m | {} m |\n", Defaults::of(class).lane, minimum_lane_width(class));
    }
    text += "\n| strip | default |\n|---|---|\n";
    for (name, width) in [
        ("bicycle lane", usual.bicycle_lane),
        ("bicycle track", usual.bicycle_track),
        ("bicycle lane ridden both ways", usual.bicycle_lane + BOTH_WAYS),
        ("bicycle track ridden both ways", usual.bicycle_track + BOTH_WAYS),
        ("buffer beside a bicycle lane", BUFFER),
        ("parking, parallel", usual.parking),
        ("parking, diagonal", PARKING_DIAGONAL),
        ("parking, perpendicular", PARKING_PERPENDICULAR),
        ("shoulder of a motorway or trunk road", Defaults::of(RoadClass::Trunk).shoulder),
        ("shoulder elsewhere", usual.shoulder),
        ("painted strip for people on foot", usual.pedestrian_lane),
        ("sidewalk", usual.sidewalk),
    ] {
        text += &format!("| {name} | {width} m |\n");
    }
    text
}

#[test]
fn the_page_about_lanes_has_these_widths() {
    let page = include_str!("../../../../docs/lanes.md");
    let tables = width_tables();
    assert!(page.contains(&tables), "put these tables into docs/lanes.md:\n{tables}");
}

/// Tags as `key=value` words separated by blanks.
fn tags(text: &str) -> Tags {
    text.split_whitespace().filter_map(|word| word.split_once('=')).collect()
}

fn read(tags: &Tags, class: RoadClass, side: DrivingSide) -> (SectionReading, Vec<Finding>) {
    let mut notes = Vec::new();
    let facts = WayFacts {
        way: 1,
        tags,
        class,
        link: false,
        bus_road: false,
        side,
        usual: Defaults::of(class),
        continued: None,
    };
    let layout = layout(&facts, &mut notes);
    (layout, notes)
}

/// A strip as letter and direction: `D>` is a driving lane with the way.
fn drawn(strips: &[Strip]) -> String {
    let word = |strip: &Strip| {
        let kind = match strip.kind {
            StripKind::Drive => 'D',
            StripKind::Bus => 'B',
            StripKind::Bicycle => 'C',
            StripKind::Parking => 'P',
            StripKind::Shoulder => 'S',
            StripKind::Sidewalk => 'W',
            StripKind::Pedestrian => 'F',
            StripKind::Buffer => '_',
        };
        let travel = match strip.travel {
            Travel::Forward => '>',
            Travel::Backward => '<',
            Travel::Both => '=',
        };
        format!("{kind}{travel}")
    };
    strips.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// The tags of the mirror image of a road.
fn mirrored(tags: &Tags) -> Tags {
    let swap = |text: &str| text.replace("left", "\0").replace("right", "left").replace('\0', "right");
    let list = |value: &str| value.split('|').rev().collect::<Vec<_>>().join("|");
    tags.iter().map(|(k, v)| (swap(k), swap(&list(v)))).collect()
}

/// Checks a residential road driving on the right, and its mirror image driving on the left.
#[track_caller]
fn expect(text: &str, expected: &str) -> SectionReading {
    let tags = tags(text);
    let (layout, _) = read(&tags, RoadClass::Residential, DrivingSide::Right);
    assert_eq!(drawn(&layout.section.strips), expected, "{text}");
    let (mirror, _) = read(&mirrored(&tags), RoadClass::Residential, DrivingSide::Left);
    let mut strips = mirror.section.strips;
    strips.reverse();
    assert_eq!(drawn(&strips), expected, "{text}, mirrored");
    for (a, b) in layout.section.strips.iter().zip(&strips) {
        assert_eq!(a.width, b.width, "{text}, mirrored");
        assert_eq!([a.change[1], a.change[0]], b.change, "{text}, mirrored");
    }
    assert!((layout.shift + mirror.shift).abs() < 1e-9, "{text}: shift {} and {}", layout.shift, mirror.shift);
    layout
}

fn slugs(text: &str) -> Vec<&'static str> {
    let (_, notes) = read(&tags(text), RoadClass::Residential, DrivingSide::Right);
    notes.iter().map(|note| note.fault).collect()
}

#[test]
fn number_of_lanes() {
    expect("", "D< D>");
    expect("lanes=2", "D< D>");
    expect("lanes=4", "D< D< D> D>");
    expect("lanes=3", "D< D> D>");
    expect("lanes=3 lanes:backward=2", "D< D< D>");
    expect("lanes:forward=2 lanes:backward=1", "D< D> D>");
    expect("lanes=5 lanes:both_ways=1", "D< D< D= D> D>");
    expect("lanes=3 lanes:forward=1 lanes:backward=1 lanes:both_ways=1", "D< D= D>");
    expect("lanes=1", "D=");
    expect("lanes=1 width=6", "D< D>");
    expect("width=3.5", "D=");
    expect("service=driveway", "D=");
    expect("width=6 parking:right=lane", "D= P>");
    expect("lanes=1.5", "D=");
    assert_eq!(slugs(""), ["lanes-guessed", "width-guessed"]);
    assert_eq!(slugs("lanes=2 width=6"), Vec::<&str>::new());
    assert_eq!(slugs("lanes=3 width=9"), ["lanes-guessed"]);
}

#[test]
fn contradictions_follow_the_more_specific_tag() {
    expect("lanes=2 lanes:forward=2 lanes:backward=1", "D< D> D>");
    expect("lanes=2 lanes:forward=2", "D< D> D>");
    expect("lanes=2 lanes:forward=1 turn:lanes:forward=left|through|right", "D< D>");
    expect("lanes=999999999999999999999 oneway=yes", &["D>"; 24].join(" "));
    expect("lanes=-3", "D< D>");
    expect("lanes=nan", "D< D>");
    expect("oneway=yes access:lanes=no|no", "D> D>");
    assert!(slugs("lanes=2 lanes:forward=2 lanes:backward=1").contains(&"lanes-contradict"));
    assert!(slugs("lanes=2 lanes:forward=1 turn:lanes:forward=left|through|right").contains(&"lanes-contradict"));
    assert!(slugs("oneway=yes access:lanes=no|no").contains(&"lanes-contradict"));
}

#[test]
fn one_way() {
    expect("oneway=yes", "D>");
    expect("oneway=yes lanes=2", "D> D>");
    expect("oneway=-1 lanes=2", "D< D<");
    expect("oneway=alternating lanes=2", "D= D=");
    expect("junction=roundabout", "D>");
    expect("junction=roundabout oneway=no", "D< D>");
    let (layout, _) = read(&Tags::new(), RoadClass::Motorway, DrivingSide::Left);
    assert_eq!(drawn(&layout.section.strips), "D> D>");
}

#[test]
fn arrows_and_changes() {
    let road =
        expect("oneway=yes turn:lanes=left|through;slight_right|none| change:lanes=not_left|yes|no|", "D> D> D> D>");
    let strips = &road.section.strips;
    assert_eq!(strips[0].arrows, Arrows::LEFT);
    assert_eq!(strips[1].arrows, Arrows::THROUGH.and(Arrows::SLIGHT_RIGHT));
    assert!(strips[2].arrows.is_none() && strips[3].arrows.is_none());
    assert_eq!(strips[0].change, [Some(false), Some(true)]);
    assert_eq!(strips[1].change, [Some(true); 2]);
    assert_eq!(strips[2].change, [Some(false); 2]);
    assert_eq!(strips[3].change, [None; 2]);
    // The lists of backward lanes are in their own direction of travel.
    let road = expect("lanes=4 turn:lanes:backward=left|right turn:lanes:forward=through|right", "D< D< D> D>");
    let strips = &road.section.strips;
    assert_eq!([strips[0].arrows, strips[1].arrows], [Arrows::RIGHT, Arrows::LEFT]);
    assert_eq!([strips[2].arrows, strips[3].arrows], [Arrows::THROUGH, Arrows::RIGHT]);
    expect("lanes=4 turn:lanes:forward=left|through|right", "D< D> D> D>");
    expect("lanes:both_ways=1 turn:lanes:both_ways=left", "D< D= D>");
}

#[test]
fn arrows_that_cross_were_written_from_right_to_left() {
    let read = |tags: &str| {
        let road = expect(&format!("oneway=yes {tags}"), "D> D>");
        [road.section.strips[0].arrows, road.section.strips[1].arrows]
    };
    let both = Arrows::THROUGH.and(Arrows::RIGHT);
    assert_eq!(read("turn:lanes=through;right|left"), [Arrows::LEFT, both]);
    assert!(slugs("oneway=yes turn:lanes=through;right|left").contains(&"lanes-contradict"));
    assert_eq!(read("turn:lanes=through;right|right"), [both, Arrows::RIGHT]);
    assert_eq!(read("turn:lanes=right|through;left"), [Arrows::THROUGH.and(Arrows::LEFT), Arrows::RIGHT]);
    // Beside a bus lane on the near side, a turn across it is what people drive.
    let road = expect("oneway=yes turn:lanes=right|through bus:lanes=|designated", "D> B>");
    assert_eq!(road.section.strips[0].arrows, Arrows::RIGHT);
}

#[test]
fn widths() {
    let widths = |text: &str, expected: &str| -> Vec<f64> {
        expect(text, expected).section.strips.iter().map(|s| (s.width * 100.0).round() / 100.0).collect()
    };
    assert_eq!(widths("lanes=2", "D< D>"), [3.0, 3.0]);
    assert_eq!(widths("lanes=2 width=7", "D< D>"), [3.5, 3.5]);
    assert_eq!(widths("lanes=2 width=20'", "D< D>"), [3.05, 3.05]);
    assert_eq!(widths("lanes=2 width=4", "D< D>"), [2.4, 2.4]);
    assert_eq!(widths("lanes=2 width=11", "S< D< D> S>"), [1.75, 3.75, 3.75, 1.75]);
    assert_eq!(widths("lanes=2 width=80", "D< D>"), [3.75, 3.75]);
    assert_eq!(widths("lanes=2 width=11 parking:both=lane", "P< D< D> P>"), [2.2, 3.3, 3.3, 2.2]);
    assert_eq!(widths("lanes=2 width:lanes:forward=3.2 width:lanes:backward=2.8", "D< D>"), [2.8, 3.2]);
    assert_eq!(widths("lanes=3 width=9 width:lanes:forward=|2.5 lanes:backward=1", "D< D> D>"), [3.25, 3.25, 2.5]);
    assert_eq!(widths("oneway=yes lane_width=3,4", "D>"), [3.4]);
    assert_eq!(widths("lanes=1 width=4.5", "D="), [4.5]);
    assert!(slugs("lanes=2 width=4").contains(&"width-implausible"));
    assert!(slugs("lanes=2 width=80").contains(&"width-implausible"));
    let est = expect("lanes=2 est_width=7", "D< D>");
    assert!(est.section.strips.iter().all(|s| s.width == 3.5 && s.width_guessed));
}

#[test]
fn bicycle_lanes() {
    expect("cycleway=lane", "C< D< D> C>");
    expect("cycleway:right=lane", "D< D> C>");
    expect("cycleway:left=track cycleway:right=lane", "C< D< D> C>");
    expect("cycleway:both=no cycleway=separate", "D< D>");
    expect("oneway=yes cycleway=lane", "D> C>");
    expect("oneway=yes cycleway=opposite_lane", "C< D>");
    expect("oneway=yes cycleway:left=lane oneway:bicycle=no", "C< D>");
    expect("oneway=yes cycleway:left=lane", "C> D>");
    expect("oneway=-1 cycleway=lane", "C< D<");
    expect("cycleway:right=track cycleway:right:oneway=no", "D< D> C=");
    expect("cycleway:left=lane cycleway:left:oneway=no", "C= D< D>");
    expect("cycleway=track cycleway:oneway=no", "C= D< D> C=");
    expect("cycleway:right=lane cycleway:right:oneway=-1", "D< D> C<");
    expect("cycleway:left=lane cycleway:left:oneway=yes", "C> D< D>");
    expect("cycleway:both=lane cycleway:both:oneway=yes", "C< D< D> C>");
    expect("oneway=yes cycleway:right=lane cycleway:right:oneway=-1", "D> C<");
    expect("oneway=yes cycleway:both=lane oneway:bicycle=no", "C< D> C>");
    expect("oneway=yes cycleway:right=track oneway:bicycle=no", "D> C=");
    expect("oneway=yes cycleway:right=lane oneway:bicycle=no", "D> C>");
    expect("oneway=yes cycleway:left=opposite_lane cycleway:left:oneway=yes", "C< D>");
    expect("cycleway:right=lane cycleway:right:buffer:left=0.7", "D< D> _> C>");
    expect("cycleway=shared_lane", "D< D>");
    let road = expect("cycleway:right=lane cycleway:right:width=1.8", "D< D> C>");
    assert_eq!(road.section.strips[2].width, 1.8);
    // `bicycle:lanes` has the lane already; `cycleway` does not repeat it.
    expect(
        "oneway=yes lanes=2 cycleway:right=lane vehicle:lanes=||no bicycle:lanes=||designated turn:lanes=left|through|",
        "D> D> C>",
    );
}

#[test]
fn parking() {
    expect("parking:both=lane", "P< D< D> P>");
    expect("parking:right=street_side parking:left=no", "D< D> P>");
    expect("parking:both=separate", "D< D>");
    expect("parking:both=on_kerb", "D< D>");
    expect("parking:lane:both=parallel", "P< D< D> P>");
    expect("parking:lane:right=diagonal parking:lane:left=no_parking", "D< D> P>");
    expect("parking:lane:right=parallel parking:lane:right:parallel=on_kerb", "D< D>");
    let road = expect("parking:right=lane parking:right:orientation=perpendicular", "D< D> P>");
    assert_eq!(road.section.strips[2].width, 5.0);
    let road = expect("parking:right=half_on_kerb", "D< D> P>");
    assert_eq!(road.section.strips[2].width, 1.1);
}

#[test]
fn sidewalks_and_shoulders() {
    expect("sidewalk=both", "W< D< D> W>");
    expect("sidewalk=right", "D< D> W>");
    expect("sidewalk=separate", "D< D>");
    expect("sidewalk:left=yes sidewalk:right=separate", "W< D< D>");
    expect("sidewalk:both=no sidewalk=both", "D< D>");
    expect("oneway=yes shoulder=yes", "D> S>");
    expect("oneway=yes shoulder=left", "S> D>");
    expect("shoulder:both=yes shoulder:right:width=2", "S< D< D> S>");
    expect("pedestrian_lane=both", "F< D< D> F>");
    expect("pedestrian_lane:right=yes cycleway:right=lane", "D< D> C> F>");
    expect("sidewalk=both cycleway:right=track parking:right=lane shoulder=right", "W< D< D> P> S> C> W>");
}

#[test]
fn bus_lanes() {
    expect("lanes=4 busway=lane", "B< D< D> B>");
    expect("lanes=3 lanes:forward=2 busway:right=lane", "D< D> B>");
    expect("oneway=yes lanes=2 busway=lane", "D> B>");
    expect("oneway=yes lanes=2 busway:left=lane", "B> D>");
    expect("oneway=yes lanes=1 busway=opposite_lane", "B< D>");
    expect("oneway=yes lanes=3 lanes:bus=1", "D> D> B>");
    expect("lanes=4 lanes:psv:backward=1", "B< D< D> D>");
    // Besides the other lanes where these would be too few, or `lanes` is the sum.
    expect("lanes=4 lanes:forward=1 lanes:backward=1 lanes:psv:forward=1 lanes:psv:backward=1", "B< D< D> B>");
    expect("lanes=4 lanes:forward=2 lanes:backward=1 lanes:bus:forward=1", "D< D> D> B>");
    expect("lanes=3 lanes:forward=2 lanes:backward=1 lanes:bus:forward=1", "D< D> B>");
    expect("oneway=yes lanes=1 lanes:psv=1", "D> B>");
    expect("oneway=yes bus:lanes=|designated", "D> B>");
    expect("oneway=yes psv:lanes=yes|| access:lanes=no||", "B> D> D>");
    expect("lanes=3 bus:lanes:forward=|designated access:lanes:forward=|no", "D< D> B>");
    expect("oneway=yes lanes=1 busway=lane", "D> B>");
    // Some mappers count bus lanes in `lanes`, some do not.
    let each_way = "bus:lanes:forward=yes|yes|designated access:lanes:forward=||no \
                    bus:lanes:backward=yes|yes|designated access:lanes:backward=||no";
    expect(&format!("lanes=5 lanes:forward=2 lanes:backward=2 lanes:both_ways=1 {each_way}"), "B< D< D< D= D> D> B>");
    expect(&format!("lanes=6 {each_way}"), "B< D< D< D> D> B>");
    assert_eq!(
        slugs(&format!("width=21 lanes=5 lanes:forward=2 lanes:backward=2 lanes:both_ways=1 {each_way}")),
        [""; 0]
    );
}

#[test]
fn access_by_direction() {
    for key in ["motorcar", "motor_vehicle", "vehicle", "access"] {
        expect(&format!("{key}:backward=no"), "D>");
        expect(&format!("{key}:forward=no"), "D<");
        expect(&format!("{key}=no {key}:forward=yes"), "D>");
        expect(&format!("{key}=yes {key}:backward=no lanes=3"), "_< D> D>");
    }
    expect("access:backward=no motorcar=yes", "D< D>");
    expect("vehicle=no motorcar:backward=yes", "D<");
    expect("motor_vehicle:backward=no lanes=1", "D>");
    expect("motor_vehicle:backward=destination", "D< D>");
    expect("motor_vehicle:backward=agricultural;forestry", "D>");
    expect("motor_vehicle:backward=designated", "D< D>");
    expect("motor_vehicle:backward=no bus:backward=yes", "B< D>");
    expect("motor_vehicle:forward=no psv:forward=designated lanes=3 lanes:forward=1", "D< D< B>");
    expect("motor_vehicle:backward=no bus:backward=yes busway:left=lane", "B< D>");
    expect("oneway=yes motor_vehicle:backward=yes", "D>");
    expect("oneway=alternating", "D=");
    expect("oneway=yes oneway:motorcar=no", "D< D>");
}

#[test]
fn buses_against_a_one_way_road() {
    let one_way = |tags: &str, expected: &str| {
        expect(&format!("oneway=yes {tags}"), expected);
        // The same road, drawn the other way around.
        let turned = tags.replace("backward", "\u{1}").replace("forward", "backward").replace('\u{1}', "forward");
        let turned = turned.replace("left", "\u{1}").replace("right", "left").replace('\u{1}', "right");
        let turned = turned.replace(":oneway=-1", ":oneway=yes");
        let words: Vec<&str> = expected.split(' ').rev().collect();
        let seen = words.join(" ").replace('>', "\u{1}").replace('<', ">").replace('\u{1}', "<");
        expect(&format!("oneway=-1 {turned}"), &seen);
    };
    let counts = "lanes=3 lanes:forward=2 lanes:backward=1";
    one_way(&format!("oneway:bus=no {counts}"), "B< D> D>");
    one_way(&format!("oneway:psv=no {counts} bus:lanes:backward=designated access:lanes:backward=no"), "B< D> D>");
    one_way(&format!("{counts} psv:lanes:backward=designated vehicle:lanes:backward=no"), "B< D> D>");
    one_way(&format!("{counts} bus:lanes:backward=yes access:lanes:backward=no"), "B< D> D>");
    one_way("lanes=3 lanes:bus:backward=1", "B< D> D>");
    one_way("lanes=3 lanes:psv:backward=1 oneway:psv=no", "B< D> D>");
    one_way("lanes=3 oneway:psv=no psv=opposite_lane", "B< D> D>");
    one_way("lanes=2 busway=opposite_lane", "B< D>");
    one_way("lanes=2 lanes:backward=1 oneway:bus=no busway:left=opposite_lane", "B< D>");
    one_way("lanes=2 busway:left=lane busway:left:oneway=-1", "B< D>");
    one_way("lanes=2 busway:left=lane oneway:bus=no", "B< D>");
    one_way("lanes=3 busway:left=opposite_lane busway:right=lane", "B< D> B>");
    one_way("lanes=3 lanes:bus=2 oneway:bus=no", "B< D> B>");
    one_way("oneway:bus=no lanes=2", "B< D>");
    one_way("bus:backward=yes", "B< D>");
    one_way("oneway:bus=no lanes=1", "D>");
    one_way("lanes=2 lanes:forward=2 busway=opposite_lane", "B< D> D>");
    one_way("lanes=1 bicycle:lanes:backward=designated vehicle:lanes:backward=no", "C< D>");
    one_way("lanes=2 lanes:backward=1", "D> D>");
    let both = "bus:lanes:forward=yes|yes|designated bus:lanes:backward=yes|yes|designated bus:backward=designated";
    one_way(&format!("lanes=3 {both} access:lanes:backward=yes|yes|no"), "D> D> B>");
    assert!(slugs(&format!("oneway=yes lanes=3 {both}")).contains(&"lanes-contradict"));
    assert!(slugs("oneway=yes lanes=2 lanes:backward=1").contains(&"lanes-contradict"));
    assert!(slugs("oneway=yes oneway:bus=no lanes=1").contains(&"lanes-guessed"));
}

#[test]
fn lists_of_another_length_keep_the_bus_lane_at_the_edge() {
    expect(
        "lanes=4 lanes:forward=3 lanes:backward=1 vehicle:lanes:forward=yes|yes|no bus:lanes:forward=yes|yes|designated \
         cycleway:right=share_busway",
        "D< D> D> B>",
    );
    expect("oneway=yes lanes=2 bus:lanes=yes|yes|yes|designated", "D> B>");
}

#[test]
fn a_bicycle_lane_between_lanes_is_one() {
    let lists = "oneway=yes lanes=2 bicycle:lanes=yes|designated|yes vehicle:lanes=yes|no|yes";
    expect(&format!("{lists} cycleway:right=lane"), "D> C> D>");
    expect(&format!("{lists} cycleway:left=lane cycleway:right=lane"), "C> D> C> D>");
}

#[test]
fn a_bus_lane_on_one_side_is_one_of_the_lanes() {
    expect("lanes=3 busway:left=lane", "B< D< D>");
    expect("lanes=3 busway:right=lane", "D< D> B>");
    expect("lanes=5 busway:left=lane", "B< D< D< D> D>");
}

#[test]
fn lists_without_a_direction_name_all_lanes_of_a_two_way_road() {
    expect("lanes=2 bus:lanes=|designated", "D< B>");
    expect("lanes=4 psv:lanes=|yes|designated|no", "D< D< B> D>");
    expect("lanes=4 bus:lanes=designated|||designated", "B< D< D> B>");
    expect("lanes=2 busway=opposite_lane", "B< D>");
    expect("lanes=2 centre_turn_lane=yes", "D< D= D>");
}

#[test]
fn each_lane_may_have_its_limit() {
    let road = expect("oneway=yes lanes=3 maxspeed:lanes=100|100|80", "D> D> D>");
    assert_eq!(road.section.strips.iter().map(|strip| strip.speed).collect::<Vec<_>>(), [100.0, 100.0, 80.0].map(Some));
}

#[test]
fn the_line_lies_in_the_middle_of_the_carriageway() {
    assert_eq!(expect("lanes=2", "D< D>").shift, 0.0);
    let near = |text: &str, expected: &str, shift: f64| {
        let road = expect(text, expected);
        assert!((road.shift - shift).abs() < 1e-9, "{text}: {}", road.shift);
    };
    // A sidewalk on the right moves the middle of the section to the right.
    near("sidewalk=right", "D< D> W>", -0.75);
    near("parking:left=street_side", "P< D< D>", 1.1);
    near("parking:left=lane", "P< D< D>", 0.0);
}

#[test]
fn placement_moves_the_line() {
    // Lanes are counted from the left on either side, so that a mirror image has other numbers.
    let near = |text: &str, side: DrivingSide, shift: f64| {
        let (road, _) = read(&tags(text), RoadClass::Residential, side);
        assert!((road.shift - shift).abs() < 1e-9, "{text}: {}", road.shift);
    };
    let (left, right) = (DrivingSide::Left, DrivingSide::Right);
    for side in [left, right] {
        near("oneway=yes lanes=3 placement=right_of:1", side, -1.5);
        near("oneway=yes lanes=3 placement=left_of:1", side, -4.5);
        near("oneway=yes lanes=3 placement=middle_of:2", side, 0.0);
        near("oneway=-1 lanes=3 placement=right_of:1", side, 1.5);
        near("oneway=yes lanes=3 placement=transition", side, 0.0);
    }
    near("lanes=3 lanes:forward=2 placement:forward=left_of:1", right, -1.5);
    near("lanes=3 lanes:backward=2 placement:backward=left_of:1", right, 1.5);
    near("lanes=3 lanes:forward=2 placement:forward=right_of:2", left, 1.5);
    assert!(slugs("oneway=yes lanes=3 placement=right_of:9").contains(&"placement-unread"));
}
