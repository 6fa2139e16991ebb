use super::*;

fn job_of_two() -> Progress {
    let progress = Progress::reporting(Form::Lines);
    progress.job(&[("first", 1.0), ("second", 3.0)]);
    progress
}

fn ask<T>(progress: &Progress, question: impl FnOnce(&Job) -> T) -> Option<T> {
    progress.reporter.as_ref().map(|reporter| question(&reporter.lock()))
}

#[test]
fn a_job_is_told_as_a_whole() {
    let progress = job_of_two();
    progress.stage("first", 10);
    progress.advance(5);
    assert_eq!(ask(&progress, Job::share), Some(0.125));
    progress.stage("second", 4);
    assert_eq!(ask(&progress, Job::share), Some(0.25));
    progress.advance(2);
    assert_eq!(ask(&progress, Job::share), Some(0.625));
    progress.done();
    assert_eq!(ask(&progress, Job::share), Some(1.0));
}

#[test]
fn what_was_done_before_says_nothing_of_the_speed() {
    let progress = job_of_two();
    progress.stage("second", 100);
    progress.skip(50);
    assert_eq!(ask(&progress, Job::left), Some(None));
    std::thread::sleep(Duration::from_millis(50));
    progress.advance(25);
    let (left, spent) = ask(&progress, |job| (job.left(), job.began.elapsed())).unwrap_or_default();
    // A quarter of the stage took that long; another quarter is left, and the first stage, which never began, is a third of it.
    let expected = spent.mul_f64((1.0 - 0.5625) / 0.1875);
    let difference = left.unwrap_or_default().as_secs_f64() / expected.as_secs_f64();
    assert!((0.9..=1.0).contains(&difference), "{difference}");
}

#[test]
fn a_stage_that_no_job_names_is_a_job_of_its_own() {
    let progress = job_of_two();
    progress.stage("another", 2);
    progress.advance(1);
    assert_eq!(ask(&progress, Job::share), Some(0.5));
}
