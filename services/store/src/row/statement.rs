//! Statements that write rows, made from the rows' columns for both databases.

use std::borrow::Borrow;
use std::iter::repeat_n;
use std::marker::PhantomData;
use std::sync::OnceLock;

use sqlx::postgres::{PgArguments, Postgres};
use sqlx::query::Query;
use sqlx::sqlite::{Sqlite, SqliteArguments};

use super::{Array, Column, Row, Type, Value};
use crate::database::{Either, Tx};

/// Most rows of one SQLite statement, which may have 32,766 parameters.
pub(crate) const ROWS_A_STATEMENT: usize = 512;
/// Number of powers of two up to [`ROWS_A_STATEMENT`].
const SIZES: usize = ROWS_A_STATEMENT.ilog2() as usize + 1;

/// A statement that writes rows of type `R`.
///
/// SQLite gets the rows as `VALUES`. PostgreSQL gets an array for each column, in one statement whatever the number of
/// rows is.
pub(crate) struct Statement<R> {
    kind: StatementKind,
    conflict: &'static str,
    returning: &'static str,
    columns: OnceLock<Vec<Column>>,
    /// Texts for SQLite by the logarithm of the number of rows.
    sqlite: [OnceLock<&'static str>; SIZES],
    postgres: OnceLock<&'static str>,
    row: PhantomData<R>,
}

/// What a statement does with its rows.
enum StatementKind {
    Insert {
        table: &'static str,
    },
    InsertBelow {
        table: &'static str,
        parent: Parent,
    },
    Update {
        table: &'static str,
        also: &'static str,
    },
    /// A text with `ROWS` in the place of the rows `n` and `OWNED` in the place of a condition.
    Custom {
        table: &'static str,
        sql: &'static str,
    },
}

/// The table that a row refers to with a number that the database has assigned.
pub(crate) struct Parent {
    /// Name of the table.
    pub(crate) table: &'static str,
    /// Part of a whole transaction's statement that returns the new rows of the table.
    pub(crate) part: &'static str,
    /// Column with the number, in both tables.
    pub(crate) number: &'static str,
    /// Columns that identify the parent; the rows' first columns have the same names.
    pub(crate) keys: [&'static str; 2],
}

impl<R: Row> Statement<R> {
    const fn new(kind: StatementKind) -> Self {
        Self {
            kind,
            conflict: "",
            returning: "",
            columns: OnceLock::new(),
            sqlite: [const { OnceLock::new() }; SIZES],
            postgres: OnceLock::new(),
            row: PhantomData,
        }
    }

    /// Inserts the rows.
    pub(crate) const fn insert(table: &'static str) -> Self {
        Self::new(StatementKind::Insert { table })
    }

    /// Inserts the rows below the newest parent with the same keys.
    pub(crate) const fn insert_below(table: &'static str, parent: Parent) -> Self {
        Self::new(StatementKind::InsertBelow { table, parent })
    }

    /// Sets all other columns of the rows with the same first column. `also` is a list of further assignments.
    pub(crate) const fn update(table: &'static str, also: &'static str) -> Self {
        Self::new(StatementKind::Update { table, also })
    }

    /// Writes the rows into a table as `sql` says.
    pub(crate) const fn custom(table: &'static str, sql: &'static str) -> Self {
        Self::new(StatementKind::Custom { table, sql })
    }

    /// Leaves existing rows unchanged.
    pub(crate) const fn unless_exists(self) -> Self {
        let mut statement = self;
        statement.conflict = " ON CONFLICT DO NOTHING";
        statement
    }

    /// Sets columns of existing rows, as `conflict` says.
    pub(crate) const fn on_conflict(self, conflict: &'static str) -> Self {
        let mut statement = self;
        statement.conflict = conflict;
        statement
    }

    /// Returns columns of the new rows, for other parts of a whole transaction's statement.
    pub(crate) const fn returning(self, returning: &'static str) -> Self {
        let mut statement = self;
        statement.returning = returning;
        statement
    }

    /// Columns of the rows.
    pub(crate) fn columns(&self) -> &[Column] {
        self.columns.get_or_init(R::columns)
    }

    fn names(&self) -> String {
        self.list(", ", |name| name.to_owned())
    }

    fn list(&self, separator: &str, column: impl Fn(&str) -> String) -> String {
        let columns: Vec<String> = self.columns().iter().map(|one| column(one.name)).collect();
        columns.join(separator)
    }

