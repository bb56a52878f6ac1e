//! What Autoware's loader rejects or changes, as facts; the rules decide how severe each is.

use crate::diagnostic::{SourceSpan, Subject};
use crate::osm::{ElementKind, Text};
use crate::projection::{InfoError, LonLat, MgrsGrid, Projector};

use super::element_roles::RoleLimit;

/// Something that does not load, or loads as something other than the file says.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadFault {
    /// The element that has it.
    pub subject: Subject,
    /// The element's position in the file.
    pub span: Option<SourceSpan>,
    /// What it is.
    pub condition: Condition,
}

impl LoadFault {
    /// Whether it says that local coordinates of the map are metres of another projection than its projector's.
    pub fn leaves_projector_open(&self) -> bool {
        matches!(
            self.condition,
            Condition::LocalShifted { .. }
                | Condition::LocalUnexplained { .. }
                | Condition::ProjectorInfo(InfoFault::AtOdds { .. })
        )
    }
}

/// A side of a lanelet, or its centre line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum BoundRole {
    /// `left`.
    Left,
    /// `right`.
    Right,
    /// `centerline`.
    Centerline,
}

impl BoundRole {
    /// The role as files write it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Left => "left",
            Self::Right => "right",
            Self::Centerline => "centerline",
        }
    }
}

impl std::fmt::Display for BoundRole {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.as_str())
    }
}

/// What can be wrong with the file that names a map's projector.
#[derive(Clone, Debug, PartialEq)]
pub enum InfoFault {
    /// There is none.
    Missing {
        /// What explains the coordinates, if MGRS does not.
        needed: Option<Projector>,
        /// The squares of MGRS that the map crosses, where that is why MGRS does not.
        squares: Vec<MgrsGrid>,
    },
    /// It has another name.
    Misnamed {
        /// The name.
        found: String,
    },
    /// It cannot be read, or says what Autoware does not take.
    Unusable(InfoError),
    /// A key is like one that Autoware reads, and is not.
    Unread {
        /// As written.
        key: String,
        /// What it is like.
        meant: &'static str,
    },
    /// The local coordinates are not those of its projector.
    AtOdds {
        /// What it says.
        said: Projector,
        /// What explains them.
        meant: Projector,
    },
    /// No node lies in its 100 km square.
    OtherGrid {
        /// The square it names.
        said: MgrsGrid,
        /// The one of most nodes.
        meant: MgrsGrid,
    },
    /// Its origin lies far from the map.
    FarOrigin {
        /// Metres from the origin to the nearest node.
        distance: f64,
    },
}

/// What the last of several elements of one id is.
#[derive(Clone, Debug, PartialEq)]
pub enum Repeat {
    /// A copy of an earlier one of this id.
    Copy,
    /// What another element says under an id of its own.
    Twin {
        /// That id.
        id: i64,
    },
    /// A separate element.
    Other {
        /// The elements that refer to it and not to an earlier one.
        referrers: Vec<Subject>,
    },
    /// The file does not show it.
    Unclear {
        /// Why, for a sentence.
        why: &'static str,
    },
}

