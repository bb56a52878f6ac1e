//! What two rings have in common as Boost.Geometry finds it, also where one crosses itself: it looks at the sides only where the
//! outlines meet, and takes what lies to the right of an outline for its inside.

use std::cmp::Ordering;
use std::collections::{BTreeMap, BTreeSet};

use super::insides::{Cell, Grid, apart, cross, dot, lies_in, minus, range};
use super::{Point, polygon};

/// Whether two rings have interior points in common. Rings are not turned: the inside of one that runs counter-clockwise is what
/// lies around it.
pub fn insides_meet(a: &[Point], b: &[Point]) -> bool {
    let Some(rings) = both(a, b) else { return false };
    let Some(meetings) = meetings(&rings) else { return true };
    let along = meetings.iter().any(|one| one.ways.contains(&Way::Along));
    let inward = |one: &Meeting| one.ways == [Way::In; 2];
    let level = |one: &Meeting| inward(one) || one.ways == [Way::Out; 2];
    along
        || (0..2).any(|side| enters(&meetings, side))
        || (meetings.iter().any(inward) && meetings.iter().all(level))
        || (meetings.is_empty() && (0..2).any(|side| rings[side].starts_in(&rings[1 - side])))
}

/// The common area of two rings, square metres.
pub fn common_area(a: &[Point], b: &[Point]) -> f64 {
    let Some(rings) = both(a, b).filter(|rings| rings.iter().all(|ring| ring.cells.len() > 2)) else { return 0.0 };
    let Some(meetings) = meetings(&rings) else { return rings[0].area().max(0.0) };
    if meetings.is_empty() {
        let inner = (0..2).filter(|&side| rings[side].starts_in(&rings[1 - side]));
        return inner.map(|side| rings[side].area().max(0.0)).sum();
    }
    Walk::new(rings, meetings).area()
}

/// [`common_area`] after both rings are turned so that they run clockwise, by the sign of their area.
pub fn common_area_turned(a: &[Point], b: &[Point]) -> f64 {
    let turned = |ring: &[Point]| -> Vec<Point> {
        if polygon::signed_area(ring) > 0.0 { ring.iter().rev().copied().collect() } else { ring.to_vec() }
    };
    common_area(&turned(a), &turned(b))
}

/// A ring on the grid, without equal neighbours.
struct Outline {
    cells: Vec<Cell>,
    /// The vertices that were rounded to them.
    places: Vec<Point>,
}

fn both(a: &[Point], b: &[Point]) -> Option<[Outline; 2]> {
    let grid = Grid::over(a, b)?;
    let rings = [a, b].map(|ring| Outline::new(ring, &grid));
    rings.iter().all(|ring| !ring.cells.is_empty()).then_some(rings)
}

impl Outline {
    fn new(ring: &[Point], grid: &Grid) -> Self {
        let mut outline = Self { cells: Vec::with_capacity(ring.len()), places: Vec::with_capacity(ring.len()) };
        for &place in ring {
            let cell = grid.cell(place);
            if outline.cells.last() != Some(&cell) {
                outline.cells.push(cell);
                outline.places.push(place);
            }
        }
        while outline.cells.len() > 1 && outline.cells.first() == outline.cells.last() {
            outline.cells.pop();
            outline.places.pop();
        }
        outline
    }

    fn vertex(&self, at: usize) -> Cell {
        self.cells[at % self.cells.len()]
    }

    /// Square metres, positive if it runs clockwise.
    fn area(&self) -> f64 {
        -polygon::signed_area(&self.places)
    }

    fn starts_in(&self, other: &Self) -> bool {
        lies_in(self.cells[0], &other.cells)
    }

    fn place(&self, at: Station) -> Point {
        let (from, to) = (self.places[at.edge], self.places[(at.edge + 1) % self.places.len()]);
        from + (to - from) * (at.part as f64 / at.whole as f64)
    }

