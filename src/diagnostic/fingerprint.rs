//! A name for a finding that stays the same while lines move and files are written anew.

use rustc_hash::FxHashMap;

use super::{Diagnostic, Subject};

/// Hands out fingerprints for the findings of one run, in the order of the run.
///
/// A fingerprint is a hash of code, kind of primitive and id. Where one fault is found on a primitive more than once,
/// the second and later ones are salted with their number.
#[derive(Debug, Default)]
pub struct Fingerprints<'a> {
    seen: FxHashMap<(&'a str, Subject), u64>,
}

impl<'a> Fingerprints<'a> {
    /// The fingerprint of the next finding: 16 hexadecimal digits.
    pub fn next(&mut self, diagnostic: &'a Diagnostic) -> String {
        let subject = diagnostic.finding.subject;
        let count = self.seen.entry((&diagnostic.code, subject)).or_default();
        let id = subject.id().map_or(String::new(), |id| id.to_string());
        let mut hash = fnv1a([diagnostic.code.as_str(), subject.kind(), &id]);
        if *count > 0 {
            hash = fnv1a([&format!("{hash:016x}"), &count.to_string(), ""]);
        }
        *count += 1;
        format!("{hash:016x}")
    }
}

/// FNV-1a of 64 bits over the parts, each closed by a zero byte. Written out, since it must never change: the
/// standard library's hashes may.
fn fnv1a(parts: [&str; 3]) -> u64 {
    const OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    let bytes = parts.iter().flat_map(|part| part.bytes().chain([0]));
    bytes.fold(OFFSET, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(PRIME))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnostic::{Finding, Severity};

    fn diagnostic(code: &str, subject: Subject) -> Diagnostic {
        Diagnostic::new(code, Severity::Error, Finding::new("fault", subject, "message"))
    }

    #[test]
    fn a_fingerprint_never_changes() {
        let found = diagnostic("vm-03-08/lane-node-missing", Subject::Lanelet(12));
        assert_eq!(Fingerprints::default().next(&found), "5db40412313cc594");
    }

    #[test]
    fn a_second_finding_of_a_kind_gets_another() {
        let found = diagnostic("a/b", Subject::Lanelet(1));
        let others = [
            diagnostic("a/c", Subject::Lanelet(1)),
            diagnostic("a/b", Subject::LineString(1)),
            diagnostic("a/b", Subject::Map),
        ];
        let mut prints = Fingerprints::default();
        let mut all = vec![prints.next(&found), prints.next(&found), prints.next(&found)];
        all.extend(others.iter().map(|other| prints.next(other)));
        let first = all[0].clone();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), 6);
        assert_eq!(Fingerprints::default().next(&found), first, "the first does not depend on what follows");
    }
}
