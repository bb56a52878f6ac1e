//! `view --build`: the builder's stages, made anew after every edit of the input. The input's file is only read.

use std::sync::{Arc, PoisonError, RwLock};
use std::thread;
use std::time::Instant;

use crate::builder::{BuildError, BuildOptions, Built, Plan, build_plan, plan};
use crate::cli::args::LayoutArgs;
use crate::cli::draw_args::StageArg;
use crate::cli::watch::Watched;
use crate::cli::{outcome, report_page, stage};
use crate::diagnostic::{Diagnostic, Finding, Severity, Subject};
use crate::geometry::Point;
use crate::lanelet::index::MapIndex;
use crate::lanelet::locate::locate;
use crate::osm::OsmData;
use crate::projection::{Extent, LonLat, Projector};
use crate::report::draw::sketch::Sketch;
use crate::report::failure::Failure;
use crate::report::html::{BuildStages, InputRoad, InputWay, Page, Served, Stage, parcel, served_build_stages};
use crate::report::{Report, Sources, TextStyle};
use crate::rules;
use crate::rules::Config;

use super::args::ViewArgs;
use super::downloads;
use super::edits::Question;
use super::server::{Answer, Handler};
use super::subscriptions::Subscriptions;
use crate::api::layout::{build_failure, osm_data};
use crate::api::requirements;

use clap::ValueEnum;
use rustc_hash::{FxHashMap, FxHashSet};

/// More roads than this are not built at once: the answer would come too late for a hand that waits.
const MOST_WAYS: usize = 700;
/// The same for pairs of meetings of roads on a square: a few long ways may cross each other thousands of times, and crossings that lie
/// close to each other cost the more. The densest extracts of real cities with so few roads have fewer.
const MOST_PAIRS: usize = 10_000;
/// Side of such a square, metres.
const SQUARE: f64 = 50.0;
/// Where there are more, this much around the place that is looked at is built, metres; half of it, and again, where that holds more
/// pairs.
const BUILT_AROUND: f64 = 300.0;
/// No less than this is built, metres.
const LEAST_AROUND: f64 = 30.0;
/// Metres in a degree of latitude.
const DEGREE: f64 = 111_000.0;

/// The input, and how it is built.
pub struct BuildSession {
    data: OsmData,
    options: BuildOptions,
    projector: Projector,
    /// Where the page's plane has its origin; the same after every edit.
    origin: Point,
    middle: LonLat,
    title: String,
    ways: usize,
}

/// The page of a map in the making.
pub struct BuildSessions {
    page: String,
    session: RwLock<Arc<BuildSession>>,
}

impl BuildSessions {
    /// Reads and builds the input, and goes on whenever its file changes.
    pub fn start(args: ViewArgs, watched: Watched, subscriptions: Arc<Subscriptions>) -> Result<Arc<Self>, Failure> {
        let mut stamps = watched.stamps();
        let (session, first) = BuildSession::open(&args)?;
        subscriptions.show(first);
        let page = served_build_stages(&session.title, &requirements()?);
        let sessions = Arc::new(Self { page, session: RwLock::new(Arc::new(session)) });
        let ours = Arc::clone(&sessions);
        thread::spawn(move || {
            loop {
                watched.wait(stamps);
                stamps = watched.stamps();
                match outcome::of(|| BuildSession::open(&args)) {
                    Ok((session, parcel)) => {
                        *ours.session.write().unwrap_or_else(PoisonError::into_inner) = Arc::new(session);
                        subscriptions.show(parcel);
                    }
                    Err(failure) => subscriptions.fail(failure.render(TextStyle::default())),
                }
            }
        });
        Ok(sessions)
    }

    fn session(&self) -> Arc<BuildSession> {
        Arc::clone(&self.session.read().unwrap_or_else(PoisonError::into_inner))
    }
}

impl Handler for BuildSessions {
    fn page(&self) -> String {
        self.page.clone()
    }

    fn post(&self, path: &str, question: &str) -> Option<Result<Answer, String>> {
        let answer = |with: fn(&BuildSession, &Question) -> Result<Answer, String>| {
            let question =
                serde_json::from_str(question).map_err(|error| format!("this is no list of edits: {error}"))?;
            with(&self.session(), &question)
        };
        Some(match path {
            "/build" => answer(|session, question| {
                let built = outcome::of(|| session.build(question)).map_err(|failure| failure.to_string())?;
                Ok(Answer { bytes: built, name: None })
            }),
            "/save/osm" => answer(|session, question| downloads::osm(&session.data, &session.title, question)),
            "/save/toml" => answer(|_, question| downloads::toml(question)),
            _ => return None,
        })
    }
}

