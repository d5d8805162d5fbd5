//! Events that a partitioned log carries to other programs: `docs/event.schema.json` describes them.

mod parts;
mod room;

use std::sync::Arc;

use serde::Serialize;
use tokio::sync::Notify;
use utoipa::ToSchema;
use vibrissa_store::time::Time;

pub use parts::*;
pub(crate) use room::OutboxRoom;

/// Version of the format. It rises if a field is removed or changes its meaning; new fields may come without a new version.
pub(crate) const VERSION: u32 = 1;

/// Name of an event. All events of a fleet have rising names, compared by epoch, number and index; in each partition they
/// stand in this order. An event whose name is not above that of the last event of its fleet in the partition was read before.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
pub struct EventId {
    /// Epoch of the fleet's lease.
    #[schema(minimum = 0)]
    pub epoch: i64,
    /// Number of the transaction under the lease.
    #[schema(minimum = 0)]
    pub number: i64,
    /// Index of the event in the transaction.
    #[schema(minimum = 0)]
    pub index: i64,
}

/// Kind of an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "SCREAMING_SNAKE_CASE")]
pub enum EventType {
    /// Contacts that a robot reported in one message, and the estimates after them.
    Contacts,
    /// Contacts of a robot are missing from here to its next `CONTACTS` event: too many events waited for the log.
    ContactsLeftOut,
    /// A trim was detected.
    Trim,
    /// The policy has decided about a trimmed whisker.
    Decision,
    /// An operator has approved a proposed compensation.
    CompensationApproved,
    /// A compensation has ended.
    CompensationEnded,
    /// A setpoint was decided.
    Setpoint,
    /// A setpoint has a new state.
    SetpointState,
    /// The error of a compensation was measured.
    Error,
    /// An alarm was raised.
    AlarmRaised,
    /// The cause of an alarm is gone.
    AlarmCleared,
    /// A whisker is not on the robot any more: all its alarms are over.
    WhiskerGone,
}

/// An event. Parts that do not concern its type are missing.
#[derive(Debug, Clone, Serialize, ToSchema)]
pub struct Event {
    /// Kind of the event.
    #[serde(rename = "type")]
    pub kind: EventType,
    /// Version of this format: 1.
    #[schema(minimum = 1)]
    pub version: u32,
    /// Time of the event, by the supervisor's clock.
    pub timestamp: Time,
    /// Name of the fleet.
    pub fleet: String,
    /// Name of the robot.
    pub robot: String,
    /// Name of the whisker's array; missing if the event concerns several whiskers or the whole robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub array: Option<String>,
    /// Number of the whisker in its array; missing if the event concerns several whiskers or the whole robot.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 0)]
    pub whisker: Option<u16>,
    /// The message of `CONTACTS`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contacts: Option<ContactsPart>,
    /// The trim of `TRIM`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trim: Option<TrimPart>,
    /// The decision of `DECISION`; the event's whisker is its target.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionPart>,
    /// The compensation of `COMPENSATION_APPROVED` and `COMPENSATION_ENDED`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub compensation: Option<CompensationPart>,
    /// The setpoint of `SETPOINT` and `SETPOINT_STATE`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub setpoint: Option<SetpointPart>,
    /// The error of `ERROR`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<ErrorPart>,
    /// The alarm of `ALARM_RAISED` and `ALARM_CLEARED`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<AlarmPart>,
}

/// Where an engine reports events, if they are published.
#[derive(Debug, Clone)]
pub(crate) struct EventSink {
    /// Whether contacts are among them.
    pub(crate) has_contacts: bool,
    /// Notified when a transaction with events is committed.
    pub(crate) committed: Arc<Notify>,
    /// Room for contacts.
    pub(crate) room: Arc<OutboxRoom>,
}

/// The published text of an event: its name before its other fields.
#[must_use]
pub fn published(id: EventId, body: &str) -> String {
    let id = serde_json::to_string(&id).unwrap_or_default();
    format!("{{\"id\":{id},{}", body.strip_prefix('{').unwrap_or(body))
}

/// JSON Schema of published events, as docs/event.schema.json has it.
#[must_use]
pub fn schema() -> serde_json::Value {
    use utoipa::PartialSchema as _;
    let mut parts = Vec::new();
    Event::schemas(&mut parts);
    parts.push(("EventId".to_owned(), EventId::schema()));
    let parts: std::collections::BTreeMap<String, serde_json::Value> =
        parts.into_iter().map(|(name, part)| (name, serde_json::to_value(part).unwrap_or_default())).collect();
    let mut schema = serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Event",
    });
    if let (Some(schema), Ok(serde_json::Value::Object(mut told))) =
        (schema.as_object_mut(), serde_json::to_value(Event::schema()))
    {
        if let Some(fields) = told.get_mut("properties").and_then(serde_json::Value::as_object_mut) {
            fields.insert("id".to_owned(), serde_json::json!({ "$ref": "#/components/schemas/EventId" }));
        }
        if let Some(required) = told.get_mut("required").and_then(serde_json::Value::as_array_mut) {
            required.insert(0, "id".into());
        }
        schema.extend(told);
        schema.insert("$defs".to_owned(), serde_json::json!(parts));
    }
    let text = schema.to_string().replace("#/components/schemas/", "#/$defs/");
    serde_json::from_str(&text).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_file_in_docs_describes_the_events() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/event.schema.json");
        let written = serde_json::to_string_pretty(&schema()).unwrap() + "\n";
        if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
            std::fs::write(path, &written).unwrap();
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == written, "docs/event.schema.json differs from the code: write it with VIBRISSA_WRITE_DOCS=1");
        assert!(written.contains("\"CONTACTS\"") && written.contains("\"$ref\": \"#/$defs/EventId\""));
    }

    #[test]
    fn the_name_of_an_event_stands_before_its_other_fields() {
        let id = EventId { epoch: 2, number: 3, index: 4 };
        let text = published(id, r#"{"type":"TRIM"}"#);
        assert_eq!(text, r#"{"id":{"epoch":2,"number":3,"index":4},"type":"TRIM"}"#);
    }
}
