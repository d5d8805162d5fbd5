//! Words of the core's closed enums in JSON, in queries and in schemas, as `vibrissa_edge::words` declares them.

use std::fmt;

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::schema::{ObjectBuilder, SchemaType, Type};
use utoipa::openapi::{RefOr, Schema};
use utoipa::{PartialSchema, ToSchema};
use vibrissa_core::mechanics::Objective;
use vibrissa_core::policy::{Case, LongerForShorter, Mode};
use vibrissa_core::robot::effect::{AlarmKind, CommandState, Condition, EndReason, Reason, TestState};
use vibrissa_edge::actions::AuditKind;
use vibrissa_edge::events::EventKind;
use vibrissa_edge::guidance::Level;
use vibrissa_edge::presence::Presence;
use vibrissa_edge::words::{Word, Words, named};

/// A value of one of the core's closed enums, in JSON and in queries as its word.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct OneOf<T>(pub T);

/// Mechanical condition of a whisker.
pub type ConditionWord = OneOf<Condition>;
/// Whether a robot is connected and heard.
pub type ConnectionWord = OneOf<Presence>;
/// Compensation case of the paper.
pub type CaseWord = OneOf<Case>;
/// Progress of a setpoint.
pub type SetpointStateWord = OneOf<CommandState>;
/// Progress of a touch test.
pub type TestStateWord = OneOf<TestState>;
/// Kind of an entry of the audit log.
pub type AuditKindWord = OneOf<AuditKind>;
/// How soon somebody must act on an alarm.
pub type LevelWord = OneOf<Level>;
/// Kind of event of webhooks.
pub type EventKindWord = OneOf<EventKind>;
/// Kind of alarm.
pub type AlarmKindWord = OneOf<AlarmKind>;
/// Whether compensations need approval.
pub type ModeWord = OneOf<Mode>;
/// Objective of the setpoint solver.
pub type ObjectiveWord = OneOf<Objective>;
/// Whether a longer whisker may compensate for a shorter one.
pub type LongerForShorterWord = OneOf<LongerForShorter>;
/// Why a compensation ended.
pub type EndReasonWord = OneOf<EndReason>;
/// Reason of a setpoint.
pub type SetpointReasonWord = OneOf<Reason>;

impl<T: Words + Copy> fmt::Display for OneOf<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.0.word())
    }
}

impl<T: Words + Copy> Serialize for OneOf<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.word())
    }
}

impl<'de, T: Words + Copy> Deserialize<'de> for OneOf<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let word = String::deserialize(deserializer)?;
        named(&word).map(Self).ok_or_else(|| {
            let words: Vec<String> = T::all().into_iter().map(|one| format!("`{}`", one.word())).collect();
            serde::de::Error::custom(format!("unknown variant `{word}`, expected one of {}", words.join(", ")))
        })
    }
}

impl<T: Words> PartialSchema for OneOf<T> {
    fn schema() -> RefOr<Schema> {
        let words: Vec<&str> = T::all().into_iter().map(Word::word).collect();
        let labels =
            T::all().into_iter().zip(&words).filter_map(|(one, word)| Some(format!("`{word}`: {}", one.label()?)));
        let labels = labels.collect::<Vec<_>>().join("; ");
        let description = (!labels.is_empty()).then(|| format!("{labels}."));
        let schema = ObjectBuilder::new().schema_type(SchemaType::Type(Type::String)).enum_values(Some(words));
        schema.description(description).into()
    }
}

impl<T: Words> ToSchema for OneOf<T> {
    fn name() -> std::borrow::Cow<'static, str> {
        format!("{}Word", T::NAME).into()
    }
}
