//! Which rules and faults somebody means by `vm-03`, `vm-03-08`, `load` or `vm-03-08/lane-node-missing`.

/// Whether a prefix names a code or a family it belongs to. A prefix ends where a part of the code ends: `vm-03-1` does
/// not name `vm-03-10`.
pub fn covers(prefix: &str, code: &str) -> bool {
    code.strip_prefix(prefix).is_some_and(|rest| rest.is_empty() || prefix.is_empty() || rest.starts_with(['-', '/']))
}

/// What belongs to the longest prefix that names a code.
pub fn most_specific<'a, T>(code: &str, entries: impl IntoIterator<Item = (&'a str, T)>) -> Option<(&'a str, T)> {
    entries.into_iter().filter(|(prefix, _)| covers(prefix, code)).max_by_key(|(prefix, _)| prefix.len())
}

/// The codes that a run is about.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Selection {
    /// Only what one of these names; everything if empty.
    pub select: Vec<String>,
    /// Without what one of these names.
    pub ignore: Vec<String>,
}

impl Selection {
    /// Whether a code is wanted. The longer prefix decides, so that one fault can be taken from a family that is left
    /// out; of two equal ones `ignore` does.
    pub fn wants(&self, code: &str) -> bool {
        let longest = |list: &[String]| {
            most_specific(code, list.iter().map(|prefix| (prefix.as_str(), ()))).map(|(p, ())| p.len())
        };
        let selected = if self.select.is_empty() { Some(0) } else { longest(&self.select) };
        match (selected, longest(&self.ignore)) {
            (None, _) => false,
            (Some(_), None) => true,
            (Some(selected), Some(ignored)) => selected > ignored,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn selection(select: &[&str], ignore: &[&str]) -> Selection {
        let own = |list: &[&str]| list.iter().map(|&prefix| prefix.to_owned()).collect();
        Selection { select: own(select), ignore: own(ignore) }
    }

    #[test]
    fn a_prefix_ends_where_a_part_ends() {
        for prefix in ["vm", "vm-03", "vm-03-08", "vm-03-08/lane-node-missing", "vm-03-08/lane-node"] {
            assert!(covers(prefix, "vm-03-08/lane-node-missing"), "{prefix}");
        }
        for prefix in ["vm-0", "vm-03-0", "vm-03-08/lane-n", "load", "m-03"] {
            assert!(!covers(prefix, "vm-03-08/lane-node-missing"), "{prefix}");
        }
    }

    #[test]
    fn the_longer_prefix_decides() {
        assert!(selection(&[], &[]).wants("load/align"));
        assert!(selection(&["load"], &[]).wants("load/align"));
        assert!(!selection(&["load"], &[]).wants("vm-03-08/closed"));
        assert!(!selection(&["vm-03"], &["vm-03-08"]).wants("vm-03-08/closed"));
        assert!(selection(&["vm-03-08/closed"], &["vm-03"]).wants("vm-03-08/closed"));
        assert!(!selection(&["vm-03-08"], &["vm-03-08"]).wants("vm-03-08/closed"));
    }
}
