//! One character wrong in a key, a value or a role: every word that Lanelet2 and Autoware know, on a primitive that can have it.

use std::collections::BTreeSet;

use lanewright::diagnostic::Subject;
use lanewright::lanelet::vocabulary::{Form, On, words};
use lanewright::osm::{ElementKind, Member, Relation};
use rayon::prelude::*;

use super::draft::{Dice, Draft, bounds};
use super::{Base, Kind, bases, kind, soak};

/// Words that are misspelt in every run, and in a soak.
const DRAWS: [usize; 2] = [200, 1000];
/// Words that are misspelt in one map at once, each on a primitive of its own.
const AT_ONCE: usize = 20;
/// The least share that must be told.
const TOLD: f64 = 0.95;

/// What can be misspelt.
#[derive(Clone, Debug)]
enum Word {
    Key(On, String),
    Value(On, String, String),
    Role(String, String),
}

/// Every key, value and role of the table, with the primitives of the sample maps; these have no areas as relations.
fn all_words() -> Vec<Word> {
    let table = words().unwrap();
    let mut all = Vec::new();
    for key in &table.key {
        for &on in key.on.iter().filter(|on| **on != On::Area) {
            let names = table.written_out(key);
            all.extend(names.iter().map(|name| Word::Key(on, name.clone())));
            let yes_no = ["yes", "no"].map(str::to_owned);
            let values = if key.form == Some(Form::YesNo) { &yes_no[..] } else { &key.values };
            for name in &names {
                all.extend(values.iter().map(|value| Word::Value(on, name.clone(), value.clone())));
            }
        }
    }
    for list in &table.types {
        for &on in &list.on {
            let is_way = matches!(on, On::LineString | On::Polygon | On::Point);
            all.extend(list.names.iter().filter(|_| is_way).map(|name| Word::Value(on, "type".into(), name.clone())));
            let subtypes = list.subtypes.iter().flatten().filter(|_| on == On::Lanelet);
            all.extend(subtypes.map(|subtype| Word::Value(on, "subtype".into(), subtype.clone())));
        }
    }
    all.extend(table.paint.words.iter().map(|word| Word::Value(On::LineString, "subtype".into(), word.clone())));
    for roles in table.roles.iter().filter(|roles| roles.of != "multipolygon") {
        all.extend(roles.words.iter().map(|role| Word::Role(roles.of.clone(), role.clone())));
    }
    all
}

/// The word with one character too many, missing, another, or two exchanged.
fn slip(word: &str, dice: &mut Dice) -> String {
    let mut letters: Vec<char> = word.chars().collect();
    let letter = char::from(b'a' + dice.below(26) as u8);
    let at = dice.below(letters.len());
    let before_last = at.min(letters.len().saturating_sub(2));
    match dice.below(4) {
        0 => letters.insert(at, letter),
        1 if letters.len() > 2 => _ = letters.remove(at),
        2 if letters.len() > 1 => letters.swap(before_last, before_last + 1),
        _ => letters[at] = letter,
    }
    letters.into_iter().collect()
}

/// Misspells a word on a primitive that is not used yet; the primitive, and what is written. `None` where the slip is no slip, or
/// the map has no such primitive.
fn misspell(map: &mut Draft, word: &Word, used: &mut BTreeSet<Subject>, dice: &mut Dice) -> Option<(Subject, String)> {
    let on = match word {
        Word::Key(on, _) | Word::Value(on, ..) => *on,
        Word::Role(of, _) if of == "lanelet" => On::Lanelet,
        Word::Role(..) => On::Element,
    };
    let is_area = |tags: &lanewright::osm::Tags| tags.is("area", "yes");
    let subjects: Vec<Subject> = match on {
        On::Point => map.nodes.iter().map(|node| Subject::Point(node.id)).collect(),
        On::LineString => {
            map.ways.iter().filter(|way| !is_area(&way.tags)).map(|way| Subject::LineString(way.id)).collect()
        }
        On::Polygon => map.ways.iter().filter(|way| is_area(&way.tags)).map(|way| Subject::Polygon(way.id)).collect(),
        On::Lanelet => map.lanelets().map(|it| Subject::Lanelet(it.id)).collect(),
        On::Element => {
            let elements = map.relations.iter().filter(|it| it.tags.is("type", "regulatory_element"));
            let of = |it: &&Relation| !matches!(word, Word::Role(of, role) if !it.tags.is("subtype", of) || !it.members.iter().any(|member| member.role == *role));
            elements.filter(of).map(|it| Subject::RegulatoryElement(it.id)).collect()
        }
        On::Area => Vec::new(),
    };
    let subject = dice.pick(subjects.into_iter().filter(|subject| !used.contains(subject)))?;
    let id = subject.id()?;
    let right = match word {
        Word::Key(_, key) => key,
        Word::Value(_, _, value) => value,
        Word::Role(_, role) => role,
    };
    let wrong = slip(right, dice);
    if wrong == *right {
        return None;
    }
    if let Word::Role(_, role) = word {
        let member = map.relation(id).members.iter_mut().find(|member| member.role == *role)?;
        member.role = wrong.as_str().into();
    } else {
        let tags = match subject {
            Subject::Point(_) => &mut map.node(id).tags,
            Subject::LineString(_) | Subject::Polygon(_) => &mut map.way(id).tags,
            _ => &mut map.relation(id).tags,
        };
        match word {
            Word::Key(..) => tags.set(wrong.as_str(), "yes"),
            Word::Value(_, key, _) => tags.set(key.as_str(), wrong.as_str()),
            Word::Role(..) => {}
        }
    }
    used.insert(subject);
    Some((subject, wrong))
}

