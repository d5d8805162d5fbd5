//! From bytes to a checked message or a labelled refusal, and back.

mod plain;

use std::fmt;

use serde::de::{DeserializeOwned, DeserializeSeed, Error as _, IgnoredAny, MapAccess, Visitor};
use serde::{Deserializer, Serialize};
use serde_json::error::Category;

use crate::messages::Checked;
use crate::{
    BootId, Connection, Contact, Contacts, Factsheet, INTEGER_LIMIT, PAYLOAD_MAX_BYTES, Receipt, Refusal, Request,
    RobotTopic, Setpoint, SetpointState, Status, SupervisorState, Topic,
};

/// A message that keeps the contract.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Message {
    /// From a robot: its birth, farewell or will.
    Connection(Connection),
    /// From a robot: what is on it.
    Factsheet(Factsheet),
    /// From a robot: a batch of contacts.
    Contacts(Contacts),
    /// From a robot: the condition of its chambers and gauges.
    Status(Status),
    /// From a robot: what became of a setpoint.
    SetpointState(SetpointState),
    /// From the supervisor: how far contacts are committed.
    Receipt(Receipt),
    /// From the supervisor: a pressure to hold.
    Setpoint(Setpoint),
    /// From the supervisor: send something again.
    Request(Request),
    /// From the supervisor: whether it is there.
    SupervisorState(SupervisorState),
}

/// Reads and checks the payload that came on a topic.
///
/// # Errors
/// Why the message is not taken. It changes nothing; [`envelope`] can still say which one it was.
pub fn decode(topic: &Topic, payload: &[u8]) -> Result<Message, Refusal> {
    limited(payload)?;
    match topic {
        Topic::SupervisorState { .. } => read(payload).map(Message::SupervisorState),
        Topic::Robot { kind, .. } => match kind {
            RobotTopic::Connection => read(payload).map(Message::Connection),
            RobotTopic::Factsheet => read(payload).map(Message::Factsheet),
            RobotTopic::Contacts => decode_contacts(payload, Vec::new()).map(Message::Contacts),
            RobotTopic::Status => read(payload).map(Message::Status),
            RobotTopic::Receipt => read(payload).map(Message::Receipt),
            RobotTopic::Setpoint => read(payload).map(Message::Setpoint),
            RobotTopic::SetpointState => read(payload).map(Message::SetpointState),
            RobotTopic::Request => read(payload).map(Message::Request),
        },
    }
}

/// Reads and checks the payload of a `contacts` message as [`decode`] does. The list of a message that is done with can
/// be used again: what is in `list` is overwritten, and nothing is allocated while it is long enough.
///
/// # Errors
/// As [`decode`].
pub fn decode_contacts(payload: &[u8], mut list: Vec<Contact>) -> Result<Contacts, Refusal> {
    limited(payload)?;
    let plain = std::str::from_utf8(payload).ok().and_then(|text| plain::contacts(text, &mut list));
    let Some(message) = plain else { return read(payload) };
    message.check()?;
    Ok(message)
}

fn limited(payload: &[u8]) -> Result<(), Refusal> {
    if payload.len() <= PAYLOAD_MAX_BYTES {
        return Ok(());
    }
    Err(Refusal::TooLarge { bytes: payload.len(), most: PAYLOAD_MAX_BYTES })
}

/// Writes a message as JSON.
///
/// # Panics
/// Never for the messages of this crate: writing structs of numbers and texts into memory cannot fail.
#[must_use]
pub fn encode(message: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(message).expect("a message has only numbers, texts and lists of them")
}

fn read<T: DeserializeOwned + Checked>(payload: &[u8]) -> Result<T, Refusal> {
    let message: T = serde_json::from_slice(payload).map_err(|_| explain::<T>(payload))?;
    message.check()?;
    Ok(message)
}

/// Reads a payload that cannot be read once more, slowly, to say where it went wrong.
fn explain<T: DeserializeOwned>(payload: &[u8]) -> Refusal {
    let mut reader = serde_json::Deserializer::from_slice(payload);
    let (path, error) = match serde_path_to_error::deserialize::<_, T>(&mut reader) {
        Err(error) => (error.path().to_string(), error.into_inner()),
        // The message itself is whole: what follows it was the trouble.
        Ok(_) => {
            return Refusal::NotJson { problem: "something follows the message".to_owned() };
        }
    };
    let problem = shortened(&error.to_string());
    match error.classify() {
        Category::Data => Refusal::Malformed { path: shortened(&path), problem },
        Category::Syntax | Category::Eof | Category::Io => Refusal::NotJson { problem },
    }
}

/// Start and end of what a reader says: it quotes whole fields, and ends with what it expected and where.
fn shortened(text: &str) -> String {
    const KEPT: usize = 150;
    let count = text.chars().count();
    if count <= 2 * KEPT {
        return text.to_owned();
    }
    let start = text.chars().take(KEPT);
    start.chain(" ... ".chars()).chain(text.chars().skip(count - KEPT)).collect()
}

/// Which message it was: the two fields that every message carries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Envelope {
    /// The sender's boot.
    pub boot_id: BootId,
    /// Its number in that boot and topic.
    pub seq: u64,
}

/// Reads only the envelope, of a message that was otherwise refused.
///
/// A refused `contacts` message can then still be counted as consumed: without that its robot would send
/// it again for ever. Stops at the second of the two fields, so what comes after need not even be JSON.
#[must_use]
pub fn envelope(payload: &[u8]) -> Option<Envelope> {
    let mut found = Found::default();
    // The result does not matter: the search ends with an error on purpose once both are found.
    let _ = found.deserialize(&mut serde_json::Deserializer::from_slice(payload));
    Some(Envelope { boot_id: found.boot_id?, seq: found.seq.filter(|&seq| seq < INTEGER_LIMIT)? })
}

/// What the search for the envelope has found so far.
#[derive(Default)]
struct Found {
    boot_id: Option<BootId>,
    seq: Option<u64>,
}

impl<'de> DeserializeSeed<'de> for &mut Found {
    type Value = ();
    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for &mut Found {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a message")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            match key.as_str() {
                "boot_id" => self.boot_id = Some(map.next_value()?),
                "seq" => self.seq = Some(map.next_value()?),
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
            if self.boot_id.is_some() && self.seq.is_some() {
                return Err(A::Error::custom("both are found"));
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests;
