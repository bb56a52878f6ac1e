//! PBF files around blocks of any content, so that faults lie inside the block and not in its packing.

#![allow(dead_code, reason = "not all tests that pack blocks pack whole files")]

use std::collections::BTreeMap;

use lanewright::osm::{ElementKind, OsmData, Tags};

/// One field of a protocol buffer: bytes under a number.
pub fn field(number: u8, bytes: &[u8]) -> Vec<u8> {
    let mut out = vec![number << 3 | 2];
    out.extend(varint(bytes.len() as u64));
    out.extend_from_slice(bytes);
    out
}

/// A number in as few bytes as it takes.
pub fn varint(mut value: u64) -> Vec<u8> {
    let mut out = Vec::new();
    while value >= 0x80 {
        out.push(value as u8 | 0x80);
        value >>= 7;
    }
    out.push(value as u8);
    out
}

/// One field of a protocol buffer: a number under a number.
pub fn number(at: u8, value: u64) -> Vec<u8> {
    [vec![at << 3], varint(value)].concat()
}

fn zigzag(value: i64) -> u64 {
    (value << 1 ^ value >> 63) as u64
}

/// A blob of this kind, not packed, with its header before it.
fn blob(kind: &str, content: &[u8]) -> Vec<u8> {
    let body = [field(1, content), number(2, content.len() as u64)].concat();
    let header = [field(1, kind.as_bytes()), number(3, body.len() as u64)].concat();
    [&(header.len() as u32).to_be_bytes()[..], &header, &body].concat()
}

/// A file with one block of data.
pub fn file(block: &[u8]) -> Vec<u8> {
    let header = field(4, b"OsmSchema-V0.6");
    [blob("OSMHeader", &header), blob("OSMData", block)].concat()
}

/// A sound block: a road of two nodes, and a relation of it.
pub fn block() -> Vec<u8> {
    let words = ["", "highway", "residential", "name", "é", "type", "route", "outer"];
    let strings: Vec<u8> = words.iter().flat_map(|word| field(1, word.as_bytes())).collect();
    let packed = |values: &[u64]| values.iter().flat_map(|&value| varint(value)).collect::<Vec<u8>>();
    let signed = |values: &[i64]| packed(&values.iter().map(|&value| zigzag(value)).collect::<Vec<_>>());
    let dense = [
        field(1, &signed(&[1, 1])),
        field(8, &signed(&[361_000_000, 1_000])),
        field(9, &signed(&[1_401_000_000, 2_000])),
        field(10, &packed(&[3, 4, 0, 0])),
    ]
    .concat();
    let node = [number(1, zigzag(3)), number(8, zigzag(361_000_500)), number(9, zigzag(1_401_000_500))].concat();
    let way = [number(1, 20), field(2, &packed(&[1])), field(3, &packed(&[2])), field(8, &signed(&[1, 1]))].concat();
    let relation = [
        number(1, 30),
        field(2, &packed(&[5])),
        field(3, &packed(&[6])),
        field(8, &packed(&[7])),
        field(9, &signed(&[20])),
        field(10, &packed(&[1])),
    ]
    .concat();
    let groups = [field(1, &node), field(2, &dense), field(3, &way), field(4, &relation)];
    let groups: Vec<u8> = groups.iter().flat_map(|group| field(2, group)).collect();
    [field(1, &strings), groups].concat()
}

fn packed(values: impl Iterator<Item = u64>) -> Vec<u8> {
    values.flat_map(varint).collect()
}

/// Numbers as the differences to those before them.
fn differences(values: impl Iterator<Item = i64>) -> Vec<u8> {
    let mut before = 0;
    packed(values.map(|value| zigzag(value - std::mem::replace(&mut before, value))))
}

/// The words of a block, by their numbers.
#[derive(Default)]
struct Words {
    numbers: BTreeMap<String, u64>,
    table: Vec<u8>,
}

impl Words {
    fn number(&mut self, word: &str) -> u64 {
        if self.table.is_empty() {
            self.table = field(1, b"");
        }
        let next = self.numbers.len() as u64 + 1;
        *self.numbers.entry(word.to_owned()).or_insert_with(|| {
            self.table.extend(field(1, word.as_bytes()));
            next
        })
    }

    /// Fields for keys and for values.
    fn tags(&mut self, tags: &Tags) -> Vec<u8> {
        let pairs: Vec<[u64; 2]> = tags.iter().map(|(key, value)| [self.number(key), self.number(value)]).collect();
        [0, 1].map(|of| field(2 + of as u8, &packed(pairs.iter().map(|pair| pair[of])))).concat()
    }
}

/// A block with one group: fields of nodes, ways or relations.
fn group(words: Words, elements: &[u8]) -> Vec<u8> {
    blob("OSMData", &[field(1, &words.table), field(2, elements)].concat())
}

/// A file with these elements, some thousands a block, which names no bounds.
pub fn of(data: &OsmData) -> Vec<u8> {
    const EACH: usize = 4000;
    let mut file = blob("OSMHeader", &[field(4, b"OsmSchema-V0.6"), field(4, b"DenseNodes")].concat());
    for nodes in data.nodes.chunks(EACH) {
        let mut words = Words::default();
        let place = |of: f64| (of * 1e7).round() as i64;
        let places = || nodes.iter().map(|node| node.position.unwrap());
        let mut tags = Vec::new();
        for node in nodes {
            tags.extend(node.tags.iter().flat_map(|(key, value)| [words.number(key), words.number(value)]));
            tags.push(0);
        }
        let dense = [
            field(1, &differences(nodes.iter().map(|node| node.id))),
            field(8, &differences(places().map(|at| place(at.lat)))),
            field(9, &differences(places().map(|at| place(at.lon)))),
            field(10, &packed(tags.into_iter())),
        ];
        file.extend(group(words, &field(2, &dense.concat())));
    }
    for ways in data.ways.chunks(EACH) {
        let mut words = Words::default();
        let way = |way: &lanewright::osm::Way| {
            let nodes = field(8, &differences(way.nodes.iter().copied()));
            field(3, &[number(1, way.id as u64), words.tags(&way.tags), nodes].concat())
        };
        let ways: Vec<u8> = ways.iter().flat_map(way).collect();
        file.extend(group(words, &ways));
    }
    for relations in data.relations.chunks(EACH) {
        let mut words = Words::default();
        let relation = |relation: &lanewright::osm::Relation| {
            let members = || relation.members.iter();
            let kind = |kind: ElementKind| {
                [ElementKind::Node, ElementKind::Way, ElementKind::Relation].iter().position(|one| *one == kind)
            };
            let roles: Vec<u64> = members().map(|member| words.number(&member.role)).collect();
            let parts = [
                number(1, relation.id as u64),
                words.tags(&relation.tags),
                field(8, &packed(roles.into_iter())),
                field(9, &differences(members().map(|member| member.id))),
                field(10, &packed(members().map(|member| kind(member.kind).unwrap() as u64))),
            ];
            field(4, &parts.concat())
        };
        let relations: Vec<u8> = relations.iter().flat_map(relation).collect();
        file.extend(group(words, &relations));
    }
    file
}
