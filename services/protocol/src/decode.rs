//! Decodes bytes to a checked message or a labelled refusal, and encodes messages.

mod cbor;
mod parts;
mod plain;
mod repair;

use std::borrow::Cow;
use std::fmt;

use serde::de::{DeserializeOwned, DeserializeSeed, Error as _, IgnoredAny, MapAccess, Visitor};
use serde::{Deserializer, Serialize};
use serde_json::error::Category;

pub use parts::Received;

use crate::messages::Checked;
use crate::shape::{Object, Whole};
use crate::{
    BootId, Connection, Contact, Contacts, Estimate, Factsheet, INTEGER_LIMIT, Maintenance, PAYLOAD_MAX_BYTES, Receipt,
    Refusal, Request, RobotTopic, Setpoint, SetpointState, Status, SupervisorRequest, SupervisorState, TestState,
    Topic,
};

/// A message that satisfies the contract.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Message {
    /// From a robot: its birth, farewell or will.
    Connection(Connection),
    /// From a robot: its arrays and whiskers.
    Factsheet(Factsheet),
    /// From a robot: a batch of contacts.
    Contacts(Contacts),
    /// From a robot: the condition of its chambers and gauges.
    Status(Status),
    /// From a robot: progress or result of a setpoint.
    SetpointState(SetpointState),
    /// From the supervisor: which contacts are committed.
    Receipt(Receipt),
    /// From the supervisor: a pressure to hold.
    Setpoint(Setpoint),
    /// From the supervisor: asks for a message again, or for a touch test.
    Request(Request),
    /// From a robot: progress or result of a touch test.
    TestState(TestState),
    /// From the supervisor: present lengths of the whiskers.
    Estimate(Estimate),
    /// From the supervisor: facts for the maintenance of the whiskers.
    Maintenance(Maintenance),
    /// From the supervisor: whether it owns the fleet.
    SupervisorState(SupervisorState),
    /// From the supervisor: asks all robots of the fleet for something.
    SupervisorRequest(SupervisorRequest),
}

/// Decodes and checks the payload received on a topic. A message with a wrong entry is refused.
///
/// # Errors
/// The reason of the refusal. [`envelope`] may still identify the message.
pub fn decode(topic: &Topic, payload: &[u8]) -> Result<Message, Refusal> {
    receive(topic, payload)?.complete()
}

/// Decodes and checks the payload received on a topic. Wrong contacts, missed touches and entries of a status are left out,
/// each with its own refusal.
///
/// # Errors
/// The reason for refusing the whole message. [`envelope`] may still identify it.
pub fn receive(topic: &Topic, payload: &[u8]) -> Result<Received<Message>, Refusal> {
    limited(payload)?;
    let is_of_contacts = matches!(topic, Topic::Robot { kind: RobotTopic::Contacts, .. });
    if cbor::is_cbor(payload) && !is_of_contacts {
        return Err(Refusal::NotJson { problem: "it begins like CBOR, which is for `contacts` only".to_owned() });
    }
    let message = match topic {
        Topic::SupervisorState { .. } => Message::SupervisorState(read(payload)?),
        Topic::SupervisorRequest { .. } => Message::SupervisorRequest(read(payload)?),
        Topic::Robot { kind, .. } => match kind {
            RobotTopic::Contacts => {
                return receive_contacts(payload, Vec::new()).map(|received| received.map(Message::Contacts));
            }
            RobotTopic::Status => return parts::read(payload).map(|received| received.map(Message::Status)),
            RobotTopic::Connection => Message::Connection(read(payload)?),
            RobotTopic::Factsheet => Message::Factsheet(read(payload)?),
            RobotTopic::Receipt => Message::Receipt(read(payload)?),
            RobotTopic::Setpoint => Message::Setpoint(read(payload)?),
            RobotTopic::SetpointState => Message::SetpointState(read(payload)?),
            RobotTopic::Request => Message::Request(read(payload)?),
            RobotTopic::TestState => Message::TestState(read(payload)?),
            RobotTopic::Estimate => Message::Estimate(read(payload)?),
            RobotTopic::Maintenance => Message::Maintenance(read(payload)?),
        },
    };
    Ok(Received::whole(message))
}

/// Decodes and checks the payload of a `contacts` message, in JSON or CBOR, like [`decode`], but reuses the allocation of
/// `list`, whose contents are discarded.
///
/// # Errors
/// Those of [`decode`].
pub fn decode_contacts(payload: &[u8], list: Vec<Contact>) -> Result<Contacts, Refusal> {
    receive_contacts(payload, list)?.complete()
}

