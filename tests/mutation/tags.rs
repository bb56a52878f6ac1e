//! Mutations of one tag, one member or one node: what is written is no word that Autoware knows, or is not written at all.

use lanewright::geometry::Vector;
use lanewright::osm::{ElementKind, Member, Relation, Way};

use super::draft::{Draft, bounds, members, relation_member, without};
use super::{Kind, kind};

/// A tag of an element that is set to one of the values; without values, it is dropped.
macro_rules! tag {
    ($name:literal, $raises:expr, $kind:ident, $among:expr, $key:literal, $values:expr) => {
        kind($name, $raises, |_, map, dice| {
            let among: fn(&Draft) -> Vec<i64> = $among;
            let values: &[&str] = $values;
            let id = dice.pick(among(map))?;
            let tags = &mut map.$kind(id).tags;
            match dice.pick(values) {
                Some(value) => tags.set($key, *value),
                None => *tags = without(tags, $key),
            }
            Some(vec![id])
        })
    };
}

/// The members of a role that are taken from an element; the element is named.
macro_rules! member {
    ($name:literal, $raises:expr, $subtype:literal, $role:literal) => {
        kind($name, $raises, |_, map, dice| {
            let has = |one: &&Relation| members(one, $role).next().is_some();
            let id = dice.pick(map.elements($subtype).filter(has))?.id;
            map.relation(id).members.retain(|member| member.role != $role);
            Some(vec![id])
        })
    };
}

/// An area of a type that no element refers to.
macro_rules! area {
    ($name:literal, $raises:expr, $type:literal) => {
        kind($name, $raises, |_, map, dice| {
            let lane = dice.pick(plain(map))?;
            let [left, right] = bounds(map.relation(lane));
            let nodes = [left, right].map(|way| map.way(way).nodes[..2].to_vec());
            let ring = vec![nodes[0][0], nodes[0][1], nodes[1][1], nodes[1][0]];
            let id = map.copy_way(left);
            map.way(id).nodes = ring;
            map.way(id).tags = [("type", $type), ("area", "yes")].into_iter().collect();
            Some(vec![id])
        })
    };
}

