//! The cross-section of every way. A way without tagged lanes takes those of the road that it continues.
//!
//! Mappers who tag lanes often leave out the short piece between two carriageways, on a bridge or through a crossing. If the
//! lanes before and after it are the same, it has them, too. A short piece may lie between roads of another name or class.
//!
//! A one-way carriageway of a main road does not lose its lanes where the tags end: it has those of the road before it or behind it, of
//! its twin, or of the same street nearby, else those that most have (`untold_carriageways`).

use rayon::prelude::*;
use rustc_hash::{FxHashMap, FxHashSet};

use crate::builder::tags::cross_section::{
    Assumed, Customs, Lane, SectionReading, StripKind, Travel, WayFacts, layout, tells_lanes,
};
use crate::builder::tags::road_class::{RoadClass, is_roundabout};
use crate::builder::tags::speed::unread;
use crate::diagnostic::{Finding, Severity, Subject};
use crate::geometry::{Point, Polyline, Vector, angle_between};
use crate::parallel::InSmallParts;

use super::End;
use super::access::{Access, Drivable};
use super::streets_nearby::{Beside, Carriageway, Carriageways, StreetsNearby};
use super::turn_angle::STRAIGHT_ON;

/// How many consecutive ways are searched for tagged lanes.
const WAYS_MOST: usize = 4;
/// A carriageway takes the lanes of others only if it and the untagged ones between are no longer than this together, metres. So much
/// of the data around it is always at hand where a map is built in tiles.
pub(super) const TAGS_FOLLOWED: f64 = 500.0;
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
        sections.layouts = drivable.par_iter().in_small_parts().map(|way| sections.layout(way, None)).collect();
        sections
    }

    fn layout(&self, way: &Drivable<'a>, continued: Option<&Assumed>) -> (SectionReading, Vec<Finding>) {
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
        let mut reading = layout(&facts, &mut notes);
        if let Some(only) = way.only {
            // The way itself tells of all that its tags lack.
            notes.clear();
            close_other_direction(&mut reading, only);
        }
        (reading, notes)
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
        let again = used.par_iter().in_small_parts().filter_map(|&i| {
            let way = &self.drivable[i];
            let by_settings = self.customs.defaults(way.class, way.link).lanes.is_some();
            let untold = || graph.untold(i).filter(|_| !by_settings);
            let lanes = graph.continued(i).or_else(|| graph.of_carriageway(i)).or_else(untold)?;
            Some((i, self.layout(way, Some(&lanes))))
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
pub(super) struct WayGraph<'a> {
    pub(super) ways: FxHashMap<usize, WayLanes<'a>>,
    /// The ways that begin or end at each node.
    pub(super) ends: FxHashMap<i64, Vec<(usize, End)>>,
    /// The tagged carriageways.
    nearby: StreetsNearby<'a>,
    /// The nodes of roundabouts and closed ways with one lane.
    pub(super) narrow_rings: FxHashSet<i64>,
    /// All carriageways of main roads.
    pub(super) carriageways: Carriageways,
}

/// What a way shares with the ways that continue it.
#[derive(PartialEq)]
pub(super) struct WayKind<'a> {
    class: RoadClass,
    link: bool,
    access: Access,
    roundabout: bool,
    name: Option<&'a str>,
}

impl WayKind<'_> {
    /// Whether it is a main road, without its ramps and roundabouts.
    fn is_main(&self) -> bool {
        self.class <= RoadClass::Secondary && !self.link && !self.roundabout && self.access != Access::Bus
    }

    /// Whether two ways differ only in name and class.
    pub(super) fn like(&self, other: &Self) -> bool {
        (self.link, self.access, self.roundabout) == (other.link, other.access, other.roundabout)
    }
}

pub(super) struct WayLanes<'a> {
    pub(super) kind: WayKind<'a>,
    pub(super) nodes: [i64; 2],
    /// The directions in which the way leads beyond its ends.
    pub(super) outward: [Vector; 2],
    /// Metres.
    pub(super) length: f64,
    /// The place in its middle, and in which direction vehicles drive there, if it is a carriageway of a main road.
    pub(super) carriageway: Option<(Point, Vector)>,
    /// Left to right along the way; defaults if none are tagged.
    pub(super) lanes: Vec<Lane>,
    pub(super) tagged: bool,
}

