//! Disjoint sets of the first so many numbers.

/// Each number with another one of its set, or itself.
pub struct UnionFind(Vec<usize>);

impl UnionFind {
    /// Every number alone.
    pub fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The least number of a set, by any of it.
    pub fn root(&mut self, mut at: usize) -> usize {
        while self.0[at] != at {
            self.0[at] = self.0[self.0[at]];
            at = self.0[at];
        }
        at
    }

    /// Makes the sets of two numbers one. The order of the sets remains that of their first members.
    pub fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
