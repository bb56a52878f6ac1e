//! Small files of OpenStreetMap data, of which the whole work lies in one place.

use std::f64::consts::TAU;

use super::Kind;
use super::sketch::{Place, Sketch};

/// The kinds; `size` roads or so.
pub const KINDS: &[Kind] = &[
    Kind { name: "dense grid", size: 200, draw: dense_grid },
    Kind { name: "parallel roads", size: 300, draw: parallel_roads },
    Kind { name: "bridges over bridges", size: 60, draw: bridges },
    Kind { name: "crosswalks", size: 100, draw: crosswalks },
    Kind { name: "signals", size: 100, draw: signals },
    Kind { name: "restrictions", size: 300, draw: restrictions },
    Kind { name: "many via", size: 300, draw: many_via },
    Kind { name: "wide", size: 100, draw: wide },
    Kind { name: "turn lanes", size: 200, draw: turn_lanes },
    Kind { name: "many tags", size: 2_000, draw: many_tags },
    Kind { name: "stubs", size: 100, draw: stubs },
    Kind { name: "zigzag", size: 3_000, draw: zigzag },
    Kind { name: "spiral", size: 3_000, draw: spiral },
    Kind { name: "one place", size: 200, draw: one_place },
    Kind { name: "footways", size: 60, draw: footways },
    Kind { name: "divided road", size: 60, draw: divided_road },
];

/// Kinds of which twice as many parts take more than two and a half times as long; these sizes are within the bounds.
pub const STEEP: &[Kind] = &[
    Kind { name: "star", size: 100, draw: star },
    Kind { name: "stars", size: 20, draw: stars },
    Kind { name: "comb", size: 40, draw: comb },
    Kind { name: "knot", size: 30, draw: knot },
    Kind { name: "row of crossings", size: 40, draw: row_of_crossings },
    Kind { name: "one over the other", size: 60, draw: one_over_the_other },
    Kind { name: "same two ends", size: 30, draw: same_two_ends },
    Kind { name: "every node with every other", size: 60, draw: complete },
    Kind { name: "roundabout", size: 40, draw: roundabout },
    Kind { name: "fork", size: 60, draw: fork },
    Kind { name: "tangle", size: 300, draw: tangle },
    Kind { name: "crossing without nodes", size: 150, draw: crossing_without_nodes },
    Kind { name: "loops", size: 60, draw: loops },
    Kind { name: "web", size: 40, draw: web },
    Kind { name: "two hubs", size: 300, draw: two_hubs },
    Kind { name: "rings in rings", size: 400, draw: rings_in_rings },
    Kind { name: "spiral ramps", size: 90, draw: spiral_ramps },
    Kind { name: "streets at random", size: 100, draw: streets_at_random },
];

const STREET: &[(&str, &str)] = &[("highway", "residential")];

fn around(angle: f64, radius: f64) -> Place {
    (radius * angle.cos(), radius * angle.sin())
}

fn turn(i: usize, of: usize) -> f64 {
    TAU * i as f64 / of as f64
}

/// Roads from one node in all directions.
fn star(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    for i in 0..size {
        let end = out.node(around(turn(i, size), 100.0));
        out.way(&[middle, end], STREET);
    }
}

/// Nodes 300 m apart, each with fourteen roads in all directions.
fn stars(out: &mut Sketch, size: usize) {
    const ROADS: usize = 14;
    for x in (0..size).map(|i| 300.0 * i as f64) {
        let middle = out.node((x, 0.0));
        for i in 0..ROADS {
            let (east, north) = around(turn(i, ROADS), 100.0);
            let end = out.node((x + east, north));
            out.way(&[middle, end], STREET);
        }
    }
}

/// Ramps that wind up thirty times, each round a bridge of its own.
fn spiral_ramps(out: &mut Sketch, size: usize) {
    const ROUNDS: usize = 30;
    let mut last = 0;
    for round in 0..size {
        let (east, layer) = (200.0 * (round / ROUNDS) as f64, (round % ROUNDS).to_string());
        let place = |at: usize| {
            let (x, y) = around(turn(at, 6), 20.0);
            (east + x, y)
        };
        if round % ROUNDS == 0 {
            last = out.node(place(0));
        }
        let nodes: Vec<i64> = std::iter::once(last).chain((1..=6).map(|at| out.node(place(at)))).collect();
        last = nodes[6];
        out.way(&nodes, &[("highway", "service"), ("bridge", "yes"), ("layer", layer.as_str())]);
    }
}

