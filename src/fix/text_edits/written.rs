//! The texts of the files with all edits, and the map that they are.

use std::ops::Range;

use super::TextEdits;
use crate::diagnostic::SourceSpan;
use crate::osm::{OsmData, ReadError, Stretch};

impl TextEdits<'_> {
    /// The files' texts with all edits, in the order of the sources.
    pub fn texts(self) -> Vec<String> {
        self.written().0
    }

    /// The map with all edits. Only what is edited is read again.
    ///
    /// # Errors
    ///
    /// If an edited element cannot be read: a fault of ours.
    pub fn made(self) -> Result<OsmData, ReadError> {
        let osm = self.osm;
        let (texts, stretches) = self.written();
        osm.replaced(texts, &stretches)
    }

    /// The texts, and where they differ from those that were read.
    fn written(mut self) -> (Vec<String>, Vec<Stretch>) {
        self.rename();
        let (mut texts, mut stretches) = (Vec::new(), Vec::new());
        let mut edited = self.edited.iter().peekable();
        for (file, source) in self.osm.sources.iter().enumerate() {
            let file = file as u32;
            let mut text = String::with_capacity(source.text.len());
            let mut at = 0;
            while let Some((span, element)) = edited.next_if(|(span, _)| span.file == file) {
                let (start, end) = (span.start as usize, span.end as usize);
                let kept = source.text.get(at..start).unwrap_or_default();
                let (kept, new) = match element {
                    Some(element) => (kept, element.render()),
                    // With the blanks and the line end before it.
                    None => (kept.trim_end_matches([' ', '\t']).trim_end_matches(['\r', '\n']), String::new()),
                };
                text += kept;
                stretches.push(stretch(file, at + kept.len()..end, text.len()..text.len() + new.len()));
                text += &new;
                at = end;
            }
            text += source.text.get(at..).unwrap_or_default();
            texts.push(text);
        }
        let last = self.osm.sources.iter().enumerate().next_back().filter(|_| !self.created.is_empty());
        if let Some(((file, source), text)) = last.zip(texts.last_mut()) {
            let end = text.rfind("</osm>").unwrap_or(text.len());
            let at = text[..end].trim_end().len();
            let added: String = self.created.iter().map(|(_, element)| format!("\n  {}", element.render())).collect();
            // What stands behind it is as it was.
            let old = source.text.len().saturating_sub(text.len() - at);
            stretches.push(stretch(file as u32, old..old, at..at + added.len()));
            text.insert_str(at, &added);
        }
        (texts, stretches)
    }
}

fn stretch(file: u32, old: Range<usize>, new: Range<usize>) -> Stretch {
    Stretch { old: SourceSpan { file, start: old.start as u64, end: old.end as u64 }, new }
}
