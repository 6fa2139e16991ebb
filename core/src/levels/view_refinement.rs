//! A partition that is drawn as a view needs it: fine where it is near, coarse where it is far and beside the picture (Surface
//! Partitions §3).
//!
//! ```text
//! partition ─▶ finest surface, its collapses ──replay──▶ AdaptiveSurface, ViewErrors
//! each view ─▶ needed splits ──both queues──▶ splits and collapses ─▶ the triangles and vertices to draw anew
//! ```
//!
//! A collapse errs as much as the level that it leads to, so where a part of the surface is drawn at one level, that level's claim holds
//! for it. Where levels meet there are triangles that none of them has, of which nothing is claimed.
//!
//! What is drawn depends on the view alone, not on the ones before: the fewest splits in which all are whose errors are larger than what
//! is allowed, and all that these force.

use std::cell::RefCell;

use crate::levels::adaptive_surface::AdaptiveSurface;
use crate::levels::collapse_log::{CollapseLog, LogError};
use crate::levels::partition::SurfacePartition;
use crate::levels::refinement_queues::{Changes, RefinementQueues};
use crate::levels::view_error::{View, ViewErrors};

/// A surface that is refined from view to view.
#[derive(Clone, Debug)]
pub struct ViewRefinement {
    surface: AdaptiveSurface,
    errors: ViewErrors,
    queues: RefinementQueues,
}

impl ViewRefinement {
    /// A valid partition, at its coarsest.
    ///
    /// # Errors
    /// Where its surface is no 2-manifold on which its collapses can be performed.
    pub fn new(partition: &SurfacePartition) -> Result<Self, LogError> {
        let (mesh, log) = partition.to_log();
        let surface = AdaptiveSurface::new(&mesh, &log)?;
        Ok(Self {
            errors: ViewErrors::new(&mesh, &log, surface.dag(), &errors(&log))?,
            queues: RefinementQueues::new(&surface, |_| 0.0),
            surface,
        })
    }

    /// Splits and collapses until no error in the picture is larger than `within` pixels, and nothing is finer than that needs.
    pub fn refine(&mut self, view: &View, within: f64) -> Changes {
        let Self {
            surface,
            errors,
            queues,
        } = self;
        let needed = RefCell::new(errors.needed_splits(view, within));
        let error = |collapse: u32| f64::from(u8::from(needed.borrow_mut().contains(collapse)));
        let entries = queues.refill(surface, error);
        let mut changes = queues.update(surface, 0.5, error);
        changes.operations += entries;
        changes
    }

    /// What is drawn.
    #[must_use]
    pub fn surface(&self) -> &AdaptiveSurface {
        &self.surface
    }

    /// See [`AdaptiveSurface::take_undrawn`].
    pub fn take_undrawn(&mut self) -> [Vec<u32>; 2] {
        self.surface.take_undrawn()
    }
}

/// Of each collapse, the error of the band that it is in.
fn errors(log: &CollapseLog) -> Vec<f64> {
    let mut start = 0;
    let of_band = log.bands.iter().flat_map(|band| {
        let count = band.end - std::mem::replace(&mut start, band.end);
        std::iter::repeat_n(band.error, count)
    });
    of_band.collect()
}
