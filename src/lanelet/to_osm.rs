//! Writes a map as the OSM XML that Autoware reads: nodes, ways, relations, each by ascending id, always the same bytes.

use std::io::{self, Write};

use super::{Attributes, Lanelet, LaneletMap, Point, RegulatoryElement, Shelf, Shelved, Target};
use crate::osm::{ElementKind, MetaInfo, OsmWriter, Text};
use crate::projection::{LonLat, Projector};

/// Steps of `local_x` and `local_y` in a metre: a tenth of a millimetre, as in the official maps.
const LOCAL_STEPS: f64 = 1e4;

/// Writes the map. Points without `lonlat` get it from their position by way of the projector; `local_x` and `local_y`
/// are always the position.
pub fn to_osm(map: &LaneletMap, projector: &Projector, out: impl Write) -> io::Result<()> {
    let format_version = map.format_version.clone().unwrap_or_else(|| Text::const_new("2"));
    let meta = MetaInfo { format_version: Some(format_version), map_version: Some(Text::const_new("1")) };
    let mut writer = OsmWriter::new(out, &meta)?;
    let points = sorted(&map.points);
    for (point, place) in points.iter().zip(places(&points, projector)) {
        node(&mut writer, point, place)?;
    }
    ways(map, &mut writer)?;
    relations(map, &mut writer)?;
    writer.finish()
}

fn sorted<T: Shelved>(shelf: &Shelf<T>) -> Vec<&T> {
    let mut items: Vec<&T> = shelf.iter().collect();
    items.sort_unstable_by_key(|item| item.id());
    items
}

fn places(points: &[&Point], projector: &Projector) -> Vec<Option<LonLat>> {
    let mut places: Vec<Option<LonLat>> = points.iter().map(|p| p.lonlat).collect();
    let wanted: Vec<usize> = (0..points.len()).filter(|&i| places[i].is_none()).collect();
    let positions: Vec<_> = wanted.iter().map(|&i| points[i].position).collect();
    let found = projector.inverse_each(&positions, |i| points[wanted[i]].ele.unwrap_or(0.0));
    for (&i, place) in wanted.iter().zip(found) {
        places[i] = place;
    }
    places
}

fn node<W: Write>(writer: &mut OsmWriter<W>, point: &Point, place: Option<LonLat>) -> io::Result<()> {
    // Adding 0 turns -0 into 0.
    let local = |metres: f64| format!("{:.4}", (metres * LOCAL_STEPS).round() / LOCAL_STEPS + 0.0);
    let (x, y) = (local(point.position.x), local(point.position.y));
    let ele = point.ele.map(|ele| (ele + 0.0).to_string());
    let own = [("local_x", x.as_str()), ("local_y", y.as_str())];
    let own = own.into_iter().chain(ele.as_deref().map(|ele| ("ele", ele)));
    writer.node(point.id.0, place, own.chain(point.attributes.iter()))
}

fn ways<W: Write>(map: &LaneletMap, writer: &mut OsmWriter<W>) -> io::Result<()> {
    let lines = map.linestrings.iter().map(|l| (l.id.0, &l.points, &l.attributes, false));
    let polygons = map.polygons.iter().map(|p| (p.id.0, &p.points, &p.attributes, true));
    let mut ways: Vec<_> = lines.chain(polygons).collect();
    ways.sort_unstable_by_key(|(id, .., area)| (*id, *area));
    for (id, points, attributes, area) in ways {
        let area = (area && !attributes.has("area")).then_some(("area", "yes"));
        writer.way(id, points.iter().map(|p| p.0), attributes.iter().chain(area))?;
    }
    Ok(())
}

fn relations<W: Write>(map: &LaneletMap, writer: &mut OsmWriter<W>) -> io::Result<()> {
    let (lanelets, elements) = (sorted(&map.lanelets), sorted(&map.regulatory_elements));
    let (mut lanelets, mut elements) = (lanelets.into_iter().peekable(), elements.into_iter().peekable());
    loop {
        let lanelet_first = match (lanelets.peek(), elements.peek()) {
            (None, None) => return Ok(()),
            (lanelet, element) => {
                element.is_none() || lanelet.is_some_and(|l| element.is_none_or(|e| l.id.0 <= e.id.0))
            }
        };
        if lanelet_first {
            lanelets.next().map_or(Ok(()), |l| write_lanelet(writer, l))?;
        } else {
            elements.next().map_or(Ok(()), |e| write_element(writer, e))?;
        }
    }
}

fn write_lanelet<W: Write>(writer: &mut OsmWriter<W>, lanelet: &Lanelet) -> io::Result<()> {
    let bounds = [(lanelet.left.line, "left"), (lanelet.right.line, "right")];
    let lines = bounds.into_iter().chain(lanelet.centerline.map(|line| (line, "centerline")));
    let ways = lines.map(|(line, role)| (ElementKind::Way, line.0, role));
    let elements =
        lanelet.regulatory_elements.iter().map(|element| (ElementKind::Relation, element.0, "regulatory_element"));
    let tags = given(&lanelet.attributes, "type", "lanelet").chain(lanelet.attributes.iter());
    writer.relation(lanelet.id.0, ways.chain(elements), tags)
}

fn write_element<W: Write>(writer: &mut OsmWriter<W>, element: &RegulatoryElement) -> io::Result<()> {
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
    writer.relation(element.id.0, members, kind.chain(subtype).chain(element.attributes.iter()))
}

/// A tag that the primitive's kind implies, unless its attributes say it already.
fn given<'a>(
    attributes: &Attributes,
    key: &'a str,
    value: &'a str,
) -> impl Iterator<Item = (&'a str, &'a str)> + use<'a> {
    (!attributes.has(key)).then_some((key, value)).into_iter()
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
        let (id, attributes) = (PointId(id), Attributes::new());
        Point { id, position, ele: Some(12.5), lonlat: None, local: [None; 2], attributes, span: None }
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
<osm version="0.6" generator="lanewright">
  <MetaInfo format_version="2" map_version="1"/>
  <node id="1" version="1" lat=""#;
        assert!(text.starts_with(head), "{text}");
        let tags = r#"">
    <tag k="local_x" v="400.0000"/>
    <tag k="local_y" v="603.0000"/>
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
        assert!(text.contains(r#"<node id="1" version="1" lat="" lon="">"#), "{text}");
        let map = read(&text, &Projector::Local);
        assert_eq!(map.points.get(PointId(1)).unwrap().position, PlanePoint::new(400.0, 603.0));
        assert_eq!(written(&map, &Projector::Local), text);
    }
}