impl<'a> WayGraph<'a> {
    fn new<'l>(
        drivable: &[Drivable<'a>],
        positions: &FxHashMap<i64, Point>,
        layouts: impl Iterator<Item = (usize, &'l SectionReading)>,
    ) -> Self {
        let (mut ways, mut ends) = (FxHashMap::default(), FxHashMap::<i64, Vec<(usize, End)>>::default());
        let (mut tagged_ones, mut carriageways) = (Vec::new(), Vec::new());
        let mut narrow_rings = FxHashSet::default();
        for (i, layout) in layouts {
            let Drivable { way, class, link, access, .. } = &drivable[i];
            let (Some(&first), Some(&last)) = (way.nodes.first(), way.nodes.last()) else { continue };
            let tags = &way.tags;
            if (is_roundabout(tags) || first == last) && layout.section.driven().count() < 2 {
                narrow_rings.extend(way.nodes.iter().copied());
            }
            if first == last {
                continue;
            }
            let name = tags.get("name").or_else(|| tags.get("ref"));
            let kind = WayKind { class: *class, link: *link, access: *access, roundabout: is_roundabout(tags), name };
            let lanes = layout.section.driven().map(|(_, strip)| (strip.kind, strip.travel)).collect();
            let tagged = tells_lanes(tags);
            let points: Vec<Point> = way.nodes.iter().filter_map(|node| positions.get(node).copied()).collect();
            let steps: Vec<Vector> = points.windows(2).map(|pair| pair[1] - pair[0]).collect();
            let outward = [steps.first().map(|step| -step), steps.last().copied()].map(Option::unwrap_or_default);
            let length = steps.iter().map(Vector::norm).sum();
            let nodes = [first, last];
            let line = layout.section.one_way().filter(|_| kind.is_main()).and_then(|travel| {
                let line = Polyline::new(points)?;
                Some(if travel == Travel::Backward { line.reversed() } else { line })
            });
            let carriageway = line.as_ref().map(|line| (line.at(length / 2.0), line.direction(length / 2.0)));
            carriageways.extend(line.clone());
            if let Some((line, street)) = line.zip(name).filter(|_| tagged) {
                tagged_ones.push(Carriageway { way: i, street, line });
            }
            ways.insert(i, WayLanes { kind, nodes, outward, length, carriageway, lanes, tagged });
            ends.entry(first).or_default().push((i, End::Start));
            ends.entry(last).or_default().push((i, End::End));
        }
        let nearby = StreetsNearby::new(tagged_ones.into_iter());
        Self { ways, ends, nearby, narrow_rings, carriageways: Carriageways::new(carriageways) }
    }

    /// The lanes that an untagged way takes: those of the road that it continues, if they are the same before and after it.
    fn continued(&self, way: usize) -> Option<Assumed> {
        let own = self.ways.get(&way).filter(|own| !own.tagged)?;
        let [before, after] = End::BOTH.map(|end| self.tagged_beyond(way, end));
        let same = |lanes: &Vec<Lane>| after.as_ref() == Some(lanes) && directions(lanes) == directions(&own.lanes);
        before.filter(same).map(|lanes| Assumed { lanes, like: "the road has before and behind".to_owned() })
    }

    /// The lanes that an untagged one-way carriageway of a main road takes: those of the tagged piece before it or behind it, whichever
    /// are fewer, else those of its twin, else those of the same street nearby.
    fn of_carriageway(&self, way: usize) -> Option<Assumed> {
        let own = self.ways.get(&way).filter(|own| !own.tagged && own.length <= TAGS_FOLLOWED)?;
        let (middle, direction) = own.carriageway?;
        let travel = own.lanes.first()?.1;
        let fits = |lanes: &Vec<Lane>| !lanes.is_empty() && lanes.iter().all(|(_, other)| *other == travel);
        let ends = [(End::Start, "the road has before it"), (End::End, "the road has behind it")];
        let ends = ends.into_iter().filter_map(|(end, like)| {
            let lanes = self.tagged_beyond(way, end).filter(fits)?;
            Some(Assumed { lanes, like: like.to_owned() })
        });
        if let Some(fewest) = ends.min_by_key(|it| it.lanes.len()) {
            return Some(fewest);
        }
        let (other, how) =
            self.nearby.beside(own.kind.name?, middle, direction).filter(|_| own.length <= TAGS_FOLLOWED / 2.0)?;
        let beside = self.ways.get(&other).filter(|beside| beside.kind == own.kind)?;
        let cars = beside.lanes.iter().filter(|(kind, _)| *kind == StripKind::Drive).count();
        let like = match how {
            Beside::Twin => "the other carriageway has",
            Beside::Nearby => "the same street has nearby",
        };
        (cars > 0).then(|| Assumed { lanes: vec![(StripKind::Drive, travel); cars], like: like.to_owned() })
    }

    /// The lanes of the first tagged way beyond one end, left to right along this way.
    fn tagged_beyond(&self, mut way: usize, mut end: End) -> Option<Vec<Lane>> {
        let mut reversed = false;
        let mut length = 0.0;
        let is_carriageway = self.ways.get(&way)?.carriageway.is_some();
        for _ in 0..WAYS_MOST {
            length += self.ways.get(&way)?.length;
            if is_carriageway && length > TAGS_FOLLOWED {
                return None;
            }
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
    pub(super) fn beyond(&self, way: usize, end: End) -> Option<(usize, End)> {
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
            turn <= STRAIGHT_ON && kind.like(&own.kind)
        };
        let is_carriageway = |way: &WayLanes| own.carriageway.and(way.carriageway).is_some();
        let goes_on = |(other, _): &(usize, End)| own.length <= PIECE || is_carriageway(&self.ways[other]);
        of_kind.or_else(|| only(next.filter(goes_straight_on)).filter(goes_on))
    }
}

/// Takes the lanes of all directions but one from vehicles.
fn close_other_direction(reading: &mut SectionReading, only: Travel) {
    for strip in reading.section.strips.iter_mut().filter(|strip| strip.kind.is_driven()) {
        match strip.travel {
            Travel::Both => strip.travel = only,
            travel if travel != only => strip.kind = StripKind::Buffer,
            _ => {}
        }
    }
}

/// The only item.
pub(super) fn only<T>(mut items: impl Iterator<Item = T>) -> Option<T> {
    let first = items.next();
    first.filter(|_| items.next().is_none())
}

/// The lanes as seen from the other end.
fn reversed_lanes(lanes: &[Lane]) -> Vec<Lane> {
    lanes.iter().rev().map(|&(kind, travel)| (kind, opposite(travel))).collect()
}

/// The direction as seen from the other end.
pub(super) fn opposite(travel: Travel) -> Travel {
    match travel {
        Travel::Forward => Travel::Backward,
        Travel::Backward => Travel::Forward,
        Travel::Both => Travel::Both,
    }
}

/// Whether any lane leads along the way, and whether any leads against it.
pub(super) fn directions(lanes: &[Lane]) -> [bool; 2] {
    [Travel::Backward, Travel::Forward].map(|other| lanes.iter().any(|(_, travel)| *travel != other))
}
