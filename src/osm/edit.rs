//! Changes of what a file says: in memory, to see what comes of them, and in the file's text, to keep them.

use super::{OsmData, Text, fixed};
use crate::projection::{Extent, LonLat};

/// Decimals of a degree that OpenStreetMap keeps: a centimetre.
const DECIMALS: usize = 7;

/// A place as OpenStreetMap would keep it.
pub fn kept(place: LonLat) -> LonLat {
    let steps = 10_f64.powi(DECIMALS as i32);
    let kept = |degrees: f64| (degrees * steps).round() / steps;
    LonLat { lon: kept(place.lon), lat: kept(place.lat) }
}

impl OsmData {
    /// Puts a node elsewhere; whether there is such a node.
    pub fn move_node(&mut self, id: i64, place: LonLat) -> bool {
        let Some(node) = self.node_index.get(&id).and_then(|&at| self.nodes.get_mut(at as usize)) else { return false };
        node.position = Some(place);
        true
    }

    /// Gives a way a tag, or takes it; whether there is such a way.
    pub fn tag_way(&mut self, id: i64, key: &str, value: Option<&str>) -> bool {
        let Some(way) = self.way_index.get(&id).and_then(|&at| self.ways.get_mut(at as usize)) else { return false };
        match value {
            Some(value) => way.tags.set(key, value),
            None => way.tags = way.tags.iter().filter(|(k, _)| *k != key).map(|(k, v)| (Text::new(k), v)).collect(),
        }
        true
    }

    /// What lies in a box: ways that reach into it, whole, their nodes, lone nodes inside, and relations that have any of
    /// these as members. Sources and oddities stay behind.
    #[must_use]
    pub fn within(&self, extent: &Extent) -> Self {
        let mut part = Self { meta: self.meta.clone(), generator: self.generator.clone(), ..Self::default() };
        let place = |id: &i64| self.node(*id).and_then(|node| node.position);
        let reaches = |nodes: &[i64]| {
            let places: Vec<LonLat> = nodes.iter().filter_map(place).collect();
            places.windows(2).any(|two| Extent::of(two.iter().copied()).is_some_and(|piece| meet(&piece, extent)))
        };
        let ways = self.ways.iter().filter(|way| reaches(&way.nodes));
        ways.for_each(|way| part.push_way(way.clone()));
        let of_ways: rustc_hash::FxHashSet<i64> = part.ways.iter().flat_map(|way| way.nodes.iter().copied()).collect();
        let lies = |at: LonLat| meet(&Extent { min: at, max: at }, extent);
        let nodes = self.nodes.iter().filter(|node| of_ways.contains(&node.id) || node.position.is_some_and(lies));
        nodes.for_each(|node| part.push_node(node.clone()));
        for relation in &self.relations {
            if relation.members.iter().any(|member| part.contains(member.kind, member.id)) {
                part.push_relation(relation.clone());
            }
        }
        part
    }
}

fn meet(a: &Extent, b: &Extent) -> bool {
    a.min.lon <= b.max.lon && b.min.lon <= a.max.lon && a.min.lat <= b.max.lat && b.min.lat <= a.max.lat
}

/// The text of the only file that `osm` was read from, with nodes put elsewhere; nothing else in it changes. `None` where
/// a node does not stand in the text.
pub fn moved(osm: &OsmData, places: &[(i64, LonLat)]) -> Option<String> {
    let mut text = osm.sources.first()?.text.clone();
    let mut moves = Vec::new();
    for (id, place) in places {
        let span = &osm.node(*id)?.span;
        moves.push((usize::try_from(span.start).ok()?, *place));
    }
    // From the end, so that what is before keeps its place.
    moves.sort_by_key(|(start, _)| std::cmp::Reverse(*start));
    for (start, LonLat { lon, lat }) in moves {
        for (name, value) in [("lon", lon), ("lat", lat)] {
            let degrees = fixed(value, DECIMALS);
            let (from, to) = attribute(text.get(start..)?, name)?;
            text.replace_range(start + from..start + to, &degrees);
        }
    }
    Some(text)
}