/// The kinds of [`LoadFault`].
#[derive(Clone, Debug, PartialEq)]
pub enum Condition {
    /// Way or relation: refers to an element that does not exist. A way loses all its nodes and is dropped, a relation
    /// loses the member.
    MissingReference {
        /// Kind of the missing element.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// The role; `None` for the node of a way.
        role: Option<Text>,
    },
    /// Way: has no nodes and is dropped.
    WayWithoutNodes,
    /// Lanelet: not exactly one left or right bound, or more than one centre line.
    BoundCount {
        /// Which.
        role: BoundRole,
        /// How many there are.
        count: usize,
        /// The ways that have the role.
        ways: Vec<i64>,
        /// The only way, of all or of these, that fits between the lanelets around.
        meant: Option<i64>,
    },
    /// Lanelet: a bound has `area=yes` and loads as a polygon.
    BoundIsPolygon {
        /// Which.
        role: BoundRole,
        /// The way.
        way: i64,
    },
    /// Lanelet: a bound is a node or a relation.
    BoundIsNotWay {
        /// Which.
        role: BoundRole,
        /// What it is.
        kind: ElementKind,
        /// Its id.
        id: i64,
    },
    /// Lanelet: a bound is a way that was itself dropped.
    BoundDropped {
        /// Which.
        role: BoundRole,
        /// The way.
        way: i64,
    },
    /// Lanelet: a bound has fewer than two points.
    BoundTooShort {
        /// Which.
        role: BoundRole,
        /// The way.
        way: i64,
    },
    /// Lanelet: left and right bound run against one another after `align`.
    BoundsOpposed {
        /// The way of the left bound, and whether it is turned around.
        left: (i64, bool),
        /// The way of the right bound, and whether it is turned around.
        right: (i64, bool),
    },
    /// Lanelet, the first of several: the bounds of the lanelets have so many points together, each as often as a lanelet uses it, that
    /// those behind it are not looked at.
    BoundsTooLong {
        /// How many lanelets are not looked at.
        lanelets: usize,
        /// How many points are.
        most: usize,
    },
    /// Lanelet: both ways run against the direction of travel that the roles give. Usual in maps drawn by hand; only a
    /// hint that the roles may be exchanged.
    BothBoundsTurned {
        /// The way of the left bound.
        left: i64,
        /// The way of the right bound.
        right: i64,
    },
    /// Lanelet: a member `regulatory_element` that is not one.
    NotRegulatoryElement {
        /// What it is.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// Whether only its `type` is missing, by its members.
        untyped: bool,
    },
    /// Lanelet or regulatory element: a member exists in the file but was itself dropped. Its own fault says why.
    MemberDropped {
        /// Kind of the member.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// Its role.
        role: Text,
    },
    /// Regulatory element: has no `subtype` and is dropped.
    WithoutSubtype {
        /// What its members belong to, where that is plain.
        meant: Option<Text>,
    },
    /// Regulatory element: nobody has registered the subtype; creation throws.
    UnknownSubtype {
        /// As written.
        subtype: Text,
        /// Whether it has members left and right, as a lanelet has.
        has_bounds: bool,
    },
    /// Regulatory element: too few or too many members of a role; creation throws.
    MemberCount {
        /// The subtype.
        subtype: Text,
        /// What is needed.
        limit: RoleLimit,
        /// How many there are of the right kind.
        count: usize,
    },
    /// Regulatory element: it has no members at all, and its subtype needs some.
    WithoutMembers {
        /// The subtype.
        subtype: Text,
    },
    /// Regulatory element: a sign without `subtype`, or no sign and no `sign_type` either; creation throws.
    SignWithoutType {
        /// `traffic_sign` or `speed_limit`.
        subtype: Text,
        /// The first `refers` way, if there is one.
        sign: Option<i64>,
    },
    /// Regulatory element: `all_way_stop` with stop lines, but not one for each lanelet; creation throws.
    StopLinesPerLanelet {
        /// Members `yield`.
        lanelets: usize,
        /// Members `ref_line`.
        stop_lines: usize,
    },
    /// Regulatory element: a member is a regulatory element.
    MemberIsRegulatoryElement {
        /// The member.
        id: i64,
        /// Its role.
        role: Text,
    },
    /// Regulatory element: a member is a relation whose `type` is absent or nothing the loader knows.
    MemberOfUnknownType {
        /// The member.
        id: i64,
        /// Its role.
        role: Text,
        /// Its type.
        found: Option<Text>,
    },
    /// Relation: `type` is absent or none of `lanelet`, `multipolygon`, `regulatory_element`; silently ignored.
    UnknownRelationType {
        /// As written.
        found: Option<Text>,
        /// What its members belong to, where it has none and that is plain.
        meant: Option<Text>,
    },
    /// Relation: a member has a role that nothing reads.
    UnreadRole {
        /// `lanelet`, `multipolygon`, or the subtype of the regulatory element.
        of: Text,
        /// Kind of the member.
        kind: ElementKind,
        /// Its id.
        id: i64,
        /// Its role.
        role: Text,
    },
    /// Relation: `type=multipolygon` without one outer ring, or with a line that closes none.
    BrokenArea(RingFault),
    /// The id is used again within its kind. Nodes and ways: the last wins; relations: tags of the first, members of all.
    DuplicateId {
        /// Kind of the elements.
        kind: ElementKind,
        /// Their positions, in file order.
        spans: Vec<SourceSpan>,
        /// What the last one is.
        repeat: Repeat,
    },
    /// The id is used by elements of other kinds too; this loads.
    IdReused {
        /// The earlier kinds.
        kinds: Vec<ElementKind>,
    },
    /// The id is 0 or negative.
    IdNotPositive,
    /// Polygon: the id does not fit 31 bits; Autoware reads `intersection_area` with `atoi`.
    PolygonIdTooLarge,
    /// Node: `lat` or `lon` is absent, not a number or not on Earth; it loads as 0, 0.
    BadCoordinate {
        /// Latitude and longitude, where they are numbers.
        said: Option<[f64; 2]>,
        /// Where its `local_x` and `local_y` are, if the projector explains those of the other nodes.
        meant: Option<LonLat>,
    },
    /// Node: the projection does not reach it; it loads at the origin.
    Unprojectable,
    /// Map: latitudes and longitudes are metres.
    MetresAsDegrees {
        /// Those of the first node.
        first: [f64; 2],
    },
    /// Map: latitudes stand as longitudes, and longitudes as latitudes.
    ExchangedDegrees {
        /// What the first node has as latitude and longitude.
        first: [f64; 2],
    },
    /// Node: no `ele`, which loads as 0.
    NoElevation,
    /// Map: all nodes without `ele` lie at height 0, where Lanelet2's own writer leaves it out.
    ElevationLeftOut {
        /// How many.
        nodes: usize,
    },
    /// Node: `ele` is not a number, which loads as 0.
    BadElevation {
        /// As written.
        found: Text,
    },
    /// Node: one of `local_x` and `local_y` is absent or not a number, or other nodes have them and this one has not.
    PartialLocal {
        /// Whether `local_x` is there.
        x: bool,
        /// Whether `local_y` is there.
        y: bool,
    },
    /// Node: `local_x` and `local_y` are not where latitude and longitude are.
    LocalMismatch {
        /// Metres between the two.
        distance: f64,
    },
    /// Map: `local_x` and `local_y` of all nodes are moved by the same way against latitude and longitude.
    LocalShifted {
        /// Metres to the east.
        east: f64,
        /// Metres to the north.
        north: f64,
    },
    /// Map: `local_x` and `local_y` of most nodes are not where latitude and longitude are, each by another way.
    LocalUnexplained {
        /// How many.
        nodes: usize,
        /// Metres between the two, at the node where it is most.
        most: f64,
    },
    /// Node, the first of several: lies in another 100 km square than the projector names, and is folded into it.
    OtherSquare {
        /// Its square.
        square: MgrsGrid,
        /// The square of the projector.
        expected: MgrsGrid,
        /// How many nodes lie in that square.
        nodes: usize,
    },
    /// Map: what is wrong with `map_projector_info.yaml`.
    ProjectorInfo(InfoFault),
    /// Map: blanks stand before the XML declaration.
    BlankStart,
    /// Map: no `format_version`.
    NoFormatVersion,
    /// Map: `format_version` is not of the form `1`, `1.0` or `1.0.0`.
    BadFormatVersion {
        /// As written.
        found: Text,
    },
    /// Map: `format_version` is above the highest that Autoware supports.
    UnsupportedFormatVersion {
        /// As written.
        found: Text,
        /// The highest supported.
        supported: u32,
    },
    /// The reader passed something over: an element without id, a reference or member without a target.
    PassedOver {
        /// One line.
        message: String,
        /// Whether Lanelet2's reader says nothing of it.
        unsaid: bool,
    },
}

