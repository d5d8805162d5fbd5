//! Conditions that rows of a list must meet, and their SQL.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};
use sqlx::{Database, Encode, QueryBuilder, Sqlite, Type};

use vibrissa_edge::fleets::FleetPattern;
use vibrissa_edge::labels::{LabelCondition, LabelConditions};

use super::ColumnKind;

/// A value to compare a column with.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Value {
    /// An integer value.
    Whole(i64),
    /// A floating-point number.
    Real(f64),
    /// A boolean value.
    Flag(bool),
    /// A text value.
    Text(String),
}

impl Value {
    /// Whether it is a text with a NUL character, which PostgreSQL refuses.
    #[must_use]
    pub fn has_nul(&self) -> bool {
        matches!(self, Self::Text(text) if text.contains('\0'))
    }

    /// Whether the value has the type of a column.
    #[must_use]
    pub fn is_a(&self, kind: ColumnKind) -> bool {
        match (self, kind) {
            (Self::Whole(_), ColumnKind::Whole)
            | (Self::Real(_), ColumnKind::Real)
            | (Self::Text(_), ColumnKind::Text) => true,
            (Self::Whole(_) | Self::Real(_) | Self::Text(_) | Self::Flag(_), _) => false,
        }
    }
}

/// A condition that the rows of a selection must meet.
#[derive(Debug, Clone, PartialEq)]
pub enum Filter {
    /// The column equals the value.
    Is(&'static str, Value),
    /// The column equals one of the values; no row matches an empty list.
    IsOneOf(&'static str, Vec<String>),
    /// The column equals one of the numbers; no row matches an empty list.
    IsOneOfNumbers(&'static str, Vec<i64>),
    /// The column is a name that matches the pattern.
    Matches(&'static str, FleetPattern),
    /// The column is at least the value.
    AtLeast(&'static str, Value),
    /// The column is less than the value.
    Below(&'static str, Value),
    /// The column is null (true), or is not (false).
    IsNull(&'static str, bool),
    /// The robot whose number is in the column has a label that meets the condition.
    HasLabel(&'static str, LabelCondition),
    /// An alarm of this kind stands for the whisker whose number is in the column (true), or does not (false).
    HasAlarm(&'static str, &'static str, bool),
    /// At least one of the columns contains the text, in upper or lower case.
    Contains(&'static [&'static str], String),
    /// One of the conditions holds; none holds of an empty list.
    AnyOf(Vec<Filter>),
    /// The column is one of those that a query selects, of the rows of which at least one column contains the text.
    /// Faster than `Contains` where the names are in a shorter table.
    IsNamed {
        /// Column of the list.
        column: &'static str,
        /// Query of one column, without a condition.
        select: &'static str,
        /// Columns of the query's tables that are searched.
        names: &'static [&'static str],
        /// Text to look for.
        text: String,
    },
}

impl Filter {
    /// Whether all columns that the condition reads are among these.
    pub(super) fn reads_only(&self, columns: &[&str]) -> bool {
        match self {
            Self::Is(column, _)
            | Self::IsOneOf(column, _)
            | Self::IsOneOfNumbers(column, _)
            | Self::Matches(column, _)
            | Self::AtLeast(column, _)
            | Self::Below(column, _)
            | Self::IsNull(column, _)
            | Self::HasLabel(column, _)
            | Self::HasAlarm(column, ..)
            | Self::IsNamed { column, .. } => columns.contains(column),
            Self::Contains(read, _) => read.iter().all(|column| columns.contains(column)),
            Self::AnyOf(filters) => filters.iter().all(|filter| filter.reads_only(columns)),
        }
    }

    /// The condition that the column is one of the names, or matches one of the patterns. No row matches an empty list.
    pub fn fleets<'a>(column: &'static str, fleets: impl IntoIterator<Item = &'a FleetPattern>) -> Self {
        let (names, patterns): (Vec<_>, Vec<_>) = fleets.into_iter().cloned().partition(FleetPattern::is_name);
        let names = match &names[..] {
            [name] => Self::Is(column, Value::Text(name.to_string())),
            names => Self::IsOneOf(column, names.iter().map(ToString::to_string).collect()),
        };
        if patterns.is_empty() {
            return names;
        }
        Self::AnyOf(patterns.into_iter().map(|pattern| Self::Matches(column, pattern)).chain([names]).collect())
    }

    /// The conditions on the labels of the robot whose number is in a column.
    pub fn labels(column: &'static str, conditions: Option<&LabelConditions>) -> impl Iterator<Item = Self> {
        let all = conditions.into_iter().flat_map(LabelConditions::iter);
        all.map(move |condition| Self::HasLabel(column, condition.clone()))
    }
}

/// Appends a value as a parameter.
pub(super) fn push_value<DB: Database>(sql: &mut QueryBuilder<DB>, value: &Value)
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    match value {
        Value::Whole(value) => sql.push_bind(*value),
        Value::Real(value) => sql.push_bind(*value),
        Value::Flag(value) => sql.push_bind(*value),
        Value::Text(value) => sql.push_bind(value.clone()),
    };
}

/// Appends conditions to the WHERE clause of a statement.
pub(crate) fn push_filters<DB: Database>(sql: &mut QueryBuilder<DB>, filters: &[Filter])
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    for filter in filters {
        sql.push(" AND ");
        push_filter(sql, filter);
    }
}

fn push_filter<DB: Database>(sql: &mut QueryBuilder<DB>, filter: &Filter)
where
    i64: for<'q> Encode<'q, DB> + Type<DB>,
    f64: for<'q> Encode<'q, DB> + Type<DB>,
    bool: for<'q> Encode<'q, DB> + Type<DB>,
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    match filter {
        Filter::Is(column, value) => {
            sql.push(*column).push(" = ");
            push_value(sql, value);
        }
        Filter::IsOneOf(column, values) => {
            sql.push(*column).push(" IN (NULL");
            for value in values {
                sql.push(", ").push_bind(value.clone());
            }
            sql.push(")");
        }
        Filter::IsOneOfNumbers(column, values) => {
            sql.push(*column).push(" IN (NULL");
            for value in values {
                sql.push(", ").push_bind(*value);
            }
            sql.push(")");
        }
        Filter::Matches(column, pattern) => push_match(sql, column, pattern),
        Filter::AtLeast(column, value) => {
            sql.push(*column).push(" >= ");
            push_value(sql, value);
        }
        Filter::Below(column, value) => {
            sql.push(*column).push(" < ");
            push_value(sql, value);
        }
        Filter::IsNull(column, is_null) => {
            sql.push(*column).push(if *is_null { " IS NULL" } else { " IS NOT NULL" });
        }
        Filter::HasLabel(column, condition) => {
            sql.push(*column).push(" IN (SELECT robot_id FROM robots WHERE replace(").push(LABEL_LINES).push(", ");
            sql.push_bind(condition.needle()).push(", '') <> ").push(LABEL_LINES).push(")");
        }
        Filter::HasAlarm(column, kind, stands) => {
            sql.push(*column).push(if *stands { " IN (" } else { " NOT IN (" });
            sql.push("SELECT whisker_id FROM alarms WHERE whisker_id IS NOT NULL AND cleared_us IS NULL AND kind = ");
            sql.push_bind((*kind).to_owned()).push(")");
        }
        Filter::Contains(columns, text) => push_contains(sql, columns, text),
        Filter::IsNamed { column, select, names, text } => {
            sql.push(*column).push(" IN (").push(*select).push(" WHERE ");
            push_contains(sql, names, text);
            sql.push(")");
        }
        Filter::AnyOf(filters) => {
            sql.push("(false");
            for filter in filters {
                sql.push(" OR ");
                push_filter(sql, filter);
            }
            sql.push(")");
        }
    }
}

/// The labels of a robot, each between two line breaks. LIKE would not tell `Hall` from `hall` in SQLite.
const LABEL_LINES: &str = "'\n' || labels || '\n'";

/// Appends the condition that at least one column contains a text.
fn push_contains<DB: Database>(sql: &mut QueryBuilder<DB>, columns: &[&'static str], text: &str)
where
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    let is_of_ascii = text.is_ascii();
    let (operator, pattern) = match (is_of_ascii, DB::NAME == Sqlite::NAME) {
        (true, _) => (" LIKE ", pattern(text)),
        // `lower` and LIKE of SQLite change ASCII only, as does `lower` of a PostgreSQL database with the ctype C.
        (false, true) => (" GLOB ", glob(text)),
        (false, false) => (" ~ ", regular(text)),
    };
    sql.push("(false");
    for column in columns {
        sql.push(" OR lower(").push(*column).push(")").push(operator).push_bind(pattern.clone());
        if is_of_ascii {
            sql.push(" ESCAPE '!'");
        }
    }
    sql.push(")");
}

/// Appends the condition that a column matches a pattern. Patterns have no special character of GLOB but `*`. LIKE of
/// SQLite would not tell `Hall` from `hall`.
fn push_match<DB: Database>(sql: &mut QueryBuilder<DB>, column: &'static str, pattern: &FleetPattern)
where
    String: for<'q> Encode<'q, DB> + Type<DB>,
{
    sql.push(column);
    if DB::NAME == Sqlite::NAME {
        sql.push(" GLOB ").push_bind(pattern.to_string());
    } else {
        let like = pattern.as_str().replace('_', "!_").replace('*', "%");
        sql.push(" LIKE ").push_bind(like).push(" ESCAPE '!'");
    }
}

/// The pattern of LIKE for a text in lower case anywhere in a column.
fn pattern(text: &str) -> String {
    let mut pattern = String::from("%");
    for letter in text.to_lowercase().chars() {
        if matches!(letter, '%' | '_' | '!') {
            pattern.push('!');
        }
        pattern.push(letter);
    }
    pattern.push('%');
    pattern
}

/// The pattern of GLOB for a text anywhere in a column whose ASCII letters are in lower case.
fn glob(text: &str) -> String {
    let letter = |letter: char| match letter {
        '*' | '?' | '[' => format!("[{letter}]"),
        _ => in_both_cases(letter),
    };
    format!("*{}*", text.chars().map(letter).collect::<String>())
}

/// The regular expression of PostgreSQL for the same.
fn regular(text: &str) -> String {
    let letter = |letter: char| {
        if letter.is_ascii_punctuation() { format!("\\{letter}") } else { in_both_cases(letter) }
    };
    text.chars().map(letter).collect()
}

/// An ASCII letter in lower case; another one as the set of its cases.
fn in_both_cases(letter: char) -> String {
    if letter.is_ascii() {
        return letter.to_ascii_lowercase().to_string();
    }
    // A case of several letters, such as that of ß, is left out.
    let one = |mut cases: Box<dyn Iterator<Item = char>>| cases.next().filter(|_| cases.next().is_none());
    let cases = [Some(letter), one(Box::new(letter.to_lowercase())), one(Box::new(letter.to_uppercase()))];
    let set: BTreeSet<char> = cases.into_iter().flatten().collect();
    if set.len() == 1 { letter.to_string() } else { format!("[{}]", set.iter().collect::<String>()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regress_letters_beyond_ascii_are_searched_in_both_cases() {
        assert_eq!(glob("ÜBER"), "*[Üü]ber*");
        assert_eq!(glob("straße [1]*?"), "*straße [[]1][*][?]*");
        assert_eq!(regular("Öl, 5 (A)"), "[Öö]l\\, 5 \\(a\\)");
        assert_eq!(regular("検査"), "検査");
    }
}
