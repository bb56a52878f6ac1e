//! Faults of the file as a whole: its format version, and what the reader skipped.

use super::{Loader, SUPPORTED_FORMAT_VERSION};
use crate::diagnostic::{SourceSpan, Subject};
use crate::lanelet::{Condition, LoadFault};
use crate::osm::{ElementKind, Oddity, OddityKind};

impl Loader<'_> {
    pub(super) fn file_level_faults(&mut self) {
        if let Some(condition) = self.format_version() {
            self.loaded.faults.push(LoadFault { subject: Subject::Map, span: None, condition });
        }
        let osm = self.osm;
        for (file, source) in osm.sources.iter().enumerate() {
            let text = source.text.trim_start_matches('\u{feff}');
            let start = text.trim_start();
            if start.len() < text.len() && start.starts_with("<?xml") {
                let span = SourceSpan { file: file as u32, start: 0, end: (source.text.len() - start.len()) as u64 };
                self.fault(Subject::Map, &span, Condition::BlankStart);
            }
        }
        let passed_over = |o: &&Oddity| matches!(o.kind, OddityKind::BadElement | OddityKind::UnsaidElement);
        for oddity in osm.oddities.iter().filter(passed_over) {
            let subject = match oddity.element {
                Some((ElementKind::Node, id)) => Subject::Node(id),
                Some((ElementKind::Way, id)) => Subject::Way(id),
                Some((ElementKind::Relation, id)) => Subject::Relation(id),
                None => Subject::Map,
            };
            let condition = Condition::PassedOver {
                message: oddity.message.clone(),
                unsaid: oddity.kind == OddityKind::UnsaidElement,
            };
            self.fault(subject, &oddity.span, condition);
        }
    }

    fn format_version(&self) -> Option<Condition> {
        let Some(found) = self.loaded.map.format_version.clone() else { return Some(Condition::NoFormatVersion) };
        let parts: Vec<&str> = found.split('.').collect();
        let numeric = |part: &&str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
        if parts.len() > 3 || !parts.iter().all(numeric) {
            return Some(Condition::BadFormatVersion { found });
        }
        // More digits than fit are certainly too high.
        let major = parts.first().and_then(|p| p.parse::<u32>().ok()).unwrap_or(u32::MAX);
        let supported = SUPPORTED_FORMAT_VERSION;
        (major > supported).then_some(Condition::UnsupportedFormatVersion { found, supported })
    }
}
