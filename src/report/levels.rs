//! What lies beneath what: pictures show a tunnel first, then the street above it.

use rayon::prelude::*;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use rustc_hash::{FxHashMap, FxHashSet};

use crate::geometry::{Point, polygon};
use crate::lanelet::index::UnionFind;
use crate::lanelet::index::thresholds::GRADE_SEPARATION;
use crate::lanelet::{Area, Lanelet, LaneletMap, LineString, LineStringId, PointId, Polygon, Target};
use crate::parallel::InSmallParts;

/// Surfaces whose common part is smaller than this (m2) only touch.
const LEAST_COMMON: f64 = 0.5;
/// Levels are raised in as many rounds; sorted by height, all but surfaces that wind around each other need one.
const ROUNDS: usize = 4;
/// More levels than these are shown as the highest of them. The largest interchanges have five.
const MOST_LEVELS: usize = 12;

/// The level of each primitive of a map, by its position in its layer: 0 for what lies above nothing else.
pub struct Levels {
    /// Of the lanelets.
    pub lanelets: Vec<usize>,
    /// Of the linestrings.
    pub lines: Vec<usize>,
    /// Of the polygons.
    pub polygons: Vec<usize>,
    /// Of the areas.
    pub areas: Vec<usize>,
    surfaces: Surfaces,
}

/// What lies on one level of a map, each kind in the map's order.
pub struct Level<'m> {
    /// The whole map.
    pub map: &'m LaneletMap,
    /// Its lanelets on this level.
    pub lanelets: Vec<&'m Lanelet>,
    /// Its linestrings on this level.
    pub lines: Vec<&'m LineString>,
    /// Its polygons on this level.
    pub polygons: Vec<&'m Polygon>,
    /// Its areas on this level.
    pub areas: Vec<&'m Area>,
}

impl Levels {
    /// Compares the heights of all surfaces of the map where they overlap. A map without heights, or a flat one, has one level.
    pub fn of(map: &LaneletMap) -> Self {
        Self::within(map, [Point::new(f64::MIN, f64::MIN), Point::new(f64::MAX, f64::MAX)])
    }

    /// The same of a part of the map, between two corners: what lies outside is on level 0.
    pub fn within(map: &LaneletMap, part: [Point; 2]) -> Self {
        let surfaces = Surfaces::within(map, part);
        let of_each = surfaces.levels();
        let (lanelets, rest) = of_each.split_at(map.lanelets.len());
        let (polygons, areas) = rest.split_at(map.polygons.len());
        let mut levels = Self {
            lanelets: lanelets.to_vec(),
            lines: vec![0; map.linestrings.len()],
            polygons: polygons.to_vec(),
            areas: areas.to_vec(),
            surfaces,
        };
        if levels.count() > 1 {
            levels.raise_lines(map, &of_each);
        }
        levels
    }

    /// How many there are, at least one.
    pub fn count(&self) -> usize {
        let all = [&self.lanelets, &self.polygons, &self.areas];
        1 + all.into_iter().flatten().copied().max().unwrap_or(0)
    }

    /// The map's primitives by level, the lowest first.
    pub fn split<'m>(&self, map: &'m LaneletMap) -> Vec<Level<'m>> {
        fn on<'m, T>(items: &'m [T], levels: &[usize], level: usize) -> Vec<&'m T> {
            items.iter().zip(levels).filter(|(_, of)| **of == level).map(|(item, _)| item).collect()
        }
        let level = |level| Level {
            map,
            lanelets: on(map.lanelets.as_slice(), &self.lanelets, level),
            lines: on(map.linestrings.as_slice(), &self.lines, level),
            polygons: on(map.polygons.as_slice(), &self.polygons, level),
            areas: on(map.areas.as_slice(), &self.areas, level),
        };
        (0..self.count()).map(level).collect()
    }

    /// Whether something that lies higher covers a place of this level.
    pub fn is_covered(&self, place: Point, level: usize) -> bool {
        let of_each = || self.lanelets.iter().chain(&self.polygons).chain(&self.areas);
        self.surfaces.around(place).any(|(at, _)| of_each().nth(at).is_some_and(|of| *of > level))
    }

    /// Lines lie where the highest surface lies that they bound, or whose lanelet refers to them; others on that whose height at
    /// their middle is nearest to their own.
    fn raise_lines(&mut self, map: &LaneletMap, of_each: &[usize]) {
        let mut highest: FxHashMap<LineStringId, usize> = FxHashMap::default();
        let mut raise = |line: LineStringId, level: usize| {
            let raised = highest.entry(line).or_default();
            *raised = level.max(*raised);
        };
        for (lanelet, &level) in map.lanelets.iter().zip(&self.lanelets) {
            let lines = [Some(lanelet.left.line), Some(lanelet.right.line), lanelet.centerline];
            lines.into_iter().flatten().for_each(|line| raise(line, level));
            let elements = lanelet.regulatory_elements.iter().filter_map(|id| map.regulatory_elements.get(*id));
            for member in elements.flat_map(|element| &element.members) {
                if let Target::LineString(line) = member.target {
                    raise(line, level);
                }
            }
        }
        for (area, &level) in map.areas.iter().zip(&self.areas) {
            area.outer.iter().for_each(|bound| raise(bound.line, level));
        }
        for (line, level) in map.linestrings.iter().zip(&mut self.lines) {
            let by_place = || {
                let middle = map.points.get(*line.points.get(line.points.len() / 2)?)?;
                let own = middle.ele()?;
                let around = self.surfaces.around(middle.position);
                let apart = |surface: &Surface| (surface.height(middle.position) - own).abs();
                let nearest = around.min_by(|(_, a), (_, b)| apart(a).total_cmp(&apart(b)));
                nearest.and_then(|(at, _)| of_each.get(at).copied())
            };
            *level = highest.get(&line.id).copied().or_else(by_place).unwrap_or(0);
        }
    }
}

