//! Walkways: which piece of one lies on lanes, and who may use it.

use crate::diagnostic::{Edit, Subject};
use crate::geometry::{Point, polygon};
use crate::lanelet::LaneletId;
use crate::lanelet::index::{Lane, MapIndex};

/// From where to where along a walkway lanes lie under it, metres from its start; `None` if none does.
pub fn crossed<'a>(walkway: &Lane, lanes: impl IntoIterator<Item = &'a Lane<'a>>) -> Option<[f64; 2]> {
    let center = walkway.center.as_ref()?;
    let stations = lanes.into_iter().flat_map(|lane| {
        let inside = polygon::intersection(&walkway.outline, &lane.outline);
        let corners: Vec<f64> = geo::CoordsIter::coords_iter(&inside)
            .map(|corner| center.project(Point::new(corner.x, corner.y)).station)
            .collect();
        corners
    });
    let [first, last] = stations.fold([f64::INFINITY, 0.0_f64], |[a, b], s| [a.min(s), b.max(s)]);
    first.is_finite().then_some([first, last])
}

/// The edit that lets people on foot use a lanelet that does not say whether they may, as each lanelet of a crosswalk element has to.
pub fn walking_allowed(map: &MapIndex, id: LaneletId) -> Option<Edit> {
    let lanelet = map.map.lanelets.get(id)?;
    let on = Subject::Lanelet(id.0);
    let key = "participant:pedestrian";
    (!lanelet.attributes.has(key)).then(|| Edit::SetTag { on, key: key.into(), value: "yes".into() })
}
