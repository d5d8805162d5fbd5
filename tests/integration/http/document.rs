//! Checks the OpenAPI document against actual answers.

use serde_json::{Value, json};
use vibrissa_tests::web::send;

use crate::served::Served;

/// The served OpenAPI document.
pub(crate) struct Document(pub(crate) Value);

/// Paths and operations of all GET routes.
pub(crate) fn get_operations(document: &Value) -> impl Iterator<Item = (&str, &Value)> {
    let paths = document["paths"].as_object().unwrap().iter();
    paths.filter_map(|(path, item)| Some((path.as_str(), item.get("get")?)))
}

/// Whether the operation returns data about robots.
fn is_read(operation: &Value) -> bool {
    let tags =
        ["fleets", "robots", "whiskers", "happenings", "compensations", "setpoints", "touch tests", "errors", "access"];
    tags.iter().any(|tag| operation["tags"][0] == *tag)
}

impl Document {
    pub(crate) async fn of(served: &Served) -> Self {
        Self(served.json("/openapi.json").await)
    }

    /// Resolves a reference to a schema.
    fn resolved<'a>(&'a self, schema: &'a Value) -> &'a Value {
        match schema["$ref"].as_str() {
            Some(name) => self.0.pointer(name.trim_start_matches('#')).unwrap(),
            None => schema,
        }
    }

    /// Allowed values of a query parameter, if the operation has it.
    pub(crate) fn words(&self, operation: &Value, name: &str) -> Option<Vec<String>> {
        let parameter = operation["parameters"].as_array()?.iter().find(|one| one["name"] == name)?;
        let schema = &parameter["schema"];
        let schemas = schema["oneOf"].as_array().cloned().unwrap_or_else(|| vec![schema.clone()]);
        let words = schemas.iter().find_map(|schema| self.resolved(schema)["enum"].as_array().cloned())?;
        Some(words.iter().map(|word| word.as_str().unwrap().to_owned()).collect())
    }

    /// Validates an answer with the schema of its status.
    fn check(&self, path: &str, operation: &Value, status: u16, body: &Value) {
        let content = &operation["responses"][status.to_string()]["content"];
        let (_, content) = content
            .as_object()
            .unwrap_or_else(|| panic!("{path} does not document status {status}"))
            .iter()
            .next()
            .unwrap();
        let mut schema = content["schema"].clone();
        schema["components"] = self.0["components"].clone();
        let validator = jsonschema::options().should_validate_formats(true).build(&schema).unwrap();
        let problems: Vec<String> =
            validator.iter_errors(body).map(|problem| format!("{}: {problem}", problem.instance_path())).collect();
        assert!(problems.is_empty(), "{path}: {problems:?} in {body}");
    }
}

/// Lists whose rows have a path of their own, and the column that names a row.
pub(crate) const NAMED_ROWS: [(&str, &str); 7] = [
    ("compensations", "compensation_id"),
    ("setpoints", "command_id"),
    ("trims", "trim_id"),
    ("health-changes", "health_change_id"),
    ("alarms", "alarm_id"),
    ("touch-tests", "test_id"),
    ("black-boxes", "black_box_id"),
];

/// The parameters of paths with values that exist.
async fn existing(served: &Served) -> Vec<(String, String)> {
    let mut values: Vec<(String, String)> = [("fleet", "f"), ("robot", "r1"), ("array", "left"), ("whisker", "0")]
        .map(|(k, v)| (k.to_owned(), v.to_owned()))
        .to_vec();
    for (list, column) in NAMED_ROWS {
        let row = served.items(&format!("/v1/{list}?fleet=f&robot=r1")).await[0][column].clone();
        values.push((column.to_owned(), row.as_str().map_or_else(|| row.to_string(), ToOwned::to_owned)));
    }
    let body = json!({ "text": "A note" });
    let note = send(served.http, "POST", "/v1/fleets/f/robots/r1/notes", &[], Some(&body)).await.unwrap().json();
    values.push(("note_id".to_owned(), note["note_id"].to_string()));
    values
}

/// A path with names that exist, and one with names that do not.
fn paths(path: &str, existing: &[(String, String)]) -> [String; 2] {
    let filled = |value: &dyn Fn(&str, &str) -> String| {
        let fill =
            |path: String, (name, known): &(String, String)| path.replace(&format!("{{{name}}}"), &value(name, known));
        let path = existing.iter().fold(path.to_owned(), fill);
        path.clone() + required_query(&path)
    };
    let unknown = |name: &str, known: &str| match name {
        "fleet" => "nobody".to_owned(),
        "robot" | "array" => known.to_owned(),
        _ => "77".to_owned(),
    };
    [filled(&|_, known| known.to_owned()), filled(&unknown)]
}