    /// Text with the rows, their condition, and the table or part of the rows' parents.
    fn text(&self, rows: &str, owned: &str, parents: impl Fn(&Parent) -> &'static str) -> String {
        let text = match &self.kind {
            StatementKind::Insert { table } => {
                format!("INSERT INTO {table} ({}) SELECT n.* FROM {rows} WHERE {owned}", self.names())
            }
            StatementKind::InsertBelow { table, parent } => {
                let names: Vec<&str> = self.columns().iter().map(|one| one.name).collect();
                let own: Vec<&str> = names.into_iter().filter(|name| !parent.keys.contains(name)).collect();
                let (number, [first, second]) = (parent.number, parent.keys);
                format!(
                    "INSERT INTO {table} ({number}, {}) SELECT (SELECT max(p.{number}) FROM {} p \
                     WHERE p.{first} = n.{first} AND p.{second} = n.{second}), n.{} FROM {rows} WHERE {owned}",
                    own.join(", "),
                    parents(parent),
                    own.join(", n."),
                )
            }
            StatementKind::Update { table, also } => {
                let key = self.columns()[0].name;
                let values = self.columns()[1..].iter().map(|Column { name, .. }| format!("{name} = n.{name}"));
                let values: Vec<String> =
                    values.chain(Some(*also).filter(|also| !also.is_empty()).map(ToOwned::to_owned)).collect();
                let values = values.join(", ");
                format!("UPDATE {table} AS t SET {values} FROM {rows} WHERE t.{key} = n.{key} AND {owned}")
            }
            StatementKind::Custom { sql, .. } => sql.replace("ROWS", rows).replace("OWNED", owned),
        };
        let returning = if self.returning.is_empty() { "" } else { " RETURNING " };
        text + self.conflict + returning + self.returning
    }

    /// Text for PostgreSQL, with the word `OWNED` in the place of a condition, as a part of a larger statement.
    pub(crate) fn part(&self) -> String {
        self.postgres_text("OWNED", |parent| parent.part)
    }

    fn postgres_text(&self, owned: &str, parents: impl Fn(&Parent) -> &'static str) -> String {
        let arrays = self.columns().iter().zip(1..).map(|(column, at)| format!("${at}::{}[]", column.kind.postgres()));
        let arrays: Vec<String> = arrays.collect();
        self.text(&format!("unnest({}) AS n ({})", arrays.join(", "), self.names()), owned, parents)
    }

    /// Binds the rows as the next parameters of a PostgreSQL statement: an array for each column.
    pub(crate) fn bind<B: Borrow<R>>(
        &self,
        query: Query<'static, Postgres, PgArguments>,
        rows: &[B],
    ) -> Query<'static, Postgres, PgArguments> {
        let mut arrays: Vec<Array<'_>> =
            self.columns().iter().map(|column| Array::new(column.kind, rows.len())).collect();
        for row in rows {
            let mut columns = arrays.iter_mut();
            row.borrow().put(&mut |value| columns.next().into_iter().for_each(|array| array.push(value)));
        }
        arrays.into_iter().fold(query, |query, array| array.bind(query))
    }

    fn of_postgres<B: Borrow<R>>(&self, rows: &[B]) -> Query<'static, Postgres, PgArguments> {
        let text = self.postgres.get_or_init(|| self.postgres_text("TRUE", |parent| parent.table).leak());
        self.bind(sqlx::query(*text), rows)
    }

    /// Text for SQLite. Rows whose first column is NULL are not written.
    fn sqlite_text(&self, rows: usize) -> String {
        let owned = match &self.kind {
            StatementKind::Insert { .. } | StatementKind::InsertBelow { .. } => {
                format!("n.{} IS NOT NULL", self.columns()[0].name)
            }
            StatementKind::Update { .. } | StatementKind::Custom { .. } => "TRUE".to_owned(),
        };
        let row = format!("({})", self.list(", ", |_| "?".to_owned()));
        let rows: Vec<&str> = repeat_n(row.as_str(), rows).collect();
        let text = self.text("n", &owned, |parent| parent.table);
        format!("WITH n ({}) AS (VALUES {}) {text}", self.names(), rows.join(", "))
    }

    /// A piece of at most [`ROWS_A_STATEMENT`] rows. It is filled up to a power of two with rows of NULL. So there are
    /// few different statements, each prepared once, and few executions, each of which costs a round trip to SQLite's
    /// thread.
    fn of_sqlite<B: Borrow<R>>(&self, piece: &[B]) -> Query<'static, Sqlite, SqliteArguments> {
        let size = piece.len().next_power_of_two();
        let text = self.sqlite[size.ilog2() as usize].get_or_init(|| self.sqlite_text(size).leak());
        let mut values: Vec<Value<'_>> = Vec::with_capacity(size * self.columns().len());
        piece.iter().for_each(|row| row.borrow().put(&mut |value| values.push(value)));
        values.resize(size * self.columns().len(), Value::Bigint(None));
        values.into_iter().fold(sqlx::query(*text), |query, value| value.bind(query))
    }

    /// Writes rows; returns the number of written rows.
    pub(crate) async fn write<B: Borrow<R> + Sync>(&self, tx: &mut Tx<'_>, rows: &[B]) -> sqlx::Result<u64> {
        let mut written = 0;
        match tx {
            Either::Sqlite(tx) => {
                for piece in rows.chunks(ROWS_A_STATEMENT) {
                    written += self.of_sqlite(piece).execute(&mut **tx).await?.rows_affected();
                }
            }
            Either::Postgres(tx) if !rows.is_empty() => {
                written = self.of_postgres(rows).execute(&mut **tx).await?.rows_affected();
            }
            Either::Postgres(_) => {}
        }
        Ok(written)
    }
}

