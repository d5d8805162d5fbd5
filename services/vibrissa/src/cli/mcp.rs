//! `vibrissa mcp`: the reading operations of the API as tools of the Model Context Protocol, for assistants. Each line of
//! the standard input is a message of JSON-RPC 2.0, and so is each line of the standard output.

use std::io::{BufRead, Write};

use anyhow::Context as _;
use serde_json::{Map, Value, json};
use url::form_urlencoded::Serializer;

use super::api::{Api, ConnectionArgs};

/// Revisions of the protocol whose messages these are, the newest first.
const REVISIONS: [&str; 4] = ["2025-11-25", "2025-06-18", "2025-03-26", "2024-11-05"];
/// Bytes of a message; a longer line ends the program.
const LINE_BYTES_MAX: u64 = 1024 * 1024;
/// Bytes of an answer that an assistant gets.
const ANSWER_BYTES_MAX: usize = 256 * 1024;
/// Levels of references in a schema that are followed.
const REFERENCES_MAX: usize = 8;
const INSTRUCTIONS: &str = "vibrissa supervises robots that feel with whiskers. Everything here only reads. Lengths are in \
    mm, pressures in MPa, errors are ratios, times are UTC; names ending in _low and _high are 95 % intervals. Lists come in \
    pages: repeat with next_cursor as cursor. Whiskers that wear off state contacts_left in list_whiskers; divide by the \
    contacts per day of list_history to learn when they fail. list_alarms tells what waits for people, list_compensations \
    which whisker does whose work, get_what_if what would follow a cut.";

/// Codes of errors of JSON-RPC.
#[derive(Debug, Clone, Copy)]
enum Code {
    NotJson = -32_700,
    NoRequest = -32_600,
    NoSuchMethod = -32_601,
    BadParameters = -32_602,
}

/// A reading operation of the API.
struct Tool {
    name: String,
    /// Path with parameters in braces.
    path: String,
    description: String,
    /// Parameters: name, whether it is part of the path, whether it is required, JSON Schema.
    parameters: Vec<(String, bool, bool, Value)>,
}

/// Answers until the input ends.
///
/// # Errors
/// The supervisor does not answer, or input or output failed.
pub fn run(args: &ConnectionArgs, input: &mut impl BufRead, output: &mut impl Write) -> anyhow::Result<()> {
    let api = args.open()?;
    let tools = tools(&api.one("/openapi.json")?);
    loop {
        let mut line = String::new();
        let read = std::io::Read::take(&mut *input, LINE_BYTES_MAX).read_line(&mut line);
        if read.context("reading a message")? == 0 {
            return Ok(());
        }
        anyhow::ensure!(line.ends_with('\n') || (line.len() as u64) < LINE_BYTES_MAX, "a message is longer than 1 MiB");
        if let Some(answer) = answer(&line, &tools, &api) {
            writeln!(output, "{answer}").and_then(|()| output.flush()).context("writing an answer")?;
        }
    }
}

/// The answer to a line; none to a notification or an empty line.
fn answer(line: &str, tools: &[Tool], api: &Api) -> Option<Value> {
    let line = line.trim();
    if line.is_empty() {
        return None;
    }
    let failed = |id: &Value, code: Code, message: &str| {
        Some(json!({ "jsonrpc": "2.0", "id": id, "error": { "code": code as i32, "message": message } }))
    };
    let Ok(message) = serde_json::from_str::<Value>(line) else {
        return failed(&Value::Null, Code::NotJson, "this line is not JSON");
    };
    let id = message.get("id")?;
    let Some(method) = message["method"].as_str() else {
        return failed(id, Code::NoRequest, "the request has no method");
    };
    let params = &message["params"];
    let result = match method {
        "initialize" => welcome(params),
        "ping" => json!({}),
        "tools/list" => json!({ "tools": tools.iter().map(Tool::described).collect::<Vec<_>>() }),
        "tools/call" => match tools.iter().find(|tool| params["name"] == *tool.name) {
            Some(tool) => tool.called(&params["arguments"], api),
            None => return failed(id, Code::BadParameters, "there is no such tool: see tools/list"),
        },
        _ => return failed(id, Code::NoSuchMethod, "there is no such method"),
    };
    Some(json!({ "jsonrpc": "2.0", "id": id, "result": result }))
}

/// The answer to `initialize`: the revision that the client asks for, or else the newest one here.
fn welcome(params: &Value) -> Value {
    let asked = params["protocolVersion"].as_str().unwrap_or_default();
    let revision = REVISIONS.into_iter().find(|one| *one == asked).unwrap_or(REVISIONS[0]);
    json!({
        "protocolVersion": revision,
        "capabilities": { "tools": {} },
        "serverInfo": { "name": "vibrissa", "version": env!("CARGO_PKG_VERSION") },
        "instructions": INSTRUCTIONS,
    })
}

