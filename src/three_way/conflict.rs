//! A conflict: both sides changed the same thing, to different values. Which changes are conflicts, `fields` and `decide` tell.

use serde::Serialize;

use crate::diagnostic::Subject;
use crate::projection::LonLat;

/// One of two versions that are merged.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Side {
    /// The version into which the other is merged.
    Ours,
    /// The other one.
    Theirs,
}

impl Side {
    /// The other one.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::Ours => Self::Theirs,
            Self::Theirs => Self::Ours,
        }
    }

    /// The word for it.
    pub const fn as_str(self) -> &'static str {
        match self {
            Self::Ours => "ours",
            Self::Theirs => "theirs",
        }
    }
}

/// A contradiction: what it is about, and what the three versions say of it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conflict {
    /// The element; the map, where it is about what stands beside it.
    pub subject: Subject,
    /// What of it: `position`, `nodes`, `members`, `tag KEY`, `role of KIND ID`, `ROLE`, `deletion`, `use`, `key PATH`.
    pub about: String,
    /// What both began with; `None` where it was not there.
    pub base: Option<String>,
    /// What ours says; `None` where it is not there.
    pub ours: Option<String>,
    /// What theirs says; `None` where it is not there.
    pub theirs: Option<String>,
    /// Whose is in the result.
    pub taken: Side,
    /// Where the element lies, if it has a place on Earth.
    pub at: Option<LonLat>,
}

impl Conflict {
    /// A few lines for people, the first with what it is about and where.
    pub fn text(&self) -> String {
        let place = self.at.map_or_else(String::new, |at| format!(" (at {:.7}, {:.7})", at.lat, at.lon));
        let mut text = format!("conflict: {}: {}{place}\n", self.subject, self.about);
        for (name, said, is_taken) in [
            ("base", &self.base, false),
            ("ours", &self.ours, self.taken == Side::Ours),
            ("theirs", &self.theirs, self.taken == Side::Theirs),
        ] {
            let said = said.as_deref().unwrap_or("(not there)");
            let taken = if is_taken { "  <- in the result" } else { "" };
            text += &format!("  {name:<6}  {said}{taken}\n");
        }
        text
    }
}
