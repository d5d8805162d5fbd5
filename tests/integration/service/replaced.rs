//! A factsheet with a new whisker in place of a trimmed one.

use vibrissa_protocol::{ArrayType, RobotTopic, SetpointOutcome, SetpointReason, encode};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::{LEARNED, Running};

#[tokio::test]
async fn the_compensator_of_a_replaced_whisker_is_released_and_the_database_says_why() {
    let running = Running::start().await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    for whisker in [0, 1] {
        robot.touch(whisker, LEARNED + 20).await;
    }
    robot.cut(0, 54.0);
    robot.touch(0, 80).await;
    let (serving, _) = robot.setpoint().await;
    assert_eq!((serving.whisker, serving.reason), (1, SetpointReason::ShorterForLonger));
    robot.answer(&serving, SetpointOutcome::Applied, None).await;
    robot.status().await;
    robot.receipted().await;

    robot.array.whiskers[0].length_mm = 68.0;
    robot.cut(0, 68.0);
    let factsheet = robot.factsheet();
    robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
    let (release, _) = robot.setpoint().await;
    assert_eq!((release.whisker, release.reason, release.pressure_mpa), (1, SetpointReason::Release, 0.1));
    robot.answer(&release, SetpointOutcome::Applied, None).await;

    let database = &running.database;
    let ended = "SELECT end_reason FROM compensations WHERE ended_us IS NOT NULL";
    assert_eq!(database.texts(ended).await, ["REPLACED"]);
    let changes = "SELECT was || '>' || becomes FROM health_changes h JOIN whiskers w USING (whisker_id) \
                   WHERE kind = 'CONDITION' AND whisker = 0 ORDER BY health_change_id DESC LIMIT 1";
    assert_eq!(database.texts(changes).await, ["TRIMMED>LEARNING"]);
    let now = "SELECT whisker || ' ' || condition || ' ' || whole_length_mm || ' ' || (state IS NOT NULL) FROM whiskers \
               ORDER BY whisker";
    let expected = ["0 LEARNING 68.0 1", "1 HEALTHY 65.0 1"];
    until_true("the new whisker in the database", async || database.texts(now).await == expected).await;
    let applied = "SELECT state FROM setpoints WHERE reason = 'RELEASE'";
    until_true("the release applied", async || database.texts(applied).await == ["APPLIED"]).await;
    // A new supervisor with the same database knows the new layout.
    let again = running.again(crate::running::quick(), None).await;
    assert_eq!(again.database.texts(now).await, expected);
    again.service.stop().await;
}