/// Pairs of meetings of roads that lie on the same square; a meeting is a node to which a road comes where one was before.
fn pairs_of_meetings(data: &OsmData) -> usize {
    let mut seen = FxHashSet::default();
    let mut squares: FxHashMap<[i64; 2], usize> = FxHashMap::default();
    let roads = data.ways.iter().filter(|way| way.tags.has("highway"));
    for id in roads.flat_map(|way| &way.nodes).filter(|id| !seen.insert(**id)) {
        let Some(LonLat { lon, lat }) = data.node(*id).and_then(|node| node.position) else { continue };
        let square = [lat, lon * lat.to_radians().cos()].map(|degrees| (degrees * DEGREE / SQUARE).floor() as i64);
        *squares.entry(square).or_default() += 1;
    }
    squares.values().map(|count| count * count).sum()
}

/// All stages; the last is the map itself.
fn stages(plan: &Plan) -> Vec<Stage> {
    let of = |which: &StageArg| Stage {
        name: which.name(),
        title: which.to_possible_value().and_then(|value| Some(value.get_help()?.to_string())).unwrap_or_default(),
        sketch: if *which == StageArg::Movements {
            Sketch::default()
        } else {
            stage::sketch(plan, *which, None, false)
        },
    };
    StageArg::value_variants().iter().map(of).collect()
}

/// The middle one of some places, by latitude and longitude.
fn median(mut places: Vec<LonLat>) -> LonLat {
    let middle = places.len() / 2;
    let mut of = |value: fn(&LonLat) -> f64| {
        places.sort_unstable_by(|a, b| value(a).total_cmp(&value(b)));
        places.get(middle).map_or(0.0, value)
    };
    LonLat { lon: of(|place| place.lon), lat: of(|place| place.lat) }
}

impl BuildSession {
    /// Reads the input and builds it as it is.
    fn open(args: &ViewArgs) -> Result<(Self, Vec<u8>), Failure> {
        let layout = LayoutArgs {
            driving_side: args.driving_side,
            config: args.config.config.clone(),
            isolated: args.config.isolated,
            ..LayoutArgs::default()
        };
        let title = report_page::title(&args.map);
        let (data, options) = osm_data(&args.map, &layout.options())?;
        let of_roads: FxHashSet<i64> =
            data.ways.iter().filter(|way| way.tags.has("highway")).flat_map(|way| way.nodes.iter().copied()).collect();
        let places: Vec<LonLat> = of_roads.iter().filter_map(|id| data.node(*id)?.position).collect();
        let Some(extent) = Extent::of(places.iter().copied()) else {
            let error = plan(&data, &options).err().unwrap_or(BuildError::NoPlace);
            return Err(build_failure(error, &title));
        };
        let projector = options.projector.unwrap_or_else(|| Projector::for_extent(&extent));
        let middle = args.at.map_or_else(|| median(places), |(lat, lon)| LonLat { lon, lat });
        let origin = projector.forward(extent.center(), 0.0).unwrap_or_default().map(f64::round);
        let ways = data.ways.iter().filter(|way| way.tags.has("highway")).count();
        let session = Self { data, options, projector, origin, middle, title, ways };
        let first = session.build(&Question::default())?;
        Ok((session, first))
    }

    /// Builds the input with edits, all of it or what lies around a place; what the page fetches.
    fn build(&self, question: &Question) -> Result<Vec<u8>, Failure> {
        let start = Instant::now();
        let (mut data, frame) = self.part(question);
        question.apply(&mut data)?;
        let mut options = BuildOptions { projector: Some(self.projector), ..self.options.clone() };
        let wishes = question.merges();
        let own = wishes.len();
        options.merges.splice(0..0, wishes);
        let plan = plan(&data, &options).map_err(|error| build_failure(error, &self.title))?;
        let mut build_stages = self.build_stages(&plan, &data, own);
        build_stages.part = frame.map(|corners| (corners, [data.ways.len(), self.data.ways.len()]));
        let mut built = build_plan(plan);
        built.map.place_on_globe(&built.projector);
        let diagnostics = self.diagnostics(&built, &data, !question.quick)?;
        build_stages.took = u64::try_from(start.elapsed().as_millis()).unwrap_or(u64::MAX);
        self.parcel(&built, &diagnostics, &build_stages)
    }

