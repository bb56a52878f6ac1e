//! A map as a few compressed columns of numbers: small in a page, quick to read into typed arrays.
//!
//! The packed bytes are raw deflate of: length of the header (u32, little-endian), header (JSON), columns. A column is
//! a list of whole numbers, each as its difference to the one before, written byte plane by byte plane: all lowest
//! bytes, then all second bytes, ... which deflate packs better than the numbers one by one.

use std::io::{self, Write};

use flate2::Compression;
use flate2::write::DeflateEncoder;
use rustc_hash::FxHashMap;
use serde::Serialize;
use serde_json::json;

use super::plane::Frame;
use crate::lanelet::{Attributes, Bound, LaneletMap, PointId, Target};
use crate::report::levels::Levels;

/// Positions are kept to the millimetre, as whole numbers.
pub const STEPS_PER_METRE: f64 = 1000.0;

/// Packs the map. Fails only where the compressor does.
pub fn pack(map: &LaneletMap, frame: &Frame) -> io::Result<Vec<u8>> {
    let mut packer = Packer::default();
    packer.points(map, frame);
    packer.ways(map);
    packer.lanelets(map);
    packer.regulatory_elements(map);
    packer.levels(map);
    packer.finish()
}

/// What the header says of one column.
#[derive(Serialize)]
struct Column {
    name: &'static str,
    count: usize,
    /// Bytes per number: 4 or 8.
    width: usize,
}

#[derive(Default)]
struct Packer {
    header: Vec<Column>,
    bytes: Vec<u8>,
    strings: Vec<String>,
    string_index: FxHashMap<String, i32>,
    tag_sets: Vec<Vec<(i32, i32)>>,
    tag_index: FxHashMap<Vec<(i32, i32)>, i32>,
    /// By the point's position in its layer: its number in the page.
    point_numbers: Vec<i32>,
}

impl Packer {
    /// Points in the order in which ways use them, so that neighbours have small differences.
    fn points(&mut self, map: &LaneletMap, frame: &Frame) {
        self.point_numbers = vec![-1; map.points.len()];
        let mut order = Vec::with_capacity(map.points.len());
        let used = map.linestrings.iter().flat_map(|l| &l.points).chain(map.polygons.iter().flat_map(|p| &p.points));
        let positions = used.filter_map(|&id| map.points.position(id)).chain(0..map.points.len());
        for position in positions {
            if self.point_numbers[position] < 0 {
                self.point_numbers[position] = order.len() as i32;
                order.push(&map.points.as_slice()[position]);
            }
        }
        let tags: Vec<i32> = order.iter().map(|p| self.tags(p.attributes())).collect();
        self.wide("point.id", order.iter().map(|p| p.id.0));
        self.column("point.x", order.iter().map(|p| steps(p.position.x - frame.origin.x)));
        self.column("point.y", order.iter().map(|p| steps(p.position.y - frame.origin.y)));
        self.column("point.tags", tags);
    }

    fn ways(&mut self, map: &LaneletMap) {
        let lines: Vec<_> = map.linestrings.iter().map(|l| (l.id.0, &l.points, &l.attributes)).collect();
        self.way_kind(map, ["line.id", "line.tags", "line.count", "line.points"], &lines);
        // The page shows areas as polygons; only those behind them are relations.
        let areas = map.areas.iter().map(|a| (a.id.0, &a.points, &a.attributes));
        let polygons: Vec<_> = map.polygons.iter().map(|p| (p.id.0, &p.points, &p.attributes)).chain(areas).collect();
        self.way_kind(map, ["polygon.id", "polygon.tags", "polygon.count", "polygon.points"], &polygons);
    }

