//! What a simplifier of curved models is told, and what it knows.

use super::cover::Carrier;
use super::curves::Candidates;
use super::nearest::Scratch;
use super::plan::Tag;
use super::shared_curves::ROUNDING;
use super::surface::Surface;
use crate::curved::model::CurvedModel;

/// When to stop, and what may become of patches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// No patch has a larger certified error, in the model's units.
    pub max_error: f64,
    /// Nothing is merged once there are so few patches.
    pub patches: usize,
    /// How far from straight on the edges of a pair may be, in radians, to begin with.
    pub angle: f64,
    /// The same where nothing else is left.
    pub largest_angle: f64,
    /// The curvature guard: the least cosine between a new patch's normals at its corners and the normal of its corners' triangle.
    pub least_cosine: f64,
    /// The size guard: the longest distance between two corners of a new patch.
    pub longest_side: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            max_error: f64::INFINITY,
            patches: 0,
            angle: 1.2,
            largest_angle: 1.5,
            least_cosine: 0.2,
            longest_side: f64::INFINITY,
        }
    }
}

/// A model while it is simplified.
pub(super) struct Simplifier {
    pub(super) options: Options,
    pub(super) surface: Surface,
    pub(super) tags: Vec<Tag>,
    /// What the removal of each vertex certifies, as it is estimated or was found; infinite where it cannot be removed.
    pub(super) costs: Vec<f64>,
    /// What was last found for each vertex.
    pub(super) found: Vec<f64>,
    /// What each vertex's pairs become, as of when it was last looked at.
    pub(super) candidates: Vec<Candidates>,
    pub(super) is_stale: Vec<bool>,
    /// Whether the edges around each vertex were not looked at since they changed.
    pub(super) may_turn: Vec<bool>,
    /// How many patches there were when nothing could go the last time.
    pub(super) stuck_at: usize,
    pub(super) angle: f64,
    pub(super) limit: f64,
    /// Vertices removed since the level began.
    pub(super) removed: usize,
    pub(super) carrier: Carrier,
    pub(super) scratch: Scratch,
}

impl Simplifier {
    pub(super) fn new(model: CurvedModel, options: &Options) -> Self {
        let vertices = model.topology.vertex_slots() as usize;
        let points = model.patches.iter().flat_map(|patch| patch.points);
        let largest_coordinate = points.fold(0.0, |largest: f64, point| largest.max(point.abs().max_element()));
        Self {
            options: *options,
            surface: Surface::new(model),
            tags: vec![Tag::Undecided; vertices],
            costs: vec![f64::INFINITY; vertices],
            found: vec![0.0; vertices],
            candidates: vec![Candidates::new(); vertices],
            is_stale: vec![true; vertices],
            may_turn: vec![true; vertices],
            stuck_at: 0,
            angle: options.angle,
            limit: ROUNDING * largest_coordinate,
            removed: usize::MAX,
            carrier: Carrier::default(),
            scratch: Scratch::default(),
        }
    }
}
