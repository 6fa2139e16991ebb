//! What a simplifier is told: what each vertex may do, what a band allows, what holds for all, and how much work to do.

/// What a vertex may do in a collapse.
///
/// | kind | as blue, into | as red | reason |
/// | --- | --- | --- | --- |
/// | `Free` | any but `Border` | yes, height free, place free if blue is `Free` | |
/// | `OnColumn`, `OnRow` | same line | yes, height free | the strip along a tile's side stays straight |
/// | `Outline` | along the outline | yes, height free | the hole keeps its shape within the tolerance, or is closed |
/// | `Breakline` | along the breakline | yes, height free | the line keeps its shape within the tolerance |
/// | `Fixed` | no | yes | corners; ends of breaklines, and where they meet |
/// | `Border` | only by `Simplifier::collapse_border` | no | shared with other tiles |
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VertexKind {
    /// Inside the surface.
    Free,
    /// On a line of constant x.
    OnColumn,
    /// On a line of constant y.
    OnRow,
    /// On the edge of the surface.
    Outline,
    /// Between the ends of a breakline.
    Breakline,
    /// Stays where it is.
    Fixed,
    /// On a tile's side.
    Border,
}

impl VertexKind {
    pub(crate) fn keeps_height(self) -> bool {
        matches!(self, Self::Fixed | Self::Border)
    }
}

/// What a band allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Allowance {
    /// Metres that the surface may stray vertically.
    pub vertical: f64,
    /// Metres that the outline may stray from that of the mesh the simplifier began with, in plan view; what of a hole is within
    /// them may be closed.
    pub outline: f64,
    /// The same for breaklines.
    pub breaklines: f64,
}

/// What holds for all bands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shape {
    /// Heights are multiples of this, metres; 0 leaves them free.
    pub height_step: f64,
    /// No edit makes a triangle of a smaller altitude than this, in plan units.
    pub least_altitude: f64,
}

/// How much work goes into few triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Collapses keep the red vertex where it is; three neighbours of each vertex are tried, once.
    Fast,
    /// The red vertex may go to the middle of the edge; four neighbours are tried, again wherever something changed.
    Default,
    /// All neighbours, more places; edge swaps and vertex moves where no log is kept.
    Best,
}

impl Quality {
    /// Where on the edge the red vertex is tried, as shares of the way from its own place to the blue vertex's.
    pub(crate) fn places(self) -> &'static [f64] {
        match self {
            Self::Fast => &[0.0],
            Self::Default => &[0.0, 0.5],
            Self::Best => &[0.0, 0.5, 0.25],
        }
    }

    /// Into how many of its neighbours, the nearest first, a vertex is tried to collapse.
    pub(crate) fn neighbours(self) -> usize {
        match self {
            Self::Fast => 3,
            Self::Default => 4,
            Self::Best => usize::MAX,
        }
    }
}
