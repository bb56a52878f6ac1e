//! What Autoware's planner will do on a lanelet, as a layer of the picture.

use super::canvas::Canvas;
use super::lettering;
use crate::geometry::{Point, Vector};
use crate::lanelet::index::view::boxes_meet;
use crate::lanelet::{LaneletId, LaneletMap};
use crate::planner::{Forecast, Front};
use crate::report::planner::{Hue, Mark, marks};

/// Height of letters in pixels.
const LETTER: f64 = 8.0;
/// How far words are above their line, pixels.
const LIFT: f64 = 9.0;

/// The styles of the layer.
pub const STYLE: &str = "\
.plan-watched{fill:#e5484d;fill-opacity:.42;stroke:#e5484d;stroke-width:1.2}\n\
.plan-before{fill:#e5484d;fill-opacity:.2;stroke:none}\n\
.plan-ignored{fill:#8b9198;fill-opacity:.45;stroke:#8b9198;stroke-width:1.2;stroke-dasharray:5 3}\n\
.plan-own{fill:#2f9e6e;fill-opacity:.4;stroke:#2f9e6e;stroke-width:1.6}\n\
.plan-stuck{fill:#f0a020;fill-opacity:.35;stroke:#f0a020;stroke-width:1}\n\
.plan-line{fill:none;stroke:#12161b;stroke-width:5}\n\
.plan-mark{fill:none;stroke:#ffffff;stroke-width:2.4}\n\
.plan-red{fill:none;stroke:#ff5a5f;stroke-width:2.4}\n\
.plan-amber{fill:none;stroke:#ffc233;stroke-width:2.4}\n";

/// What the hues mean.
pub const MEANINGS: [(&str, &str); 5] = [
    ("plan-own", "the lanelet"),
    ("plan-watched", "watched"),
    ("plan-before", "watched, before them"),
    ("plan-ignored", "ignored"),
    ("plan-stuck", "must be free"),
];

/// Draws whom a vehicle on each lanelet watches and ignores, and where it stops.
pub fn forecasts(canvas: &mut Canvas, map: &LaneletMap, forecasts: &[Forecast]) {
    for forecast in forecasts {
        lanes(canvas, map, forecast);
    }
    for forecast in forecasts {
        lines(canvas, forecast);
    }
}

fn lanes(canvas: &mut Canvas, map: &LaneletMap, forecast: &Forecast) {
    let mut fill = |id: LaneletId, class: &str, what: &str| {
        if let Some(lanelet) = map.lanelets.get(id) {
            canvas.area(class, &map.outline(lanelet), &format!("{id}: {what}"));
        }
    };
    let mut before: Vec<LaneletId> = forecast.watched.iter().flat_map(|one| one.before.iter().copied()).collect();
    before.sort_unstable();
    before.dedup();
    before.retain(|id| forecast.watched.iter().all(|one| one.lanelet != *id));
    before.into_iter().for_each(|id| fill(id, "plan-before", "watched, before one that conflicts"));
    forecast.watched.iter().for_each(|one| fill(one.lanelet, "plan-watched", "watched"));
    forecast.ignored.iter().for_each(|one| fill(one.lanelet, "plan-ignored", "ignored"));
    fill(forecast.lanelet, "plan-own", "the lanelet");
    if let Some(area) = &forecast.lines.stuck {
        canvas.area("plan-stuck", &area.outline, "a vehicle that stands here blocks the way");
    }
}

fn lines(canvas: &mut Canvas, forecast: &Forecast) {
    let marks = marks(forecast);
    for Mark { front, what, hue } in &marks {
        let class = match hue {
            Hue::White => "plan-mark",
            Hue::Red => "plan-red",
            Hue::Amber => "plan-amber",
        };
        let [left, right] = wide(front);
        canvas.line("plan-line", &[left, right], what);
        canvas.line(class, &[left, right], what);
    }
    let mut taken: Vec<[Point; 2]> = Vec::new();
    for Mark { front, what, .. } in &marks {
        let [left, _] = wide(front);
        let half = Vector::new(lettering::width(what, LETTER) / 2.0 + 3.0, LETTER / 2.0 + 2.0);
        let at = canvas.view.pixel(left);
        let boxed = |lift: f64| [at - Vector::new(0.0, lift) - half, at - Vector::new(0.0, lift) + half];
        let lifts = (0..=marks.len()).map(|i| LIFT + i as f64 * (LETTER + 5.0));
        let free = |lift: &f64| taken.iter().all(|&other| !boxes_meet(other, boxed(*lift)));
        let lift = lifts.clone().find(free).unwrap_or(LIFT);
        taken.push(boxed(lift));
        canvas.words("found", left, lift, what, LETTER);
    }
}

/// The bumper, made longer on both sides so that it can be told from paint.
fn wide(front: &Front) -> [Point; 2] {
    let [left, right] = front.ends;
    let more = (right - left) * 0.35;
    [left - more, right + more]
}
