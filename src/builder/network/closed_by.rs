//! What keeps vehicles from turns at the end of a road.

/// What keeps vehicles from a turn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ClosedBy {
    /// No other road leads that way.
    OneWays,
    /// Turn restrictions forbid every turn.
    Restrictions,
    /// All turns would turn back.
    Angle,
    /// There is no room for a lanelet.
    Room,
}
