//! Values of columns, and the types of fields that consist of them.

use sqlx::postgres::{PgArguments, Postgres};
use sqlx::query::Query;
use sqlx::sqlite::{Sqlite, SqliteArguments};

/// Defines the types of columns: the name in Rust and in PostgreSQL, the SQLite types that hold it, and the Rust type
/// of a value.
macro_rules! types {
    ($($name:ident, $postgres:literal, $sqlite:literal: $value:ty;)+) => {
        /// Type of a column.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub(crate) enum Type { $($name),+ }

        impl Type {
            /// Name of the type in PostgreSQL.
            pub(crate) fn postgres(self) -> &'static str {
                match self { $(Self::$name => $postgres),+ }
            }

            /// Name of the type in SQLite.
            pub(crate) fn sqlite(self) -> &'static str {
                match self { $(Self::$name => $sqlite),+ }
            }
        }

        /// Value of a column; `None` is NULL.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub(crate) enum Value<'r> { $($name(Option<$value>)),+ }

        impl Value<'_> {
            /// Binds the value as the next parameter of a statement.
            pub(crate) fn bind(self, query: Query<'static, Sqlite, SqliteArguments>)
                -> Query<'static, Sqlite, SqliteArguments> {
                match self { $(Self::$name(value) => query.bind(value)),+ }
            }
        }

        $(impl<'r> From<$value> for Value<'r> {
            fn from(value: $value) -> Self {
                Self::$name(Some(value))
            }
        }

        impl<'r> From<Option<$value>> for Value<'r> {
            fn from(value: Option<$value>) -> Self {
                Self::$name(value)
            }
        })+

        /// The values of a column in several rows.
        #[derive(Debug)]
        pub(crate) enum Array<'r> { $($name(Vec<Option<$value>>)),+ }

        impl<'r> Array<'r> {
            /// An empty array with room for `rows` values.
            pub(crate) fn new(kind: Type, rows: usize) -> Self {
                match kind { $(Type::$name => Self::$name(Vec::with_capacity(rows))),+ }
            }

            /// Appends a value, which has the type of the array.
            pub(crate) fn push(&mut self, value: Value<'r>) {
                match (self, value) {
                    $((Self::$name(values), Value::$name(value)) => values.push(value),)+
                    (array, value) => unreachable!("{value:?} is no value of {array:?}"),
                }
            }

            /// Binds the array as the next parameter of a statement.
            pub(crate) fn bind(self, query: Query<'static, Postgres, PgArguments>)
                -> Query<'static, Postgres, PgArguments> {
                match self { $(Self::$name(values) => query.bind(values)),+ }
            }
        }
    };
}

types! {
    Bigint, "bigint", "INTEGER": i64;
    Integer, "integer", "INTEGER": i32;
    Double, "double precision", "REAL": f64;
    Real, "real", "REAL": f32;
    Boolean, "boolean", "INTEGER": bool;
    Text, "text", "TEXT": &'r str;
    Bytes, "bytea", "BLOB": &'r [u8];
}

/// A field of a row, as the values of one or more columns.
pub(crate) trait Field {
    /// Types of the columns.
    const TYPES: &'static [Type];

    /// Passes the value of each column to `put`.
    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>));
}

/// Implements [`Field`] for types of one column, also if the value may be missing.
macro_rules! fields {
    ($($type:ty = $kind:ident |$field:ident| $value:expr;)+) => {$(
        impl Field for $type {
            const TYPES: &'static [Type] = &[Type::$kind];

            fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
                let $field = self;
                put(Value::$kind(Some($value)));
            }
        }

        impl Field for Option<$type> {
            const TYPES: &'static [Type] = &[Type::$kind];

            fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
                put(Value::$kind(self.as_ref().map(|$field| $value)));
            }
        }
    )+};
}

fields! {
    i64 = Bigint |field| *field;
    i32 = Integer |field| *field;
    f64 = Double |field| *field;
    f32 = Real |field| *field;
    bool = Boolean |field| *field;
    &str = Text |field| *field;
    String = Text |field| field.as_str();
    Vec<u8> = Bytes |field| field.as_slice();
}

/// Estimate, lower and upper bound.
/// An estimate with its 95 % interval.
#[derive(Debug, Clone, Copy)]
pub struct Interval {
    /// The estimated value.
    pub mean: f64,
    /// Lower bound of the interval.
    pub low: f64,
    /// Upper bound of the interval.
    pub high: f64,
}

impl Field for Interval {
    const TYPES: &'static [Type] = &[Type::Double; 3];

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        [self.mean, self.low, self.high].into_iter().for_each(|value| put(value.into()));
    }
}

impl Field for Option<Interval> {
    const TYPES: &'static [Type] = Interval::TYPES;

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        let values = [self.map(|one| one.mean), self.map(|one| one.low), self.map(|one| one.high)];
        values.into_iter().for_each(|value| put(value.into()));
    }
}

/// Lower and upper bound.
impl Field for Option<(f64, f64)> {
    const TYPES: &'static [Type] = &[Type::Double; 2];

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        put(self.map(|bounds| bounds.0).into());
        put(self.map(|bounds| bounds.1).into());
    }
}

/// One column for each element.
impl<F: Field, const N: usize> Field for [F; N] {
    const TYPES: &'static [Type] = &[F::TYPES[0]; N];

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        self.iter().for_each(|field| field.put(put));
    }
}