    fn way_kind(&mut self, map: &LaneletMap, names: [&'static str; 4], ways: &[(i64, &Vec<PointId>, &Attributes)]) {
        let [id, tags, count, points] = names;
        let numbers: Vec<Vec<i32>> =
            ways.iter().map(|(_, ids, _)| ids.iter().filter_map(|&id| self.point_number(map, id)).collect()).collect();
        let sets: Vec<i32> = ways.iter().map(|(_, _, attributes)| self.tags(attributes)).collect();
        self.wide(id, ways.iter().map(|way| way.0));
        self.column(tags, sets);
        self.column(count, numbers.iter().map(|n| n.len() as i32));
        self.column(points, numbers.into_iter().flatten());
    }

    fn lanelets(&mut self, map: &LaneletMap) {
        // 0: not there; else twice (number of the line + 1), odd where it runs against the lanelet.
        let bound = |bound: Bound| {
            map.linestrings.position(bound.line).map_or(0, |at| (at as i32 + 1) * 2 + i32::from(bound.inverted))
        };
        let rules: Vec<Vec<i32>> = map
            .lanelets
            .iter()
            .map(|l| l.regulatory_elements.iter().filter_map(|&id| map.regulatory_elements.position(id)))
            .map(|positions| positions.map(|at| at as i32).collect())
            .collect();
        let tags: Vec<i32> = map.lanelets.iter().map(|l| self.tags(&l.attributes)).collect();
        self.wide("lanelet.id", map.lanelets.iter().map(|l| l.id.0));
        self.column("lanelet.left", map.lanelets.iter().map(|l| bound(l.left)));
        self.column("lanelet.right", map.lanelets.iter().map(|l| bound(l.right)));
        self.column("lanelet.tags", tags);
        self.column("lanelet.count", rules.iter().map(|r| r.len() as i32));
        self.column("lanelet.rules", rules.into_iter().flatten());
    }

    fn regulatory_elements(&mut self, map: &LaneletMap) {
        let mut members: [Vec<i32>; 4] = Default::default();
        let (mut ids, mut sets) = (Vec::new(), Vec::new());
        for element in &map.regulatory_elements {
            let before = members[1].len();
            for member in &element.members {
                let Some((kind, number)) = self.target(map, member.target) else { continue };
                let role = self.string(&member.role);
                members[1].push(role);
                members[2].push(kind);
                members[3].push(number);
            }
            let count = members[1].len() - before;
            members[0].push(count as i32);
            ids.push(element.id.0);
            let tags = self.tags(&element.attributes);
            sets.push(tags);
        }
        self.wide("rule.id", ids);
        self.column("rule.tags", sets);
        for (name, values) in ["rule.count", "rule.role", "rule.kind", "rule.member"].into_iter().zip(members) {
            self.column(name, values);
        }
    }

    /// What is shown above what: nothing is said of a map where nothing passes over anything.
    fn levels(&mut self, map: &LaneletMap) {
        let levels = Levels::of(map);
        if levels.count() > 1 {
            let whole = |levels: Vec<usize>| levels.into_iter().map(|level| level as i32);
            self.column("line.level", whole(levels.lines));
            self.column("polygon.level", whole(levels.polygons).chain(whole(levels.areas)));
            self.column("lanelet.level", whole(levels.lanelets));
        }
    }

    /// Kind, as the page numbers them, and number among its kind.
    fn target(&self, map: &LaneletMap, target: Target) -> Option<(i32, i32)> {
        let number = |position: Option<usize>| position.map(|at| at as i32);
        match target {
            Target::Point(id) => Some((0, self.point_number(map, id)?)),
            Target::LineString(id) => Some((1, number(map.linestrings.position(id))?)),
            Target::Polygon(id) => Some((2, number(map.polygons.position(id))?)),
            Target::Lanelet(id) => Some((3, number(map.lanelets.position(id))?)),
        }
    }

    fn point_number(&self, map: &LaneletMap, id: PointId) -> Option<i32> {
        self.point_numbers.get(map.points.position(id)?).copied()
    }

    fn string(&mut self, text: &str) -> i32 {
        if let Some(&at) = self.string_index.get(text) {
            return at;
        }
        let at = self.strings.len() as i32;
        self.strings.push(text.to_owned());
        self.string_index.insert(text.to_owned(), at);
        at
    }

    /// The number of a set of tags; most primitives share theirs with many others.
    fn tags(&mut self, attributes: &Attributes) -> i32 {
        let set: Vec<(i32, i32)> = attributes.iter().map(|(k, v)| (self.string(k), self.string(v))).collect();
        if let Some(&at) = self.tag_index.get(&set) {
            return at;
        }
        let at = self.tag_sets.len() as i32;
        self.tag_sets.push(set.clone());
        self.tag_index.insert(set, at);
        at
    }

    fn column(&mut self, name: &'static str, values: impl IntoIterator<Item = i32>) {
        let mut last = 0_i32;
        let differences = values.into_iter().map(|v| v.wrapping_sub(std::mem::replace(&mut last, v)).to_le_bytes());
        let differences: Vec<[u8; 4]> = differences.collect();
        self.planes(name, &differences);
    }

    fn wide(&mut self, name: &'static str, values: impl IntoIterator<Item = i64>) {
        let mut last = 0_i64;
        let differences = values.into_iter().map(|v| v.wrapping_sub(std::mem::replace(&mut last, v)).to_le_bytes());
        let differences: Vec<[u8; 8]> = differences.collect();
        self.planes(name, &differences);
    }

    fn planes<const N: usize>(&mut self, name: &'static str, values: &[[u8; N]]) {
        self.header.push(Column { name, count: values.len(), width: N });
        for plane in 0..N {
            self.bytes.extend(values.iter().map(|bytes| bytes[plane]));
        }
    }

    fn finish(mut self) -> io::Result<Vec<u8>> {
        let sets = std::mem::take(&mut self.tag_sets);
        self.column("tags.count", sets.iter().map(|set| set.len() as i32));
        self.column("tags.key", sets.iter().flatten().map(|pair| pair.0));
        self.column("tags.value", sets.iter().flatten().map(|pair| pair.1));
        let header = json!({ "columns": self.header, "strings": self.strings }).to_string();
        let length = u32::try_from(header.len()).map_err(io::Error::other)?;
        let mut deflate = DeflateEncoder::new(Vec::new(), Compression::new(7));
        deflate.write_all(&length.to_le_bytes())?;
        deflate.write_all(header.as_bytes())?;
        deflate.write_all(&self.bytes)?;
        deflate.finish()
    }
}

/// Metres as whole steps; what is no number, or beyond 2000 km, is held to the range.
pub fn steps(metres: f64) -> i32 {
    // `as` saturates and turns NaN into 0.
    (metres * STEPS_PER_METRE).round() as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn columns_are_differences_in_planes() {
        let mut packer = Packer::default();
        packer.column("a", [1, 2, 258, 257]);
        assert_eq!(packer.bytes, [1, 1, 0, 255, 0, 0, 1, 255, 0, 0, 0, 255, 0, 0, 0, 255]);
    }

    #[test]
    fn equal_tags_are_kept_once() {
        let mut packer = Packer::default();
        let road: Attributes = [("type", "lanelet"), ("subtype", "road")].into_iter().collect();
        let other: Attributes = [("type", "lanelet")].into_iter().collect();
        assert_eq!([packer.tags(&road), packer.tags(&other), packer.tags(&road)], [0, 1, 0]);
        assert_eq!(packer.strings, ["type", "lanelet", "subtype", "road"]);
    }

    #[test]
    fn an_empty_map_packs() {
        let map = LaneletMap::default();
        let packed = pack(&map, &Frame::of(&map, None)).unwrap();
        let mut raw = Vec::new();
        flate2::read::DeflateDecoder::new(packed.as_slice()).read_to_end(&mut raw).unwrap();
        let length = u32::from_le_bytes(raw[..4].try_into().unwrap()) as usize;
        let header: serde_json::Value = serde_json::from_slice(&raw[4..4 + length]).unwrap();
        assert_eq!(header["columns"][0]["name"], "point.id");
        assert_eq!(raw.len(), 4 + length);
    }

    #[test]
    fn wild_coordinates_are_held_to_the_range() {
        assert_eq!(steps(f64::NAN), 0);
        assert_eq!(steps(1e300), i32::MAX);
        assert_eq!(steps(-1.2344), -1234);
    }
}
