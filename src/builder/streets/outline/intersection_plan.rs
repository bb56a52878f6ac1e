//! One intersection while its outline is made: what is planned before the roads' other ends are known, and the closing of the
//! ring with the cuts as they came out.

use std::borrow::Cow;
use std::sync::OnceLock;

use crate::builder::network::{End, Intersection, RoadNetwork, Stations};
use crate::builder::streets::snap_grid::snap;
use crate::geometry::Point;
use crate::geometry::simple_ring::faults;

use super::general::RoadStar;
use super::ring::Corner;
use super::thicken::ThickenedArm;
use super::{Outline, OutlineCase, OutlineCut, OutlineOptions, general, merged, ring, terminus};

/// Edges that meet at less than this, degrees, lie on each other where coordinates are rounded.
const FOLD: f64 = 1.0;
/// Cuts closer together than this, metres, are the same but for rounding.
const SAME: f64 = 1e-9;

/// What is to be done at one intersection before the roads' other ends are known.
#[derive(Clone, Debug)]
pub struct IntersectionPlan {
    pub case: OutlineCase,
    pub star: RoadStar,
    /// The ground inside, where several nodes were merged.
    pub ground: Vec<Vec<Point>>,
    /// The outline if the star is trimmed as it would like to be.
    pub outline: Option<Outline>,
}

impl IntersectionPlan {
    fn new(case: OutlineCase, star: RoadStar) -> Self {
        Self { case, star, ground: Vec::new(), outline: None }
    }

    fn of(
        network: &RoadNetwork,
        intersection: &Intersection,
        arms: &[ThickenedArm],
        within: &[Stations],
        options: &OutlineOptions,
    ) -> Self {
        match arms {
            [_] if intersection.map_edge => Self::new(OutlineCase::MapEdge, RoadStar::terminus(0.0)),
            [arm] => Self::new(OutlineCase::DeadEnd, RoadStar::terminus(terminus::dead_end(arm, options))),
            _ => {
                let mut star = general::star(arms, options);
                for (i, arm) in arms.iter().enumerate() {
                    let [from, to] = within[arm.at.road];
                    let floor = if arm.at.end == End::Start { from } else { arm.length - to };
                    star.trims[i] = star.trims[i].max(floor);
                }
                let merged = !intersection.inner.is_empty();
                let case = match arms.len() {
                    _ if merged => OutlineCase::Merged,
                    2 => OutlineCase::Degenerate,
                    _ if star.wedge => OutlineCase::Ramp,
                    _ => OutlineCase::General,
                };
                let mut plan = Self::new(case, star);
                if !merged {
                    plan.outline = outline(&plan, arms, &plan.star.trims);
                }
                if plan.outline.is_none() {
                    plan.ground = merged::ground(network, intersection, arms);
                    plan.star.least = merged::trims(arms, &plan.ground, &plan.star.least, options);
                    plan.star.trims = merged::trims(arms, &plan.ground, &plan.star.trims, options);
                }
                plan
            }
        }
    }
}

/// An intersection of a network with its plan.
pub struct IntersectionSite<'a> {
    network: &'a RoadNetwork,
    pub intersection: &'a Intersection,
    options: &'a OutlineOptions,
    pub plan: Cow<'a, IntersectionPlan>,
    arms: OnceLock<Vec<ThickenedArm>>,
}

impl<'a> IntersectionSite<'a> {
    /// Plans an intersection, with every road cut back at least to the stations in `within`.
    pub fn new(
        network: &'a RoadNetwork,
        intersection: &'a Intersection,
        within: &[Stations],
        options: &'a OutlineOptions,
    ) -> Self {
        let arms = arms(network, intersection, options);
        let plan = Cow::Owned(IntersectionPlan::of(network, intersection, &arms, within, options));
        Self { network, intersection, options, plan, arms: OnceLock::from(arms) }
    }

    /// An intersection whose plan is known. Its arms are drawn only where it does not close as planned.
    pub fn known(
        network: &'a RoadNetwork,
        intersection: &'a Intersection,
        plan: &'a IntersectionPlan,
        options: &'a OutlineOptions,
    ) -> Self {
        Self { network, intersection, options, plan: Cow::Borrowed(plan), arms: OnceLock::new() }
    }

    /// Its arms in clockwise order.
    pub fn arms(&self) -> &[ThickenedArm] {
        self.arms.get_or_init(|| arms(self.network, self.intersection, self.options))
    }

    /// The station of each arm's cut, and that of the cut at its other end, seen from the intersection outwards.
    fn ends(&self, kept: &[Stations]) -> (Vec<f64>, Vec<f64>) {
        let seen = |arm: &ThickenedArm| {
            let [from, to] = kept[arm.at.road];
            match arm.at.end {
                End::Start => (from, to),
                End::End => (arm.length - to, arm.length - from),
            }
        };
        self.arms().iter().map(seen).unzip()
    }

