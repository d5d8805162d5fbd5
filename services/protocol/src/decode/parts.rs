//! Messages with lists of independent entries: a wrong entry is refused alone, and the message is kept.

use std::borrow::Cow;

use serde::de::{DeserializeOwned, MapAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::value::RawValue;

use super::{explain, repair};
use crate::Refusal;
use crate::check::keep_valid;
use crate::messages::{Checked, Contact, Contacts, MissedTouch, Status, WhiskerStatus};
use crate::shape::Object;

/// A message, and the refusals of its entries that were left out.
#[derive(Debug, Clone, PartialEq)]
pub struct Received<T> {
    /// The message without the refused entries.
    pub message: T,
    /// One refusal for each refused entry, with the entry's position in the message as it was sent.
    pub refused: Vec<Refusal>,
}

impl<T> Received<T> {
    /// A message without refused entries.
    pub(super) fn whole(message: T) -> Self {
        Self { message, refused: Vec::new() }
    }

    /// Converts the message.
    pub(super) fn map<U>(self, convert: impl FnOnce(T) -> U) -> Received<U> {
        Received { message: convert(self.message), refused: self.refused }
    }

    /// The message, if nothing was refused; otherwise the first refusal.
    pub(super) fn complete(self) -> Result<T, Refusal> {
        self.refused.into_iter().next().map_or(Ok(self.message), Err)
    }
}

/// A list's name, and the check of an entry's text.
type List = (&'static str, fn(&str) -> Result<(), Refusal>);

/// A message with lists of independent entries.
pub(super) trait Parted: Checked + DeserializeOwned {
    /// Lists of the message whose entries are checked one by one.
    const LISTS: &[List];

    /// Checks the message apart from the entries, and removes those that are wrong.
    fn sift(&mut self, refused: &mut Vec<Refusal>) -> Result<(), Refusal>;
}

impl Parted for Contacts {
    const LISTS: &[List] = &[("contacts", entry::<Contact>), ("missed", entry::<MissedTouch>)];

    fn sift(&mut self, refused: &mut Vec<Refusal>) -> Result<(), Refusal> {
        self.check_frame()?;
        keep_valid("contacts", &mut self.contacts, refused);
        keep_valid("missed", &mut self.missed, refused);
        Ok(())
    }
}

impl Parted for Status {
    const LISTS: &[List] = &[("whiskers", entry::<WhiskerStatus>)];

    fn sift(&mut self, refused: &mut Vec<Refusal>) -> Result<(), Refusal> {
        self.check_frame()?;
        keep_valid("whiskers", &mut self.whiskers, refused);
        Ok(())
    }
}

/// Checks the text of an entry.
fn entry<T: DeserializeOwned + Checked>(text: &str) -> Result<(), Refusal> {
    match serde_json::from_str::<Object<T>>(text) {
        Ok(Object(entry)) => entry.check(),
        // Positions in the entry's text mean nothing to the sender.
        Err(_) => Err(of_entry(explain::<T>(text.as_bytes()).without_position())),
    }
}

/// The refusal of an entry, with its path below the entry.
fn of_entry(refusal: Refusal) -> Refusal {
    match refusal {
        Refusal::NotJson { problem } => Refusal::Malformed { path: String::new(), problem },
        Refusal::Malformed { path, problem } if path == "." => Refusal::Malformed { path: String::new(), problem },
        Refusal::Malformed { .. }
        | Refusal::UnknownTopic { .. }
        | Refusal::BadName { .. }
        | Refusal::TooLarge { .. }
        | Refusal::NotCbor { .. }
        | Refusal::OutOfRange { .. }
        | Refusal::TooMany { .. }
        | Refusal::Duplicate { .. }
        | Refusal::WrongNeighbour { .. } => refusal,
    }
}

/// Removes wrong entries from a message whose types are right.
pub(super) fn sifted<T: Parted>(mut message: T) -> Result<Received<T>, Refusal> {
    let mut refused = Vec::new();
    message.sift(&mut refused)?;
    Ok(Received { message, refused })
}

/// Reads a message in JSON.
pub(super) fn read<T: Parted>(payload: &[u8]) -> Result<Received<T>, Refusal> {
    match serde_json::from_slice::<Object<T>>(payload) {
        Ok(Object(message)) => sifted(message),
        Err(_) => without_wrong_entries(payload).ok_or_else(|| explain::<T>(payload)),
    }
}

/// Reads a message of which something has a wrong form. `None` if that is not in an entry.
pub(super) fn without_wrong_entries<T: Parted>(payload: &[u8]) -> Option<Received<T>> {
    let mut text = Cow::Borrowed(payload);
    if serde_json::from_slice::<Fields<'_>>(payload).is_err() {
        text = Cow::Owned(repair::repaired(payload).into_bytes());
    }
    let Fields(fields) = serde_json::from_slice(&text).ok()?;
    let (mut kept, mut refused) = (String::with_capacity(text.len()), Vec::new());
    for (name, value) in fields {
        kept.push(if kept.is_empty() { '{' } else { ',' });
        kept.push_str(&serde_json::to_string(&name).ok()?);
        kept.push(':');
        match T::LISTS.iter().find(|(list, _)| *list == name) {
            Some(list) => keep_entries(value.get(), list, &mut kept, &mut refused)?,
            None => kept.push_str(value.get()),
        }
    }
    kept.push('}');
    let Object(message) = serde_json::from_str::<Object<T>>(&kept).ok()?;
    let mut received = sifted(message).ok()?;
    received.refused.append(&mut refused);
    Some(received)
}

/// Writes the entries of a list that are right.
fn keep_entries(list: &str, (name, check): &List, kept: &mut String, refused: &mut Vec<Refusal>) -> Option<()> {
    let entries: Vec<&RawValue> = serde_json::from_str(list).ok()?;
    let mut before = '[';
    for (index, entry) in entries.into_iter().enumerate() {
        match check(entry.get()) {
            Ok(()) => {
                kept.push(before);
                kept.push_str(entry.get());
                before = ',';
            }
            Err(refusal) => refused.push(repair::with_remedy(refusal).within(name, index)),
        }
    }
    if before == '[' {
        kept.push('[');
    }
    kept.push(']');
    Some(())
}

/// The fields of an object in their order, as text.
struct Fields<'a>(Vec<(String, &'a RawValue)>);

impl<'de: 'a, 'a> Deserialize<'de> for Fields<'a> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Object;
        impl<'de> Visitor<'de> for Object {
            type Value = Fields<'de>;
            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a message")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Fields<'de>, A::Error> {
                let mut fields = Vec::new();
                while let Some(field) = map.next_entry()? {
                    fields.push(field);
                }
                Ok(Fields(fields))
            }
        }
        deserializer.deserialize_map(Object)
    }
}

#[cfg(test)]
mod tests;
