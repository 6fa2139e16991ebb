//! Which vertices are worth a try to collapse, and which a round has touched.

/// The tries of a simplifier.
#[derive(Debug)]
pub(crate) struct Attempts {
    is_worth_it: Vec<bool>,
    /// The round in which each vertex was last a red one.
    touched: Vec<u32>,
    round: u32,
}

impl Attempts {
    pub(crate) fn new(vertices: usize) -> Self {
        Self {
            is_worth_it: vec![false; vertices],
            touched: vec![0; vertices],
            round: 0,
        }
    }

    /// Rounds so far.
    pub(crate) fn rounds(&self) -> u32 {
        self.round
    }

    pub(crate) fn begin_round(&mut self) {
        self.round += 1;
    }

    pub(crate) fn is_worth_it(&self, vertex: u32) -> bool {
        self.is_worth_it[vertex as usize]
    }

    pub(crate) fn set_worth_it(&mut self, vertex: u32, is_worth_it: bool) {
        self.is_worth_it[vertex as usize] = is_worth_it;
    }

    /// Keeps the other collapses of the round away from a vertex.
    pub(crate) fn touch(&mut self, vertex: u32) {
        self.touched[vertex as usize] = self.round;
    }

    pub(crate) fn is_any_touched(&self, vertices: &[u32]) -> bool {
        vertices
            .iter()
            .any(|&vertex| self.touched[vertex as usize] == self.round)
    }
}
