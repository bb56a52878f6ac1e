//! PBF files around blocks of any content, so that faults lie inside the block and not in its packing.

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
