//! Who may go from which lanelet to which by the real Lanelet2 library, and what a fix changes of it.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use lanewright::api::{FixOptions, fix};
use lanewright::fix::Scope;
use lanewright::osm::{ElementKind, OsmData};

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

/// A map that was mended: its files before and after, and what the findings name that were mended.
pub struct MendedFile {
    pub before: PathBuf,
    pub after: PathBuf,
    /// The lanelets that each finding names, and those along lines that it names.
    about: Vec<BTreeSet<String>>,
    /// The lanelets that there are before and after.
    common: BTreeSet<String>,
}

impl MendedFile {
    /// Mends a copy of a map in a directory of its own; `None` for a map that cannot be read. The library places nodes by latitude and
    /// longitude: those that have none get some.
    pub fn of(map: &Path, dir: &Path, scope: Scope) -> Option<Self> {
        std::fs::create_dir_all(dir).unwrap();
        let (before, after) = (dir.join("before.osm"), dir.join("after.osm"));
        std::fs::copy(map, &before).unwrap();
        let fixed = fix(before.clone(), &FixOptions { scope, ..FixOptions::default() }).ok()?;
        let osm = &fixed.mended.osm;
        for (file, osm) in [(&before, &fixed.loaded.osm), (&after, osm)] {
            std::fs::write(file, placed(&osm.sources[0].text)).unwrap();
        }
        let lanelets = |osm: &OsmData| -> BTreeSet<String> {
            let all = osm.relations.iter().filter(|one| one.tags.is("type", "lanelet"));
            all.map(|one| one.id.to_string()).collect()
        };
        let old = &fixed.loaded.osm;
        let named = |about: &Vec<(ElementKind, i64)>| -> BTreeSet<String> {
            let is_meant = |one: &&lanewright::osm::Relation| {
                let is_member = |key: &(ElementKind, i64)| one.members.iter().any(|it| (it.kind, it.id) == *key);
                about.contains(&(ElementKind::Relation, one.id))
                    || about.iter().any(|key| key.0 == ElementKind::Way && is_member(key))
            };
            let all = old.relations.iter().chain(&osm.relations).filter(is_meant);
            all.map(|one| one.id.to_string()).collect()
        };
        let about = fixed.mended.about.iter().map(named).collect();
        Some(Self { about, common: &lanelets(old) & &lanelets(osm), before, after })
    }

    /// Whether a finding that was mended names both lanelets of a route.
    pub fn is_about(&self, [_, _, from, to]: &[String; 4]) -> bool {
        let both = [from, to].map(|id| bare(id).to_owned());
        self.about.iter().any(|named| both.iter().all(|id| named.contains(id)))
    }

    /// The routes that are not the same before and after although no mended finding names both lanelets. Where a lanelet was cut or
    /// merged, what leads through its pieces is one route between those that there are before and after.
    pub fn unasked(&self, before: &Routes, after: &Routes) -> Vec<String> {
        // Who drove against the direction of a lanelet may drive on one of their own now: it is no longer one of the steps.
        let gone: Routes =
            before.difference(after).filter(|route| route[1] == "pass" && route[2].ends_with('-')).cloned().collect();
        let passes = |routes: &Routes, [who, _, from, to]: &[String; 4]| {
            [from, to].into_iter().all(|id| routes.contains(&[who.clone(), "pass".into(), id.clone(), id.clone()]))
        };
        let [before, after] = [before, after].map(|routes| self.between_common(routes, &gone));
        let lost = before.difference(&after).map(|route| ("lost", route));
        let won = after.difference(&before).map(|route| ("won", route));
        // Where somebody may no longer use a lanelet at all, the routes to and from it are not told, too.
        let is_told = |route: &[String; 4]| route[1] == "pass" || passes(&before, route) && passes(&after, route);
        let changed = lost.chain(won).filter(|(_, route)| is_told(route) && !self.is_about(route));
        changed.map(|(what, route)| format!("{what}: {}", route.join(" "))).collect()
    }

