//! Ids that stay: derived from the ids of the input and the part an element plays, by a hash that never changes.

use std::collections::BTreeSet;
use std::sync::{Mutex, PoisonError};

use rustc_hash::FxHashSet;

/// Every id but a polygon's is above this, so that the two can never meet.
const POLYGON_LIMIT: u64 = 1 << 31;

/// Ids stay below this: what a double (and with it JavaScript) holds exactly.
const LIMIT: u64 = 1 << 53;

/// What identifies an element from one build to the next: words and numbers, hashed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u64);

impl Key {
    /// FNV-1a's offset basis and prime, 64 bits; the finish below mixes the high bits.
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    /// What seven bytes that are 0 multiply the hash by.
    const ZEROS: u64 = Self::PRIME.wrapping_pow(7);

    /// The key of an element that plays this part.
    pub fn new(part: &str) -> Self {
        Self(Self::BASIS).word(part)
    }

    /// Refined by a word.
    #[must_use]
    pub fn word(self, word: &str) -> Self {
        // The length closes a word, so that "ab" + "c" differs from "a" + "bc".
        self.bytes(word.as_bytes()).number(word.len() as i64)
    }

    /// Refined by a number.
    #[must_use]
    pub fn number(self, number: i64) -> Self {
        match u8::try_from(number) {
            Ok(byte) => Self(self.bytes(&[byte]).0.wrapping_mul(Self::ZEROS)),
            Err(_) => self.bytes(&number.to_le_bytes()),
        }
    }

    /// An id for a node that the input does not have: above those of OpenStreetMap, below 2^53.
    pub fn new_node(self) -> i64 {
        (LIMIT / 2 + self.mixed() % (LIMIT / 2)) as i64
    }

    fn bytes(self, bytes: &[u8]) -> Self {
        Self(bytes.iter().fold(self.0, |hash, b| (hash ^ u64::from(*b)).wrapping_mul(Self::PRIME)))
    }

