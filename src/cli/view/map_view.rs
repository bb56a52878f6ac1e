//! The report of a map, made anew whenever its files change; then what fixes would change.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use crate::cli::watch::Watched;
use crate::cli::{outcome, report_page};
use crate::lanelet::from_osm;
use crate::planner::Params;
use crate::report::failure::Failure;
use crate::report::html::{FixPreview, Page, Served, fix_previews, parcel, served};
use crate::report::{TextStyle, planner};

use super::args::ViewArgs;
use super::server::{Answer, Handler};
use super::subscriptions::Subscriptions;
use crate::api::{Along, CheckOptions, Checked, Loaded, check, forecasts, mended, requirements};

/// The page of a map's report, and the map that it shows.
pub struct Reports {
    page: String,
    params: Params,
    shown: Arc<Mutex<Arc<Judged>>>,
}

impl Handler for Reports {
    fn page(&self) -> String {
        self.page.clone()
    }

    fn post(&self, path: &str, question: &str) -> Option<Result<Answer, String>> {
        (path == "/planner").then(|| {
            let id = question.parse().map_err(|_| format!("`{question}` is no id of a lanelet"))?;
            let shown = Arc::clone(&lock(&self.shown));
            let bytes = planned(&shown.0.loaded, id, &self.params).map_err(|failure| failure.to_string())?;
            Ok(Answer { bytes, name: None })
        })
    }
}

/// Whoever panicked while it held the map has left it whole.
fn lock(shown: &Mutex<Arc<Judged>>) -> MutexGuard<'_, Arc<Judged>> {
    shown.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What the planner will do on a lanelet, as `planner --format json` tells it.
fn planned(loaded: &Loaded, lanelet: i64, params: &Params) -> Result<Vec<u8>, Failure> {
    let found = forecasts(loaded, &Along::Lanelets(vec![lanelet]), params)?;
    let told = planner::json(&found, params, &|_| None).and_then(|json| serde_json::to_vec(&json));
    told.map_err(|error| Failure::new(error.to_string()))
}

impl Reports {
    /// Reads and checks the map, and goes on whenever a file changes.
    pub fn start(args: ViewArgs, watched: Watched, subscriptions: Arc<Subscriptions>) -> Result<Self, Failure> {
        let mut stamps = watched.stamps();
        let params = args.parameters.read()?;
        let first = Arc::new(Judged::read(&args)?);
        let shown = Arc::new(Mutex::new(Arc::clone(&first)));
        let latest = Arc::clone(&shown);
        let page = served(&report_page::title(&args.map), &requirements()?);
        subscriptions.show(first.parcel(&args, &[])?);
        thread::spawn(move || {
            let mut checked: Result<Arc<Judged>, Failure> = Ok(first);
            loop {
                let told = checked.and_then(|checked| {
                    outcome::of(|| {
                        let previews = checked.fix_previews(args.r#unsafe)?;
                        if !previews.is_empty() {
                            subscriptions.show(checked.parcel(&args, &previews)?);
                        }
                        Ok(())
                    })
                });
                if let Err(failure) = told {
                    subscriptions.fail(failure.render(TextStyle::default()));
                }
                watched.wait(stamps);
                stamps = watched.stamps();
                checked = outcome::of(|| {
                    let checked = Arc::new(Judged::read(&args)?);
                    let parcel = checked.parcel(&args, &[])?;
                    *lock(&latest) = Arc::clone(&checked);
                    subscriptions.show(parcel);
                    Ok(checked)
                });
            }
        });
        Ok(Self { page, params, shown })
    }
}

/// A map and what was found in it.
struct Judged(Checked);

impl Judged {
    fn read(args: &ViewArgs) -> Result<Self, Failure> {
        let options = CheckOptions { configuration: args.config.configuration(), ..CheckOptions::default() };
        Ok(Self(check(args.map.as_path(), options)?))
    }

    /// What the page fetches.
    fn parcel(&self, args: &ViewArgs, previews: &[FixPreview]) -> Result<Vec<u8>, Failure> {
        self.0.with_report(|report| {
            let (title, path, requirements) =
                (report_page::title(&args.map), report_page::only_file(report), report_page::requirements(report)?);
            let page = Page { title: &title, path: path.as_deref(), requirements: &requirements, ..Page::default() };
            parcel(report, &page, &Served { previews, ..Served::default() })
                .map_err(|error| Failure::new(error.to_string()))
        })
    }

    /// What `fix` would change. The files stay as they are.
    fn fix_previews(&self, unsafe_too: bool) -> Result<Vec<FixPreview>, Failure> {
        let Loaded { map, projector, .. } = &self.0.loaded;
        let findings = &self.0.sorted.left;
        if self.0.loaded.divided || findings.iter().all(|one| one.finding.fix.is_none()) {
            return Ok(Vec::new());
        }
        let mended = mended(&self.0.loaded, unsafe_too)?;
        let kept = |i: &usize| {
            let one = &findings[*i];
            let same = |title: &str| {
                mended
                    .done
                    .iter()
                    .any(|mend| mend.code == one.code && mend.subject == one.finding.subject && mend.title == title)
            };
            one.finding.fix.as_ref().is_some_and(|fix| same(&fix.title))
        };
        let done: Vec<usize> = (0..findings.len()).filter(kept).collect();
        Ok(fix_previews(map, &from_osm(&mended.osm, projector).map, findings, &done))
    }
}
