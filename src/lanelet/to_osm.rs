//! Writes a map as the OSM XML that Autoware reads: nodes, ways, relations, each by ascending id, always the same bytes.

use std::io::{self, Write};

use rayon::prelude::*;

use crate::osm::{ElementKind, MetaInfo, OsmText, Tags, Text};
use crate::parallel::InSmallParts;
use crate::projection::{LonLat, Projector};

use super::point::lonlats;
use super::{Attributes, Lanelet, LaneletMap, LineString, Point, Polygon, RegulatoryElement, Target};

/// Decimals of `local_x` and `local_y`: a tenth of a millimetre, as in the official maps.
const LOCAL_DECIMALS: usize = 4;

/// Elements whose text one thread makes at a time: what its own cache holds.
const CHUNK: usize = 1 << 8;
/// Chunks that are made before they are written: their text is held in memory.
const CHUNKS: usize = 16;

/// Writes the map. Points without `lonlat` get it from their position by way of the projector. `local_x` and `local_y` are the
/// position; they are written where the loader reads them, which is under [`Projector::Local`] alone, and for points that had them.
///
/// # Errors
///
/// If `out` cannot be written to.
pub fn to_osm(map: &LaneletMap, projector: &Projector, mut out: impl Write + Send) -> io::Result<()> {
    let format_version = map.format_version.clone().unwrap_or_else(|| Text::const_new("2"));
    let meta = MetaInfo { format_version: Some(format_version), map_version: Some(Text::const_new("1")) };
    out.write_all(OsmText::head(&meta).as_bytes())?;
    let mut texts = Texts::default();
    let points = map.points.as_slice();
    let local = *projector == Projector::Local;
    texts.write_all(&mut out, &map.points.ascending(), |positions, text| {
        let points: Vec<&Point> = positions.iter().map(|&at| &points[at as usize]).collect();
        for (point, place) in points.iter().zip(lonlats(&points, projector)) {
            node(text, point, place, local);
        }
    })?;
    let lines = map.linestrings.iter().map(|line| ((line.id.0, false), WrittenWay::Line(line)));
    let ways = sorted(lines.chain(map.polygons.iter().map(|area| ((area.id.0, true), WrittenWay::Area(area)))));
    texts.write_all(&mut out, &ways, |ways, text| ways.iter().for_each(|(_, way)| way.write(text)))?;
    let lanelets = map.lanelets.iter().map(|lanelet| ((lanelet.id.0, false), WrittenRelation::Lanelet(lanelet)));
    let elements =
        map.regulatory_elements.iter().map(|element| ((element.id.0, true), WrittenRelation::Element(element)));
    let relations = sorted(lanelets.chain(elements));
    texts.write_all(&mut out, &relations, |relations, text| relations.iter().for_each(|(_, one)| one.write(text)))?;
    out.write_all(OsmText::tail().as_bytes())?;
    out.flush()
}

/// The texts of two batches: one is made while the other is written. Their memory serves all batches.
#[derive(Default)]
struct Texts {
    ready: Vec<OsmText>,
    next: Vec<OsmText>,
}

impl Texts {
    /// Writes the text of all items in their order; all threads make it while one of them writes.
    fn write_all<T: Sync>(
        &mut self,
        out: &mut (impl Write + Send),
        items: &[T],
        text_of: impl Fn(&[T], &mut OsmText) + Sync,
    ) -> io::Result<()> {
        let made = |(text, items): (&mut OsmText, &[T])| {
            text.clear();
            text_of(items, text);
        };
        let Self { ready, next } = self;
        let mut filled = 0;
        for batch in items.chunks(CHUNK * CHUNKS) {
            next.resize_with(CHUNKS, OsmText::default);
            let (written, ()) = rayon::join(
                || ready.iter().take(filled).try_for_each(|text| out.write_all(text.as_bytes())),
                || next.par_iter_mut().in_small_parts().zip(batch.par_chunks(CHUNK).in_small_parts()).for_each(made),
            );
            written?;
            filled = batch.len().div_ceil(CHUNK);
            std::mem::swap(ready, next);
        }
        ready.iter().take(filled).try_for_each(|text| out.write_all(text.as_bytes()))
    }
}

/// Items by ascending keys. The keys are stored beside them, because fetching each from its item takes longer than the sort.
fn sorted<K: Copy + Ord + Send, T: Send>(items: impl Iterator<Item = (K, T)>) -> Vec<(K, T)> {
    let mut items: Vec<(K, T)> = items.collect();
    items.par_sort_unstable_by_key(|(key, _)| *key);
    items
}

