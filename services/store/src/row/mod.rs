//! Rows of tables, each declared once: a declaration gives the struct and its columns in both databases.
//!
//! [`row!`] declares the struct, [`Statement`] writes it into a table. A new column is a new field of the struct
//! and a column in the two migrations.

pub(crate) mod statement;
mod value;

pub(crate) use statement::{Declared, Parent, Statement};
pub use value::Interval;
pub(crate) use value::{Array, Field, Type, Value};

/// A column of a table.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Column {
    /// Name of the column.
    pub(crate) name: &'static str,
    /// Type of its values.
    pub(crate) kind: Type,
}

/// Values of columns, in a fixed order. The first column of a row that is written is never NULL; it is the key of a row
/// that is updated.
pub(crate) trait Row: Sync {
    /// The columns.
    fn columns() -> Vec<Column>;

    /// Passes the value of each column to `put`.
    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>));
}

impl<R: Row> Row for &R {
    fn columns() -> Vec<Column> {
        R::columns()
    }

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        R::put(self, put);
    }
}

/// The columns of the first row, then those of the second.
impl<A: Row, B: Row> Row for (A, B) {
    fn columns() -> Vec<Column> {
        [A::columns(), B::columns()].concat()
    }

    fn put<'r>(&'r self, put: &mut impl FnMut(Value<'r>)) {
        self.0.put(put);
        self.1.put(put);
    }
}

/// The columns of a field of type `F`.
pub(crate) fn columns_of<F: Field>(names: &'static [&'static str]) -> impl Iterator<Item = Column> {
    names.iter().zip(F::TYPES).map(|(&name, &kind)| Column { name, kind })
}

/// Declares rows: structs with the columns of their fields.
///
/// A field is the column of the same name, or the columns in the list behind its type; a field with an empty list is
/// no column. `also` declares columns whose values are computed from the row.
macro_rules! row {
    ($(
        $(#[$meta:meta])*
        pub struct $name:ident {
            $($(#[$field_meta:meta])* pub $field:ident: $type:ty $(= [$($column:literal),*])?,)+
        }
        $(also { $($computed:ident: $computed_type:ty = |$row:ident| $value:expr,)+ })?
    )+) => {$(
        $(#[$meta])*
        #[derive(Debug, Clone)]
        pub struct $name {
            $($(#[$field_meta])* pub $field: $type,)+
        }

        $crate::row::columns! {
            $name { $($field: $type $(= [$($column),*])?,)+ }
            $(also { $($computed: $computed_type = |$row| $value,)+ })?
        }
    )+};
}
pub(crate) use row;

/// Declares the columns of a struct, in the form of [`row!`].
macro_rules! columns {
    (
        $name:ident $(<$life:lifetime>)? {
            $($field:ident: $type:ty $(= [$($column:literal),*])?,)+
        }
        $(also { $($computed:ident: $computed_type:ty = |$row:ident| $value:expr,)+ })?
    ) => {
        impl $(<$life>)? $crate::row::Row for $name $(<$life>)? {
            fn columns() -> Vec<$crate::row::Column> {
                let mut columns = Vec::new();
                $($crate::row::columns!(@names columns, $field: $type $(= [$($column),*])?);)+
                $($($crate::row::columns!(@names columns, $computed: $computed_type);)+)?
                columns
            }

            fn put<'r>(&'r self, put: &mut impl FnMut($crate::row::Value<'r>)) {
                $($crate::row::columns!(@put self, put, $field: $type $(= [$($column),*])?);)+
                $($({
                    let $row = self;
                    let value: $computed_type = $value;
                    put(value.into());
                })+)?
            }
        }
    };
    (@names $columns:ident, $field:ident: $type:ty = []) => {};
    (@names $columns:ident, $field:ident: $type:ty = [$($column:literal),+]) => {
        const { assert!([$($column),+].len() == <$type as $crate::row::Field>::TYPES.len()) };
        $columns.extend($crate::row::columns_of::<$type>(&[$($column),+]));
    };
    (@names $columns:ident, $field:ident: $type:ty) => {
        const { assert!(<$type as $crate::row::Field>::TYPES.len() == 1) };
        $columns.extend($crate::row::columns_of::<$type>(&[stringify!($field)]));
    };
    (@put $self:ident, $put:ident, $field:ident: $type:ty = []) => {};
    (@put $self:ident, $put:ident, $field:ident: $type:ty $(= [$($column:literal),+])?) => {
        $crate::row::Field::put(&$self.$field, $put);
    };
}
pub(crate) use columns;