    /// The direction in which the ring goes on from a place.
    fn ahead(&self, at: Station) -> Cell {
        minus(self.vertex(at.edge + 1), self.vertex(at.edge))
    }

    /// The direction from a place back along the ring.
    fn behind(&self, at: Station) -> Cell {
        let before = if at.part == 0 { at.edge + self.cells.len() - 1 } else { at.edge + 1 };
        let back = minus(self.vertex(before), self.vertex(at.edge));
        if at.part == 0 { back } else { back.map(|v| -v) }
    }

    /// What a direction from a place on this ring leads to.
    fn side_of(&self, direction: Cell, at: Station) -> Way {
        if is_between(direction, self.ahead(at), self.behind(at)) { Way::Out } else { Way::In }
    }
}

/// Whether a direction lies counter-clockwise of the second one and before the third one.
fn is_between(direction: Cell, from: Cell, to: Cell) -> bool {
    let [whole, first, rest] = [cross(from, to), cross(from, direction), cross(direction, to)];
    match whole.cmp(&0) {
        Ordering::Greater => first > 0 && rest > 0,
        Ordering::Equal if dot(from, to) < 0 => first > 0,
        Ordering::Equal => first != 0 || dot(from, direction) <= 0,
        Ordering::Less => first > 0 || rest > 0,
    }
}

/// A place on a ring: a share of an edge, less than 1.
#[derive(Clone, Copy, Debug)]
struct Station {
    edge: usize,
    part: i64,
    whole: i64,
}

impl Station {
    /// The place at a share of an edge of a ring with this many edges.
    fn of(edge: usize, part: i64, whole: i64, edges: usize) -> Self {
        match part {
            0 => Self { edge, part: 0, whole: 1 },
            _ if part == whole => Self { edge: (edge + 1) % edges, part: 0, whole: 1 },
            _ => Self { edge, part, whole },
        }
    }
}

impl Ord for Station {
    fn cmp(&self, other: &Self) -> Ordering {
        let share = |one: &Self, two: &Self| i128::from(one.part) * i128::from(two.whole);
        self.edge.cmp(&other.edge).then_with(|| share(self, other).cmp(&share(other, self)))
    }
}

