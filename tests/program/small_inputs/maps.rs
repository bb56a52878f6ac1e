//! Small Lanelet2 maps, of which the whole work lies in one place.

use std::f64::consts::TAU;

use super::Kind;
use super::sketch::{Place, Sketch};

/// The kinds; `size` lanelets or so.
pub const KINDS: &[Kind] = &[
    Kind { name: "areas over lanelets", size: 60, draw: areas_over_lanelets },
    Kind { name: "long bound", size: 5_000, draw: long_bound },
    Kind { name: "jagged bound", size: 2_000, draw: jagged_bound },
    Kind { name: "star polygon", size: 60, draw: star_polygon },
    Kind { name: "chain", size: 300, draw: chain },
    Kind { name: "wide road", size: 200, draw: wide_road },
    Kind { name: "common bound", size: 200, draw: common_bound },
    Kind { name: "one over the other", size: 60, draw: one_over_the_other },
    Kind { name: "lattice", size: 60, draw: lattice },
    Kind { name: "crosswalks", size: 100, draw: crosswalks },
    Kind { name: "stop lines", size: 200, draw: stop_lines },
    Kind { name: "lights", size: 200, draw: lights },
    Kind { name: "light of many", size: 200, draw: light_of_many },
    Kind { name: "regulatory elements", size: 300, draw: regulatory_elements },
    Kind { name: "speed limits", size: 300, draw: speed_limits },
    Kind { name: "parking", size: 100, draw: parking },
    Kind { name: "many tags", size: 2_000, draw: many_tags },
    Kind { name: "tiny lanelets", size: 150, draw: tiny_lanelets },
    Kind { name: "nested relations", size: 500, draw: nested_relations },
    Kind { name: "ring of relations", size: 500, draw: ring_of_relations },
    Kind { name: "same id", size: 500, draw: same_id },
    Kind { name: "no area", size: 100, draw: no_area },
    Kind { name: "missing members", size: 500, draw: missing_members },
    Kind { name: "conflicts", size: 60, draw: conflicts },
    Kind { name: "borders", size: 300, draw: borders },
];

/// Kinds of which twice as many parts take more than two and a half times as long; these sizes are within the bounds.
pub const STEEP: &[Kind] = &[
    Kind { name: "shared node", size: 200, draw: shared_node },
    Kind { name: "right of way", size: 600, draw: right_of_way },
    Kind { name: "one start", size: 100, draw: one_start },
    Kind { name: "fan", size: 150, draw: fan },
    Kind { name: "near nodes", size: 300, draw: near_nodes },
    Kind { name: "nearly joined", size: 200, draw: nearly_joined },
    Kind { name: "nodes at one place", size: 200, draw: nodes_at_one_place },
    Kind { name: "mutual yields", size: 60, draw: mutual_yields },
    Kind { name: "hub", size: 100, draw: hub },
    Kind { name: "heap", size: 150, draw: heap },
    Kind { name: "both directions", size: 150, draw: both_directions },
    Kind { name: "many into many", size: 350, draw: many_into_many },
    Kind { name: "copies", size: 1_500, draw: copies },
    Kind { name: "tangled areas", size: 4_000, draw: tangled_areas },
    Kind { name: "lanes in all directions", size: 500, draw: lanes_in_all_directions },
    Kind { name: "bound through one node", size: 2_000, draw: bound_through_one_node },
    Kind { name: "bound of many", size: 300, draw: bound_of_many },
    Kind { name: "to and fro", size: 5_000, draw: to_and_fro },
];

const THIN: &[(&str, &str)] = &[("type", "line_thin"), ("subtype", "solid")];
const BORDER: &[(&str, &str)] = &[("type", "road_border")];
const ROAD: &[(&str, &str)] = &[
    ("type", "lanelet"),
    ("subtype", "road"),
    ("location", "urban"),
    ("one_way", "yes"),
    ("speed_limit", "40"),
    ("participant:vehicle", "yes"),
];

