//! Faults that a stream of bytes chooses are injected into maps, for the tests and for the fuzzers in `fuzz/`. The files stay
//! well-formed XML; their content is what broken editors and converters, or attackers, write.

#![allow(clippy::unwrap_used, dead_code, missing_docs, reason = "part of tests")]

pub mod pbf;

use lanewright::osm::{ElementKind, Member, Node, OsmData, OsmText, Relation, Tags, Way, read_bytes};
use lanewright::projection::LonLat;

/// Values that tools write by mistake, or that mean to harm.
pub const ODD: [&str; 32] = [
    "",
    "0",
    "-1",
    "1",
    "2",
    "3",
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "150",
    "2147483648",
    "-9223372036854775808",
    "9223372036854775807",
    "left",
    "right",
    "straight",
    "virtual",
    "yes",
    "no",
    "é",
    "yield",
    "refers",
    "ref_line",
    "lanelet",
    "regulatory_element",
    "right_of_way",
    "through|left;right|none",
    "50 mph",
    "3 m; 4'6\"",
];

/// Degrees where arithmetic goes wrong.
const FAR: [f64; 10] = [0.0, -0.0, 90.0, -90.0, 180.0, -180.0, 84.0, 1e-300, f64::NAN, 139.999_999_999];

/// Ids where arithmetic goes wrong.
const IDS: [i64; 6] = [0, -1, i64::MIN, i64::MAX, 1 << 31, 1 << 62];

/// Bytes that decide; zeroes when they are used up.
pub struct Dice<'a>(&'a [u8]);

impl Dice<'_> {
    fn byte(&mut self) -> usize {
        match self.0 {
            [first, rest @ ..] => {
                let byte = usize::from(*first);
                self.0 = rest;
                byte
            }
            [] => 0,
        }
    }

    fn below(&mut self, count: usize) -> Option<usize> {
        let number = self.byte() << 8 | self.byte();
        (count > 0).then(|| number % count)
    }

    fn pick<'t, T>(&mut self, from: &'t [T]) -> Option<&'t T> {
        from.get(self.below(from.len())?)
    }

    fn pick_mut<'t, T>(&mut self, from: &'t mut [T]) -> Option<&'t mut T> {
        let at = self.below(from.len())?;
        from.get_mut(at)
    }
}

/// The elements of a file.
struct Draft {
    nodes: Vec<Node>,
    ways: Vec<Way>,
    relations: Vec<Relation>,
    /// Every tag there is, as a store of values.
    said: Vec<(String, String)>,
    roles: Vec<String>,
}

/// The file of `seed`, changed at most `most` times as the bytes say.
pub fn changed(seed: &str, bytes: &[u8], most: usize) -> Vec<u8> {
    let mut data = OsmData::default();
    read_bytes(&mut data, "seed", seed.as_bytes().to_vec()).unwrap();
    let meta = data.meta.clone().unwrap_or_default();
    let mut draft = Draft::of(data);
    let mut dice = Dice(bytes);
    for _ in 0..most {
        if dice.0.is_empty() {
            break;
        }
        draft.change(&mut dice);
    }
    let mut out = OsmText::default();
    draft.nodes.iter().for_each(|node| out.node(node.id, node.position, node.tags.iter()));
    draft.ways.iter().for_each(|way| out.way(way.id, way.nodes.iter().copied(), way.tags.iter()));
    for relation in &draft.relations {
        let members = relation.members.iter().map(|member| (member.kind, member.id, member.role.as_str()));
        out.relation(relation.id, members, relation.tags.iter());
    }
    [OsmText::head(&meta), out, OsmText::tail()].map(|text| text.as_bytes().to_vec()).concat()
}

impl Draft {
    fn of(data: OsmData) -> Self {
        let OsmData { nodes, ways, relations, .. } = data;
        let tags = nodes.iter().map(|one| &one.tags).chain(ways.iter().map(|one| &one.tags));
        let tags = tags.chain(relations.iter().map(|one| &one.tags));
        let said = tags.flat_map(Tags::iter).map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
        let roles = relations.iter().flat_map(|one| &one.members).map(|member| member.role.to_string()).collect();
        Self { nodes, ways, relations, said, roles }
    }

    /// One change; `None` where there is nothing to change so.
    fn change(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        match dice.byte() % 8 {
            0 => self.retag(dice),
            1 => self.move_node(dice),
            2 | 3 => self.change_way(dice),
            4 | 5 => self.change_relation(dice),
            6 => self.renumber(dice),
            _ => self.delete_or_repeat(dice),
        }
    }

    fn retag(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        let (key, value) = dice.pick(&self.said)?.clone();
        let odd = (*dice.pick(&ODD)?).to_owned();
        let tags = match dice.byte() % 4 {
            0 => &mut dice.pick_mut(&mut self.nodes)?.tags,
            1 => &mut dice.pick_mut(&mut self.ways)?.tags,
            _ => &mut dice.pick_mut(&mut self.relations)?.tags,
        };
        let all: Vec<(String, String)> = tags.iter().map(|(k, v)| (k.to_owned(), v.to_owned())).collect();
        match dice.byte() % 4 {
            0 => tags.set(key, value),
            1 => tags.set(key, odd),
            2 => tags.set(dice.pick(&all)?.0.as_str(), odd),
            _ => {
                let gone = dice.below(all.len())?;
                *tags = all.into_iter().enumerate().filter(|(at, _)| *at != gone).map(|(_, tag)| tag).collect();
            }
        }
        Some(())
    }

