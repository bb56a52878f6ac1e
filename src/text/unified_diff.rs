//! The unified diff of two texts, as `diff -u` and git show it.

use imara_diff::{Algorithm, BasicLineDiffPrinter, Diff, InternedInput, UnifiedDiffConfig};

/// The hunks of more changed lines than this are shown as they come.
const MOST_TIDIED: u32 = 1000;

/// The hunks that turn one text into another, under the names of both; empty where they are the same.
pub fn unified_diff([old_name, new_name]: [&str; 2], [old, new]: [&str; 2]) -> String {
    if old == new {
        return String::new();
    }
    let lines = InternedInput::new(old, new);
    let mut diff = Diff::compute(Algorithm::Myers, &lines);
    // Hunks that begin where a reader expects it take time in the lines of the map for each.
    if diff.count_additions() + diff.count_removals() <= MOST_TIDIED {
        diff.postprocess_lines(&lines);
    }
    let printer = BasicLineDiffPrinter(&lines.interner);
    let hunks = diff.unified_diff(&printer, UnifiedDiffConfig::default(), &lines);
    format!("--- {old_name}\n+++ {new_name}\n{hunks}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_the_same_has_no_diff() {
        assert_eq!(unified_diff(["a", "b"], ["1\n", "1\n"]), "");
        assert_eq!(unified_diff(["a", "b"], ["1\n2\n", "1\n3\n"]), "--- a\n+++ b\n@@ -1,2 +1,2 @@\n 1\n-2\n+3\n");
    }
}