fn around(angle: f64, radius: f64) -> Place {
    (radius * angle.cos(), radius * angle.sin())
}

fn turn(i: usize, of: usize) -> f64 {
    TAU * i as f64 / of as f64
}

/// A lanelet between two ways, with regulatory elements.
fn between(out: &mut Sketch, left: i64, right: i64, elements: &[i64]) -> i64 {
    let mut members = vec![("way", "left", left), ("way", "right", right)];
    members.extend(elements.iter().map(|&id| ("relation", "regulatory_element", id)));
    out.relation(&members, ROAD)
}

/// A lanelet between two lines with points of their own.
fn lanelet(out: &mut Sketch, left: &[Place], right: &[Place]) -> i64 {
    let (left, right) = (out.line(left, THIN), out.line(right, THIN));
    between(out, left, right, &[])
}

/// A straight lanelet three metres wide.
fn straight(out: &mut Sketch, from: Place, to: Place, elements: &[i64]) -> i64 {
    let (east, north) = (to.0 - from.0, to.1 - from.1);
    let length = east.hypot(north);
    let (east, north) = (1.5 * east / length, 1.5 * north / length);
    let sides = [1.0, -1.0].map(|side| {
        let at = |place: Place| (place.0 - side * north, place.1 + side * east);
        out.line(&[at(from), at(to)], BORDER)
    });
    between(out, sides[0], sides[1], elements)
}

fn rule(out: &mut Sketch, subtype: &str, members: &[(&str, &str, i64)]) -> i64 {
    out.relation(members, &[("type", "regulatory_element"), ("subtype", subtype)])
}

/// An area with a type and corners of its own.
fn area(out: &mut Sketch, kind: &str, corners: &[Place]) -> i64 {
    let mut nodes: Vec<i64> = corners.iter().map(|&place| out.node(place)).collect();
    nodes.extend(nodes.first().copied());
    out.way(&nodes, &[("type", kind), ("area", "yes")])
}

fn square(around: Place, half: f64) -> [Place; 4] {
    [(-half, -half), (half, -half), (half, half), (-half, half)].map(|(x, y)| (around.0 + x, around.1 + y))
}

/// The bounds of all lanelets meet in one node.
fn shared_node(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    for i in 0..size {
        let ways = [0, 1].map(|side| {
            let end = out.node(around(turn(2 * i + side, 2 * size), 50.0));
            out.way(&[middle, end], THIN)
        });
        between(out, ways[1], ways[0], &[]);
    }
}

/// Half of the lanelets have the right of way over the others, said once.
fn right_of_way(out: &mut Sketch, size: usize) {
    let element = out.next_id() + 7 * size as i64;
    let mut members = Vec::new();
    for i in 0..size {
        let across = 4.0 * (i / 2) as f64;
        let length = 2.0 * size as f64 + 20.0;
        let id = if i % 2 == 0 {
            straight(out, (-20.0, across), (length, across), &[])
        } else {
            straight(out, (across, -20.0), (across, length), &[element])
        };
        members.push(("relation", if i % 2 == 0 { "right_of_way" } else { "yield" }, id));
    }
    assert_eq!(rule(out, "right_of_way", &members), element);
}

/// Lanelets that begin at one place, with common nodes, and end side by side.
fn one_start(out: &mut Sketch, size: usize) {
    let starts = [out.node((0.0, 1.5)), out.node((0.0, -1.5))];
    for i in 0..size {
        let angle = TAU / 4.0 * (i as f64 / size as f64 - 0.5);
        let (east, north) = around(angle, 60.0);
        let ends = [out.node((east, north + 1.5)), out.node((east, north - 1.5))];
        let ways = [0, 1].map(|side| out.way(&[starts[side], ends[side]], THIN));
        between(out, ways[0], ways[1], &[]);
    }
}

