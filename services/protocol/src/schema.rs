//! The ranges of the checks as JSON Schema, for the derives on the messages.

use schemars::{Schema, SchemaGenerator, json_schema};
use serde_json::{Value, json};

use crate::check::{DEFLECTION_MM, DISTANCE_MM, GAIN, RATIO, Range, STRAIN_PER_MM, TEXT_MAX_CHARS};
use crate::{GAIN_POINTS_MAX, HELD_MAX, INTEGER_LIMIT, RESPONSE_POINTS_MAX, SetpointOutcome, TEST_POINTS_MAX};

impl Range {
    /// Adds the range to the schema of a number, or of a nullable number.
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

/// Writes a whole number without decimals.
fn plain(number: f64) -> Value {
    if number.fract() == 0.0 { json!(number as i64) } else { json!(number) }
}

/// Adds the upper limit of [`crate::check::integer`].
pub(crate) fn exact_integer(schema: &mut Schema) {
    schema.insert("maximum".to_owned(), json!(INTEGER_LIMIT - 1));
}

/// Schema of a text that matches a pattern.
pub(crate) fn matching(pattern: &str) -> Schema {
    json_schema!({ "type": "string", "pattern": pattern })
}

/// Schema of a text that [`crate::check::is_identifier`] accepts.
pub(crate) fn identifier() -> Schema {
    json_schema!({
        "type": "string",
        "minLength": 1,
        "maxLength": TEXT_MAX_CHARS,
        "pattern": r"^[^\x00-\x1f\x7f-\x9f]*$",
    })
}

/// [`identifier`] for a field with another Rust type.
pub(crate) fn identifier_field(_: &mut SchemaGenerator) -> Schema {
    identifier()
}

/// [`identifier`], or nothing.
pub(crate) fn optional_identifier(_: &mut SchemaGenerator) -> Schema {
    let mut schema = identifier();
    schema.insert("type".to_owned(), json!(["string", "null"]));
    schema
}

/// Schema of the pairs of contact ratio and factor.
pub(crate) fn gain(_: &mut SchemaGenerator) -> Schema {
    let points = [number(RATIO, "Contact ratio."), number(GAIN, "Factor on the strain.")];
    list_of_pairs(GAIN_POINTS_MAX, &json!({ "prefixItems": points }))
}

/// Schema of the points of a response.
pub(crate) fn response(_: &mut SchemaGenerator) -> Schema {
    let points = [
        number(DISTANCE_MM, "Distance from the base, mm."),
        number(STRAIN_PER_MM, "Strain per mm of deflection."),
        number(STRAIN_PER_MM, "Its standard deviation."),
    ];
    list_of_lists(RESPONSE_POINTS_MAX, points.len(), &json!({ "prefixItems": points }))
}

fn number(range: Range, description: &str) -> Schema {
    let mut schema = json_schema!({ "type": "number", "description": description });
    range.in_schema()(&mut schema);
    schema
}

/// Schema of ranges of `seq`, both ends inclusive.
pub(crate) fn held(_: &mut SchemaGenerator) -> Schema {
    let seq = json!({ "type": "integer", "minimum": 0, "maximum": INTEGER_LIMIT - 1 });
    list_of_pairs(HELD_MAX, &json!({ "items": seq }))
}

fn list_of_pairs(most: usize, pair: &Value) -> Schema {
    list_of_lists(most, 2, pair)
}

fn list_of_lists(most: usize, length: usize, list: &Value) -> Schema {
    let mut items = json_schema!({ "type": "array", "minItems": length, "maxItems": length });
    if let Value::Object(list) = list {
        list.iter().for_each(|(key, value)| drop(items.insert(key.clone(), value.clone())));
    }
    json_schema!({ "type": "array", "maxItems": most, "items": items })
}

/// Adds that outcomes for which [`SetpointOutcome::needs_error`] is true require `error`.
pub(crate) fn error_where_due(schema: &mut Schema) {
    let due: Vec<&str> = SetpointOutcome::ALL.iter().filter(|one| one.needs_error()).map(|one| one.as_str()).collect();
    schema.insert("if".to_owned(), json!({ "properties": { "state": { "enum": due } }, "required": ["state"] }));
    schema.insert("then".to_owned(), json!({ "properties": { "error": { "type": "string" } }, "required": ["error"] }));
}

/// Schema of a touch test's distances.
pub(crate) fn test_distances(_: &mut SchemaGenerator) -> Schema {
    list_of_numbers(TEST_POINTS_MAX, DISTANCE_MM)
}

/// Schema of a touch test's deflections.
pub(crate) fn test_deflections(_: &mut SchemaGenerator) -> Schema {
    list_of_numbers(TEST_POINTS_MAX, DEFLECTION_MM)
}

fn list_of_numbers(most: usize, range: Range) -> Schema {
    let mut number = json_schema!({ "type": "number" });
    range.in_schema()(&mut number);
    json_schema!({ "type": "array", "maxItems": most, "items": number })
}

/// Adds that a test of kind WALL has distances and deflections.
pub(crate) fn points_of_wall(schema: &mut Schema) {
    let wall = json!({ "properties": { "kind": { "const": "WALL" } }, "required": ["kind"] });
    let points = json!({ "properties": { "distances_mm": { "minItems": 1 }, "deflections_mm": { "minItems": 1 } } });
    schema.insert("if".to_owned(), wall);
    schema.insert("then".to_owned(), points);
}

/// Adds that a request of a touch test has one, and that others have none.
pub(crate) fn touch_test_where_due(schema: &mut Schema) {
    let of_test = json!({ "properties": { "request": { "const": "TOUCH_TEST" } }, "required": ["request"] });
    let has_test = json!({ "properties": { "touch_test": { "type": "object" } }, "required": ["touch_test"] });
    schema.insert("if".to_owned(), of_test);
    schema.insert("then".to_owned(), has_test);
    schema.insert("else".to_owned(), json!({ "properties": { "touch_test": { "type": "null" } } }));
}

/// Adds that a rejected touch test requires `error`.
pub(crate) fn error_of_rejected(schema: &mut Schema) {
    let rejected = json!({ "properties": { "state": { "const": "REJECTED" } }, "required": ["state"] });
    schema.insert("if".to_owned(), rejected);
    schema.insert("then".to_owned(), json!({ "properties": { "error": { "type": "string" } }, "required": ["error"] }));
}

/// Adds that a contact with a ratio has no other place, and that a standard deviation belongs to a number.
pub(crate) fn one_place(schema: &mut Schema) {
    let number = |field: &str| json!({ "properties": { field: { "type": "number" } }, "required": [field] });
    let only_with = |sd: &str, field: &str| json!({ "if": number(sd), "then": number(field) });
    let other = json!({ "properties": { "distance_mm": { "type": "null" }, "tip": { "const": false } } });
    let rules = [
        json!({ "if": number("ratio"), "then": other }),
        only_with("ratio_sd", "ratio"),
        only_with("distance_sd_mm", "distance_mm"),
    ];
    schema.insert("allOf".to_owned(), json!(rules));
}

/// Removes Rust's number formats: validators that know only standard formats reject them.
pub(crate) fn without_number_formats(schema: &mut Schema) {
    schemars::transform::transform_subschemas(&mut without_number_formats, schema);
    if schema.get("format").is_some_and(|format| format != "date-time") {
        schema.remove("format");
    }
}
