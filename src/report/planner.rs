//! What Autoware's planner will do, in words and as JSON.

use std::fmt::Write;

use serde::Serialize;
use serde_json::{Value, json};

use super::{TOOL, Unproject, VERSION};
use crate::geometry::Point;
use crate::planner::{Forecast, Front, Outcome, Params, Priority, ReachesIn, Reason, StopSource, Watched};

/// The forecasts as JSON. Places are local metres, with longitude and latitude beside them where the map has a projection.
///
/// # Errors
///
/// If a number cannot be written, which no map causes.
pub fn json(forecasts: &[Forecast], params: &Params, unproject: Unproject<'_>) -> Result<Value, serde_json::Error> {
    let mut lanelets = serde_json::to_value(forecasts)?;
    for (at, forecast) in forecasts.iter().enumerate() {
        lanelets[at]["marks"] = serde_json::to_value(marks(forecast))?;
    }
    place(&mut lanelets, unproject);
    let parameters: serde_json::Map<String, Value> =
        params.table().into_iter().map(|(name, value)| (name.to_owned(), number(&value))).collect();
    let mut all = json!({ "tool": TOOL, "version": VERSION, "parameters": parameters, "lanelets": lanelets });
    for (at, forecast) in forecasts.iter().enumerate() {
        all["lanelets"][at]["sentence"] = sentence(forecast).into();
        all["lanelets"][at]["places"] = json!(places(forecast));
    }
    Ok(all)
}

fn number(text: &str) -> Value {
    text.parse::<f64>().map_or_else(|_| Value::Bool(text == "true"), Value::from)
}

/// Adds longitude and latitude to what has points.
fn place(value: &mut Value, unproject: Unproject<'_>) {
    match value {
        Value::Array(list) => list.iter_mut().for_each(|one| place(one, unproject)),
        Value::Object(entries) => {
            for (from, to) in [("ends", "ends_lonlat"), ("outline", "outline_lonlat")] {
                let points = entries.get(from).and_then(points);
                let degrees = points.filter(|points| !points.is_empty()).and_then(|points| unproject(&points));
                if let Some(degrees) = degrees {
                    let list: Vec<[f64; 2]> = degrees.iter().map(|p| [p.lon, p.lat]).collect();
                    entries.insert(to.to_owned(), json!(list));
                }
            }
            entries.values_mut().for_each(|one| place(one, unproject));
        }
        _ => {}
    }
}

/// A list of pairs of fractions; ids of lanelets are whole numbers.
fn points(value: &Value) -> Option<Vec<Point>> {
    let pair = |one: &Value| match one.as_array()?.as_slice() {
        [x, y] if x.is_f64() => Some(Point::new(x.as_f64()?, y.as_f64()?)),
        _ => None,
    };
    value.as_array()?.iter().map(pair).collect()
}

/// What the planner will do on one lanelet, in a sentence.
pub fn sentence(forecast: &Forecast) -> String {
    let mut parts: Vec<String> = vec![main_clause(forecast)];
    for (element, count) in ignored_by(forecast) {
        let lanes = lanes(count);
        parts.push(match element {
            Reason::RightOfWay(id) => format!("ignores {lanes} because element {id} says so"),
            Reason::BeforeYield(id) => format!("ignores {lanes} before those that element {id} names"),
            Reason::StraightWithLight(id) => format!("ignores {lanes} because it goes straight on at light {id}"),
        });
    }
    if forecast.private.is_some() {
        parts.push("stops first, because it comes from private ground".to_owned());
    }
    for one in &forecast.crosswalks {
        let StopAtWords(stop) = StopAtWords::of(one.stop.before);
        parts.push(format!("stops {stop} crosswalk {}", one.crosswalk));
    }
    parts.extend(forecast.signs.iter().map(|sign| format!("stops at the stop sign {}", sign.element)));
    if let Some(blinker) = &forecast.blinker {
        parts.push(format!("blinks {} from {:.0} m", blinker.side, blinker.before));
    }
    let text = parts.join(", ");
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| format!("{}{}.", first.to_uppercase(), letters.as_str()))
}

/// `1.2 m before`, `0.3 m behind the edge of`.
struct StopAtWords(String);

impl StopAtWords {
    fn of(before: f64) -> Self {
        Self(match before {
            before if before >= 0.0 => format!("{before:.1} m before"),
            _ => format!("{:.1} m behind the edge of", -before),
        })
    }
}

fn lanes(count: usize) -> String {
    format!("{count} lane{}", if count == 1 { "" } else { "s" })
}

