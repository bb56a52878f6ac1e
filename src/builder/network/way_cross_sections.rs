//! The cross-section of every way; where its tags tell no lanes, that of the road which it continues.
//!
//! Who tags lanes often leaves out the short piece between two carriageways, over a bridge, through a crossing: there the
//! road has as many lanes as before and behind.

use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::builder::tags::cross_section::{
    Customs, Lane, SectionReading, StripKind, Travel, WayFacts, layout, tells_lanes,
};
use crate::builder::tags::road_class::{RoadClass, is_roundabout};
use crate::diagnostic::Finding;
use crate::parallel::Finely;

use super::End;
use super::access::{Access, Drivable};

/// So many ways without tagged lanes, one behind the other, are continued from one tagged way to the next.
const WAYS_MOST: usize = 4;

/// What the tags of each way tell by themselves.
pub(super) struct Told<'d, 'a> {
    drivable: &'d [Drivable<'a>],
    customs: Customs<'d>,
    layouts: Vec<(SectionReading, Vec<Finding>)>,
}

impl<'d, 'a> Told<'d, 'a> {
    /// Reads the tags of all ways.
    pub fn read(drivable: &'d [Drivable<'a>], customs: Customs<'d>) -> Self {
        let mut told = Self { drivable, customs, layouts: Vec::new() };
        told.layouts = drivable.par_iter().finely().map(|way| told.layout(way, None)).collect();
        told
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
        (layout(&facts, &mut notes), notes)
    }

    /// The cross-section of every way that is used, by the way's index.
    pub fn layouts(
        mut self,
        used: impl Iterator<Item = usize>,
        notes: &mut Vec<Finding>,
    ) -> FxHashMap<usize, SectionReading> {
        let mut used: Vec<usize> = used.collect();
        used.sort_unstable();
        used.dedup();
        let streets = Streets::new(self.drivable, used.iter().map(|&i| (i, &self.layouts[i].0)));
        let again = used.par_iter().finely().filter_map(|&i| {
            let lanes = streets.continued(i)?;
            Some((i, self.layout(&self.drivable[i], Some(&lanes))))
        });
        let again: Vec<_> = again.collect();
        for (i, told) in again {
            self.layouts[i] = told;
        }
        let of_used = self.layouts.into_iter().enumerate().filter(|(i, _)| used.binary_search(i).is_ok());
        let noted = |(i, (layout, own)): (usize, (SectionReading, Vec<Finding>))| {
            notes.extend(own);
            (i, layout)
        };
        of_used.map(noted).collect()
    }
}

/// The ways as far as their tags tell, and how they meet end to end.
struct Streets<'a> {
    ways: FxHashMap<usize, Street<'a>>,
    /// By node: the ways that begin or end there.
    ends: FxHashMap<i64, Vec<(usize, End)>>,
}

/// What a way has in common with the ways that continue it.
#[derive(PartialEq)]
struct Kind<'a> {
    class: RoadClass,
    link: bool,
    access: Access,
    roundabout: bool,
    name: Option<&'a str>,
}

struct Street<'a> {
    kind: Kind<'a>,
    nodes: [i64; 2],
    /// Left to right along the way; of none that are tagged, what they are by default.
    lanes: Vec<Lane>,
    tagged: bool,
}

impl<'a> Streets<'a> {
    fn new<'l>(drivable: &[Drivable<'a>], layouts: impl Iterator<Item = (usize, &'l SectionReading)>) -> Self {
        let (mut ways, mut ends) = (FxHashMap::default(), FxHashMap::<i64, Vec<(usize, End)>>::default());
        for (i, layout) in layouts {
            let Drivable { way, class, link, access } = &drivable[i];
            let (Some(&first), Some(&last)) = (way.nodes.first(), way.nodes.last()) else { continue };
            if first == last {
                continue;
            }
            let tags = &way.tags;
            let name = tags.get("name").or_else(|| tags.get("ref"));
            let kind = Kind { class: *class, link: *link, access: *access, roundabout: is_roundabout(tags), name };
            let lanes = layout.section.driven().map(|(_, strip)| (strip.kind, strip.travel)).collect();
            ways.insert(i, Street { kind, nodes: [first, last], lanes, tagged: tells_lanes(tags) });
            ends.entry(first).or_default().push((i, End::Start));
            ends.entry(last).or_default().push((i, End::End));
        }
        Self { ways, ends }
    }

    /// The lanes of the road that a way without tagged ones continues, if it has the same on both sides.
    fn continued(&self, way: usize) -> Option<Vec<Lane>> {
        let street = self.ways.get(&way).filter(|street| !street.tagged)?;
        let [before, behind] = End::BOTH.map(|end| self.tagged_beyond(way, end));
        before.filter(|lanes| behind.as_ref() == Some(lanes) && directions(lanes) == directions(&street.lanes))
    }

    /// The lanes of the first tagged way beyond one end, left to right along the way at hand.
    fn tagged_beyond(&self, mut way: usize, mut end: End) -> Option<Vec<Lane>> {
        let mut reversed = false;
        for _ in 0..WAYS_MOST {
            let (next, at) = self.beyond(way, end)?;
            reversed ^= at == end;
            let street = &self.ways[&next];
            if street.tagged {
                return Some(if reversed { against(&street.lanes) } else { street.lanes.clone() });
            }
            (way, end) = (next, at.other());
        }
        None
    }

    /// The one way that continues another beyond an end, and with which of its own ends; `None` if there are several.
    fn beyond(&self, way: usize, end: End) -> Option<(usize, End)> {
        let street = &self.ways[&way];
        let node = street.nodes[usize::from(end == End::End)];
        let mut next = self.ends[&node].iter().copied().filter(|&(other, at)| {
            let lanes = &self.ways[&other].lanes;
            let along = if at == end { directions(&against(lanes)) } else { directions(lanes) };
            other != way && self.ways[&other].kind == street.kind && along == directions(&street.lanes)
        });
        next.next().filter(|_| next.next().is_none())
    }
}

/// Lanes as they are seen from the other end.
fn against(lanes: &[Lane]) -> Vec<Lane> {
    let turned = |&(kind, travel): &(StripKind, Travel)| match travel {
        Travel::Forward => (kind, Travel::Backward),
        Travel::Backward => (kind, Travel::Forward),
        Travel::Both => (kind, Travel::Both),
    };
    lanes.iter().rev().map(turned).collect()
}

/// Whether lanes lead along the way, and whether against it.
fn directions(lanes: &[Lane]) -> [bool; 2] {
    [Travel::Backward, Travel::Forward].map(|other| lanes.iter().any(|(_, travel)| *travel != other))
}
