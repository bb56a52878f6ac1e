//! Stable ids: a hash, which never changes, of the ids of the input and of the part that an element plays.
//!
//! The id of an element depends on its key alone, so that an element has the same id in every tile of the map. An id that belongs
//! to two keys is contested: neither element gets it.

use std::ops::Range;

/// Ids of polygons: Autoware reads them into 32 bits.
const SHORT: Range<u64> = 1..1 << 31;

/// Ids of lines, lanelets and regulatory elements, apart from those of polygons. Doubles, and so JavaScript, hold them exactly.
const LONG: Range<u64> = SHORT.end..1 << 53;

/// Ids of points, apart from those of polygons: GDAL 3 keeps nodes in buckets of 65,536, numbered in 31 bits, and reads no others
/// (ogr/ogrsf_frmts/osm).
const NODE: Range<u64> = SHORT.end..65_536 * ((1 << 31) - 1);

/// The hash of the words and numbers that identify an element from one build to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Key(u64);

impl Key {
    /// FNV-1a's offset basis and prime, 64 bits; the finish below mixes the high bits.
    const BASIS: u64 = 0xcbf2_9ce4_8422_2325;
    const PRIME: u64 = 0x0000_0100_0000_01b3;
    /// The factor by which seven bytes of 0 multiply the hash.
    const ZEROS: u64 = Self::PRIME.wrapping_pow(7);

    /// The key of elements that play this part.
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
        self.id_in(LONG.end / 2..LONG.end)
    }

    /// The id of a point: positive, below 65,536 × (2^31 − 1), none of those that are `contested`.
    pub fn node_id(self, contested: impl Fn(i64) -> bool) -> i64 {
        self.first_in(NODE, contested)
    }

    /// The id of a line, lanelet or regulatory element: positive, below 2^53, none of those that are `contested`.
    pub fn id(self, contested: impl Fn(i64) -> bool) -> i64 {
        self.first_in(LONG, contested)
    }

    /// As [`Key::id`] in 1..=2147483647, for polygons.
    pub fn short_id(self, contested: impl Fn(i64) -> bool) -> i64 {
        self.first_in(SHORT, contested)
    }

    /// The id of the key in a range; if that is contested, the id of the key refined by the first number whose id is not.
    fn first_in(self, range: Range<u64>, contested: impl Fn(i64) -> bool) -> i64 {
        let keys = std::iter::once(self).chain((1..).map(|attempt| self.number(attempt)));
        keys.map(|key| key.id_in(range.clone())).find(|id| !contested(*id)).unwrap_or_default()
    }

    fn id_in(self, range: Range<u64>) -> i64 {
        (range.start + self.mixed() % (range.end - range.start)) as i64
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

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    const FREE: fn(i64) -> bool = |_| false;
    const FROZEN_POINT: i64 = 43_196_421_763_966;
    const FROZEN_LINE: i64 = 3_848_924_037_313_406;
    const FROZEN_AREA: i64 = 648_029_609;

    #[test]
    fn ids_are_frozen() {
        assert_eq!(Key::new("").0, Key(Key::BASIS).number(0).0);
        assert_eq!(Key::new("point").number(1).node_id(FREE), FROZEN_POINT);
        assert_eq!(Key::new("point").number(1).id(FREE), FROZEN_LINE);
        assert_eq!(Key::new("area").number(1).short_id(FREE), FROZEN_AREA);
    }

    #[test]
    fn ids_lie_in_their_ranges() {
        for i in 0..20_000 {
            assert!((1 << 31..1 << 53).contains(&Key::new("line").number(i).id(FREE)));
            assert!((1 << 31..140_737_488_289_792).contains(&Key::new("point").number(i).node_id(FREE)));
            assert!((1..=i64::from(i32::MAX)).contains(&Key::new("area").number(i).short_id(FREE)));
        }
    }

    #[test]
    fn a_contested_id_gives_way_to_another() {
        let key = Key::new("area").number(1);
        let first = key.short_id(FREE);
        let second = key.short_id(|id| id == first);
        let contested = BTreeSet::from([first, second]);
        let third = key.short_id(|id| contested.contains(&id));
        assert!(first != second && !contested.contains(&third));
    }
}
