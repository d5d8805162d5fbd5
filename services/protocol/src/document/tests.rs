use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use jsonschema::{Draft, Validator};
use proptest::prelude::*;
use proptest::sample::{Index, select};
use serde_json::{Value, json};

use super::*;
use crate::{INTEGER_LIMIT, Message, Refusal, Topic, decode};

/// The AsyncAPI document, parsed.
static DOCUMENT: LazyLock<Value> = LazyLock::new(|| serde_saphyr::from_str(&asyncapi()).unwrap());

/// Validators of each channel: from its own schema, and from its component of the AsyncAPI document.
static VALIDATORS: LazyLock<Vec<[Validator; 2]>> = LazyLock::new(|| {
    let both = |channel: &Channel| {
        let own = serde_json::to_value(json_schema(*channel)).unwrap();
        let payload = &DOCUMENT["components"]["messages"][channel.name()]["payload"];
        let component = json!({ "allOf": [payload], "components": DOCUMENT["components"] });
        [(Draft::Draft202012, own), (Draft::Draft7, component)]
            .map(|(draft, schema)| jsonschema::options().with_draft(draft).build(&schema).unwrap())
    };
    Channel::ALL.iter().map(both).collect()
});

fn decoded(channel: Channel, message: &Value) -> Result<Message, Refusal> {
    let topic = channel.address().replace("{fleet}", "f").replace("{robot}", "r");
    decode(&Topic::parse(&topic).unwrap(), message.to_string().as_bytes())
}

#[test]
fn the_files_in_docs_are_what_the_program_writes() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    const MEND: &str = "write it with: VIBRISSA_WRITE_DOCS=1 cargo test --workspace --lib the_files_in_docs";
    let written = files();
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        for file in &written {
            fs::write(docs.join(&file.path), &file.text).unwrap();
        }
    }
    for file in &written {
        let there = fs::read_to_string(docs.join(&file.path)).unwrap_or_default();
        assert!(there == file.text, "docs/{} differs from the code; {MEND}", file.path);
    }
    for entry in fs::read_dir(docs.join("schemas")).unwrap() {
        let path = format!("schemas/{}", entry.unwrap().file_name().into_string().unwrap());
        assert!(written.iter().any(|file| file.path == path), "docs/{path} belongs to no message any more");
    }
}

#[test]
fn every_example_is_what_its_schemas_and_the_decoder_accept() {
    for (channel, validators) in Channel::ALL.iter().zip(VALIDATORS.iter()) {
        let examples = DOCUMENT["components"]["messages"][channel.name()]["examples"].as_array().unwrap();
        assert_eq!(examples.len(), channel.examples().len());
        for example in examples {
            let payload = &example["payload"];
            for validator in validators {
                validator.validate(payload).unwrap_or_else(|problem| panic!("{}: {problem}", channel.name()));
            }
            decoded(*channel, payload).unwrap();
        }
    }
}

/// All `$ref` values below a value.
fn references(value: &Value) -> Vec<&str> {
    match value {
        Value::Array(items) => items.iter().flat_map(references).collect(),
        Value::Object(fields) => {
            let own = fields.get("$ref").and_then(Value::as_str);
            own.into_iter().chain(fields.values().flat_map(references)).collect()
        }
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => Vec::new(),
    }
}

#[test]
fn every_reference_of_the_asyncapi_document_leads_somewhere() {
    let references = references(&DOCUMENT);
    assert!(references.len() > 50, "{} references", references.len());
    for reference in references {
        let pointer = reference.strip_prefix('#').unwrap();
        assert!(DOCUMENT.pointer(pointer).is_some(), "{reference} leads nowhere");
    }
}

#[test]
fn every_topic_is_a_channel_with_its_message_its_parameters_and_one_operation() {
    let channels = DOCUMENT["channels"].as_object().unwrap();
    assert_eq!(channels.len(), Channel::ALL.len());
    for channel in Channel::ALL {
        let entry = &channels[channel.name()];
        assert_eq!(entry["address"], channel.address());
        assert_eq!(entry["messages"].as_object().unwrap().len(), 1);
        let parameters = entry["parameters"].as_object().unwrap();
        assert_eq!(parameters.len(), channel.address().matches('{').count());
        assert!(parameters.keys().all(|name| channel.address().contains(&format!("{{{name}}}"))));

        let place = json!({ "$ref": format!("#/channels/{}", channel.name()) });
        let operations: Vec<&Value> =
            DOCUMENT["operations"].as_object().unwrap().values().filter(|one| one["channel"] == place).collect();
        assert_eq!(operations.len(), 1, "{}", channel.name());
        assert_eq!(operations[0]["action"], if channel.is_from_robot() { "send" } else { "receive" });
        let mqtt = &operations[0]["bindings"]["mqtt"];
        assert_eq!((&mqtt["qos"], &mqtt["retain"]), (&json!(channel.qos()), &json!(channel.is_retained())));
    }
    assert!(!DOCUMENT["operations"]["receive_setpoint"]["bindings"]["mqtt"]["messageExpiryInterval"].is_null());
}

/// One change to one place of a message.
#[derive(Debug, Clone)]
enum Change {
    Set(Value),
    Remove,
    AddUnknown,
    /// An object becomes the list of its values, a text an object with it as its key, and another value a list with it.
    Reshape,
    /// A list gets this many copies of its first entry; another value is set to zero.
    Repeat(usize),
}

