//! Row types of queries: structs whose fields are the query's columns.

use serde::Serialize;

/// Defines structs that are read from rows: each field is the column of the same name.
macro_rules! from_row {
    ($($(#[$meta:meta])* $vis:vis struct $name:ident { $($(#[$field_meta:meta])* $field_vis:vis $field:ident: $type:ty,)+ })+) => {
        $($(#[$meta])* $vis struct $name { $($(#[$field_meta])* $field_vis $field: $type,)+ }

        impl<'r> sqlx::FromRow<'r, sqlx::sqlite::SqliteRow> for $name {
            fn from_row(row: &'r sqlx::sqlite::SqliteRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?,)+ })
            }
        }

        impl<'r> sqlx::FromRow<'r, sqlx::postgres::PgRow> for $name {
            fn from_row(row: &'r sqlx::postgres::PgRow) -> sqlx::Result<Self> {
                Ok(Self { $($field: sqlx::Row::try_get(row, stringify!($field))?,)+ })
            }
        }
        )+
    };
}
pub(super) use from_row;

/// Lets a type be read from text columns.
macro_rules! text_columns {
    ($name:ident) => {
        impl sqlx::Type<sqlx::Sqlite> for $name {
            fn type_info() -> sqlx::sqlite::SqliteTypeInfo {
                <String as sqlx::Type<sqlx::Sqlite>>::type_info()
            }

            fn compatible(ty: &sqlx::sqlite::SqliteTypeInfo) -> bool {
                <String as sqlx::Type<sqlx::Sqlite>>::compatible(ty)
            }
        }

        impl sqlx::Type<sqlx::Postgres> for $name {
            fn type_info() -> sqlx::postgres::PgTypeInfo {
                <String as sqlx::Type<sqlx::Postgres>>::type_info()
            }

            fn compatible(ty: &sqlx::postgres::PgTypeInfo) -> bool {
                <String as sqlx::Type<sqlx::Postgres>>::compatible(ty)
            }
        }

        impl<'r> sqlx::Decode<'r, sqlx::Sqlite> for $name {
            fn decode(value: sqlx::sqlite::SqliteValueRef<'r>) -> Result<Self, sqlx::error::BoxDynError> {
                Ok(<String as sqlx::Decode<sqlx::Sqlite>>::decode(value)?.try_into()?)
            }
        }

        impl<'r> sqlx::Decode<'r, sqlx::Postgres> for $name {
            fn decode(value: sqlx::postgres::PgValueRef<'r>) -> Result<Self, sqlx::error::BoxDynError> {
                Ok(<String as sqlx::Decode<sqlx::Postgres>>::decode(value)?.try_into()?)
            }
        }
    };
}
pub(super) use text_columns;

/// A JSON document that the database stores as text.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Json(pub serde_json::Value);

impl TryFrom<String> for Json {
    type Error = serde_json::Error;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        serde_json::from_str(&text).map(Self)
    }
}

text_columns!(Json);

from_row! {
    /// Estimated length after a contact.
    #[derive(Debug, Clone)]
    pub struct LengthPoint {
        /// Time of the contact, µs since 1970 UTC by the robot's clock.
        pub t_us: i64,
        /// Estimated length, mm.
        pub length_mm: f64,
        /// Standard deviation of the estimated length, mm.
        pub length_sd_mm: f64,
        /// Pressure of the chamber, MPa.
        pub pressure_mpa: f64,
    }

    /// A change of a whisker's condition or fault.
    #[derive(Debug, Clone, Serialize)]
    pub struct HealthChangeReading {
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        pub whisker: i64,
        /// Condition or fault before the change; `None` for no fault.
        pub was: Option<String>,
        /// Condition or fault after the change; `None` for no fault.
        pub becomes: Option<String>,
        /// Time of the change, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
    }

    /// A state in the history of a setpoint.
    #[derive(Debug, Clone, Serialize)]
    pub struct SetpointStateReading {
        /// Name of the robot.
        pub robot: String,
        /// Name of the array.
        pub array: String,
        /// Number of the whisker in its array.
        pub whisker: i64,
        /// Pressure of the setpoint, MPa.
        pub pressure_mpa: f64,
        /// Reason of the setpoint, such as `SELF_COMPENSATION`.
        pub reason: String,
        /// The state, such as `APPLIED`.
        pub state: String,
        /// Time at which the setpoint entered the state, µs since 1970 UTC by the supervisor's clock.
        pub recorded_us: i64,
    }
}
