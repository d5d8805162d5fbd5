use super::*;

const HOUR_US: i64 = 3_600_000_000;

fn wrong() -> Judgement {
    Judgement { standing: Standing::Wrong, ..Judgement::default() }
}

#[test]
fn a_judgement_counts_once_it_has_held_for_a_second() {
    let mut settling = Settling::default();
    let begin = Instant::now();
    let at = |ms: u64| begin + Duration::from_millis(ms);
    for ms in [0, 250, 500, 900] {
        assert!(!settling.take(wrong(), at(ms)));
    }
    // A single other reading begins the second anew.
    assert!(!settling.take(Judgement::default(), at(950)));
    assert!(!settling.take(wrong(), at(1_000)));
    assert!(!settling.take(wrong(), at(1_900)));
    assert!(settling.take(wrong(), at(2_000)));
    assert!(!settling.take(wrong(), at(3_000)), "it is told once");
    assert_eq!(settling.in_force, wrong());
    assert!(!settling.take(Judgement::default(), at(3_250)));
    assert!(settling.take(Judgement::default(), at(4_250)));
}

fn problem(readings: Readings) -> Option<String> {
    let mut clocks = Clocks { readings, ..Clocks::default() };
    let readings = &clocks.readings;
    clocks.settling.in_force = Judgement {
        standing: readings.standing(),
        is_host_off: readings.is_host_off(),
        follows_host: readings.follows_host(1_795_248_000_000_000),
    };
    clocks.problem()
}

#[test]
fn the_reason_names_each_clock_that_disagrees_and_the_remedy() {
    let reason = problem(Readings {
        database: Some(120_000_000),
        robots: Some(120_300_000),
        supervisors: vec![120_000_000],
        ..Readings::default()
    });
    let reason = reason.expect("a reason");
    assert!(reason.starts_with("most other clocks contradict this supervisor's: "), "{reason}");
    assert!(reason.contains("the database's clock is 120.0 s ahead"), "{reason}");
    assert!(reason.contains("the median clock of the robots is 120.3 s ahead"), "{reason}");
    assert!(reason.contains("(NTP)"), "{reason}");

    let reason = problem(Readings { database: Some(-2 * HOUR_US), ..Readings::default() }).expect("a reason");
    assert!(reason.contains("no majority") && reason.contains("7200.0 s behind"), "{reason}");

    let reason = problem(Readings { host: -HOUR_US, robots: Some(0), ..Readings::default() }).expect("a reason");
    assert!(reason.contains("keeps its own time: the host's clock is 3600.0 s behind"), "{reason}");
}

#[test]
fn a_supervisor_that_agrees_with_most_is_ready() {
    assert_eq!(problem(Readings::default()), None);
    let database_alone =
        Readings { database: Some(HOUR_US), robots: Some(0), supervisors: vec![0], ..Readings::default() };
    assert_eq!(problem(database_alone), None, "the metric and the alert tell it");
}