/// Side roads every three metres.
fn comb(out: &mut Sketch, size: usize) {
    let mut spine = Vec::new();
    for i in 0..size {
        let foot = out.node((3.0 * i as f64, 0.0));
        let tip = out.node((3.0 * i as f64, 60.0));
        out.way(&[foot, tip], STREET);
        spine.push(foot);
    }
    out.way(&spine, STREET);
}

/// One way that passes through one node again and again.
fn knot(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    let mut nodes = vec![middle];
    for i in 0..size {
        nodes.push(out.node(around(turn(3 * i, 3 * size), 60.0)));
        nodes.push(out.node(around(turn(3 * i + 1, 3 * size), 60.0)));
        nodes.push(middle);
    }
    out.way(&nodes, STREET);
}

/// Streets that cross every five metres.
fn dense_grid(out: &mut Sketch, size: usize) {
    let side = (size as f64 / 2.0).sqrt().round() as usize;
    let rows: Vec<Vec<i64>> =
        (0..=side).map(|y| (0..=side).map(|x| out.node((5.0 * x as f64, 5.0 * y as f64))).collect()).collect();
    for row in &rows {
        out.way(row, STREET);
    }
    for x in 0..=side {
        let column: Vec<i64> = rows.iter().map(|row| row[x]).collect();
        out.way(&column, STREET);
    }
}

fn parallel_roads(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let x = 4.0 * i as f64;
        out.line(&[(x, 0.0), (x, 200.0)], STREET);
    }
}

fn zigzag(out: &mut Sketch, size: usize) {
    let places: Vec<Place> = (0..size).map(|i| (5.0 * i as f64, 3.0 * (i % 2) as f64)).collect();
    out.line(&places, STREET);
}

/// A road that meets a cross street every 12 m.
fn row_of_crossings(out: &mut Sketch, size: usize) {
    let mut row = Vec::new();
    for i in 0..size {
        let x = 12.0 * i as f64;
        let middle = out.node((x, 0.0));
        let (above, below) = (out.node((x, 60.0)), out.node((x, -60.0)));
        out.way(&[below, middle, above], STREET);
        row.push(middle);
    }
    out.way(&row, STREET);
}

/// The same road again and again, without a common node.
fn one_over_the_other(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let shift = 0.01 * i as f64;
        out.line(&[(0.0, shift), (100.0, shift), (200.0, 40.0 + shift)], STREET);
    }
}

/// Half of the roads cross all of the others on bridges.
fn bridges(out: &mut Sketch, size: usize) {
    for i in 0..size / 2 {
        let x = 10.0 * i as f64;
        let length = 5.0 * size as f64;
        out.line(&[(x, -20.0), (x, length)], &[("highway", "residential"), ("bridge", "yes"), ("layer", "1")]);
        out.line(&[(-20.0, x), (length, x)], STREET);
    }
}

fn same_two_ends(out: &mut Sketch, size: usize) {
    let (start, end) = (out.node((0.0, 0.0)), out.node((200.0, 0.0)));
    for i in 0..size {
        let middle = out.node((100.0, 6.0 * i as f64));
        out.way(&[start, middle, end], STREET);
    }
}

/// As many roads as asked for, each from one of a ring of nodes straight to another.
fn complete(out: &mut Sketch, size: usize) {
    let corners = (1..).find(|n| n * (n - 1) / 2 >= size).unwrap_or(1);
    let nodes: Vec<i64> = (0..corners).map(|i| out.node(around(turn(i, corners), 100.0))).collect();
    for (i, &from) in nodes.iter().enumerate() {
        for &to in &nodes[..i] {
            out.way(&[from, to], STREET);
        }
    }
}

/// A crossing every metre.
fn crosswalks(out: &mut Sketch, size: usize) {
    let marked = [("highway", "crossing"), ("crossing", "marked")];
    let nodes: Vec<i64> = (0..size).map(|i| out.tagged_node((i as f64, 0.0), &marked)).collect();
    out.way(&nodes, STREET);
    for (i, &node) in nodes.iter().enumerate() {
        let (one, other) = (out.node((i as f64, -8.0)), out.node((i as f64, 8.0)));
        out.way(&[one, node, other], &[("highway", "footway"), ("footway", "crossing")]);
    }
}

/// A signal every metre.
fn signals(out: &mut Sketch, size: usize) {
    let signal = [("highway", "traffic_signals"), ("traffic_signals:direction", "forward")];
    let nodes: Vec<i64> = (0..size).map(|i| out.tagged_node((i as f64, 0.0), &signal)).collect();
    out.way(&nodes, STREET);
}

