//! A review of a map: fixes that a person accepts or rejects one after another, edits of their own, undo, and saving. Nothing is
//! written before that. The page of `view --review` and `fix --interactive` are two faces of it.

mod hand_edit;
mod inputs;
mod item;
mod preview;
mod proposals;
mod save;
mod step;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rustc_hash::FxHashMap;

use crate::diagnostic::{Diagnostic, Severity, Subject};
use crate::fix::{Mend, applied, mend_chosen, new_findings};
use crate::lanelet::{INFO, LaneletMap, from_osm};
use crate::osm::OsmData;
use crate::report::Report;
use crate::report::failure::Failure;
use crate::triage::{Baseline, Sorted};

use super::checked::with_report;
use super::config::Configuration;
use super::error::Error;
use super::fixed::{PROJECTOR_MISSING, ProjectorFile, fix_failure, unreadable};
use super::judge::MapJudge;
use super::load::{self, Loaded};
pub use hand_edit::{HELP, HandEdit};
pub use item::{Decision, Item};
pub use preview::Preview;
pub use step::Step;

/// The baseline of a review that names none: a file of this name beside the map.
const BASELINE: &str = "baseline.json";
/// So much text of maps is kept for undo, bytes; older states than these are gone.
const UNDO_TEXT: usize = 1 << 30;

/// What is reviewed.
#[derive(Clone, Debug)]
pub struct ReviewOptions {
    /// A `.osm` file, a directory of them, or a map directory.
    pub map: PathBuf,
    /// Which settings count, which rules are asked.
    pub configuration: Configuration,
    /// The file that remembers what was rejected; `baseline.json` beside the map where none is named.
    pub baseline: Option<PathBuf>,
}

/// A map in the midst of a review.
pub struct Review {
    options: ReviewOptions,
    /// The map as its files have it.
    loaded: Loaded,
    /// The projector's file that is not beside the map; writing it is proposed as a fix.
    missing: Option<ProjectorFile>,
    baseline_file: PathBuf,
    /// What was known when the review began.
    baseline: Baseline,
    /// What the review has written into the baseline.
    remembered: BTreeMap<(String, Subject), String>,
    /// Errors and warnings of the map as it was read.
    first: [usize; 2],
    items: Vec<Item>,
    by_mend: FxHashMap<Mend, usize>,
    now: State,
    past: Vec<State>,
    /// What would come of single fixes, in the map as it is now.
    tried: FxHashMap<usize, Arc<Outcome>>,
}

/// The map at one step of a review, with all that was decided until then.
#[derive(Clone)]
struct State {
    osm: Arc<OsmData>,
    map: Arc<LaneletMap>,
    left: Arc<Vec<Diagnostic>>,
    /// Whether the projector's file that was missing is to be written.
    with_projector_file: bool,
    decisions: BTreeMap<usize, Decision>,
    steps: Vec<Step>,
}

/// What comes of some fixes.
struct Outcome {
    osm: Arc<OsmData>,
    left: Arc<Vec<Diagnostic>>,
    with_projector_file: bool,
    made: Vec<Mend>,
    refused: Vec<(Mend, String)>,
}

/// Errors and warnings.
fn counts(found: &[Diagnostic]) -> [usize; 2] {
    [Severity::Error, Severity::Warning].map(|severity| found.iter().filter(|one| one.severity == severity).count())
}