/// A tool for each operation of the document that reads JSON.
fn tools(document: &Value) -> Vec<Tool> {
    let paths = document["paths"].as_object().into_iter().flatten();
    let reading =
        paths.filter(|(_, item)| item["get"]["responses"]["200"]["content"].get("application/json").is_some());
    reading.map(|(path, item)| Tool::of(document, path, &item["get"])).collect()
}

impl Tool {
    fn of(document: &Value, path: &str, operation: &Value) -> Self {
        let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
        let parameters = operation["parameters"].as_array().into_iter().flatten();
        // Headers are for caches, and an assistant reads JSON.
        let parameters = parameters.filter(|one| one["in"] != "header" && one["name"] != "format").map(|one| {
            let mut schema = inlined(document, &one["schema"], 0);
            if let (Some(fields), Some(description)) = (schema.as_object_mut(), one.get("description")) {
                fields.insert("description".to_owned(), description.clone());
            }
            (text(&one["name"]), one["in"] == "path", one["required"] == true, schema)
        });
        Tool {
            name: text(&operation["operationId"]),
            path: path.to_owned(),
            description: [text(&operation["summary"]), text(&operation["description"])].join(" ").trim().to_owned(),
            parameters: parameters.collect(),
        }
    }

    fn described(&self) -> Value {
        let properties: Map<_, _> =
            self.parameters.iter().map(|(name, _, _, schema)| (name.clone(), schema.clone())).collect();
        let required: Vec<_> = self.parameters.iter().filter(|one| one.2).map(|one| &one.0).collect();
        json!({
            "name": self.name,
            "description": self.description,
            "inputSchema": { "type": "object", "properties": properties, "required": required, "additionalProperties": false },
            "annotations": { "readOnlyHint": true, "openWorldHint": false },
        })
    }

    /// Result of the tool. A refusal is a result, too: the assistant reads the reason and corrects its request.
    fn called(&self, arguments: &Value, api: &Api) -> Value {
        let answer = self.request(arguments).and_then(|path| api.one(&path).map_err(|problem| format!("{problem:#}")));
        let (text, is_error) = match answer.map(|answer| answer.to_string()) {
            Ok(text) if text.len() > ANSWER_BYTES_MAX => {
                (format!("the answer has {} bytes: ask for less by filters or a smaller limit", text.len()), true)
            }
            Ok(text) => (text, false),
            Err(problem) => (problem, true),
        };
        json!({ "content": [{ "type": "text", "text": text }], "isError": is_error })
    }

    /// Path and query of the request with these arguments.
    fn request(&self, arguments: &Value) -> Result<String, String> {
        let none = Map::new();
        let given = arguments.as_object().unwrap_or(&none);
        if let Some(unknown) = given.keys().find(|name| self.parameters.iter().all(|one| one.0 != **name)) {
            return Err(format!("{} has no parameter {unknown}", self.name));
        }
        let mut path = self.path.clone();
        let mut query = Serializer::new(String::new());
        for (name, is_in_path, is_required, _) in &self.parameters {
            let value = match given.get(name) {
                Some(Value::String(text)) => text.clone(),
                Some(Value::Null) | None if *is_required => return Err(format!("the parameter {name} is missing")),
                Some(Value::Null) | None => continue,
                Some(other) => other.to_string(),
            };
            if *is_in_path {
                path = path.replace(&format!("{{{name}}}"), &segment(&value)?);
            } else {
                query.append_pair(name, &value);
            }
        }
        let query = query.finish();
        Ok(if query.is_empty() { path } else { format!("{path}?{query}") })
    }
}

/// A value as one segment of a path. Dots alone would name another path.
fn segment(value: &str) -> Result<String, String> {
    if value.is_empty() || value.bytes().all(|byte| byte == b'.') {
        return Err(format!("{value:?} is no name"));
    }
    Ok(Serializer::new(String::new()).append_key_only(value).finish().replace('+', "%20"))
}

/// A schema with the schemas that it refers to.
fn inlined(document: &Value, schema: &Value, depth: usize) -> Value {
    match schema {
        Value::Object(fields) => {
            let target =
                fields.get("$ref").and_then(Value::as_str).and_then(|at| document.pointer(at.trim_start_matches('#')));
            match target {
                Some(target) if depth < REFERENCES_MAX => inlined(document, target, depth + 1),
                Some(_) => json!({}),
                None => fields.iter().map(|(name, part)| (name.clone(), inlined(document, part, depth))).collect(),
            }
        }
        Value::Array(parts) => parts.iter().map(|part| inlined(document, part, depth)).collect(),
        other @ (Value::Null | Value::Bool(_) | Value::Number(_) | Value::String(_)) => other.clone(),
    }
}