/// A lanelet with many that follow it, in all directions.
fn fan(out: &mut Sketch, size: usize) {
    let starts = [out.node((0.0, 1.5)), out.node((0.0, -1.5))];
    let tails = [out.node((-50.0, 1.5)), out.node((-50.0, -1.5))];
    let ways = [0, 1].map(|side| out.way(&[tails[side], starts[side]], THIN));
    between(out, ways[0], ways[1], &[]);
    for i in 0..size {
        let angle = TAU / 2.0 * (i as f64 / size as f64 - 0.5);
        let middle = around(angle, 40.0);
        let across = around(angle + TAU / 4.0, 1.5);
        let ends = [1.0, -1.0].map(|side| out.node((middle.0 + side * across.0, middle.1 + side * across.1)));
        let ways = [0, 1].map(|side| out.way(&[starts[side], ends[side]], THIN));
        between(out, ways[0], ways[1], &[]);
    }
}

/// Areas of intersections and lanelets, all over each other.
fn areas_over_lanelets(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let shift = 0.1 * i as f64;
        area(out, "intersection_area", &square((shift, shift), 30.0));
        straight(out, (-40.0, shift), (40.0, shift + 5.0), &[]);
    }
}

fn long_bound(out: &mut Sketch, size: usize) {
    let side = |y: f64| (0..size).map(|i| (2.0 * i as f64, y + 0.3 * (i as f64 / 9.0).sin())).collect::<Vec<_>>();
    lanelet(out, &side(3.0), &side(0.0));
}

fn jagged_bound(out: &mut Sketch, size: usize) {
    let side = |y: f64| (0..size).map(|i| (0.2 * i as f64, y + 2.0 * (i % 2) as f64)).collect::<Vec<_>>();
    lanelet(out, &side(3.0), &side(0.0));
}

/// An area whose edges all cross each other, and a lanelet over it.
fn star_polygon(out: &mut Sketch, size: usize) {
    let corners = size | 1;
    let places: Vec<Place> = (0..corners).map(|i| around(turn(i * (corners / 2), corners), 30.0)).collect();
    area(out, "intersection_area", &places);
    area(out, "detection_area", &places);
    straight(out, (-40.0, 0.0), (40.0, 0.0), &[]);
}

fn chain(out: &mut Sketch, size: usize) {
    let mut last = [out.node((0.0, 1.5)), out.node((0.0, -1.5))];
    for i in 0..size {
        let x = 10.0 * (i + 1) as f64;
        let next = [out.node((x, 1.5)), out.node((x, -1.5))];
        let ways = [0, 1].map(|side| out.way(&[last[side], next[side]], BORDER));
        between(out, ways[0], ways[1], &[]);
        last = next;
    }
}

/// Lanes side by side.
fn wide_road(out: &mut Sketch, size: usize) {
    let ways: Vec<i64> =
        (0..=size).map(|i| out.line(&[(0.0, 3.0 * i as f64), (100.0, 3.0 * i as f64)], THIN)).collect();
    for pair in ways.windows(2) {
        between(out, pair[1], pair[0], &[]);
    }
}

/// Lanelets with one bound for all.
fn common_bound(out: &mut Sketch, size: usize) {
    let left = out.line(&[(0.0, 3.0), (50.0, 3.0)], THIN);
    for i in 0..size {
        let y = -0.01 * i as f64;
        let right = out.line(&[(0.0, y), (50.0, y)], THIN);
        between(out, left, right, &[]);
    }
}

fn one_over_the_other(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let y = 0.003 * i as f64;
        straight(out, (0.0, y), (50.0, y), &[]);
    }
}

/// Half of the lanelets cross all of the others.
fn lattice(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let across = 4.0 * (i / 2) as f64;
        let length = 2.0 * size as f64 + 20.0;
        if i % 2 == 0 {
            straight(out, (-20.0, across), (length, across), &[]);
        } else {
            straight(out, (across, -20.0), (across, length), &[]);
        }
    }
}

