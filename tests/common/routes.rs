//! Who may go from which lanelet to which by the real Lanelet2 library, and what a fix changes of it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use lanewright::api::{CheckOptions, FixOptions, check, fix};
use lanewright::diagnostic::Subject;
use lanewright::fix::Scope;

use super::needs::python;
use super::root;

/// Participant, relation, from, to; a lanelet against its direction has its id with a minus after it.
pub type Routes = BTreeSet<[String; 4]>;

/// The routes of each map, `None` for one that does not load; `None` without a Python.
pub fn real(maps: &[PathBuf]) -> Option<Vec<Option<Routes>>> {
    let mut python = python()?;
    python.arg(root().join("tests/checking/routing_pairs.py"));
    let mut running = python.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
    let paths: Vec<&Path> = maps.iter().map(PathBuf::as_path).collect();
    let mut stdin = running.stdin.take().unwrap();
    stdin.write_all(serde_json::to_string(&paths).unwrap().as_bytes()).unwrap();
    drop(stdin);
    let output = running.wait_with_output().unwrap();
    assert!(output.status.success(), "the Lanelet2 library gave no answer");
    let answers: Vec<Option<BTreeMap<String, Vec<[String; 3]>>>> = serde_json::from_slice(&output.stdout).unwrap();
    let routes = |one: BTreeMap<String, Vec<[String; 3]>>| -> Routes {
        let of = |(who, found): (String, Vec<[String; 3]>)| {
            found.into_iter().map(move |[how, from, to]| [who.clone(), how, from, to])
        };
        one.into_iter().flat_map(of).collect()
    };
    Some(answers.into_iter().map(|answer| answer.map(routes)).collect())
}

/// A map that was mended: its files before and after, and which lanelets the findings name that were mended.
pub struct MendedFile {
    pub before: PathBuf,
    pub after: PathBuf,
    about: Vec<BTreeSet<String>>,
}

impl MendedFile {
    /// Mends a copy of a map in a directory of its own; `None` for a map that cannot be read.
    pub fn of(map: &Path, dir: &Path, scope: Scope) -> Option<Self> {
        std::fs::create_dir_all(dir).unwrap();
        let (before, after) = (dir.join("before.osm"), dir.join("after.osm"));
        std::fs::copy(map, &before).unwrap();
        let found = check(before.clone(), CheckOptions::default()).ok()?;
        let fixed = fix(before.clone(), &FixOptions { scope, ..FixOptions::default() }).ok()?;
        let text = &fixed.mended.osm.sources[0].text;
        std::fs::write(&after, text.as_bytes()).unwrap();
        let lanelet = |subject: Subject| match subject {
            Subject::Lanelet(id) => Some(id.to_string()),
            _ => None,
        };
        let is_done = |code: &str, subject: Subject| {
            fixed.mended.done.iter().any(|mend| mend.code == code && mend.subject == subject)
        };
        let found = found.sorted.left.iter().filter(|one| is_done(&one.code, one.finding.subject));
        let about = found.map(|one| {
            let related = one.finding.related.iter().map(|related| related.subject);
            std::iter::once(one.finding.subject).chain(related).filter_map(lanelet).collect()
        });
        Some(Self { about: about.collect(), before, after })
    }

    /// Whether a finding that was mended names both lanelets of a route.
    pub fn is_about(&self, [_, _, from, to]: &[String; 4]) -> bool {
        let both = [from, to].map(|id| id.trim_end_matches('-').to_owned());
        self.about.iter().any(|named| both.iter().all(|id| named.contains(id)))
    }

    /// The routes that are not the same before and after although no mended finding names both lanelets.
    pub fn unasked(&self, before: &Routes, after: &Routes) -> Vec<String> {
        let lost = before.difference(after).map(|route| ("lost", route));
        let won = after.difference(before).map(|route| ("won", route));
        let changed = lost.chain(won).filter(|(_, route)| !self.is_about(route));
        changed.map(|(what, route)| format!("{what}: {}", route.join(" "))).collect()
    }
}

/// Mends each map and holds the real library's routes before and after against each other: what changed unasked, by map.
pub fn changed_unasked(maps: &[PathBuf], scope: Scope) -> Option<Vec<String>> {
    let dir = tempfile::tempdir().unwrap();
    let mended = maps
        .iter()
        .enumerate()
        .filter_map(|(at, map)| Some((map, MendedFile::of(map, &dir.path().join(at.to_string()), scope)?)));
    let mended: Vec<(&PathBuf, MendedFile)> = mended.collect();
    let files: Vec<PathBuf> = mended.iter().flat_map(|(_, one)| [one.before.clone(), one.after.clone()]).collect();
    let routes = real(&files)?;
    let mut changed = Vec::new();
    for ((map, one), pair) in mended.iter().zip(routes.chunks(2)) {
        let [Some(before), Some(after)] = pair else { continue };
        let unasked = one.unasked(before, after);
        if !unasked.is_empty() {
            changed.push(format!("{}: {}", map.display(), unasked.join(", ")));
        }
    }
    Some(changed)
}