impl PartialOrd for Station {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Station {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Station {}

/// A place on both rings.
type Both = [Station; 2];

/// How a ring goes on where it meets the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Way {
    /// To the left of the other.
    Out,
    /// To the right of the other.
    In,
    /// Along the other, against its direction.
    Blocked,
    /// Along the other, in its direction.
    Along,
}

/// A place where the rings meet, and how each goes on from there.
struct Meeting {
    at: Both,
    ways: [Way; 2],
}

impl Meeting {
    /// Of rings that go on along edges of their own.
    fn parting([a, b]: &[Outline; 2], at: Both) -> Self {
        Self { at, ways: [b.side_of(a.ahead(at[0]), at[1]), a.side_of(b.ahead(at[1]), at[0])] }
    }
}

/// Where edges meet, before stretches are joined.
#[derive(Default)]
struct Contacts {
    crossings: Vec<Meeting>,
    points: BTreeSet<Both>,
    /// The stretches along which the rings run in opposite directions (0) or in one (1): where the first ring enters and leaves them.
    stretches: [BTreeMap<Both, Both>; 2],
}

/// The places where two rings meet, in the order of the first one; `None` if they run along each other all the way round.
fn meetings(rings: &[Outline; 2]) -> Option<Vec<Meeting>> {
    let mut contacts = Contacts::default();
    let [a, b] = [0, 1].map(|side| rings[side].cells.len());
    for i in 0..a {
        for j in 0..b {
            contacts.compare(rings, [i, j]);
        }
    }
    let Contacts { crossings: mut found, mut points, stretches } = contacts;
    for (along, stretches) in stretches.into_iter().enumerate() {
        let ends: BTreeSet<Both> = stretches.values().copied().collect();
        let starts: Vec<Both> = stretches.keys().copied().filter(|start| !ends.contains(start)).collect();
        if starts.is_empty() && !stretches.is_empty() {
            return None;
        }
        points.retain(|at| !ends.contains(at) && !stretches.contains_key(at));
        for start in starts {
            let end = std::iter::successors(stretches.get(&start), |end| stretches.get(*end)).last();
            found.extend(end.into_iter().flat_map(|&end| stretch(rings, [start, end], along == 1)));
        }
    }
    found.extend(points.into_iter().map(|at| Meeting::parting(rings, at)));
    found.sort_by_key(|one| (one.at, one.ways));
    Some(found)
}

/// Where two rings begin and cease to run along each other.
fn stretch(rings: &[Outline; 2], [start, end]: [Both; 2], along: bool) -> [Meeting; 2] {
    let [mut first, mut last] = [start, end].map(|at| Meeting::parting(rings, at));
    if along {
        first.ways = [Way::Along; 2];
    } else {
        first.ways[0] = Way::Blocked;
        last.ways[1] = Way::Blocked;
    }
    [first, last]
}

impl Contacts {
    /// Adds where two edges meet.
    fn compare(&mut self, rings: &[Outline; 2], edges: [usize; 2]) {
        let [[p, q], [u, v]] = [0, 1].map(|side| [0, 1].map(|end| rings[side].vertex(edges[side] + end)));
        if [0, 1].iter().any(|&axis| apart(range(&[p, q], axis), range(&[u, v], axis))) {
            return;
        }
        let (d, e) = (minus(q, p), minus(v, u));
        let across = cross(d, e);
        if across == 0 {
            if cross(d, minus(u, p)) == 0 {
                self.lie_along(rings, edges, [[p, q], [u, v]]);
            }
            return;
        }
        let sign = across.signum();
        let [whole, t, s] = [across, cross(minus(u, p), e), cross(minus(u, p), d)].map(|v| v * sign);
        if (0..=whole).contains(&t) && (0..=whole).contains(&s) {
            let at =
                [(0, t), (1, s)].map(|(side, part)| Station::of(edges[side], part, whole, rings[side].cells.len()));
            if [t, s].iter().all(|part| (1..whole).contains(part)) {
                let ways = if sign > 0 { [Way::In, Way::Out] } else { [Way::Out, Way::In] };
                self.crossings.push(Meeting { at, ways });
            } else {
                self.points.insert(at);
            }
        }
    }

    /// Adds the common stretch of two edges on one line.
    fn lie_along(&mut self, rings: &[Outline; 2], [i, j]: [usize; 2], [[p, q], [u, v]]: [[Cell; 2]; 2]) {
        let (d, e) = (minus(q, p), minus(v, u));
        let (whole, other) = (dot(d, d), dot(e, e));
        let [from, to] = [u, v].map(|end| dot(d, minus(end, p)));
        let (low, high) = (from.min(to).max(0), from.max(to).min(whole));
        let [start, end] = [low, high].map(|at| {
            // Each end is an end of one of both edges.
            let part = match at {
                _ if at == from => 0,
                _ if at == to => other,
                0 => dot(e, minus(p, u)),
                _ => dot(e, minus(q, u)),
            };
            [Station::of(i, at, whole, rings[0].cells.len()), Station::of(j, part, other, rings[1].cells.len())]
        });
        match low.cmp(&high) {
            Ordering::Less => {
                self.stretches[usize::from(dot(d, e) > 0)].insert(start, end);
            }
            Ordering::Equal => {
                self.points.insert(start);
            }
            Ordering::Greater => {}
        }
    }
}

/// Whether one of the rings enters the other. Of several meetings at one place of it, the last tells.
fn enters(meetings: &[Meeting], side: usize) -> bool {
    let mut order: Vec<&Meeting> = meetings.iter().collect();
    order.sort_by_key(|one| (one.at[side], one.ways[side]));
    let groups = order.chunk_by(|a, b| a.at[side] == b.at[side]);
    groups.into_iter().any(|group| {
        let last = group.last().is_some_and(|one| one.ways[side] == Way::In);
        last && group.iter().any(|one| one.ways[side] == Way::In && one.ways[1 - side] != Way::In)
    })
}

/// A walk along the outline of what two rings have in common.
struct Walk {
    rings: [Outline; 2],
    meetings: Vec<Meeting>,
    /// For each ring, the meeting that comes after each.
    next: [Vec<usize>; 2],
    /// Which rings have been followed from each meeting.
    followed: Vec<[bool; 2]>,
}

impl Walk {
    fn new(rings: [Outline; 2], mut meetings: Vec<Meeting>) -> Self {
        meetings.retain(|one| one.ways != [Way::Out; 2] && one.ways != [Way::Blocked; 2]);
        let next = [0, 1].map(|side| {
            let mut order: Vec<usize> = (0..meetings.len()).collect();
            order.sort_by_key(|&one| meetings[one].at[side]);
            let mut next = vec![0; order.len()];
            order.iter().zip(order.iter().cycle().skip(1)).for_each(|(&one, &after)| next[one] = after);
            next
        });
        Self { followed: vec![[false; 2]; meetings.len()], rings, meetings, next }
    }

