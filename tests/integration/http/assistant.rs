//! `vibrissa mcp`: an assistant reads what the API returns, and nothing can be changed through it.

use std::collections::BTreeSet;
use std::io::Write;
use std::process::{Command, Stdio};

use serde_json::{Value, json};

use crate::served::Served;

/// The answers to lines of input.
fn said(served: &Served, lines: &[Value]) -> Vec<Value> {
    let mut program = Command::new(env!("CARGO_BIN_EXE_vibrissa-under-test"))
        .args(["mcp", "--url", &format!("http://{}", served.http)])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let text: String = lines
        .iter()
        .map(|line| format!("{}\n", line.as_str().map_or_else(|| line.to_string(), str::to_owned)))
        .collect();
    program.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
    let output = program.wait_with_output().unwrap();
    assert!(output.status.success());
    String::from_utf8(output.stdout).unwrap().lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn call(id: u64, name: &str, arguments: &Value) -> Value {
    let params = json!({ "name": name, "arguments": arguments });
    json!({ "jsonrpc": "2.0", "id": id, "method": "tools/call", "params": params })
}

fn content(answer: &Value) -> &str {
    answer["result"]["content"][0]["text"].as_str().unwrap()
}

#[tokio::test(flavor = "multi_thread")]
async fn an_assistant_reads_what_the_api_returns() {
    let served = Served::sqlite().await;
    let hello =
        json!({ "protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": { "name": "t", "version": "1" } });
    let answers = said(
        &served,
        &[
            json!({ "jsonrpc": "2.0", "id": 1, "method": "initialize", "params": hello }),
            json!({ "jsonrpc": "2.0", "method": "notifications/initialized" }),
            json!({ "jsonrpc": "2.0", "id": "two", "method": "tools/list" }),
            call(3, "list_whiskers", &json!({ "limit": 2, "fleet": "lab" })),
            call(4, "list_whiskers", &json!({ "limit": 0 })),
            call(5, "get_robot", &json!({ "fleet": "lab" })),
            call(6, "get_robot", &json!({ "fleet": "..", "robot": "x" })),
            call(7, "list_alarms", &json!({ "colour": "red" })),
            call(8, "hold_robots", &json!({})),
            json!({ "jsonrpc": "2.0", "id": 9, "method": "resources/list" }),
            json!("{"),
        ],
    );
    assert_eq!(answers.len(), 10, "a notification has no answer");
    assert_eq!(answers[0]["result"]["protocolVersion"], "2025-06-18");
    assert_eq!(answers[1]["id"], "two");
    let document: Value = served.json("/openapi.json").await;
    let reads = |item: &&Value| item["get"]["responses"]["200"]["content"].get("application/json").is_some();
    let operations = document["paths"].as_object().unwrap().values().filter(reads);
    let expected: BTreeSet<_> = operations.map(|item| item["get"]["operationId"].as_str().unwrap()).collect();
    let tools = answers[1]["result"]["tools"].as_array().unwrap();
    let named: BTreeSet<_> = tools.iter().map(|tool| tool["name"].as_str().unwrap()).collect();
    assert_eq!(named, expected);
    assert!(tools.iter().all(|tool| tool["annotations"]["readOnlyHint"] == true));
    assert!(!answers[1].to_string().contains("$ref"), "schemas are whole");
    let rows: Value = serde_json::from_str(content(&answers[2])).unwrap();
    assert_eq!(rows, served.json("/v1/whiskers?limit=2&fleet=lab").await);
    for (index, part) in [(3, "limit"), (4, "robot is missing"), (5, "is no name"), (6, "no parameter colour")] {
        assert_eq!(answers[index]["result"]["isError"], true, "{}", answers[index]);
        assert!(content(&answers[index]).contains(part), "{}", answers[index]);
    }
    let codes: Vec<_> = answers[7..].iter().map(|answer| answer["error"]["code"].as_i64().unwrap()).collect();
    assert_eq!(codes, [-32_602, -32_601, -32_700]);
}