    /// The routes between lanelets that there are before and after; those that lead on through others are one.
    fn between_common(&self, routes: &Routes, gone: &Routes) -> Routes {
        let is_common = |who: &String, id: &String| {
            self.common.contains(bare(id)) && !gone.contains(&[who.clone(), "pass".into(), id.clone(), id.clone()])
        };
        let mut next: BTreeMap<(&str, &String), Vec<&String>> = BTreeMap::new();
        for [who, _, from, to] in routes.iter().filter(|route| route[1] == "following") {
            next.entry((who, from)).or_default().push(to);
        }
        let between = |[who, _, from, to]: &[String; 4]| is_common(who, from) && is_common(who, to);
        let mut common: Routes = routes.iter().filter(|route| between(route)).cloned().collect();
        let leads_off =
            |[who, how, from, to]: &&[String; 4]| how == "following" && is_common(who, from) && !is_common(who, to);
        for [who, how, from, to] in routes.iter().filter(leads_off) {
            let (mut open, mut seen) = (vec![to], BTreeSet::from([to]));
            while let Some(at) = open.pop() {
                for &to in next.get(&(who.as_str(), at)).into_iter().flatten() {
                    if is_common(who, to) {
                        common.insert([who.clone(), how.clone(), from.clone(), to.clone()]);
                    } else if seen.insert(to) {
                        open.push(to);
                    }
                }
            }
        }
        common
    }
}

fn bare(id: &str) -> &str {
    id.trim_end_matches('-')
}

/// The text of a map of which nodes without latitude and longitude have those of their `local_x` and `local_y` near the equator.
fn placed(text: &str) -> String {
    const DEGREE: f64 = 111_320.0;
    let mut whole = String::new();
    for (at, part) in text.split("<node ").enumerate() {
        if at > 0 {
            whole += "<node ";
        }
        let local = |key: &str| -> Option<f64> {
            let (_, rest) = part.split_once(&format!("k=\"{key}\" v=\""))?;
            rest.split_once('"')?.0.parse().ok()
        };
        let own = part.split("</node>").next().unwrap_or_default();
        match (own.contains("lat=\"\""), local("local_x"), local("local_y")) {
            (true, Some(x), Some(y)) => {
                let part = part.replacen("lat=\"\"", &format!("lat=\"{:.11}\"", y / DEGREE), 1);
                whole += &part.replacen("lon=\"\"", &format!("lon=\"{:.11}\"", x / DEGREE), 1);
            }
            _ => whole += part,
        }
    }
    whole
}

/// What mending did to the routes of a map.
pub struct Changed {
    pub map: PathBuf,
    /// How many routes there were.
    pub before: usize,
    /// How many were lost and won in all.
    pub lost: usize,
    pub won: usize,
    /// Those of which no mended finding speaks.
    pub unasked: Vec<String>,
}

/// Mends each map and holds the real library's routes before and after against each other.
pub fn changes(maps: &[PathBuf], scope: Scope) -> Option<Vec<Changed>> {
    let dir = tempfile::tempdir().unwrap();
    let mended = maps
        .iter()
        .enumerate()
        .filter_map(|(at, map)| Some((map, MendedFile::of(map, &dir.path().join(at.to_string()), scope)?)));
    let mended: Vec<(&PathBuf, MendedFile)> = mended.collect();
    let files: Vec<PathBuf> = mended.iter().flat_map(|(_, one)| [one.before.clone(), one.after.clone()]).collect();
    let routes = real(&files)?;
    let changed = mended.iter().zip(routes.chunks(2)).filter_map(|((map, one), pair)| {
        let [Some(before), Some(after)] = pair else { return None };
        Some(Changed {
            map: map.to_path_buf(),
            before: before.len(),
            lost: before.difference(after).count(),
            won: after.difference(before).count(),
            unasked: one.unasked(before, after),
        })
    });
    Some(changed.collect())
}

/// What changed unasked, by map.
pub fn changed_unasked(maps: &[PathBuf], scope: Scope) -> Option<Vec<String>> {
    let changed = changes(maps, scope)?.into_iter().filter(|one| !one.unasked.is_empty());
    Some(changed.map(|one| format!("{}: {}", one.map.display(), one.unasked.join(", "))).collect())
}
