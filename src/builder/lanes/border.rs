//! The borders between the lanes of a road, as lines along it.

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::Road;
use crate::builder::tags::cross_section::{CrossSection, Travel};
use crate::builder::tags::marking::marking;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::curve::untangled;
use crate::geometry::fillet::Rounding;
use crate::geometry::miter::miter;
use crate::geometry::{Point, Vector, left_of};
use crate::lanelet::{Bound, PointId};

use super::lanelet_validity::{aligned, centred, simple};

/// Corners of the road's line closer to a cut than this, metres, are left out of the borders, or more where these would cross.
const CLEAR: f64 = 0.5;
/// Corners are mitred up to this bend, degrees, and rounded beyond it.
const MITER: f64 = 30.0;
/// How tightly a border may bend: Lanelet2's own checks want a radius of one metre.
const BENDS: Rounding = Rounding { min_radius: 1.25, easy_radius: 1.25, max_shift: 0.0 };

/// Which way the lanelets of each strip run; `None` where there are none.
fn travels(section: &CrossSection) -> Vec<Option<Travel>> {
    let mut travels = vec![None; section.strips.len()];
    for run in strip_runs(section) {
        travels[run.strips].fill(Some(run.travel));
    }
    for (i, strip) in section.driven() {
        travels[i] = Some(strip.travel);
    }
    travels
}

/// Whether a border is drawn against the road's line: where only lanelets against it use the border.
fn against_line(travels: &[Option<Travel>], edge: usize) -> bool {
    let beside = [edge.checked_sub(1), Some(edge)].map(|i| travels.get(i?).copied().flatten());
    let mut beside = beside.into_iter().flatten().peekable();
    beside.peek().is_some() && beside.all(|travel| travel == Travel::Backward)
}

/// The border line at each edge of the cross-section that is used, as a bound along the road's line.
pub fn borders(
    assembly: &mut MapBuilder,
    road: &Road,
    country: Option<&str>,
    kept: [f64; 2],
    nodes: &[Vec<Option<PointId>>; 2],
) -> Vec<Option<Bound>> {
    let key = road.key_of("border");
    let places = border_places(assembly, road, kept, nodes);
    let travels = travels(&road.section);
    places
        .into_iter()
        .enumerate()
        .map(|(edge, places)| {
            let (mut places, first, last) = (places?, nodes[0][edge]?, nodes[1][edge]?);
            let key = key.number(edge as i64);
            let inverted = against_line(&travels, edge);
            let attributes = marking(&road.section, edge, &road.tags, country, inverted);
            let ends = if inverted { [last, first] } else { [first, last] };
            if inverted {
                places.reverse();
            }
            Some(Bound { line: assembly.line_between(key, ends, &places, attributes), inverted })
        })
        .collect()
}

/// Where the borders run, along the road's line. Where a lane between two would cross itself, more and more of the road's corners
/// are left out, those next to its cuts first; where one would not be read as drawn, points show its sides.
fn border_places(
    assembly: &MapBuilder,
    road: &Road,
    kept: [f64; 2],
    nodes: &[Vec<Option<PointId>>; 2],
) -> Vec<Option<Vec<Point>>> {
    let ends = |edge: usize| Some([nodes[0][edge]?, nodes[1][edge]?].map(|id| assembly.position(id)));
    let beside = |clear: f64| -> Vec<Option<Vec<Point>>> {
        let along = |edge| ends(edge).map(|ends| border(road, kept, clear, road.section.edge(edge), ends));
        (0..nodes[0].len()).map(along).collect()
    };
    let strips: Vec<usize> = road.section.driven().map(|(i, _)| i).collect();
    let all = |places: &[Option<Vec<Point>>], holds: fn(&[&[Point]; 2]) -> bool| {
        strips.iter().all(|&strip| match &places[strip..strip + 2] {
            [Some(left), Some(right)] => holds(&[left, right]),
            _ => true,
        })
    };
    let mut clear = CLEAR;
    let mut places = beside(clear);
    while clear < kept[1] - kept[0] && !all(&places, |lane| simple(lane)) {
        clear *= 2.0;
        places = beside(clear);
    }
    if !all(&places, |lane| aligned(lane)) {
        places = places.into_iter().map(|p| p.map(|p| centred(&p))).collect();
    }
    places
}

/// A border between its ends: the road's own corners, moved sideways, that are no closer to the cuts than `clear`.
fn border(road: &Road, kept: [f64; 2], clear: f64, offset: f64, ends: [Point; 2]) -> Vec<Point> {
    let corners: Vec<(Point, f64)> = road.line.points().iter().copied().zip(road.line.stations()).collect();
    let cuts = [road.line.direction(kept[0]), -road.line.direction((kept[1] - 1e-3).max(0.0))];
    // Inside a bend near a cut, a moved corner can fall behind the cut.
    let before_cut = |p: Point, station: f64| {
        let near = [station - kept[0], kept[1] - station].map(|s| s < 2.0 * offset.abs());
        (0..2).all(|i| !near[i] || (p - ends[i]).dot(&cuts[i]) > 0.0)
    };
    let mut line = vec![ends[0]];
    for w in corners.windows(3) {
        let [(before, _), (corner, station), (after, _)] = [w[0], w[1], w[2]];
        if station >= kept[0] + clear && station <= kept[1] - clear {
            let around = [(corner - before).normalize(), (after - corner).normalize()];
            line.extend(beside_corner(corner, around, offset).into_iter().filter(|&p| before_cut(p, station)));
        }
    }
    line.push(ends[1]);
    BENDS.of(&untangled(&line)).into_owned()
}

/// A corner moved sideways: one mitred point where the bend is slight, an arc outside a sharp bend, both ends of the
/// moved segments inside it (their crossing is cut off later).
fn beside_corner(corner: Point, [before, after]: [Vector; 2], offset: f64) -> Vec<Point> {
    let turn = crate::geometry::angle_between(before, after);
    if turn.abs() <= MITER.to_radians() {
        return vec![miter(corner, [before, after], offset)];
    }
    let normals = [left_of(before) * offset, left_of(after) * offset];
    if turn * offset > 0.0 {
        return normals.map(|n| corner + n).to_vec();
    }
    let pieces = (turn.abs() / MITER.to_radians()).ceil() as usize * 2;
    (0..=pieces).map(|i| corner + nalgebra::Rotation2::new(turn * i as f64 / pieces as f64) * normals[0]).collect()
}
