//! How large the error of a collapse is on the screen: from certified errors, the distance of the eye and the focal length; 0
//! beside the picture.
//!
//! ```text
//! screen error [pixels] = certified error × focal length [pixels] / distance
//! ```
//!
//! A collapse is seen where its star is. It has to be split if it is larger on the screen than what is allowed, or if one is that it
//! needs: [`NeededSplits`]. To ask all of these would cost as much as there are, so every collapse gets a box that holds its star *and those of
//! all collapses that it needs*, and the largest error of all of them. By these it is never smaller on the screen than what it
//! needs, whatever the view, and where even they are small, nothing below is asked.

use std::sync::Arc;

use glam::DVec3;

use crate::levels::collapse_log::{CollapseLog, LogError};
use crate::levels::dag::CollapseDag;
use crate::levels::replay::{Demand, Replay};
use crate::mesh::Mesh;
use crate::selection::camera::HalfSpace;

/// From where, and how, a surface is looked at.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// Where the eye is, in the units of the positions.
    pub eye: DVec3,
    /// How many pixels a length has that is seen from as far away as it is long: half the picture's height over the tangent of
    /// half its angle.
    pub focal_length: f64,
    /// What is in the picture is in all of these; none where all around is of interest.
    pub frustum: Vec<HalfSpace>,
}

impl View {
    /// What an error at a distance, both in the units of the positions, measures on the screen, in pixels; infinite
    /// where the distance is 0.
    #[must_use]
    pub fn screen_error(&self, error: f64, distance: f64) -> f64 {
        if error == 0.0 {
            return 0.0;
        }
        error * self.focal_length / distance
    }

    /// Whether some of a box may be in the picture.
    fn sees(&self, bounds: Bounds) -> bool {
        let reaches = |side: &HalfSpace| {
            let farthest = DVec3::select(side.normal.cmpgt(DVec3::ZERO), bounds.high, bounds.low);
            side.normal.dot(farthest) + side.offset >= 0.0
        };
        self.frustum.iter().all(reaches)
    }
}

/// A box along the axes, around all that a collapse changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    fn of(place: DVec3) -> Self {
        Self {
            low: place,
            high: place,
        }
    }

    fn with(self, other: Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
        }
    }

    fn distance(self, place: DVec3) -> f64 {
        place.clamp(self.low, self.high).distance(place)
    }
}

/// An error, and where it is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
struct SeenError {
    error: f64,
    bounds: Bounds,
}

impl SeenError {
    /// Pixels.
    fn on_screen(self, view: &View) -> f64 {
        if !view.sees(self.bounds) {
            return 0.0;
        }
        view.screen_error(self.error, self.bounds.distance(view.eye))
    }
}

/// Errors and boxes of the collapses of a log: of each alone, and with all that it needs.
#[derive(Clone, Debug)]
pub struct ViewErrors {
    dag: Arc<CollapseDag>,
    own: Vec<SeenError>,
    with_needed: Vec<SeenError>,
}

impl ViewErrors {
    /// For collapses whose certified errors are `errors`, in the units of the positions. `dag` is that of `log` on
    /// `mesh`.
    ///
    /// # Errors
    /// Where the log cannot be replayed.
    pub fn new(mesh: &Mesh, log: &CollapseLog, dag: &Arc<CollapseDag>, errors: &[f64]) -> Result<Self, LogError> {
        let mut positions = mesh.positions.clone();
        let (mut own, mut with_needed) = (
            Vec::with_capacity(dag.len()),
            Vec::<SeenError>::with_capacity(dag.len()),
        );
        let monotone = dag.monotone_errors(errors);
        Replay::run(mesh, log, Demand::Consistent, |step| {
            let (index, red_after) = (step.index as usize, step.collapse.red_after);
            let star = step
                .star
                .vertices()
                .iter()
                .map(|&vertex| Bounds::of(positions[vertex as usize]));
            let bounds = star.fold(Bounds::of(red_after), Bounds::with);
            let needed = dag.constraints(step.index).iter();
            let with_all = needed.fold(bounds, |all, &needed| all.with(with_needed[needed as usize].bounds));
            own.push(SeenError {
                error: errors[index],
                bounds,
            });
            with_needed.push(SeenError {
                error: monotone[index],
                bounds: with_all,
            });
            positions[step.collapse.red as usize] = red_after;
        })?;
        Ok(Self {
            dag: Arc::clone(dag),
            own,
            with_needed,
        })
    }

    /// The error of a collapse on the screen, in pixels.
    #[must_use]
    pub fn screen_error(&self, view: &View, collapse: u32) -> f64 {
        self.own[collapse as usize].on_screen(view)
    }

    /// No less than the error on the screen of a collapse, and than that of anything that it needs.
    #[must_use]
    pub fn largest_screen_error(&self, view: &View, collapse: u32) -> f64 {
        self.with_needed[collapse as usize].on_screen(view)
    }

    /// What has to be split, so that nothing is seen of an error of more than `within` pixels.
    #[must_use]
    pub fn needed_splits<'a>(&'a self, view: &'a View, within: f64) -> NeededSplits<'a> {
        NeededSplits {
            errors: self,
            view,
            within,
            found: vec![None; self.own.len()],
            path: Vec::new(),
        }
    }
}

/// Which collapses a view must have split, found out as it is asked, each once.
#[derive(Clone, Debug)]
pub struct NeededSplits<'a> {
    errors: &'a ViewErrors,
    view: &'a View,
    within: f64,
    found: Vec<Option<bool>>,
    /// Collapses that are being asked, each needed by the one before, and how many of those that they need have been asked.
    path: Vec<(u32, usize)>,
}

impl NeededSplits<'_> {
    /// Whether a collapse, or one that it needs, is larger on the screen than what is allowed.
    pub fn contains(&mut self, collapse: u32) -> bool {
        if let Some(found) = self.known(collapse) {
            return found;
        }
        self.path.push((collapse, 0));
        while let Some((above, asked)) = self.path.last_mut() {
            let (above, next) = (*above, self.errors.dag.constraints(*above).get(*asked));
            *asked += 1;
            match next.map(|&needed| (needed, self.known(needed))) {
                None => {
                    self.found[above as usize] = Some(false);
                    self.path.pop();
                }
                Some((_, Some(false))) => {}
                Some((needed, None)) => self.path.push((needed, 0)),
                Some((_, Some(true))) => {
                    for (resting, _) in self.path.drain(..) {
                        self.found[resting as usize] = Some(true);
                    }
                }
            }
        }
        self.found[collapse as usize] == Some(true)
    }

    /// What is known of a collapse without asking those that it needs.
    fn known(&mut self, collapse: u32) -> Option<bool> {
        let Self { errors, view, .. } = *self;
        let known = &mut self.found[collapse as usize];
        if known.is_none() {
            if errors.screen_error(view, collapse) > self.within {
                *known = Some(true);
            } else if errors.largest_screen_error(view, collapse) <= self.within {
                *known = Some(false);
            }
        }
        *known
    }
}

#[cfg(test)]
#[path = "view_error_tests.rs"]
mod tests;
