//! What is painted along a bound: pieces by station, cut out of it and drawn as dashes and parallels.

use crate::geometry::{Point, Polyline};

/// Length of a dash, metres, as between the lanes of a town's streets; ...
pub const DASH: f64 = 3.0;
/// ... the next one begins so many metres behind its begin.
pub const DASH_PERIOD: f64 = 9.0;
/// Length of a dot, metres: the block of a block marking; ...
const DOT: f64 = 0.5;
/// ... the next one begins so many metres behind its begin.
const DOT_PERIOD: f64 = 1.0;
/// Each line of a double one lies so many metres from the bound.
pub const DOUBLE_APART: f64 = 0.18;
/// Breadth of paint, metres.
pub const PAINT: f64 = 0.12;
/// Breadth of a kerb, metres.
pub const KERB: f64 = 0.3;
/// Parallels are mitred up to so many times their distance.
const MITER_MOST: f64 = 3.0;

/// What runs along a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One unbroken line.
    Solid(Paint),
    /// One line of dashes.
    Dashed(Paint),
    /// One line of blocks as long as the gaps between them.
    Dotted(Paint),
    /// Two unbroken lines side by side.
    Double(Paint),
    /// An unbroken line, and to its right, seen along the lane, one of dashes.
    SolidDashed(Paint),
    /// A line of dashes, and to its right, seen along the lane, an unbroken one.
    DashedSolid(Paint),
    /// The edge of the carriageway.
    Kerb,
    /// Nothing that can be seen.
    Virtual,
    /// Something, but nobody knows what.
    Unknown,
}

/// The colour of paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Paint {
    /// Between lanes and at edges.
    White,
    /// Between directions in many countries.
    Yellow,
}

/// The colour of a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Colour {
    /// White paint.
    White,
    /// Yellow paint.
    Yellow,
    /// A kerb.
    Grey,
    /// What nobody knows: so that it stands out.
    Magenta,
}

/// What runs along a bound from a station on, up to that of the next marking.
#[derive(Clone, Debug, PartialEq)]
pub struct Marking {
    /// Metres along the bound, in the lane's direction of travel.
    pub station: f64,
    /// All that runs there.
    pub kinds: Vec<Kind>,
}

/// How long the dashes of a line are, and from begin to begin, metres.
type Dashes = [f64; 2];

/// One line of paint or stone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke<'a> {
    /// Along which bound: 0 the left one, 1 the right one.
    pub side: usize,
    /// What it is part of.
    pub kind: Kind,
    /// Its colour.
    pub colour: Colour,
    /// Its breadth, metres.
    pub breadth: f64,
    /// Its middle.
    pub line: &'a [Point],
}

/// All strokes of a lane, in order of sides, stations and kinds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    points: Vec<Point>,
    /// Side, kind and end in `points`.
    strokes: Vec<(usize, Kind, usize)>,
}

impl Strokes {
    /// One kind along a whole line: on its left side comes what a kind names first.
    pub fn along(line: &[Point], kind: Kind) -> Self {
        let mut strokes = Self::default();
        strokes.draw(0, line, &[Marking { station: 0.0, kinds: vec![kind] }]);
        strokes
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = Stroke<'_>> {
        let begins = std::iter::once(0).chain(self.strokes.iter().map(|(.., end)| *end));
        self.strokes.iter().zip(begins).map(|(&(side, kind, end), begin)| {
            let (colour, breadth) = look(kind);
            Stroke { side, kind, colour, breadth, line: &self.points[begin..end] }
        })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.strokes.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.strokes.is_empty()
    }

    /// Draws the markings along a bound.
    pub(super) fn draw(&mut self, side: usize, bound: &[Point], markings: &[Marking]) {
        if markings.is_empty() {
            return;
        }
        let track = Track::along(bound);
        let ends = markings.iter().skip(1).map(|next| next.station).chain([f64::INFINITY]);
        for (marking, end) in markings.iter().zip(ends) {
            let piece = [marking.station.max(0.0), end.min(track.length())];
            if piece[1] - piece[0] > Polyline::MERGE {
                marking.kinds.iter().for_each(|&kind| self.piece(side, kind, &track, piece));
            }
        }
    }

