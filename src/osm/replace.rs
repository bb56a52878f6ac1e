//! Elements replaced in the text of the files: what stays is not read again.

use rustc_hash::FxHashSet;

use super::{ElementKind, Node, OddityKind, OsmData, ReadError, Relation, Source, Way, read_bytes};
use crate::text::SourceSpan;

/// A stretch of a file's text in place of another.
#[derive(Clone, Debug)]
pub struct Stretch {
    /// Where the other one was: an element, with the blanks before it where it is removed; empty where something is added.
    pub old: SourceSpan,
    /// Where this one is in the new text: nothing, or whole elements. The file is the same.
    pub new: std::ops::Range<usize>,
}

impl OsmData {
    /// The same files with these texts, which differ by these stretches alone, in the order of the files.
    ///
    /// # Errors
    ///
    /// If a new stretch is no OpenStreetMap data.
    pub fn replaced(&self, texts: Vec<String>, stretches: &[Stretch]) -> Result<Self, ReadError> {
        let mut fresh = Fresh::read(&texts, stretches)?;
        let shifts = Shifts::of(stretches);
        let nodes = self.nodes.iter().filter_map(|one| Some(Node { span: shifts.of_span(&one.span)?, ..one.clone() }));
        let ways = self.ways.iter().filter_map(|one| Some(Way { span: shifts.of_span(&one.span)?, ..one.clone() }));
        let relations =
            self.relations.iter().filter_map(|one| Some(Relation { span: shifts.of_span(&one.span)?, ..one.clone() }));
        let old = self.oddities.iter().filter(|odd| odd.kind != OddityKind::DuplicateId);
        let mut oddities: Vec<super::Oddity> = old
            .filter_map(|odd| Some(super::Oddity { span: shifts.of_span(&odd.span)?, ..odd.clone() }))
            .chain(fresh.0.oddities.drain(..).filter(|odd| odd.kind != OddityKind::DuplicateId))
            .collect();
        let sources = self.sources.iter().zip(texts);
        let mut osm = Self {
            sources: sources
                .map(|(Source { name, marked, .. }, text)| Source { name: name.clone(), text, marked: *marked })
                .collect(),
            meta: fresh.0.meta.take().or_else(|| self.meta.clone()),
            generator: self.generator.clone(),
            bounds: self.bounds.clone(),
            nodes: in_file_order(nodes.chain(fresh.0.nodes.drain(..)).collect(), |one| &one.span),
            ways: in_file_order(ways.chain(fresh.0.ways.drain(..)).collect(), |one| &one.span),
            relations: in_file_order(relations.chain(fresh.0.relations.drain(..)).collect(), |one| &one.span),
            ..Self::default()
        };
        osm.index([0; 3]);
        oddities.append(&mut osm.oddities);
        osm.oddities = in_file_order(oddities, |odd| &odd.span);
        Ok(osm)
    }

    /// A part of these elements, without the texts of the files.
    #[must_use]
    pub fn part(&self, kept: &FxHashSet<(ElementKind, i64)>) -> Self {
        let is_kept = |kind, id| kept.contains(&(kind, id));
        let odd = |odd: &&super::Oddity| {
            odd.kind != OddityKind::DuplicateId && odd.element.is_none_or(|(kind, id)| is_kept(kind, id))
        };
        let mut part = Self {
            meta: self.meta.clone(),
            generator: self.generator.clone(),
            bounds: self.bounds.clone(),
            nodes: self.nodes.iter().filter(|one| is_kept(ElementKind::Node, one.id)).cloned().collect(),
            ways: self.ways.iter().filter(|one| is_kept(ElementKind::Way, one.id)).cloned().collect(),
            relations: self.relations.iter().filter(|one| is_kept(ElementKind::Relation, one.id)).cloned().collect(),
            oddities: self.oddities.iter().filter(odd).cloned().collect(),
            ..Self::default()
        };
        part.index([0; 3]);
        part
    }
}

/// Elements of which two runs, each in the order of the files, stand behind each other.
fn in_file_order<T>(mut all: Vec<T>, span: impl Fn(&T) -> &SourceSpan) -> Vec<T> {
    all.sort_by_key(|one| (span(one).file, span(one).start));
    all
}

/// What the new stretches say, each element at its place in the new texts.
struct Fresh(OsmData);

impl Fresh {
    fn read(texts: &[String], stretches: &[Stretch]) -> Result<Self, ReadError> {
        let mut text = "<osm version=\"0.6\">".to_owned();
        // Where each stretch begins in that text.
        let mut starts: Vec<(usize, &Stretch)> = Vec::new();
        for stretch in stretches.iter().filter(|stretch| !stretch.new.is_empty()) {
            starts.push((text.len(), stretch));
            text += texts.get(stretch.old.file as usize).and_then(|of| of.get(stretch.new.clone())).unwrap_or_default();
        }
        text += "</osm>";
        let mut osm = OsmData::default();
        read_bytes(&mut osm, "the mended elements", text.into_bytes())?;
        let put = |span: &mut SourceSpan| {
            let after = starts.partition_point(|(start, _)| *start as u64 <= span.start);
            if let Some((start, stretch)) = after.checked_sub(1).and_then(|at| starts.get(at)) {
                let place = |at: u64| at - *start as u64 + stretch.new.start as u64;
                *span = SourceSpan { file: stretch.old.file, start: place(span.start), end: place(span.end) };
            }
        };
        osm.nodes.iter_mut().for_each(|one| put(&mut one.span));
        osm.ways.iter_mut().for_each(|one| put(&mut one.span));
        osm.relations.iter_mut().for_each(|one| put(&mut one.span));
        osm.oddities.iter_mut().for_each(|one| put(&mut one.span));
        Ok(Self(osm))
    }
}

/// By how much what stays is moved: for each stretch its file, its old place, and by how much what stands behind it is moved.
struct Shifts(Vec<(u32, std::ops::Range<u64>, i64)>);

impl Shifts {
    fn of(stretches: &[Stretch]) -> Self {
        let mut shifts: Vec<(u32, std::ops::Range<u64>, i64)> = Vec::with_capacity(stretches.len());
        for Stretch { old, new } in stretches {
            let before = shifts.last().filter(|(file, ..)| *file == old.file).map_or(0, |(_, _, shift)| *shift);
            let shift = before + new.len() as i64 - (old.end - old.start) as i64;
            shifts.push((old.file, old.start..old.end, shift));
        }
        Self(shifts)
    }

    /// The new place of what was there; `None` where it was replaced.
    fn of_span(&self, span: &SourceSpan) -> Option<SourceSpan> {
        let after = self.0.partition_point(|(file, old, _)| (*file, old.start) <= (span.file, span.start));
        let before = after.checked_sub(1).and_then(|at| self.0.get(at)).filter(|(file, ..)| *file == span.file);
        let Some((_, old, shift)) = before else { return Some(span.clone()) };
        let moved = |at: u64| at.checked_add_signed(*shift);
        match old.contains(&span.start) {
            true => None,
            false => Some(SourceSpan { file: span.file, start: moved(span.start)?, end: moved(span.end)? }),
        }
    }
}
