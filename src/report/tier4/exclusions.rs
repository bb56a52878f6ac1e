//! An exclusion list: issues that are left out, by primitive and id.

use serde::Deserialize;

use super::{FormatError, Validator};

const PRIMITIVES: [&str; 7] = ["point", "linestring", "polygon", "lanelet", "area", "regulatory element", "primitive"];

/// What a user wants left out.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Exclusions {
    exclusion: Vec<Exclusion>,
}

#[derive(Clone, Debug, Deserialize)]
struct Exclusion {
    primitive: String,
    id: i64,
    validators: Option<Vec<ExcludedPrimitive>>,
}

#[derive(Clone, Debug, Deserialize)]
struct ExcludedPrimitive {
    name: String,
}

impl Exclusions {
    /// Reads a list; kinds of primitives and validators must be known.
    ///
    /// # Errors
    ///
    /// If the text is no such list, or names an unknown kind of primitive or validator.
    pub fn parse(text: &str, validators: &[Validator<'_>]) -> Result<Self, FormatError> {
        let list: Self = serde_json::from_str(text).map_err(|error| FormatError(error.to_string()))?;
        for one in &list.exclusion {
            if !PRIMITIVES.contains(&one.primitive.as_str()) {
                let known = PRIMITIVES.join(", ");
                return Err(FormatError(format!("`{}` is no primitive; known are {known}", one.primitive)));
            }
            let mut names = one.validators.iter().flatten();
            if let Some(named) = names.find(|named| !validators.iter().any(|known| known.name == named.name)) {
                return Err(FormatError(format!("there is no validator `{}`", named.name)));
            }
        }
        Ok(list)
    }

    /// Whether the list holds an issue. The kind is that of the issue, not of the primitive around it.
    pub(super) fn hold(&self, validator: &str, primitive: &str, id: i64) -> bool {
        self.exclusion.iter().any(|one| {
            let meant = one.validators.as_ref().is_none_or(|names| names.iter().any(|named| named.name == validator));
            one.primitive == primitive && one.id == id && meant
        })
    }
}
