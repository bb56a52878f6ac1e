//! Maps that are divided into cells: what stands where, and that the whole comes back, is judged alike, and loads in the real
//! Lanelet2 library.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use lanewright::api::{CheckOptions, Checked, Configuration, LayoutOptions, check, merge, split};
use lanewright::build;
use lanewright::lanelet::cell_metadata::CellMetadata;
use lanewright::osm::{ElementKind, OsmData, read_file};
use proptest::prelude::*;

use crate::common::needs::{python, skip};
use crate::common::{hand_made_maps, root};

type Key = (ElementKind, i64);

/// What a map says of each element, and what each refers to.
fn content(osm: &OsmData) -> BTreeMap<Key, Vec<String>> {
    let mut said: BTreeMap<Key, Vec<String>> = BTreeMap::new();
    let mut note = |kind, id, content: String| said.entry((kind, id)).or_default().push(content);
    osm.nodes.iter().for_each(|one| note(ElementKind::Node, one.id, format!("{:?} {:?}", one.position, one.tags)));
    osm.ways.iter().for_each(|one| note(ElementKind::Way, one.id, format!("{:?} {:?}", one.nodes, one.tags)));
    osm.relations
        .iter()
        .for_each(|one| note(ElementKind::Relation, one.id, format!("{:?} {:?}", one.members, one.tags)));
    said
}

fn references(osm: &OsmData) -> BTreeMap<Key, BTreeSet<Key>> {
    let named = |tags: &lanewright::osm::Tags| {
        let ids = ["intersection_area", "traffic_light_id"].map(|key| tags.get(key).and_then(|id| id.parse().ok()));
        ids.into_iter().flatten().map(|id| (ElementKind::Way, id)).collect::<Vec<Key>>()
    };
    let ways = osm.ways.iter().map(|way| {
        let nodes = way.nodes.iter().map(|id| (ElementKind::Node, *id));
        ((ElementKind::Way, way.id), nodes.chain(named(&way.tags)).collect())
    });
    let relations = osm.relations.iter().map(|relation| {
        let members = relation.members.iter().map(|member| (member.kind, member.id));
        ((ElementKind::Relation, relation.id), members.chain(named(&relation.tags)).collect())
    });
    ways.chain(relations).collect()
}

fn cells(divided: &Path) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> =
        fs::read_dir(divided.join("lanelet2_map.osm")).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

fn divide(map: &Path, size: u32, to: &Path) {
    split(map, to, size, &Configuration::default(), &|_| ()).unwrap();
}

/// Holds that cells are closed, that each element is the same in all, and that together they are the map, there and back.
fn holds_together(map: &Path, size: u32, dir: &Path) {
    let (divided, back) = (dir.join("cells"), dir.join("back"));
    divide(map, size, &divided);
    let whole = read_file(map).unwrap();
    let (said, refers) = (content(&whole), references(&whole));
    let mut seen = BTreeSet::new();
    for file in cells(&divided) {
        let name = file.display();
        let cell = content(&read_file(&file).unwrap());
        assert!(!cell.is_empty(), "{name} is empty");
        for (key, content) in &cell {
            assert_eq!(said.get(key), Some(content), "{name}: {key:?}");
            for target in refers.get(key).into_iter().flatten().filter(|target| said.contains_key(target)) {
                assert!(cell.contains_key(target), "{name}: {key:?} is there without {target:?}");
            }
        }
        seen.extend(cell.into_keys());
    }
    assert!(seen.iter().eq(said.keys()), "{size} m: elements of {} are in no cell", map.display());
    merge(&[divided], &back, false, &|_| ()).unwrap();
    let merged = read_file(&back.join("lanelet2_map.osm")).unwrap();
    assert!(content(&merged) == said, "{size} m: {} comes back changed", map.display());
    assert_eq!(merged.meta, whole.meta);
}

#[test]
fn hand_made_maps_come_back_as_they_were() {
    for map in hand_made_maps() {
        for size in [100, 30, 5000] {
            holds_together(&map, size, tempfile::tempdir().unwrap().path());
        }
    }
}

#[test]
fn no_cell_is_written_that_nothing_stands_in() {
    let node = "<node id='1' lat='' lon=''><tag k='local_x' v='100'/><tag k='local_y' v='100'/></node>";
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("map.osm");
    for (ways, count) in [("", 1), ("<way id='2'/>", 2)] {
        fs::write(&file, format!("<osm><MetaInfo format_version='2'/>{node}{ways}</osm>")).unwrap();
        holds_together(&file, 10, dir.path());
        assert_eq!(cells(&dir.path().join("cells")).len(), count, "{ways}");
        fs::remove_dir_all(dir.path().join("cells")).unwrap();
        fs::remove_dir_all(dir.path().join("back")).unwrap();
    }
}

