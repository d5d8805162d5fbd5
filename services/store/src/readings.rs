//! What queries read: a struct for each, its fields the query's columns.

use serde::Serialize;

/// Defines what a query reads: a struct whose fields are the query's columns, by name.
macro_rules! readings {
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
pub(super) use readings;

/// Lets a type be read from columns that hold texts.
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

readings! {
    /// The estimated length after a contact.
    #[derive(Debug, Clone)]
    pub struct LengthPoint {
        /// Robot's clock.
        pub t_us: i64,
        /// Length.
        pub length_mm: f64,
        /// Its standard deviation.
        pub length_sd_mm: f64,
        /// Pressure.
        pub pressure_mpa: f64,
    }

    /// A change of condition or fault.
    #[derive(Debug, Clone, Serialize)]
    pub struct HealthChangeReading {
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        pub whisker: i64,
        /// Before.
        pub was: Option<String>,
        /// Now.
        pub becomes: Option<String>,
        /// When.
        pub recorded_us: i64,
    }

    /// A state that a setpoint came into.
    #[derive(Debug, Clone, Serialize)]
    pub struct SetpointStateReading {
        /// Robot.
        pub robot: String,
        /// Array.
        pub array: String,
        /// Number in the array.
        pub whisker: i64,
        /// Its pressure.
        pub pressure_mpa: f64,
        /// Why it was sent.
        pub reason: String,
        /// The state.
        pub state: String,
        /// When.
        pub recorded_us: i64,
    }
}
