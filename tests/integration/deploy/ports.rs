//! The engine and its ports: `inbox`, `log_inbox`, `link_state` and `outbox` carry data, name no transport and read no
//! metric.

use std::path::PathBuf;

use crate::project;
use crate::structure::{code, rust_files};

/// Transports and their libraries. No path of the engine or of its ports has one of these names.
const TRANSPORTS: [&str; 8] = ["mqtt", "kafka", "http", "rumqttc", "mqtt5", "rskafka", "axum", "hyper"];
/// Calls that read a metric, or a state that metrics show.
const READS: [&str; 3] = [".get()", ".age(", ".ages("];

/// Files of these modules of the supervisor.
fn files(modules: &[&str]) -> Vec<PathBuf> {
    let root = project().join("services/supervisor/src");
    let of = |path: &PathBuf| {
        let top = path.strip_prefix(&root).unwrap().iter().next().unwrap().to_str().unwrap();
        modules.contains(&top.trim_end_matches(".rs"))
    };
    rust_files(&root).into_iter().filter(of).collect()
}

/// The transports that code names in its imports and paths.
fn transports(code: &str) -> Vec<&str> {
    let names = code.split(|one: char| !one.is_alphanumeric() && one != '_');
    names.filter(|name| TRANSPORTS.contains(name)).collect()
}

#[test]
fn the_engine_names_no_transport() {
    assert_eq!(
        transports("use crate::{inbox, kafka::LogReader};\nlet a = rumqttc::QoS::AtMostOnce;"),
        ["kafka", "rumqttc"]
    );
    assert!(transports("let mqtt_topic = https;").is_empty());
    let files = files(&["engine", "inbox", "log_inbox", "link_state", "outbox"]);
    assert!(files.len() > 50, "{files:?}");
    for path in files {
        assert_eq!(transports(&code(&path)), Vec::<&str>::new(), "{}", path.display());
    }
}

/// A gauge is an output. The engine decides by the state of its parts.
#[test]
fn the_engine_reads_no_metric() {
    for path in files(&["engine", "inbox"]) {
        let code: String = code(&path).split_whitespace().collect();
        for after in code.split("metrics.").skip(1) {
            let statement = after.split([';', ',', '{', '}']).next().unwrap_or_default();
            assert!(!READS.iter().any(|read| statement.contains(read)), "{}: metrics.{statement}", path.display());
        }
    }
}
