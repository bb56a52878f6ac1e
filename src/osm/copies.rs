//! Elements that stand in several files of one map: each is kept once, and where two of one id differ, that is said.

use std::hash::{DefaultHasher, Hash, Hasher};

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Element, ElementKind, Node, Oddity, OddityKind, OsmData, Relation, Way};
use crate::text::SourceSpan;

/// Two elements of one id in two files, which differ.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Contradiction {
    /// The kind of both.
    pub kind: ElementKind,
    /// The id of both.
    pub id: i64,
    /// Where they stand.
    pub spans: [SourceSpan; 2],
}

/// What an element says, apart from its id.
pub trait Content: Hash {
    /// A number that differs where the content does, but for one case in 2^64. It is the same in all runs of one program.
    fn fingerprint(&self) -> u64 {
        let mut hasher = DefaultHasher::new();
        self.hash(&mut hasher);
        hasher.finish()
    }
}

impl Hash for Node {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Minus zero is zero.
        self.position.map(|place| [place.lon + 0.0, place.lat + 0.0].map(f64::to_bits)).hash(state);
        self.tags.words().for_each(|word| word.hash(state));
    }
}

impl Hash for Way {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.nodes.hash(state);
        self.tags.words().for_each(|word| word.hash(state));
    }
}

impl Hash for Relation {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.members.len().hash(state);
        self.members.iter().for_each(|member| (member.kind, member.id, member.role.as_str()).hash(state));
        self.tags.words().for_each(|word| word.hash(state));
    }
}

impl Content for Node {}
impl Content for Way {}
impl Content for Relation {}

impl OsmData {
    /// Keeps each element of several files once: what a later file repeats is left out, with all that reading noted of it.
    /// Elements that contradict each other are kept and returned, by kind and then in the order of the files.
    pub fn leave_out_copies(&mut self) -> Vec<Contradiction> {
        let mut copies = Copies::default();
        copies.of(&mut self.nodes);
        copies.of(&mut self.ways);
        copies.of(&mut self.relations);
        if !copies.left_out.is_empty() {
            copies.left_out.sort_unstable();
            self.index_anew();
            let of_copies = |oddity: &Oddity| {
                let holds = |(file, start, end): &(u32, u64, u64)| {
                    *file == oddity.span.file && (*start..*end).contains(&oddity.span.start)
                };
                let at = copies.left_out.partition_point(|(file, start, _)| (*file, *start) <= key(&oddity.span));
                at.checked_sub(1).and_then(|at| copies.left_out.get(at)).is_some_and(holds)
            };
            self.oddities.retain(|oddity| !of_copies(oddity));
        }
        copies.contradictions
    }

    /// Puts the elements of each kind in the order of their ids.
    pub fn sort_by_id(&mut self) {
        self.nodes.sort_by_key(|one| one.id);
        self.ways.sort_by_key(|one| one.id);
        self.relations.sort_by_key(|one| one.id);
        self.index_anew();
    }

    /// The index of elements that have moved, with ids that repeat noted again.
    fn index_anew(&mut self) {
        self.oddities.retain(|oddity| oddity.kind != OddityKind::DuplicateId);
        self.node_index.clear();
        self.way_index.clear();
        self.relation_index.clear();
        self.index([0; 3]);
        self.oddities.sort_by(|a, b| a.span.cmp(&b.span));
    }
}

fn key(span: &SourceSpan) -> (u32, u64) {
    (span.file, span.start)
}

/// What was found of copies.
#[derive(Default)]
struct Copies {
    contradictions: Vec<Contradiction>,
    /// Where copies stand that were left out: file, begin, end.
    left_out: Vec<(u32, u64, u64)>,
}

impl Copies {
    fn of<E: Element + Content>(&mut self, elements: &mut Vec<E>) {
        // Files may have an id more than once: then the first is held against the first, the second against the second.
        let mut first_of: FxHashMap<(i64, u32), (u64, SourceSpan)> = FxHashMap::default();
        let mut in_file: FxHashMap<i64, (u32, u32)> = FxHashMap::default();
        let several = elements.first().zip(elements.last()).is_some_and(|(first, last)| {
            let [(.., a), (.., b)] = [first, last].map(Element::identity);
            a.file != b.file
        });
        if !several {
            return;
        }
        let mut told = FxHashSet::default();
        elements.retain(|element| {
            let (kind, id, span) = element.identity();
            let (file, times) = in_file.entry(id).or_insert((span.file, 0));
            *times = if *file == span.file { *times + 1 } else { 1 };
            *file = span.file;
            let fingerprint = element.fingerprint();
            let Some((known, place)) = first_of.get(&(id, *times)) else {
                first_of.insert((id, *times), (fingerprint, span.clone()));
                return true;
            };
            if *known == fingerprint {
                self.left_out.push((span.file, span.start, span.end));
                return false;
            }
            if told.insert(id) {
                self.contradictions.push(Contradiction { kind, id, spans: [place.clone(), span.clone()] });
            }
            true
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osm::read_bytes;

    fn read(files: &[&str]) -> OsmData {
        let mut data = OsmData::default();
        for (i, text) in files.iter().enumerate() {
            read_bytes(&mut data, &i.to_string(), format!("<osm>{text}</osm>").into_bytes()).unwrap();
        }
        data
    }

    const NODE: &str = "<node id='1' lat='2' lon='3'><tag k='a' v='b'/></node>";

    #[test]
    fn a_copy_is_left_out() {
        let other = "<node lon='3.0' id='1' lat=\"2\">\n<tag k='a' v='b'/></node><node id='0' lat='2' lon='3'/>";
        let mut data = read(&[NODE, other, NODE]);
        assert_eq!(data.leave_out_copies(), []);
        data.sort_by_id();
        assert_eq!(data.nodes.iter().map(|one| one.id).collect::<Vec<_>>(), [0, 1]);
        assert!(data.oddities.is_empty(), "{:?}", data.oddities);
        assert_eq!(data.node(1).unwrap().span.file, 0);
    }

    #[test]
    fn what_differs_is_told_once_and_kept() {
        let moved = NODE.replace("'2'", "'2.1'");
        let mut data = read(&[NODE, &moved, &moved]);
        let found = data.leave_out_copies();
        assert_eq!(found.iter().map(|one| (one.kind, one.id)).collect::<Vec<_>>(), [(ElementKind::Node, 1)]);
        assert_eq!(found[0].spans.each_ref().map(|span| span.file), [0, 1]);
        assert_eq!(data.nodes.len(), 3);
    }

    #[test]
    fn an_id_that_repeats_in_one_file_stays_repeated_and_what_reading_noted_of_copies_goes() {
        let way = "<way id='5'><nd ref='x'/></way>";
        let file = format!("{NODE}{NODE}{way}");
        let mut data = read(&[&file, &file]);
        assert_eq!(data.leave_out_copies(), []);
        assert_eq!((data.nodes.len(), data.ways.len()), (2, 1));
        let kinds: Vec<_> = data.oddities.iter().map(|one| (one.kind, one.span.file)).collect();
        assert_eq!(kinds, [(OddityKind::DuplicateId, 0), (OddityKind::BadElement, 0)]);
    }
}
