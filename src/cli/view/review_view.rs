//! `view --review`: the page of a review. The server holds what was decided; only a page that knows the token may ask and tell.

use std::fmt::Write;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use serde::Deserialize;
use serde_json::{Value, json};

use crate::api::requirements;
use crate::api::review::{Decision, HandEdit, Preview, Review, ReviewOptions};
use crate::cli::watch::Watched;
use crate::cli::{outcome, report_page};
use crate::geometry::Point;
use crate::report::TextStyle;
use crate::report::failure::Failure;
use crate::report::html::{Page, Served, page_origin, parcel, served_review, shown_previews};
use crate::report::visible;

use super::args::ViewArgs;
use super::server::{Answer, Handler};
use super::subscriptions::Subscriptions;

/// What a page wants to be done.
#[derive(Debug, Deserialize)]
#[serde(tag = "do", rename_all = "kebab-case", deny_unknown_fields)]
enum Action {
    Accept { items: Vec<usize> },
    Reject { items: Vec<usize>, reason: String },
    Later { items: Vec<usize> },
    Edit { edit: HandEdit },
    Undo,
    Save,
    Reload,
}

/// Which fix a page asks about.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Question {
    item: usize,
}

/// The page of a review.
pub struct ReviewSession {
    page: String,
    title: String,
    token: String,
    /// Where the page's plane has its origin; the same after every edit.
    origin: Point,
    review: Mutex<Review>,
    subscriptions: Arc<Subscriptions>,
}

impl ReviewSession {
    /// Reads and judges the map, and looks whether somebody else saves its files.
    pub fn start(args: ViewArgs, watched: Watched, subscriptions: Arc<Subscriptions>) -> Result<Arc<Self>, Failure> {
        let stamps = watched.stamps();
        let configuration = args.config.configuration();
        let review = Review::open(ReviewOptions { map: args.map.clone(), configuration, baseline: args.baseline })?;
        let title = report_page::title(&args.map);
        let session = Arc::new(Self {
            page: served_review(&title, &requirements()?),
            title,
            token: token()?,
            origin: page_origin(review.map()),
            review: Mutex::new(review),
            subscriptions,
        });
        session.show(&session.review())?;
        let ours = Arc::clone(&session);
        thread::spawn(move || ours.follow(&watched, stamps));
        Ok(session)
    }

    fn review(&self) -> MutexGuard<'_, Review> {
        self.review.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Reads the files again when somebody else has saved them; where there are decisions that are not saved, the page asks first.
    fn follow(&self, watched: &Watched, mut stamps: Vec<crate::cli::watch::Stamp>) {
        loop {
            watched.wait(stamps);
            stamps = watched.stamps();
            let mut review = self.review();
            if !review.is_overtaken() {
                continue;
            }
            if review.is_unsaved() {
                let words = "Somebody else has saved the map. Press Reload: it is read again, and your decisions are made on what it says now.";
                self.subscriptions.fail(words.to_owned());
                continue;
            }
            let told = outcome::of(|| review.reload().and_then(|_| self.show(&review)));
            if let Err(failure) = told {
                self.subscriptions.fail(failure.render(TextStyle::default()));
            }
        }
    }

    /// Shows the map as the review has it now.
    fn show(&self, review: &Review) -> Result<(), Failure> {
        let facts = facts(review);
        let data = review.with_report(|report| {
            let requirements = report_page::requirements(report)?;
            let path = report_page::only_file(report);
            let page = Page {
                title: &self.title,
                path: path.as_deref(),
                requirements: &requirements,
                origin: Some(self.origin),
                ..Page::default()
            };
            let served = Served { review: Some(&facts), ..Served::default() };
            parcel(report, &page, &served).map_err(|error| Failure::new(error.to_string()))
        })?;
        self.subscriptions.show(data);
        Ok(())
    }

