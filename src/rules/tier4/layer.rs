//! The order in which the existing validator visits lanelets. The file does not show it: it is the order of a hash table in
//! memory. It depends on the ids alone, and decides which of two lanelets comes first where both would do.

use crate::lanelet::Point;
use crate::lanelet::index::view::View;

/// Numbers of buckets that the table of the GNU library grows through.
const BUCKETS: [usize; 22] = [
    13, 29, 59, 127, 257, 541, 1109, 2357, 5087, 10273, 20753, 42043, 85229, 172_933, 351_061, 712_697, 1_447_153,
    2_938_679, 5_967_347, 12_117_689, 24_607_243, 49_969_847,
];

/// The point that comes first among those of which something holds.
pub fn first_point<'m>(view: &View<'m>, holds: impl Fn(&Point) -> bool) -> Option<&'m Point> {
    let mut points: Vec<&Point> = view.map.points.iter().collect();
    points.sort_by_key(|point| point.id);
    let ids: Vec<i64> = points.iter().map(|point| point.id.0).collect();
    order(&ids).into_iter().map(|at| points[at]).find(|point| holds(point))
}

/// For every lanelet of the view how many come before it.
pub fn ranks(view: &View) -> Vec<usize> {
    let mut by_id: Vec<usize> = (0..view.lanelets.len()).collect();
    by_id.sort_by_key(|&at| view.lanelets[at].id());
    let ids: Vec<i64> = by_id.iter().map(|&at| view.lanelets[at].id().0).collect();
    let mut ranks = vec![0; ids.len()];
    for (rank, at) in order(&ids).into_iter().enumerate() {
        ranks[by_id[at]] = rank;
    }
    ranks
}

/// The positions of keys in the order in which the table lists them after they were inserted one after the other.
fn order(keys: &[i64]) -> Vec<usize> {
    let mut table = HashLayout { keys, next: vec![NONE; keys.len() + 1], before: vec![NONE; BUCKETS[0]] };
    for at in 0..keys.len() {
        if at == table.before.len() {
            let larger = BUCKETS.iter().find(|&&count| count > at).copied().unwrap_or(2 * at + 1);
            table.grow(larger);
        }
        table.put(at);
    }
    table.order()
}

/// No entry.
const NONE: usize = usize::MAX;

/// A list of entries, those of a bucket side by side; entry 0 is the head, key `i` stands in entry `i + 1`.
struct HashLayout<'a> {
    keys: &'a [i64],
    next: Vec<usize>,
    /// For every bucket the entry before its first.
    before: Vec<usize>,
}

impl HashLayout<'_> {
    fn bucket(&self, entry: usize) -> usize {
        // As many bits as the table's own hash has.
        #[allow(clippy::cast_sign_loss, reason = "negative ids wrap around there, too")]
        let hash = self.keys[entry - 1] as u64;
        (hash % self.before.len() as u64) as usize
    }

    /// An entry comes first in its bucket, and a bucket that was empty comes first of all.
    fn put(&mut self, at: usize) {
        let entry = at + 1;
        let bucket = self.bucket(entry);
        if self.before[bucket] == NONE {
            self.next[entry] = self.next[0];
            self.next[0] = entry;
            if self.next[entry] != NONE {
                let behind = self.bucket(self.next[entry]);
                self.before[behind] = entry;
            }
            self.before[bucket] = 0;
        } else {
            let before = self.before[bucket];
            self.next[entry] = self.next[before];
            self.next[before] = entry;
        }
    }

    fn grow(&mut self, buckets: usize) {
        let order = self.order();
        self.next.fill(NONE);
        self.before = vec![NONE; buckets];
        order.into_iter().for_each(|at| self.put(at));
    }

    fn order(&self) -> Vec<usize> {
        let follow = |&entry: &usize| Some(self.next[entry]).filter(|&next| next != NONE);
        std::iter::successors(follow(&0), follow).map(|entry| entry - 1).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn what_comes_last_comes_first_until_buckets_are_shared() {
        assert_eq!(order(&[1, 2, 3]), [2, 1, 0]);
        // 14 falls into the bucket of 1, and is before it there.
        assert_eq!(order(&[1, 2, 14]), [1, 2, 0]);
        assert_eq!(order(&[]), [0; 0]);
    }

    #[test]
    fn growing_turns_the_order_around() {
        let keys: Vec<i64> = (0..14).collect();
        assert_eq!(order(&keys), [13, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]);
    }
}
