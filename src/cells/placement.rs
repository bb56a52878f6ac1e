//! In which cells each element stands: those that it touches, and those of whatever refers to it.

use std::ops::Not;

use rustc_hash::FxHashMap;

use crate::geometry::Point;
use crate::osm::ElementKind;

use super::DivideError;
use super::grid::{Cell, Grid, TooWide};
use super::sets::{CellSets, NOWHERE, SetId};
use super::survey::{Is, Shelf, Survey};

/// The cells of all elements, by their positions in the survey.
#[derive(Debug)]
pub struct Placement {
    pub sets: CellSets,
    pub nodes: Vec<SetId>,
    pub ways: Vec<SetId>,
    pub relations: Vec<SetId>,
}

impl Placement {
    /// Places the elements of a map.
    pub fn of(survey: &Survey, grid: Grid) -> Result<Self, DivideError> {
        let nodes = vec![NOWHERE; survey.nodes.ids.len()];
        let relations = vec![NOWHERE; survey.relations.ids.len()];
        let placement = Self { sets: CellSets::default(), nodes, ways: Vec::new(), relations };
        let mut placing = Placing { survey, grid, placement, found: Vec::new() };
        placing.touch_ways()?;
        placing.touch_relations()?;
        placing.spread_relations()?;
        placing.spread_ways()?;
        placing.place_nodes()?;
        Ok(placing.placement)
    }
}

struct Placing<'a> {
    survey: &'a Survey,
    grid: Grid,
    placement: Placement,
    /// Room for the cells of one element.
    found: Vec<Cell>,
}

