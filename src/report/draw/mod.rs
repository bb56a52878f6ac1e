//! A map as a picture: SVG to zoom and point at, PNG to look at and send; and its lines as GeoJSON.

mod canvas;
mod findings;
mod ids;
mod labels;
mod lanes;
mod legend;
mod lettering;
mod planner;
mod signals;
pub mod sketch;
mod strokes;
mod style;

#[cfg(feature = "draw")]
use resvg::{tiny_skia, usvg};

pub use canvas::{Canvas, View, bounding_box};
pub use strokes::geojson;

use crate::diagnostic::Diagnostic;
use crate::geometry::Point;
use crate::lanelet::{AreaId, LaneletId, LaneletMap, LineStringId, PointId, PolygonId, RegulatoryElementId, Target};
use crate::planner::Forecast;
use crate::report::levels::Levels;

use labels::Labels;

/// Length of a picture's longer side in pixels, where no scale is asked for.
const COMFORTABLE_SIDE: f64 = 1800.0;
/// Without being asked, one metre does not become more pixels than this.
const LARGEST_SCALE: f64 = 24.0;
/// White around what is drawn, metres.
const MARGIN: f64 = 6.0;
/// What is drawn around a single primitive, metres.
const SURROUNDINGS: f64 = 20.0;
/// Most pixels of a PNG. Four bytes each while it is drawn: 200 MB.
pub const MAX_PIXELS: f64 = 50e6;

/// Which part of a map to draw.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Focus {
    /// All of it.
    #[default]
    Whole,
    /// A square around a place in local metres, this many metres to each side.
    Around(Point, f64),
    /// A primitive of whatever kind, with what lies around it.
    Primitive(i64),
}

/// What to draw and how.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// The part.
    pub focus: Focus,
    /// Pixels per metre; `None`: whatever gives a picture that fits a screen.
    pub scale: Option<f64>,
    /// Whether to write ids: white-haloed, lanelets blue, areas gold, regulatory elements red.
    pub ids: bool,
    /// What stands in the title.
    pub title: String,
    /// What Autoware's planner will do, to be drawn on top.
    pub forecasts: Vec<Forecast>,
    /// Lines and closed rings in local metres that are pointed at, drawn dashed on top.
    pub marked: Vec<(bool, Vec<Point>)>,
    /// Whether the legend is left out: of a small picture it would hide a part.
    pub without_legend: bool,
}

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
pub enum DrawError {
    /// No point in the map has a usable place.
    #[error("the map has no point that could be drawn")]
    Empty,
    /// There is nothing of this id.
    #[error("the map has nothing with the id {0}")]
    NoSuchId(i64),
    /// Scale or radius is zero, negative or not a number.
    #[error("{what} must be a positive number, not {value}")]
    NotPositive {
        /// `the scale` or `the radius`.
        what: &'static str,
        /// As given.
        value: f64,
    },
    /// Too large for the memory of ordinary machines.
    #[error("the picture would be {width} x {height} pixels; a PNG may have {} million", MAX_PIXELS / 1e6)]
    TooLarge {
        /// Pixels.
        width: f64,
        /// Pixels.
        height: f64,
    },
    /// The renderer refused; says why.
    #[error("the picture could not be rendered: {0}")]
    Render(String),
}

impl DrawError {
    /// A way out, in one line.
    pub fn help(&self) -> &'static str {
        match self {
            Self::Empty => "is this a Lanelet2 map with lat/lon or local_x/local_y on its nodes?",
            Self::NoSuchId(_) => "give the id of a lanelet, regulatory element, way or node of the map",
            Self::NotPositive { .. } => "leave it out for a picture that fits a screen",
            Self::TooLarge { .. } => {
                "use a smaller --scale, draw a part (--at LAT,LON --radius M, or --around ID), or write .svg"
            }
            Self::Render(_) => "try .svg, which any browser shows",
        }
    }
}