pub const KINDS: &[Kind] = &[
    tag!("misplace a lane", &["vm-01-01/location"], relation, plain, "location", &["rural", ""]),
    tag!("let a lane be two-way", &["vm-01-01/one-way"], relation, plain, "one_way", &["no", "true"]),
    tag!("drop lane_change between lanes", &["vm-01-02/lane-change-missing"], way, between, "lane_change", &[]),
    tag!("drop lane_change of a middle line", &["vm-01-02/lane-change-implied"], way, middle, "lane_change", &[]),
    tag!("misspell lane_change", &["vm-01-02/lane-change-invalid"], way, between, "lane_change", &["maybe", "Yes"]),
    tag!(
        "close one side beside lane_change",
        &["vm-01-02/lane-change-hidden"],
        way,
        dashed,
        "lane_change:left",
        &["no"]
    ),
    kind("close one side alone", &["vm-01-02/lane-change-half"], |_, map, dice| {
        let id = dice.pick(dashed(map))?;
        let way = map.way(id);
        let others: Vec<_> = way.tags.iter().filter(|(key, _)| *key != "lane_change").collect();
        way.tags = others.into_iter().chain([("lane_change:left", "no")]).collect();
        Some(vec![id])
    }),
    tag!("forbid to cross a dashed line", &["health/lane-change-paint"], way, dashed, "lane_change", &["no"]),
    tag!(
        "write a speed that is no number",
        &["vm-01-09/speed-invalid"],
        relation,
        plain,
        "speed_limit",
        &["fast", "-5"]
    ),
    tag!(
        "write a speed with its unit",
        &["vm-01-09/speed-unit"],
        relation,
        plain,
        "speed_limit",
        &["60km/h", "30 mph", "10 m/s"]
    ),
    tag!(
        "write a speed in metres per second",
        &["vm-01-09/speed-metres"],
        relation,
        plain,
        "speed_limit",
        &["13.89", "8.33", "11.175"]
    ),
    tag!("write a speed beyond all limits", &["vm-01-09/speed-range"], relation, plain, "speed_limit", &["300"]),
    tag!("make a shoulder of a lane", &["vm-01-21/other-kind"], relation, plain, "subtype", &["road_shoulder"]),
    tag!("retype a stop sign", &["vm-02-02/sign-type"], way, signs, "type", &["pole"]),
    // The type says that it is a stop line, or the subtype.
    kind("retype a sign's line", &["vm-02-02/line-type"], |_, map, dice| {
        let id = dice.pick(lines_of(map, "traffic_sign"))?;
        let tags = &mut map.way(id).tags;
        *tags = without(tags, "subtype");
        tags.set("type", "line_thin");
        Some(vec![id])
    }),
    tag!("retype a light", &["vm-04-01/body-type", "vm-04-01/unreferenced"], way, lights, "type", &["traffic_sign"]),
    tag!(
        "retype a light's line",
        &["vm-04-01/line-type"],
        way,
        |map| lines_of(map, "traffic_light"),
        "type",
        &["line_thin"]
    ),
    tag!("retype bulbs", &["vm-04-01/bulbs-type"], way, bulbs, "type", &["line_thin"]),
    tag!("let bulbs forget their light", &["vm-04-01/bulbs-nameless"], way, bulbs, "traffic_light_id", &[]),
    tag!("drop a light's height", &["vm-04-02/height-missing"], way, lights, "height", &[]),
    tag!("write a light's height in centimetres", &["vm-04-02/height-range"], way, lights, "height", &["50", "0"]),
    tag!("drop a bulb's colour", &["vm-04-03/color-missing"], node, lamps, "color", &[]),
    tag!("misspell a bulb's colour", &["vm-04-03/color-invalid"], node, lamps, "color", &["amber", "Red"]),
    tag!("misspell a bulb's arrow", &["vm-04-03/arrow-invalid"], node, lamps, "arrow", &["straight", "up_light"]),
    tag!("forget who walks", &["vm-05-01/pedestrian-missing"], relation, crosswalks, "participant:pedestrian", &[]),
    tag!("forbid to walk", &["vm-05-01/pedestrian-no"], relation, crosswalks, "participant:pedestrian", &["no"]),
    tag!("slow down by a word", &["vm-05-03/speed"], relation, crosswalks, "safety_slow_down_speed", &["slow", "-1"]),
    tag!(
        "slow down from a word on",
        &["vm-05-03/distance"],
        relation,
        crosswalks,
        "safety_slow_down_distance",
        &["near"]
    ),
    member!("let a sign forget its line", &["vm-02-02/sign-without-line"], "traffic_sign", "ref_line"),
    member!(
        "let a crosswalk element forget its crosswalk",
        &["vm-05-01/no-refers", "vm-05-01/unreferenced"],
        "crosswalk",
        "refers"
    ),
    area!("forbid to park without an element", &["vm-06-02/unreferenced"], "no_parking_area"),
    area!("forbid to stop without an element", &["vm-06-04/unreferenced"], "no_stopping_area"),
    area!("watch an area without an element", &["vm-06-05/unreferenced"], "detection_area"),
    area!("stop buses without an element", &["vm-06-06/unreferenced"], "bus_stop_area"),
    area!("hatch a lane", &["vm-06-01/overlap", "vm-06-01/invalid"], "hatched_road_markings"),
    kind("let bulbs name a light that is not there", &["vm-04-01/bulbs-unpaired"], |_, map, dice| {
        let element = dice.pick(map.elements("traffic_light"))?;
        let (id, bulbs) = (element.id, members(element, "light_bulbs").next()?);
        map.way(bulbs).tags.set("traffic_light_id", "7");
        Some(vec![id])
    }),
    kind("give a light the bulbs of another, too", &["vm-04-01/bulbs-count"], |_, map, dice| {
        let element = dice.pick(map.elements("traffic_light"))?;
        let (id, own) = (element.id, members(element, "light_bulbs").collect::<Vec<_>>());
        let other = dice.pick(bulbs(map).into_iter().filter(|way| !own.contains(way)))?;
        map.relation(id).members.push(Member { kind: ElementKind::Way, id: other, role: "light_bulbs".into() });
        Some(vec![id])
    }),
    kind("turn a light around", &["vm-04-02/reversed"], |_, map, dice| {
        let id = dice.pick(drivers_lights(map))?;
        map.way(id).nodes.reverse();
        Some(vec![id])
    }),
    kind("draw a light as a closed line", &["vm-04-02/outline"], |_, map, dice| {
        let id = dice.pick(drivers_lights(map))?;
        let nodes = &mut map.way(id).nodes;
        nodes.extend(nodes.first().copied());
        Some(vec![id])
    }),
    kind("hang a light far from the road", &["vm-04-02/off-road"], |_, map, dice| {
        let id = dice.pick(drivers_lights(map))?;
        let line = map.line(id);
        let middle = nalgebra::center(line.first()?, line.last()?);
        let off = |angle: i32| {
            let (sin, cos) = f64::from(angle).to_radians().sin_cos();
            Vector::new(cos, sin) * 60.0
        };
        let is_free = |by: &Vector| map.nodes.iter().all(|node| (map.place(node.id) - middle - by).norm() > 45.0);
        let by = (0..360).step_by(30).map(off).find(is_free)?;
        for node in map.way(id).nodes.clone() {
            map.shift(node, by);
        }
        Some(vec![id])
    }),
    kind("turn a light by a quarter", &["vm-04-02/sideways"], |_, map, dice| {
        let id = dice.pick(drivers_lights(map))?;
        let line = map.line(id);
        let middle = nalgebra::center(line.first()?, line.last()?);
        for node in map.way(id).nodes.clone() {
            let off = map.place(node) - middle;
            map.shift(node, Vector::new(-off.y, off.x) - off);
        }
        Some(vec![id])
    }),
    kind("draw a light that belongs to nothing", &["vm-04-01/unreferenced"], |_, map, dice| {
        let id = dice.pick(lights(map))?;
        Some(vec![map.copy_way(id)])
    }),
    kind("let all forget a light", &["vm-04-01/idle"], |_, map, dice| {
        let id = dice.pick(map.elements("traffic_light"))?.id;
        map.relations.iter_mut().for_each(|one| one.members.retain(|member| member.id != id));
        Some(vec![id])
    }),
    kind("delete a crosswalk's element", &["vm-05-01/unreferenced"], |_, map, dice| {
        // An element may also refer to a walkway, which needs none where the map has no others.
        let walks = crosswalks(map);
        let of_crosswalks = map.elements("crosswalk").filter_map(|one| Some((one.id, members(one, "refers").next()?)));
        let (id, walk) = dice.pick(of_crosswalks.filter(|(_, walk)| walks.contains(walk)))?;
        map.remove(ElementKind::Relation, id);
        Some(vec![walk])
    }),
    kind("give a crosswalk's element a second crosswalk", &["vm-05-01/several-refers"], |_, map, dice| {
        let element = dice.pick(map.elements("crosswalk"))?;
        let (id, own) = (element.id, members(element, "refers").next()?);
        let other = dice.pick(crosswalks(map).into_iter().filter(|walk| *walk != own))?;
        map.relation(id).members.push(relation_member(other, "refers"));
        Some(vec![id])
    }),
    kind("let a crosswalk's element refer to a lane", &["vm-05-01/refers-type"], |_, map, dice| {
        let (id, lane) = (dice.pick(map.elements("crosswalk"))?.id, dice.pick(plain(map))?);
        map.relation(id).members.iter_mut().filter(|member| member.role == "refers").for_each(|one| one.id = lane);
        Some(vec![id, lane])
    }),
    kind(
        "let a lane that crosses nothing refer to a crosswalk's element",
        &["vm-05-01/not-crossing"],
        |_, map, dice| {
            let (id, lane) = (dice.pick(map.elements("crosswalk"))?.id, dice.pick(plain(map))?);
            map.relation(lane).members.push(relation_member(id, "regulatory_element"));
            Some(vec![id, lane])
        },
    ),
    kind("take a node for a bound", &["load/bound-not-way"], |_, map, dice| {
        let lanelet = dice.pick(map.lanelets())?;
        let (id, way) = (lanelet.id, bounds(lanelet)[0]);
        let node = map.way(way).nodes[0];
        let member = map.relation(id).members.iter_mut().find(|member| member.role == "left")?;
        *member = Member { kind: ElementKind::Node, id: node, role: "left".into() };
        Some(vec![id])
    }),
    kind("put an element into an element", &["load/re-member-type"], |_, map, dice| {
        let (id, other) = (dice.pick(map.elements("right_of_way"))?.id, dice.pick(map.elements("crosswalk"))?.id);
        map.relation(id).members.push(relation_member(other, "yield"));
        Some(vec![id])
    }),
    kind("give a way the id of a node", &["ids/reused"], |_, map, dice| {
        let (way, node) = (dice.pick(&map.ways)?.id, dice.pick(&map.nodes)?.id);
        map.renumber(ElementKind::Way, way, node);
        Some(vec![node])
    }),
    kind("move a node into another square", &["node/other-square"], |_, map, dice| {
        let id = dice.pick(&map.nodes)?.id;
        let node = map.node(id);
        if let Some(place) = &mut node.position {
            place.lat += 1.1;
        }
        Some(vec![id])
    }),
    kind("raise one side of a lane by 2 m", &["health/tilt"], |_, map, dice| {
        let lane = dice.pick(plain(map))?;
        let [left, _] = bounds(map.relation(lane));
        for node in map.way(left).nodes.clone() {
            let ele: f64 = map.node(node).tags.get("ele")?.parse().ok()?;
            map.node(node).tags.set("ele", (ele + 2.0).to_string());
        }
        Some(map.bounded(left))
    }),
    kind("draw a lanelet of no length", &["health/zero-length"], |_, map, dice| {
        let lane = dice.pick(plain(map))?;
        let own = bounds(map.relation(lane));
        let id = map.fresh();
        let copy = Relation { id, ..map.relation(lane).clone() };
        map.relations.push(copy);
        for (role, way) in ["left", "right"].into_iter().zip(own) {
            let short = map.copy_way(way);
            let first = map.way(way).nodes[0];
            let second = map.copy_node(first);
            map.shift(second, Vector::new(0.001, 0.001));
            map.way(short).nodes = vec![first, second];
            let members = &mut map.relation(id).members;
            members.iter_mut().filter(|member| member.role == role).for_each(|member| member.id = short);
        }
        Some(vec![id])
    }),
    kind("let a lane end in a point", &["vm-01-05/shared-point"], |_, map, dice| {
        let lane = dice.pick(plain(map))?;
        let [left, right] = bounds(map.relation(lane));
        let node = *map.way(left).nodes.last()?;
        let own = map.copy_way(right);
        // Bounds may run either way: the nearer end.
        let ends = [map.line(own)[0], *map.line(own).last()?].map(|end| (end - map.place(node)).norm());
        let nodes = &mut map.way(own).nodes;
        let at = if ends[0] < ends[1] { 0 } else { nodes.len() - 1 };
        nodes[at] = node;
        let members = &mut map.relation(lane).members;
        members.iter_mut().filter(|member| member.role == "right").for_each(|member| member.id = own);
        Some(vec![lane])
    }),
    kind(
        "draw a stop line that nothing refers to",
        &["vm-02-02/unreferenced", "vm-03-14/unreferenced", "vm-03-09/no-stop-line"],
        |_, map, dice| {
            let lane = dice.pick(plain(map))?;
            let [left, right] = bounds(map.relation(lane));
            let first = *map.way(left).nodes.first()?;
            let ends = [*map.way(right).nodes.first()?, *map.way(right).nodes.last()?];
            // Bounds may run either way: the nearer end.
            let away = |node: &i64| (map.place(*node) - map.place(first)).norm();
            let nodes = vec![first, ends.into_iter().min_by(|a, b| away(a).total_cmp(&away(b)))?];
            // Not where there is one already, of which it would be a copy.
            let taken =
                |way: &Way| way.tags.is("type", "stop_line") && nodes.iter().any(|node| way.nodes.contains(node));
            if map.ways.iter().any(taken) {
                return None;
            }
            let tags = [("type", "stop_line"), ("subtype", "solid")].into_iter().collect();
            let way = Way { id: map.fresh(), nodes, tags, ..map.way(left).clone() };
            let id = way.id;
            map.ways.push(way);
            Some(vec![id])
        },
    ),
];

