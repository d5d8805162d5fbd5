//! The host's clock is stepped, and a supervisor with another clock takes the fleet over: every contact is recorded.

use vibrissa_simulator::clock::now_us;
use vibrissa_tests::robot::HandRobot;
use vibrissa_tests::wait::until_true;

use crate::supervised::Supervised;

const HOUR_US: i64 = 3_600_000_000;
const BEHIND_US: i64 = -120_000_000;
/// Longer than the retention of contacts, minutes and records.
const YEARS_US: i64 = 3 * 365 * 24 * HOUR_US;

/// Sends contacts and statuses with the true time. Returns the number of contacts.
async fn talk(robot: &mut HandRobot) -> i64 {
    robot.settle().await;
    for _ in 0..5 {
        robot.clock_us = now_us();
        robot.status().await;
        robot.touch(0, 20).await;
    }
    robot.receipted().await;
    100
}

async fn every_contact_is_recorded(mut supervised: Supervised) {
    let mut robot = supervised.robot("r").await;
    let mut sent = talk(&mut robot).await;
    let mut followed = 0;
    let to_1970_us = 5_000_000 - now_us() as i64;
    for ahead_us in [HOUR_US, -HOUR_US, to_1970_us, 0] {
        supervised.set_host_clock(ahead_us);
        if supervised.is_shared() || ahead_us == to_1970_us {
            // The database contradicts the host, or the host's clock was never set.
            let is_told = |text: &str| text.contains("keeps its own time") == (ahead_us != 0);
            until_true("a reason in /readyz", async || is_told(&supervised.readiness().await)).await;
        } else {
            followed += 1;
            let message = "following a step of the host's clock";
            until_true("a step that is followed", async || supervised.logged(message) == followed).await;
        }
        sent += talk(&mut robot).await;
    }
    // The next owner has another clock.
    for ahead_us in [BEHIND_US, -BEHIND_US, 0] {
        supervised.set_host_clock(ahead_us);
        supervised.begin_again();
        sent += talk(&mut robot).await;
    }
    let count = "SELECT count(*) FROM contacts";
    until_true("every contact recorded", async || supervised.number(count).await == sent).await;
    let timely = "SELECT count(*) FROM contacts WHERE used = 'IMPLAUSIBLE'";
    assert_eq!(supervised.number(timely).await, 0);
    until_true("metrics", async || supervised.answers("/metrics").await.is_some()).await;
    assert_eq!(supervised.metric("vibrissa_contacts_bad_time_total{fleet=\"f\"}").await, 0.0);
    assert_eq!(supervised.logged("bad_time"), 0, "no time is refused because of the supervisor's own clock");
}

#[tokio::test]
async fn regress_no_step_of_the_hosts_clock_loses_a_contact_on_sqlite() {
    every_contact_is_recorded(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn regress_no_step_of_the_hosts_clock_loses_a_contact_on_postgres() {
    every_contact_is_recorded(Supervised::on_postgres().await).await;
}

/// A host starts with a clock that is years ahead, by which all rows are old.
async fn nothing_is_deleted_by_a_clock_that_is_years_ahead(mut supervised: Supervised) {
    const ROWS: &str = "SELECT (SELECT count(*) FROM contacts) + (SELECT count(*) FROM contact_minutes)";
    let mut robot = supervised.robot("r").await;
    talk(&mut robot).await;
    let rows = supervised.number(ROWS).await;
    assert!(rows >= 100, "{rows} rows");
    supervised.set_host_clock(YEARS_US);
    supervised.begin_again();
    until_true("upkeep of the tables", async || {
        let metrics = supervised.answers("/metrics").await.unwrap_or_default();
        let time = metrics.lines().find_map(|line| line.strip_prefix("vibrissa_upkeep_timestamp_seconds "));
        time.is_some_and(|time| time.parse::<f64>().unwrap() > 0.0)
    })
    .await;
    assert!(supervised.number(ROWS).await >= rows, "rows are gone");
    assert_eq!(supervised.metric("vibrissa_old_rows_removed_total").await, 0.0);
    assert_eq!(supervised.metric("vibrissa_partitions_dropped_total").await, 0.0);
}

#[tokio::test]
async fn regress_a_clock_that_is_years_ahead_at_the_start_deletes_nothing_from_sqlite() {
    nothing_is_deleted_by_a_clock_that_is_years_ahead(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn regress_a_clock_that_is_years_ahead_at_the_start_deletes_nothing_from_postgres() {
    nothing_is_deleted_by_a_clock_that_is_years_ahead(Supervised::on_postgres().await).await;
}