fn main_clause(forecast: &Forecast) -> String {
    let watched = lanes(forecast.watched.len());
    match forecast.outcome {
        Outcome::NotInIntersection => "is in no intersection: it has no turn_direction".to_owned(),
        Outcome::NoConflict => {
            "waits for nobody: no lane conflicts, and the intersection module reports an error".to_owned()
        }
        Outcome::WatchesNobody => "waits for nobody".to_owned(),
        Outcome::NeverMeets => format!("waits for nobody: its path never touches the {watched} that it watches"),
        Outcome::NoApproach => format!("watches {watched} and cannot stop for them: the map begins here"),
        Outcome::StopsTooLate => {
            format!("watches {watched} and stops for none: where it would stop it already stands in the first")
        }
        Outcome::Watches => format!("will wait for {watched}"),
    }
}

/// How many lanes are ignored for each reason, in the order of the lanes.
fn ignored_by(forecast: &Forecast) -> Vec<(Reason, usize)> {
    let mut counts: Vec<(Reason, usize)> = Vec::new();
    for reason in forecast.ignored.iter().filter_map(|one| one.ignored) {
        match counts.iter_mut().find(|(known, _)| *known == reason) {
            Some((_, count)) => *count += 1,
            None => counts.push((reason, 1)),
        }
    }
    counts
}

/// The forecasts as a page for a terminal: of one lanelet all, of many a line each.
pub fn text(forecasts: &[Forecast]) -> String {
    let mut out = String::new();
    match forecasts {
        [one] => details(&mut out, one),
        many => {
            for one in many {
                let turn = one.turn.as_deref().unwrap_or("no turn_direction");
                // Writing to a string cannot fail.
                let _ = writeln!(out, "{} ({turn}): {}", one.lanelet, sentence(one));
            }
        }
    }
    out
}

fn details(out: &mut String, forecast: &Forecast) {
    let path: Vec<String> = forecast.path.iter().map(ToString::to_string).collect();
    let turn = forecast.turn.as_deref().unwrap_or("no turn_direction");
    let _ = writeln!(out, "Lanelet {} ({turn}), {} km/h\n{}", forecast.lanelet, forecast.speed, sentence(forecast));
    let _ = writeln!(out, "\nPath: {}", path.join(" > "));
    table(out, "Watched", &forecast.watched, forecast);
    table(out, "Ignored", &forecast.ignored, forecast);
    let _ = writeln!(
        out,
        "\nPlaces of the front of the vehicle, metres from the begin of the lanelet; negative: before it"
    );
    for (at, what) in places(forecast) {
        let _ = writeln!(out, "  {at:>8.1}  {what}");
    }
    if let Some(area) = &forecast.lines.stuck {
        let size = crate::geometry::polygon::signed_area(&area.outline).abs();
        let _ =
            writeln!(out, "\nA vehicle that stands in the {size:.0} m2 ahead of the lanes that cross blocks the way.");
    }
    if let Some(blind) = &forecast.blind_spot {
        let ids: Vec<String> = blind.lanelets.iter().map(ToString::to_string).collect();
        let _ =
            writeln!(out, "\nBlind spot: {:.0} m back on the {}, along {}", blind.length, blind.side, ids.join(" < "));
    }
}

fn table(out: &mut String, title: &str, lanes: &[Watched], forecast: &Forecast) {
    if !lanes.is_empty() {
        let _ = writeln!(out, "\n{title}");
    }
    for one in lanes {
        let mut notes: Vec<String> = Vec::new();
        notes.extend((forecast.first_watched == Some(one.lanelet)).then(|| "met first".to_owned()));
        notes.extend(one.light.map(|light| format!("light {light}")));
        notes.push(match (one.waits, one.ignored) {
            (Priority::Both, _) => "watches this one, too".to_owned(),
            (Priority::Mine, _) => "does not watch this one".to_owned(),
            (Priority::Theirs, _) => "watches this one".to_owned(),
            (Priority::Nobody, _) => "does not watch this one either".to_owned(),
        });
        notes.extend(one.ignored.map(|reason| match reason {
            Reason::RightOfWay(id) => format!("ignored by element {id}"),
            Reason::BeforeYield(id) => format!("ignored because it leads to what element {id} names"),
            Reason::StraightWithLight(id) => format!("ignored because of light {id}"),
        }));
        if !one.before.is_empty() {
            notes.push(format!("with {} lanelet{} before it", one.before.len(), plural(one.before.len())));
        }
        if let Some((lanelet, after)) = one.ends.iter().min_by(|a, b| a.1.total_cmp(&b.1)) {
            notes.push(format!("the map begins {after:.0} m before it, at {lanelet}"));
        }
        let turn = one.turn.as_deref().unwrap_or("-");
        let _ = writeln!(out, "  {:<12} {turn:<9} {}", one.lanelet, notes.join("; "));
    }
}

