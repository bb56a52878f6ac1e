//! Maps of which only a part is judged again.

use std::cell::Cell;
use std::convert::Infallible;

use super::{diagnostic, read, wants_ele};
use crate::diagnostic::{Diagnostic, Subject};
use crate::fix::{Judge, mend};
use crate::osm::{Node, OsmData};

/// How many places there are, half a kilometre apart, and how many nodes each has.
const PLACES: i64 = 100;
const NODES: i64 = 16;

/// Wants `ele` of every node; in one place a node must not have it, which is said of the place.
struct Places {
    /// How many nodes it has looked at.
    looked: Cell<usize>,
    /// Whether it sees that of the whole map only.
    is_blind: bool,
}

impl Places {
    fn found(&self, osm: &OsmData, is_whole: bool) -> Vec<Diagnostic> {
        self.looked.set(self.looked.get() + osm.nodes.len());
        let mut found = Vec::new();
        for node in &osm.nodes {
            let (place, at) = (node.id / NODES, node.id % NODES);
            let local = Some(crate::geometry::Point::new(500.0 * place as f64, 0.0));
            if !node.tags.has("ele") {
                found.push(Diagnostic { local, ..wants_ele(Subject::Point(node.id)) });
            } else if (place, at) == (PLACES / 2, 5) && (is_whole || !self.is_blind) {
                found.push(Diagnostic { local, ..diagnostic("place/fault", Subject::Point(1_000_000 + place), None) });
            }
        }
        found
    }
}

impl Judge for &Places {
    type Error = Infallible;

    fn whole(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Infallible> {
        Ok(self.found(osm, true))
    }

    fn part(&self, osm: &OsmData) -> Result<Vec<Diagnostic>, Infallible> {
        Ok(self.found(osm, false))
    }

    fn place(&self, node: &Node) -> Option<[f64; 2]> {
        node.position.map(|place| [500.0 * place.lon, 0.0])
    }
}

fn places() -> OsmData {
    let node = |id: i64| format!("<node id=\"{id}\" lat=\"0\" lon=\"{}\"/>\n", id / NODES);
    let nodes: String = (NODES..NODES * (PLACES + 1)).map(node).collect();
    read(&format!("<osm version=\"0.6\">\n{nodes}</osm>\n"))
}

#[test]
fn what_is_far_from_a_change_is_not_judged_again() {
    let judge = Places { looked: Cell::new(0), is_blind: false };
    let mended = mend(places(), false, &judge).unwrap();
    let all = PLACES * NODES;
    assert_eq!((mended.done.len() as i64, mended.refused.len()), (all - 1, 1));
    // As it was, with all fixes, as it is in the end; what is left is the one place, halved four times.
    let most = 4 * all as usize;
    assert!(judge.looked.get() <= most, "{} nodes looked at, of {all}", judge.looked.get());
}

#[test]
fn what_only_the_whole_map_shows_is_not_kept() {
    let judge = Places { looked: Cell::new(0), is_blind: true };
    // One node lacks `ele` at first, the one that must not have it, so that its place alone is judged.
    let mut edits = places().sources[0].text.clone();
    for id in (NODES..NODES * (PLACES + 1)).filter(|id| *id != PLACES / 2 * NODES + 5) {
        let bare = format!("<node id=\"{id}\" lat=\"0\" lon=\"{}\"/>", id / NODES);
        edits = edits.replace(&bare, &bare.replace("/>", "><tag k=\"ele\" v=\"0\"/></node>"));
    }
    let mended = mend(read(&edits), false, &judge).unwrap();
    assert_eq!((mended.done.len(), mended.refused.len()), (0, 1));
    assert_eq!(mended.left.len(), 1, "no error has come");
}
