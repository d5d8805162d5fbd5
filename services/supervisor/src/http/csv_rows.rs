//! Rows of lists as CSV (RFC 4180), safe to open in a spreadsheet.

use serde::Serialize;
use serde_json::Value;
use utoipa::PartialSchema;
use utoipa::openapi::{RefOr, Schema};

/// Media type of the rows.
pub const MEDIA_TYPE: &str = "text/csv; charset=utf-8; header=present";

/// Names of the columns: those of the row in JSON, in the order of its schema.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Columns(Vec<String>);

impl Columns {
    /// The columns of a type of rows.
    #[must_use]
    pub fn of<T: PartialSchema>() -> Self {
        // A test of all lists notices a row without columns.
        let RefOr::T(Schema::Object(object)) = T::schema() else { return Self(Vec::new()) };
        Self(object.properties.keys().cloned().collect())
    }

    /// The header row.
    ///
    /// # Errors
    /// Never in practice: the text is written to memory.
    pub fn header(&self) -> csv::Result<Vec<u8>> {
        record(self.0.iter().map(String::as_str))
    }

    /// One row.
    ///
    /// # Errors
    /// The row is no JSON object.
    pub fn row(&self, row: &impl Serialize) -> anyhow::Result<Vec<u8>> {
        let Value::Object(fields) = serde_json::to_value(row)? else { anyhow::bail!("a row is not a JSON object") };
        Ok(record(self.0.iter().map(|name| cell(fields.get(name))))?)
    }
}

fn record(cells: impl IntoIterator<Item = impl AsRef<[u8]>>) -> csv::Result<Vec<u8>> {
    let mut writer = csv::WriterBuilder::new().terminator(csv::Terminator::CRLF).from_writer(Vec::new());
    writer.write_record(cells)?;
    writer.into_inner().map_err(|problem| problem.into_error().into())
}

/// A value as text: numbers as in JSON, null as an empty cell, lists and objects as JSON.
fn cell(value: Option<&Value>) -> String {
    match value {
        None | Some(Value::Null) => String::new(),
        Some(Value::String(text)) => harmless(text),
        Some(value @ (Value::Bool(_) | Value::Number(_))) => value.to_string(),
        Some(value @ (Value::Array(_) | Value::Object(_))) => harmless(&value.to_string()),
    }
}

/// A text that no spreadsheet takes for a formula: an apostrophe precedes a text that begins like one.
#[must_use]
pub fn harmless(text: &str) -> String {
    if text.starts_with(['=', '+', '-', '@', '\t', '\r', '\n']) { format!("'{text}") } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn cells_are_quoted_as_in_rfc_4180_and_never_formulas() {
        let columns = Columns(["a", "b", "c"].map(ToOwned::to_owned).to_vec());
        assert_eq!(columns.header().unwrap(), b"a,b,c\r\n");
        for (row, expected) in [
            (json!({ "b": 1.5, "a": "x", "c": null }), "x,1.5,\r\n"),
            (
                json!({ "a": "x,y", "b": "say \"a\"", "c": "two\nlines" }),
                "\"x,y\",\"say \"\"a\"\"\",\"two\nlines\"\r\n",
            ),
            (json!({ "a": "=1+1", "b": "+1", "c": "@x" }), "'=1+1,'+1,'@x\r\n"),
            (json!({ "a": "-r", "b": -0.25, "c": "\t=1" }), "'-r,-0.25,'\t=1\r\n"),
            (json!({ "a": true, "b": [1, 2], "c": { "k": "v" } }), "true,\"[1,2]\",\"{\"\"k\"\":\"\"v\"\"}\"\r\n"),
        ] {
            assert_eq!(String::from_utf8(columns.row(&row).unwrap()).unwrap(), expected);
        }
        assert!(columns.row(&7).is_err());
    }
}