fn node(text: &mut OsmText, point: &Point, place: Option<LonLat>, local: bool) {
    text.begin_node(point.id.0, place);
    let tags = in_order(point.attributes().words());
    let (before, after) = tags.split_at(tags.partition_point(|(key, _)| Tags::rank(key) < Tags::rank(b"local_x")));
    text.tags(before.iter().copied());
    let coordinates = [("local_x", point.position.x), ("local_y", point.position.y)];
    for ((key, metres), had) in coordinates.into_iter().zip(point.local()) {
        if local || had {
            text.number(key, metres, LOCAL_DECIMALS);
        }
    }
    if let Some(metres) = point.ele() {
        text.decimal("ele", metres);
    }
    text.tags(after.iter().copied());
    text.end_node();
}

/// What becomes a way.
enum WrittenWay<'a> {
    Line(&'a LineString),
    Area(&'a Polygon),
}

impl WrittenWay<'_> {
    fn write(&self, text: &mut OsmText) {
        match self {
            Self::Line(line) => text.way(line.id.0, line.points.iter().map(|p| p.0), in_order(line.attributes.words())),
            Self::Area(area) => {
                let tags = area.attributes.words().chain(given(&area.attributes, "area", "yes"));
                text.way(area.id.0, area.points.iter().map(|p| p.0), in_order(tags));
            }
        }
    }
}

/// What becomes a relation.
enum WrittenRelation<'a> {
    Lanelet(&'a Lanelet),
    Element(&'a RegulatoryElement),
}

impl WrittenRelation<'_> {
    fn write(&self, text: &mut OsmText) {
        match self {
            Self::Lanelet(lanelet) => write_lanelet(text, lanelet),
            Self::Element(element) => write_element(text, element),
        }
    }
}

fn write_lanelet(text: &mut OsmText, lanelet: &Lanelet) {
    let bounds = [(lanelet.left.line, "left"), (lanelet.right.line, "right")];
    let lines = bounds.into_iter().chain(lanelet.centerline.map(|line| (line, "centerline")));
    let ways = lines.map(|(line, role)| (ElementKind::Way, line.0, role));
    let elements =
        lanelet.regulatory_elements.iter().map(|element| (ElementKind::Relation, element.0, "regulatory_element"));
    let tags = given(&lanelet.attributes, "type", "lanelet").chain(lanelet.attributes.words());
    text.relation(lanelet.id.0, ways.chain(elements), in_order(tags));
}

fn write_element(text: &mut OsmText, element: &RegulatoryElement) {
    let members = element.members.iter().map(|member| {
        let (kind, id) = match member.target {
            Target::Point(id) => (ElementKind::Node, id.0),
            Target::LineString(id) => (ElementKind::Way, id.0),
            Target::Polygon(id) => (ElementKind::Way, id.0),
            Target::Lanelet(id) => (ElementKind::Relation, id.0),
        };
        (kind, id, member.role.as_str())
    });
    let kind = given(&element.attributes, "type", "regulatory_element");
    let subtype = given(&element.attributes, "subtype", &element.subtype);
    let tags = kind.chain(subtype).chain(element.attributes.words());
    text.relation(element.id.0, members, in_order(tags));
}

/// Tags in the order of the canonical form, which `fmt` writes. Of a key that repeats the last one still comes last.
fn in_order<'a>(tags: impl Iterator<Item = Word<'a>>) -> Vec<Word<'a>> {
    let mut tags: Vec<Word<'a>> = tags.collect();
    tags.sort_by_key(|&(key, _)| (Tags::rank(key), key));
    tags
}

/// Key and value.
type Word<'a> = (&'a [u8], &'a [u8]);

