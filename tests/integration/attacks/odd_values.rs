//! Texts with control characters and numbers that are not measurements are refused on arrival and affect no other
//! robot.

use vibrissa_protocol::{Contact, RobotTopic, encode};
use vibrissa_tests::wait::until_true;

use crate::supervised::Supervised;

/// (ratio, deflection in mm, strain). The first three made the estimated length of a whisker of 69.3 mm non-finite.
const POISON: [(f64, f64, f64); 6] = [
    (5e-324, 1e-9, -0.0117),
    (0.85, 1000.0, 5e-324),
    (0.45, 999.999, 1.0),
    (0.001, 2.4, 0.0117),
    (0.85, 1e-300, 0.0117),
    (0.85, 2.4, -1e-12),
];

async fn odd_values_are_refused(supervised: Supervised) {
    let mut honest = supervised.robot("honest").await;
    let mut odd = supervised.robot("r").await;
    let factsheet = odd.factsheet();
    let text = String::from_utf8(encode(&factsheet)).unwrap();
    for control in ["\\u0000", "\\u001b[2J", "\\u0085"] {
        let spoilt = text.replace("by-hand", &format!("a{control}b"));
        odd.say(RobotTopic::Factsheet, spoilt).await;
    }
    let spoilt = text.replace("nguyen-2021", "nguyen\\u0000");
    odd.say(RobotTopic::Factsheet, spoilt).await;
    // Sends the valid factsheet again, so that the broker retains it.
    odd.say(RobotTopic::Factsheet, text).await;
    for (ratio, deflection_mm, strain) in POISON {
        let contact = Contact { ratio: Some(ratio), deflection_mm, strain, ..odd.contact(1) };
        odd.send(vec![contact]).await;
        let contacts = vec![honest.contact(0)];
        honest.send(contacts).await;
        honest.receipted().await;
    }
    odd.receipted().await;
    odd.touch(1, 20).await;
    odd.receipted().await;
    supervised.has_refused(&[("malformed", 4.0), ("out_of_range", 5.0)]).await;
    // The third one is within the ranges of the contract.
    let recorded = "SELECT count(*) FROM contacts WHERE length_mm > 60 AND length_mm < 80 AND length_sd_mm < 10";
    until_true("every other contact", async || supervised.number(recorded).await == POISON.len() as i64 + 1 + 20).await;
    assert!(supervised.answers("/readyz").await.is_some());
}

#[tokio::test]
async fn odd_values_are_refused_and_nobody_else_notices_on_sqlite() {
    odd_values_are_refused(Supervised::on_sqlite().await).await;
}

#[tokio::test]
async fn odd_values_are_refused_and_nobody_else_notices_on_postgres() {
    odd_values_are_refused(Supervised::on_postgres().await).await;
}