impl Review {
    /// Reads and judges a map. What the baseline knows is not proposed.
    ///
    /// # Errors
    ///
    /// Where the map, the baseline or settings cannot be read, or the map is divided or packed: such files are not edited.
    pub fn open(options: ReviewOptions) -> Result<Self, Error> {
        let loaded = Loaded::read(options.map.as_path(), &options.configuration)?;
        inputs::editable(&loaded)?;
        let baseline_file = options.baseline.clone().unwrap_or_else(|| load::home(&options.map).join(BASELINE));
        let baseline = match options.baseline.is_some() || baseline_file.is_file() {
            true => inputs::read(&baseline_file)?,
            false => Baseline::default(),
        };
        let judge = MapJudge::telling(&loaded, &loaded.projector, &loaded.info, &|_, _| {}).knowing(Some(&baseline));
        let left = crate::fix::Judge::whole(&judge, &loaded.osm)?;
        let now = State {
            osm: Arc::new(loaded.osm.clone()),
            map: Arc::new(loaded.map.clone()),
            left: Arc::new(left),
            with_projector_file: false,
            decisions: BTreeMap::new(),
            steps: Vec::new(),
        };
        let mut review = Self {
            options,
            missing: ProjectorFile::missing(&loaded),
            first: counts(&now.left),
            loaded,
            baseline_file,
            baseline,
            remembered: BTreeMap::new(),
            items: Vec::new(),
            by_mend: FxHashMap::default(),
            now,
            past: Vec::new(),
            tried: FxHashMap::default(),
        };
        review.list();
        Ok(review)
    }

    /// What was done so far, in order.
    pub fn steps(&self) -> &[Step] {
        &self.now.steps
    }

    /// Whether there is something to undo.
    pub fn can_undo(&self) -> bool {
        !self.past.is_empty()
    }

    /// Errors and warnings of the map as it was read, and as it is now.
    pub fn counts(&self) -> [[usize; 2]; 2] {
        [self.first, counts(&self.now.left)]
    }

    /// The map as it is now.
    pub fn map(&self) -> &LaneletMap {
        &self.now.map
    }

    /// The file that remembers what was rejected.
    pub fn baseline_file(&self) -> &Path {
        &self.baseline_file
    }

