//! The plan of an intersection, made before the other ends of its roads are known, and its outline for the final cuts.

use std::borrow::Cow;
use std::sync::OnceLock;

use crate::builder::network::{Intersection, RoadEnd, RoadNetwork, Stations};
use crate::builder::streets::snap_grid::snap;
use crate::geometry::Point;
use crate::geometry::polygon::{convex_hull, outside};
use crate::geometry::simple_ring::{faults, without_faults};

use super::general_outline::RoadStar;
use super::merged_outline::{CutArea, TOUCH, split_at_cuts};
use super::ring::Corner;
use super::sizes::KERB_REACH;
use super::thicken::{ThickenedArm, outwards};
use super::{Outline, OutlineCase, OutlineCut, general_outline, merged_outline, ring, terminus};

/// Least angle between edges, degrees: smaller ones may coincide after rounding.
const FOLD: f64 = 1.0;
/// The largest distance between equal cuts after rounding, metres.
const SAME_CUT: f64 = 1e-9;

/// Where more roads than this meet, the union of their ends is not asked for: all of them cross each other, in each of many rounds. Their
/// outline is the hull of their cuts.
const MOST_IN_UNION: usize = 48;

/// The plan of one intersection.
#[derive(Clone, Debug)]
pub struct IntersectionPlan {
    pub case: OutlineCase,
    pub star: RoadStar,
    /// The ground inside, if the outline is the boundary of a union.
    pub ground: Vec<Vec<Point>>,
    /// The outline if the arms are cut at the star's `trims`.
    pub outline: Option<Outline>,
}

impl IntersectionPlan {
    fn new(case: OutlineCase, star: RoadStar) -> Self {
        Self { case, star, ground: Vec::new(), outline: None }
    }

    fn of(network: &RoadNetwork, intersection: &Intersection, arms: &[ThickenedArm], within: &[Stations]) -> Self {
        match arms {
            [_] if intersection.map_edge => Self::new(OutlineCase::MapEdge, RoadStar::terminus(0.0)),
            [arm] => Self::new(OutlineCase::DeadEnd, RoadStar::terminus(terminus::dead_end(arm))),
            _ => {
                let mut star = general_outline::star(arms);
                for (i, arm) in arms.iter().enumerate() {
                    let [least, _] = arm.outwards(within);
                    star.trims[i] = star.trims[i].max(least);
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
                if plan.outline.is_none() && arms.len() <= MOST_IN_UNION {
                    plan.ground = merged_outline::ground(network, intersection, arms);
                    plan.star.least = merged_outline::trims(arms, &plan.ground, &plan.star.least);
                    plan.star.trims = merged_outline::trims(arms, &plan.ground, &plan.star.trims);
                }
                plan
            }
        }
    }
}

impl Outline {
    /// The outline without what `others` cover of its corners; `None` if they cover a cut, or no simple ring is left.
    pub(super) fn without(&self, others: &[Vec<Point>]) -> Option<Self> {
        let (order, corners) = split_at_cuts(&outside(&self.ring, others)?, &self.cuts, TOUCH)?;
        if !order.is_sorted() {
            return None;
        }
        let ring = ring::ring(&self.cuts, &corners);
        is_valid(&ring).then(|| Self { corners, ring, ..self.clone() })
    }
}

/// An intersection of a network with its plan.
pub struct IntersectionSite<'a> {
    network: &'a RoadNetwork,
    pub intersection: &'a Intersection,
    pub plan: Cow<'a, IntersectionPlan>,
    arms: OnceLock<Vec<ThickenedArm>>,
}

impl<'a> IntersectionSite<'a> {
    /// Plans an intersection. Every road is cut back at least to its stations in `within`.
    pub fn new(network: &'a RoadNetwork, intersection: &'a Intersection, within: &[Stations]) -> Self {
        let arms = arms(network, intersection);
        let plan = Cow::Owned(IntersectionPlan::of(network, intersection, &arms, within));
        Self { network, intersection, plan, arms: OnceLock::from(arms) }
    }

    /// An intersection with a known plan. Its arms are made only if the planned outline does not fit.
    pub fn known(network: &'a RoadNetwork, intersection: &'a Intersection, plan: &'a IntersectionPlan) -> Self {
        Self { network, intersection, plan: Cow::Borrowed(plan), arms: OnceLock::new() }
    }

    /// Its arms, clockwise.
    pub fn arms(&self) -> &[ThickenedArm] {
        self.arms.get_or_init(|| arms(self.network, self.intersection))
    }

    /// The stations of each arm's cut and of the cut at its other end, metres outwards.
    fn ends(&self, kept: &[Stations]) -> (Vec<f64>, Vec<f64>) {
        self.arms().iter().map(|arm| <(f64, f64)>::from(arm.outwards(kept))).unzip()
    }

