//! Draws the markings along a bound as solid lines, dashes and double lines.

use crate::geometry::{Point, Polyline};

/// The length of a dash on a city street, metres, ...
pub const DASH: f64 = 3.0;
/// ... and the distance between the starts of two dashes, metres.
pub const DASH_PERIOD: f64 = 9.0;
/// The length of a dot, metres, ...
const DOT: f64 = 0.5;
/// ... and the distance between the starts of two dots, metres.
const DOT_PERIOD: f64 = 1.0;
/// The distance of each line of a double line from the bound, metres.
pub const DOUBLE_APART: f64 = 0.18;
/// The width of a painted line, metres.
pub const PAINT: f64 = 0.12;
/// The width of a kerb, metres.
pub const KERB: f64 = 0.3;
/// The longest miter of a double line as a multiple of its offset.
const MITER_LIMIT: f64 = 3.0;

/// A kind of marking along a bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Kind {
    /// One solid line.
    Solid(Paint),
    /// One dashed line.
    Dashed(Paint),
    /// One line of dots (short blocks), as long as the gaps between them.
    Dotted(Paint),
    /// Two solid lines side by side.
    Double(Paint),
    /// A solid line, and a dashed line to its right, seen along the lane.
    SolidDashed(Paint),
    /// A dashed line, and a solid line to its right, seen along the lane.
    DashedSolid(Paint),
    /// The edge of the carriageway.
    Kerb,
    /// No marking.
    Virtual,
    /// A marking of unknown kind.
    Unknown,
}

/// The colour of paint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Paint {
    /// Between lanes and at edges.
    White,
    /// Between opposite directions in many countries.
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
    /// A marking of unknown kind, to attract attention.
    Magenta,
}

/// The marking of a bound from a station to the next marking.
#[derive(Clone, Debug, PartialEq)]
pub struct Marking {
    /// The station on the bound in the direction of travel, metres.
    pub station: f64,
    /// The kinds drawn there.
    pub kinds: Vec<Kind>,
}

/// The length of dashes, and the distance between their starts, metres.
type Dashes = [f64; 2];

/// One drawn line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke<'a> {
    /// The bound: 0 left, 1 right.
    pub side: usize,
    /// The kind of which it is a part.
    pub kind: Kind,
    /// Its colour.
    pub colour: Colour,
    /// Its width, metres.
    pub breadth: f64,
    /// Its middle line.
    pub line: &'a [Point],
}

/// All strokes of a lane, sorted by side, station and kind.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Strokes {
    points: Vec<Point>,
    /// Side, kind, and end in `points`.
    strokes: Vec<(usize, Kind, usize)>,
}

impl Strokes {
    /// The strokes of one kind along a line.
    pub fn along(line: &[Point], kind: Kind) -> Self {
        let mut strokes = Self::default();
        strokes.draw(0, line, &[Marking { station: 0.0, kinds: vec![kind] }]);
        strokes
    }

    /// All strokes.
    pub fn iter(&self) -> impl Iterator<Item = Stroke<'_>> {
        let starts = std::iter::once(0).chain(self.strokes.iter().map(|(.., end)| *end));
        self.strokes.iter().zip(starts).map(|(&(side, kind, end), start)| {
            let (colour, breadth) = appearance(kind);
            Stroke { side, kind, colour, breadth, line: &self.points[start..end] }
        })
    }

    /// The number of strokes.
    pub fn len(&self) -> usize {
        self.strokes.len()
    }

    /// Whether there are no strokes.
    pub fn is_empty(&self) -> bool {
        self.strokes.is_empty()
    }

    /// Draws the markings along a bound.
    pub(super) fn draw(&mut self, side: usize, bound: &[Point], markings: &[Marking]) {
        if markings.is_empty() {
            return;
        }
        let bound = MeasuredBound::new(bound);
        let ends = markings.iter().skip(1).map(|next| next.station).chain([f64::INFINITY]);
        for (marking, end) in markings.iter().zip(ends) {
            let range = [marking.station.max(0.0), end.min(bound.length())];
            if range[1] - range[0] > Polyline::MERGE {
                marking.kinds.iter().for_each(|&kind| self.draw_kind(side, kind, &bound, range));
            }
        }
    }

    fn draw_kind(&mut self, side: usize, kind: Kind, bound: &MeasuredBound, range: [f64; 2]) {
        const DASHES: Option<Dashes> = Some([DASH, DASH_PERIOD]);
        match kind {
            Kind::Virtual => {}
            Kind::Solid(_) | Kind::Kerb | Kind::Unknown => self.draw_line(side, kind, bound, range, None),
            Kind::Dashed(_) => self.draw_line(side, kind, bound, range, DASHES),
            Kind::Dotted(_) => self.draw_line(side, kind, bound, range, Some([DOT, DOT_PERIOD])),
            Kind::Double(_) => self.draw_double(side, kind, bound, range, [None, None]),
            Kind::SolidDashed(_) => self.draw_double(side, kind, bound, range, [None, DASHES]),
            Kind::DashedSolid(_) => self.draw_double(side, kind, bound, range, [DASHES, None]),
        }
    }

    /// Draws two lines, the left one first.
    fn draw_double(
        &mut self,
        side: usize,
        kind: Kind,
        bound: &MeasuredBound,
        range: [f64; 2],
        dashes: [Option<Dashes>; 2],
    ) {
        let mut middle = Vec::new();
        bound.part(&mut 0, range, &mut middle);
        let Some(middle) = Polyline::new(middle) else { return };
        for (offset, dashes) in [DOUBLE_APART, -DOUBLE_APART].into_iter().zip(dashes) {
            if let Some(line) = middle.offset(offset, MITER_LIMIT) {
                let line = MeasuredBound::new(line.points());
                self.draw_line(side, kind, &line, [0.0, line.length()], dashes);
            }
        }
    }

    /// Draws a solid line, or dashes of which the first begins at the start of the range.
    fn draw_line(&mut self, side: usize, kind: Kind, bound: &MeasuredBound, range: [f64; 2], dashes: Option<Dashes>) {
        let ([from, to], Some([dash, period])) = (range, dashes) else {
            bound.part(&mut 0, range, &mut self.points);
            self.strokes.push((side, kind, self.points.len()));
            return;
        };
        let count = ((to - from) / period).ceil();
        let period = if count > Polyline::MOST_PIECES { (to - from) / Polyline::MOST_PIECES } else { period };
        let mut segment = 0;
        for i in 0..count.min(Polyline::MOST_PIECES) as usize {
            let start = from + i as f64 * period;
            let range = [start, (start + dash).min(to)];
            if range[1] - range[0] > Polyline::MERGE {
                bound.part(&mut segment, range, &mut self.points);
                self.strokes.push((side, kind, self.points.len()));
            }
        }
    }
}

/// The colour and the width, metres, of a kind.
fn appearance(kind: Kind) -> (Colour, f64) {
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

/// A bound with the stations of its points.
struct MeasuredBound<'a> {
    points: &'a [Point],
    stations: Vec<f64>,
}

impl<'a> MeasuredBound<'a> {
    fn new(points: &'a [Point]) -> Self {
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

    /// Appends the part between two stations to `out`. `segment` begins before the part and becomes the one at its end.
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
        // Vertices are exact, so that paint meets at a joint as the bounds do.
        if station >= self.stations[to] || length <= 0.0 {
            return self.points[to];
        }
        let t = (station - self.stations[from]).max(0.0) / length;
        self.points[from] + (self.points[to] - self.points[from]) * t
    }
}
