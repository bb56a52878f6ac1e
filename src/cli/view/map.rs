//! The report of a map, made anew whenever its files change; then what fixes would change.

use std::sync::Arc;
use std::thread;

use crate::cli::watch::Watched;
use crate::cli::{ViewArgs, page};
use crate::lanelet::from_osm;
use crate::report::TextStyle;
use crate::report::failure::Failure;
use crate::report::html::{Ghost, Page, Served, ghosts, parcel, served};
use crate::requirement::Requirement;
use crate::rules;
use crate::triage;

use super::live::Live;
use super::server::Desk;
use crate::api::{CheckOptions, Checked, Loaded, check, mended};

/// The page of a map's report.
pub struct Reports {
    page: String,
}

impl Desk for Reports {
    fn page(&self) -> String {
        self.page.clone()
    }
}

impl Reports {
    /// Reads and checks the map, and goes on whenever a file changes.
    pub fn start(args: ViewArgs, watched: Watched, live: Arc<Live>) -> Result<Self, Failure> {
        let mut stamps = watched.stamps();
        let first = Judged::read(&args)?;
        let page = served(&page::title(&args.map), &requirements()?);
        live.show(first.parcel(&args, &[])?);
        thread::spawn(move || {
            let mut checked: Result<Judged, Failure> = Ok(first);
            loop {
                let told = checked.and_then(|checked| {
                    let ghosts = checked.ghosts(args.r#unsafe)?;
                    if !ghosts.is_empty() {
                        live.show(checked.parcel(&args, &ghosts)?);
                    }
                    Ok(())
                });
                if let Err(failure) = told {
                    live.fail(failure.render(TextStyle::default()));
                }
                watched.wait(stamps);
                stamps = watched.stamps();
                checked = Judged::read(&args).and_then(|checked| {
                    live.show(checked.parcel(&args, &[])?);
                    Ok(checked)
                });
            }
        });
        Ok(Self { page })
    }
}

/// The requirements whose pages a report may need.
pub fn requirements() -> Result<Vec<&'static Requirement>, Failure> {
    let failed = |error: &dyn std::fmt::Display| Failure::new(error.to_string());
    let rows = rules::table().map_err(|error| failed(error))?;
    let own = triage::requirement().map_err(|error| failed(error))?;
    Ok(rows.iter().map(|row| &row.requirement).chain([own]).collect())
}

/// A map and what was found in it.
struct Judged(Checked);

impl Judged {
    fn read(args: &ViewArgs) -> Result<Self, Failure> {
        let options = CheckOptions { configuration: args.config.configuration(), ..CheckOptions::default() };
        Ok(Self(check(args.map.as_path(), options)?))
    }

    /// What the page fetches.
    fn parcel(&self, args: &ViewArgs, ghosts: &[Ghost]) -> Result<Vec<u8>, Failure> {
        self.0.with_report(|report| {
            let (title, path, requirements) =
                (page::title(&args.map), page::only_file(report), page::requirements(report)?);
            let page = Page { title: &title, path: path.as_deref(), requirements: &requirements, ..Page::default() };
            parcel(report, &page, &Served { ghosts, workshop: None }).map_err(|error| Failure::new(error.to_string()))
        })
    }

    /// What `fix` would change. The files stay as they are.
    fn ghosts(&self, unsafe_too: bool) -> Result<Vec<Ghost>, Failure> {
        let Loaded { map, projector, .. } = &self.0.loaded;
        let findings = &self.0.sorted.left;
        if findings.iter().all(|one| one.finding.fix.is_none()) {
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
        Ok(ghosts(map, &from_osm(&mended.osm, projector).map, findings, &done))
    }
}
