//! Joins the two carriageways around a traffic island into one road with a median.
//!
//! A refuge for pedestrians splits a street into two one-way ways for some metres (A/B Street's "sausage link"). As two roads
//! they would overlap at both ends.

use crate::builder::network::{End, Feature, FeatureKind, IntersectionIx, Road, RoadEnd, RoadIx, RoadNetwork};
use crate::builder::tags::cross_section::{CrossSection, Strip, StripKind, Travel};
use crate::geometry::{Point, Polyline};

use super::join_roads::directed;
use super::network_edit::NetworkEdit;

/// A longer island, metres, is the median between two roads.
const LONGEST: f64 = 120.0;
/// A wider island, metres, is the median between two roads.
const WIDEST: f64 = 6.0;
/// Spacing of the samples of the middle line, metres.
const SAMPLED_EVERY: f64 = 2.0;

/// Joins every pair of one-way roads around an island.
pub fn join_around_islands(network: RoadNetwork) -> RoadNetwork {
    let mut edit = NetworkEdit::new(network);
    for ix in edit.intersections() {
        let arms = edit.intersection(ix).arms.clone();
        for (one, two) in arms.iter().zip(arms.iter().cycle().skip(1)) {
            if join_pair(&mut edit, ix, *one, *two).is_some() {
                break;
            }
        }
    }
    edit.finish()
}

/// Joins two neighbouring arms of an intersection if they are the carriageways around one island.
fn join_pair(edit: &mut NetworkEdit, ix: IntersectionIx, one: RoadEnd, two: RoadEnd) -> Option<()> {
    let (away, back) = match (edit.road(one.road).one_way()?, edit.road(two.road).one_way()?) {
        _ if one.road == two.road => return None,
        (x, y) => match (leaves(one, x), leaves(two, y)) {
            (true, false) => (one, two),
            (false, true) => (two, one),
            _ => return None,
        },
    };
    // Both lead away from here, as the joined road will.
    let a = directed(edit.road(away.road), away.end == End::Start);
    let b = directed(edit.road(back.road), back.end == End::Start);
    if a.to != b.to || a.from == a.to || a.line.length().max(b.line.length()) > LONGEST || a.level != b.level {
        return None;
    }
    let there = edit.intersection(a.to);
    if there.map_edge || edit.intersection(ix).map_edge || !neighbours(&there.arms, away.road, back.road) {
        return None;
    }
    if a.roundabout || b.roundabout || (a.class, a.link) != (b.class, b.link) {
        return None;
    }
    let road = around_island(&a, &b)?;
    edit.join([away.road, back.road], road, |end| Some(if end == away || end == back { End::Start } else { End::End }));
    Some(())
}

fn leaves(arm: RoadEnd, travel: Travel) -> bool {
    (arm.end == End::Start) == (travel == Travel::Forward)
}

fn neighbours(arms: &[RoadEnd], a: RoadIx, b: RoadIx) -> bool {
    let position = |road| arms.iter().position(|arm| arm.road == road);
    let (Some(i), Some(j)) = (position(a), position(b)) else { return false };
    (i + 1) % arms.len() == j || (j + 1) % arms.len() == i
}

/// Crossings of the two carriageways that lie this near each other along the street, metres, are one crosswalk.
const SAME_CROSSWALK: f64 = 3.0;

/// One road from two carriageways with the same first and last point; `a` is driven along its line, `b` against it.
fn around_island(a: &Road, b: &Road) -> Option<Road> {
    let count = (a.line.length().max(b.line.length()) / SAMPLED_EVERY).ceil() as usize + 1;
    let (with, against) = (a.line.resampled_to(count), b.line.resampled_to(count));
    let half = a.half_width() + b.half_width();
    let mut widest = f64::NEG_INFINITY;
    let mut left_votes = 0_i32;
    let mut middle: Vec<Point> = Vec::with_capacity(count);
    for (p, q) in with.points().iter().zip(against.points()) {
        widest = widest.max((q - p).norm() - half);
        middle.push(nalgebra::center(p, q));
    }
    let middle = Polyline::new(middle)?;
    for q in against.points() {
        left_votes += if middle.project(*q).offset >= 0.0 { 1 } else { -1 };
    }
    if widest > WIDEST {
        return None;
    }
    let against_on_left = left_votes > 0;
    let island = Strip::plain(StripKind::Buffer, Travel::Both, widest.max(0.0), true);
    let (left, right) = if against_on_left { (&b.section, &a.section) } else { (&a.section, &b.section) };
    let strips = [left.strips.clone(), vec![island], right.strips.clone()].concat();
    let section = CrossSection { strips: strips.into_iter().filter(|s| s.width > 0.0).collect() };
    // The middle of the outer edges differs from the middle of the centre lines if one carriageway is wider.
    let shift = (left.width() - right.width()) / 4.0;
    let line = middle.offset(shift, 3.0).unwrap_or(middle);
    let mut ways = a.ways.clone();
    ways.extend(b.ways.iter().copied());
    let mut features = a.features.clone();
    let ratio = line.length() / b.line.length();
    for f in &b.features {
        let f = Feature { station: f.station * ratio, ..f.clone() };
        let is_known = |x: &Feature| x.node == f.node && x.kind == f.kind || is_one_crosswalk(x, &f);
        if !features.iter().any(is_known) {
            features.push(f);
        }
    }
    features.sort_by(|x, y| x.station.total_cmp(&y.station));
    let speed = [a.speed[0], b.speed[1]];
    Some(Road { ways, line, section, features, speed, ..a.clone() })
}

/// Whether people cross both carriageways over one crosswalk.
fn is_one_crosswalk(a: &Feature, b: &Feature) -> bool {
    let is_crossing = |one: &Feature| matches!(one.kind, FeatureKind::Crossing { .. });
    is_crossing(a) && is_crossing(b) && (a.station - b.station).abs() < SAME_CROSSWALK
}