/// The ring around a lanelet, polygon or area, with the heights of its corners.
struct Surface {
    ring: Vec<(Point, f64)>,
    extent: [Point; 2],
    /// Lowest and highest corner, metres.
    heights: [f64; 2],
}

impl Surface {
    /// `None` without three corners, or where a place or a height is missing.
    fn of(map: &LaneletMap, ids: impl Iterator<Item = PointId>) -> Option<Self> {
        let corner = |id| {
            let point = map.points.get(id)?;
            let height = point.ele().filter(|height| height.is_finite())?;
            let finite = point.position.x.is_finite() && point.position.y.is_finite();
            finite.then_some((point.position, height))
        };
        let ring: Vec<(Point, f64)> = ids.map(corner).collect::<Option<_>>()?;
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        let heights = ring.iter().fold(range, |[low, high], (_, height)| [low.min(*height), high.max(*height)]);
        let extent = polygon::bounds(&ring.iter().map(|(place, _)| *place).collect::<Vec<_>>())?;
        (ring.len() > 2).then_some(Self { ring, extent, heights })
    }

    fn outline(&self) -> Vec<Point> {
        self.ring.iter().map(|(place, _)| *place).collect()
    }

    /// Height of the nearest place of its outline, metres.
    fn height(&self, place: Point) -> f64 {
        let edges = self.ring.iter().zip(self.ring.iter().cycle().skip(1));
        let nearest = edges.map(|(&(from, low), &(to, high))| {
            let along = to - from;
            let share = ((place - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
            // An edge without length has no share.
            let share = if share.is_finite() { share } else { 0.0 };
            ((place - (from + along * share)).norm_squared(), low + (high - low) * share)
        });
        nearest.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(0.0, |(_, height)| height)
    }
}

/// The surfaces of a map: those of lanelets, then of polygons, then of areas. None of a flat map.
struct Surfaces {
    all: Vec<Option<Surface>>,
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// Of surfaces and others alike.
    count: usize,
}

impl Surfaces {
    fn within(map: &LaneletMap, [south_west, north_east]: [Point; 2]) -> Self {
        let count = map.lanelets.len() + map.polygons.len() + map.areas.len();
        let heights = map.points.iter().filter_map(|point| point.ele()).filter(|height| height.is_finite());
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        let [low, high] = heights.fold(range, |[low, high], height| [low.min(height), high.max(height)]);
        if high - low <= GRADE_SEPARATION || low > high {
            return Self { all: Vec::new(), tree: RTree::new(), count };
        }
        let lanelet = |lanelet: &Lanelet| {
            let [left, right] =
                [lanelet.left, lanelet.right].map(|bound| map.bound_points(bound).map(|point| point.id));
            Surface::of(map, left.chain(right.rev()))
        };
        let lanelets = map.lanelets.as_slice().par_iter().in_small_parts().map(lanelet);
        let mut all: Vec<Option<Surface>> = lanelets.collect();
        all.extend(map.polygons.iter().map(|polygon| Surface::of(map, polygon.points.iter().copied())));
        all.extend(map.areas.iter().map(|area| Surface::of(map, area.points.iter().copied())));
        let is_seen = |&[low, high]: &[Point; 2]| {
            low.x <= north_east.x && low.y <= north_east.y && high.x >= south_west.x && high.y >= south_west.y
        };
        for surface in &mut all {
            *surface = surface.take().filter(|surface| is_seen(&surface.extent));
        }
        let boxed = all.iter().enumerate().filter_map(|(at, surface)| {
            let [low, high] = surface.as_ref()?.extent;
            Some(GeomWithData::new(Rectangle::from_corners([low.x, low.y], [high.x, high.y]), at))
        });
        let tree = RTree::bulk_load(boxed.collect());
        Self { all, tree, count }
    }

    fn get(&self, at: usize) -> Option<&Surface> {
        self.all.get(at)?.as_ref()
    }

    /// Those whose boxes meet one, in order.
    fn near(&self, [low, high]: [Point; 2]) -> Vec<usize> {
        let extent = AABB::from_corners([low.x, low.y], [high.x, high.y]);
        let mut near: Vec<usize> = self.tree.locate_in_envelope_intersecting(&extent).map(|found| found.data).collect();
        near.sort_unstable();
        near
    }

    /// Those that a place lies in.
    fn around(&self, place: Point) -> impl Iterator<Item = (usize, &Surface)> {
        let near = self.near([place, place]).into_iter().filter_map(|at| Some((at, self.get(at)?)));
        near.filter(move |(_, surface)| polygon::contains(&surface.outline(), place))
    }

    /// How much higher the second is than the first where they overlap, metres; `None` where they do not.
    fn rise(&self, low: usize, high: usize) -> Option<f64> {
        let (low, high) = (self.get(low)?, self.get(high)?);
        let (area, place) = polygon::common_part(&low.outline(), &high.outline())?;
        (area > LEAST_COMMON).then(|| high.height(place) - low.height(place))
    }

    /// Pairs of a surface and one that passes over it.
    fn passing(&self) -> Vec<[usize; 2]> {
        let over = |(x, surface): (usize, &Option<Surface>)| -> Vec<[usize; 2]> {
            let Some(surface) = surface else { return Vec::new() };
            let pair = |y: usize| {
                let other = self.get(y).filter(|_| y > x)?.heights;
                let most = (other[1] - surface.heights[0]).max(surface.heights[1] - other[0]);
                let rise = (most > GRADE_SEPARATION).then(|| self.rise(x, y))??;
                let ordered = if rise > 0.0 { [x, y] } else { [y, x] };
                (rise.abs() > GRADE_SEPARATION).then_some(ordered)
            };
            self.near(surface.extent).into_iter().filter_map(pair).collect()
        };
        self.all.par_iter().in_small_parts().enumerate().flat_map_iter(over).collect()
    }

    /// The level of each. What overlaps on one height is drawn together: the lanelets of an intersection with its area.
    fn levels(&self) -> Vec<usize> {
        let mut levels = vec![0; self.count];
        let passing = self.passing();
        if passing.is_empty() {
            return levels;
        }
        let mut together = self.together(&passing);
        let mut sets: Vec<usize> = (0..self.count).map(|at| together.root(at)).collect();
        // A set that passes over itself, as a winding ramp does together with its ends, cannot be drawn in one go.
        let torn: FxHashSet<usize> =
            passing.iter().filter(|[low, high]| sets[*low] == sets[*high]).map(|[low, _]| sets[*low]).collect();
        sets.iter_mut().enumerate().filter(|(_, set)| torn.contains(set)).for_each(|(at, set)| *set = at);
        let mut steps: Vec<[usize; 2]> = passing.iter().map(|[low, high]| [sets[*low], sets[*high]]).collect();
        let height = |at: usize| self.get(at).map_or(0.0, |surface| surface.heights[0] + surface.heights[1]);
        steps.sort_by(|a, b| height(a[1]).total_cmp(&height(b[1])).then(a.cmp(b)));
        steps.dedup();
        for _ in 0..ROUNDS {
            for &[low, high] in &steps {
                levels[high] = levels[high].max(levels[low] + 1).min(MOST_LEVELS - 1);
            }
        }
        sets.iter().map(|&set| levels[set]).collect()
    }

    /// Which surfaces overlap on one height, of all that hang together with those that pass over each other.
    fn together(&self, passing: &[[usize; 2]]) -> UnionFind {
        let mut together = UnionFind::new(self.count);
        let mut seen: FxHashSet<usize> = passing.iter().flatten().copied().collect();
        let mut waiting: Vec<usize> = seen.iter().copied().collect();
        while let Some(x) = waiting.pop() {
            let Some(surface) = self.get(x) else { continue };
            for y in self.near(surface.extent).into_iter().filter(|&y| y != x) {
                if self.rise(x, y).is_some_and(|rise| rise.abs() <= GRADE_SEPARATION) {
                    together.join(x, y);
                    if seen.insert(y) {
                        waiting.push(y);
                    }
                }
            }
        }
        together
    }
}

#[cfg(test)]
mod tests;