    /// The finish of MurmurHash3, which spreads every bit over the whole word.
    fn mixed(self) -> u64 {
        let mut h = self.0;
        h = (h ^ (h >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
        h = (h ^ (h >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
        h ^ (h >> 33)
    }
}

/// An id before it belongs to a kind of element.
pub type Id = u64;

/// Which ids two elements want. Neither gets them, so that the id of an element depends on no other element, and is the same in any
/// part of the map that is built by itself. Only those of polygons, with 31 bits, are noted: of a million ids with 53 bits two are the
/// same once among ten thousand maps, unless they stand for the same thing, and then they lie side by side.
#[derive(Debug, Default)]
pub struct Contest {
    known: FxHashSet<Id>,
    /// Those found out now: an id that was given, and one that was wanted before and taken.
    found: Mutex<Vec<[Id; 2]>>,
}

impl Contest {
    /// With ids that are known to be wanted twice.
    pub fn of(known: &BTreeSet<i64>) -> Self {
        Self { known: known.iter().map(|id| *id as Id).collect(), found: Mutex::default() }
    }

    /// Whether an id is known to be wanted twice.
    pub fn knows(&self, id: &Id) -> bool {
        self.known.contains(id)
    }

    /// Notes what an element got that wanted these ids, in this order.
    pub fn note(&self, wanted: impl Iterator<Item = Id>, given: i64) {
        let given = given as Id;
        let lost = wanted.take_while(|id| *id != given).filter(|id| !self.knows(id)).map(|id| [given, id]);
        let mut lost = lost.peekable();
        if lost.peek().is_some() {
            self.found.lock().unwrap_or_else(PoisonError::into_inner).extend(lost);
        }
    }

    /// The ids that were wanted and taken, by elements that are there, ascending.
    pub fn found(&self, is_there: impl Fn(i64) -> bool) -> Vec<i64> {
        let found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let lost = found.iter().filter(|[given, _]| is_there(*given as i64)).map(|[_, wanted]| *wanted as i64);
        BTreeSet::from_iter(lost).into_iter().collect()
    }
}

/// The ids that a polygon wants, one after the other.
pub fn wanted_by_polygon(key: Key) -> impl Iterator<Item = Id> {
    choices(key, 1, POLYGON_LIMIT)
}

/// The key's place in `from..to`, and where numbers added to the key lead.
fn choices(key: Key, from: u64, to: u64) -> impl Iterator<Item = Id> {
    (0..).map(move |attempt| {
        let key = if attempt == 0 { key } else { key.number(attempt) };
        from + key.mixed() % (to - from)
    })
}

/// Two parts of a map, made apart, came upon the same id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IdTaken;

/// Hands out ids, each once, whatever the kind of the element.
#[derive(Clone, Debug, Default)]
pub struct Ids {
    taken: FxHashSet<Id>,
    /// Taken too, in half the memory, while no more are claimed.
    resting: Vec<Id>,
    /// Those given back, some of which may have been handed out again.
    released: Vec<Id>,
}

impl Ids {
    /// A positive id below 2^53 for a point, line, lanelet or regulatory element; `elsewhere` tells which ids others
    /// have taken.
    pub fn claim(&mut self, key: Key, elsewhere: impl Fn(&Id) -> bool) -> i64 {
        self.claim_in(key, POLYGON_LIMIT, LIMIT, elsewhere)
    }

    /// An id in 1..=2147483647 for a polygon: Autoware reads it into 32 bits.
    pub fn claim_polygon(&mut self, key: Key, elsewhere: impl Fn(&Id) -> bool) -> i64 {
        self.claim_in(key, 1, POLYGON_LIMIT, elsewhere)
    }

    /// Takes less memory until [`Ids::wake`]; nothing is to be asked until then.
    pub fn rest(&mut self) {
        let taken = std::mem::take(&mut self.taken);
        self.resting.reserve_exact(taken.len());
        self.resting.extend(taken);
    }

    /// Is ready to claim more.
    pub fn wake(&mut self) {
        self.taken.extend(std::mem::take(&mut self.resting));
    }

    /// Takes all ids that others have handed out and that are not asked for any more.
    pub fn pile(&mut self, others: &Self) {
        self.resting.extend(others.all());
    }

    /// Gives back those that were piled up behind so many.
    pub fn split_off(&mut self, count: usize) -> Self {
        Self { resting: self.resting.split_off(count), ..Self::default() }
    }

    /// All that are taken, in any order.
    fn all(&self) -> impl Iterator<Item = &Id> {
        self.taken.iter().chain(&self.resting)
    }

    /// How many are taken.
    pub fn count(&self) -> usize {
        self.taken.len() + self.resting.len()
    }

    /// Makes room for so many more.
    pub fn reserve(&mut self, more: usize) {
        self.taken.reserve(more);
    }

    /// Whether an id has been handed out.
    pub fn taken(&self, id: &Id) -> bool {
        self.taken.contains(id)
    }

    /// Gives an id back: its element is to be made anew.
    pub fn release(&mut self, id: i64) {
        if self.taken.remove(&(id as Id)) {
            self.released.push(id as Id);
        }
    }

    /// The ids that were given back and not handed out again.
    pub fn released(&self) -> FxHashSet<Id> {
        self.released.iter().filter(|id| !self.taken(id)).copied().collect()
    }

    /// Takes all ids that others have handed out.
    ///
    /// # Errors
    /// One of them is taken; then none is added.
    pub fn join(&mut self, others: &Self) -> Result<(), IdTaken> {
        self.taken.reserve(others.count());
        for (joined, id) in others.all().enumerate() {
            if !self.taken.insert(*id) {
                others.all().take(joined).for_each(|id| {
                    self.taken.remove(id);
                });
                return Err(IdTaken);
            }
        }
        Ok(())
    }

    /// Takes all ids that others have handed out, which are none of those taken.
    pub fn join_apart<'a>(&mut self, others: impl Iterator<Item = &'a Self> + Clone) {
        self.taken.reserve(others.clone().map(Self::count).sum());
        self.taken.extend(others.flat_map(Self::all));
    }

    /// Whether none of all these ids has been handed out twice.
    pub fn are_apart<'a>(all: impl Iterator<Item = &'a Self> + Clone + Send + Sync) -> bool {
        let [even, odd] = [0, 1].map(|half| {
            let all = all.clone();
            move || Self::are_half_apart(all, half)
        });
        let (even, odd) = rayon::join(even, odd);
        even && odd
    }

    /// As [`Ids::are_apart`] for the even ids (`half` 0) or the odd ones.
    fn are_half_apart<'a>(all: impl Iterator<Item = &'a Self> + Clone, half: Id) -> bool {
        // Ids are hashes, so few share their last bits with one before: only these are held against all.
        let bits = 8 * all.clone().map(Self::count).sum::<usize>().next_power_of_two().max(8);
        let mut seen = vec![0_u64; bits / 64];
        let mut doubtful = FxHashSet::default();
        let own = || all.clone().flat_map(Self::all).filter(|id| **id % 2 == half);
        for id in own() {
            let place = (*id / 2) as usize % bits;
            let (word, bit) = (&mut seen[place / 64], 1 << (place % 64));
            if *word & bit != 0 && !doubtful.insert(*id) {
                return false;
            }
            *word |= bit;
        }
        own().filter(|id| doubtful.contains(id)).count() == doubtful.len()
    }

    /// The key's place in `from..to`, or where a number added to the key leads if that is taken.
    fn claim_in(&mut self, key: Key, from: u64, to: u64, elsewhere: impl Fn(&Id) -> bool) -> i64 {
        let free = choices(key, from, to).find(|id| !elsewhere(id) && self.taken.insert(*id));
        free.unwrap_or_default() as i64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_frozen() {
        let key = Key::new("lane").number(42).word("left");
        assert_eq!(Ids::default().claim(key, FREE), Ids::default().claim(key, FREE));
        assert_eq!(Key::new("").0, Key(Key::BASIS).number(0).0);
        assert_eq!(Ids::default().claim(Key::new("point").number(1), FREE), FROZEN_POINT);
        assert_eq!(Ids::default().claim_polygon(Key::new("area").number(1), FREE), FROZEN_AREA);
    }

    const FREE: fn(&Id) -> bool = |_| false;
    const FROZEN_POINT: i64 = 3_848_924_037_313_406;
    const FROZEN_AREA: i64 = 648_029_609;

    #[test]
    fn ids_lie_in_their_ranges_and_never_repeat() {
        let mut ids = Ids::default();
        let mut seen = FxHashSet::default();
        for i in 0..20_000 {
            let id = ids.claim(Key::new("point").number(i), FREE);
            assert!((1 << 31..1 << 53).contains(&id));
            assert!(seen.insert(id));
            let id = ids.claim_polygon(Key::new("area").number(i), FREE);
            assert!((1..=i64::from(i32::MAX)).contains(&id));
            assert!(seen.insert(id));
        }
    }

    #[test]
    fn what_two_want_neither_gets() {
        let key = |i: i64| Key::new("area").number(i);
        let contest = Contest::default();
        let mut ids = Ids::default();
        let claim = |ids: &mut Ids, contest: &Contest, i: i64| {
            let id = ids.claim_polygon(key(i), |id| contest.knows(id));
            contest.note(wanted_by_polygon(key(i)), id);
            id
        };
        let taken = claim(&mut ids, &contest, 1);
        assert!(contest.found(|_| true).is_empty());
        // Another that wants the same, as if its hash were the same.
        let second = ids.claim_polygon(key(1), |_| false);
        contest.note(wanted_by_polygon(key(1)), second);
        assert_eq!((contest.found(|_| true), contest.found(|id| id == taken)), (vec![taken], vec![]));
        let contest = Contest::of(&BTreeSet::from([taken]));
        assert_eq!(claim(&mut Ids::default(), &contest, 1), second);
        assert!(contest.found(|_| true).is_empty());
    }

    #[test]
    fn a_taken_id_gives_way_deterministically() {
        let key = Key::new("point");
        let two = || {
            let mut ids = Ids::default();
            (ids.claim(key, FREE), ids.claim(key, FREE))
        };
        assert_eq!(two(), two());
        assert_ne!(two().0, two().1);
    }

    #[test]
    fn parts_made_apart_join_unless_they_share_an_id() {
        let key = Key::new("point");
        let [mut a, mut b, mut c] = [Ids::default(), Ids::default(), Ids::default()];
        let first = a.claim(key, FREE);
        b.claim(key, FREE);
        assert_ne!(c.claim(key, |id| a.taken(id)), first);
        assert!(Ids::are_apart([&a, &c].into_iter()) && !Ids::are_apart([&a, &b, &c].into_iter()));
        c.rest();
        assert!(Ids::are_apart([&a, &c].into_iter()) && !Ids::are_apart([&c, &b, &c].into_iter()));
        assert_eq!((a.join(&c), a.join(&b)), (Ok(()), Err(IdTaken)));
        c.wake();
        assert!(c.count() == 1 && c.all().all(|id| c.taken(id) && a.taken(id)));
    }
}
