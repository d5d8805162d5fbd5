//! Notifications of the browser about new alarms.

use vibrissa_protocol::{Gauge, Regulator, RobotTopic, Status, WhiskerStatus, encode};

use crate::stage::Stage;

/// A browser whose page is out of sight, and which allows notifications and records them.
const RECORDER: &str = "(() => {
    window.told = [];
    window.Notification = class {
        static permission = 'granted';
        static requestPermission = async () => 'granted';
        constructor(title, { body, renotify }) {
            // Without it a second notification would replace the first one silently.
            window.told.push(renotify ? `${title}: ${body}` : 'silent');
            document.body.dataset.told = window.told.length;
        }
    };
    Object.defineProperty(document, 'hidden', { get: () => true });
})()";
const BUTTON: &str = "document.getElementById('notifications')";

#[tokio::test]
async fn an_alarm_while_the_page_is_out_of_sight_is_notified_once_its_reader_wants_it() {
    let mut stage = Stage::start().await;
    stage.open("#/fleets").await;
    stage.browser.until("the stream", "document.getElementById('connection').textContent.trim() === 'live'").await;
    stage.browser.js(RECORDER).await;
    stage.browser.click(BUTTON).await;
    stage.browser.until("the choice", &format!("{BUTTON}.getAttribute('aria-pressed') === 'true'")).await;
    let robot = &mut stage.robot;
    let whiskers = (0..3).map(|whisker| WhiskerStatus {
        array: robot.array.array.clone(),
        whisker,
        pressure_mpa: 0.1,
        setpoint_mpa: 0.1,
        regulator: Regulator::Ok,
        gauge: Gauge::Open,
        segmenter: None,
    });
    let whiskers = whiskers.collect();
    let seq = robot.next_seq(RobotTopic::Status);
    let status = Status { boot_id: robot.boot_id.clone(), seq, t_us: robot.clock_us, whiskers, contacts_dropped: None };
    robot.say(RobotTopic::Status, encode(&status)).await;
    let told = stage.browser.until("a notification", "window.told.length > 0 && window.told[0]").await;
    let told = told.as_str().unwrap();
    assert!(told.contains("new alarm") || told.starts_with("New alarm"), "{told}");
    assert!(told.contains("r left 0: gauge open"), "{told}");
    stage.browser.click(BUTTON).await;
    stage.browser.until("the choice", &format!("{BUTTON}.getAttribute('aria-pressed') === 'false'")).await;
    stage.stop().await;
}
