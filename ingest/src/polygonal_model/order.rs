//! What to make of a model.

use terrain_core::space::simplify::Placement;

/// When to stop simplifying.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// As far as topology allows.
    Coarsest,
    /// With at most so many triangles.
    Triangles(usize),
    /// With as few triangles as an error allows, in the model's units.
    Error(f64),
}

/// What the levels are for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Order {
    /// When to stop simplifying.
    pub(super) target: Target,
    /// Where vertices may go.
    pub(super) placement: Placement,
    /// Whether positions are to be on a lattice, for a `.spm` file.
    pub(super) is_rounded: bool,
}
