//! A map in Lanelet2's words. The builder makes one, the rules judge one, the reports draw one.
//!
//! Six layers hold the primitives, each with ids of its own type. References between primitives are ids that always resolve:
//! [`from_osm()`] reports what does not resolve and leaves it out, as Autoware's loader does.

pub mod align;
mod attributes;
pub mod cell_metadata;
mod element_roles;
mod fault;
mod from_osm;
pub mod index;
mod inferred_projector;
pub mod lane_change;
pub mod locate;
pub mod number;
mod open;
mod other_heights;
pub mod participants;
pub mod placed;
mod point;
mod primitive_layer;
mod projector_info;
pub mod referrers;
pub mod right_of_way;
pub mod routing_pairs;
mod to_osm;
pub mod vocabulary;

pub use attributes::{Attributes, RoadType, TurnDirection};
pub use cell_metadata::MAP;
pub use element_roles::{RoleLimit, TargetKind, known_subtypes, role_limits};
pub use fault::{BoundRole, Condition, InfoFault, LoadFault, Repeat, RingFault};
pub use from_osm::{Loaded, SUPPORTED_FORMAT_VERSION, from_osm, is_area, positions};
pub use inferred_projector::{Evidence, Inferred, inferred_projector, twice};
pub use open::{
    OpenError, Opened, ProjectorFrom, files_of, is_lanelet2, is_navigation_osm, locate_files, open, open_bytes,
    projector_for, read_elements,
};
pub use other_heights::heights_by_other_names;
pub use point::Point;
pub use primitive_layer::Primitive;
pub use primitive_layer::{Cursor, PrimitiveLayer};
pub use projector_info::{INFO, ProjectorInfo};
pub use to_osm::to_osm;

/// What kind of element a fault speaks about.
pub use crate::osm::ElementKind;
/// What a fault of the projector's file says of it.
pub use crate::projection::InfoError;

use rayon::prelude::*;
use rustc_hash::FxHashSet;
use serde::Serialize;

use crate::diagnostic::SourceSpan;
use crate::geometry::Point as PlanePoint;
use crate::osm::Text;

