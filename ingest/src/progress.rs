//! Tells how far a long job is: a line that changes on a terminal, one line a stage elsewhere, JSON for scripts.

use std::io::{IsTerminal, stderr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use serde::Serialize;

/// Between two turns of a clock's hand.
const TICK: Duration = Duration::from_millis(100);
/// Between two events of progress.
const BETWEEN_EVENTS: Duration = Duration::from_secs(1);
/// Steps of the bar.
const STEPS: f64 = 1000.0;
/// Share of the work before which nothing is said of what is left.
const TOO_EARLY: f64 = 0.01;

/// A job in stages, one after the other. Clones report to the same job, from any thread.
#[derive(Clone, Default)]
pub struct Progress {
    reporter: Option<Arc<Reporter>>,
}

struct Reporter {
    form: Form,
    job: Mutex<Job>,
}

/// How it is told, on standard error.
enum Form {
    Terminal(ProgressBar),
    Lines,
    Events,
}

struct Job {
    began: Instant,
    /// The stages of the whole job, each with its share of the work; none where nobody said.
    stages: Vec<(&'static str, f64)>,
    /// Share of the job that is done by stages that ended.
    done: f64,
    /// Share of the job that was found done already.
    skipped: f64,
    stage: Option<Stage>,
    last_event: Option<Instant>,
}

struct Stage {
    name: String,
    began: Instant,
    /// None where nobody knows how long it takes.
    total: Option<u64>,
    steps: u64,
    /// Share of the job.
    share: f64,
}

/// A line of JSON on standard error.
#[derive(Serialize)]
#[serde(tag = "event", rename_all = "lowercase")]
enum Event<'a> {
    /// A stage begins or goes on.
    Progress {
        stage: &'a str,
        done: u64,
        #[serde(skip_serializing_if = "Option::is_none")]
        of: Option<u64>,
        /// Of the whole job.
        share: f64,
        seconds: f64,
        #[serde(skip_serializing_if = "Option::is_none")]
        seconds_left: Option<f64>,
    },
    /// A stage has ended.
    Done { stage: &'a str, done: u64, seconds: f64 },
    /// A remark.
    Note { text: &'a str },
}

impl Progress {
    /// Says nothing, for tests and for `--quiet`; the default.
    #[must_use]
    pub fn silent() -> Self {
        Self::default()
    }

    /// Reports on standard error: one line that changes if that is a terminal, a line for each stage if not.
    #[must_use]
    pub fn on_standard_error() -> Self {
        Self::reporting(if stderr().is_terminal() {
            let bar = ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr());
            Form::Terminal(bar.with_style(style("{msg}")))
        } else {
            Form::Lines
        })
    }

    /// Reports on standard error, an event a line, as JSON: `progress` (at most one a second), `done`, `note`.
    #[must_use]
    pub fn as_events() -> Self {
        Self::reporting(Form::Events)
    }

    fn reporting(form: Form) -> Self {
        let job = Job {
            began: Instant::now(),
            stages: Vec::new(),
            done: 0.0,
            skipped: 0.0,
            stage: None,
            last_event: None,
        };
        let reporter = Reporter {
            form,
            job: Mutex::new(job),
        };
        Self {
            reporter: Some(Arc::new(reporter)),
        }
    }

    /// Begins a job of several stages, each with its share of the work: what is told from then on is of all of it.
    pub fn job(&self, stages: &[(&'static str, f64)]) {
        if let Some(reporter) = &self.reporter {
            let mut job = reporter.lock();
            let all: f64 = stages.iter().map(|(_, share)| share).sum();
            job.stages = stages.iter().map(|&(name, share)| (name, share / all)).collect();
            (job.began, job.done, job.skipped) = (Instant::now(), 0.0, 0.0);
        }
    }

    /// Ends the stage before, if there is one, and begins the stage `name` of `total` steps.
    pub fn stage(&self, name: &str, total: u64) {
        self.begin(name, Some(total));
    }

    /// Ends the stage before, if there is one, and begins the stage `name`, of which nobody knows how long it takes.
    pub fn open_stage(&self, name: &str) {
        self.begin(name, None);
    }

    fn begin(&self, name: &str, total: Option<u64>) {
        self.done();
        let Some(reporter) = &self.reporter else { return };
        let mut job = reporter.lock();
        let known = job.stages.iter().find(|(known, _)| *known == name);
        let share = known.map_or(1.0, |&(_, share)| share);
        if known.is_none() {
            (job.done, job.skipped) = (0.0, 0.0);
            job.began = Instant::now();
        }
        job.stage = Some(Stage {
            name: name.to_owned(),
            began: Instant::now(),
            total,
            steps: 0,
            share,
        });
        reporter.begin_bar(total);
        reporter.tell(&mut job, true);
    }

    /// Another `steps` steps of the stage are done.
    pub fn advance(&self, steps: u64) {
        self.step(steps, false);
    }

    /// Another `steps` steps of the stage were done already: they say nothing of how long the rest takes.
    pub fn skip(&self, steps: u64) {
        self.step(steps, true);
    }

    fn step(&self, steps: u64, is_skipped: bool) {
        let Some(reporter) = &self.reporter else { return };
        let mut job = reporter.lock();
        let Some(stage) = &mut job.stage else { return };
        stage.steps += steps;
        if is_skipped {
            job.skipped += stage.share_of(steps);
        }
        reporter.tell(&mut job, false);
    }

    /// Ends the stage; does nothing between stages.
    pub fn done(&self) {
        let Some(reporter) = &self.reporter else { return };
        let mut job = reporter.lock();
        let Some(stage) = job.stage.take() else { return };
        job.done += stage.share;
        reporter.end(&stage);
    }

    /// Prints a remark that the person should see but that stops nothing.
    pub fn note(&self, text: &str) {
        let Some(reporter) = &self.reporter else { return };
        match &reporter.form {
            Form::Terminal(bar) => bar.suspend(|| eprintln!("note: {text}")),
            Form::Lines => eprintln!("note: {text}"),
            Form::Events => print(&Event::Note { text }),
        }
    }
}

impl Stage {
    /// Share of the job that so many of its steps are.
    fn share_of(&self, steps: u64) -> f64 {
        self.share * steps as f64 / self.total.unwrap_or(u64::MAX).max(1) as f64
    }
}

impl Job {
    /// Share of the job that is done.
    fn share(&self) -> f64 {
        let of_stage = self
            .stage
            .as_ref()
            .map_or(0.0, |stage| stage.share_of(stage.steps).min(stage.share));
        self.done + of_stage
    }

    /// What is left at the speed so far; None as long as that says little.
    fn left(&self) -> Option<Duration> {
        let (share, worked) = (self.share(), self.share() - self.skipped);
        let is_known = worked > TOO_EARLY && self.stage.as_ref().is_some_and(|stage| stage.total.is_some());
        is_known.then(|| self.began.elapsed().mul_f64((1.0 - share).max(0.0) / worked))
    }
}

impl Reporter {
    fn lock(&self) -> MutexGuard<'_, Job> {
        self.job.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn begin_bar(&self, total: Option<u64>) {
        let Form::Terminal(bar) = &self.form else { return };
        if total.is_some() {
            bar.disable_steady_tick();
            bar.set_length(STEPS as u64);
            bar.set_style(style("[{wide_bar}] {percent:>3}% {msg}"));
        } else {
            bar.set_style(style("{spinner} {msg} {elapsed}"));
            bar.enable_steady_tick(TICK);
        }
        bar.reset();
    }

    fn tell(&self, job: &mut Job, is_due: bool) {
        let Some(stage) = &job.stage else { return };
        match &self.form {
            Form::Lines => {}
            Form::Terminal(bar) => {
                bar.set_position((job.share() * STEPS) as u64);
                bar.set_message(message(stage, job.left()));
            }
            Form::Events => {
                let is_due = is_due || job.last_event.is_none_or(|last| last.elapsed() >= BETWEEN_EVENTS);
                if is_due {
                    print(&Event::Progress {
                        stage: &stage.name,
                        done: stage.steps,
                        of: stage.total,
                        share: job.share(),
                        seconds: job.began.elapsed().as_secs_f64(),
                        seconds_left: job.left().map(|left| left.as_secs_f64()),
                    });
                    job.last_event = Some(Instant::now());
                }
            }
        }
    }

    fn end(&self, stage: &Stage) {
        let seconds = stage.began.elapsed().as_secs_f64();
        let line = match stage.total {
            Some(_) => format!("{}: {} in {seconds:.1} s", stage.name, HumanCount(stage.steps)),
            None => format!("{}: {seconds:.1} s", stage.name),
        };
        match &self.form {
            Form::Terminal(bar) => {
                bar.suspend(|| eprintln!("{line}"));
                bar.finish_and_clear();
            }
            Form::Lines => eprintln!("{line}"),
            Form::Events => print(&Event::Done {
                stage: &stage.name,
                done: stage.steps,
                seconds,
            }),
        }
    }
}

/// `tiles 34 of 1,024, 12 seconds left`.
fn message(stage: &Stage, left: Option<Duration>) -> String {
    let so_far = stage.total.map_or_else(
        || stage.name.clone(),
        |total| format!("{} {} of {}", stage.name, HumanCount(stage.steps), HumanCount(total)),
    );
    match left {
        Some(left) => format!("{so_far}, {} left", HumanDuration(left)),
        None => so_far,
    }
}

fn print(event: &Event) {
    // Numbers and text always become JSON.
    if let Ok(line) = serde_json::to_string(event) {
        eprintln!("{line}");
    }
}

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

#[cfg(test)]
#[path = "progress_tests.rs"]
mod tests;
