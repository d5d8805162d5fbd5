//! Half a minute of chaos with ten hostile robots among a hundred, and beside it the same with a cluster: real servers behave as the
//! models in simulated time do. `tests/release` has the long runs and the controls with real servers; the suite `simulated` has
//! the controls in simulated time.

use std::process::Command;

use serde_json::Value;

/// Runs the program `chaos` and returns its exit code and its result; no result if the run is not possible here.
fn chaos(arguments: &[&str]) -> (i32, Option<Value>) {
    let output = Command::new(env!("CARGO_BIN_EXE_chaos"))
        .args(["--json", "--program", env!("CARGO_BIN_EXE_vibrissa-under-test")])
        .args(arguments)
        .output()
        .expect("a program of ours");
    let (stdout, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // Visible if the test fails.
    println!("{said}{stdout}");
    let result = stdout.lines().last().and_then(|line| serde_json::from_str(line).ok());
    (output.status.code().expect("an exit code"), result)
}

fn count(result: &Value, name: &str) -> u64 {
    result[name].as_u64().unwrap_or_else(|| panic!("no {name}: {result}"))
}

/// Kafka and RMQTT take part where they are installed.
#[test]
fn a_cluster_loses_nothing() {
    // Many contacts per second: whiskers must be learned, and trims detected, between faults.
    let run = ["--cluster", "--seed", "2", "--seconds", "30", "--overlapping", "--rate", "800"];
    let engines: [&[&str]; 4] = [
        &["--broker", "rmqtt", "--kafka", "3"],
        &["--broker", "rmqtt"],
        &["--broker", "mosquitto", "--kafka", "3"],
        &["--broker", "mosquitto"],
    ];
    let done = engines.into_iter().find_map(|engines| {
        let (code, result) = chaos(&[&run[..], engines].concat());
        (code != 77).then(|| (code, result.expect("a line of JSON")))
    });
    let Some((code, result)) = done else { return };
    assert_eq!(code, 0);
    assert_eq!((count(&result, "fleets"), count(&result, "robots")), (6, 100));
    assert!(result["faults"].as_array().expect("faults").len() >= 5, "each part fails");
    assert_eq!(result["rounds_s"].as_array().expect("a round").len(), 1);
}

#[test]
fn nothing_is_lost_and_nothing_is_stale() {
    let (code, result) = chaos(&["--seed", "1", "--seconds", "45"]);
    assert_eq!(code, 0);
    let result = result.expect("a line of JSON");
    assert_eq!(result["faults"].as_array().expect("faults").len(), 8);
    assert_eq!(count(&result, "hostile_robots"), 10);
    let done = result["hostile"].as_object().expect("behaviours");
    assert!(done.len() > 10 && done.values().all(|count| count.as_u64() > Some(0)), "{done:?}");
}
