//! Body of a request to a target.

use serde::Serialize;
use utoipa::ToSchema;
use vibrissa_edge::clock::wall_clock;
use vibrissa_edge::guidance::{RUNBOOKS, of_word};
use vibrissa_edge::webhooks::EventKind;
use vibrissa_edge::words::named;
use vibrissa_store::time::Time;
use vibrissa_store::webhooks::event::EventRow;

use crate::one_of::{
    AlarmKindWord, CaseWord, ConditionWord, EndReasonWord, EventKindWord, LevelWord, OneOf, SetpointReasonWord,
    SetpointStateWord,
};

/// Version of the format. It rises if a field is removed or changes its meaning; new fields may come without a new version.
const VERSION: u32 = 1;

/// An event, as webhooks send it. `type`, `timestamp` and `data` are those of Standard Webhooks.
#[derive(Debug, Serialize, ToSchema)]
pub struct WebhookEvent {
    /// Kind of the event.
    #[serde(rename = "type")]
    pub kind: EventKindWord,
    /// Time of the event, by the supervisor's clock.
    pub timestamp: Time,
    /// Version of this format: 1.
    #[schema(minimum = 1)]
    pub version: u32,
    /// What happened, and where.
    pub data: EventData,
}

/// What happened, and where. Parts that do not concern the kind of the event are null.
#[derive(Debug, Serialize, ToSchema)]
pub struct EventData {
    /// Number of the event, unique in the database; null in a test.
    #[schema(minimum = 1)]
    pub event_id: Option<i64>,
    /// How soon somebody must act.
    pub level: LevelWord,
    /// Name of the fleet; null in a test.
    pub fleet: Option<String>,
    /// Name of the robot; null in a test.
    pub robot: Option<String>,
    /// Name of the array; null if the whole robot is concerned.
    pub array: Option<String>,
    /// Number of the whisker in its array; null if the whole robot is concerned.
    #[schema(minimum = 0)]
    pub whisker: Option<i64>,
    /// The alarm of `ALARM_RAISED` and `ALARM_CLEARED`.
    pub alarm: Option<AlarmPart>,
    /// The trim of `TRIM`.
    pub trim: Option<TrimPart>,
    /// The change of `CONDITION_CHANGED`.
    pub condition: Option<ConditionPart>,
    /// The compensation of `COMPENSATION_BEGUN` and `COMPENSATION_ENDED`; the event's whisker is its target.
    pub compensation: Option<CompensationPart>,
    /// The setpoint of `SETPOINT_FAILED`.
    pub setpoint: Option<SetpointPart>,
}

/// An alarm.
#[derive(Debug, Serialize, ToSchema)]
pub struct AlarmPart {
    /// Number of the alarm, the same when it is raised and when it is cleared.
    pub alarm_id: i64,
    /// Kind of the alarm.
    pub kind: AlarmKindWord,
    /// Advice in one or two sentences.
    pub hint: String,
    /// Path of the runbook on the supervisor.
    pub runbook: String,
}

/// A trim.
#[derive(Debug, Serialize, ToSchema)]
pub struct TrimPart {
    /// Number of the trim.
    pub trim_id: i64,
    /// Length before, mm.
    pub length_before_mm: Option<f64>,
    /// Length after, mm.
    pub length_after_mm: Option<f64>,
    /// Standard deviation of the length after, mm.
    pub length_after_sd_mm: Option<f64>,
}

/// A change of a whisker's condition.
#[derive(Debug, Serialize, ToSchema)]
pub struct ConditionPart {
    /// Condition before.
    pub was: Option<ConditionWord>,
    /// Condition after.
    pub becomes: Option<ConditionWord>,
}

/// A compensation.
#[derive(Debug, Serialize, ToSchema)]
pub struct CompensationPart {
    /// Number of the compensation.
    pub compensation_id: i64,
    /// Case of the paper.
    pub case: Option<CaseWord>,
    /// Number of the compensating whisker in the array.
    pub compensator_whisker: Option<i64>,
    /// Pressure of the compensator, MPa.
    pub pressure_mpa: Option<f64>,
    /// Predicted compensation error, as a ratio.
    pub predicted_error: Option<f64>,
    /// Why it ended; null when it begins.
    pub end_reason: Option<EndReasonWord>,
}

/// A setpoint that was rejected, failed or expired.
#[derive(Debug, Serialize, ToSchema)]
pub struct SetpointPart {
    /// Identifier of the setpoint, a UUID.
    pub command_id: String,
    /// State of the setpoint.
    pub state: Option<SetpointStateWord>,
    /// Pressure of the setpoint, MPa.
    pub pressure_mpa: Option<f64>,
    /// Reason of the setpoint.
    pub reason: Option<SetpointReasonWord>,
    /// Why the robot rejected it; null otherwise.
    pub error: Option<String>,
}