/// Draws the map, with the findings on it, as an SVG document.
///
/// # Errors
///
/// If the map has nothing to draw, not the primitive that the options name, or the scale is not positive.
pub fn svg(map: &LaneletMap, diagnostics: &[Diagnostic], options: &Options) -> Result<String, DrawError> {
    Ok(svg_of(map, diagnostics, view(map, options)?, options))
}

/// The same for a part of the plane that is known already.
pub fn svg_of(map: &LaneletMap, diagnostics: &[Diagnostic], view: View, options: &Options) -> String {
    let mut canvas = Canvas::new(view);
    let levels = Levels::within(map, [view.min, view.max]);
    for (at, level) in levels.split(map).iter().enumerate() {
        // The names of the lowest level stand alone.
        let of_level = |name: &str| if at == 0 { name.to_owned() } else { format!("{name}-above-{at}") };
        layer(&mut canvas, &of_level("areas"), |c| {
            lanes::areas(c, level);
            lanes::polygons(c, level, false);
        });
        layer(&mut canvas, &of_level("lanes"), |c| lanes::surfaces(c, level));
        layer(&mut canvas, &of_level("intersections"), |c| {
            lanes::polygons(c, level, true);
            lanes::islands(c, level);
        });
        layer(&mut canvas, &of_level("turns"), |c| lanes::turns(c, level));
        layer(&mut canvas, &of_level("crosswalks"), |c| lanes::crosswalks(c, level));
        layer(&mut canvas, &of_level("markings"), |c| lanes::markings(c, level));
        layer(&mut canvas, &of_level("arrows"), |c| lanes::arrows(c, level));
        layer(&mut canvas, &of_level("signals"), |c| signals::signals(c, level));
    }
    let mut labels = Labels::default();
    layer(&mut canvas, "findings", |c| findings::findings(c, map, diagnostics, &mut labels));
    if !options.forecasts.is_empty() {
        layer(&mut canvas, "planner", |c| planner::forecasts(c, map, &options.forecasts));
    }
    if !options.marked.is_empty() {
        layer(&mut canvas, "marked", |c| marked(c, &options.marked));
    }
    if options.ids {
        layer(&mut canvas, "ids", |c| ids::ids(c, map, &levels, &mut labels));
    }
    let more: &[_] = if options.forecasts.is_empty() { &[] } else { &planner::MEANINGS };
    if !options.without_legend {
        layer(&mut canvas, "legend", |c| legend::legend(c, map, diagnostics, more));
    }
    let mut style = style::sheet(canvas.view.scale);
    if canvas.shows(style::YELLOW) {
        style += style::YELLOW_PAINT;
    }
    if canvas.shows(style::PASSAGE) {
        style += style::PASSAGE_GROUND;
    }
    if !options.forecasts.is_empty() {
        style += planner::STYLE;
    }
    if !options.marked.is_empty() {
        style += style::MARKED;
    }
    canvas.finish(&style, &options.title)
}

/// The same as PNG bytes.
///
/// # Errors
///
/// As [`svg`] and [`rendered`].
#[cfg(feature = "draw")]
pub fn png(map: &LaneletMap, diagnostics: &[Diagnostic], options: &Options) -> Result<Vec<u8>, DrawError> {
    let view = view(map, options)?;
    let (width, height) = (view.width(), view.height());
    if width * height > MAX_PIXELS {
        return Err(DrawError::TooLarge { width, height });
    }
    rendered(&svg(map, diagnostics, options)?)
}

/// An SVG document as PNG bytes.
///
/// # Errors
///
/// If the picture has more than [`MAX_PIXELS`], or is no SVG.
#[cfg(feature = "draw")]
pub fn rendered(svg: &str) -> Result<Vec<u8>, DrawError> {
    let failed = |error: &dyn std::fmt::Display| DrawError::Render(error.to_string());
    let tree = usvg::Tree::from_str(svg, &usvg::Options::default()).map_err(|e| failed(&e))?;
    let (width, height) = (f64::from(tree.size().width()), f64::from(tree.size().height()));
    if width * height > MAX_PIXELS {
        return Err(DrawError::TooLarge { width, height });
    }
    let mut pixels = tiny_skia::Pixmap::new(width as u32, height as u32)
        .ok_or_else(|| failed(&format!("{width} x {height} pixels do not fit")))?;
    resvg::render(&tree, tiny_skia::Transform::identity(), &mut pixels.as_mut());
    pixels.encode_png().map_err(|e| failed(&e))
}