/// What is wrong with the rings of an area.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RingFault {
    /// A member is no line.
    NoLine {
        /// `outer` or `inner`.
        role: &'static str,
        /// What it is.
        kind: ElementKind,
        /// Its id.
        id: i64,
    },
    /// No line goes on where one ends.
    Open {
        /// `outer` or `inner`.
        role: &'static str,
    },
    /// A ring crosses itself, or goes around nothing.
    Crossing {
        /// `outer` or `inner`.
        role: &'static str,
    },
    /// The number of outer rings, if it is not one.
    Rings(usize),
}

impl Condition {
    /// Whether an element loses a member of this role.
    pub fn loses(&self, of_role: &str) -> bool {
        match self {
            Self::MissingReference { role, .. } => role.as_ref().is_some_and(|role| role == of_role),
            Self::MemberDropped { role, .. } => role == of_role,
            _ => false,
        }
    }

    /// Whether Lanelet2 loads such an element without a word, though Autoware cannot use it.
    pub fn is_unsaid(&self) -> bool {
        match self {
            Self::BoundsOpposed { .. } | Self::BoundTooShort { .. } => true,
            Self::PassedOver { unsaid, .. } => *unsaid,
            // An empty subtype makes an element without a class.
            Self::UnknownSubtype { subtype, .. } => subtype.is_empty(),
            // The constructor counts lanelets only.
            Self::MemberCount { subtype, limit, .. } => subtype == "right_of_way" && limit.role == "ref_line",
            _ => false,
        }
    }
}
