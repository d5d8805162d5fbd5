//! The values that a schema allows, as a tree for fast random draws.

use serde_json::Value;

/// Largest number of characters in a text whose schema gives no limit.
const TEXT_CHARS: usize = 64;

/// The values allowed at one place of a message.
#[derive(Debug, Clone)]
pub enum Shape {
    /// Exactly this JSON.
    Constant(String),
    /// Any of these shapes.
    Choice(Vec<Shape>),
    /// An integer between these bounds, both included.
    Integer(u64, u64),
    /// A number within this range.
    Number(Range),
    /// A text of this kind.
    Text(Text),
    /// A list of up to `most` entries.
    List {
        /// The shape of each entry.
        item: Box<Shape>,
        /// Largest number of entries.
        most: usize,
    },
    /// An object with its fields in the order of the contract.
    Object(Vec<Field>),
}

/// The range of a number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    /// The least value.
    pub least: f64,
    /// The greatest value.
    pub most: f64,
}

/// The kind of a text, derived from its schema's pattern and format.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Text {
    /// A name: letters, digits, `_` and `-`.
    Name,
    /// A time in RFC 3339.
    Timestamp,
    /// Any text up to this number of characters.
    Free(usize),
}

/// A field of an object.
#[derive(Debug, Clone)]
pub struct Field {
    /// The field's name.
    pub name: String,
    /// The field's values.
    pub shape: Shape,
    /// Whether the contract requires the field.
    pub is_required: bool,
}

impl Range {
    /// The range of a schema, without excluded bounds.
    fn of(schema: &Value) -> Self {
        let number = |key: &str| schema[key].as_f64();
        let least = number("exclusiveMinimum").map(f64::next_up).or_else(|| number("minimum"));
        let most = number("exclusiveMaximum").map(f64::next_down).or_else(|| number("maximum"));
        Self { least: least.unwrap_or(f64::MIN), most: most.unwrap_or(f64::MAX) }
    }
}

impl Shape {
    /// Converts a whole schema of the contract.
    ///
    /// # Panics
    /// The schema uses a keyword that this reader does not know.
    #[must_use]
    pub fn of_schema(schema: &Value) -> Self {
        Self::new(schema, schema)
    }

    fn new(schema: &Value, root: &Value) -> Self {
        if let Some(reference) = schema["$ref"].as_str() {
            let found = root.pointer(reference.trim_start_matches('#'));
            return Self::new(found.unwrap_or_else(|| panic!("the schema has no {reference}")), root);
        }
        if let Some(constant) = schema.get("const") {
            return Self::Constant(constant.to_string());
        }
        if let Some(words) = schema["enum"].as_array() {
            return Self::Choice(words.iter().map(|word| Self::Constant(word.to_string())).collect());
        }
        let list = |key: &str| schema[key].as_array();
        // Rules about several fields say nothing about the shape of each.
        let all_of = list("allOf").filter(|parts| parts.iter().all(|part| part.get("if").is_none()));
        if let Some(one_of) = list("anyOf").or_else(|| list("oneOf")).or(all_of) {
            // The limits of a number stand beside its type, so both parts are merged.
            let merged = |part: &Value| {
                let mut whole = schema.clone();
                let fields = whole.as_object_mut().expect("a schema is an object");
                ["anyOf", "oneOf", "allOf"].iter().for_each(|key| drop(fields.remove(*key)));
                fields.extend(part.as_object().cloned().unwrap_or_default());
                whole
            };
            return Self::Choice(one_of.iter().map(|part| Self::new(&merged(part), root)).collect());
        }
        match &schema["type"] {
            Value::String(kind) => Self::of_type(kind, schema, root),
            Value::Array(kinds) => {
                let kinds = kinds.iter().filter_map(Value::as_str);
                Self::Choice(kinds.map(|kind| Self::of_type(kind, schema, root)).collect())
            }
            other => panic!("a schema of type {other}: {schema}"),
        }
    }

    fn of_type(kind: &str, schema: &Value, root: &Value) -> Self {
        let count = |key: &str| schema[key].as_u64().and_then(|count| usize::try_from(count).ok());
        match kind {
            "null" => Self::Constant("null".to_owned()),
            "boolean" => Self::Choice(["true", "false"].map(|word| Self::Constant(word.to_owned())).into()),
            "integer" => {
                let limit = |key: &str, otherwise: u64| schema[key].as_u64().unwrap_or(otherwise);
                Self::Integer(limit("minimum", 0), limit("maximum", u64::MAX))
            }
            "number" => Self::Number(Range::of(schema)),
            "string" => Self::Text(match schema["pattern"].as_str() {
                Some(pattern) if pattern.contains("[A-Za-z0-9_-]") => Text::Name,
                Some(pattern) if pattern.contains("[Tt]") => Text::Timestamp,
                Some(_) | None => Text::Free(count("maxLength").unwrap_or(TEXT_CHARS)),
            }),
            "array" => Self::List {
                item: Box::new(Self::new(&schema["items"], root)),
                most: count("maxItems").unwrap_or(usize::MAX),
            },
            "object" => Self::Object(Self::fields(schema, root)),
            other => panic!("a schema of type {other}: {schema}"),
        }
    }

    /// Fields in the order of the contract, required fields first.
    fn fields(schema: &Value, root: &Value) -> Vec<Field> {
        let required: Vec<&str> =
            schema["required"].as_array().into_iter().flatten().filter_map(Value::as_str).collect();
        let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
        let optional = properties.keys().map(String::as_str).filter(|name| !required.contains(name));
        let field = |(name, is_required): (&str, bool)| Field {
            name: name.to_owned(),
            shape: Self::new(&properties[name], root),
            is_required,
        };
        let all = required.iter().map(|&name| (name, true)).chain(optional.map(|name| (name, false)));
        all.map(field).collect()
    }

    /// The shape at a path of field names; lists on the way are skipped.
    #[must_use]
    pub fn at(&self, path: &[&str]) -> Option<&Self> {
        match self {
            Self::List { item, .. } => item.at(path),
            Self::Object(fields) => match path {
                [] => Some(self),
                [name, rest @ ..] => fields.iter().find(|field| field.name == *name)?.shape.at(rest),
            },
            Self::Constant(_) | Self::Choice(_) | Self::Integer(..) | Self::Number(_) | Self::Text(_) => {
                path.is_empty().then_some(self)
            }
        }
    }

    /// Every number range of this shape, including those inside a choice.
    #[must_use]
    pub fn ranges(&self) -> Vec<Range> {
        match self {
            Self::Number(range) => vec![*range],
            Self::Choice(choices) => choices.iter().flat_map(Self::ranges).collect(),
            Self::Constant(_) | Self::Integer(..) | Self::Text(_) | Self::List { .. } | Self::Object(_) => Vec::new(),
        }
    }
}