    fn area(mut self) -> f64 {
        let starts: Vec<(usize, usize)> = (0..self.meetings.len()).flat_map(|one| [(one, 0), (one, 1)]).collect();
        let rings: Vec<Vec<Point>> = starts.into_iter().filter_map(|start| self.ring_from(start)).collect();
        // Rings that run the other way round are no areas.
        rings.iter().map(|ring| (-polygon::signed_area(ring)).max(0.0)).sum()
    }

    /// The ring that begins at a meeting along one of the rings; `None` if the walk does not come back there.
    fn ring_from(&mut self, start: (usize, usize)) -> Option<Vec<Point>> {
        if !self.leads_on(start) {
            return None;
        }
        let mut ring = Vec::new();
        let mut taken = BTreeSet::new();
        let mut at = start;
        loop {
            let next = self.next[at.1][at.0];
            self.draw(at, next, &mut ring);
            let chosen = self.choose(next, at.1, &taken);
            // Back on its first step it is closed, whichever ring it would follow then.
            let closed = (at == start && next == start.0) || chosen == Some(start);
            taken.extend(chosen);
            if closed {
                break;
            }
            at = chosen?;
        }
        taken.insert(start);
        taken.into_iter().for_each(|(one, side)| self.followed[one][side] = true);
        Some(ring)
    }

    fn leads_on(&self, (one, side): (usize, usize)) -> bool {
        matches!(self.meetings[one].ways[side], Way::In | Way::Along) && !self.followed[one][side]
    }

    /// Which ring to follow from a meeting that was reached along one of them: the other one, where both lead on.
    fn choose(&self, one: usize, from: usize, taken: &BTreeSet<(usize, usize)>) -> Option<(usize, usize)> {
        let [free, rest] = [0, 1].map(|side| self.leads_on((one, side)) && !taken.contains(&(one, side)));
        let side = match (free, rest) {
            (true, true) if self.meetings[one].ways[0] == Way::In => 1 - from,
            (true, _) => 0,
            (false, true) => 1,
            (false, false) => return None,
        };
        Some((one, side))
    }

    /// Adds the vertices from one meeting to the next along a ring.
    fn draw(&self, (one, side): (usize, usize), next: usize, ring: &mut Vec<Point>) {
        let outline = &self.rings[side];
        let [from, to] = [one, next].map(|one| self.meetings[one].at[side]);
        let around = if to <= from { outline.cells.len() } else { 0 };
        ring.push(outline.place(from));
        let last = to.edge + around + usize::from(to.part > 0);
        ring.extend((from.edge + 1..last).map(|at| outline.places[at % outline.places.len()]));
    }
}

#[cfg(test)]
mod tests;
