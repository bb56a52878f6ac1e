//! The cross-section of every way. A way without tagged lanes takes those of the road that it continues.
//!
//! Mappers who tag lanes often leave out the short piece between two carriageways, on a bridge or through a crossing. If the
//! lanes before and after it are the same, it has them, too. A short piece may lie between roads of another name or class.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::tags::cross_section::{
    Customs, Lane, SectionReading, StripKind, Travel, WayFacts, layout, tells_lanes,
};
use crate::builder::tags::road_class::{RoadClass, is_roundabout};
use crate::builder::tags::speed::unread;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::{Point, Vector, angle_between};
use crate::parallel::Finely;

use super::End;
use super::access::{Access, Drivable};
use super::turn_angle::STRAIGHT;

/// How many consecutive ways are searched for tagged lanes.
const WAYS_MOST: usize = 4;
/// A way no longer than this, metres, may be the piece of a road through a crossing.
const PIECE: f64 = 60.0;

/// The cross-section of each way from its own tags.
pub(super) struct WaySections<'d, 'a> {
    drivable: &'d [Drivable<'a>],
    customs: Customs<'d>,
    layouts: Vec<(SectionReading, Vec<Finding>)>,
}

impl<'d, 'a> WaySections<'d, 'a> {
    /// Reads the tags of all ways.
    pub fn read(drivable: &'d [Drivable<'a>], customs: Customs<'d>) -> Self {
        let mut sections = Self { drivable, customs, layouts: Vec::new() };
        sections.layouts = drivable.par_iter().finely().map(|way| sections.layout(way, None)).collect();
        sections
    }

    fn layout(&self, way: &Drivable<'a>, continued: Option<&[Lane]>) -> (SectionReading, Vec<Finding>) {
        let facts = WayFacts {
            way: way.way.id,
            tags: &way.way.tags,
            class: way.class,
            link: way.link,
            bus_road: way.access == Access::Bus,
            side: self.customs.side,
            usual: self.customs.defaults(way.class, way.link),
            continued,
        };
        let mut notes = Vec::new();
        if let Some(tag) = unread(facts.tags, self.customs.country) {
            let message = format!("way {}: {tag} is no limit that is known; it is passed over", facts.way);
            notes.push(Finding::new("speed-unread", Subject::Way(facts.way), message).graded(Severity::Info));
        }
        (layout(&facts, &mut notes), notes)
    }

    /// The cross-section of every way in `used`, by the way's index.
    pub fn of_ways(
        mut self,
        used: impl Iterator<Item = usize>,
        positions: &FxHashMap<i64, Point>,
        notes: &mut Vec<Finding>,
    ) -> FxHashMap<usize, SectionReading> {
        let mut used: Vec<usize> = used.collect();
        used.sort_unstable();
        used.dedup();
        let graph = WayGraph::new(self.drivable, positions, used.iter().map(|&i| (i, &self.layouts[i].0)));
        let again = used.par_iter().finely().filter_map(|&i| {
            let lanes = graph.continued(i)?;
            Some((i, self.layout(&self.drivable[i], Some(&lanes))))
        });
        let again: Vec<_> = again.collect();
        for (i, layout) in again {
            self.layouts[i] = layout;
        }
        let of_used = self.layouts.into_iter().enumerate().filter(|(i, _)| used.binary_search(i).is_ok());
        of_used
            .map(|(i, (layout, own_notes))| {
                notes.extend(own_notes);
                (i, layout)
            })
            .collect()
    }
}

/// The ways by index, and how they meet end to end.
struct WayGraph<'a> {
    ways: FxHashMap<usize, WayLanes<'a>>,
    /// The ways that begin or end at each node.
    ends: FxHashMap<i64, Vec<(usize, End)>>,
}

/// What a way shares with the ways that continue it.
#[derive(PartialEq)]
struct WayKind<'a> {
    class: RoadClass,
    link: bool,
    access: Access,
    roundabout: bool,
    name: Option<&'a str>,
}

impl WayKind<'_> {
    /// Whether two ways differ only in name and class.
    fn like(&self, other: &Self) -> bool {
        (self.link, self.access, self.roundabout) == (other.link, other.access, other.roundabout)
    }
}

struct WayLanes<'a> {
    kind: WayKind<'a>,
    nodes: [i64; 2],
    /// The directions in which the way leads beyond its ends.
    outward: [Vector; 2],
    /// Metres.
    length: f64,
    /// Left to right along the way; defaults if none are tagged.
    lanes: Vec<Lane>,
    tagged: bool,
}

