//! Robots that leave the allow list while the supervisor works for them.

use serde_json::json;
use sqlx::ConnectOptions as _;
use sqlx::sqlite::SqliteConnectOptions;
use vibrissa_protocol::{ArrayType, ConnectionState, Message};
use vibrissa_tests::observer::Observer;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::{PATIENCE, until_true};
use vibrissa_tests::web::send;

use crate::running::{LEARNED, Running, database_in};

/// Runs statements as another program does that shares the database.
async fn run(running: &Running, sql: &'static str) {
    let file = SqliteConnectOptions::new().filename(database_in(running.folder())).busy_timeout(PATIENCE);
    sqlx::raw_sql(sql).execute(&mut file.connect().await.unwrap()).await.unwrap();
}

/// The supervisor looked for a new list once a second, and sent setpoints meanwhile.
#[tokio::test]
async fn regress_a_setpoint_after_the_exclusion_does_not_go_out() {
    let running = Running::start().await;
    let mut robot = HandRobot::born(running.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    robot.touch(0, LEARNED + 20).await;
    robot.receipted().await;
    robot.cut(0, 66.0);
    // Nobody tells the supervisor of the list, as if another supervisor had got the request.
    run(
        &running,
        "INSERT INTO actions (action_id, actor, role, request_id, kind, parameters, state, asked_us, expires_us) \
         VALUES (1000, 'local', 'ADMIN', 'r', 'ALLOWED_ROBOTS', '{}', 'DONE', 1, 1); \
         INSERT INTO allowed_robots VALUES ('f', 1, 'another', 1, 'local', NULL, 1000)",
    )
    .await;
    let mut observer = Observer::subscribed(running.port(), "o", &["whisker/v1/f/r/#"]).await;
    robot.touch(0, 80).await;
    until_true("it is refused", async || {
        robot.status().await;
        running.metrics().await.refused().contains_key("not_allowed")
    })
    .await;
    // What the supervisor sent before comes before this.
    robot.clock_us += 1;
    robot.status().await;
    let (mut setpoints, end_us) = (0, robot.clock_us);
    observer
        .expect("the end", |heard| {
            setpoints += usize::from(matches!(heard.message, Message::Setpoint(_)));
            matches!(heard.message, Message::Status(status) if status.t_us == end_us).then_some(())
        })
        .await;
    assert_eq!(setpoints, 0);
    running.service.stop().await;
}

/// The supervisor forgot the robot although the database had refused to, told the person that there was no such robot, and
/// supervised it no more.
#[tokio::test]
async fn regress_a_robot_that_the_database_does_not_let_go_stays_supervised() {
    const ROBOT: &str = "/v1/fleets/f/robots/old";
    let running = Running::start().await;
    let mut robot = HandRobot::born(running.port(), "old", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(0, 30).await;
    robot.receipted().await;
    robot.connection(ConnectionState::ConnectionBroken).await;
    until_true("the alarm", async || running.list("alarms?standing=true&robot=old").await.len() == 1).await;
    run(
        &running,
        "CREATE TRIGGER keep BEFORE UPDATE OF decommissioned_us ON robots WHEN NEW.decommissioned_us IS NOT NULL \
         BEGIN SELECT RAISE(ABORT, 'planted'); END",
    )
    .await;
    let asked = async || {
        let body = json!({ "reason": "scrapped" });
        let answer = send(running.service.http, "DELETE", ROBOT, &[], Some(&body)).await.unwrap();
        (answer.status, answer.json())
    };
    let (status, problem) = asked().await;
    assert_eq!(status, 409, "{problem}");
    assert!(problem["detail"].as_str().unwrap().contains("the database refuses"), "{problem}");
    assert_eq!(running.list("robots").await.len(), 1);
    assert_eq!(running.list("alarms?standing=true&robot=old").await.len(), 1);
    robot.connection(ConnectionState::Online).await;
    robot.touch(0, 10).await;
    robot.receipted().await;
    assert!(running.list("alarms?standing=true&robot=old").await.is_empty(), "it is supervised");

    run(&running, "DROP TRIGGER keep").await;
    robot.connection(ConnectionState::ConnectionBroken).await;
    until_true("the alarm", async || running.list("alarms?standing=true&robot=old").await.len() == 1).await;
    let (status, action) = asked().await;
    assert_eq!((status, &action["state"]), (200, &json!("DONE")), "{action}");
    assert!(running.list("robots").await.is_empty());
    running.service.stop().await;
}