/// One prohibition, said again and again.
fn restrictions(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    let arms: Vec<i64> = (0..4)
        .map(|i| {
            let end = out.node(around(turn(i, 4), 100.0));
            out.way(&[middle, end], STREET)
        })
        .collect();
    for _ in 0..size {
        let members = [("way", "from", arms[0]), ("node", "via", middle), ("way", "to", arms[1])];
        out.relation(&members, &[("type", "restriction"), ("restriction", "no_left_turn")]);
    }
}

/// A prohibition over many ways.
fn many_via(out: &mut Sketch, size: usize) {
    let nodes: Vec<i64> = (0..=size).map(|i| out.node((30.0 * i as f64, 0.0))).collect();
    let ways: Vec<i64> = nodes.windows(2).map(|ends| out.way(ends, STREET)).collect();
    for &node in &nodes {
        let end = out.node((15.0 + 30.0 * (node - nodes[0]) as f64, 60.0));
        out.way(&[node, end], STREET);
    }
    let role = |i| {
        if i == 0 {
            "from"
        } else if i + 1 == size {
            "to"
        } else {
            "via"
        }
    };
    let members: Vec<_> = ways.iter().enumerate().map(|(i, &way)| ("way", role(i), way)).collect();
    out.relation(&members, &[("type", "restriction"), ("restriction", "no_straight_on")]);
}

fn roundabout(out: &mut Sketch, size: usize) {
    let mut ring: Vec<i64> = (0..size).map(|i| out.node(around(turn(i, size), 20.0))).collect();
    for (i, &node) in ring.iter().enumerate() {
        let end = out.node(around(turn(i, size), 100.0));
        out.way(&[node, end], STREET);
    }
    ring.extend(ring.first().copied());
    out.way(&ring, &[("highway", "residential"), ("junction", "roundabout"), ("oneway", "yes")]);
}

/// A crossing of two roads of many lanes.
fn wide(out: &mut Sketch, size: usize) {
    let lanes = size.to_string();
    let middle = out.node((0.0, 0.0));
    for i in 0..4 {
        let end = out.node(around(turn(i, 4), 1_000.0));
        out.way(&[middle, end], &[("highway", "primary"), ("lanes", &lanes)]);
    }
}

fn turn_lanes(out: &mut Sketch, size: usize) {
    let (lanes, turns) = (size.to_string(), vec!["left;through;right"; size].join("|"));
    let middle = out.node((0.0, 0.0));
    for i in 0..4 {
        let end = out.node(around(turn(i, 4), 300.0));
        let tags = [("highway", "primary"), ("oneway", "yes"), ("lanes", &lanes), ("turn:lanes", &turns)];
        out.way(&[end, middle], &tags[..if i % 2 == 0 { 4 } else { 1 }]);
    }
}

fn many_tags(out: &mut Sketch, size: usize) {
    let keys: Vec<String> = (0..size).map(|i| format!("maxspeed:conditional:{i}")).collect();
    let mut tags: Vec<(&str, &str)> = keys.iter().map(|key| (key.as_str(), "50 @ (Mo-Fr)")).collect();
    tags.extend(STREET);
    let middle = out.node((0.0, 0.0));
    for i in 0..3 {
        let end = out.node(around(turn(i, 3), 100.0));
        out.way(&[middle, end], if i == 0 { &tags } else { STREET });
    }
}

/// Roads of one metre at one node.
fn stubs(out: &mut Sketch, size: usize) {
    let mut row = Vec::new();
    for i in 0..size {
        let foot = out.node((20.0 * i as f64, 0.0));
        let tip = out.node((20.0 * i as f64, 1.0));
        out.way(&[foot, tip], &[("highway", "service")]);
        row.push(foot);
    }
    out.way(&row, STREET);
}

fn spiral(out: &mut Sketch, size: usize) {
    let places: Vec<Place> = (0..size)
        .map(|i| {
            let angle = (i as f64).sqrt() * 1.2;
            around(angle, 20.0 + 1.5 * angle)
        })
        .collect();
    out.line(&places, STREET);
}

/// Nodes that all lie at one place.
fn one_place(out: &mut Sketch, size: usize) {
    for i in 0..size {
        out.line(&[(0.0, 0.0), (0.0, 0.0), if i % 2 == 0 { (0.0, 0.0) } else { (0.01, 0.0) }], STREET);
    }
}