/// Decodes and checks the payload of a `contacts` message like [`receive`], but reuses the allocation of `list`, whose
/// contents are discarded.
///
/// # Errors
/// Those of [`receive`].
pub fn receive_contacts(payload: &[u8], mut list: Vec<Contact>) -> Result<Received<Contacts>, Refusal> {
    limited(payload)?;
    if cbor::is_cbor(payload) {
        return receive_cbor(payload, &mut list);
    }
    let plain = std::str::from_utf8(payload).ok().and_then(|text| plain::contacts(text, &mut list));
    plain.map_or_else(|| parts::read(payload), parts::sifted)
}

fn receive_cbor(payload: &[u8], list: &mut Vec<Contact>) -> Result<Received<Contacts>, Refusal> {
    if let Some(message) = cbor::contacts(payload, list) {
        return parts::sifted(message);
    }
    match cbor::json::of(payload) {
        // Positions in the written text mean nothing to the sender.
        Ok(text) => parts::read(&text).map_err(Refusal::without_position),
        Err(problem) => {
            let received = cbor::json::marked(payload).and_then(|text| parts::without_wrong_entries(&text));
            received.ok_or_else(|| Refusal::NotCbor { problem: shortened(&problem) })
        }
    }
}

/// A message in CBOR as JSON, for tools that know only JSON; every other payload as it is. `None` for CBOR that is not
/// well-formed.
#[must_use]
pub fn as_json(payload: &[u8]) -> Option<Cow<'_, [u8]>> {
    if cbor::is_cbor(payload) { cbor::json::of(payload).ok().map(Cow::Owned) } else { Some(Cow::Borrowed(payload)) }
}

fn limited(payload: &[u8]) -> Result<(), Refusal> {
    if payload.len() <= PAYLOAD_MAX_BYTES {
        return Ok(());
    }
    Err(Refusal::TooLarge { bytes: payload.len(), most: PAYLOAD_MAX_BYTES })
}

/// Encodes a `contacts` message as CBOR.
#[must_use]
pub fn encode_cbor(message: &Contacts) -> Vec<u8> {
    cbor::write(message)
}

/// Encodes a message as JSON.
///
/// # Panics
/// Never for the messages of this crate: serializing numbers and texts into memory cannot fail.
#[must_use]
pub fn encode(message: &impl Serialize) -> Vec<u8> {
    serde_json::to_vec(message).expect("a message has only numbers, texts and lists of them")
}

fn read<T: DeserializeOwned + Checked>(payload: &[u8]) -> Result<T, Refusal> {
    let Object(message): Object<T> = serde_json::from_slice(payload).map_err(|_| explain::<T>(payload))?;
    message.check()?;
    Ok(message)
}

/// Decodes an invalid payload again with a slower reader that reports the path of the error.
fn explain<T: DeserializeOwned>(payload: &[u8]) -> Refusal {
    let mut reader = serde_json::Deserializer::from_slice(payload);
    let (path, error) = match serde_path_to_error::deserialize::<_, Object<T>>(&mut reader) {
        Err(error) => (error.path().to_string(), error.into_inner()),
        // The message itself is valid; other text follows it.
        Ok(_) => {
            return Refusal::NotJson { problem: "unexpected text after the message".to_owned() };
        }
    };
    match error.classify() {
        Category::Data => Refusal::Malformed { path: shortened(&path), problem: shortened(&error.to_string()) },
        Category::Syntax | Category::Eof | Category::Io => {
            Refusal::NotJson { problem: shortened(&crate::plain::not_json(&error.to_string())) }
        }
    }
}

/// First and last part of an error text: readers quote whole fields, and end with the expected value and the
/// position.
fn shortened(text: &str) -> String {
    const KEPT: usize = 150;
    let count = text.chars().count();
    if count <= 2 * KEPT {
        return text.to_owned();
    }
    let start = text.chars().take(KEPT);
    start.chain(" ... ".chars()).chain(text.chars().skip(count - KEPT)).collect()
}

/// Identity of a message: the two fields that every message has.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Envelope {
    /// Boot of the sender.
    pub boot_id: BootId,
    /// Sequence number within the boot and the topic.
    pub seq: u64,
}

/// Reads only the envelope of a refused message.
///
/// A refused `contacts` message can then still be receipted; otherwise its robot would send it again forever.
/// Reading stops at the second of the two fields, so the rest need not be JSON or CBOR.
#[must_use]
pub fn envelope(payload: &[u8]) -> Option<Envelope> {
    let mut found = Found::default();
    let text = match cbor::is_cbor(payload) {
        true => Cow::Owned(cbor::json::begin_of(payload).0),
        false => Cow::Borrowed(payload),
    };
    // The result is irrelevant: the search ends with a deliberate error once both fields are found.
    let _ = found.deserialize(&mut serde_json::Deserializer::from_slice(&text));
    Some(Envelope { boot_id: found.boot_id?, seq: found.seq.filter(|&seq| seq < INTEGER_LIMIT)? })
}

/// Fields of the envelope found so far.
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
                "seq" => self.seq = Some(map.next_value::<Whole<u64>>()?.0),
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
