//! The nodes at the ends of borders: where the file links lanes, their borders end in the same nodes.

use std::collections::BTreeMap;

use crate::xodr::Place;

use super::contacts::{Contact, LaneEnd};
use super::lane_use::sides;

/// Ends of borders up to this far from each other, metres, are one place: its mean.
pub const WELD: f64 = 0.05;
/// Ends of borders of linked lanes farther apart than this, metres, stay apart: there is no way on.
pub const FARTHEST: f64 = 1.5;

/// The end of a border: index of the stretch, whether it is the end at the larger station, the border.
pub type BorderEnd = (usize, bool, i64);

/// For each end of a border the first one of its node, and the node's place.
pub type EndNodes = BTreeMap<BorderEnd, (BorderEnd, Place)>;

/// Ends of borders, each with its node.
#[derive(Default)]
pub struct Nodes {
    known: BTreeMap<BorderEnd, usize>,
    ends: Vec<BorderEnd>,
    places: Vec<Place>,
    /// Whether an end lies in a junction: it yields to one that does not.
    inside: Vec<bool>,
    parent: Vec<usize>,
    /// The ends that are one node, by their root.
    members: Vec<Vec<usize>>,
}

/// A contact whose lanes do not meet well.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gap {
    /// The contact.
    pub contact: Contact,
    /// Metres.
    pub distance: f64,
    /// Whether the lanes were joined all the same.
    pub joined: bool,
}

fn distance(a: Place, b: Place) -> f64 {
    (a[0] - b[0]).hypot(a[1] - b[1])
}

impl Nodes {
    /// Adds the end of a border.
    pub fn add(&mut self, end: BorderEnd, place: Place, inside: bool) {
        self.known.insert(end, self.ends.len());
        self.parent.push(self.ends.len());
        self.members.push(vec![self.ends.len()]);
        self.ends.push(end);
        self.places.push(place);
        self.inside.push(inside);
    }

    fn root(&self, mut at: usize) -> usize {
        while self.parent[at] != at {
            at = self.parent[at];
        }
        at
    }

    fn unite(&mut self, a: usize, b: usize) {
        let [a, b] = [self.root(a), self.root(b)];
        if a != b {
            let (keeps, yields) = (a.min(b), a.max(b));
            self.parent[yields] = keeps;
            let moved = std::mem::take(&mut self.members[yields]);
            self.members[keeps].extend(moved);
        }
    }

    /// Whether one node for both ends would be one for two borders of a stretch.
    fn closes_lane(&self, a: usize, b: usize) -> bool {
        let [a, b] = [a, b].map(|at| self.root(at));
        let of = |root: usize| self.members[root].iter().map(|&at| self.ends[at]);
        a != b && of(a).any(|one| of(b).any(|other| (one.0, one.1) == (other.0, other.1)))
    }

    /// Makes two ends of borders of one stretch one node, where the borders are one.
    pub fn pinch(&mut self, a: BorderEnd, b: BorderEnd) {
        if let (Some(&a), Some(&b)) = (self.known.get(&a), self.known.get(&b)) {
            self.unite(a, b);
        }
    }

    /// Joins the borders of lanes that meet; gives the contacts with a gap. Strips beside the lanes are joined only where they meet.
    pub fn join(&mut self, contacts: &[Contact], driven: impl Fn(LaneEnd) -> bool) -> Vec<Gap> {
        let mut gaps = Vec::new();
        let mut far_apart = Vec::new();
        let (lanes, strips): (Vec<&Contact>, Vec<&Contact>) =
            contacts.iter().partition(|contact| contact.ends.into_iter().all(&driven));
        for contact in lanes {
            let Some(pairs) = self.pairs(contact) else { continue };
            let most = pairs.map(|[a, b]| distance(self.places[a], self.places[b])).into_iter().fold(0.0, f64::max);
            if most <= WELD {
                pairs.into_iter().for_each(|[a, b]| self.unite(a, b));
            } else {
                far_apart.push((*contact, pairs, most));
            }
        }
        // Strips beside the lanes end where they meet; a lane that begins between them keeps its two borders.
        for contact in strips {
            for [a, b] in self.pairs(contact).into_iter().flatten() {
                if distance(self.places[a], self.places[b]) <= WELD && !self.closes_lane(a, b) {
                    self.unite(a, b);
                }
            }
        }
        // The nearer ones first: none of them may pull a lane's own borders together.
        far_apart.sort_by(|a, b| a.2.total_cmp(&b.2).then(a.0.cmp(&b.0)));
        for (contact, pairs, distance) in far_apart {
            let roots = pairs.map(|pair| pair.map(|at| self.root(at)));
            let [[a, b], [c, d]] = roots;
            let collapses = (a == c) != (b == d) || a == d || b == c;
            let joined = distance <= FARTHEST && !collapses;
            if joined {
                pairs.into_iter().for_each(|[a, b]| self.unite(a, b));
            }
            if !(joined && contact.bridged) {
                gaps.push(Gap { contact, distance, joined });
            }
        }
        gaps
    }

