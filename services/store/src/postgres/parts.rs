//! Combines statements into one, as its parts.

use std::borrow::Borrow;

use super::Query;
use crate::row::{Row, Statement};

/// Advances the commit counter of the lease and renews it; also used as a statement on its own.
pub(in super::super) const COUNTED: &str = "UPDATE leases SET commits = $4 + 1, expires_us = clock_us() + $5 \
    WHERE fleet = $1 AND epoch = $2 AND owner = $3 AND commits = $4 AND numbers >= $6 RETURNING fleet";

/// Takes the parts of a statement in their order. One pass over the parts makes the text, another binds the values.
pub(super) trait Parts: Sized {
    /// A part that writes rows.
    fn rows<R: Row, B: Borrow<R>>(self, name: &str, statement: &Statement<R>, rows: &[B]) -> Self;
}

/// Binds the values of the parts, in their order.
impl Parts for Query {
    fn rows<R: Row, B: Borrow<R>>(self, _name: &str, statement: &Statement<R>, rows: &[B]) -> Self {
        statement.bind(self, rows)
    }
}

/// Text of the statement. The first part advances the commit counter; all others write nothing if it did not.
pub(super) struct Text {
    parts: Vec<String>,
    /// Number of parameters of all parts.
    parameters: usize,
}

impl Text {
    /// The text with the first part only.
    pub(super) fn new() -> Self {
        Self { parts: Vec::new(), parameters: 0 }.with("counted", COUNTED)
    }

    /// Appends a part, and renumbers its parameters.
    fn with(mut self, name: &str, sql: &str) -> Self {
        let mut pieces = sql.split('$');
        let mut text = pieces.next().unwrap_or_default().to_owned();
        let before = self.parameters;
        for piece in pieces {
            let digits = piece.find(|c: char| !c.is_ascii_digit()).unwrap_or(piece.len());
            let number = before + piece[..digits].parse::<usize>().unwrap_or_default();
            self.parameters = self.parameters.max(number);
            text += &format!("${number}{}", &piece[digits..]);
        }
        self.parts.push(format!("{name} AS ({})", text.replace("OWNED", "EXISTS (SELECT FROM counted)")));
        self
    }

    /// The whole text; the statement returns the number of rows that each of the parts `counts` returned.
    pub(super) fn counting(self, counts: &[&str]) -> String {
        let counts: Vec<String> = counts.iter().map(|name| format!("(SELECT count(*) FROM {name})")).collect();
        format!("WITH {} SELECT {}", self.parts.join(", "), counts.join(", "))
    }
}

impl Parts for Text {
    fn rows<R: Row, B: Borrow<R>>(self, name: &str, statement: &Statement<R>, _rows: &[B]) -> Self {
        self.with(name, &statement.part())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_statement_have_parameters_of_their_own() {
        let first = Text { parts: Vec::new(), parameters: 0 };
        let text = first
            .with("counted", "UPDATE a SET b = $2 WHERE c = $1 RETURNING c")
            .with("next", "DELETE FROM d WHERE e = $1 AND OWNED")
            .counting(&["counted", "next"]);
        assert_eq!(
            text,
            "WITH counted AS (UPDATE a SET b = $2 WHERE c = $1 RETURNING c), \
             next AS (DELETE FROM d WHERE e = $3 AND EXISTS (SELECT FROM counted)) \
             SELECT (SELECT count(*) FROM counted), (SELECT count(*) FROM next)"
        );
    }
}
