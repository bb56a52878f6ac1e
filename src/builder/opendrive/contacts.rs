//! Which ends of lanes meet, by the links of the file: of sections, of roads, and of junctions.

use std::collections::{BTreeMap, BTreeSet};

use crate::text::Text;
use crate::xodr::{Connection, Junction, JunctionKind, OpenDrive, Road, RoadEnd, RoadLink};

use super::stretches::CutRoad;

/// The end of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct LaneEnd {
    /// Index of the stretch among those of all roads.
    pub stretch: usize,
    /// Whether it is the end at the larger station.
    pub far: bool,
    /// The lane.
    pub lane: i64,
}

/// Two ends that meet, and the line of the file that says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Contact {
    /// Both, in order.
    pub ends: [LaneEnd; 2],
    /// From 1.
    pub line: usize,
    /// Whether a road lies between that is too short for lanelets.
    pub bridged: bool,
}

/// Something in the links that leads nowhere.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Dangling {
    /// From 1.
    pub line: usize,
    /// One sentence.
    pub message: String,
}

/// All contacts of a file, in order.
pub struct Contacts {
    /// Sorted, each pair of ends once.
    pub all: Vec<Contact>,
    /// Links that lead nowhere.
    pub dangling: Vec<Dangling>,
}

struct Finder<'a> {
    file: &'a OpenDrive,
    cut: &'a [CutRoad],
    /// For each road the index of its first stretch.
    first: &'a [usize],
    by_id: BTreeMap<&'a Text, usize>,
    found: Contacts,
}

/// Finds all contacts. `first` is, for each road, the index of its first stretch.
pub fn contacts(file: &OpenDrive, cut: &[CutRoad], first: &[usize]) -> Contacts {
    let by_id = file.roads.iter().enumerate().map(|(i, road)| (&road.id, i)).collect();
    let found = Contacts { all: Vec::new(), dangling: Vec::new() };
    let mut finder = Finder { file, cut, first, by_id, found };
    for (index, road) in file.roads.iter().enumerate() {
        finder.inside(index, road);
        finder.of_road(index, road);
    }
    for junction in &file.junctions {
        finder.of_junction(junction);
    }
    let mut found = finder.found;
    found.all = bridged(found.all, cut, first);
    found.all.sort_unstable();
    found.all.dedup_by_key(|contact| contact.ends);
    found
}

/// The contacts over roads that are dissolved.
fn bridged(mut all: Vec<Contact>, cut: &[CutRoad], first: &[usize]) -> Vec<Contact> {
    for (_, &stretch) in cut.iter().zip(first).filter(|(cut, _)| cut.dissolved) {
        let (own, others): (Vec<Contact>, Vec<Contact>) =
            all.into_iter().partition(|contact| contact.ends.iter().any(|end| end.stretch == stretch));
        all = others;
        let reached = |far: bool, lane: i64| -> Vec<(LaneEnd, usize)> {
            let other = |contact: &Contact| {
                let at = contact.ends.iter().position(|end| *end == LaneEnd { stretch, far, lane })?;
                Some((contact.ends[1 - at], contact.line))
            };
            own.iter().filter_map(other).filter(|(end, _)| end.stretch != stretch).collect()
        };
        let lanes: BTreeSet<i64> = own
            .iter()
            .flat_map(|contact| contact.ends)
            .filter(|end| end.stretch == stretch)
            .map(|end| end.lane)
            .collect();
        for lane in lanes {
            for (a, line) in reached(false, lane) {
                for (b, _) in reached(true, lane).into_iter().filter(|(b, _)| *b != a) {
                    all.push(Contact { ends: [a.min(b), a.max(b)], line, bridged: true });
                }
            }
        }
    }
    all
}