    fn ground(&self) -> Cow<'_, [Vec<Point>]> {
        match self.plan.ground.is_empty() {
            true => Cow::Owned(merged::ground(self.network, self.intersection, self.arms())),
            false => Cow::Borrowed(&self.plan.ground),
        }
    }

    /// The outline that was planned, if every road is cut where the plan has it.
    fn as_planned(&self, kept: &[Stations]) -> Option<Outline> {
        let mut outline = self.plan.outline.clone()?;
        let arms = &self.intersection.arms;
        for ((at, planned), cut) in arms.iter().zip(&self.plan.star.trims).zip(&mut outline.cuts) {
            let [from, to] = kept[at.road];
            let trim = match at.end {
                End::Start => from,
                End::End => self.network.road(at.road).line.length() - to,
            };
            if (trim - planned).abs() >= SAME {
                return None;
            }
            // The network for which it was planned may have counted its roads otherwise.
            cut.at = *at;
        }
        Some(outline)
    }

    /// Closes the ring with the cuts as they came out; `None` if no simple ring goes through them.
    pub fn close(&self, kept: &[Stations]) -> Option<Outline> {
        if let Some(outline) = self.as_planned(kept) {
            return Some(outline);
        }
        let (trims, far) = self.ends(kept);
        if matches!(self.plan.case, OutlineCase::MapEdge) || trims.is_empty() {
            let cuts = cuts(self.arms(), &trims);
            return Some(Outline {
                case: self.plan.case,
                corners: vec![Vec::new(); cuts.len()],
                cuts,
                ring: Vec::new(),
            });
        }
        let general = || outline(&self.plan, self.arms(), &trims);
        let around = || self.around_union([&trims, &far]);
        // Roads that cover a cut of another keep the boundary from closing; the star's own corners still may.
        if self.plan.ground.is_empty() { general().or_else(around) } else { around().or_else(general) }
    }

    /// The outline around the union of what the roads cover.
    fn around_union(&self, [trims, far]: [&[f64]; 2]) -> Option<Outline> {
        let cuts = cuts(self.arms(), trims);
        let (order, sharp) = merged::corners(self.arms(), trims, far, &cuts, &self.ground())?;
        let cuts: Vec<OutlineCut> = order.into_iter().map(|i| cuts[i].clone()).collect();
        let round = sharp.iter().map(|chain| merged::rounded(chain, self.options.kerb_reach)).collect();
        [round, sharp].into_iter().find_map(|corners: Vec<Vec<Point>>| {
            let ring = ring::ring(&cuts, &corners);
            is_sound(&ring).then(|| Outline { case: self.plan.case, cuts: cuts.clone(), corners, ring })
        })
    }

    /// The arms whose cuts other roads cover.
    pub fn hidden(&self, kept: &[Stations]) -> impl Iterator<Item = &ThickenedArm> {
        let (trims, far) = self.ends(kept);
        let hidden = merged::hidden(self.arms(), [&trims, &far], &cuts(self.arms(), &trims), &self.ground());
        hidden.into_iter().map(|i| &self.arms()[i])
    }

    /// A shape for the intersection whose own could not be made: the convex hull of its cuts.
    pub fn fallback(&self, kept: &[Stations]) -> Outline {
        let cuts = cuts(self.arms(), &self.ends(kept).0);
        let corners = (0..cuts.len()).map(|i| vec![cuts[i].left, cuts[(i + 1) % cuts.len()].right]).collect();
        let ring = crate::geometry::polygon::convex_hull(cuts.iter().flat_map(|cut| [cut.left, cut.right]));
        Outline { case: OutlineCase::Fallback, cuts, corners, ring }
    }
}

fn arms(network: &RoadNetwork, intersection: &Intersection, options: &OutlineOptions) -> Vec<ThickenedArm> {
    intersection.arms.iter().map(|at| ThickenedArm::new(network, *at, options)).collect()
}

fn cuts(arms: &[ThickenedArm], trims: &[f64]) -> Vec<OutlineCut> {
    arms.iter().zip(trims).map(|(arm, trim)| ring::cut(arm, *trim)).collect()
}

/// The outline of the general method; `None` if it is no simple polygon.
fn outline(plan: &IntersectionPlan, arms: &[ThickenedArm], trims: &[f64]) -> Option<Outline> {
    let cuts = cuts(arms, trims);
    let (corners, ring) = [true, false].into_iter().find_map(|rounded| {
        let corners = corners(&plan.star, arms, trims, &cuts, rounded);
        let ring = ring::ring(&cuts, &corners);
        is_sound(&ring).then_some((corners, ring))
    })?;
    Some(Outline { case: plan.case, cuts, corners, ring })
}

/// Whether the ring is simple where it will be written, on the grid, and stays so when others round it again.
pub fn is_sound(ring: &[Point]) -> bool {
    let ring: Vec<Point> = ring.iter().copied().map(snap).collect();
    let distinct = ring.iter().zip(ring.iter().cycle().skip(1)).all(|(a, b)| a != b);
    distinct && faults(&ring, FOLD, 1).is_empty()
}

fn corners(
    star: &RoadStar,
    arms: &[ThickenedArm],
    trims: &[f64],
    cuts: &[OutlineCut],
    rounded: bool,
) -> Vec<Vec<Point>> {
    let n = arms.len();
    (0..n)
        .map(|i| {
            let next = (i + 1) % n;
            let (a, b) = (&arms[i], &arms[next]);
            let ends = [cuts[i].left, cuts[next].right];
            match fitted(a, b, ends, star.corners[i], rounded) {
                Some(corner) => ring::corner(a, b, [trims[i], trims[next]], ends, corner),
                None => ends.to_vec(),
            }
        })
        .collect()
}

/// The corner with a curve that begins before the cuts; `None` if the collision itself lies beyond a cut.
fn fitted(a: &ThickenedArm, b: &ThickenedArm, ends: [Point; 2], corner: Corner, rounded: bool) -> Option<Corner> {
    let Corner::Collision { point, along, tangent } = corner else { return Some(corner) };
    let room_a = a.right.project(ends[0]).station - along[0];
    let room_b = b.left.project(ends[1]).station - along[1];
    let room = room_a.min(room_b);
    let tangent = if rounded { tangent.min(room) } else { 0.0 };
    (room >= 0.0).then_some(Corner::Collision { point, along, tangent })
}
