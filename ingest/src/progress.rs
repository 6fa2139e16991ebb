//! Tells a person at a terminal how far a long job is: bars on a terminal, one line a stage elsewhere.

use std::io::{IsTerminal, stderr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use indicatif::{HumanCount, ProgressBar, ProgressDrawTarget, ProgressStyle};

/// Between two turns of a clock's hand.
const TICK: Duration = Duration::from_millis(100);

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
        self.begin(name, |reporter| reporter.bar(total));
    }

    /// Ends the stage before, if there is one, and begins the stage `name`, of which nobody knows how long it takes.
    pub fn open_stage(&self, name: &str) {
        self.begin(name, Reporter::clock);
    }

    fn begin(&self, name: &str, bar: impl FnOnce(&Reporter) -> ProgressBar) {
        self.done();
        if let Some(reporter) = &self.reporter {
            *reporter.lock() = Some(Stage {
                name: name.to_owned(),
                bar: bar(reporter).with_message(name.to_owned()),
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
            let seconds = stage.bar.elapsed().as_secs_f64();
            match stage.bar.length() {
                Some(_) => eprintln!("{}: {} in {seconds:.1} s", stage.name, HumanCount(stage.bar.position())),
                None => eprintln!("{}: {seconds:.1} s", stage.name),
            }
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

    fn bar(&self, total: u64) -> ProgressBar {
        let bar = ProgressBar::with_draw_target(Some(total), self.target());
        bar.with_style(style("{msg:>20} [{wide_bar}] {human_pos}/{human_len} {eta}"))
    }

    /// A bar that shows nothing but that time goes by.
    fn clock(&self) -> ProgressBar {
        let clock = ProgressBar::with_draw_target(None, self.target());
        clock.enable_steady_tick(TICK);
        clock.with_style(style("{msg:>20} {spinner} {elapsed}"))
    }

    fn target(&self) -> ProgressDrawTarget {
        if self.on_terminal {
            ProgressDrawTarget::stderr()
        } else {
            ProgressDrawTarget::hidden()
        }
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}