/// A statement of any rows.
pub(crate) trait Declared: Sync {
    /// Table that the statement writes.
    fn table(&self) -> &'static str;

    /// Whether the statement inserts rows.
    fn inserts(&self) -> bool;

    /// Columns of the table that the statement writes.
    fn written(&self) -> Vec<Column>;
}

impl<R: Row> Declared for Statement<R> {
    fn table(&self) -> &'static str {
        match self.kind {
            StatementKind::Insert { table } | StatementKind::InsertBelow { table, .. } => table,
            StatementKind::Update { table, .. } | StatementKind::Custom { table, .. } => table,
        }
    }

    fn inserts(&self) -> bool {
        matches!(self.kind, StatementKind::Insert { .. } | StatementKind::InsertBelow { .. })
    }

    fn written(&self) -> Vec<Column> {
        match &self.kind {
            StatementKind::Insert { .. } | StatementKind::Update { .. } => self.columns().to_vec(),
            StatementKind::InsertBelow { parent, .. } => {
                let own = self.columns().iter().filter(|column| !parent.keys.contains(&column.name)).copied();
                [Column { name: parent.number, kind: Type::Bigint }].into_iter().chain(own).collect()
            }
            // Its columns need not be those of the table.
            StatementKind::Custom { .. } => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row::columns;

    struct Example {
        number: i64,
        name: Option<String>,
        pair: [f64; 2],
    }

    columns! {
        Example { number: i64, name: Option<String>, pair: [f64; 2] = ["first", "second"], }
    }

    static INSERT: Statement<Example> = Statement::insert("examples").unless_exists().returning("number");
    static UPDATE: Statement<Example> = Statement::update("examples", "again = TRUE");

    #[test]
    fn texts_have_the_declared_columns() {
        assert_eq!(
            INSERT.part(),
            "INSERT INTO examples (number, name, first, second) SELECT n.* FROM unnest($1::bigint[], $2::text[], \
             $3::double precision[], $4::double precision[]) AS n (number, name, first, second) WHERE OWNED \
             ON CONFLICT DO NOTHING RETURNING number"
        );
        assert_eq!(
            INSERT.sqlite_text(2),
            "WITH n (number, name, first, second) AS (VALUES (?, ?, ?, ?), (?, ?, ?, ?)) \
             INSERT INTO examples (number, name, first, second) SELECT n.* FROM n WHERE n.number IS NOT NULL \
             ON CONFLICT DO NOTHING RETURNING number"
        );
        assert_eq!(
            UPDATE.sqlite_text(1),
            "WITH n (number, name, first, second) AS (VALUES (?, ?, ?, ?)) UPDATE examples AS t SET name = n.name, \
             first = n.first, second = n.second, again = TRUE FROM n WHERE t.number = n.number AND TRUE"
        );
    }

    #[tokio::test]
    async fn any_number_of_rows_is_written_in_order() {
        use sqlx::Connection;

        for count in [0, 1, 7, 8, 9, 511, 512, 1100] {
            let mut link = sqlx::SqliteConnection::connect("sqlite::memory:").await.unwrap();
            sqlx::raw_sql("CREATE TABLE examples (number INTEGER, name TEXT, first REAL, second REAL)")
                .execute(&mut link)
                .await
                .unwrap();
            let rows: Vec<Example> =
                (0..count).map(|number| Example { number, name: None, pair: [0.5, number as f64] }).collect();
            let mut tx = Either::Sqlite(link.begin().await.unwrap());
            let written = INSERT.write(&mut tx, &rows).await.unwrap();
            assert_eq!(written, count as u64);
            tx.commit().await.unwrap();
            let stored: Vec<(i64, f64)> = sqlx::query_as("SELECT number, second FROM examples ORDER BY rowid")
                .fetch_all(&mut link)
                .await
                .unwrap();
            assert_eq!(stored, (0..count).map(|number| (number, number as f64)).collect::<Vec<_>>());
        }
    }
}
