//! Two robots from one disk image: one name, one client identifier, two boots.

use serde_json::json;
use vibrissa_protocol::{ArrayType, BootId, ConnectionState};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::running::Running;

#[tokio::test]
async fn regress_two_robots_with_one_name_are_one_alarm_that_says_so() {
    let running = Running::start().await;
    let mut replaced = Vec::new();
    for at in 0..8 {
        // Each connection takes the place of the one before, because the client identifier is the same.
        let mut robot = HandRobot::connect(running.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
        robot.boot_id = BootId::new(["first", "second"][at % 2]).unwrap();
        if at < 2 {
            robot.birth().await;
        } else {
            robot.connection(ConnectionState::Online).await;
        }
        replaced.push(robot);
    }
    until_true("the alarm", async || !running.list("alarms?standing=true&kind=DUPLICATE_ROBOT").await.is_empty()).await;
    let standing = running.list("alarms?standing=true").await;
    let alarms: Vec<_> = standing.iter().map(|one| (&one["kind"], &one["robot"], &one["array"])).collect();
    assert_eq!(alarms, [(&json!("DUPLICATE_ROBOT"), &json!("r"), &json!(null))]);
    running.service.stop().await;
}
