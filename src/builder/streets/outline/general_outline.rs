//! A/B Street's general method for the roads at one intersection.
//!
//! Every road is trimmed back to the farthest collision of its edges with those of any other road. The trimmed ends and the
//! collisions between neighbours make up the outline.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use crate::geometry::{angle_between, line_crossing};

use super::collide::{Collision, collisions};
use super::ring::Corner;
use super::sizes::{KERB_REACH, LEAST_TRIM, MARGIN, MOST_TRIM};
use super::thicken::{Side, ThickenedArm};

/// The trims and corners at one intersection, per arm.
#[derive(Clone, Debug)]
pub struct RoadStar {
    /// How far the arm must be trimmed, metres.
    pub least: Vec<f64>,
    /// How far it should be trimmed so that the kerbs have room for their curves, metres.
    pub trims: Vec<f64>,
    /// The corner between it and the next arm clockwise.
    pub corners: Vec<Corner>,
    /// Whether any two neighbours are nearly parallel, with a wedge between them.
    pub wedge: bool,
}

impl RoadStar {
    /// One arm, cut back by `trim` metres.
    pub fn terminus(trim: f64) -> Self {
        Self { least: vec![trim], trims: vec![trim], corners: vec![Corner::Open], wedge: false }
    }
}

/// The trims and corners of the arms, which are in clockwise order.
pub fn star(arms: &[ThickenedArm]) -> RoadStar {
    let n = arms.len();
    let mut trims = vec![0.0_f64; n];
    let mut corners = vec![Corner::Open; n];
    for i in 0..n {
        for j in i + 1..n {
            let found = collisions(&arms[i], &arms[j]);
            // Roads that diverge at a small angle are cut where a wedge has room; beyond, they run side by side.
            let reach = MOST_TRIM * arms[i].half.max(arms[j].half) * 2.0;
            for c in &found {
                trims[i] = trims[i].max(c.stations[0].min(reach));
                trims[j] = trims[j].max(c.stations[1].min(reach));
            }
            if j == i + 1 {
                corners[i] = corner(&arms[i], &arms[j], &found, false);
            }
            if i == 0 && j == n - 1 {
                corners[j] = corner(&arms[j], &arms[i], &found, true);
            }
        }
    }
    let mut least = trims.clone();
    for i in 0..n {
        let next = (i + 1) % n;
        if let Corner::Collision { along, tangent, .. } = corners[i] {
            let reach = MOST_TRIM * arms[i].half.max(arms[next].half) * 2.0;
            if along[0].max(along[1]) > reach {
                continue;
            }
            let right = arms[i].right.at(along[0] + tangent);
            let left = arms[next].left.at(along[1] + tangent);
            trims[i] = trims[i].max(arms[i].line.project(right).station);
            trims[next] = trims[next].max(arms[next].line.project(left).station);
        }
    }
    if let [a, b] = arms {
        let taper = (a.half - b.half).abs();
        trims.iter_mut().chain(&mut least).for_each(|trim| *trim = trim.max(taper));
    }
    for trim in trims.iter_mut().chain(&mut least) {
        *trim = (*trim + MARGIN).max(LEAST_TRIM);
    }
    let wedge = (0..n).any(|i| gap(&arms[i], &arms[(i + 1) % n]) < WEDGE);
    RoadStar { least, trims, corners, wedge }
}

/// The corner from `a` clockwise to `b`: the farthest collision of the facing edges. `swapped` if `found` names `b` first.
fn corner(a: &ThickenedArm, b: &ThickenedArm, found: &[Collision], swapped: bool) -> Corner {
    let facing = found.iter().rev().find(|c| match swapped {
        false => c.a == Side::Right && c.b == Side::Left,
        true => c.a == Side::Left && c.b == Side::Right,
    });
    let Some(c) = facing else { return corner_without_collision(a, b) };
    let along = if swapped { [c.along[1], c.along[0]] } else { c.along };
    let leaving = [a.right.direction(along[0]), b.left.direction(along[1])];
    let opening = angle_between(leaving[0], leaving[1]).abs();
    // Distance from the collision at which a kerb of this radius touches both edges.
    let tangent = (a.kerb.min(b.kerb) / (opening / 2.0).tan()).min(KERB_REACH * (opening / FRAC_PI_2).min(1.0));
    Corner::Collision { point: c.point, along, tangent }
}

/// The corner from `a` clockwise to `b` if their edges do not collide. It is open if the arms are half a turn or more apart.
/// Else one road is so wide that the other's edge begins inside it; then the edges extended backwards may meet.
fn corner_without_collision(a: &ThickenedArm, b: &ThickenedArm) -> Corner {
    if gap(a, b) >= PI {
        return Corner::Open;
    }
    let (p, q) = (a.right.first(), b.left.first());
    let (u, v) = (a.right.direction(0.0), b.left.direction(0.0));
    let reach = a.half.max(b.half);
    match line_crossing(p, u, q, v) {
        Some((s, t, point)) if s.min(t) >= -reach && s <= 2.0 * reach && t <= 2.0 * reach => {
            Corner::Collision { point, along: [s.max(0.0), t.max(0.0)], tangent: 0.0 }
        }
        _ => Corner::Chord,
    }
}

/// The angle from the direction of `a` clockwise to that of `b`, radians, from 0 to 2 pi.
fn gap(a: &ThickenedArm, b: &ThickenedArm) -> f64 {
    let look = |arm: &ThickenedArm| arm.line.at(LOOK.min(arm.length)) - arm.line.first();
    (-angle_between(look(a), look(b))).rem_euclid(TAU)
}

/// Largest angle between nearly parallel arms, radians: 25 degrees.
const WEDGE: f64 = 25.0 * PI / 180.0;

/// Distance over which the direction of an arm is taken, metres.
const LOOK: f64 = 5.0;
