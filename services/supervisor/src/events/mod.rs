//! Events as live pages, webhooks and Kafka get them: `docs/event.schema.json` describes them, docs/events.json has an example of
//! each kind. The engine writes them into the log of `vibrissa_store::events`.
//!
//! A new kind is a variant of [`EventKind`]; the compiler then asks for its word, its audience and its example.

#[cfg(test)]
mod examples;
mod parts;
mod room;

use std::sync::Arc;

use serde::Serialize;
use tokio::sync::Notify;
use utoipa::{PartialSchema as _, ToSchema};
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::guidance::{RUNBOOKS, of_word};
use vibrissa_edge::words::named;
use vibrissa_store::events::write::EventRow;
use vibrissa_store::events::{StoredEvent, VERSION};
use vibrissa_store::time::Time;

use crate::one_of::{EventKindWord, LevelWord, OneOf};
pub use parts::*;
pub(crate) use room::OutboxRoom;

/// An event. `type`, `timestamp` and `data` are those of Standard Webhooks.
#[derive(Debug, Serialize, ToSchema)]
pub struct Event {
    /// Kind of the event.
    #[serde(rename = "type")]
    pub kind: EventKindWord,
    /// Number of the event, unique in the database; null in a test.
    #[schema(minimum = 1)]
    pub event_id: Option<i64>,
    /// Version of `data`, now 2. It rises if a field is removed or changes its meaning; new fields come without a new version.
    #[schema(minimum = 1)]
    pub version: i64,
    /// Time of the event, by the supervisor's clock.
    pub timestamp: Time,
    /// Subject and data of the event.
    pub data: EventData,
}

/// Subject and data of an event. Parts that do not concern the kind of the event are missing.
#[derive(Debug, Serialize, ToSchema)]
pub struct EventData {
    /// Subject of the event.
    #[serde(flatten)]
    pub subject: Subject,
    /// Data that depend on the kind of the event.
    #[serde(flatten)]
    pub parts: Parts,
}

/// Subject of an event, and its urgency.
#[derive(Debug, Serialize, ToSchema)]
pub struct Subject {
    /// How soon somebody must act.
    pub level: LevelWord,
    /// Name of the fleet; null in a test.
    pub fleet: Option<String>,
    /// Name of the robot; null if the whole fleet is concerned.
    pub robot: Option<String>,
    /// Name of the array; null if no single whisker is concerned.
    pub array: Option<String>,
    /// Number of the whisker in its array; null if no single whisker is concerned.
    #[schema(minimum = 0)]
    pub whisker: Option<i64>,
    /// The alarm of `ALARM_RAISED` and `ALARM_CLEARED`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub alarm: Option<AlarmPart>,
}

impl Event {
    /// The event of a test.
    #[must_use]
    pub fn test() -> Self {
        let level = OneOf(EventKind::Test.level(None));
        Self {
            kind: OneOf(EventKind::Test),
            event_id: None,
            version: VERSION,
            timestamp: Time(wall_clock().0 as i64),
            data: EventData {
                subject: Subject { level, fleet: None, robot: None, array: None, whisker: None, alarm: None },
                parts: Parts::default(),
            },
        }
    }
}

/// The event of the log as JSON. The stored data are not parsed: their bytes stay as they were written.
#[must_use]
pub fn published(stored: &StoredEvent) -> String {
    let (kind, word) = (stored.event_kind(), stored.word.as_deref());
    let is_alarm = matches!(kind, Some(EventKind::AlarmRaised | EventKind::AlarmCleared));
    let subject = Subject {
        level: OneOf(kind.unwrap_or(EventKind::Test).level(word)),
        fleet: Some(stored.fleet.clone()),
        robot: stored.robot.clone(),
        array: stored.array.clone(),
        whisker: stored.whisker,
        alarm: word.filter(|_| is_alarm).and_then(AlarmPart::of),
    };
    // Texts and numbers only: they cannot fail.
    let subject = serde_json::to_string(&subject).unwrap_or_default();
    let timestamp = serde_json::to_string(&Time(stored.recorded_us)).unwrap_or_default();
    let parts = stored.data.trim_start().strip_prefix('{').unwrap_or("}").trim_start();
    let comma = if parts.starts_with('}') { "" } else { "," };
    format!(
        r#"{{"type":"{}","event_id":{},"version":{},"timestamp":{timestamp},"data":{}{comma}{parts}}}"#,
        stored.kind,
        stored.event_id,
        stored.version,
        subject.strip_suffix('}').unwrap_or(&subject)
    )
}