    fn piece(&mut self, side: usize, kind: Kind, track: &Track, piece: [f64; 2]) {
        match kind {
            Kind::Virtual => {}
            Kind::Solid(_) | Kind::Kerb | Kind::Unknown => self.line(side, kind, track, piece, None),
            Kind::Dashed(_) => self.line(side, kind, track, piece, Some([DASH, DASH_PERIOD])),
            Kind::Dotted(_) => self.line(side, kind, track, piece, Some([DOT, DOT_PERIOD])),
            Kind::Double(_) => self.parallels(side, kind, track, piece, [None, None]),
            Kind::SolidDashed(_) => self.parallels(side, kind, track, piece, [None, Some([DASH, DASH_PERIOD])]),
            Kind::DashedSolid(_) => self.parallels(side, kind, track, piece, [Some([DASH, DASH_PERIOD]), None]),
        }
    }

    /// Two lines, the left one first, each broken or not.
    fn parallels(&mut self, side: usize, kind: Kind, track: &Track, piece: [f64; 2], broken: [Option<Dashes>; 2]) {
        let mut middle = Vec::new();
        track.part(&mut 0, piece, &mut middle);
        let Some(middle) = Polyline::new(middle) else { return };
        for (apart, dashes) in [DOUBLE_APART, -DOUBLE_APART].into_iter().zip(broken) {
            if let Some(line) = middle.offset(apart, MITER_MOST) {
                let track = Track::along(line.points());
                self.line(side, kind, &track, [0.0, track.length()], dashes);
            }
        }
    }

    fn line(&mut self, side: usize, kind: Kind, track: &Track, piece: [f64; 2], dashes: Option<Dashes>) {
        match dashes {
            Some(dashes) => self.broken(side, kind, track, piece, dashes),
            None => {
                track.part(&mut 0, piece, &mut self.points);
                self.done(side, kind);
            }
        }
    }

    /// Dashes begin where the piece does.
    fn broken(&mut self, side: usize, kind: Kind, track: &Track, [from, to]: [f64; 2], [dash, period]: Dashes) {
        let count = ((to - from) / period).ceil();
        let period = if count > Polyline::MOST_PIECES { (to - from) / Polyline::MOST_PIECES } else { period };
        let mut segment = 0;
        for i in 0..count.min(Polyline::MOST_PIECES) as usize {
            let begin = from + i as f64 * period;
            let part = [begin, (begin + dash).min(to)];
            if part[1] - part[0] > Polyline::MERGE {
                track.part(&mut segment, part, &mut self.points);
                self.done(side, kind);
            }
        }
    }

    fn done(&mut self, side: usize, kind: Kind) {
        self.strokes.push((side, kind, self.points.len()));
    }
}

fn look(kind: Kind) -> (Colour, f64) {
    match kind {
        Kind::Solid(paint)
        | Kind::Dashed(paint)
        | Kind::Dotted(paint)
        | Kind::Double(paint)
        | Kind::SolidDashed(paint)
        | Kind::DashedSolid(paint) => match paint {
            Paint::White => (Colour::White, PAINT),
            Paint::Yellow => (Colour::Yellow, PAINT),
        },
        Kind::Kerb => (Colour::Grey, KERB),
        Kind::Virtual | Kind::Unknown => (Colour::Magenta, PAINT),
    }
}

/// A bound with its stations.
struct Track<'a> {
    points: &'a [Point],
    stations: Vec<f64>,
}

impl<'a> Track<'a> {
    fn along(points: &'a [Point]) -> Self {
        let mut sum = 0.0;
        let lengths = points.windows(2).map(|w| {
            sum += (w[1] - w[0]).norm();
            sum
        });
        Self { points, stations: std::iter::once(0.0).chain(lengths).collect() }
    }

    fn length(&self) -> f64 {
        self.stations[self.stations.len() - 1]
    }

    /// Adds the points of the part between two stations that lie within the bound. `segment` is one that begins before
    /// the part; afterwards that where the part ends.
    fn part(&self, segment: &mut usize, [from, to]: [f64; 2], out: &mut Vec<Point>) {
        out.push(self.at(segment, from));
        let mut next = *segment + 1;
        while next + 1 < self.points.len() && self.stations[next] < to - Polyline::MERGE {
            if self.stations[next] > from + Polyline::MERGE {
                out.push(self.points[next]);
            }
            next += 1;
        }
        *segment = next - 1;
        out.push(self.at(segment, to));
    }

    fn at(&self, segment: &mut usize, station: f64) -> Point {
        while *segment + 2 < self.points.len() && self.stations[*segment + 1] <= station {
            *segment += 1;
        }
        let [from, to] = [*segment, *segment + 1];
        let length = self.stations[to] - self.stations[from];
        // At its points to the last bit, so that paint meets at a joint as the bounds do.
        if station >= self.stations[to] || length <= 0.0 {
            return self.points[to];
        }
        let t = (station - self.stations[from]).max(0.0) / length;
        self.points[from] + (self.points[to] - self.points[from]) * t
    }
}
