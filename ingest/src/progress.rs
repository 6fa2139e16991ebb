//! Tells a person at a terminal how far a long job is: bars on a terminal, one line a stage elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

/// A job in stages, one after the other. Clones report to the same job, from any thread.
#[derive(Clone, Default)]
pub struct Progress {
    reporter: Option<Arc<Reporter>>,
}

struct Reporter {
    on_terminal: bool,
    stage: Mutex<Option<Stage>>,
}

struct Stage {
    name: String,
    bar: ProgressBar,
}

impl Progress {
    /// Says nothing, for tests and for `--quiet`; the default.
    #[must_use]
    pub fn silent() -> Self {
        Self::default()
    }

    /// Reports on standard error: bars if that is a terminal, lines if not.
    #[must_use]
    pub fn on_standard_error() -> Self {
        let reporter = Reporter {
            on_terminal: stderr().is_terminal(),
            stage: Mutex::default(),
        };
        Self {
            reporter: Some(Arc::new(reporter)),
        }
    }

    /// Ends the stage before, if there is one, and begins the stage `name` of `total` steps.
    pub fn stage(&self, name: &str, total: u64) {
        self.done();
        if let Some(reporter) = &self.reporter {
            *reporter.lock() = Some(Stage {
                name: name.to_owned(),
                bar: reporter.bar(name, total),
            });
        }
    }

    /// Another `steps` steps of the stage are done.
    pub fn advance(&self, steps: u64) {
        if let Some(stage) = self.reporter.as_ref().and_then(|reporter| reporter.bar_of_stage()) {
            stage.inc(steps);
        }
    }

    /// Ends the stage; does nothing between stages.
    pub fn done(&self) {
        let Some(reporter) = &self.reporter else { return };
        if let Some(stage) = reporter.lock().take() {
            stage.bar.finish_and_clear();
            eprintln!(
                "{}: {} in {:.1} s",
                stage.name,
                stage.bar.position(),
                stage.bar.elapsed().as_secs_f64()
            );
        }
    }

    /// Prints a remark that the person should see but that stops nothing.
    pub fn note(&self, text: &str) {
        let Some(reporter) = &self.reporter else { return };
        match reporter.bar_of_stage() {
            Some(bar) => bar.suspend(|| eprintln!("note: {text}")),
            None => eprintln!("note: {text}"),
        }
    }
}

impl Reporter {
    fn lock(&self) -> MutexGuard<'_, Option<Stage>> {
        self.stage.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn bar_of_stage(&self) -> Option<ProgressBar> {
        self.lock().as_ref().map(|stage| stage.bar.clone())
    }

    fn bar(&self, name: &str, total: u64) -> ProgressBar {
        let target = if self.on_terminal {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        };
        let style = ProgressStyle::with_template("{msg:>20} [{wide_bar}] {human_pos}/{human_len} {eta}")
            .unwrap_or_else(|_| ProgressStyle::default_bar());
        ProgressBar::with_draw_target(Some(total), target)
            .with_style(style)
            .with_message(name.to_owned())
    }
}