/// Crosswalks over one lanelet and over each other.
fn crosswalks(out: &mut Sketch, size: usize) {
    let mut elements = Vec::new();
    for i in 0..size {
        let x = 0.1 * i as f64;
        let [left, right] = [x, x + 3.0].map(|x| out.line(&[(x, -5.0), (x, 5.0)], &[("type", "pedestrian_marking")]));
        let walk = out.relation(
            &[("way", "left", left), ("way", "right", right)],
            &[("type", "lanelet"), ("subtype", "crosswalk"), ("one_way", "no"), ("participant:pedestrian", "yes")],
        );
        elements.push(rule(out, "crosswalk", &[("relation", "refers", walk)]));
    }
    straight(out, (-50.0, 0.0), (100.0, 0.0), &elements);
}

/// Stop lines across one lanelet.
fn stop_lines(out: &mut Sketch, size: usize) {
    let mut elements = Vec::new();
    for i in 0..size {
        let x = 0.1 * i as f64;
        let sign = out.line(&[(x, 4.0), (x, 5.0)], &[("type", "traffic_sign"), ("subtype", "stop_sign")]);
        let line = out.line(&[(x, -1.4), (x, 1.4)], &[("type", "stop_line")]);
        elements.push(rule(out, "traffic_sign", &[("way", "refers", sign), ("way", "ref_line", line)]));
    }
    straight(out, (-50.0, 0.0), (0.1 * size as f64 + 50.0, 0.0), &elements);
}

/// Lights for one lanelet, each an element of its own.
fn lights(out: &mut Sketch, size: usize) {
    let line = out.line(&[(48.0, -1.4), (48.0, 1.4)], &[("type", "stop_line")]);
    let elements: Vec<i64> = (0..size)
        .map(|i| {
            let y = 0.05 * i as f64;
            let tags = [("type", "traffic_light"), ("subtype", "red_yellow_green"), ("height", "0.5")];
            let light = out.line(&[(60.0, y), (60.0, y + 1.0)], &tags);
            rule(out, "traffic_light", &[("way", "refers", light), ("way", "ref_line", line)])
        })
        .collect();
    straight(out, (0.0, 0.0), (50.0, 0.0), &elements);
}

/// One light with many boxes, for many lanelets.
fn light_of_many(out: &mut Sketch, size: usize) {
    let element = out.next_id() + 3 + 3 * size as i64;
    let line = out.line(&[(48.0, -1.4), (48.0, 1.4)], &[("type", "stop_line")]);
    let mut members = vec![("way", "ref_line", line)];
    for i in 0..size {
        let y = 0.05 * i as f64;
        let tags = [("type", "traffic_light"), ("subtype", "red_yellow_green"), ("height", "0.5")];
        members.push(("way", "refers", out.line(&[(60.0, y), (60.0, y + 1.0)], &tags)));
    }
    assert_eq!(rule(out, "traffic_light", &members), element);
    for i in 0..size {
        straight(out, (0.0, 3.0 * i as f64), (50.0, 3.0 * i as f64), &[element]);
    }
}

/// Elements of every kind on one lanelet, each with an area.
fn regulatory_elements(out: &mut Sketch, size: usize) {
    let elements: Vec<i64> = (0..size)
        .map(|i| {
            let line = out.line(&[(1.0, -1.4), (1.0, 1.4)], &[("type", "stop_line")]);
            let kind = ["detection_area", "no_stopping_area", "no_parking_area", "bus_stop_area"][i % 4];
            let place = area(out, kind, &square((25.0 + 0.02 * i as f64, 0.0), 3.0));
            rule(out, kind, &[("way", "refers", place), ("way", "ref_line", line)])
        })
        .collect();
    straight(out, (0.0, 0.0), (50.0, 0.0), &elements);
}

fn speed_limits(out: &mut Sketch, size: usize) {
    let elements: Vec<i64> = (0..size)
        .map(|_| {
            let sign = out.line(&[(1.0, 4.0), (1.0, 5.0)], &[("type", "traffic_sign"), ("subtype", "de274")]);
            rule(out, "speed_limit", &[("way", "refers", sign)])
        })
        .collect();
    straight(out, (0.0, 0.0), (50.0, 0.0), &elements);
}