impl Placing<'_> {
    /// Ways go where they run; areas also where they lie.
    fn touch_ways(&mut self) -> Result<(), DivideError> {
        let survey = self.survey;
        for way in 0..survey.ways.ids.len() {
            let mut line = self.line(way);
            let area = survey.areas.get(way) == Some(&true);
            if area {
                line.extend(line.first().copied());
            }
            let set = self
                .touched(&line, area.then_some(&line))
                .map_err(|TooWide| DivideError::TooWide { kind: ElementKind::Way, id: survey.ways.ids.at(way) })?;
            self.placement.ways.push(set);
        }
        Ok(())
    }

    /// The places of a way's nodes, as far as they are there.
    fn line(&self, way: usize) -> Vec<Point> {
        let nodes = self.survey.way_nodes.at(way).iter();
        nodes.filter_map(|at| self.survey.places.get(*at as usize).copied()).collect()
    }

    fn touched(&mut self, line: &[Point], ring: Option<&Vec<Point>>) -> Result<SetId, TooWide> {
        self.found.clear();
        self.grid.along(line, &mut self.found)?;
        if let Some(ring) = ring {
            self.grid.within(ring, &mut self.found)?;
        }
        Ok(self.placement.sets.of(&self.found))
    }

    /// Relations go where their members are; lanelets also where they lie. Regulatory elements go where their lanelets go, and
    /// where their members are only if they have none.
    fn touch_relations(&mut self) -> Result<(), DivideError> {
        let survey = self.survey;
        let mut referred = vec![false; survey.relations.ids.len()];
        for (relation, is) in survey.relation_is.iter().enumerate() {
            let Is::Lanelet(bounds) = is else { continue };
            let elements = survey.members.at(relation).iter().filter(|(kind, _)| *kind == ElementKind::Relation);
            for element in elements.filter_map(|(_, id)| survey.relations.ids.find(*id)) {
                referred[element as usize] = true;
            }
            let inside = self.inside(*bounds).map_err(|TooWide| DivideError::TooWide {
                kind: ElementKind::Relation,
                id: survey.relations.ids.at(relation),
            })?;
            let set = self.of_members(relation, inside)?;
            self.placement.relations[relation] = set;
        }
        for wanted in [Is::Other, Is::RegulatoryElement] {
            let of_kind = survey.relation_is.iter().enumerate().filter(|(_, is)| **is == wanted);
            for (relation, _) in of_kind.filter(|(at, _)| wanted == Is::Other || referred[*at].not()) {
                self.placement.relations[relation] = self.of_members(relation, NOWHERE)?;
            }
        }
        Ok(())
    }

    /// The cells between two bounds, whichever way each of them runs.
    fn inside(&mut self, bounds: [Option<i64>; 2]) -> Result<SetId, TooWide> {
        let line = |id: Option<i64>| self.survey.ways.ids.find(id?).map(|way| self.line(way as usize));
        let [Some(mut ring), Some(mut right)] = bounds.map(line) else { return Ok(NOWHERE) };
        let (Some(a), Some(b)) = (ends(&ring), ends(&right)) else { return Ok(NOWHERE) };
        if (a.0 - b.0).norm() + (a.1 - b.1).norm() < (a.0 - b.1).norm() + (a.1 - b.0).norm() {
            right.reverse();
        }
        ring.append(&mut right);
        ring.extend(ring.first().copied());
        self.touched(&ring, Some(&ring))
    }

    fn of_members(&mut self, relation: usize, mut set: SetId) -> Result<SetId, DivideError> {
        for (kind, id) in self.survey.members.at(relation) {
            let at = |shelf: &Shelf| shelf.ids.find(*id).map(|at| at as usize);
            let of_member = match kind {
                ElementKind::Node => match at(&self.survey.nodes) {
                    Some(node) => self.own_cell(node)?,
                    None => NOWHERE,
                },
                ElementKind::Way => at(&self.survey.ways).map_or(NOWHERE, |way| self.placement.ways[way]),
                ElementKind::Relation => {
                    at(&self.survey.relations).map_or(NOWHERE, |other| self.placement.relations[other])
                }
            };
            set = self.placement.sets.union(set, of_member);
        }
        Ok(set)
    }

    /// The cell that a node lies in.
    fn own_cell(&mut self, node: usize) -> Result<SetId, DivideError> {
        let place = self.survey.places.get(node).copied().unwrap_or_default();
        let id = || self.survey.nodes.ids.at(node);
        self.touched(&[place], None).map_err(|TooWide| DivideError::TooWide { kind: ElementKind::Node, id: id() })
    }

    /// The cell of what has no place. Only for an element that needs it: a cell that is named becomes a file.
    fn first_cell(&mut self) -> SetId {
        let first = self.placement.sets.cells().iter().min().copied();
        self.placement.sets.of(&[first.unwrap_or(Cell { row: 0, column: 0 })])
    }

    /// Relations go where relations that have them as members go.
    fn spread_relations(&mut self) -> Result<(), DivideError> {
        let survey = self.survey;
        let twins = twins(&survey.relations);
        let Placement { sets, relations, .. } = &mut self.placement;
        let follow = |relation: u32, reach: &mut dyn FnMut(u32)| {
            let members = survey.members.at(relation as usize).iter();
            let relations = members.filter(|(kind, _)| *kind == ElementKind::Relation);
            relations.filter_map(|(_, id)| survey.relations.ids.find(*id)).for_each(&mut *reach);
            twins.get(&relation).into_iter().flatten().copied().for_each(reach);
        };
        let placed = (0..).zip(&*relations).filter(|(_, set)| **set != NOWHERE).map(|(at, _)| at).collect();
        spread(sets, relations, placed, follow)?;
        let nowhere: Vec<u32> = (0..).zip(&*relations).filter(|(_, set)| **set == NOWHERE).map(|(at, _)| at).collect();
        if nowhere.is_empty() {
            return Ok(());
        }
        let first = self.first_cell();
        let Placement { sets, relations, .. } = &mut self.placement;
        nowhere.iter().for_each(|at| relations[*at as usize] = first);
        spread(sets, relations, nowhere, follow)
    }

    /// Ways go where relations go that have them as members or name them, and where ways go that name them.
    fn spread_ways(&mut self) -> Result<(), DivideError> {
        let survey = self.survey;
        let Placement { sets, ways, relations, .. } = &mut self.placement;
        let mut put = |id: i64, set: SetId| {
            if let Some(way) = survey.ways.ids.find(id) {
                ways[way as usize] = sets.union(ways[way as usize], set);
            }
        };
        for (relation, set) in relations.iter().enumerate() {
            let members = survey.members.at(relation).iter().filter(|(kind, _)| *kind == ElementKind::Way);
            members.for_each(|(_, id)| put(*id, *set));
        }
        survey.relation_names.iter().for_each(|(relation, id)| put(*id, relations[*relation as usize]));
        if ways.contains(&NOWHERE) {
            let first = self.first_cell();
            self.placement.ways.iter_mut().filter(|set| **set == NOWHERE).for_each(|set| *set = first);
        }
        let Placement { sets, ways, .. } = &mut self.placement;
        let mut next = twins(&survey.ways);
        for (way, id) in &survey.way_names {
            next.entry(*way).or_default().extend(survey.ways.ids.find(*id));
        }
        let mut queue: Vec<u32> = next.keys().copied().collect();
        queue.sort_unstable();
        spread(sets, ways, queue, |way, reach| next.get(&way).into_iter().flatten().copied().for_each(reach))
    }

    /// Nodes go where ways and relations go that have them; free ones where they lie.
    fn place_nodes(&mut self) -> Result<(), DivideError> {
        let survey = self.survey;
        let Placement { sets, nodes, ways, relations } = &mut self.placement;
        let mut put = |node: u32, set: SetId| {
            if let Some(own) = nodes.get_mut(node as usize) {
                *own = sets.union(*own, set);
            }
        };
        for (way, set) in ways.iter().enumerate() {
            survey.way_nodes.at(way).iter().for_each(|node| put(*node, *set));
        }
        for (relation, set) in relations.iter().enumerate() {
            let members = survey.members.at(relation).iter().filter(|(kind, _)| *kind == ElementKind::Node);
            members.filter_map(|(_, id)| survey.nodes.ids.find(*id)).for_each(|node| put(node, *set));
        }
        for node in 0..nodes.len() {
            if self.placement.nodes[node] == NOWHERE {
                self.placement.nodes[node] = self.own_cell(node)?;
            }
        }
        let (twins, Placement { sets, nodes, .. }) = (twins(&survey.nodes), &mut self.placement);
        let mut queue: Vec<u32> = twins.keys().copied().collect();
        queue.sort_unstable();
        spread(sets, nodes, queue, |node, reach| twins.get(&node).into_iter().flatten().copied().for_each(reach))
    }
}

/// Elements of one id in one file: all stand where one of them stands.
fn twins(shelf: &Shelf) -> FxHashMap<u32, Vec<u32>> {
    let mut twins: FxHashMap<u32, Vec<u32>> = FxHashMap::default();
    for (first, other) in &shelf.repeats {
        twins.entry(*first).or_default().push(*other);
        twins.entry(*other).or_default().push(*first);
    }
    twins
}

/// Adds the cells of each element of the queue to those of all that it leads to, until nothing changes.
fn spread(
    sets: &mut CellSets,
    of: &mut [SetId],
    mut queue: Vec<u32>,
    follow: impl Fn(u32, &mut dyn FnMut(u32)),
) -> Result<(), DivideError> {
    while let Some(from) = queue.pop() {
        let set = of[from as usize];
        follow(from, &mut |to| {
            let (before, to_at) = (of[to as usize], to as usize);
            let union = sets.union(before, set);
            if union != before {
                of[to_at] = union;
                queue.push(to);
            }
        });
        if sets.too_many() {
            return Err(DivideError::Chained);
        }
    }
    Ok(())
}

fn ends(line: &[Point]) -> Option<(Point, Point)> {
    Some((*line.first()?, *line.last()?))
}
