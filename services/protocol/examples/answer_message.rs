//! Reads three `contacts` messages of a robot: a good one, one with a wrong contact, and one that is no JSON. Prints the
//! refusals, and the receipt for the others: `cargo run -p vibrissa-protocol --example answer_message`.

use std::error::Error;

use vibrissa_protocol::{BootId, Message, Receipt, RobotTopic, Topic, encode, envelope, receive};

const GOOD: &str = r#"{"boot_id": "boot-1", "seq": 0, "contacts": [
    {"array": "left", "whisker": 0, "t_us": 1000000, "ratio": 0.8, "deflection_mm": 2.5, "strain": 0.0021,
     "pressure_mpa": 0.1, "temperature_c": 21.5}]}"#;
/// The second contact has a contact ratio above 1. The first one is accepted.
const PARTLY_WRONG: &str = r#"{"boot_id": "boot-1", "seq": 1, "contacts": [
    {"array": "left", "whisker": 0, "t_us": 1100000, "ratio": 0.7, "deflection_mm": 2.5, "strain": 0.0023,
     "pressure_mpa": 0.1, "temperature_c": 21.5},
    {"array": "left", "whisker": 1, "t_us": 1100000, "ratio": 1.3, "deflection_mm": 2.5, "strain": 0.0023,
     "pressure_mpa": 0.1, "temperature_c": 21.5}]}"#;
/// The number of the message can still be read.
const CUT_OFF: &str = r#"{"boot_id": "boot-1", "seq": 2, "contacts": [{"array": "left", "#;

fn main() -> Result<(), Box<dyn Error>> {
    let topic = Topic::parse("whisker/v1/lab/crawler/contacts")?;
    let mut next = 0;
    for payload in [GOOD, PARTLY_WRONG, CUT_OFF].map(str::as_bytes) {
        match receive(&topic, payload) {
            Ok(received) => {
                let Message::Contacts(message) = received.message else { return Err("another message".into()) };
                println!("seq {}: {} contacts accepted", message.seq, message.contacts.len());
                for refusal in &received.refused {
                    println!("  refused as {}: {refusal}", refusal.label());
                }
                next = message.seq + 1;
            }
            Err(refusal) => {
                println!("refused as {}: {refusal}", refusal.label());
                // A refused message is receipted, too, if its number is readable: otherwise the robot repeats it forever.
                if let Some(envelope) = envelope(payload) {
                    next = envelope.seq + 1;
                }
            }
        }
    }

    // A supervisor sends the receipt only after the commit.
    let receipt = Receipt {
        boot_id: BootId::new("supervisor-1")?,
        seq: 0,
        robot_boot_id: BootId::new("boot-1")?,
        next,
        held: Vec::new(),
    };
    let Topic::Robot { fleet, robot, .. } = topic else { return Err("no topic of a robot".into()) };
    let answer = encode(&receipt);
    println!("{}: {}", RobotTopic::Receipt.of(&fleet, &robot), String::from_utf8(answer)?);
    Ok(())
}
