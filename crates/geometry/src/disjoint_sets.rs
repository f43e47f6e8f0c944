//! Which of some members hang together.
//!
//! Source: union–find (Galler and Fischer 1964) with path halving. Cost: all but constant a step.

/// Sets of members that are numbered from 0; at first each is alone.
#[derive(Clone, Debug)]
pub struct DisjointSets(Vec<u32>);

impl DisjointSets {
    /// So many sets of one member.
    pub fn new(count: usize) -> Self {
        Self((0..count as u32).collect())
    }

    /// The least member of a member's set.
    ///
    /// # Panics
    /// If there is no such member.
    pub fn root(&mut self, mut member: u32) -> u32 {
        while self.0[member as usize] != member {
            self.0[member as usize] = self.0[self.0[member as usize] as usize];
            member = self.0[member as usize];
        }
        member
    }

    /// Makes the sets of two members one.
    ///
    /// # Panics
    /// If there are no such members.
    pub fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller root stays, so that the result does not depend on the order of the joins.
        self.0[a.max(b) as usize] = a.min(b);
    }
}
