//! A minute of chaos with ten hostile robots among a hundred; then the controls: defects that the harness must detect. Beside it
//! the same with a cluster. The runs of each test follow one another, because a run needs a core.

use std::process::Command;

use serde_json::Value;

/// Runs the program `chaos` and returns its exit code and its result.
fn chaos(arguments: &[&str]) -> (i32, Value) {
    let output = Command::new(env!("CARGO_BIN_EXE_chaos"))
        .args(["--json", "--program", env!("CARGO_BIN_EXE_vibrissa-under-test")])
        .args(arguments)
        .output()
        .expect("a program of ours");
    let (stdout, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // Visible if the test fails.
    println!("{said}{stdout}");
    let result = stdout.lines().last().and_then(|line| serde_json::from_str(line).ok());
    (output.status.code().expect("an exit code"), result.expect("a line of JSON"))
}

/// Runs with a planted defect until the harness detects it as expected. The faults of one run may spare the defect by chance:
/// contacts are lost only if some were receipted in the moment of the fault.
fn is_caught(name: &str, run: impl Fn(&str) -> (i32, Value), as_expected: impl Fn(&Value) -> bool) {
    let caught = ["1", "2", "3", "4"].into_iter().any(|seed| {
        let (code, result) = run(seed);
        code == 1 && as_expected(&result)
    });
    assert!(caught, "{name} is not detected in four runs");
}

fn count(result: &Value, name: &str) -> u64 {
    result[name].as_u64().unwrap_or_else(|| panic!("no {name}: {result}"))
}

/// Runs the program `chaos` with a cluster. Without RMQTT, one Mosquitto takes its place. `None`, with a line that says so, if
/// the cluster cannot run here.
fn cluster(arguments: &[&str]) -> Option<(i32, Value)> {
    let program = ["--cluster", "--json", "--program", env!("CARGO_BIN_EXE_vibrissa-under-test")];
    let run = |broker: &str| {
        Command::new(env!("CARGO_BIN_EXE_chaos")).args(program).args(["--broker", broker]).args(arguments).output()
    };
    let mut output = run("rmqtt").expect("a program of ours");
    if output.status.code() == Some(77) {
        println!("{}", String::from_utf8_lossy(&output.stderr));
        output = run("mosquitto").expect("a program of ours");
    }
    let (stdout, said) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    // Visible if the test fails.
    println!("{said}{stdout}");
    let code = output.status.code().expect("an exit code");
    if code == 77 {
        return None;
    }
    let result = stdout.lines().last().and_then(|line| serde_json::from_str(line).ok());
    Some((code, result.expect("a line of JSON")))
}

/// Takeover times are in the result; no assertion depends on them.
#[test]
fn a_cluster_loses_nothing_and_its_controls_are_caught() {
    let Some((code, result)) = cluster(&["--seed", "1", "--seconds", "60"]) else { return };
    assert_eq!(code, 0);
    assert_eq!((count(&result, "fleets"), count(&result, "robots")), (6, 100));
    assert!(!result["faults"].as_array().expect("faults").is_empty());
    // More contacts per second: whiskers must be learned, and trims detected, between faults.
    let overlapping = ["--seed", "2", "--seconds", "30", "--overlapping", "--rate", "800"];
    let through_kafka = cluster(&[&overlapping[..], &["--kafka", "3"]].concat());
    let (code, result) = through_kafka.unwrap_or_else(|| cluster(&overlapping).expect("it ran before"));
    assert_eq!(code, 0);
    assert!(result["faults"].as_array().expect("faults").len() >= 5, "each part fails");
    assert_eq!(result["rounds_s"].as_array().expect("a round").len(), 1);
    let control = |name: &str, arguments: &[&str], expected: &str| {
        let run =
            |seed: &str| cluster(&[&["--seed", seed, "--control", name], arguments].concat()).expect("it ran before");
        is_caught(name, run, |result| count(result, expected) > 0);
    };
    control("asynchronous", &["--seconds", "40"], "missing");
    control("no-fence", &["--seconds", "30"], "duplicate");
    // The suite `kafka` plants the fault of positions that are written before their state.
}

#[test]
fn nothing_is_lost_nothing_is_stale_and_every_control_is_caught() {
    let (code, result) = chaos(&["--seed", "1", "--seconds", "67"]);
    assert_eq!(code, 0);
    assert_eq!(result["faults"].as_array().expect("faults").len(), 13);
    assert_eq!(count(&result, "hostile_robots"), 10);
    let done = result["hostile"].as_object().expect("behaviours");
    assert!(done.len() > 10 && done.values().all(|count| count.as_u64() > Some(0)), "{done:?}");

    let control = |name: &str, seconds: &str, expected: &[&str]| {
        // No hostile robots: the harness must catch each control alone.
        let run = |seed: &str| chaos(&["--seed", seed, "--seconds", seconds, "--control", name, "--hostile", "0"]);
        is_caught(name, run, |result| expected.iter().all(|one| count(result, one) > 0));
    };
    // The supervisor counts this defect, too.
    let early = |seed: &str| {
        let control = ["--control", "receipt-before-commit", "--hostile", "0"];
        chaos(&[&["--seed", seed, "--seconds", "22"], &control[..]].concat())
    };
    let counter = "vibrissa_invariant_violations_total{invariant=\"RECEIPT_AFTER_COMMIT\"}";
    let is_seen = |result: &Value| count(result, "missing") > 0 && result["refusals"][counter].as_u64() > Some(0);
    is_caught("receipt-before-commit", early, is_seen);
    control("no-fence", "20", &["duplicate"]);
    control("robot-ignores-epochs", "20", &["applied_twice", "applied_stale"]);
    control("no-robot-buffer", "20", &["missing"]);
}
