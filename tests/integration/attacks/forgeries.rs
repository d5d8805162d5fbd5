//! Messages that violate the contract: they have no effect and are counted.

use vibrissa_protocol::{BootId, Contacts, RobotTopic, SetpointError, SetpointOutcome, encode};
use vibrissa_tests::wait::until_true;

use crate::supervised::Supervised;

async fn forgeries_are_counted(supervised: Supervised) {
    let mut robot = supervised.robot("r").await;
    let mut other = supervised.robot("other").await;
    let contacts = vec![robot.contact(0), robot.contact(1)];
    let said = robot.send(contacts).await;
    robot.receipted().await;
    const DUPLICATES: &str = "vibrissa_messages_duplicate_total{fleet=\"f\"}";
    let before = supervised.metric(DUPLICATES).await;

    // A repeated message is a duplicate; other contents under its number are a forgery.
    robot.say(RobotTopic::Contacts, encode(&said)).await;
    let mut forged = Contacts { contacts: said.contacts.clone(), ..said.clone() };
    forged.contacts[1].strain *= 1.000_001;
    robot.say(RobotTopic::Contacts, encode(&forged)).await;
    supervised.has_refused(&[("conflicting_duplicate", 1.0)]).await;
    until_true("both are duplicates", async || supervised.metric(DUPLICATES).await == before + 2.0).await;

    robot.status().await;
    supervised.set_by_hand(0, 0.05).await;
    let (setpoint, _) = robot.setpoint().await;
    let mut unknown = setpoint.clone();
    unknown.command_id = "00000000-0000-5000-8000-000000000000".to_owned();
    robot.answer(&unknown, SetpointOutcome::Applied, None).await;
    // Another robot answers for this robot.
    other.answer(&setpoint, SetpointOutcome::Failed, Some(SetpointError::Leak)).await;
    let own = std::mem::replace(&mut robot.boot_id, BootId::new("never-born").unwrap());
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.boot_id = own;
    robot.answer(&setpoint, SetpointOutcome::Applying, None).await;
    robot.answer(&setpoint, SetpointOutcome::Received, None).await;
    let expected =
        [("conflicting_duplicate", 1.0), ("state_backward", 1.0), ("unknown_boot", 1.0), ("unknown_command", 2.0)];
    supervised.has_refused(&expected).await;
    let applying = "SELECT count(*) FROM setpoints WHERE state = 'APPLYING'";
    until_true("the setpoint has the first reported state", async || supervised.number(applying).await == 1).await;
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    let applied = "SELECT count(*) FROM setpoints WHERE state = 'APPLIED'";
    until_true("the setpoint is applied", async || supervised.number(applied).await == 1).await;
    // A repeated answer is allowed, a contradictory one is refused.
    robot.answer(&setpoint, SetpointOutcome::Applied, None).await;
    robot.answer(&setpoint, SetpointOutcome::Failed, Some(SetpointError::Leak)).await;
    let mut expected = expected;
    expected[1].1 = 2.0;
    supervised.has_refused(&expected).await;
    assert_eq!(supervised.number(applied).await, 1);
    for reason in ["conflicting_duplicate", "state_backward", "unknown_command"] {
        // Each worker of the engine has its own rate limit of the log.
        assert!((1..=2).contains(&supervised.logged(reason)), "{reason} is logged once a minute");
    }
}

#[tokio::test]
async fn forgeries_change_nothing_and_are_counted_on_sqlite() {
    forgeries_are_counted(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn forgeries_change_nothing_and_are_counted_on_postgres() {
    forgeries_are_counted(Supervised::on_postgres().await).await;
}