    /// The input, or where that is large, what lies around a place, with the corners of the box in metres.
    fn part(&self, question: &Question) -> (OsmData, Option<[Point; 2]>) {
        if self.ways <= MOST_WAYS && pairs_of_meetings(&self.data) <= MOST_PAIRS {
            return (self.data.clone(), None);
        }
        let place = question.around.map_or(self.middle, |[lat, lon]| LonLat { lon, lat });
        let mut reach = BUILT_AROUND;
        loop {
            let (high, wide) = (reach / DEGREE, reach / (DEGREE * place.lat.to_radians().cos().max(0.01)));
            let corner = |sign: f64| LonLat { lon: place.lon + sign * wide, lat: place.lat + sign * high };
            let [min, max] = [corner(-1.0), corner(1.0)];
            let part = self.data.within(&Extent { min, max });
            if pairs_of_meetings(&part) <= MOST_PAIRS || reach <= LEAST_AROUND {
                let corners = [min, max].map(|corner| self.projector.forward(corner, 0.0).unwrap_or_default());
                return (part, Some(corners));
            }
            reach = (reach / 2.0).max(LEAST_AROUND);
        }
    }

    /// What a page shows of a plan, of which the first `own` wishes came from the page.
    fn build_stages(&self, plan: &Plan, data: &OsmData, own: usize) -> BuildStages {
        let network = &plan.streets.network;
        let inner = network.intersections.iter().flat_map(|intersection| &intersection.inner);
        let notes: FxHashMap<_, _> = plan.streets.merges.iter().map(|note| (note.key, note)).collect();
        let keys = network.roads.iter().map(|road| (road.key, false)).chain(inner.clone().map(|road| (road.key, true)));
        let roads = keys.map(|(key, merged)| {
            let note = notes.get(&key);
            InputRoad {
                way: key.way,
                ends: [key.first, key.last],
                merged,
                why: note.map(|note| {
                    let here = note.wish.is_some_and(|wish| wish < own);
                    let why = if here { "decided here" } else { note.reason.words() };
                    format!("{why}; {:.1} m left between its cuts", note.left)
                }),
            }
        });
        let used: FxHashSet<i64> = network
            .roads
            .iter()
            .flat_map(|road| &road.ways)
            .chain(inner.flat_map(|road| &road.ways))
            .copied()
            .collect();
        let mut build_stages = BuildStages { stages: stages(plan), roads: roads.collect(), ..BuildStages::default() };
        let mut numbers: FxHashMap<i64, usize> = FxHashMap::default();
        for way in data.ways.iter().filter(|way| used.contains(&way.id)) {
            let mut nodes = Vec::with_capacity(way.nodes.len());
            for id in &way.nodes {
                let Some(at) = data.node(*id).and_then(|node| self.projector.forward(node.position?, 0.0)) else {
                    continue;
                };
                nodes.push(*numbers.entry(*id).or_insert_with(|| {
                    build_stages.nodes.push((*id, at));
                    build_stages.nodes.len() - 1
                }));
            }
            let tags = way.tags.iter().map(|(key, value)| (key.to_owned(), value.to_owned())).collect();
            build_stages.ways.push(InputWay { id: way.id, nodes, tags });
        }
        build_stages
    }

    /// What the rules find in the map, if that is wanted, and what the builder says of the input.
    fn diagnostics(&self, built: &Built, data: &OsmData, judged: bool) -> Result<Vec<Diagnostic>, Failure> {
        let mut all = Vec::new();
        if judged {
            let index = MapIndex::new(&built.map, &[], &built.settings);
            let found = rules::run(&index, &Config::from(&built.settings));
            all.extend(found.map_err(|error| Failure::new(error.to_string()))?);
        }
        all.extend(built.notes.iter().map(|note| self.note(note, built, data)));
        Ok(all)
    }

    fn note(&self, finding: &Finding, built: &Built, data: &OsmData) -> Diagnostic {
        let node = match finding.subject {
            Subject::Node(id) => data.node(id),
            Subject::Way(id) => data.way(id).and_then(|way| data.node(*way.nodes.get(way.nodes.len() / 2)?)),
            _ => None,
        };
        let lonlat = node.and_then(|node| node.position);
        let local = lonlat.and_then(|place| self.projector.forward(place, 0.0));
        let found = locate(&built.map, finding.subject, &finding.place);
        let severity = finding.severity.unwrap_or(Severity::Info);
        Diagnostic {
            lonlat: lonlat.or(found.lonlat),
            local: found.local.or(local),
            ..Diagnostic::new(format!("build/{}", finding.fault), severity, finding.clone())
        }
    }

    fn parcel(
        &self,
        built: &Built,
        diagnostics: &[Diagnostic],
        build_stages: &BuildStages,
    ) -> Result<Vec<u8>, Failure> {
        let requirements = rules::selected(&Config::from(&built.settings));
        let sources = Sources::new([]);
        let report = Report { requirements: &requirements, ..Report::new(diagnostics, &sources, &built.map) };
        let all = report_page::requirements(&report)?;
        let page = Page { title: &self.title, requirements: &all, origin: Some(self.origin), ..Page::default() };
        let served = Served { build_stages: Some(build_stages), ..Served::default() };
        parcel(&report, &page, &served).map_err(|error| Failure::new(error.to_string()))
    }
}
