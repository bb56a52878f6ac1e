//! Reviews of small maps, step by step.

use super::*;
use crate::api::Input;

/// A map with an intersection's area, with latitude, longitude and local coordinates.
fn map() -> (tempfile::TempDir, PathBuf, String) {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("map.osm");
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rules/vm-03-08/bad-lane-node-missing.osm");
    let text = std::fs::read_to_string(source).unwrap();
    std::fs::write(&file, &text).unwrap();
    let plain = open(&file);
    let with_place = |line: &str| {
        let node = line.split("<node id=\"").nth(1).and_then(|rest| rest.split('"').next()?.parse().ok());
        let place = node.and_then(|id| plain.map().points.get(crate::lanelet::PointId(id))).map(|point| point.position);
        place.map_or_else(
            || line.to_owned(),
            |at| {
                let tags =
                    format!("<tag k=\"local_x\" v=\"{:.4}\"/><tag k=\"local_y\" v=\"{:.4}\"/></node>", at.x, at.y);
                line.replace("</node>", &tags)
            },
        )
    };
    let text: String = text.lines().map(|line| with_place(line) + "\n").collect();
    std::fs::write(&file, &text).unwrap();
    (dir, file, text)
}

fn open(map: &Path) -> Review {
    let configuration = Configuration { isolated: true, ..Configuration::default() };
    Review::open(ReviewOptions { map: map.to_path_buf(), configuration, baseline: None }).unwrap()
}

#[test]
fn a_vertex_moves_in_degrees_and_metres_alike() {
    let (_dir, file, before) = map();
    let mut review = open(&file);
    let area = review.map().polygons.iter().next().unwrap();
    let node = area.points[0];
    let old = review.map().points.get(node).unwrap().position;
    let edit = HandEdit::MoveVertex { area: area.id.0, node: node.0, to: [old.x + 1.25, old.y - 0.5] };
    let area = area.id.0;
    assert!(review.edit(&edit).unwrap().starts_with("edited: vertex "));
    review.save().unwrap();
    let saved = std::fs::read_to_string(&file).unwrap();
    assert_eq!(before.lines().zip(saved.lines()).filter(|(old, new)| old != new).count(), 1, "the node's line alone");
    assert!(saved.contains(&format!("v=\"{:.4}\"", old.x + 1.25)), "local coordinates are moved, too");
    let again = open(&file);
    let new = again.map().points.get(node).unwrap().position;
    assert!((new.x - old.x - 1.25).abs() < 1e-2 && (new.y - old.y + 0.5).abs() < 1e-2, "{new} {old}");
    let checked = crate::api::check(Input::from(file.as_path()), crate::api::CheckOptions::default()).unwrap();
    assert!(!checked.sorted.left.iter().any(|one| one.code.starts_with("node/")), "both say the same");

    // Onto another node: only the outline changes.
    let other = again
        .map()
        .linestrings
        .iter()
        .flat_map(|line| &line.points)
        .find(|point| again.map().polygons.iter().all(|area| !area.points.contains(point)));
    let by = other.unwrap().0;
    let mut again = again;
    again.edit(&HandEdit::ReplaceVertex { area, node: node.0, by }).unwrap();
    assert!(again.map().polygons.iter().next().unwrap().points.iter().any(|point| point.0 == by));
    let twice = again.edit(&HandEdit::ReplaceVertex { area, node: by, by }).unwrap_err();
    assert!(twice.message().contains("already"));
}

