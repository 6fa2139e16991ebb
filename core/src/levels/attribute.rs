//! What a vertex has besides connectivity: a position, a normal, a colour, a texture coordinate (Surface Partitions
//! §2.3, "Red vertices are allowed to move").
//!
//! A blue vertex is not drawn any more, so its entry in a second array is free to keep what the red vertex had before
//! the collapse. Undoing exchanges the two entries, and doing again exchanges them back:
//!
//! ```text
//!              red array             blue array
//! collapse     red ← new value       blue ← old value of the red vertex
//! undo, redo   red ↔ the blue array's entry of the blue vertex
//! ```

use std::ops::Range;

/// One attribute of all vertices.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Attribute<T> {
    /// The value of each vertex as it is now; of a blue one, as it was when it left the surface.
    pub red: Vec<T>,
    /// What the representative of each blue vertex had before the collapse; of a red one, nothing of use.
    pub blue: Vec<T>,
}

impl<T: Copy> Attribute<T> {
    /// The attribute before any collapse.
    #[must_use]
    pub fn new(values: Vec<T>) -> Self {
        Self {
            blue: values.clone(),
            red: values,
        }
    }

    /// Saves the red vertex's value on the blue vertex and gives the red one `after`.
    pub fn collapse(&mut self, blue: u32, red: u32, after: T) {
        self.blue[blue as usize] = std::mem::replace(&mut self.red[red as usize], after);
    }

    /// Gives the red vertex back what it had before `blue` collapsed into it, or, where that is undone already, what
    /// it had afterwards. Among collapses into one red vertex, the last performed is the first to be undone.
    pub fn exchange(&mut self, blue: u32, red: u32) {
        std::mem::swap(&mut self.red[red as usize], &mut self.blue[blue as usize]);
    }

    /// Undoes the collapses of the vertices in `range` of a Surface Partition's order, coarsest first.
    pub fn undo(&mut self, representatives: &[u32], range: Range<usize>) {
        for blue in range {
            self.exchange(blue as u32, representatives[blue]);
        }
    }

    /// Performs the collapses of the vertices in `range` again, finest first: the opposite of [`Self::undo`].
    pub fn redo(&mut self, representatives: &[u32], range: Range<usize>) {
        for blue in range.rev() {
            self.exchange(blue as u32, representatives[blue]);
        }
    }

    /// The same with vertex `order[i]` in place `i`.
    #[must_use]
    pub fn sorted(&self, order: &[u32]) -> Self {
        let gather = |values: &[T]| order.iter().map(|&vertex| values[vertex as usize]).collect();
        Self {
            red: gather(&self.red),
            blue: gather(&self.blue),
        }
    }
}