/// Parking lots over each other, with spaces in all of them.
fn parking(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let shift = 0.05 * i as f64;
        let corners = square((shift, 0.0), 20.0).map(|place| out.node(place));
        out.way(
            &[corners[0], corners[1], corners[2], corners[3], corners[0]],
            &[("type", "parking_lot"), ("area", "yes")],
        );
        out.line(&[(shift, -3.0), (shift, 3.0)], &[("type", "parking_space"), ("width", "2.5")]);
    }
    straight(out, (-60.0, 0.0), (-19.0, 0.0), &[]);
}

fn many_tags(out: &mut Sketch, size: usize) {
    let keys: Vec<String> = (0..size).map(|i| format!("speed_limit:{i}")).collect();
    let mut tags: Vec<(&str, &str)> = keys.iter().map(|key| (key.as_str(), "40")).collect();
    tags.extend(ROAD);
    let [left, right] = [1.5, -1.5].map(|y| out.line(&[(0.0, y), (50.0, y)], THIN));
    out.relation(&[("way", "left", left), ("way", "right", right)], &tags);
}

/// Nodes a millimetre from each other.
fn near_nodes(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let shift = 0.001 * i as f64;
        lanelet(out, &[(shift, 3.0), (50.0 + shift, 3.0)], &[(shift, 0.0), (50.0 + shift, 0.0)]);
    }
}

/// Lanelets in all directions whose bounds begin at one place, each with a node of its own.
fn nodes_at_one_place(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let angle = turn(i, size);
        lanelet(out, &[(0.0, 0.0), around(angle, 20.0)], &[(0.0, 0.0), around(angle - 0.001, 20.0)]);
    }
}

/// Half of the lanelets end where the others begin, all with nodes of their own.
fn nearly_joined(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let shift = 0.1 * i as f64 / size as f64;
        if i % 2 == 0 {
            lanelet(out, &[(-30.0, 1.5 + shift), (0.0, 1.5 + shift)], &[(-30.0, shift - 1.5), (0.0, shift - 1.5)]);
        } else {
            lanelet(out, &[(0.0, 1.5 + shift), (30.0, 1.5 + shift)], &[(0.0, shift - 1.5), (30.0, shift - 1.5)]);
        }
    }
}

/// Lanelets a decimetre long, in one heap.
fn tiny_lanelets(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let from = around(turn(i, size), 0.05);
        straight(out, from, (from.0 + 0.1, from.1), &[]);
    }
}

/// Relations that are members of relations.
fn nested_relations(out: &mut Sketch, size: usize) {
    let mut inner = straight(out, (0.0, 0.0), (50.0, 0.0), &[]);
    for _ in 0..size {
        inner = rule(out, "right_of_way", &[("relation", "right_of_way", inner), ("relation", "yield", inner)]);
    }
}

fn ring_of_relations(out: &mut Sketch, size: usize) {
    let first = out.next_id();
    for i in 0..size {
        let next = first + ((i + 1) % size) as i64;
        rule(out, "road_marking", &[("relation", "refers", next)]);
    }
    straight(out, (0.0, 0.0), (50.0, 0.0), &[first]);
}

/// One id for many elements.
fn same_id(out: &mut Sketch, size: usize) {
    for _ in 0..size {
        let mut copy = Sketch::default();
        straight(&mut copy, (0.0, 0.0), (50.0, 0.0), &[]);
        out.append(&copy);
    }
}

