//! A requirement set: which validators run under which requirement, and which have to pass before others.

use serde_json::{Value, json};

use super::Validator;

/// What is wrong with a file of the existing validator's.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct FormatError(pub String);

/// A requirement set. Fields that nobody knows are kept and shown again.
#[derive(Clone, Debug)]
pub struct RequirementSet {
    document: Value,
    file: String,
}

/// A validator, one that it needs, and whether warnings of that one are forgiven.
pub(super) type Prerequisites<'a> = Vec<(&'a str, Vec<(&'a str, bool)>)>;

impl RequirementSet {
    /// Every validator under its own requirement.
    pub fn of_all(validators: &[Validator<'_>]) -> Self {
        let mut requirements: Vec<(&str, Vec<Value>)> = Vec::new();
        for validator in validators {
            let entry = json!({ "name": validator.name });
            match requirements.iter_mut().find(|(id, _)| *id == validator.requirement) {
                Some((_, list)) => list.push(entry),
                None => requirements.push((validator.requirement, vec![entry])),
            }
        }
        let requirements: Vec<Value> =
            requirements.into_iter().map(|(id, validators)| json!({ "id": id, "validators": validators })).collect();
        Self { document: json!({ "requirements": requirements }), file: String::new() }
    }

    /// Reads a set; every validator must be one of these.
    ///
    /// # Errors
    ///
    /// If the text is no such set, or names an unknown validator.
    pub fn parse(file: &str, text: &str, validators: &[Validator<'_>]) -> Result<Self, FormatError> {
        let document: Value = serde_json::from_str(text).map_err(|error| FormatError(error.to_string()))?;
        let set = Self { document, file: file.to_owned() };
        set.requirements()?;
        let prerequisites = set.prerequisites();
        let known = |name: &str| validators.iter().any(|validator| validator.name == name);
        match prerequisites.iter().find(|(name, _)| !known(name)) {
            Some((name, _)) => Err(FormatError(format!("there is no validator `{name}`"))),
            None => Ok(set),
        }
    }

    /// Holds that everything that has to be there is.
    fn requirements(&self) -> Result<(), FormatError> {
        let wrong = |what: &str| FormatError(what.to_owned());
        let list = |value: &Value, key: &str| value.get(key).and_then(Value::as_array).cloned();
        let named = |value: &Value, key: &str| value.get(key).is_some_and(Value::is_string);
        for requirement in list(&self.document, "requirements").ok_or_else(|| wrong("no list `requirements`"))? {
            if !named(&requirement, "id") {
                return Err(wrong("a requirement has no `id`"));
            }
            for validator in
                list(&requirement, "validators").ok_or_else(|| wrong("a requirement has no `validators`"))?
            {
                let prerequisites = list(&validator, "prerequisites").unwrap_or_default();
                if !named(&validator, "name") || !prerequisites.iter().all(|one| named(one, "name")) {
                    return Err(wrong("a validator has no `name`"));
                }
            }
        }
        Ok(())
    }

    fn validators(&self) -> impl Iterator<Item = &Value> {
        let requirements = self.document.get("requirements").and_then(Value::as_array).into_iter().flatten();
        requirements.flat_map(|one| one.get("validators").and_then(Value::as_array).into_iter().flatten())
    }

    /// The validators in order, as often as they are listed.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        self.validators().filter_map(|validator| validator.get("name")?.as_str())
    }

    /// What each validator needs, over all requirements under which it is.
    pub(super) fn prerequisites(&self) -> Prerequisites<'_> {
        let mut all: Prerequisites<'_> = Vec::new();
        for validator in self.validators() {
            let Some(name) = validator.get("name").and_then(Value::as_str) else { continue };
            let needed = validator.get("prerequisites").and_then(Value::as_array).into_iter().flatten();
            let needed = needed.filter_map(|one| {
                let forgiving = one.get("forgive_warnings").and_then(Value::as_bool).unwrap_or(false);
                Some((one.get("name")?.as_str()?, forgiving))
            });
            match all.iter_mut().find(|(known, _)| *known == name) {
                Some((_, list)) => list.extend(needed),
                None => all.push((name, needed.collect())),
            }
        }
        all
    }

    pub(super) fn document(&self) -> &Value {
        &self.document
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    pub(super) fn version(&self) -> &str {
        self.document.get("version").and_then(Value::as_str).unwrap_or_default()
    }
}
