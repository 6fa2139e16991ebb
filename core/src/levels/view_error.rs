//! How large the error of a collapse is on the screen: from certified errors, the distance of the eye, the height of the
//! screen and the field of view.
//!
//! ```text
//! screen error [pixels] = certified error × viewport height / (2 × distance × tan(field of view / 2))
//! ```
//!
//! The queues need errors that grow along the graph, and distances do not. So every collapse gets a ball that holds its
//! star *and the balls of all collapses that it needs*, and the distance is that of the ball: what needs more is then
//! never farther from the eye, whatever the view.

use glam::DVec3;

use crate::levels::collapse_log::{CollapseLog, LogError};
use crate::levels::dag::CollapseDag;
use crate::levels::replay::{Demand, Replay};
use crate::mesh::Mesh;

/// From where, and how, a surface is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Where the eye is, in the units of the positions.
    pub eye: DVec3,
    /// Height of the viewport, pixels.
    pub viewport_height: f64,
    /// Vertical field of view, radians.
    pub field_of_view: f64,
}

impl View {
    /// What an error at a distance, both in the units of the positions, measures on the screen, in pixels; infinite
    /// where the distance is 0.
    #[must_use]
    pub fn screen_error(&self, error: f64, distance: f64) -> f64 {
        if error == 0.0 {
            return 0.0;
        }
        error * self.viewport_height / (2.0 * distance * (self.field_of_view / 2.0).tan())
    }
}

/// A ball around everything that a collapse changes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Ball {
    centre: DVec3,
    radius: f64,
}

/// Errors and balls of the collapses of a log, both monotone along its graph.
#[derive(Clone, Debug)]
pub struct ViewErrors {
    errors: Vec<f64>,
    balls: Vec<Ball>,
}

impl ViewErrors {
    /// For collapses whose certified errors are `errors`, in the units of the positions. `dag` is that of `log` on
    /// `mesh`.
    ///
    /// # Errors
    /// Where the log cannot be replayed.
    pub fn new(mesh: &Mesh, log: &CollapseLog, dag: &CollapseDag, errors: &[f64]) -> Result<Self, LogError> {
        let mut positions = mesh.positions.clone();
        let mut balls: Vec<Ball> = Vec::with_capacity(dag.len());
        Replay::run(mesh, log, Demand::Consistent, |step| {
            let centre = step.collapse.red_after;
            let to_star = step
                .star
                .vertices()
                .iter()
                .map(|&v| centre.distance(positions[v as usize]));
            let to_balls = dag.constraints(step.index).iter().map(|&needed| {
                let ball = balls[needed as usize];
                centre.distance(ball.centre) + ball.radius
            });
            let radius = to_star.chain(to_balls).fold(0.0, f64::max);
            balls.push(Ball { centre, radius });
            positions[step.collapse.red as usize] = centre;
        })?;
        Ok(Self {
            errors: dag.monotone_errors(errors),
            balls,
        })
    }

    /// The error of a collapse on the screen, in pixels; but for rounding, at least that of any that it needs.
    #[must_use]
    pub fn screen_error(&self, view: &View, collapse: u32) -> f64 {
        let ball = self.balls[collapse as usize];
        let distance = (view.eye.distance(ball.centre) - ball.radius).max(0.0);
        view.screen_error(self.errors[collapse as usize], distance)
    }
}

#[cfg(test)]
#[path = "view_error_tests.rs"]
mod tests;