#[test]
fn one_character_wrong_in_a_known_word_is_told() {
    let (all, bases) = (all_words(), bases());
    let rounds = DRAWS[usize::from(soak())] / AT_ONCE;
    let outcomes: Vec<(usize, Vec<String>)> = (0..rounds)
        .into_par_iter()
        .map(|round| {
            let (base, mut dice) = (&bases[round % bases.len()], Dice(7000 + round as u64));
            let mut draft = base.draft.clone();
            let (mut used, mut slips) = (BTreeSet::new(), Vec::new());
            for _ in 0..AT_ONCE * 20 {
                if slips.len() < AT_ONCE
                    && let Some(word) = dice.pick(all.iter())
                    && let Some((subject, wrong)) = misspell(&mut draft, word, &mut used, &mut dice)
                {
                    slips.push((subject, wrong, word));
                }
            }
            let found = base.judge(&draft);
            let new: Vec<_> = found.iter().filter(|one| base.is_new(one)).collect();
            let missed = slips.iter().filter(|(subject, wrong, _)| {
                let names = |word: &str| word.contains(wrong.as_str());
                !new.iter().any(|one| one.finding.subject.id() == subject.id() && names(&one.finding.message))
            });
            (slips.len(), missed.map(|(subject, wrong, word)| format!("{wrong} for {word:?} on {subject}")).collect())
        })
        .collect();
    let count: usize = outcomes.iter().map(|(count, _)| count).sum();
    let missed: Vec<&String> = outcomes.iter().flat_map(|(_, missed)| missed).collect();
    let told = 1.0 - missed.len() as f64 / count as f64;
    println!("{count} words misspelt, {} told ({:.1} %); not told:", count - missed.len(), told * 100.0);
    missed.iter().for_each(|one| println!("  {one}"));
    assert!(count + AT_ONCE > DRAWS[usize::from(soak())], "only {count} words were misspelt");
    assert!(told >= TOLD, "{:.1} % of {count} slips are told", told * 100.0);
}

/// A lanelet of `subtype=road` that another road leads into.
fn roads(map: &Draft) -> Vec<i64> {
    map.lanelets().filter(|lanelet| lanelet.tags.is("subtype", "road")).map(|lanelet| lanelet.id).collect()
}

/// Sets a tag of a road.
macro_rules! road {
    ($name:literal, $raises:expr, $key:literal, $values:expr) => {
        kind($name, $raises, |_: &Base, map, dice| {
            let id = dice.pick(roads(map))?;
            let values: &[&str] = $values;
            map.relation(id).tags.set($key, dice.pick(values.iter().copied())?);
            Some(vec![id])
        })
    };
}

/// A traffic light with a tag of its own about others.
macro_rules! light {
    ($name:literal, $raises:expr, $key:literal, $value:literal) => {
        kind($name, $raises, |_: &Base, map, dice| {
            let is_light = |one: &&Relation| one.tags.is("subtype", "traffic_light");
            let id = dice.pick(map.relations.iter().filter(is_light))?.id;
            map.relation(id).tags.set($key, $value);
            Some(vec![id])
        })
    };
}