#[test]
fn a_built_map_comes_back_to_the_byte_and_is_divided_alike_when_it_is_built() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let built = build(root().join("sample_maps/crossing_right.osm"), &LayoutOptions::default()).unwrap();
    built.write(&at("whole"), false).unwrap();
    built.write_cells(&at("direct"), 50).unwrap();
    divide(&at("whole"), 50, &at("cells"));
    merge(&[at("cells")], &at("back"), false, &|_| ()).unwrap();
    let bytes = |name: &str| fs::read(at(name)).unwrap();
    for file in ["lanelet2_map.osm", "map_projector_info.yaml", "lanewright.toml"] {
        assert!(bytes(&format!("back/{file}")) == bytes(&format!("whole/{file}")), "{file}");
    }
    for file in ["lanelet2_map_metadata.yaml", "map_projector_info.yaml", "lanewright.toml"] {
        assert!(bytes(&format!("cells/{file}")) == bytes(&format!("direct/{file}")), "{file}");
    }
    assert_eq!(cells(&at("cells")).len(), cells(&at("direct")).len());
    for (one, other) in cells(&at("cells")).into_iter().zip(cells(&at("direct"))) {
        assert_eq!(fs::read(&one).unwrap(), fs::read(&other).unwrap(), "{}", one.display());
    }
    // Cells of another size come from the cells themselves, and from several of them the part that they cover.
    divide(&at("cells"), 70, &at("other"));
    divide(&at("whole"), 70, &at("expected"));
    let names =
        |name: &str| cells(&at(name)).iter().map(|file| file.file_name().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(names("other"), names("expected"));
    merge(&cells(&at("cells")), &at("all"), false, &|_| ()).unwrap();
    assert!(bytes("all/lanelet2_map.osm") == bytes("whole/lanelet2_map.osm"));
}

#[test]
fn the_list_of_the_cells_leads_autoware_to_them() {
    let dir = tempfile::tempdir().unwrap();
    divide(&root().join("tests/rules/vm-03-02/good.osm"), 25, dir.path());
    let list = fs::read_to_string(dir.path().join("lanelet2_map_metadata.yaml")).unwrap();
    let list = CellMetadata::read(&list).unwrap();
    assert_eq!(list.resolution, [25.0, 25.0]);
    let named: BTreeSet<PathBuf> = list.cells.iter().map(|(name, _)| dir.path().join(name)).collect();
    assert!(named.iter().eq(cells(dir.path()).iter()));
    for (name, [x, y]) in &list.cells {
        assert!(name.ends_with(&format!("/{}_{}.osm", x, y)), "{name} {x} {y}");
    }
}

/// The findings of a map, without their places.
fn findings(checked: &Checked) -> Vec<String> {
    let found = checked.sorted.left.iter();
    found
        .map(|one| format!("{:?} {} {} {}", one.severity, one.code, one.finding.subject, one.finding.message))
        .collect()
}

fn judged(map: &Path) -> Checked {
    let options = CheckOptions {
        configuration: Configuration { isolated: true, ..Default::default() },
        baseline: None,
        peer_parameters: None,
    };
    check(map, options).unwrap()
}

#[test]
fn a_divided_map_has_the_findings_of_the_whole_each_once_with_a_place_in_a_cell() {
    for map in hand_made_maps() {
        let dir = tempfile::tempdir().unwrap();
        // Beside the others a map has another name than Autoware's, and its cells have that name: so has the whole here.
        let whole = dir.path().join("whole");
        fs::create_dir(&whole).unwrap();
        fs::copy(&map, whole.join("lanelet2_map.osm")).unwrap();
        let divided = dir.path().join("cells");
        divide(&whole, 60, &divided);
        let (of_whole, of_cells) = (judged(&whole), judged(&divided));
        let [left, right] = [&of_cells, &of_whole].map(findings);
        let differ: Vec<_> = left.iter().zip(&right).filter(|(a, b)| a != b).take(5).collect();
        assert!(left.len() == right.len() && differ.is_empty(), "{}: {differ:#?}", map.display());
        for (one, other) in of_whole.sorted.left.iter().zip(&of_cells.sorted.left) {
            let text = |checked: &Checked, span: &lanewright::diagnostic::SourceSpan| {
                let source = &checked.loaded.osm.sources[span.file as usize];
                source.text[span.start as usize..span.end as usize].to_owned()
            };
            let [a, b] =
                [(&of_whole, one), (&of_cells, other)].map(|(all, one)| one.span.as_ref().map(|span| text(all, span)));
            assert_eq!(a, b, "{}: {}", map.display(), one.code);
        }
    }
}

/// A relation drawn at random: its sort, and the kind and number of each member.
type Drawn = (u8, Vec<(u8, usize)>);