impl<'a> WayGraph<'a> {
    fn new<'l>(
        drivable: &[Drivable<'a>],
        positions: &FxHashMap<i64, Point>,
        layouts: impl Iterator<Item = (usize, &'l SectionReading)>,
    ) -> Self {
        let (mut ways, mut ends) = (FxHashMap::default(), FxHashMap::<i64, Vec<(usize, End)>>::default());
        for (i, layout) in layouts {
            let Drivable { way, class, link, access } = &drivable[i];
            let (Some(&first), Some(&last)) = (way.nodes.first(), way.nodes.last()) else { continue };
            if first == last {
                continue;
            }
            let tags = &way.tags;
            let name = tags.get("name").or_else(|| tags.get("ref"));
            let kind = WayKind { class: *class, link: *link, access: *access, roundabout: is_roundabout(tags), name };
            let lanes = layout.section.driven().map(|(_, strip)| (strip.kind, strip.travel)).collect();
            let points: Vec<Point> = way.nodes.iter().filter_map(|node| positions.get(node).copied()).collect();
            let steps: Vec<Vector> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let outward = [steps.first().map(|step| -step), steps.last().copied()].map(Option::unwrap_or_default);
            let length = steps.iter().map(Vector::norm).sum();
            let nodes = [first, last];
            ways.insert(i, WayLanes { kind, nodes, outward, length, lanes, tagged: tells_lanes(tags) });
            ends.entry(first).or_default().push((i, End::Start));
            ends.entry(last).or_default().push((i, End::End));
        }
        Self { ways, ends }
    }

    /// The lanes that an untagged way takes: those of the road that it continues, if they are the same before and after it.
    fn continued(&self, way: usize) -> Option<Vec<Lane>> {
        let own = self.ways.get(&way).filter(|own| !own.tagged)?;
        let [before, after] = End::BOTH.map(|end| self.tagged_beyond(way, end));
        before.filter(|lanes| after.as_ref() == Some(lanes) && directions(lanes) == directions(&own.lanes))
    }

    /// The lanes of the first tagged way beyond one end, left to right along this way.
    fn tagged_beyond(&self, mut way: usize, mut end: End) -> Option<Vec<Lane>> {
        let mut reversed = false;
        for _ in 0..WAYS_MOST {
            let (next, entry) = self.beyond(way, end)?;
            reversed ^= entry == end;
            let WayLanes { lanes, tagged, .. } = &self.ways[&next];
            if *tagged {
                return Some(if reversed { reversed_lanes(lanes) } else { lanes.clone() });
            }
            (way, end) = (next, entry.other());
        }
        None
    }

    /// The way that continues another beyond an end, and the end at which it does; `None` if there are several.
    fn beyond(&self, way: usize, end: End) -> Option<(usize, End)> {
        let own = &self.ways[&way];
        let next = self.ends[&own.nodes[end]].iter().copied().filter(|&(other, entry)| {
            let lanes = &self.ways[&other].lanes;
            let along = if entry == end { directions(&reversed_lanes(lanes)) } else { directions(lanes) };
            other != way && along == directions(&own.lanes)
        });
        let of_kind = only(next.clone().filter(|(other, _)| self.ways[other].kind == own.kind));
        let goes_straight_on = |&(other, entry): &(usize, End)| {
            let WayLanes { kind, outward, .. } = &self.ways[&other];
            let turn = angle_between(own.outward[end], -outward[entry]).abs().to_degrees();
            turn <= STRAIGHT && kind.like(&own.kind)
        };
        of_kind.or_else(|| only(next.filter(goes_straight_on)).filter(|_| own.length <= PIECE))
    }
}

/// The only item.
fn only<T>(mut items: impl Iterator<Item = T>) -> Option<T> {
    let first = items.next();
    first.filter(|_| items.next().is_none())
}

/// The lanes as seen from the other end.
fn reversed_lanes(lanes: &[Lane]) -> Vec<Lane> {
    let turned = |&(kind, travel): &(StripKind, Travel)| match travel {
        Travel::Forward => (kind, Travel::Backward),
        Travel::Backward => (kind, Travel::Forward),
        Travel::Both => (kind, Travel::Both),
    };
    lanes.iter().rev().map(turned).collect()
}

/// Whether any lane leads along the way, and whether any leads against it.
fn directions(lanes: &[Lane]) -> [bool; 2] {
    [Travel::Backward, Travel::Forward].map(|other| lanes.iter().any(|(_, travel)| *travel != other))
}
