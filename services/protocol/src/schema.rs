//! What the checks enforce, in the words of JSON Schema: used by the derives on the messages.

use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use crate::check::{GAIN, RATIO, Range, TEXT_MAX_CHARS};
use crate::{GAIN_POINTS_MAX, HELD_MAX, INTEGER_LIMIT, SetpointOutcome};

impl Range {
    /// Adds the range to a number's schema, or to one of a number that may be null.
    pub(crate) fn in_schema(self) -> impl FnMut(&mut Schema) {
        move |schema| {
            let least = if self.is_least_excluded { "exclusiveMinimum" } else { "minimum" };
            schema.insert(least.to_owned(), plain(self.least));
            schema.insert("maximum".to_owned(), plain(self.most));
            if self.least_magnitude > 0.0 {
                let (least, most) = (plain(self.least_magnitude), plain(-self.least_magnitude));
                let any = json!([{ "const": 0 }, { "minimum": least }, { "maximum": most }]);
                schema.insert("anyOf".to_owned(), any);
            }
        }
    }
}

/// A whole number is written without decimals.
fn plain(number: f64) -> Value {
    if number.fract() == 0.0 { json!(number as i64) } else { json!(number) }
}

/// Adds the limit of [`crate::check::integer`].
pub(crate) fn exact_integer(schema: &mut Schema) {
    schema.insert("maximum".to_owned(), json!(INTEGER_LIMIT - 1));
}

/// A text of that pattern.
pub(crate) fn matching(pattern: &str) -> Schema {
    json_schema!({ "type": "string", "pattern": pattern })
}

/// A text as [`crate::check::is_identifier`] takes it.
pub(crate) fn identifier() -> Schema {
    json_schema!({
        "type": "string",
        "minLength": 1,
        "maxLength": TEXT_MAX_CHARS,
        "pattern": r"^[^\x00-\x1f\x7f-\x9f]*$",
    })
}

/// [`identifier`] for a field of another type.
pub(crate) fn identifier_field(_: &mut SchemaGenerator) -> Schema {
    identifier()
}

/// Pairs of contact ratio and factor.
pub(crate) fn gain(_: &mut SchemaGenerator) -> Schema {
    let number = |range: Range, description: &str| {
        let mut schema = json_schema!({ "type": "number", "description": description });
        range.in_schema()(&mut schema);
        schema
    };
    let points = [number(RATIO, "Contact ratio."), number(GAIN, "Factor on the strain.")];
    list_of_pairs(GAIN_POINTS_MAX, &json!({ "prefixItems": points }))
}

/// Ranges of `seq`, both ends included.
pub(crate) fn held(_: &mut SchemaGenerator) -> Schema {
    let seq = json!({ "type": "integer", "minimum": 0, "maximum": INTEGER_LIMIT - 1 });
    list_of_pairs(HELD_MAX, &json!({ "items": seq }))
}

fn list_of_pairs(most: usize, pair: &Value) -> Schema {
    let mut items = json_schema!({ "type": "array", "minItems": 2, "maxItems": 2 });
    if let Value::Object(pair) = pair {
        pair.iter().for_each(|(key, value)| drop(items.insert(key.clone(), value.clone())));
    }
    json_schema!({ "type": "array", "maxItems": most, "items": items })
}

/// Adds that those outcomes which [`SetpointOutcome::needs_error`] names must say why.
pub(crate) fn error_where_due(schema: &mut Schema) {
    let due: Vec<&str> = SetpointOutcome::ALL.iter().filter(|one| one.needs_error()).map(|one| one.as_str()).collect();
    schema.insert("if".to_owned(), json!({ "properties": { "state": { "enum": due } }, "required": ["state"] }));
    schema.insert("then".to_owned(), json!({ "properties": { "error": { "type": "string" } }, "required": ["error"] }));
}

/// Leaves out Rust's names of number types: validators that know only standard formats stumble over them.
pub(crate) fn without_number_formats(schema: &mut Schema) {
    schemars::transform::transform_subschemas(&mut without_number_formats, schema);
    if schema.get("format").is_some_and(|format| format != "date-time") {
        schema.remove("format");
    }
}