impl Finder<'_> {
    fn add(&mut self, a: LaneEnd, b: LaneEnd, line: usize) {
        if a != b {
            self.found.all.push(Contact { ends: [a.min(b), a.max(b)], line, bridged: false });
        }
    }

    fn dangling(&mut self, line: usize, message: String) {
        self.found.dangling.push(Dangling { line, message });
    }

    /// Between the stretches of one road.
    fn inside(&mut self, index: usize, road: &Road) {
        let cut = &self.cut[index];
        for (at, pair) in cut.stretches.windows(2).enumerate() {
            let stretch = self.first[index] + at;
            let last = pair[0].sections.end - 1;
            let pairs: Vec<[i64; 2]> = if pair[1].sections.start == last {
                road.sections[cut.kept[last]].lanes.iter().map(|lane| [lane.id; 2]).collect()
            } else {
                cut.links.get(last).cloned().unwrap_or_default()
            };
            for [a, b] in pairs {
                let ends = [(stretch, true, a), (stretch + 1, false, b)];
                let [a, b] = ends.map(|(stretch, far, lane)| LaneEnd { stretch, far, lane });
                self.add(a, b, road.line);
            }
        }
    }

    /// The end of a lane at an end of a road; the lane is one of the outermost section there, which may be a micro section: it is then
    /// followed to the stretch. `None` if there is no such lane.
    fn end(&self, index: usize, end: RoadEnd, lane: i64) -> Option<LaneEnd> {
        let (cut, road) = (&self.cut[index], &self.file.roads[index]);
        let far = end == RoadEnd::End;
        let outer = if far { road.sections.len().checked_sub(1)? } else { 0 };
        let kept = *if far { cut.kept.last()? } else { cut.kept.first()? };
        road.sections.get(outer)?.lane(lane)?;
        let mut lane = lane;
        let mut at = outer;
        while at != kept {
            let next = if far { at - 1 } else { at + 1 };
            let side = usize::from(!far);
            let (own, other) = (road.sections[at].lane(lane)?, &road.sections[next]);
            let linked = own.links[side].first().copied().filter(|id| other.lane(*id).is_some());
            let back = || other.lanes.iter().find(|it| it.links[1 - side].contains(&lane)).map(|it| it.id);
            lane = linked.or_else(back)?;
            at = next;
        }
        let count = cut.stretches.len();
        let stretch = self.first[index] + if far { count.checked_sub(1)? } else { 0 };
        road.sections[kept].lane(lane)?;
        (count > 0).then_some(LaneEnd { stretch, far, lane })
    }

    /// From the ends of a road to the roads that it is linked to.
    fn of_road(&mut self, index: usize, road: &Road) {
        if self.cut[index].stretches.is_empty() {
            return;
        }
        for (side, end) in [(0, RoadEnd::Start), (1, RoadEnd::End)] {
            let (other, contact) = match &road.links[side] {
                Some(RoadLink::Road(other, contact)) => (other, contact),
                Some(RoadLink::Junction(junction)) => {
                    if !self.file.junctions.iter().any(|it| it.id == *junction) {
                        let message = format!("road {} leads to junction {junction}, which is not there", road.id);
                        self.dangling(road.line, message);
                    }
                    continue;
                }
                None => continue,
            };
            let Some(&to) = self.by_id.get(other) else {
                self.dangling(road.line, format!("road {} leads to road {other}, which is not there", road.id));
                continue;
            };
            let contact = contact.unwrap_or_else(|| self.nearest(to, index, end));
            let outer = if end == RoadEnd::End { road.sections.last() } else { road.sections.first() };
            let Some(outer) = outer else { continue };
            let pairs = outer.lanes.iter().flat_map(|lane| lane.links[side].iter().map(|next| [lane.id, *next]));
            let pairs: Vec<[i64; 2]> = pairs.collect();
            if pairs.is_empty() && to != index {
                self.dangling(road.line, format!("road {} leads to road {other}, but none of its lanes does", road.id));
            }
            for [a, b] in pairs {
                match self.end(index, end, a).zip(self.end(to, contact, b)) {
                    Some((a, b)) => self.add(a, b, road.line),
                    None => {
                        let message = format!(
                            "lane {a} of road {} leads to lane {b} of road {other}, which is not there",
                            road.id
                        );
                        self.dangling(road.line, message);
                    }
                }
            }
        }
    }

    fn of_junction(&mut self, junction: &Junction) {
        if junction.kind == JunctionKind::Virtual {
            return;
        }
        for connection in &junction.connections {
            let roads = [&connection.incoming, &connection.connecting].map(|id| self.by_id.get(id).copied());
            let [Some(incoming), Some(connecting)] = roads else {
                let message = format!(
                    "junction {} connects road {} and road {}, of which one is not there",
                    junction.id, connection.incoming, connection.connecting
                );
                self.dangling(connection.line, message);
                continue;
            };
            self.connect(junction, connection, [incoming, connecting]);
        }
    }

    fn connect(&mut self, junction: &Junction, connection: &Connection, [incoming, connecting]: [usize; 2]) {
        let contact = connection.contact.unwrap_or(RoadEnd::Start);
        let leads = |side: usize| matches!(&self.file.roads[incoming].links[side], Some(RoadLink::Junction(id)) if *id == junction.id);
        let end = match [leads(0), leads(1)] {
            [true, false] => RoadEnd::Start,
            [false, true] => RoadEnd::End,
            _ => self.nearest(incoming, connecting, contact),
        };
        for &[from, to] in &connection.lanes {
            match self.end(incoming, end, from).zip(self.end(connecting, contact, to)) {
                Some((a, b)) => self.add(a, b, connection.line),
                None => {
                    let message = format!(
                        "junction {} links lane {from} of road {} to lane {to} of road {}, of which one is not there",
                        junction.id, connection.incoming, connection.connecting
                    );
                    self.dangling(connection.line, message);
                }
            }
        }
    }

    /// The end of a road that lies nearer to an end of another.
    fn nearest(&self, road: usize, other: usize, end: RoadEnd) -> RoadEnd {
        let place = |road: usize, end: RoadEnd| {
            let road = &self.file.roads[road];
            road.plan.at(if end == RoadEnd::End { road.length } else { 0.0 }).point
        };
        let at = place(other, end);
        let off = |end| (place(road, end) - at).norm();
        if off(RoadEnd::Start) <= off(RoadEnd::End) { RoadEnd::Start } else { RoadEnd::End }
    }
}