/// Shapes without any area: points, lines there and back, bounds that are one.
fn no_area(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let at = |x: f64| (x + i as f64, 0.0);
        lanelet(out, &[at(0.0), at(50.0)], &[at(0.0), at(50.0)]);
        lanelet(out, &[at(0.0), at(0.0)], &[at(0.0), at(0.0)]);
        area(out, "intersection_area", &[at(0.0), at(20.0), at(10.0)]);
        area(out, "detection_area", &[at(0.0), at(0.0), at(0.0)]);
        area(out, "hatched_road_markings", &[at(0.0), at(20.0), at(0.0), at(20.0)]);
    }
}

fn missing_members(out: &mut Sketch, size: usize) {
    for i in 0..size as i64 {
        let gone = 1_000_000 + i;
        let way = out.way(&[gone, gone + 1], THIN);
        between(out, way, gone, &[gone]);
        rule(out, "traffic_light", &[("way", "refers", gone), ("relation", "refers", gone)]);
    }
}

/// Lanelets of one intersection that all cross in its middle.
fn conflicts(out: &mut Sketch, size: usize) {
    let place = area(out, "intersection_area", &square((0.0, 0.0), 45.0));
    let place = place.to_string();
    for i in 0..size {
        let (from, to) = (around(turn(i, size), 40.0), around(turn(i, size) + TAU / 2.0, 40.0));
        let (left, right) = (
            out.line(&[(from.0, from.1 + 1.5), (to.0, to.1 + 1.5)], THIN),
            out.line(&[(from.0, from.1 - 1.5), (to.0, to.1 - 1.5)], THIN),
        );
        let mut tags = ROAD.to_vec();
        tags.extend([("turn_direction", "straight"), ("intersection_area", &place)]);
        out.relation(&[("way", "left", left), ("way", "right", right)], &tags);
    }
}

/// Road borders that cross a lanelet.
fn borders(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let x = 50.0 * i as f64 / size as f64;
        out.line(&[(x, -10.0), (x, 10.0)], BORDER);
    }
    straight(out, (0.0, 0.0), (50.0, 0.0), &[]);
}

/// Lanelets that cross in one place, each with an element that lets it yield to all before it.
fn mutual_yields(out: &mut Sketch, size: usize) {
    let first = out.next_id() + 7 * size as i64;
    let lanelets: Vec<i64> = (0..size)
        .map(|i| {
            straight(out, around(turn(i, size), 40.0), around(turn(i, size) + TAU / 2.0, 40.0), &[first + i as i64])
        })
        .collect();
    for (i, &id) in lanelets.iter().enumerate() {
        let mut members = vec![("relation", "right_of_way", id)];
        members
            .extend(lanelets.iter().filter(|&&other| other != id).take(i).map(|&other| ("relation", "yield", other)));
        rule(out, "right_of_way", &members);
    }
}

/// Lanelets that end at one place where as many begin.
fn hub(out: &mut Sketch, size: usize) {
    let middle = [out.node((0.0, 1.5)), out.node((0.0, -1.5))];
    for i in 0..size {
        let aside = TAU / 4.0 * ((i as f64 + 0.5) / size as f64 - 0.5);
        for (angle, is_coming) in [(aside + TAU / 2.0, true), (aside, false)] {
            let (east, north) = around(angle, 60.0);
            let ends = [out.node((east, north + 1.5)), out.node((east, north - 1.5))];
            let nodes = |side: usize| if is_coming { [ends[side], middle[side]] } else { [middle[side], ends[side]] };
            let ways = [0, 1].map(|side| out.way(&nodes(side), THIN));
            between(out, ways[0], ways[1], &[]);
        }
    }
}

/// Lanelets that lie over each other in all directions.
fn heap(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let (angle, from) = (i as f64 * 2.399_963, around(i as f64, 15.0 * (i as f64 / size as f64).sqrt()));
        let (east, north) = around(angle, 20.0);
        straight(out, (from.0 - east, from.1 - north), (from.0 + east, from.1 + north), &[]);
    }
}