/// A tag that the primitive's kind implies, unless its attributes say it already.
fn given<'a>(
    attributes: &Attributes,
    key: &'a str,
    value: &'a str,
) -> impl Iterator<Item = (&'a [u8], &'a [u8])> + use<'a> {
    (!attributes.has(key)).then_some((key.as_bytes(), value.as_bytes())).into_iter()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point as PlanePoint;
    use crate::lanelet::{
        Bound, LaneletId, LineString, LineStringId, Member, PointId, Polygon, PolygonId, RegulatoryElementId, from_osm,
    };
    use crate::osm::{OsmData, read_bytes};

    fn point(id: i64, x: f64, y: f64) -> Point {
        let position = PlanePoint::new(x, y);
        Point::new(PointId(id), position, Some(12.5))
    }

    /// A lane of ten metres with a stop line element and an area, made in an order that is not that of the ids.
    fn made() -> LaneletMap {
        let mut map = LaneletMap::default();
        for (id, x, y) in [(4, 410.0, 600.0), (1, 400.0, 603.0), (2, 410.0, 603.0), (3, 400.0, 600.0)] {
            map.points.insert(point(id, x, y));
        }
        let line = |id, ends: [i64; 2]| LineString {
            id: LineStringId(id),
            points: ends.map(PointId).to_vec(),
            attributes: [("type", "virtual")].into_iter().collect(),
            span: None,
        };
        map.linestrings.insert(line(12, [3, 4]));
        map.linestrings.insert(line(10, [1, 2]));
        let points = [1, 2, 4, 3].map(PointId).to_vec();
        let attributes = [("type", "intersection_area")].into_iter().collect();
        map.polygons.insert(Polygon { id: PolygonId(11), points, attributes, span: None });
        map.lanelets.insert(Lanelet {
            id: LaneletId(21),
            left: Bound { line: LineStringId(10), inverted: false },
            right: Bound { line: LineStringId(12), inverted: false },
            centerline: None,
            regulatory_elements: vec![RegulatoryElementId(20)],
            attributes: [("subtype", "road")].into_iter().collect(),
            span: None,
        });
        let target = Target::LineString(LineStringId(10));
        map.regulatory_elements.insert(RegulatoryElement {
            id: RegulatoryElementId(20),
            subtype: Text::from("road_marking"),
            members: vec![Member { role: Text::from("refers"), target }],
            attributes: Attributes::new(),
            span: None,
        });
        map
    }

    fn written(map: &LaneletMap, projector: &Projector) -> String {
        let mut bytes = Vec::new();
        to_osm(map, projector, &mut bytes).unwrap();
        String::from_utf8(bytes).unwrap()
    }

    fn read(text: &str, projector: &Projector) -> LaneletMap {
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "test", text.as_bytes().to_vec()).unwrap();
        let loaded = from_osm(&osm, projector);
        assert_eq!(loaded.faults, []);
        loaded.map
    }

    #[test]
    fn the_text_is_the_expected_one() {
        let text = written(&made(), &Projector::mgrs("54SUE".parse().unwrap()));
        let head = r#"<?xml version="1.0" encoding="UTF-8"?>
<osm version="0.6" generator="lanewright" upload="false">
  <MetaInfo format_version="2" map_version="1"/>
  <node id="1" version="1" lat=""#;
        assert!(text.starts_with(head), "{text}");
        let tags = r#"">
    <tag k="ele" v="12.5"/>
  </node>
"#;
        assert!(text.contains(tags), "{text}");
        let tail = r#"  <way id="12" version="1">
    <nd ref="3"/>
    <nd ref="4"/>
    <tag k="type" v="virtual"/>
  </way>
  <relation id="20" version="1">
    <member type="way" ref="10" role="refers"/>
    <tag k="type" v="regulatory_element"/>
    <tag k="subtype" v="road_marking"/>
  </relation>
  <relation id="21" version="1">
    <member type="way" ref="10" role="left"/>
    <member type="way" ref="12" role="right"/>
    <member type="relation" ref="20" role="regulatory_element"/>
    <tag k="type" v="lanelet"/>
    <tag k="subtype" v="road"/>
  </relation>
</osm>
"#;
        assert!(text.ends_with(tail), "{text}");
    }

    #[test]
    fn a_map_survives_every_projector() {
        let origin = LonLat { lon: 138.8, lat: 35.2 };
        for projector in [
            Projector::mgrs("54SUE".parse().unwrap()),
            Projector::LocalCartesianUtm { origin },
            Projector::transverse_mercator(origin),
            Projector::LocalCartesian { origin },
        ] {
            let text = written(&made(), &projector);
            let map = read(&text, &projector);
            for point in &made().points {
                let moved = (map.points.get(point.id).unwrap().position - point.position).norm();
                assert!(moved < 1e-4, "{} {moved}", projector.name());
            }
            assert_eq!(written(&map, &projector), text, "the second writing differs: {}", projector.name());
            let lanelet = map.lanelets.get(LaneletId(21)).unwrap();
            assert_eq!((lanelet.left.line, lanelet.right.line), (LineStringId(10), LineStringId(12)));
            assert_eq!(lanelet.regulatory_elements, [RegulatoryElementId(20)]);
            assert!(lanelet.attributes.is("subtype", "road"));
            assert!(map.polygons.get(PolygonId(11)).unwrap().attributes.is("area", "yes"));
        }
    }

    #[test]
    fn a_map_without_projection_survives() {
        let text = written(&made(), &Projector::Local);
        let node = r#"<node id="1" version="1" lat="" lon="">
    <tag k="local_x" v="400.0000"/>
    <tag k="local_y" v="603.0000"/>
    <tag k="ele" v="12.5"/>
  </node>
"#;
        assert!(text.contains(node), "{text}");
        let map = read(&text, &Projector::Local);
        assert_eq!(map.points.get(PointId(1)).unwrap().position, PlanePoint::new(400.0, 603.0));
        assert_eq!(written(&map, &Projector::Local), text);
    }
}
