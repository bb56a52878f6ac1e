//! The borders between the lanes of a road, as lines along it.

use crate::builder::map::map_builder::MapBuilder;
use crate::builder::network::{Road, Stations};
use crate::builder::tags::cross_section::{CrossSection, Travel};
use crate::builder::tags::marking::marking;
use crate::builder::tags::side_strips::strip_runs;
use crate::geometry::curve::untangled;
use crate::geometry::fillet::Rounding;
use crate::geometry::miter::miter;
use crate::geometry::{Point, Vector, angle_between, left_of};
use crate::lanelet::{Bound, PointId};

use super::lanelet_validity::{are_read_as_drawn, is_simple, with_centred_middle};

/// Corners of the road's line closer to a cut than this, metres, are left out of the borders; more where these would cross.
const CORNER_FROM_CUT: f64 = 0.5;
/// Corners are mitred up to this bend, degrees, and rounded beyond it.
const MITER: f64 = 30.0;
/// How tightly a border may bend: Lanelet2's own checks want a radius of one metre.
const BENDS: Rounding = Rounding { min_radius: 1.25, easy_radius: 1.25, max_shift: 0.0 };

/// The direction of the lanelets of each strip; `None` where there are none.
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

/// Whether a border is drawn against the road's line: if only lanelets against the line use it.
fn against_line(travels: &[Option<Travel>], edge: usize) -> bool {
    let users = [edge.checked_sub(1), Some(edge)].map(|i| travels.get(i?).copied().flatten());
    users != [None; 2] && users.into_iter().flatten().all(|travel| travel == Travel::Backward)
}

/// The border at each edge of the cross-section that has `nodes` at both ends, as a bound along the road's line.
pub fn borders(
    assembly: &mut MapBuilder,
    road: &Road,
    country: Option<&str>,
    kept: Stations,
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

/// The places of the borders along the road's line. While a lane between two of them would cross itself, corners of the road
/// are left out, those next to its cuts first. Where the loader would swap the bounds of a lane, points are added.
fn border_places(
    assembly: &MapBuilder,
    road: &Road,
    kept: Stations,
    nodes: &[Vec<Option<PointId>>; 2],
) -> Vec<Option<Vec<Point>>> {
    let ends = |edge: usize| Some([nodes[0][edge]?, nodes[1][edge]?].map(|id| assembly.position(id)));
    let drawn = |clear: f64| -> Vec<Option<Vec<Point>>> {
        let edges = 0..nodes[0].len();
        edges.map(|edge| Some(border(road, kept, clear, road.section.edge(edge), ends(edge)?))).collect()
    };
    let mut clear = CORNER_FROM_CUT;
    let mut places = drawn(clear);
    while clear < kept[1] - kept[0] && !all_lanes(road, &places, |lane| is_simple(lane)) {
        clear *= 2.0;
        places = drawn(clear);
    }
    if !all_lanes(road, &places, |lane| are_read_as_drawn(lane)) {
        places = places.into_iter().map(|p| p.map(|p| with_centred_middle(&p))).collect();
    }
    places
}

/// Whether this holds of the bounds of all driven lanes.
fn all_lanes(road: &Road, borders: &[Option<Vec<Point>>], holds: fn(&[&Vec<Point>; 2]) -> bool) -> bool {
    let bounds =
        road.section.driven().filter_map(|(strip, _)| Some([borders[strip].as_ref()?, borders[strip + 1].as_ref()?]));
    bounds.into_iter().all(|bounds| holds(&bounds))
}

/// A border between its ends: the road's corners, moved sideways by `offset` metres, that are at least `clear` metres from the
/// cuts.
fn border(road: &Road, kept: Stations, clear: f64, offset: f64, ends: [Point; 2]) -> Vec<Point> {
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
            line.extend(offset_corner(corner, around, offset).into_iter().filter(|&p| before_cut(p, station)));
        }
    }
    line.push(ends[1]);
    BENDS.of(&untangled(&line)).into_owned()
}

/// A corner of a parallel curve: one mitred point where the bend is slight, an arc outside a sharp bend, and inside it the
/// ends of both moved segments, whose crossing is cut off later.
fn offset_corner(corner: Point, [before, after]: [Vector; 2], offset: f64) -> Vec<Point> {
    let turn = angle_between(before, after);
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