    /// Does what a page wants; says what came of it.
    fn act(&self, action: Action) -> Result<String, Failure> {
        let mut review = self.review();
        let said = match action {
            Action::Accept { items } => review.accept(&items),
            Action::Reject { items, reason } => review.reject(&items, &reason),
            Action::Later { items } => review.put_off(&items),
            Action::Edit { edit } => review.edit(&edit),
            Action::Undo => review.undo(),
            Action::Save => review.save(),
            Action::Reload => review.reload().map(|lost| match lost.len() {
                0 => "read again".to_owned(),
                _ => format!("read again; not made again: {}", lost.join("; ")),
            }),
        };
        // A refused save may have found more to show.
        self.show(&review)?;
        said
    }
}

impl Handler for ReviewSession {
    fn page(&self) -> String {
        self.page.clone()
    }

    fn token(&self) -> Option<&str> {
        Some(&self.token)
    }

    fn post(&self, path: &str, question: &str) -> Option<Result<Answer, String>> {
        let answer = |value: &Value| Answer { bytes: value.to_string().into_bytes(), name: None };
        Some(match path {
            "/review/do" => read(question).and_then(|action| {
                let said = outcome::of(|| self.act(action)).map_err(in_a_line)?;
                Ok(answer(&json!({ "said": said })))
            }),
            "/review/preview" => read(question).and_then(|Question { item }| {
                let preview = outcome::of(|| self.review().preview(item)).map_err(in_a_line)?;
                Ok(answer(&self.preview(item, &preview)))
            }),
            "/review/diff" => {
                Ok(Answer { bytes: json!({ "diff": self.review().diff() }).to_string().into_bytes(), name: None })
            }
            _ => return None,
        })
    }
}

impl ReviewSession {
    fn preview(&self, item: usize, preview: &Preview) -> Value {
        let Preview { refused, also, changes, counts, brings, planner, pictures } = preview;
        json!({
            "item": item,
            "refused": refused,
            "also": also,
            "changes": shown_previews(changes, self.origin),
            "counts": counts,
            "brings": brings,
            "planner": planner,
            "pictures": pictures,
        })
    }
}

fn read<'a, T: Deserialize<'a>>(question: &'a str) -> Result<T, String> {
    serde_json::from_str(question).map_err(|error| format!("this is nothing that a review can do: {error}"))
}

fn in_a_line(failure: Failure) -> String {
    let way_out = failure.way_out().map(|help| format!(" ({help})")).unwrap_or_default();
    format!("{}{way_out}", visible(failure.message()))
}

/// How far the review has come.
fn facts(review: &Review) -> Value {
    let open = review.open_items();
    let items = review.items().map(|(at, item)| {
        let subject = item.finding.finding.subject;
        let (status, reason) = match review.decision(at) {
            Some(Decision::Accepted) => ("accepted", None),
            Some(Decision::Rejected(reason)) => ("rejected", Some(reason)),
            _ if !open.contains(&at) => ("gone", None),
            Some(Decision::Later) => ("later", None),
            None => ("open", None),
        };
        json!({
            "id": at,
            "kind": item.kind,
            "code": item.finding.code,
            "severity": item.finding.severity,
            "message": item.finding.finding.message,
            "help": item.finding.help,
            "subject": subject.to_string(),
            "subject_id": subject.id().map(|id| id.to_string()),
            "title": item.title(),
            "safe": item.safe,
            "assumes": item.assumes,
            "findings": item.mends.len(),
            "status": status,
            "reason": reason,
        })
    });
    json!({
        "items": items.collect::<Vec<_>>(),
        "steps": review.steps().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "can_undo": review.can_undo(),
        "unsaved": review.is_unsaved(),
        "counts": review.counts(),
        "baseline": review.baseline_file().display().to_string(),
    })
}

/// A word that nobody guesses: 128 bits.
fn token() -> Result<String, Failure> {
    let mut bytes = [0_u8; 16];
    getrandom::fill(&mut bytes).map_err(|error| Failure::new(format!("the system gives no random number: {error}")))?;
    Ok(bytes.iter().fold(String::new(), |mut token, byte| {
        let _ = write!(token, "{byte:02x}");
        token
    }))
}
