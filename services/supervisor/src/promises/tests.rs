//! Promises in simulated time.

use super::*;

const S: Duration = Duration::from_secs(1);

fn age_s(open: &Open, promise: Promise, now: Instant) -> Option<u64> {
    open.age(promise, now).map(|age| age.as_secs())
}

#[test]
fn an_item_is_open_until_it_has_left_and_its_age_grows_without_any_further_call() {
    let (mut open, t0) = (Open::default(), Instant::now());
    assert_eq!(age_s(&open, Promise::Committed, t0), None);
    open.uncommitted.enter(2, t0);
    open.uncommitted.leave(1, t0 + 60 * S);
    assert_eq!(age_s(&open, Promise::Committed, t0 + 70 * S), Some(70), "the second item still waits");
    open.uncommitted.leave(1, t0 + 71 * S);
    assert_eq!(age_s(&open, Promise::Committed, t0 + 72 * S), None);
    open.unreceipted.enter(1, t0);
    assert_eq!(age_s(&open, Promise::Receipted, t0 + 3 * S), Some(3));
}

#[test]
fn items_that_keep_moving_do_not_grow_old_and_one_that_stays_does() {
    let (mut open, mut now) = (Open::default(), Instant::now());
    for second in 0..100 {
        // Each message waits for five seconds, so that there are always some.
        open.uncommitted.enter(1, now);
        open.uncommitted.leave(u64::from(second >= 5), now);
        assert!(age_s(&open, Promise::Committed, now) <= Some(5), "{open:?}");
        now += S;
    }
    assert!(age_s(&open, Promise::Committed, now + 60 * S) >= Some(60));
    open.uncommitted.leave(1000, now);
    assert_eq!(age_s(&open, Promise::Committed, now), None, "more cannot leave than entered");
    open.uncommitted.enter(1, now);
    assert_eq!(age_s(&open, Promise::Committed, now + S), Some(1));
}

/// A locked table, a full disk and a frozen server look the same: messages wait, and nothing is committed.
#[test]
fn regress_a_commit_that_hangs_is_a_problem_although_nothing_has_failed() {
    let (mut open, t0) = (Open::default(), Instant::now());
    let none = Vec::<String>::new();
    assert_eq!(open.problems(t0 + 3600 * S), none, "nothing waits, so nothing is late");
    open.uncommitted.enter(1, t0);
    assert_eq!(open.problems(t0 + PATIENCE), none, "a slow disk is no problem yet");
    let problems = open.problems(t0 + PATIENCE + S);
    assert!(problems.len() == 1 && problems[0].starts_with("nothing is recorded: "), "{problems:?}");
    open.uncommitted.leave(1, t0 + PATIENCE + S);
    assert_eq!(open.problems(t0 + PATIENCE + S), none);
    open.unreceipted.enter(1, t0);
    assert_eq!(open.problems(t0 + PATIENCE + S).len(), 1);
}

#[test]
fn a_failed_attempt_is_a_problem_at_once_and_until_the_next_commit() {
    let promises = Promises::default();
    promises.failed("nothing is recorded: no space is left".to_owned());
    assert_eq!(promises.problems(), ["nothing is recorded: no space is left"]);
    promises.recorded();
    assert_eq!(promises.problems(), Vec::<String>::new());
}

#[test]
fn deafness_lasts_from_its_first_moment_and_a_gap_is_as_old_as_the_survey_says() {
    let (mut open, t0) = (Open::default(), Instant::now() + 100 * S);
    open.heard(false, t0);
    open.heard(false, t0 + 5 * S);
    assert_eq!(age_s(&open, Promise::Received, t0 + 6 * S), Some(6));
    open.heard(true, t0 + 6 * S);
    assert_eq!(age_s(&open, Promise::Received, t0 + 6 * S), None);
    open.surveyed(Some(4 * S), Some(2 * S), t0);
    let ages = [Promise::Received, Promise::Answered].map(|promise| age_s(&open, promise, t0 + S));
    assert_eq!(ages, [Some(5), Some(3)]);
}
