//! scratch
use lanewright::builder::consolidate::*;
use lanewright::builder::road_network::*;
use lanewright::geometry::Point;
use lanewright::projection::LonLat;
fn main() {
    for path in std::env::args().skip(1) {
        let osm = lanewright::osm::read_file(std::path::Path::new(&path)).unwrap();
        let lat0 = osm.nodes.iter().find_map(|n| n.position).unwrap();
        let f = |ll: &[LonLat]| -> Vec<Point> {
            ll.iter().map(|p| Point::new((p.lon - lat0.lon) * 111_320.0 * lat0.lat.to_radians().cos(), (p.lat - lat0.lat) * 110_540.0)).collect()
        };
        let t = std::time::Instant::now();
        let net = road_network(&osm, &f, &NetworkOptions::default()).unwrap();
        let t1 = t.elapsed();
        let n = net.network;
        let before = (n.roads.len(), n.intersections.len());
        let kept = |n: &RoadNetwork| -> Vec<[f64; 2]> {
            n.roads.iter().enumerate().map(|(i, r)| {
                let trim = |ix: IntersectionIx| {
                    let arms = &n.intersection(ix).arms;
                    if arms.len() < 3 { return 0.5 }
                    arms.iter().filter(|a| a.road.0 != i as u32).map(|a| n.road(a.road).half_width()).fold(0.0, f64::max)
                };
                [trim(r.from), r.line.length() - trim(r.to)]
            }).collect()
        };
        let (m, notes) = consolidate(n, &ConsolidateOptions::default(), kept);
        let mut by = std::collections::BTreeMap::new();
        for note in &notes { *by.entry(format!("{:?} {}", note.reason, note.merged)).or_insert(0) += 1; }
        println!("{path}: {before:?} -> {:?} net {:?} all {:?} {by:?}", (m.roads.len(), m.intersections.len()), t1, t.elapsed());
    }
}
