//! Messages that the database refused.

use serde::Serialize;
use utoipa::ToSchema;

use super::sorts;
use crate::list::List;
use crate::readings::readings;
use crate::time::Time;

/// Characters of a message that a list shows at most.
const PAYLOAD_CHARACTERS_MAX: usize = 2000;

/// A message's bytes as text, with a replacement character for invalid UTF-8.
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
        Ok(Self(String::from_utf8_lossy(&bytes).chars().take(PAYLOAD_CHARACTERS_MAX).collect()))
    }
}

readings! {
    /// A message that the database refused, although it keeps the contract. It was receipted, and nothing followed from it.
    #[derive(Debug, Clone, PartialEq, Serialize, ToSchema)]
    pub struct Quarantined {
        /// The row's number.
        #[schema(minimum = 0)]
        pub quarantine_id: i64,
        /// The fleet's name.
        pub fleet: String,
        /// The robot that sent it.
        pub robot: String,
        /// The topic below the robot's level, such as `contacts`.
        pub topic: String,
        /// The boot that sent it; null if the message does not say so.
        pub boot_id: Option<String>,
        /// Its number in this boot and topic; null if the message does not say so.
        pub seq: Option<i64>,
        /// When it was received, by the supervisor's clock.
        pub received_at: Time,
        /// When it was put into quarantine, by the supervisor's clock.
        pub quarantined_at: Time,
        /// Why: `DATA` (a value has no form in the database), `CONSTRAINT` (a constraint or trigger refuses the row), or `SIZE`
        /// (a row is too large).
        pub cause: String,
        /// The database's own code of the error: an SQLSTATE, or SQLite's extended result code.
        pub code: String,
        /// The first 2000 characters of the message.
        pub payload: PayloadText,
    }
}

sorts! {
    /// Sort orders of the list of messages in quarantine.
    pub enum QuarantineSort {
        /// When they were put there.
        QuarantinedAt = "quarantined_at" Whole Down,
    }
}

/// Messages that the database refused.
pub static QUARANTINE: List = List {
    what: "list the messages in quarantine",
    select: "SELECT quarantine_id, fleet, robot, topic, boot_id, seq, received_us AS received_at, \
             quarantined_us AS quarantined_at, cause, code, payload FROM quarantine",
    sorts: QuarantineSort::SORTS,
    id: "quarantine_id",
};