#[test]
fn only_ends_of_lines_are_joined() {
    let (_dir, file, _) = map();
    let mut review = open(&file);
    let line = review.map().linestrings.iter().find(|line| line.points.len() > 2).unwrap().clone();
    let (end, inner) = (line.points[0].0, line.points[1].0);
    let ends: Vec<i64> = review.map().linestrings.iter().filter_map(|line| Some(line.points.last()?.0)).collect();
    let to = *ends.iter().find(|&&node| node != end && !line.points.iter().any(|point| point.0 == node)).unwrap();
    assert!(review.edit(&HandEdit::Join { from: inner, to }).unwrap_err().message().contains("no end of a line"));
    assert!(review.edit(&HandEdit::Join { from: end, to: end }).is_err());
    review.edit(&HandEdit::Join { from: end, to }).unwrap();
    assert!(review.map().points.iter().all(|point| point.id.0 != end));
    review.undo().unwrap();
    assert!(review.map().points.iter().any(|point| point.id.0 == end) && !review.is_unsaved());
    assert!(review.undo().is_err());
}

#[test]
fn what_is_typed_is_read_as_an_edit() {
    let parsed =
        |text: &str| HandEdit::parse(text).map(|edit| edit.to_string()).unwrap_or_else(|e| e.message().to_owned());
    assert_eq!(parsed("tag lanelet 5 name=Main  street"), "set name=Main  street on lanelet 5");
    assert_eq!(parsed("tag area 5 note"), "remove note from area 5");
    assert_eq!(parsed("turn -5 none"), "lanelet -5 does not turn");
    assert_eq!(parsed("yield 5 add 6"), "lanelet 6 gives way to lanelet 5");
    assert_eq!(parsed("yield 5 take 6"), "lanelet 6 does not give way to lanelet 5");
    assert_eq!(parsed("join 1 2"), "node 1 becomes node 2");
    assert_eq!(parsed("vertex 9 1 2"), "area 9 runs over node 2 in place of 1");
    assert_eq!(parsed("turn five left"), "five is no id");
    assert_eq!(parsed("tag tree 5 a=b"), "tree is no kind of element");
    assert_eq!(parsed("burn"), "no such edit: burn");
}

#[test]
fn packed_maps_are_not_reviewed() {
    let dir = tempfile::tempdir().unwrap();
    let file = dir.path().join("map.osm.gz");
    let (_source, plain, _) = map();
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    std::io::Write::write_all(&mut packed, &std::fs::read(plain).unwrap()).unwrap();
    std::fs::write(&file, packed.finish().unwrap()).unwrap();
    let options = ReviewOptions { map: file, configuration: Configuration::default(), baseline: None };
    assert!(Review::open(options).err().unwrap().message().contains("packed"));
}

#[test]
fn a_missing_projector_file_is_written_when_it_is_accepted_and_saved() {
    let dir = tempfile::tempdir().unwrap();
    let (file, beside) = (dir.path().join("map.osm"), dir.path().join(crate::lanelet::INFO));
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/tests/rules/projector/bad-missing.osm"), &file).unwrap();
    let mut review = open(&file);
    let is_file = |item: &Item| item.title().starts_with("write map_projector_info.yaml: ");
    let proposed = |review: &Review| review.items().find(|(_, item)| is_file(item)).map(|(at, _)| at);
    let item = proposed(&review).unwrap();
    assert!(review.open_items().contains(&item) && !review.items[item].safe && !review.is_unsaved());
    assert!(review.preview(item).unwrap().refused.is_none());

    let told = review.accept(&[item]).unwrap();
    assert!(told.starts_with("accepted `projector/missing` on map: write map_projector_info.yaml"), "{told}");
    assert!(!review.open_items().contains(&item) && review.is_unsaved() && !beside.exists());
    assert!(review.diff().contains("+projector_type: "), "{}", review.diff());
    review.undo().unwrap();
    assert!(review.open_items().contains(&item) && !review.is_unsaved());

    review.accept(&[item]).unwrap();
    assert_eq!(review.save().unwrap(), "saved: 1 file written");
    assert!(beside.exists() && !review.is_unsaved() && review.diff().is_empty());
    assert!(review.undo().unwrap_err().message().contains("written already"));
    assert!(proposed(&open(&file)).is_none(), "a review of the saved map has nothing to say of it");
}