/// Dashed outlines of what is pointed at.
fn marked(canvas: &mut Canvas, shapes: &[(bool, Vec<Point>)]) {
    for (closed, points) in shapes {
        let ring = points.first().filter(|_| *closed);
        let line: Vec<Point> = points.iter().chain(ring).copied().collect();
        canvas.line("marked-halo", &line, "");
        canvas.line("marked", &line, "");
    }
}

fn layer(canvas: &mut Canvas, name: &str, draw: impl FnOnce(&mut Canvas)) {
    canvas.open(name);
    draw(canvas);
    canvas.close();
}

/// The part of the plane that the options ask for.
///
/// # Errors
///
/// If the map has nothing to draw, not the primitive that the options name, or the scale is not positive.
pub fn view(map: &LaneletMap, options: &Options) -> Result<View, DrawError> {
    let (min, max) = match options.focus {
        Focus::Whole => widen(whole(map).ok_or(DrawError::Empty)?, MARGIN),
        Focus::Around(place, radius) => widen((place, place), positive("the radius", radius)?),
        Focus::Primitive(id) => {
            let points = points_of(map, id);
            widen(bounding_box(&points).ok_or(DrawError::NoSuchId(id))?, SURROUNDINGS)
        }
    };
    scaled(min, max, options.scale)
}

/// A box at the scale that is asked for, or at one that fits a screen.
fn scaled(min: Point, max: Point, scale: Option<f64>) -> Result<View, DrawError> {
    let side = (max.x - min.x).max(max.y - min.y);
    let scale = match scale {
        Some(scale) => positive("the scale", scale)?,
        None => (COMFORTABLE_SIDE / side).min(LARGEST_SCALE),
    };
    Ok(View { min, max, scale })
}

fn positive(what: &'static str, value: f64) -> Result<f64, DrawError> {
    if value.is_finite() && value > 0.0 { Ok(value) } else { Err(DrawError::NotPositive { what, value }) }
}

fn widen((min, max): (Point, Point), by: f64) -> (Point, Point) {
    let by = nalgebra::Vector2::new(by, by);
    (min - by, max + by)
}

/// The box around everything that a linestring or polygon uses.
fn whole(map: &LaneletMap) -> Option<(Point, Point)> {
    let lines = map.linestrings.iter().flat_map(|l| &l.points);
    let polygons = map.polygons.iter().flat_map(|p| &p.points);
    bounding_box(lines.chain(polygons).filter_map(|&id| map.points.get(id)).map(|p| &p.position))
}

/// The points of everything that has this id.
fn points_of(map: &LaneletMap, id: i64) -> Vec<Point> {
    let mut points: Vec<Point> = map.points.get(PointId(id)).map(|p| p.position).into_iter().collect();
    let line = |id| map.linestrings.get(id).map(|l| lanes::positions(map, &l.points)).unwrap_or_default();
    let polygon = |id| map.polygons.get(id).map(|p| lanes::positions(map, &p.points)).unwrap_or_default();
    let lanelet = |id| map.lanelets.get(id).map(|l| map.outline(l)).unwrap_or_default();
    points.extend(line(LineStringId(id)));
    points.extend(polygon(PolygonId(id)));
    points.extend(lanelet(LaneletId(id)));
    points.extend(map.areas.get(AreaId(id)).map(|area| lanes::positions(map, &area.points)).unwrap_or_default());
    for member in map.regulatory_elements.get(RegulatoryElementId(id)).into_iter().flat_map(|r| &r.members) {
        points.extend(match member.target {
            Target::Point(id) => map.points.get(id).map(|p| p.position).into_iter().collect(),
            Target::LineString(id) => line(id),
            Target::Polygon(id) => polygon(id),
            Target::Lanelet(id) => lanelet(id),
        });
    }
    points
}

#[cfg(test)]
mod tests;