/// Road lanelets between intersections.
fn plain(map: &Draft) -> Vec<i64> {
    let plain = |one: &&Relation| one.tags.is("subtype", "road") && !one.tags.has("intersection_area");
    map.lanelets().filter(plain).map(|one| one.id).collect()
}

/// Ways between two lanes of one direction, outside intersections.
fn between(map: &Draft) -> Vec<i64> {
    let lanes: Vec<[i64; 2]> =
        plain(map).iter().filter_map(|id| map.relations.iter().find(|one| one.id == *id)).map(bounds).collect();
    lanes.iter().map(|lane| lane[1]).filter(|way| lanes.iter().any(|lane| lane[0] == *way)).collect()
}

/// Painted lines between two lanes of opposite directions.
fn middle(map: &Draft) -> Vec<i64> {
    let lefts: Vec<i64> =
        map.lanelets().filter(|one| one.tags.is("subtype", "road")).map(|one| bounds(one)[0]).collect();
    let is_shared = |way: &i64| lefts.iter().filter(|left| *left == way).count() == 2;
    of_type(map, "line_thin").into_iter().filter(is_shared).collect()
}

fn dashed(map: &Draft) -> Vec<i64> {
    let is = |id: &i64| map.ways.iter().any(|way| way.id == *id && way.tags.is("subtype", "dashed"));
    between(map).into_iter().filter(is).collect()
}