    /// All that shows what is found in the map as it is now.
    pub fn with_report<T>(&self, show: impl FnOnce(&Report<'_>) -> T) -> T {
        let left = self.now.left.as_ref().clone();
        let sorted = Sorted { left, known: self.baseline.len(), ..Sorted::default() };
        let (projector, settings) = (self.projector(), &self.loaded.settings);
        with_report((&self.now.osm, &self.now.map), (&projector, settings), &sorted, show)
    }

    /// What comes of some fixes in the map as it is now. A file that is missing comes first: the others are judged with it.
    fn outcome(&self, items: &[usize]) -> Result<Outcome, Error> {
        let mends = items.iter().filter_map(|&at| self.items.get(at)).flat_map(|item| &item.mends);
        let (of_file, chosen): (Vec<Mend>, Vec<Mend>) = mends.cloned().partition(|mend| mend.code == PROJECTOR_MISSING);
        let State { osm, left, .. } = &self.now;
        let with_projector_file = self.now.with_projector_file || !of_file.is_empty();
        let plane = self.plane(with_projector_file);
        let left = match of_file.is_empty() {
            true => Arc::clone(left),
            false => Arc::new(crate::fix::Judge::whole(&self.judge(&plane), osm)?),
        };
        if chosen.is_empty() {
            let (osm, made, refused) = (Arc::clone(osm), of_file, Vec::new());
            return Ok(Outcome { osm, left, with_projector_file, made, refused });
        }
        let chosen = chosen.into_iter().collect();
        let mended = mend_chosen(osm.as_ref().clone(), left.as_ref().clone(), chosen, self.judge(&plane))
            .map_err(fix_failure)?;
        Ok(Outcome {
            osm: Arc::new(mended.osm),
            left: Arc::new(mended.left),
            with_projector_file,
            made: of_file.into_iter().chain(mended.done).collect(),
            refused: mended.refused,
        })
    }

    /// The same of one fix; asked again, it is known.
    fn tried(&mut self, item: usize) -> Result<Arc<Outcome>, Error> {
        if let Some(known) = self.tried.get(&item) {
            return Ok(Arc::clone(known));
        }
        let outcome = Arc::new(self.outcome(&[item])?);
        self.tried.insert(item, Arc::clone(&outcome));
        Ok(outcome)
    }

    /// The number of an open fix that somebody names.
    fn open_item(&self, item: usize) -> Result<(), Failure> {
        match self.open_items().contains(&item) {
            true => Ok(()),
            false => Err(Failure::new("this fix is not open any more").help("look at the next one")),
        }
    }

    /// Makes fixes, and those that follow from them. What does harm is not made: if that is all of it, it is an error that says why.
    ///
    /// # Errors
    ///
    /// Where none of them can be made.
    pub fn accept(&mut self, items: &[usize]) -> Result<String, Failure> {
        items.iter().try_for_each(|&item| self.open_item(item))?;
        let outcome = match items {
            [one] => self.tried(*one)?,
            many => Arc::new(self.outcome(many)?),
        };
        let is_made = |item: &Item| item.mends.iter().any(|mend| outcome.made.contains(mend));
        let made: Vec<usize> = items.iter().copied().filter(|&at| self.items.get(at).is_some_and(is_made)).collect();
        if made.is_empty() {
            let why = outcome.refused.first().map_or("another change has mended it", |(_, why)| why.as_str());
            return Err(Failure::new(format!("not made: {why}")).help("reject it, or edit the map yourself"));
        }
        let mut decisions = self.now.decisions.clone();
        decisions.extend(made.iter().map(|&at| (at, Decision::Accepted)));
        let words = match made.as_slice() {
            [one] => self.items.get(*one).map(|item| item.title().to_owned()).unwrap_or_default(),
            many => format!("{} fixes", many.len()),
        };
        let mends = made.iter().filter_map(|&at| self.items.get(at)).flat_map(|item| item.mends.clone()).collect();
        let step = Step::Accept { mends, words };
        let refused = items.len() - made.len();
        let told = self.change(&outcome, decisions, step);
        Ok(if refused > 0 { format!("{told}; {refused} not made, because they do harm or mend nothing") } else { told })
    }

    /// Decides that fixes are not wanted. [`Review::save`] lets the baseline remember why.
    ///
    /// # Errors
    ///
    /// Where there is no reason, or a fix is not open.
    pub fn reject(&mut self, items: &[usize], reason: &str) -> Result<String, Failure> {
        items.iter().try_for_each(|&item| self.open_item(item))?;
        let reason = reason.split_whitespace().collect::<Vec<_>>().join(" ");
        if reason.is_empty() {
            return Err(Failure::new("a rejected fix needs a reason").help("say it in a few words for your colleagues"));
        }
        let mends = items.iter().filter_map(|&at| self.items.get(at)).flat_map(|item| item.mends.clone()).collect();
        let step = Step::Reject { mends, reason: reason.clone() };
        let told = step.to_string();
        self.decide(items, &Decision::Rejected(reason), step);
        Ok(told)
    }

    /// Puts fixes off.
    ///
    /// # Errors
    ///
    /// Where a fix is not open.
    pub fn put_off(&mut self, items: &[usize]) -> Result<String, Failure> {
        items.iter().try_for_each(|&item| self.open_item(item))?;
        let mends = items.iter().filter_map(|&at| self.items.get(at)).flat_map(|item| item.mends.clone()).collect();
        let step = Step::Later { mends };
        let told = step.to_string();
        self.decide(items, &Decision::Later, step);
        Ok(told)
    }

    fn decide(&mut self, items: &[usize], decision: &Decision, step: Step) {
        let mut decisions = self.now.decisions.clone();
        decisions.extend(items.iter().map(|&at| (at, decision.clone())));
        let mut steps = self.now.steps.clone();
        steps.push(step);
        let next = State { decisions, steps, ..self.now.clone() };
        self.past.push(std::mem::replace(&mut self.now, next));
    }

    /// Makes an edit of the person's own; says what it changes in the findings.
    ///
    /// # Errors
    ///
    /// Where it cannot be made, or the map would not load in Autoware any more.
    pub fn edit(&mut self, edit: &HandEdit) -> Result<String, Failure> {
        let plane = self.plane(self.now.with_projector_file);
        let fix = edit.fix(&self.now.map, &self.now.osm, &plane.0)?;
        let osm = applied(&self.now.osm, &fix).map_err(|error| unreadable(&error))?;
        let osm = osm.ok_or_else(|| Failure::new(format!("cannot be made: {}", fix.title)))?;
        let left = crate::fix::Judge::whole(&self.judge(&plane), &osm)?;
        let breaks = |one: &&&Diagnostic| one.code.starts_with("load/") && one.severity == Severity::Error;
        let broken = new_findings(&self.now.left, &left);
        let broken = broken.iter().find(breaks);
        if let Some(broken) = broken {
            return Err(Failure::new(format!("not made, the map would not load: {}", broken.finding.message)));
        }
        let (decisions, step) = (self.now.decisions.clone(), Step::Edit(edit.clone()));
        let with_projector_file = self.now.with_projector_file;
        let (osm, left, made, refused) = (Arc::new(osm), Arc::new(left), Vec::new(), Vec::new());
        Ok(self.change(&Outcome { osm, left, with_projector_file, made, refused }, decisions, step))
    }

    /// Takes another state of the map; says what that changes in the findings.
    fn change(&mut self, outcome: &Outcome, decisions: BTreeMap<usize, Decision>, step: Step) -> String {
        let Outcome { osm, left, with_projector_file, .. } = outcome;
        let (osm, left, with_projector_file) = (Arc::clone(osm), Arc::clone(left), *with_projector_file);
        let [before, after] = [counts(&self.now.left), counts(&left)];
        let map = Arc::new(from_osm(&osm, &self.plane(with_projector_file).0).map);
        let mut steps = self.now.steps.clone();
        let words = step.to_string();
        steps.push(step);
        let next = State { osm, map, left, with_projector_file, decisions, steps };
        self.past.push(std::mem::replace(&mut self.now, next));
        self.forget_far_past();
        self.tried.clear();
        self.list();
        let difference = |at: usize, word: &str| {
            let [before, after] = [before, after].map(|counts| counts.get(at).copied().unwrap_or_default());
            (before != after).then(|| format!("{word} {before} → {after}"))
        };
        let changes: Vec<String> = [difference(0, "errors"), difference(1, "warnings")].into_iter().flatten().collect();
        if changes.is_empty() { words } else { format!("{words} ({})", changes.join(", ")) }
    }

    /// Lets the oldest states go where all together would take too much memory.
    fn forget_far_past(&mut self) {
        let text: usize = self.now.osm.sources.iter().map(|source| source.text.len()).sum();
        let most = (UNDO_TEXT / text.max(1)).max(1);
        let mut maps = 0;
        let mut last: Option<&Arc<OsmData>> = Some(&self.now.osm);
        let keep = self.past.iter().rev().take_while(|state| {
            maps += usize::from(!last.replace(&state.osm).is_some_and(|last| Arc::ptr_eq(last, &state.osm)));
            maps <= most
        });
        let gone = self.past.len() - keep.count();
        self.past.drain(..gone);
    }

    /// Goes back to the state before the last step; says which that was.
    ///
    /// # Errors
    ///
    /// Where there is none.
    pub fn undo(&mut self) -> Result<String, Failure> {
        let nothing = || Failure::new("there is nothing to undo");
        let before = self.past.last().ok_or_else(nothing)?;
        if self.missing.is_none() && before.with_projector_file != self.now.with_projector_file {
            return Err(Failure::new(format!("{INFO} is written already")).help("remove the file to do without it"));
        }
        let before = self.past.pop().ok_or_else(nothing)?;
        let undone = std::mem::replace(&mut self.now, before);
        self.tried.clear();
        self.list();
        Ok(format!("undone: {}", undone.steps.last().map(ToString::to_string).unwrap_or_default()))
    }
}

impl Item {
    /// What the fix does, in one line.
    pub fn title(&self) -> &str {
        self.finding.finding.fix.as_ref().map_or("", |fix| &fix.title)
    }
}
