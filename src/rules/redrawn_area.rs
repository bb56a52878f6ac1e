//! The fix that draws an intersection area anew around its lanelets.

use std::cell::{OnceCell, RefCell};

use crate::diagnostic::{AreaCorner, Edit, Finding, Subject};
use crate::lanelet::index::{AreaOutlines, Corner, Intersection, MapIndex, Outline};
use crate::text::counted;

use super::far_lanes;

use rustc_hash::FxHashMap;

/// Draws areas of a map; gathers the road borders only once an area is drawn.
pub struct RedrawnAreas<'i, 'm> {
    map: &'i MapIndex<'m>,
    outlines: OnceCell<AreaOutlines<'i, 'm>>,
    /// What was drawn around lanes: many findings may ask for the same.
    drawn: RefCell<FxHashMap<Vec<usize>, Option<Outline>>>,
}

impl<'i, 'm> RedrawnAreas<'i, 'm> {
    /// For a map.
    pub fn new(map: &'i MapIndex<'m>) -> Self {
        Self { map, outlines: OnceCell::new(), drawn: RefCell::default() }
    }

    /// The finding with an outline over the ends of the lanes of the intersection and the nodes of road borders. It has no fix if
    /// there is no such outline, if the area has it already, or if a lane reaches far beyond the others.
    pub fn mend(&self, finding: Finding, intersection: &Intersection) -> Finding {
        let lanes: Vec<usize> = intersection.members.iter().map(|member| member.lane).collect();
        let Some(area) = intersection.area.and_then(|id| self.map.map.polygons.get(id)) else { return finding };
        let Some(outline) = self.around(&lanes) else { return finding };
        let points: Vec<i64> = outline.points.into_iter().map(|id| id.0).collect();
        let known: Vec<i64> = area.points.iter().map(|id| id.0).collect();
        if points == known {
            return finding;
        }
        let edits = vec![Edit::SetVertices { way: Subject::Polygon(area.id.0), points }];
        finding.fixed_by("draw the outline anew over the ends of its lanes and the road borders", false, edits)
    }

    /// The finding with a new area around these lanelets, in place of one that is not there.
    pub fn replace(&self, finding: Finding, lanes: &[usize]) -> Finding {
        let Some(outline) = self.around(lanes) else { return finding };
        let lanelets = lanes.iter().map(|&lane| self.map.lanes[lane].id.0).collect();
        let title = format!("draw the area around {} that name it", counted(lanes.len(), "lanelet"));
        finding.fixed_by(title, false, vec![area_around(&outline, lanelets)])
    }

    fn around(&self, lanes: &[usize]) -> Option<Outline> {
        if let Some(known) = self.drawn.borrow().get(lanes) {
            return known.clone();
        }
        let outlines = self.outlines.get_or_init(|| AreaOutlines::new(self.map));
        let outline = if far_lanes::has_far(self.map, lanes) { None } else { outlines.around(lanes).ok() };
        self.drawn.borrow_mut().insert(lanes.to_vec(), outline.clone());
        outline
    }
}

/// The edit that draws an area over an outline and names it in the tags of its lanelets.
pub fn area_around(outline: &Outline, lanelets: Vec<i64>) -> Edit {
    let corner = |one: &Corner| AreaCorner { before: one.before, ends: one.ends.map(|id| id.0), share: one.share };
    Edit::CreateArea {
        points: outline.points.iter().map(|id| id.0).collect(),
        corners: outline.corners.iter().map(corner).collect(),
        lanelets,
    }
}