macro_rules! ids {
    ($($(#[$doc:meta])* $name:ident),* $(,)?) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
        pub struct $name(pub i64);

        impl From<$name> for i64 {
            fn from(id: $name) -> Self {
                id.0
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    )*};
}

ids! {
    /// Id of a [`Point`]: a node of the file.
    PointId,
    /// Id of a [`LineString`]: a way without `area=yes`.
    LineStringId,
    /// Id of a [`Polygon`]: a way with `area=yes`.
    PolygonId,
    /// Id of a [`Lanelet`]: a relation with `type=lanelet`.
    LaneletId,
    /// Id of a [`RegulatoryElement`]: a relation with `type=regulatory_element`.
    RegulatoryElementId,
    /// Id of an [`Area`]: a relation with `type=multipolygon`.
    AreaId,
}

/// A line of points, without area: one at least, two or more where it is a bound of a lanelet.
#[derive(Clone, Debug)]
pub struct LineString {
    /// Its id.
    pub id: LineStringId,
    /// In file order; a lanelet may use it turned around.
    pub points: Vec<PointId>,
    /// Its tags.
    pub attributes: Attributes,
    /// Its position in the file.
    pub span: Option<SourceSpan>,
}

/// A closed outline; the first point is not repeated.
#[derive(Clone, Debug)]
pub struct Polygon {
    /// Its id.
    pub id: PolygonId,
    /// In file order.
    pub points: Vec<PointId>,
    /// Its tags.
    pub attributes: Attributes,
    /// Its position in the file.
    pub span: Option<SourceSpan>,
}

/// A linestring as a lanelet uses it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Bound {
    /// The linestring.
    pub line: LineStringId,
    /// Whether it runs against the lanelet's direction, by the loader's `align`.
    pub inverted: bool,
}

/// A directed piece of lane between two bounds.
#[derive(Clone, Debug)]
pub struct Lanelet {
    /// Its id.
    pub id: LaneletId,
    /// On the left in the direction of travel.
    pub left: Bound,
    /// On the right in the direction of travel.
    pub right: Bound,
    /// An explicit centre line, if it has one.
    pub centerline: Option<LineStringId>,
    /// The elements it refers to, in file order.
    pub regulatory_elements: Vec<RegulatoryElementId>,
    /// Its tags.
    pub attributes: Attributes,
    /// Its position in the file.
    pub span: Option<SourceSpan>,
}

/// What a member of a regulatory element is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Target {
    /// A node.
    Point(PointId),
    /// A way without `area=yes`.
    LineString(LineStringId),
    /// A way with `area=yes`.
    Polygon(PolygonId),
    /// A relation with `type=lanelet`.
    Lanelet(LaneletId),
}

/// One member of a regulatory element.
#[derive(Clone, Debug)]
pub struct Member {
    /// `refers`, `ref_line`, `yield`, ...
    pub role: Text,
    /// What it points to.
    pub target: Target,
}

/// A rule of the road and the primitives that it concerns.
#[derive(Clone, Debug)]
pub struct RegulatoryElement {
    /// Its id.
    pub id: RegulatoryElementId,
    /// `traffic_light`, `right_of_way`, ...
    pub subtype: Text,
    /// In file order.
    pub members: Vec<Member>,
    /// Its tags, `type` and `subtype` included.
    pub attributes: Attributes,
    /// Its position in the file.
    pub span: Option<SourceSpan>,
}

impl RegulatoryElement {
    /// The targets of one role, in file order.
    pub fn role<'a>(&'a self, role: &'a str) -> impl Iterator<Item = Target> + 'a {
        self.members.iter().filter(move |m| m.role == role).map(|m| m.target)
    }

    /// The lanelets of one role, in file order.
    pub fn lanelets<'a>(&'a self, role: &'a str) -> impl Iterator<Item = LaneletId> + 'a {
        self.role(role).filter_map(|t| match t {
            Target::Lanelet(id) => Some(id),
            _ => None,
        })
    }

    /// The polygons of one role, in file order.
    pub fn polygons<'a>(&'a self, role: &'a str) -> impl Iterator<Item = PolygonId> + 'a {
        self.role(role).filter_map(|t| match t {
            Target::Polygon(id) => Some(id),
            _ => None,
        })
    }

    /// The linestrings of one role, in file order.
    pub fn linestrings<'a>(&'a self, role: &'a str) -> impl Iterator<Item = LineStringId> + 'a {
        self.role(role).filter_map(|t| match t {
            Target::LineString(id) => Some(id),
            _ => None,
        })
    }
}

/// Ground that may be crossed from lanelet to lanelet.
#[derive(Clone, Debug)]
pub struct Area {
    /// Its id.
    pub id: AreaId,
    /// The lines of its outer ring, one behind the other, clockwise.
    pub outer: Vec<Bound>,
    /// The points of the outer ring, clockwise; the first is not repeated.
    pub points: Vec<PointId>,
    /// The number of its inner rings.
    pub holes: usize,
    /// Its tags.
    pub attributes: Attributes,
    /// Its position in the file.
    pub span: Option<SourceSpan>,
}

/// Primitives that Lanelet2 holds and Autoware cannot use: mostly placeholders for what did not load. They are not in the layers
/// of the map; only the profile `tier4` looks at them, because the existing validator judges them like all others.
#[derive(Clone, Debug, Default)]
pub struct Dummies {
    /// Lanelets with a bound of fewer than two points. A bound that is no linestring of the map has none.
    pub lanelets: Vec<Lanelet>,
    /// Centre lines of lanelets that did not load, or have one point only.
    pub centerlines: Vec<(LaneletId, LineStringId)>,
    /// All members of the elements that refer to what did not load, in file order.
    pub members: Vec<(RegulatoryElementId, Vec<Member>)>,
    /// Elements that Lanelet2 takes, though Autoware cannot use them.
    pub elements: Vec<RegulatoryElement>,
    /// The lanelets that refer to those.
    pub references: Vec<(LaneletId, RegulatoryElementId)>,
}

impl Dummies {
    /// Whether everything loaded.
    pub fn is_empty(&self) -> bool {
        let Self { lanelets, centerlines, members, elements, references: _ } = self;
        lanelets.is_empty() && centerlines.is_empty() && members.is_empty() && elements.is_empty()
    }
}

/// A map: six layers of primitives.
#[derive(Clone, Debug, Default)]
pub struct LaneletMap {
    /// `format_version` of `MetaInfo`, as written.
    pub format_version: Option<Text>,
    /// Whether its points lie where `local_x` and `local_y` say, whatever their latitudes and longitudes are.
    pub local: bool,
    /// Points by id.
    pub points: PrimitiveLayer<Point>,
    /// Linestrings by id.
    pub linestrings: PrimitiveLayer<LineString>,
    /// Polygons by id.
    pub polygons: PrimitiveLayer<Polygon>,
    /// Lanelets by id.
    pub lanelets: PrimitiveLayer<Lanelet>,
    /// Regulatory elements by id.
    pub regulatory_elements: PrimitiveLayer<RegulatoryElement>,
    /// Areas by id, as a file has them: the builder makes none.
    pub areas: PrimitiveLayer<Area>,
    /// What did not load.
    pub dummies: Dummies,
}

macro_rules! shelved {
    ($($item:ident => $id:ident),* $(,)?) => {$(
        impl Primitive for $item {
            type Id = $id;

            fn id(&self) -> $id {
                self.id
            }
        }
    )*};
}

shelved! {
    Point => PointId,
    LineString => LineStringId,
    Polygon => PolygonId,
    Lanelet => LaneletId,
    RegulatoryElement => RegulatoryElementId,
    Area => AreaId,
}

impl LaneletMap {
    /// Appends all primitives of other maps, with all threads. No id may be there twice.
    pub fn absorb_all(&mut self, others: Vec<Self>) {
        let mut layers = (Vec::new(), Vec::new(), Vec::new(), Vec::new(), Vec::new());
        for other in others {
            layers.0.push(other.points);
            layers.1.push(other.linestrings);
            layers.2.push(other.polygons);
            layers.3.push(other.lanelets);
            layers.4.push(other.regulatory_elements);
        }
        let Self { points, linestrings, polygons, lanelets, regulatory_elements, .. } = self;
        let rest = || {
            linestrings.append(layers.1);
            polygons.append(layers.2);
            lanelets.append(layers.3);
            regulatory_elements.append(layers.4);
        };
        rayon::join(|| points.append(layers.0), rest);
    }

    /// Appends all primitives of another map; the indexes are built at the next lookup. No id may be there twice.
    pub fn pile(&mut self, other: Self) {
        self.points.pile(other.points);
        self.linestrings.pile(other.linestrings);
        self.polygons.pile(other.polygons);
        self.lanelets.pile(other.lanelets);
        self.regulatory_elements.pile(other.regulatory_elements);
    }

    /// The number of points, linestrings, polygons, lanelets, regulatory elements.
    pub fn counts(&self) -> [usize; 5] {
        let Self { points, linestrings, polygons, lanelets, regulatory_elements, .. } = self;
        [points.len(), linestrings.len(), polygons.len(), lanelets.len(), regulatory_elements.len()]
    }

    /// The ids that two primitives have, of whatever kinds, ascending.
    pub fn repeated_ids(&self) -> Vec<i64> {
        let Self { points, linestrings, polygons, lanelets, regulatory_elements, .. } = self;
        let mut ids = Vec::with_capacity(self.counts().iter().sum());
        ids.extend(points.iter().map(|it| it.id.0));
        ids.extend(linestrings.iter().map(|it| it.id.0));
        ids.extend(polygons.iter().map(|it| it.id.0));
        ids.extend(lanelets.iter().map(|it| it.id.0));
        ids.extend(regulatory_elements.iter().map(|it| it.id.0));
        ids.par_sort_unstable();
        let again = ids.iter().zip(ids.iter().skip(1)).filter(|(id, next)| id == next);
        let mut repeated: Vec<i64> = again.map(|(id, _)| *id).collect();
        repeated.dedup();
        repeated
    }

    /// Keeps the first of the primitives of a kind that have the same id.
    pub fn drop_repeats(&mut self) {
        fn drop_later<T: Primitive>(layer: &mut PrimitiveLayer<T>) {
            let mut seen = FxHashSet::default();
            layer.retain(|item| seen.insert(item.id()));
        }
        drop_later(&mut self.points);
        drop_later(&mut self.linestrings);
        drop_later(&mut self.polygons);
        drop_later(&mut self.lanelets);
        drop_later(&mut self.regulatory_elements);
    }

    /// Puts all primitives of another map before its own, with all threads; only the points go after them, since there are many
    /// and their order does not matter. No id may be there twice.
    pub fn prepend(&mut self, first: Self) {
        let Self { points, linestrings, polygons, lanelets, regulatory_elements, .. } = self;
        let rest = || {
            linestrings.prepend(first.linestrings);
            polygons.prepend(first.polygons);
            lanelets.prepend(first.lanelets);
            regulatory_elements.prepend(first.regulatory_elements);
        };
        rayon::join(|| points.append(vec![first.points]), rest);
    }

    /// Frees the spare memory of all layers.
    pub fn shrink(&mut self) {
        self.points.shrink();
        self.linestrings.shrink();
        self.polygons.shrink();
        self.lanelets.shrink();
        self.regulatory_elements.shrink();
    }

    /// The points of a bound in the lanelet's direction of travel.
    pub fn bound_points(&self, bound: Bound) -> impl DoubleEndedIterator<Item = &Point> + '_ {
        let ids: &[PointId] = self.linestrings.get(bound.line).map_or(&[], |l| &l.points);
        let count = ids.len();
        self.points.get_each((0..count).map(move |i| if bound.inverted { ids[count - 1 - i] } else { ids[i] }))
    }

    /// Where the points of a bound lie, in the lanelet's direction of travel.
    pub fn bound_line(&self, bound: Bound) -> Vec<PlanePoint> {
        self.bound_points(bound).map(|p| p.position).collect()
    }

    /// The outline of a lanelet: left bound, then the right bound backwards; not closed.
    pub fn outline(&self, lanelet: &Lanelet) -> Vec<PlanePoint> {
        let mut ring = self.bound_line(lanelet.left);
        ring.extend(self.bound_points(lanelet.right).rev().map(|p| p.position));
        ring
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_ids_are_found_in_all_layers_and_those_of_a_kind_dropped() {
        let point = |id, x| Point::new(PointId(id), PlanePoint::new(x, 0.0), None);
        let line = |id| LineString { id: LineStringId(id), points: vec![], attributes: Attributes::new(), span: None };
        let mut map = LaneletMap::default();
        [point(1, 1.0), point(2, 2.0), point(1, 3.0), point(1, 4.0)].into_iter().for_each(|it| map.points.push(it));
        [line(2), line(3)].into_iter().for_each(|it| map.linestrings.push(it));
        assert_eq!(map.repeated_ids(), [1, 2]);
        map.drop_repeats();
        assert_eq!(map.points.iter().map(|it| it.position.x).collect::<Vec<_>>(), [1.0, 2.0]);
        assert_eq!((map.linestrings.len(), map.repeated_ids()), (2, vec![2]));
    }
}