pub const KINDS: &[Kind] = &[
    kind("misspell the type of a bound", &["tag/value"], |_, map, dice| {
        let lane = dice.pick(roads(map))?;
        let way = dice.pick(bounds(map.relation(lane)))?;
        let right = map.way(way).tags.get("type")?.to_owned();
        let wrong = (0..9).map(|_| slip(&right, dice)).find(|wrong| *wrong != right)?;
        map.way(way).tags.set("type", wrong.as_str());
        Some(vec![way])
    }),
    kind("say the type of a bound in another word", &["tag/value"], |_, map, dice| {
        let lane = dice.pick(roads(map))?;
        let way = dice.pick(bounds(map.relation(lane)))?;
        map.way(way).tags.set("type", dice.pick(["line", "road_edge", "kerb", "lane_marking", "white_line"])?);
        Some(vec![way])
    }),
    kind("say the paint of a bound in another word", &["tag/value"], |_, map, dice| {
        let lane = dice.pick(roads(map))?;
        let ways = bounds(map.relation(lane));
        let is_paint = |way: &i64| map.ways.iter().any(|one| one.id == *way && one.tags.is("type", "line_thin"));
        let way = dice.pick(ways.into_iter().filter(is_paint))?;
        map.way(way).tags.set("subtype", dice.pick(["dotted", "broken", "solid_white", "continuous", "double_solid"])?);
        Some(vec![way])
    }),
    road!("follow a line that is none", &["tag/id"], "waypoints", &["7"]),
    kind("misspell a key of a lanelet", &["tag/key"], |_, map, dice| {
        let lane = dice.pick(roads(map))?;
        map.relation(lane)
            .tags
            .set(dice.pick(["turn_directon", "participants:vehicle", "speedlimit", "loaction"])?, "yes");
        Some(vec![lane])
    }),
    kind("misspell the role of a stop line", &["tag/role"], |_, map, dice| {
        let has = |one: &&Relation| one.members.iter().any(|member| member.role == "ref_line");
        let id = dice.pick(map.relations.iter().filter(has))?.id;
        map.relation(id).members.iter_mut().find(|member| member.role == "ref_line")?.role = "ref_lien".into();
        Some(vec![id])
    }),
    kind("limit a road twice", &["tag/twice"], |_, map, dice| {
        let id = dice.pick(roads(map))?;
        map.relation(id).tags.push("speed_limit", "61");
        map.relation(id).tags.push("speed_limit", "62");
        Some(vec![id])
    }),
    road!("call a road otherwise", &["access/not-road"], "subtype", &["highway", "", "tram_lane", "street"]),
    road!("close a road to all by naming one", &["access/closed"], "participant:vehicle", &["designated", "no"]),
    road!("forbid a road to a kind of the vehicles it lets in", &["access/hidden"], "participant:vehicle:car", &["no"]),
    road!("hide a speed limit", &["access/standstill"], "speed_limit:vehicle", &["0"]),
    road!("let a lane reverse by the tag's former name", &["tag/renamed"], "direction_change_lane", &["yes"]),
    road!("ask for an approval where nobody asks", &["tag/misplaced"], "rtc_approval_required_v1", &["crosswalk"]),
    road!("close a lane to the vehicle with another word", &["tag/value"], "no_drivable_lane", &["true"]),
    road!("put on the signal with another word", &["roundabout/not-true"], "enable_exit_turn_signal", &["yes", "1"]),
    road!("name an exit outside every roundabout", &["roundabout/no-exit"], "exit_turn_signal_left", &["7"]),
    road!("name an exit by a key", &["roundabout/old-tag"], "7", &["turn_signal_left", "turn_signal_right"]),
    light!("name a light that is none", &["signal/target"], "signal_color_relation:red:green", "7"),
    light!("name a lamp that is none", &["signal/lamp"], "signal_color_relation:yellow:green", "7"),
    light!("put a blank before a light", &["signal/blank"], "signal_color_relation:red:green", "7, 8"),
    kind("make an edge of the road a curb", &["parts/curbstone"], |_, map, dice| {
        let lane = dice.pick(roads(map))?;
        let ways = bounds(map.relation(lane));
        let way = dice.pick(
            ways.into_iter()
                .filter(|way| map.ways.iter().any(|one| one.id == *way && one.tags.is("type", "road_border"))),
        )?;
        map.way(way).tags.set("type", "curbstone");
        Some(Vec::new())
    }),
    kind("add a speed limit that no lanelet knows", &["parts/unreferenced"], |_, map, dice| {
        let like = dice.pick(map.relations.iter())?.clone();
        let (id, way) = (map.fresh(), dice.pick(map.lines("stop_line"))?.id);
        let tags =
            [("type", "regulatory_element"), ("subtype", "speed_limit"), ("sign_type", "30")].into_iter().collect();
        let members = vec![Member { kind: ElementKind::Way, id: way, role: "ref_line".into() }];
        map.relations.push(Relation { id, tags, members, ..like });
        Some(vec![id])
    }),
];