impl WebhookEvent {
    /// The body about an event of the outbox. It is the same at each attempt.
    #[must_use]
    pub fn of(event: &EventRow) -> Self {
        let kind = event.event_kind().unwrap_or(EventKind::Test);
        let word = event.word.as_deref();
        let is_alarm = matches!(kind, EventKind::AlarmRaised | EventKind::AlarmCleared);
        let is_compensation = matches!(kind, EventKind::CompensationBegun | EventKind::CompensationEnded);
        let number = event.number.unwrap_or_default();
        Self {
            kind: OneOf(kind),
            timestamp: Time(event.occurred_us),
            version: VERSION,
            data: EventData {
                event_id: Some(event.event_id),
                level: OneOf(kind.level(word)),
                fleet: Some(event.fleet.clone()),
                robot: Some(event.robot.clone()),
                array: event.array.clone(),
                whisker: event.whisker,
                alarm: word.filter(|_| is_alarm).and_then(|word| AlarmPart::of(number, word)),
                trim: (kind == EventKind::Trim).then_some(TrimPart {
                    trim_id: number,
                    length_before_mm: event.length_before_mm,
                    length_after_mm: event.length_after_mm,
                    length_after_sd_mm: event.length_after_sd_mm,
                }),
                condition: (kind == EventKind::ConditionChanged).then(|| ConditionPart {
                    was: event.was.as_deref().and_then(named).map(OneOf),
                    becomes: word.and_then(named).map(OneOf),
                }),
                compensation: is_compensation.then(|| CompensationPart {
                    compensation_id: number,
                    case: event.compensation_case.as_deref().and_then(named).map(OneOf),
                    compensator_whisker: event.compensator_whisker,
                    pressure_mpa: event.pressure_mpa,
                    predicted_error: event.predicted_error,
                    end_reason: word.and_then(named).map(OneOf),
                }),
                setpoint: event.command_id.as_ref().map(|command_id| SetpointPart {
                    command_id: command_id.clone(),
                    state: word.and_then(named).map(OneOf),
                    pressure_mpa: event.pressure_mpa,
                    reason: event.setpoint_reason.as_deref().and_then(named).map(OneOf),
                    error: event.setpoint_error.clone(),
                }),
            },
        }
    }

    /// The body of a test.
    #[must_use]
    pub fn test() -> Self {
        Self {
            kind: OneOf(EventKind::Test),
            timestamp: Time(wall_clock().0 as i64),
            version: VERSION,
            data: EventData {
                event_id: None,
                level: OneOf(EventKind::Test.level(None)),
                fleet: None,
                robot: None,
                array: None,
                whisker: None,
                alarm: None,
                trim: None,
                condition: None,
                compensation: None,
                setpoint: None,
            },
        }
    }
}

impl AlarmPart {
    fn of(alarm_id: i64, word: &str) -> Option<Self> {
        let guidance = of_word(word)?;
        let runbook = format!("{RUNBOOKS}/{}", guidance.runbook);
        Some(Self { alarm_id, kind: OneOf(named(word)?), hint: guidance.hint.to_owned(), runbook })
    }
}

/// JSON Schema of [`WebhookEvent`], as docs/webhook.schema.json has it.
#[must_use]
pub fn schema() -> serde_json::Value {
    use utoipa::{PartialSchema as _, ToSchema as _};
    let mut parts = Vec::new();
    WebhookEvent::schemas(&mut parts);
    let mut schema = serde_json::json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "WebhookEvent",
    });
    let told = serde_json::to_value(WebhookEvent::schema()).unwrap_or_default();
    let parts: std::collections::BTreeMap<String, serde_json::Value> =
        parts.into_iter().map(|(name, part)| (name, serde_json::to_value(part).unwrap_or_default())).collect();
    if let (Some(schema), serde_json::Value::Object(told)) = (schema.as_object_mut(), told) {
        schema.extend(told);
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
    fn the_files_in_docs_describe_the_events_of_webhooks() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/webhook.schema.json");
        let written = serde_json::to_string_pretty(&schema()).unwrap() + "\n";
        if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
            std::fs::write(path, &written).unwrap();
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(
            there == written,
            "docs/webhook.schema.json differs from the code: write it with VIBRISSA_WRITE_DOCS=1"
        );
        assert!(written.contains("\"COMPENSATION_BEGUN\"") && written.contains("\"$ref\": \"#/$defs/EventData\""));
    }
}