fn change() -> impl Strategy<Value = Change> {
    let near = [0.0, 1.0, 10.0, -1.0, 64.0, -100.0, 300.0, 1000.0, 65_535.0, 1e5, -1e5];
    let near = near.into_iter().flat_map(|limit| [limit, limit - 1e-4, limit + 1e-4, limit + 1.0]);
    // A whole number may be written with decimals or without.
    let numbers = near.flat_map(|number| [json!(number), json!(number as i64)]);
    let far = [json!(INTEGER_LIMIT - 1), json!(INTEGER_LIMIT), json!(u64::MAX), json!(1e3), json!(-0.0), json!(1e300)];
    let far = far.into_iter().chain([json!(9_007_199_254_740_991.0), json!(9_007_199_254_740_992.0)]);
    let numbers: Vec<Value> = numbers.chain(far).collect();
    let texts = ["", "a", "a b", "ä", "\u{1}", "\u{85}", "ONLINE", "FAILED", "LEAK", "OK", "1970-01-01t00:00:00z"];
    let stamps =
        ["2026-13-01T00:00:00Z", "1969-12-31T23:59:59Z", "2026-01-01T24:00:00Z", "2026-01-01T23:59:60.25+00:00"];
    let texts = texts.into_iter().chain(stamps).map(str::to_owned);
    let texts: Vec<Value> = texts
        .chain([63, 64, 65].map(|count| "é".repeat(count)))
        .chain(["x".repeat(64), "x".repeat(65)])
        .map(Value::from)
        .collect();
    prop_oneof![
        4 => select(numbers).prop_map(Change::Set),
        4 => select(texts).prop_map(Change::Set),
        1 => select(vec![json!(null), json!(true), json!([]), json!({})]).prop_map(Change::Set),
        1 => Just(Change::Remove),
        1 => Just(Change::AddUnknown),
        1 => Just(Change::Reshape),
        1 => select(vec![0, 1, 2, 3, 64, 65, 1000, 1001]).prop_map(Change::Repeat),
    ]
}

/// The JSON pointers of all values in a message.
fn places(value: &Value, at: &str, found: &mut Vec<String>) {
    found.push(at.to_owned());
    match value {
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(index, item)| places(item, &format!("{at}/{index}"), found));
        }
        Value::Object(fields) => fields.iter().for_each(|(key, item)| places(item, &format!("{at}/{key}"), found)),
        Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
    }
}

fn apply(message: &mut Value, place: &str, change: &Change) {
    if let (Change::Remove, Some((parent, key))) = (change, place.rsplit_once('/')) {
        if let Some(Value::Object(fields)) = message.pointer_mut(parent) {
            fields.remove(key);
        }
        return;
    }
    let Some(value) = message.pointer_mut(place) else { return };
    match change {
        Change::Set(new) => *value = new.clone(),
        Change::AddUnknown => {
            if let Value::Object(fields) = value {
                fields.insert("colour".to_owned(), json!({ "a": [1] }));
            }
        }
        Change::Reshape => {
            *value = match value.take() {
                Value::Object(fields) => fields.into_iter().map(|(_, value)| value).collect(),
                Value::String(text) => json!({ text: null }),
                other @ (Value::Null | Value::Bool(_) | Value::Number(_) | Value::Array(_)) => json!([other]),
            }
        }
        Change::Repeat(count) => {
            *value = match value.get(0) {
                Some(first) => Value::Array(vec![first.clone(); *count]),
                None => json!(0),
            }
        }
        Change::Remove => {}
    }
}

/// Whether [`BEYOND_SCHEMAS`] lists this refusal.
fn is_beyond_schemas(refusal: &Refusal) -> bool {
    match refusal {
        Refusal::Duplicate { .. } | Refusal::WrongNeighbour { .. } | Refusal::TooLarge { .. } => true,
        Refusal::OutOfRange { allowed, .. } => {
            let beyond = ["at most pressure_max_mpa", "[first, last] with last not below first"];
            beyond.contains(allowed) || *allowed == crate::messages::WITHIN_INTERVAL
        }
        Refusal::Malformed { problem, .. } => {
            problem == "contact ratios must rise" || problem == "distances must rise, and strains per mm must fall"
        }
        Refusal::UnknownTopic { .. }
        | Refusal::BadName { .. }
        | Refusal::NotJson { .. }
        | Refusal::NotCbor { .. }
        | Refusal::TooMany { .. } => false,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn property_schemas_and_decoder_accept_the_same(
        at in any::<Index>(),
        changes in prop::collection::vec((any::<Index>(), change()), 1..3),
    ) {
        let all: Vec<(usize, &str)> = Channel::ALL.iter().enumerate()
            .flat_map(|(index, channel)| channel.examples().iter().map(move |(_, text)| (index, *text)))
            .collect();
        let (index, text) = all[at.index(all.len())];
        let mut message: Value = serde_json::from_str(text).unwrap();
        for (at, change) in &changes {
            let mut found = Vec::new();
            places(&message, "", &mut found);
            apply(&mut message, &found[at.index(found.len())], change);
        }
        let decoded = decoded(Channel::ALL[index], &message);
        for (validator, draft) in VALIDATORS[index].iter().zip(["2020-12", "7"]) {
            match (&decoded, validator.validate(&message)) {
                (Ok(_), Ok(())) | (Err(_), Err(_)) => {}
                (Ok(_), Err(problem)) => prop_assert!(false, "draft {draft}, {message}: only the schema refuses: {problem}"),
                (Err(refusal), Ok(())) => prop_assert!(
                    is_beyond_schemas(refusal), "draft {draft}, {message}: only the decoder refuses: {refusal}"
                ),
            }
        }
    }
}