fn plural(count: usize) -> &'static str {
    if count == 1 { "" } else { "s" }
}

/// A line across the path, as pictures show it.
#[derive(Clone, Debug, Serialize)]
pub struct Mark<'a> {
    /// Where the front of the vehicle is there.
    #[serde(flatten)]
    pub front: &'a Front,
    /// What it is, in few words.
    pub what: String,
    /// In which hue it is drawn.
    pub hue: Hue,
}

/// The hue of a mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Hue {
    /// Where the vehicle stops.
    White,
    /// From where it watches.
    Red,
    /// All else.
    Amber,
}

/// The lines of a forecast in the order in which they are drawn.
pub fn marks<'a>(forecast: &'a Forecast) -> Vec<Mark<'a>> {
    let mut marks: Vec<Mark<'a>> = Vec::new();
    let mut add = |front: Option<&'a Front>, hue: Hue, what: &str| {
        marks.extend(front.map(|front| Mark { front, what: what.to_owned(), hue }));
    };
    let lines = &forecast.lines;
    add(lines.pass_judge.as_ref(), Hue::Amber, "pass judge");
    add(forecast.blinker.as_ref().and_then(|one| one.start.as_ref()), Hue::Amber, "blinker");
    add(lines.stuck.as_ref().and_then(|area| area.stop.as_ref()), Hue::Amber, "stop if blocked");
    add(lines.first_attention.as_ref(), Hue::Red, "first attention");
    add(lines.peeking.as_ref(), Hue::Red, "peeking");
    add(lines.default_stop.as_ref().map(|stop| &stop.front), Hue::White, "stop for traffic");
    add(forecast.light.as_ref().and_then(|light| light.stop.as_ref()), Hue::White, "stop at red");
    forecast.signs.iter().for_each(|sign| add(Some(&sign.stop), Hue::White, "stop sign"));
    add(forecast.private.as_ref().and_then(|one| one.stop.as_ref()), Hue::White, "leaves private");
    for one in &forecast.crosswalks {
        add(one.stop.front.as_ref(), Hue::White, &format!("crosswalk {}", one.crosswalk));
    }
    marks
}

/// The places along the path, in order, each with what it is.
pub fn places(forecast: &Forecast) -> Vec<(f64, String)> {
    let station = |front: &Front| front.from_start;
    let mut found: Vec<(f64, String)> = vec![(0.0, "begin of the lanelet".to_owned())];
    let lines = &forecast.lines;
    found.extend(lines.first_attention.iter().map(|front| (station(front), "first attention line".to_owned())));
    found.extend(lines.default_stop.iter().map(|stop| {
        let what = match stop.source {
            StopSource::RoadMarking(way) => format!("stop line of the intersection: way {way}"),
            StopSource::Margin => "stop line of the intersection: the default margin".to_owned(),
        };
        let late = match stop.reaches_in {
            ReachesIn::No => "",
            ReachesIn::AtEdge => " (at the very edge of the first watched lane)",
            ReachesIn::Yes => " (inside the first watched lane)",
        };
        (station(&stop.front), format!("{what}{late}"))
    }));
    found.extend(lines.peeking.iter().map(|front| (station(front), "peeking line".to_owned())));
    found.extend(lines.pass_judge.iter().map(|front| {
        let what = format!("pass judge line, {:.1} m of braking at {} km/h", lines.braking, forecast.speed);
        (station(front), what)
    }));
    let stuck = lines.stuck.iter().filter_map(|area| area.stop.as_ref());
    found.extend(stuck.map(|front| (station(front), "stop while the exit is blocked".to_owned())));
    if let Some(light) = &forecast.light {
        let at = light.stop.as_ref().map(station);
        found.extend(at.map(|at| (at, format!("stop line of traffic light {}", light.element))));
    }
    found.extend(forecast.signs.iter().map(|sign| (station(&sign.stop), format!("stop sign {}", sign.element))));
    let private = forecast.private.iter().filter_map(|private| private.stop.as_ref());
    found.extend(private.map(|front| (station(front), "stop on leaving private ground".to_owned())));
    for one in &forecast.crosswalks {
        let line = one.stop.line.map_or("the default distance".to_owned(), |line| format!("way {line}"));
        found.push((one.from_start - one.stop.before, format!("stop for crosswalk {}: {line}", one.crosswalk)));
        found.push((one.from_start, format!("crosswalk {}", one.crosswalk)));
    }
    found.extend(forecast.blinker.iter().map(|blinker| {
        let tag = if blinker.tagged { "turn_signal_distance" } else { "the default at the speed limit" };
        (-blinker.before, format!("blinker {}: {tag}", blinker.side))
    }));
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}