    fn ground(&self) -> Cow<'_, [Vec<Point>]> {
        match self.plan.ground.is_empty() {
            true => Cow::Owned(merged_outline::ground(self.network, self.intersection, self.arms())),
            false => Cow::Borrowed(&self.plan.ground),
        }
    }

    /// The planned outline, if every road is cut as planned.
    fn as_planned(&self, kept: &[Stations]) -> Option<Outline> {
        let mut outline = self.plan.outline.clone()?;
        let arms = &self.intersection.arms;
        for ((arm, planned), cut) in arms.iter().zip(&self.plan.star.trims).zip(&mut outline.cuts) {
            let [trim, _] = outwards(*arm, self.network.road(arm.road).line.length(), kept);
            if (trim - planned).abs() >= SAME_CUT {
                return None;
            }
            // The roads may have other indices than in the network of the plan.
            cut.at = *arm;
        }
        Some(outline)
    }

    /// The outline for these cuts; `None` if there is no simple ring.
    pub fn close(&self, kept: &[Stations]) -> Option<Outline> {
        if let Some(outline) = self.as_planned(kept) {
            return Some(outline);
        }
        let (trims, far) = self.ends(kept);
        if matches!(self.plan.case, OutlineCase::MapEdge) || trims.is_empty() {
            let cuts = ring::cuts(self.arms(), &trims);
            return Some(Outline {
                case: self.plan.case,
                corners: vec![Vec::new(); cuts.len()],
                cuts,
                ring: Vec::new(),
            });
        }
        let general = || outline(&self.plan, self.arms(), &trims);
        if self.is_crowded() {
            return general();
        }
        let around = || self.around_union(&trims, &far);
        // If a road covers the cut of another, the boundary does not close; the corners of the star still may.
        if self.plan.ground.is_empty() { general().or_else(around) } else { around().or_else(general) }
    }

    /// The outline around the union of the ground that the roads cover.
    fn around_union(&self, trims: &[f64], far: &[f64]) -> Option<Outline> {
        let ground = self.ground();
        let area = CutArea::new(self.arms(), trims, &ground);
        let (order, sharp) = area.corners(far)?;
        let cuts: Vec<OutlineCut> = order.into_iter().map(|i| area.cuts[i].clone()).collect();
        let round = sharp.iter().map(|chain| merged_outline::rounded(chain, KERB_REACH)).collect();
        [round, sharp].into_iter().find_map(|corners: Vec<Vec<Point>>| {
            let ring = ring::ring(&cuts, &corners);
            is_valid(&ring).then(|| Outline { case: self.plan.case, cuts: cuts.clone(), corners, ring })
        })
    }

    /// Whether so many roads meet that its outline is the hull of their cuts.
    fn is_crowded(&self) -> bool {
        self.arms().len() > MOST_IN_UNION
    }

    /// The arms whose cuts other roads cover; none where too many roads meet.
    pub fn covered_arms(&self, kept: &[Stations]) -> impl Iterator<Item = RoadEnd> {
        let (trims, far) = self.ends(kept);
        let covered = match self.is_crowded() {
            true => Vec::new(),
            false => CutArea::new(self.arms(), &trims, &self.ground()).covered_arms(&far),
        };
        covered.into_iter().map(|i| self.arms()[i].road_end)
    }

    /// The ground that the roads leave where no outline closes from cut to cut, because some cut is covered; the convex hull of
    /// the cuts where that is no simple ring either.
    pub fn fallback(&self, kept: &[Stations]) -> Outline {
        let (trims, far) = self.ends(kept);
        let cuts = ring::cuts(self.arms(), &trims);
        let corners = (0..cuts.len()).map(|i| vec![cuts[i].left, cuts[(i + 1) % cuts.len()].right]).collect();
        let left = || CutArea::new(self.arms(), &trims, &self.ground()).without_own_roads(&far);
        let ring = (!self.is_crowded()).then(left).flatten().map(simple).filter(|ring| is_valid(ring));
        let ring = ring.unwrap_or_else(|| convex_hull(cuts.iter().flat_map(|cut| [cut.left, cut.right])));
        Outline { case: OutlineCase::Fallback, cuts, corners, ring }
    }
}

fn arms(network: &RoadNetwork, intersection: &Intersection) -> Vec<ThickenedArm> {
    intersection.arms.iter().map(|arm| ThickenedArm::new(network, *arm)).collect()
}

/// The outline of the general method; `None` if it is not a simple polygon.
fn outline(plan: &IntersectionPlan, arms: &[ThickenedArm], trims: &[f64]) -> Option<Outline> {
    let cuts = ring::cuts(arms, trims);
    let (corners, ring) = [true, false].into_iter().find_map(|rounded| {
        let corners = corners(&plan.star, arms, trims, &cuts, rounded);
        let ring = ring::ring(&cuts, &corners);
        is_valid(&ring).then_some((corners, ring))
    })?;
    Some(Outline { case: plan.case, cuts, corners, ring })
}

/// Whether the ring is simple on the grid on which it is written, and stays so if it is rounded again.
pub fn is_valid(ring: &[Point]) -> bool {
    let ring: Vec<Point> = ring.iter().copied().map(snap).collect();
    let distinct = ring.iter().zip(ring.iter().cycle().skip(1)).all(|(a, b)| a != b);
    distinct && faults(&ring, FOLD, 1).is_empty()
}

/// A ring on the grid on which it is written, without what would fold or cross there.
fn simple(ring: Vec<Point>) -> Vec<Point> {
    let mut ring: Vec<Point> = ring.into_iter().map(snap).collect();
    ring.dedup();
    without_faults(&ring, FOLD, |_| false).into_iter().map(|i| ring[i]).collect()
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

/// The corner with a curve between the cuts; `None` if the collision lies beyond a cut.
fn fitted(a: &ThickenedArm, b: &ThickenedArm, ends: [Point; 2], corner: Corner, rounded: bool) -> Option<Corner> {
    let Corner::Collision { point, along, tangent } = corner else { return Some(corner) };
    let room_a = a.right.project(ends[0]).station - along[0];
    let room_b = b.left.project(ends[1]).station - along[1];
    let room = room_a.min(room_b);
    let tangent = if rounded { tangent.min(room) } else { 0.0 };
    (room >= 0.0).then_some(Corner::Collision { point, along, tangent })
}
