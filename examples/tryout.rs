//! Scratch: geometry of OpenStreetMap files as GeoJSON into a folder.
use lanewright::builder::consolidate::*;
use lanewright::builder::geojson::geometry_geojson;
use lanewright::builder::outline::*;
use lanewright::builder::road_network::*;
use lanewright::geometry::Point;
use lanewright::projection::LonLat;
fn main() {
    let merge = std::env::var("NOMERGE").is_err();
    let mut args = std::env::args().skip(1);
    let out = args.next().unwrap();
    for path in args {
        let osm = lanewright::osm::read_file(std::path::Path::new(&path)).unwrap();
        let lat0 = osm.nodes.iter().find_map(|n| n.position).unwrap();
        let (mx, my) = (111_320.0 * lat0.lat.to_radians().cos(), 110_540.0);
        let f = |ll: &[LonLat]| -> Vec<Point> {
            ll.iter().map(|p| Point::new((p.lon - lat0.lon) * mx, (p.lat - lat0.lat) * my)).collect()
        };
        let t = std::time::Instant::now();
        let mut n = road_network(&osm, &f, &NetworkOptions::default()).unwrap().network;
        let t1 = t.elapsed();
        let before = (n.roads.len(), n.intersections.len());
        let o = OutlineOptions::default();
        let mut by = std::collections::BTreeMap::new();
        if merge {
            let (m, notes) = consolidate(n, &ConsolidateOptions::default(), |n| remaining(n, &o));
            n = m;
            for note in &notes {
                *by.entry(format!("{:?} {}", note.reason, note.merged)).or_insert(0) += 1;
            }
        }
        let (outl, findings) = outlines(&n, &o);
        for f in &findings {
            by.entry(f.fault.to_string()).and_modify(|x| *x += 1).or_insert(1);
        }
        println!(
            "{path}: {before:?} -> {:?} net {:?} all {:?} {by:?}",
            (n.roads.len(), n.intersections.len()),
            t1,
            t.elapsed()
        );
        let name = std::path::Path::new(&path).file_stem().unwrap().to_str().unwrap().replace(".osm", "");
        let back = |ps: &[Point]| -> Vec<LonLat> {
            ps.iter().map(|p| LonLat { lon: lat0.lon + p.x / mx, lat: lat0.lat + p.y / my }).collect()
        };
        std::fs::write(format!("{out}/{name}.geojson"), geometry_geojson(&n, &outl, Some(&back)).unwrap()).unwrap();
    }
}