/// Footways that cross a road side by side, and each other.
fn footways(out: &mut Sketch, size: usize) {
    out.line(&[(-100.0, 0.0), (100.0, 0.0)], STREET);
    for i in 0..size {
        let x = 20.0 * (i as f64 / size as f64 - 0.5);
        out.line(&[(x, -10.0), (-x, 10.0)], &[("highway", "footway")]);
    }
}

/// Two carriageways, joined every ten metres.
fn divided_road(out: &mut Sketch, size: usize) {
    let places = |y: f64| (0..size).map(move |i| (10.0 * i as f64, y));
    let there: Vec<i64> = places(0.0).map(|place| out.node(place)).collect();
    let mut back: Vec<i64> = places(9.0).map(|place| out.node(place)).collect();
    for (&one, &other) in there.iter().zip(&back) {
        out.way(&[one, other], &[("highway", "service")]);
    }
    back.reverse();
    for nodes in [there, back] {
        out.way(&nodes, &[("highway", "primary"), ("oneway", "yes"), ("lanes", "2")]);
    }
}

/// Roads that leave one node within a right angle.
fn fork(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    let tail = out.node((-100.0, 0.0));
    out.way(&[tail, middle], STREET);
    for i in 0..size {
        let end = out.node(around(turn(i, 4 * size), 100.0));
        out.way(&[middle, end], &[("highway", "residential"), ("oneway", "yes")]);
    }
}

/// A way that crosses itself at every turn.
fn tangle(out: &mut Sketch, size: usize) {
    let places: Vec<Place> =
        (0..size).map(|i| around(i as f64 * 2.399_963, 100.0 * (0.1 + i as f64 / size as f64))).collect();
    out.line(&places, STREET);
}

/// Roads in all directions that cross each other without a common node.
fn crossing_without_nodes(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let (from, to) = (around(i as f64 * 2.399_963, 150.0), around(i as f64 * 2.399_963 + 2.0, 150.0));
        out.line(&[from, to], STREET);
    }
}

/// Loops at one node.
fn loops(out: &mut Sketch, size: usize) {
    let middle = out.node((0.0, 0.0));
    for i in 0..size {
        let (one, other) =
            (out.node(around(turn(2 * i, 2 * size), 40.0)), out.node(around(turn(2 * i + 1, 2 * size), 45.0)));
        out.way(&[middle, one, other, middle], STREET);
    }
}

/// Rings of streets around each other, 12 m apart, and streets from the middle through all of them.
fn web(out: &mut Sketch, size: usize) {
    let rings: Vec<Vec<i64>> = (1..=size / 3)
        .map(|ring| (0..size).map(|i| out.node(around(turn(i, size), 12.0 * ring as f64))).collect())
        .collect();
    let middle = out.node((0.0, 0.0));
    for ring in &rings {
        out.way(&[&ring[..], &ring[..1]].concat(), STREET);
    }
    for i in 0..size {
        let spoke: Vec<i64> = std::iter::once(middle).chain(rings.iter().map(|ring| ring[i])).collect();
        out.way(&spoke, STREET);
    }
}

/// Two nodes side by side, with roads from each in a half circle.
fn two_hubs(out: &mut Sketch, size: usize) {
    let hubs = [0.0, 9.0].map(|x| out.node((x, 0.0)));
    out.way(&hubs, STREET);
    for i in 0..size {
        let (east, north) = around(turn(1, 4) + turn(i, 2 * size), 100.0);
        let ends = [out.node((east, north)), out.node((9.0 - east, -north))];
        out.way(&[hubs[0], ends[0]], STREET);
        out.way(&[hubs[1], ends[1]], STREET);
    }
}

/// Rings around each other that meet nothing, 3 m apart.
fn rings_in_rings(out: &mut Sketch, size: usize) {
    for i in 0..size {
        let nodes: Vec<i64> = (0..8).map(|k| out.node(around(turn(k, 8), 10.0 + 3.0 * i as f64))).collect();
        out.way(&[&nodes[..], &nodes[..1]].concat(), STREET);
    }
}

/// Streets straight from some nodes within 100 m to others.
fn streets_at_random(out: &mut Sketch, size: usize) {
    let count = (2.0 * (size as f64).sqrt()) as usize;
    let nodes: Vec<i64> =
        (0..count).map(|i| out.node(around(i as f64 * 2.399_963, 50.0 * (i as f64 / count as f64).sqrt()))).collect();
    for i in 0..size {
        let (from, to) = (i % count, (i % count + 1 + (7 * i) / count % (count - 1)) % count);
        out.way(&[nodes[from], nodes[to]], STREET);
    }
}