/// Where the value of an attribute stands in a start tag that the text begins with, in bytes from its start.
pub fn attribute(tag: &str, name: &str) -> Option<(usize, usize)> {
    let (mut at, mut rest) = (0, tag);
    // From value to value: a name inside a value is none.
    loop {
        let equals = rest.find('=')?;
        let key = rest.get(..equals)?.trim_end().rsplit(char::is_whitespace).next()?;
        let quote = rest.get(equals..)?.find(['"', '\''])? + equals;
        let mark = rest.get(quote..)?.chars().next()?;
        let length = rest.get(quote + 1..)?.find(mark)?;
        let value = (at + quote + 1, at + quote + 1 + length);
        if key == name {
            return Some(value);
        }
        at = value.1 + 1;
        rest = tag.get(at..)?;
        if rest.trim_start().starts_with(['>', '/']) {
            return None;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::read_bytes;

    const TEXT: &str = r#"<osm version="0.6">
  <node id="1" note='lat="9" lon=' lat = "48.1" lon='11.5' version="3"/>
  <node id="2" lat="48.2" lon="11.6"><tag k="lat" v="1"/></node>
  <node id="3" lat="48.3" lon="11.7"/>
  <way id="4"><nd ref="1"/><nd ref="2"/><tag k="highway" v="service"/></way>
  <relation id="5"><member type="way" ref="4" role=""/></relation>
</osm>
"#;

    fn data(text: &str) -> OsmData {
        let mut data = OsmData::default();
        read_bytes(&mut data, "test", text.as_bytes().to_vec()).unwrap();
        data
    }

    #[test]
    fn nodes_move_in_the_text_and_nothing_else_does() {
        let places = [(1, LonLat { lon: -11.123_456_78, lat: 48.0 }), (2, LonLat { lon: 0.0, lat: -1e-9 })];
        let text = moved(&data(TEXT), &places).unwrap();
        let expected = TEXT.replace("\"48.1\"", "\"48.0000000\"").replace("'11.5'", "'-11.1234568'");
        let expected = expected.replace("\"48.2\" lon=\"11.6\"", "\"0.0000000\" lon=\"0.0000000\"");
        assert_eq!(text, expected);
        assert_eq!(moved(&data(TEXT), &[(9, LonLat::default())]), None);
    }

    #[test]
    fn memory_and_text_agree() {
        let place = kept(LonLat { lon: 11.512_345_678_9, lat: 48.112_345_612 });
        let mut changed = data(TEXT);
        assert!(changed.move_node(2, place) && !changed.move_node(8, place));
        let again = data(&moved(&data(TEXT), &[(2, place)]).unwrap());
        assert_eq!(changed.node(2).unwrap().position, again.node(2).unwrap().position);
    }

    #[test]
    fn tags_come_and_go() {
        let mut data = data(TEXT);
        assert!(data.tag_way(4, "lanes", Some("3")) && data.tag_way(4, "highway", None) && !data.tag_way(1, "a", None));
        assert_eq!(data.way(4).unwrap().tags.iter().collect::<Vec<_>>(), [("lanes", "3")]);
    }

    #[test]
    fn a_part_has_whole_ways_and_what_speaks_of_them() {
        let at = |lon, lat| LonLat { lon, lat };
        let part = data(TEXT).within(&Extent { min: at(11.54, 48.14), max: at(11.56, 48.16) });
        assert_eq!(part.nodes.iter().map(|node| node.id).collect::<Vec<_>>(), [1, 2]);
        assert_eq!((part.ways.len(), part.relations.len()), (1, 1));
        let far = data(TEXT).within(&Extent { min: at(11.69, 48.29), max: at(11.71, 48.31) });
        assert_eq!((far.nodes.len(), far.ways.len(), far.relations.len()), (1, 0, 0));
    }
}
