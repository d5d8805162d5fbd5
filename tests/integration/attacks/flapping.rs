//! A robot whose status says leak and no leak in turns.
//!
//! `FLAPPING_S=600 cargo test -p vibrissa-tests --test attacks flapping -- --nocapture` prints how the database grows meanwhile.

use std::time::{Duration, Instant};

use vibrissa_protocol::{ArrayType, Gauge, Regulator, RobotTopic, Status, WhiskerStatus, encode};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::fair::{quantile, work};
use crate::with_limits::{DatabaseKind, Supervised};

const WHISKERS: usize = 1000;
/// Time between two statuses.
const EVERY: Duration = Duration::from_millis(250);
/// Length of the attack, s, unless `FLAPPING_S` tells another.
const LASTS_S: u64 = 5;

fn status(robot: &mut HandRobot, regulator: Regulator) -> Vec<u8> {
    let whisker = |whisker: usize| WhiskerStatus {
        array: robot.array.array.clone(),
        whisker: whisker as u16,
        pressure_mpa: 0.1,
        setpoint_mpa: 0.1,
        regulator,
        gauge: Gauge::Ok,
        segmenter: None,
    };
    let whiskers = (0..WHISKERS).map(whisker).collect();
    let (boot_id, t_us) = (robot.boot_id.clone(), vibrissa_simulator::clock::now_us());
    let seq = robot.next_seq(RobotTopic::Status);
    encode(&Status { boot_id, seq, t_us, whiskers, contacts_dropped: None })
}

async fn number(supervised: &Supervised, sql: &'static str) -> u64 {
    supervised.texts(sql).await[0].parse().unwrap()
}

#[tokio::test]
async fn regress_a_status_that_flaps_is_one_alarm_for_each_whisker_and_fills_no_disk() {
    const BYTES: &str = "SELECT CAST(page_count * page_size AS TEXT) FROM pragma_page_count(), pragma_page_size()";
    const ALARMS: &str = "SELECT CAST(count(*) AS TEXT) FROM alarms WHERE kind = 'LEAK'";
    const CHANGES: &str = "SELECT CAST(count(*) AS TEXT) FROM health_changes";
    const FED: &str = "SELECT CAST(count(*) AS TEXT) FROM events";
    let supervised = Supervised::start(DatabaseKind::Sqlite, &[]).await;
    let lasts_s = std::env::var("FLAPPING_S").map_or(LASTS_S, |text| text.parse().unwrap());
    let mut other = HandRobot::born(supervised.port(), "other", array(ArrayType::Type2, &[70.0])).await;
    let (back, mut without) = work(other, Duration::from_secs(lasts_s / 4)).await;
    other = back;
    // Born now, because its silence would be an alarm, too.
    let mut robot = HandRobot::born(supervised.port(), "r", array(ArrayType::Type2, &[70.0; WHISKERS])).await;
    until_true("the layout is written", async || {
        number(&supervised, "SELECT CAST(count(*) AS TEXT) FROM whiskers").await == 1001
    })
    .await;
    let working = tokio::spawn(work(other, Duration::from_secs(lasts_s)));
    let (before, begun) = (number(&supervised, BYTES).await, Instant::now());
    let mut statuses = 0;
    while begun.elapsed() < Duration::from_secs(lasts_s) {
        for regulator in [Regulator::Leak, Regulator::Ok] {
            let payload = status(&mut robot, regulator);
            robot.say(RobotTopic::Status, payload).await;
            statuses += 1;
            tokio::time::sleep(EVERY).await;
        }
    }
    let came = "vibrissa_messages_received_total{fleet=\"f\",topic=\"status\"}";
    until_true("all statuses have come", async || supervised.metric(came).await >= f64::from(statuses)).await;
    // Receipts come after everything before them.
    robot.touch(0, 20).await;
    robot.receipted().await;
    let (_, mut with) = working.await.unwrap();
    without.sort_unstable();
    with.sort_unstable();
    println!("p95 of another robot: {:?} before, {:?} meanwhile", quantile(&without, 0.95), quantile(&with, 0.95));
    let (alarms, changes) = (number(&supervised, ALARMS).await, number(&supervised, CHANGES).await);
    let grown = number(&supervised, BYTES).await - before;
    let fed = number(&supervised, FED).await;
    println!(
        "{lasts_s} s, {statuses} statuses: {alarms} alarms, {changes} changes of health, {fed} in the feed, {grown} bytes"
    );
    assert_eq!(alarms, WHISKERS as u64, "one alarm for each whisker");
    assert!(changes <= 6 * WHISKERS as u64, "{changes} changes");
    assert!(grown < 8_000_000, "the database has grown by {grown} bytes");
}