/// Lanelets for both directions that lie on each other.
fn both_directions(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let y = 0.02 * i as f64;
        let [left, right] = [1.5, -1.5].map(|side| out.line(&[(0.0, y + side), (40.0, y + side)], BORDER));
        let tags: Vec<_> =
            ROAD.iter().map(|&(key, value)| (key, if key == "one_way" { "no" } else { value })).collect();
        out.relation(&[("way", "left", left), ("way", "right", right)], &tags);
    }
}

/// Lanelets that end where as many begin.
fn many_into_many(out: &mut Sketch, size: usize) {
    let gate = [out.node((0.0, 1.5)), out.node((0.0, -1.5))];
    for i in 0..2 * size {
        let ahead = i % 2 == 1;
        let angle = if ahead { 0.0 } else { TAU / 2.0 } + TAU / 4.0 * ((i / 2) as f64 / size as f64 - 0.5);
        let (east, north) = around(angle, 60.0);
        let ends = [out.node((east, north + 1.5)), out.node((east, north - 1.5))];
        let [left, right] = [0, 1].map(|k| out.way(&if ahead { [gate[k], ends[k]] } else { [ends[k], gate[k]] }, THIN));
        between(out, left, right, &[]);
    }
}

/// Lanelets between the same two ways.
fn copies(out: &mut Sketch, size: usize) {
    let [left, right] = [1.5, -1.5].map(|y| out.line(&[(0.0, y), (50.0, y)], THIN));
    for _ in 0..size {
        between(out, left, right, &[]);
    }
}

/// Areas whose outlines cross themselves at every step, over a lanelet.
fn tangled_areas(out: &mut Sketch, size: usize) {
    for kind in ["intersection_area", "detection_area"] {
        let outline: Vec<Place> =
            (0..size).map(|i| around(i as f64 * 2.399_963, 40.0 * (0.1 + i as f64 / size as f64))).collect();
        out.line(&[&outline[..], &outline[..1]].concat(), &[("type", kind), ("area", "yes")]);
    }
    let [left, right] = [1.5, -1.5].map(|y| out.line(&[(-50.0, y), (50.0, y)], THIN));
    between(out, left, right, &[]);
}

/// Lanelets of 40 m within 30 m.
fn lanes_in_all_directions(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let (angle, at) = (i as f64 * 2.399_963, around(i as f64 * 0.7, 15.0 * (i as f64 / size as f64).sqrt()));
        let along = |by: f64, aside: f64| {
            (at.0 + by * angle.cos() - aside * angle.sin(), at.1 + by * angle.sin() + aside * angle.cos())
        };
        let [left, right] = [1.5, -1.5].map(|aside| out.line(&[along(-20.0, aside), along(20.0, aside)], THIN));
        between(out, left, right, &[]);
    }
}

/// A long way that bounds many lanelets.
fn bound_of_many(out: &mut Sketch, size: usize) {
    let places: Vec<Place> = (0..4 * size).map(|i| (0.05 * i as f64, 0.01 * (i % 2) as f64)).collect();
    let common = out.line(&places, THIN);
    for i in 0..size {
        let y = 3.0 + 0.003 * i as f64;
        let other = out.line(&[(0.0, y), (0.2 * size as f64, y)], THIN);
        between(out, other, common, &[]);
    }
}

/// A way that runs to and fro between two nodes.
fn to_and_fro(out: &mut Sketch, size: usize) {
    let nodes = [out.node((0.0, 0.0)), out.node((1.0, 0.0))];
    let left = out.way(&nodes.repeat(size), THIN);
    let right = out.line(&[(0.0, -3.0), (20.0, -3.0)], THIN);
    between(out, left, right, &[]);
}

/// A lanelet whose left bound returns to one node again and again.
fn bound_through_one_node(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    let mut nodes = vec![middle];
    for i in 0..size {
        nodes.push(out.node(around(turn(i, size), 20.0 + (i % 7) as f64)));
        nodes.push(middle);
    }
    let left = out.way(&nodes, THIN);
    let right = out.line(&[(0.0, -3.0), (20.0, -3.0)], THIN);
    between(out, left, right, &[]);
}