    fn move_node(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        let other = dice.pick(&self.nodes)?.position;
        let node = dice.pick_mut(&mut self.nodes)?;
        node.position = match dice.byte() % 4 {
            0 => other,
            1 => Some(LonLat { lon: *dice.pick(&FAR)?, lat: *dice.pick(&FAR)? }),
            2 => None,
            _ => {
                // Steps of a decimetre, up to some ten metres.
                let mut step = || (dice.byte() as f64 - 128.0) * 1e-6;
                let (east, north) = (step(), step());
                node.position.map(|at| LonLat { lon: at.lon + east, lat: at.lat + north })
            }
        };
        // Maps that go by local coordinates are moved, too.
        if dice.byte().is_multiple_of(2) && node.tags.has("local_x") {
            let odd = dice.pick(&ODD)?;
            node.tags.set("local_x", *odd);
        }
        Some(())
    }

    fn change_way(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        let node = dice.pick(&self.nodes)?.id;
        let other = dice.pick(&self.ways)?.nodes.clone();
        let nodes = &mut dice.pick_mut(&mut self.ways)?.nodes;
        let at = dice.below(nodes.len())?;
        match dice.byte() % 9 {
            0 => drop(nodes.remove(at)),
            1 => nodes.insert(at, node),
            2 => nodes[at] = node,
            3 => nodes.insert(at, nodes[at]),
            4 => nodes.reverse(),
            5 => nodes.truncate(at),
            6 => nodes.fill(node),
            7 => nodes.extend(other),
            _ => *nodes = other,
        }
        Some(())
    }

    fn change_relation(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        let kind = [ElementKind::Node, ElementKind::Way, ElementKind::Relation][dice.byte() % 3];
        let id = self.any(kind, dice)?;
        let role = dice.pick(&self.roles).map_or("left", String::as_str).into();
        let other = dice.pick(&self.relations)?.members.clone();
        let members = &mut dice.pick_mut(&mut self.relations)?.members;
        let at = dice.below(members.len())?;
        match dice.byte() % 7 {
            0 => drop(members.remove(at)),
            1 => members.push(Member { kind, id, role }),
            2 => members[at].role = role,
            3 => (members[at].kind, members[at].id) = (kind, id),
            4 => {
                let to = dice.below(members.len())?;
                let (a, b) = (members[at].id, members[to].id);
                (members[at].id, members[to].id) = (b, a);
            }
            5 => members.extend(other),
            _ => *members = other,
        }
        Some(())
    }

    fn any(&self, kind: ElementKind, dice: &mut Dice<'_>) -> Option<i64> {
        match kind {
            ElementKind::Node => dice.pick(&self.nodes).map(|one| one.id),
            ElementKind::Way => dice.pick(&self.ways).map(|one| one.id),
            ElementKind::Relation => dice.pick(&self.relations).map(|one| one.id),
        }
    }

    fn renumber(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        let kinds = [ElementKind::Node, ElementKind::Way, ElementKind::Relation];
        let theirs = self.any(kinds[dice.byte() % 3], dice)?;
        let id = if dice.byte().is_multiple_of(2) { theirs } else { *dice.pick(&IDS)? };
        match dice.byte() % 3 {
            0 => dice.pick_mut(&mut self.nodes)?.id = id,
            1 => dice.pick_mut(&mut self.ways)?.id = id,
            _ => dice.pick_mut(&mut self.relations)?.id = id,
        }
        Some(())
    }

    fn delete_or_repeat(&mut self, dice: &mut Dice<'_>) -> Option<()> {
        fn either<T: Clone>(all: &mut Vec<T>, dice: &mut Dice<'_>) -> Option<()> {
            let at = dice.below(all.len())?;
            match dice.byte() % 3 {
                0 => all.push(all[at].clone()),
                1 => all.insert(0, all[at].clone()),
                _ => drop(all.remove(at)),
            }
            Some(())
        }
        match dice.byte() % 3 {
            0 => either(&mut self.nodes, dice),
            1 => either(&mut self.ways, dice),
            _ => either(&mut self.relations, dice),
        }
    }
}

/// The text with the `nth` quoted value replaced.
pub fn with_value(text: &str, nth: usize, value: &str) -> String {
    let quotes: Vec<usize> = text.match_indices('"').map(|(at, _)| at).collect();
    let pairs: Vec<(usize, usize)> = quotes.chunks_exact(2).map(|pair| (pair[0] + 1, pair[1])).collect();
    let (from, to) = pairs[nth % pairs.len()];
    format!("{}{value}{}", &text[..from], &text[to..])
}
