//! Writes what a review has decided: the map by the smallest change of its text, the rejected fixes into the baseline.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::diagnostic::Subject;
use crate::fix::Judge;
use crate::osm::Source;
use crate::report::failure::Failure;
use crate::text::{counted, unified_diff};

use super::{Decision, Review, Step, counts, inputs};
use crate::api::checked::write_baseline;
use crate::api::fixed::{Edits, ProjectorFile};

impl Review {
    /// What was rejected: code, subject and reason.
    fn rejected(&self) -> BTreeMap<(String, Subject), String> {
        let decided = self.now.decisions.iter().filter_map(|(at, decision)| match decision {
            Decision::Rejected(reason) => Some((self.items.get(*at)?, reason)),
            _ => None,
        });
        let each = decided.flat_map(|(item, reason)| item.mends.iter().map(move |mend| (mend, reason)));
        each.map(|(mend, reason)| ((mend.code.clone(), mend.subject), reason.clone())).collect()
    }

    /// The projector's file, where it was accepted and is not written yet.
    fn file_to_write(&self) -> Option<&ProjectorFile> {
        self.missing.as_ref().filter(|_| self.now.with_projector_file)
    }

    /// Whether the files differ from what was decided.
    pub fn is_unsaved(&self) -> bool {
        let texts = self.loaded.osm.sources.iter().zip(&self.now.osm.sources);
        let is_file_open = self.file_to_write().is_some();
        is_file_open || self.rejected() != self.remembered || texts.into_iter().any(|(old, new)| old.text != new.text)
    }

    /// What saving would change in the map's files, as a unified diff.
    pub fn diff(&self) -> String {
        let texts = self.loaded.osm.sources.iter().zip(&self.now.osm.sources);
        let changed = texts.filter(|(old, new)| old.text != new.text);
        let of_map = changed.map(|(old, new)| {
            let texts = [old, new].map(Source::as_written);
            unified_diff([&old.name, &new.name], [&texts[0], &texts[1]])
        });
        of_map.chain(self.file_to_write().map(ProjectorFile::diff)).collect()
    }

    /// Judges the map as a whole and writes what changed, all files or none; then the baseline. Says what was written.
    ///
    /// # Errors
    ///
    /// Where somebody else has saved the map since it was read, a file cannot be written, or the whole map has more errors than the
    /// review has told; nothing is written then.
    pub fn save(&mut self) -> Result<String, Failure> {
        let told = counts(&self.now.left);
        let plane = self.plane(self.now.with_projector_file);
        let left = self.judge(&plane).whole(&self.now.osm)?;
        let found = counts(&left);
        self.now.left = Arc::new(left);
        if found > told {
            self.tried.clear();
            self.list();
            return Err(Failure::new(
                "nothing was saved: judged as a whole, the map has errors that were not shown before",
            )
            .help("they are shown now; look at them and save again"));
        }
        let mut edits = Edits::between(&self.loaded, &self.now.osm);
        edits.files.extend(self.file_to_write().map(ProjectorFile::edited));
        edits.write()?;
        self.loaded.osm = self.now.osm.as_ref().clone();
        if self.file_to_write().is_some() {
            (self.loaded.projector, self.loaded.info) = plane;
            self.missing = None;
        }
        let mut words = vec![match edits.files.len() {
            0 => "the map is as it was".to_owned(),
            count => format!("{} written", counted(count, "file")),
        }];
        let rejected = self.rejected();
        if rejected != self.remembered {
            let mut known = inputs::read(&self.baseline_file)?;
            for ((code, subject), _) in self.remembered.iter().filter(|(key, _)| !rejected.contains_key(*key)) {
                known.forget(code, *subject);
            }
            for ((code, subject), reason) in &rejected {
                let is_same =
                    |one: &&crate::diagnostic::Diagnostic| one.code == *code && one.finding.subject == *subject;
                known.accept(code, *subject, self.now.left.iter().filter(is_same).count().max(1), reason);
            }
            write_baseline(&known, &self.baseline_file)?;
            words.push(format!("{} in {}", counted(rejected.len(), "rejected finding"), self.baseline_file.display()));
            self.remembered = rejected;
        }
        Ok(format!("saved: {}", words.join(", ")))
    }

    /// Reads the files again, because somebody else has saved them, and makes the unsaved steps on what they say now; gives those that
    /// could not be made.
    ///
    /// # Errors
    ///
    /// Where the files cannot be read; the review is what it was.
    pub fn reload(&mut self) -> Result<Vec<String>, Failure> {
        let mut fresh = Self::open(self.options.clone())?;
        let mut lost = Vec::new();
        for step in &self.now.steps {
            let of = |mends: &[crate::fix::Mend]| {
                let open = fresh.open_items();
                let mut items: Vec<usize> = mends.iter().filter_map(|mend| fresh.by_mend.get(mend).copied()).collect();
                items.sort_unstable();
                items.dedup();
                items.retain(|at| open.contains(at));
                items
            };
            let made = match step {
                Step::Accept { mends, .. } => match of(mends) {
                    items if items.is_empty() => continue,
                    items => fresh.accept(&items),
                },
                Step::Reject { mends, reason } => match of(mends) {
                    items if items.is_empty() => continue,
                    items => fresh.reject(&items, reason),
                },
                Step::Later { mends } => match of(mends) {
                    items if items.is_empty() => continue,
                    items => fresh.put_off(&items),
                },
                Step::Edit(edit) => fresh.edit(edit),
            };
            if let Err(failure) = made {
                lost.push(format!("{step}: {}", failure.message()));
            }
        }
        *self = fresh;
        Ok(lost)
    }

    /// Whether the files of the map are not what was read or written last.
    pub fn is_overtaken(&self) -> bool {
        let files = self.loaded.files.iter().zip(&self.loaded.osm.sources);
        files
            .into_iter()
            .any(|(file, source)| std::fs::read(file).is_ok_and(|bytes| bytes != source.as_written().as_bytes()))
    }
}