/// A new event with its data.
pub(crate) fn event(kind: EventKind, recorded_us: i64, parts: &Parts) -> EventRow {
    // Texts and numbers only, and infinite numbers become null.
    EventRow { data: serde_json::to_string(parts).unwrap_or_default(), ..EventRow::new(kind, recorded_us) }
}

impl AlarmPart {
    fn of(word: &str) -> Option<Self> {
        let guidance = of_word(word)?;
        let runbook = format!("{RUNBOOKS}/{}", guidance.runbook);
        Some(Self { kind: OneOf(named(word)?), hint: guidance.hint.to_owned(), runbook })
    }
}

/// Where an engine reports contacts for Kafka, if they are published.
#[derive(Debug, Clone)]
pub(crate) struct EventSink {
    /// Whether contacts are published, and not only the other events.
    pub(crate) has_contacts: bool,
    /// Notified when a transaction with events is committed.
    pub(crate) committed: Arc<Notify>,
    /// Room for contacts.
    pub(crate) room: Arc<OutboxRoom>,
}

/// JSON Schema of [`Event`], as docs/event.schema.json has it.
#[must_use]
pub fn schema() -> serde_json::Value {
    let mut parts = Vec::new();
    Event::schemas(&mut parts);
    let parts: std::collections::BTreeMap<String, serde_json::Value> =
        parts.into_iter().map(|(name, part)| (name, serde_json::to_value(part).unwrap_or_default())).collect();
    let mut schema = serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Event",
    });
    let event = serde_json::to_value(Event::schema()).unwrap_or_default();
    if let (Some(schema), serde_json::Value::Object(event)) = (schema.as_object_mut(), event) {
        schema.extend(event);
        schema.insert("$defs".to_owned(), serde_json::json!(parts));
    }
    // The same schemas are components of the OpenAPI document.
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
        assert!(written.contains("\"CONTACTS\"") && written.contains("\"$ref\": \"#/$defs/EventData\""));
    }

    #[test]
    fn a_published_event_has_its_subject_and_its_stored_data() {
        let stored = |data: &str| StoredEvent {
            event_id: 7,
            tx: 3,
            recorded_us: 1_795_260_000_000_000,
            version: VERSION,
            kind: "ALARM_RAISED".to_owned(),
            word: Some("LEAK".to_owned()),
            fleet: "f".to_owned(),
            robot: Some("r".to_owned()),
            array: None,
            whisker: None,
            data: data.to_owned(),
        };
        for (data, trim_id) in
            [("{}", None), (r#"{"trim":{"trim_id":4}}"#, Some(4)), (" { \"trim\" : {\"trim_id\": 4}}", Some(4))]
        {
            let event: serde_json::Value = serde_json::from_str(&published(&stored(data))).unwrap();
            assert_eq!(
                (event["type"].as_str(), event["event_id"].as_i64()),
                (Some("ALARM_RAISED"), Some(7)),
                "{event}"
            );
            assert_eq!(event["data"]["trim"]["trim_id"].as_i64(), trim_id, "{event}");
            assert_eq!(
                (&event["data"]["robot"], &event["data"]["alarm"]["kind"]),
                (&"r".into(), &"LEAK".into()),
                "{event}"
            );
        }
    }
}
