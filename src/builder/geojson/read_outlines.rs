//! Reads the outlines of a file: finds cuts and kerbs on its polygons, and computes missing outlines.

use crate::builder::network::{End, Intersection, IntersectionIx, Road, RoadEnd, RoadNetwork, Stations};
use crate::builder::streets::outline::{Outline, OutlineCase, OutlineCut, Outlines, outlines as computed};
use crate::diagnostic::Finding;
use crate::geometry::{Point, Polyline, left_of, polygon, segment_crossing};

use super::values::{Rings, cut_of, ring};

/// A vertex of a polygon within this distance, metres, of the end of a cut is that end.
const TOLERANCE: f64 = 1e-3;

/// The outline of every intersection and the rest of every road.
pub fn outlines(network: &RoadNetwork, rings: &Rings<'_>, findings: &mut Vec<Finding>) -> Outlines {
    let own: Vec<Vec<Point>> =
        rings.intersections.iter().map(|f| f.map_or_else(Vec::new, |f| ring(f.geometry.as_ref()))).collect();
    let lacking = |i: usize| own[i].len() < 3 && !network.intersections[i].map_edge;
    let substitute = (0..own.len()).any(lacking).then(|| computed(network));
    let substitute = substitute.map(|(outlines, found)| {
        findings.extend(found);
        outlines
    });
    let substitute = substitute.as_ref();
    let kept: Vec<Stations> = network
        .roads
        .iter()
        .enumerate()
        .map(|(i, road)| {
            let said = said(rings, i, road);
            End::BOTH.map(|end| {
                let (side, at) = (usize::from(end == End::End), road.intersection(end).0 as usize);
                let computed = substitute.filter(|_| lacking(at)).map(|outlines| outlines.kept[i][side]);
                computed.or(said.map(|kept| kept[side])).unwrap_or_else(|| exit(road, end, &own[at]))
            })
        })
        .collect();
    let intersections = network
        .intersections
        .iter()
        .enumerate()
        .map(|(i, intersection)| match substitute {
            Some(outlines) if lacking(i) => outlines.intersections[i].clone(),
            _ => outline(network, rings, IntersectionIx::new(i), intersection, &own[i], &kept),
        })
        .collect();
    Outlines { kept, intersections }
}

/// The rest of a road by the file.
fn said(rings: &Rings<'_>, index: usize, road: &Road) -> Option<[f64; 2]> {
    let shape = rings.roads[index];
    let trims = || Some([shape.trim_start?, road.line.length() - shape.trim_end?]);
    shape.kept.or_else(trims).filter(|kept| kept.iter().all(|station| station.is_finite()))
}

/// The station, metres, at which a road that begins inside a polygon leaves it; that of its end if it begins outside.
fn exit(road: &Road, end: End, ring: &[Point]) -> f64 {
    let length = road.line.length();
    let outwards = if end == End::Start { road.line.clone() } else { road.line.reversed() };
    let station = if polygon::contains(ring, outwards.first()) { first_crossing(&outwards, ring) } else { 0.0 };
    if end == End::Start { station } else { length - station }
}

fn first_crossing(line: &Polyline, ring: &[Point]) -> f64 {
    let mut passed = 0.0;
    for (a, b) in line.segments() {
        let edges = ring.iter().zip(ring.iter().cycle().skip(1));
        let nearest = edges.filter_map(|(c, d)| Some(segment_crossing(a, b, *c, *d)?.0)).min_by(f64::total_cmp);
        if let Some(t) = nearest {
            return passed + t * (b - a).norm();
        }
        passed += (b - a).norm();
    }
    0.0
}

fn outline(
    network: &RoadNetwork,
    rings: &Rings<'_>,
    ix: IntersectionIx,
    intersection: &Intersection,
    ring: &[Point],
    kept: &[Stations],
) -> Outline {
    let feature = rings.intersections[ix];
    let id = feature.map(|feature| &feature.properties.id);
    let cut = |at: &RoadEnd| {
        let road = network.road(at.road);
        let said = cut_of(rings.roads[at.road], at.end, id);
        across(road, *at, kept[at.road], said)
    };
    let cuts: Vec<OutlineCut> = intersection.arms.iter().map(cut).collect();
    let usual = if ring.len() < 3 { OutlineCase::MapEdge } else { OutlineCase::General };
    let case = feature.and_then(|feature| feature.properties.case).unwrap_or(usual);
    let corners = (0..cuts.len())
        .map(|i| match case {
            OutlineCase::MapEdge => Vec::new(),
            OutlineCase::Fallback => vec![cuts[i].left, cuts[(i + 1) % cuts.len()].right],
            _ => kerb(ring, cuts[i].left, cuts[(i + 1) % cuts.len()].right),
        })
        .collect();
    Outline { case, cuts, corners, ring: ring.to_vec() }
}

/// The cut across a road end, seen looking into the intersection: between the points of the file, else straight across the
/// centre line.
fn across(road: &Road, at: RoadEnd, kept: Stations, said: Option<[Point; 2]>) -> OutlineCut {
    let station = kept[usize::from(at.end == End::End)];
    let along = road.line.direction(station);
    let inward = if at.end == End::Start { -along } else { along };
    let (middle, half) = (road.line.at(station), left_of(inward) * road.half_width());
    let [left, right] = match said {
        // Other tools may give the points in the other order.
        Some([a, b]) if (a - b).dot(&half) < 0.0 => [b, a],
        Some([a, b]) => [a, b],
        None => [middle + half, middle - half],
    };
    OutlineCut { at, left, right }
}

/// The part of a clockwise ring between two points on it, both included.
fn kerb(ring: &[Point], from: Point, to: Point) -> Vec<Point> {
    let mut chain = vec![from];
    if let (Some(first), Some(last)) = (vertex(ring, from), vertex(ring, to)) {
        let steps = (last + ring.len() - first) % ring.len();
        chain.extend((1..steps).map(|step| ring[(first + step) % ring.len()]));
    }
    chain.push(to);
    chain
}

/// The vertex of a ring at a point.
fn vertex(ring: &[Point], at: Point) -> Option<usize> {
    let nearest = (0..ring.len()).min_by(|&a, &b| (ring[a] - at).norm().total_cmp(&(ring[b] - at).norm()))?;
    ((ring[nearest] - at).norm() <= TOLERANCE).then_some(nearest)
}