    /// Makes ends of driven lanes' borders that lie at one place one node, whatever is linked: lanes of two roads side by side. Where that
    /// would let one lane lead to another, they stay apart.
    pub fn touch(&mut self, driven: impl Fn(LaneEnd) -> bool) {
        let beside = |(stretch, far, border): BorderEnd| {
            let lanes = [border, border + 1, border - 1].map(|lane| LaneEnd { stretch, far, lane });
            lanes.into_iter().filter(|end| end.lane != 0 && sides(end.lane).contains(&border)).find(|end| driven(*end))
        };
        let mut by_cell: BTreeMap<[i64; 2], Vec<usize>> = BTreeMap::new();
        let cell = |[x, y, _]: Place| [x, y].map(|it| (it / WELD).floor() as i64);
        let own: Vec<usize> = (0..self.ends.len()).filter(|&at| beside(self.ends[at]).is_some()).collect();
        for &at in &own {
            by_cell.entry(cell(self.places[at])).or_default().push(at);
        }
        for a in own {
            let [x, y] = cell(self.places[a]);
            let around = (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [x + dx, y + dy]));
            let near: Vec<usize> = around.filter_map(|cell| by_cell.get(&cell)).flatten().copied().collect();
            for b in near.into_iter().filter(|&b| b > a) {
                let lie = self.ends[b].0 != self.ends[a].0
                    && distance(self.places[a], self.places[b]) <= WELD
                    && (self.places[a][2] - self.places[b][2]).abs() <= WELD;
                if lie && self.root(a) != self.root(b) && !self.closes_lane(a, b) && !self.leads_on(a, b) {
                    self.unite(a, b);
                }
            }
        }
    }

    /// Whether one node for both ends would let a lane that ends at one lead to a lane that ends at the other: their other borders end
    /// in one node already.
    fn leads_on(&self, a: usize, b: usize) -> bool {
        let others = |at: usize| -> Vec<usize> {
            let ends = self.members[self.root(at)].iter().map(|&member| self.ends[member]);
            let next = |(stretch, far, border): BorderEnd| [border - 1, border + 1].map(|it| (stretch, far, it));
            ends.flat_map(next).filter_map(|end| self.known.get(&end)).map(|&other| self.root(other)).collect()
        };
        let of_a = others(a);
        others(b).iter().any(|root| of_a.contains(root))
    }

    /// The ends of borders that a contact joins.
    fn pairs(&self, contact: &Contact) -> Option<[[usize; 2]; 2]> {
        let [a, b] = contact
            .ends
            .map(|end| sides(end.lane).map(|border| self.known.get(&(end.stretch, end.far, border)).copied()));
        let [[Some(a_high), Some(a_low)], [Some(b_high), Some(b_low)]] = [a, b] else { return None };
        // Where the roads run against each other, left and right change sides.
        let against = contact.ends[0].far == contact.ends[1].far;
        Some(if against { [[a_high, b_low], [a_low, b_high]] } else { [[a_high, b_high], [a_low, b_low]] })
    }

    /// For each end of a border the first end of its node and the node's place: the mean of ends that lie together, else where the
    /// roads outside junctions have it.
    pub fn places(&self) -> EndNodes {
        let mut all = BTreeMap::new();
        for members in self.members.iter().filter(|members| !members.is_empty()) {
            let first = members.iter().copied().map(|at| self.ends[at]).min().unwrap_or_default();
            let place = self.meeting(members);
            all.extend(members.iter().map(|&at| (self.ends[at], (first, place))));
        }
        self.carry_along(&mut all);
        all
    }

    /// Moves an end that nothing is joined to with the end beside it, where the lane between them has no width and the other is drawn off
    /// to its node: the lane's borders would cross.
    fn carry_along(&self, all: &mut EndNodes) {
        let alone = self.members.iter().filter(|members| members.len() == 1).map(|members| members[0]);
        for at in alone {
            let (stretch, far, border) = self.ends[at];
            let own = self.places[at];
            let beside = [border - 1, border + 1].into_iter().filter_map(|it| self.known.get(&(stretch, far, it)));
            let together = beside.copied().filter(|&other| distance(own, self.places[other]) <= WELD);
            let moved = together.filter_map(|other| {
                let (_, place) = all.get(&self.ends[other])?;
                let shift: Place = std::array::from_fn(|i| place[i] - self.places[other][i]);
                (shift[0].hypot(shift[1]) > WELD).then_some(shift)
            });
            let Some(shift) = moved.into_iter().next() else { continue };
            if let Some((_, place)) = all.get_mut(&self.ends[at]) {
                *place = std::array::from_fn(|i| own[i] + shift[i]);
            }
        }
    }

    fn meeting(&self, members: &[usize]) -> Place {
        let at = |member: usize| self.places[member];
        let together = members.iter().all(|&a| distance(at(a), at(members[0])) <= WELD);
        let outside: Vec<usize> = members.iter().copied().filter(|&member| !self.inside[member]).collect();
        let counted = match (together, outside.first()) {
            (true, _) => members.to_vec(),
            (false, Some(&first)) => {
                outside.iter().copied().filter(|&other| distance(at(other), at(first)) <= WELD).collect()
            }
            (false, None) => vec![members[0]],
        };
        let mut sum = [0.0; 3];
        for &member in &counted {
            sum.iter_mut().zip(at(member)).for_each(|(sum, value)| *sum += value);
        }
        sum.map(|sum| sum / counted.len() as f64)
    }
}