/// A map drawn at random: nodes, some free, ways and areas over them, lanelets, and regulatory elements over all, with
/// references that lead nowhere and ids that repeat.
fn random_map() -> impl Strategy<Value = String> {
    let places = prop::collection::vec((-300..300_i32, -300..300_i32), 1..30);
    let ways = prop::collection::vec((prop::collection::vec(0..33_usize, 0..6), 0..4_u8), 0..20);
    let relations = prop::collection::vec((0..3_u8, prop::collection::vec((0..3_u8, 0..22_usize), 0..5)), 0..12);
    (places, ways, relations, any::<bool>()).prop_map(|(places, ways, relations, repeat)| {
        let node = |(i, (x, y)): (usize, &(i32, i32))| {
            format!(
                "<node id='{}' lat='' lon=''><tag k='local_x' v='{x}'/><tag k='local_y' v='{y}.5'/></node>\n",
                i + 1
            )
        };
        let way = |(i, (nodes, sort)): (usize, &(Vec<usize>, u8))| {
            let nodes: String = nodes.iter().map(|node| format!("<nd ref='{}'/>", node + 1)).collect();
            let tag = match sort {
                0 => "<tag k='area' v='yes'/>".to_owned(),
                1 => format!("<tag k='traffic_light_id' v='{}'/>", 100 + (i * 7) % 20),
                _ => String::new(),
            };
            format!("<way id='{}'>{nodes}{tag}</way>\n", 100 + i)
        };
        let relation = |(i, (sort, members)): (usize, &Drawn)| {
            let member = |(at, (kind, target)): (usize, &(u8, usize))| match (sort, kind) {
                (0, _) if at < 2 => {
                    format!("<member type='way' ref='{}' role='{}'/>", 100 + target, ["left", "right"][at])
                }
                (_, 0) => format!("<member type='way' ref='{}' role='refers'/>", 100 + target),
                (_, 1) => format!("<member type='node' ref='{}' role='refers'/>", 1 + target),
                _ => format!("<member type='relation' ref='{}' role='regulatory_element'/>", 200 + target % 12),
            };
            let members: String = members.iter().enumerate().map(member).collect();
            let tags = match sort {
                0 => format!("<tag k='type' v='lanelet'/><tag k='intersection_area' v='{}'/>", 100 + i),
                1 => "<tag k='type' v='regulatory_element'/>".to_owned(),
                _ => "<tag k='type' v='other'/>".to_owned(),
            };
            format!("<relation id='{}'>{members}{tags}</relation>\n", 200 + i)
        };
        let nodes: Vec<String> = places.iter().enumerate().map(node).collect();
        let ways: Vec<String> = ways.iter().enumerate().map(way).collect();
        let relations: Vec<String> = relations.iter().enumerate().map(relation).collect();
        let again =
            if repeat { [nodes[0].as_str(), ways.first().map_or("", String::as_str)].concat() } else { String::new() };
        let body = [nodes.concat(), ways.concat(), relations.concat(), again].concat();
        format!("<osm generator='test'><MetaInfo format_version='2'/>{body}</osm>")
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 128, ..ProptestConfig::default() })]

    #[test]
    fn any_map_comes_back_from_cells_of_any_size(map in random_map(), size in 10_u32..400) {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("map.osm");
        fs::write(&file, map).unwrap();
        holds_together(&file, size, dir.path());
    }
}

#[test]
fn cells_and_blocks_of_cells_load_in_the_real_library_and_route_as_the_whole() {
    let dir = tempfile::tempdir().unwrap();
    let at = |name: &str| dir.path().join(name);
    let built = build(root().join("sample_maps/crossing_right.osm"), &LayoutOptions::default()).unwrap();
    built.write(&at("crossing"), false).unwrap();
    divide(&at("crossing"), 40, &at("crossing-cells"));
    let mut maps = vec![(at("crossing"), at("crossing-cells"))];
    for map in hand_made_maps().into_iter().filter(|map| {
        let name = map.file_name().unwrap().to_string_lossy().into_owned();
        ["autoware_vm_03_left_hand.osm", "autoware_intersection.osm"].contains(&name.as_str())
    }) {
        let name = map.file_stem().unwrap().to_string_lossy().into_owned();
        fs::create_dir(at(&name)).unwrap();
        fs::copy(&map, at(&name).join("lanelet2_map.osm")).unwrap();
        divide(&map, 100, &at(&format!("{name}-cells")));
        maps.push((at(&name), at(&format!("{name}-cells"))));
    }
    let Some(mut python) = python() else { return };
    python.arg(root().join("tests/checking/divided_maps.py"));
    maps.iter().for_each(|(whole, cells)| _ = python.args([whole.join("lanelet2_map.osm"), cells.clone()]));
    let run = python.output().unwrap();
    let told = String::from_utf8_lossy(&run.stdout);
    if told.contains("no lanelet2") {
        return skip::<()>("this Python has no Lanelet2 library").unwrap_or_default();
    }
    assert!(run.status.success(), "{told}{}", String::from_utf8_lossy(&run.stderr));
}