fn of_type(map: &Draft, kind: &str) -> Vec<i64> {
    map.ways.iter().filter(|way| way.tags.is("type", kind)).map(|way| way.id).collect()
}

fn lights(map: &Draft) -> Vec<i64> {
    of_type(map, "traffic_light")
}

/// Those of which the requirement says which way they hang.
fn drivers_lights(map: &Draft) -> Vec<i64> {
    let body = |way: &&Way| way.tags.is("type", "traffic_light") && way.tags.is("subtype", "red_yellow_green");
    map.ways.iter().filter(body).map(|way| way.id).collect()
}

fn bulbs(map: &Draft) -> Vec<i64> {
    of_type(map, "light_bulbs")
}

fn signs(map: &Draft) -> Vec<i64> {
    of_type(map, "traffic_sign")
}

fn lamps(map: &Draft) -> Vec<i64> {
    map.ways.iter().filter(|way| way.tags.is("type", "light_bulbs")).flat_map(|way| way.nodes.clone()).collect()
}

fn crosswalks(map: &Draft) -> Vec<i64> {
    map.lanelets().filter(|one| one.tags.is("subtype", "crosswalk")).map(|one| one.id).collect()
}

/// The stop lines of the elements of a subtype.
fn lines_of(map: &Draft, subtype: &str) -> Vec<i64> {
    map.elements(subtype).flat_map(|one| members(one, "ref_line").collect::<Vec<_>>()).collect()
}
