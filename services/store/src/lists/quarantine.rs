//! Messages in quarantine: the database refused their rows.

use std::borrow::Cow;

use serde::Serialize;
use utoipa::ToSchema;
use vibrissa_protocol::as_json;

use super::sorts;
use crate::from_row::from_row;
use crate::list::List;
use crate::time::Time;

/// Most characters of a message that a list shows.
const PAYLOAD_CHARACTERS_MAX: usize = 2000;

/// Bytes of a message as text; CBOR as JSON, and a replacement character for invalid UTF-8.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, ToSchema)]
#[serde(transparent)]
pub struct PayloadText(String);

impl<DB: sqlx::Database> sqlx::Type<DB> for PayloadText
where
    Vec<u8>: sqlx::Type<DB>,
{
    fn type_info() -> DB::TypeInfo {
        <Vec<u8> as sqlx::Type<DB>>::type_info()
    }

    fn compatible(ty: &DB::TypeInfo) -> bool {
        <Vec<u8> as sqlx::Type<DB>>::compatible(ty)
    }
}

impl<'r, DB: sqlx::Database> sqlx::Decode<'r, DB> for PayloadText
where
    Vec<u8>: sqlx::Decode<'r, DB>,
{
    fn decode(value: DB::ValueRef<'r>) -> Result<Self, sqlx::error::BoxDynError> {
        let bytes = <Vec<u8> as sqlx::Decode<'r, DB>>::decode(value)?;
        let text = as_json(&bytes).unwrap_or(Cow::Borrowed(&bytes));
        Ok(Self(String::from_utf8_lossy(&text).chars().take(PAYLOAD_CHARACTERS_MAX).collect()))
    }
}

from_row! {
    /// A valid message whose rows the database refused. It was receipted, and had no other effect.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Quarantined {
        /// Number of the row.
        #[schema(minimum = 0)]
        pub quarantine_id: i64,
        /// Name of the fleet.
        pub fleet: String,
        /// Name of the robot that sent the message.
        pub robot: String,
        /// Topic below the robot's level, such as `contacts`.
        pub topic: String,
        /// Boot of the robot that sent the message; null if the message does not name it.
        pub boot_id: Option<String>,
        /// Sequence number of the message in its boot and topic; null if the message has none.
        pub seq: Option<i64>,
        /// Time of receipt, by the supervisor's clock.
        pub received_at: Time,
        /// Time at which the message was put into quarantine, by the supervisor's clock.
        pub quarantined_at: Time,
        /// Class of the error: `DATA` (the database cannot represent a value), `CONSTRAINT` (a constraint or trigger
        /// refuses the row), or `SIZE` (a row is too large).
        pub cause: String,
        /// Error code of the database: an SQLSTATE, or SQLite's extended result code.
        pub code: String,
        /// First 2000 characters of the message.
        pub payload: PayloadText,
    }
}

sorts! {
    /// Sort keys of the list of messages in quarantine.
    pub enum QuarantineSort {
        /// By the time at which they were put into quarantine.
        QuarantinedAt = "quarantined_at" Whole Down,
    }
}

/// All messages in quarantine.
pub static QUARANTINE: List = List {
    what: "list the messages in quarantine",
    select: "SELECT quarantine_id, fleet, robot, topic, boot_id, seq, received_us AS received_at, \
             quarantined_us AS quarantined_at, cause, code, payload FROM quarantine",
    details: "",
    keys: &[],
    sorts: QuarantineSort::SORTS,
    id: "quarantine_id",
};