/// Every GET answers as documented, for existing and for unknown names.
async fn answers_are_as_the_document_says(served: &Served) {
    let document = Document::of(served).await;
    let existing = existing(served).await;
    let mut routes = 0;
    for (template, operation) in get_operations(&document.0).filter(|(_, operation)| is_read(operation)) {
        routes += 1;
        let [there, nowhere] = paths(template, &existing);
        let answer = served.get(&there).await;
        assert_eq!(answer.status, 200, "{there}: {}", answer.body);
        if answer.headers["content-type"] == "application/json" {
            document.check(&there, operation, 200, &answer.json());
        } else {
            document.check(&there, operation, 200, &json!(answer.body));
        }
        if nowhere != there {
            let answer = served.get(&nowhere).await;
            assert_eq!(answer.status, 404, "{nowhere}: {}", answer.body);
            document.check(&nowhere, operation, 404, &answer.json());
        }
        if operation["parameters"].as_array().is_some_and(|all| all.iter().any(|one| one["in"] == "query")) {
            let and = if there.contains('?') { '&' } else { '?' };
            let answer = served.get(&format!("{there}{and}nonsense=1")).await;
            assert_eq!(answer.status, 422, "{there}");
            assert_eq!(answer.json()["errors"][0]["field"], "nonsense", "{there}");
            document.check(&there, operation, 422, &answer.json());
        }
    }
    assert!(routes >= 40, "{routes}");
}

#[tokio::test]
async fn answers_are_as_the_document_says_on_sqlite() {
    answers_are_as_the_document_says(&Served::sqlite().await).await;
}

#[tokio::test]
async fn answers_are_as_the_document_says_on_postgres() {
    answers_are_as_the_document_says(&Served::postgres().await).await;
}

#[tokio::test]
async fn regress_the_document_refers_to_nothing_that_it_lacks() {
    let document = Document::of(&Served::sqlite().await).await.0;
    let mut open = vec![&document];
    let mut references = 0;
    while let Some(value) = open.pop() {
        if let Some(name) = value.get("$ref").and_then(Value::as_str) {
            references += 1;
            assert!(document.pointer(name.trim_start_matches('#')).is_some(), "{name}");
        }
        match value {
            Value::Array(items) => open.extend(items),
            Value::Object(fields) => open.extend(fields.values()),
            Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_) => {}
        }
    }
    assert!(references > 100);
}

#[tokio::test]
async fn what_would_be_done_is_told_and_not_done() {
    let served = Served::sqlite().await;
    let whisker = "/v1/fleets/f/robots/r1/arrays/left/whiskers/1";
    let before = served.json(whisker).await;
    let answer = served.json(&format!("{whisker}/what-if?length_mm=64")).await;
    assert_eq!(answer["decisions"][0]["target_whisker"], 1);
    assert!(!answer["decisions"][0]["candidates"].as_array().unwrap().is_empty(), "{answer}");
    assert_eq!(served.json(whisker).await, before);
    let longer = served.get(&format!("{whisker}/what-if?length_mm=71")).await;
    assert_eq!((longer.status, &longer.json()["type"]), (409, &json!("/problems/refused")));
}

#[tokio::test]
async fn the_place_of_a_touch_lies_within_its_interval_on_the_whisker() {
    let served = Served::sqlite().await;
    let whisker = "/v1/fleets/f/robots/r1/arrays/left/whiskers/1";
    let ask = async |touch: &str| served.get(&format!("{whisker}/contact-place?{touch}")).await;
    let number = |answer: &serde_json::Value, name: &str| answer[name].as_f64().unwrap();
    let mut nearer_mm = 0.0;
    for strain in ["0.013", "0.011", "0.009"] {
        let answer = ask(&format!("strain={strain}&deflection_mm=2&pressure_mpa=0.1")).await;
        assert_eq!(answer.status, 200, "{}", answer.body);
        let answer = answer.json();
        let [mm, low, high] = ["distance_mm", "distance_low_mm", "distance_high_mm"].map(|name| number(&answer, name));
        assert!(low < mm && mm < high && high <= number(&answer, "length_mm") && mm > nearer_mm, "{answer}");
        assert!((number(&answer, "ratio") * number(&answer, "length_mm") - mm).abs() < 1e-9, "{answer}");
        nearer_mm = mm;
    }
    let negative = ask("strain=-0.01&deflection_mm=2").await;
    assert_eq!((negative.status, &negative.json()["type"]), (409, &json!("/problems/refused")));
    for (touch, field) in [("strain=2&deflection_mm=2", "strain"), ("strain=0.01&deflection_mm=0", "deflection_mm")] {
        let wrong = ask(touch).await;
        assert_eq!((wrong.status, &wrong.json()["errors"][0]["field"]), (422, &json!(field)), "{}", wrong.body);
    }
}

/// The query that a path of the API requires.
pub(crate) fn required_query(path: &str) -> &'static str {
    match path.rsplit('/').next() {
        Some("what-if") => "?length_mm=62",
        Some("contact-place") => "?strain=0.01&deflection_mm=2",
        _ => "",
    }
}
