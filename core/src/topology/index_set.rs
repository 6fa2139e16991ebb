//! A set of indices that can be changed and listed at the cost of its members.

/// Stands for an index that is not in the set.
const ABSENT: u32 = u32::MAX;

/// Some of the indices from 0 to a limit (P. Briggs, L. Torczon, *An Efficient Representation for Sparse Sets*, 1993).
#[derive(Clone, Debug)]
pub(crate) struct IndexSet {
    members: Vec<u32>,
    /// Where each index stands in `members`, or [`ABSENT`].
    places: Vec<u32>,
}

impl IndexSet {
    pub(crate) fn empty(limit: usize) -> Self {
        Self {
            members: Vec::new(),
            places: vec![ABSENT; limit],
        }
    }

    pub(crate) fn members(&self) -> &[u32] {
        &self.members
    }

    /// Where a member stands among the members.
    pub(crate) fn place(&self, index: u32) -> Option<u32> {
        Some(self.places[index as usize]).filter(|&place| place != ABSENT)
    }

    /// The members, growing, none of which is left.
    pub(crate) fn take(&mut self) -> Vec<u32> {
        let mut taken = std::mem::take(&mut self.members);
        taken.iter().for_each(|&index| self.places[index as usize] = ABSENT);
        taken.sort_unstable();
        taken
    }

    pub(crate) fn set(&mut self, index: u32, is_member: bool) {
        if is_member {
            self.insert(index);
        } else {
            self.remove(index);
        }
    }

    pub(crate) fn insert(&mut self, index: u32) {
        if self.places[index as usize] == ABSENT {
            self.places[index as usize] = self.members.len() as u32;
            self.members.push(index);
        }
    }

    pub(crate) fn remove(&mut self, index: u32) {
        let place = std::mem::replace(&mut self.places[index as usize], ABSENT);
        if place != ABSENT {
            self.members.swap_remove(place as usize);
            if let Some(&moved) = self.members.get(place as usize) {
                self.places[moved as usize] = place;
            }
        }
    }
}
