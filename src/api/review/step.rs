//! A step of a review, in words that find their way into a map that was read anew.

use std::fmt;

use crate::fix::Mend;
use crate::text::counted;

use super::HandEdit;

/// What somebody did.
#[derive(Clone, Debug, PartialEq)]
pub enum Step {
    /// Accepted fixes.
    Accept {
        /// The findings' fixes.
        mends: Vec<Mend>,
        /// What they do.
        words: String,
    },
    /// Rejected them.
    Reject {
        /// The findings' fixes.
        mends: Vec<Mend>,
        /// Why.
        reason: String,
    },
    /// Put them off.
    Later {
        /// The findings' fixes.
        mends: Vec<Mend>,
    },
    /// Edited the map.
    Edit(HandEdit),
}

impl fmt::Display for Step {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let of = |mends: &[Mend]| match mends {
            [one] => format!("`{}` on {}", one.code, one.subject),
            [one, ..] => format!("{} of `{}`", counted(mends.len(), "finding"), one.code),
            [] => String::new(),
        };
        match self {
            Self::Accept { mends, words } => write!(f, "accepted {}: {words}", of(mends)),
            Self::Reject { mends, reason } => write!(f, "rejected {}: {reason}", of(mends)),
            Self::Later { mends } => write!(f, "put off {}", of(mends)),
            Self::Edit(edit) => write!(f, "edited: {edit}"),
        }
    }
}
