//! Stored rows that cannot be read. A query leaves such a row out, so that it holds up no other one. The row stays in its table:
//! it is logged once, counted, and named for a while after a query has met it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use sqlx::{Column as _, ColumnIndex, Decode, FromRow, Row, Type};
use tokio::time::Instant;
use tracing::error;

/// Time for which a row is named after a query has met it.
const NAMED: Duration = Duration::from_secs(600);
/// Largest number of rows that are told apart; further ones are neither logged nor counted.
const ROWS_MAX: usize = 1000;
/// Largest number of rows that are named at once.
const NAMES_MAX: usize = 10;

/// The unreadable rows of a database that this process has met. Clones share them.
#[derive(Debug, Clone, Default)]
pub struct SetAside(Arc<Mutex<BTreeMap<String, Instant>>>);

/// A row, if it can be read.
#[derive(Debug)]
pub(crate) enum Tried<T> {
    Read(T),
    Unreadable(Unreadable),
}

/// A row that cannot be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Unreadable {
    /// The row's first column, if it is a whole number.
    pub(crate) id: Option<i64>,
    column: String,
    problem: String,
}

impl Unreadable {
    /// Any other error than an unreadable value is one of the query.
    fn of<R: Row>(row: &R, problem: sqlx::Error) -> sqlx::Result<Self>
    where
        usize: ColumnIndex<R>,
        i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    {
        let sqlx::Error::ColumnDecode { index, source } = problem else { return Err(problem) };
        let column = row.columns().first().map(|column| column.name().to_owned()).unwrap_or_default();
        let problem = format!("column {} {}", index.trim_matches('"'), defect_of(&*source));
        Ok(Self { id: row.try_get(0_usize).ok(), column, problem })
    }
}

/// Why a value cannot be read.
fn defect_of(source: &(dyn std::error::Error + 'static)) -> &'static str {
    if source.is::<std::str::Utf8Error>() {
        "is no text in UTF-8"
    } else if source.is::<serde_json::Error>() {
        "is no JSON"
    } else if source.is::<sqlx::error::UnexpectedNullError>() {
        "is empty"
    } else {
        "has a value of another type"
    }
}

impl<'r, R: Row, T: FromRow<'r, R>> FromRow<'r, R> for Tried<T>
where
    usize: ColumnIndex<R>,
    i64: for<'v> Decode<'v, R::Database> + Type<R::Database>,
{
    fn from_row(row: &'r R) -> sqlx::Result<Self> {
        Self::of(row, T::from_row(row))
    }
}

impl<T> Tried<T> {
    /// The content of a row, or why it cannot be read.
    pub(crate) fn of<R: Row>(row: &R, content: sqlx::Result<T>) -> sqlx::Result<Self>
    where
        usize: ColumnIndex<R>,
        i64: for<'r> Decode<'r, R::Database> + Type<R::Database>,
    {
        match content {
            Ok(read) => Ok(Self::Read(read)),
            Err(problem) => Unreadable::of(row, problem).map(Self::Unreadable),
        }
    }

    /// The row with another content, if it can be read.
    pub(crate) fn map<U>(self, change: impl FnOnce(T) -> U) -> Tried<U> {
        match self {
            Self::Read(read) => Tried::Read(change(read)),
            Self::Unreadable(row) => Tried::Unreadable(row),
        }
    }

    /// An unreadable row is named by this column, which is not its first one.
    pub(crate) fn named(self, column: &str, id: Option<i64>) -> Self {
        match self {
            Self::Read(read) => Self::Read(read),
            Self::Unreadable(row) => Self::Unreadable(Unreadable { id, column: column.to_owned(), ..row }),
        }
    }
}

impl SetAside {
    /// Notes a row of a table.
    pub(crate) fn add(&self, table: &str, row: &Unreadable) {
        let Unreadable { id, column, problem } = row;
        let id = id.map_or_else(|| "unknown".to_owned(), |id| id.to_string());
        self.note(format!("the row {column} = {id} of {table}: {problem}"));
    }

    /// Notes a row by its name and its problem.
    pub(crate) fn note(&self, row: String) {
        let mut rows = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(met) = rows.get_mut(&row) {
            *met = Instant::now();
        } else if rows.len() < ROWS_MAX {
            error!(
                row,
                "a stored row cannot be read and is set aside: correct it with the database's own program, or restore the \
                 back-up (docs/runbooks/VibrissaItemsSetAside.md)"
            );
            rows.insert(row, Instant::now());
        }
    }

    /// The row, if it can be read; otherwise it is noted.
    pub(crate) fn read<T>(&self, table: &str, row: Tried<T>) -> Option<T> {
        match row {
            Tried::Read(row) => Some(row),
            Tried::Unreadable(row) => {
                self.add(table, &row);
                None
            }
        }
    }

    /// The rows that can be read; the others are noted.
    pub(crate) fn readable<T>(&self, table: &str, rows: Vec<Tried<T>>) -> Vec<T> {
        rows.into_iter().filter_map(|row| self.read(table, row)).collect()
    }

    /// Number of unreadable rows so far, each counted once.
    #[must_use]
    pub fn count(&self) -> usize {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).len()
    }

    /// The rows that a query has met in the last ten minutes: some by name, and how many more.
    #[must_use]
    pub fn notices(&self) -> Vec<String> {
        let rows = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        let newly: Vec<&String> =
            rows.iter().filter(|(_, met)| now.duration_since(**met) < NAMED).map(|(row, _)| row).collect();
        let mut texts: Vec<String> =
            newly.iter().take(NAMES_MAX).map(|row| format!("{row}; it is set aside: see the log")).collect();
        if newly.len() > NAMES_MAX {
            texts.push(format!("{} further rows are set aside: see the log", newly.len() - NAMES_MAX));
        }
        texts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_counts_once_and_few_are_named() {
        let set_aside = SetAside::default();
        for id in (0..2000).chain(0..2000) {
            let problem = "column reason is no text in UTF-8".to_owned();
            set_aside.add("actions", &Unreadable { id: Some(id), column: "action_id".to_owned(), problem });
        }
        assert_eq!((set_aside.count(), set_aside.notices().len()), (ROWS_MAX, NAMES_MAX + 1));
        let first = "the row action_id = 0 of actions: column reason is no text in UTF-8; it is set aside: see the log";
        assert_eq!(set_aside.notices()[0], first);
    }
}
