//! Checks metrics and API paths in alerts and runbooks against a running service.

use std::collections::BTreeSet;

use serde_json::Value;
use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::Params;
use vibrissa_protocol::Name;
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

use super::{code, files, list, read, rules, text};

/// A whisker that is cut early, so that every metric gets a value.
const SCENARIO: &str = r#"
fleet = "f"
seed = 3
[behaviour]
contacts_per_second = 150.0
contacts_per_message = 10
message_after_s = 0.2
[[robots]]
robot = "r"
events = [{ at_contact = 100, array = "left", whisker = 0, change = { kind = "TRIM", length_mm = 67.0 } }]
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
"#;

/// Names of metrics in an expression or a text.
fn metrics_in(text: &str) -> impl Iterator<Item = &str> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric() && c != '_' && c != ':');
    words.filter(|word| word.starts_with("vibrissa_") || word.starts_with("process_"))
}

/// Names of the declared metrics, including the series of histograms.
fn declared(text: &str) -> BTreeSet<String> {
    let kinds = text.lines().filter_map(|line| line.strip_prefix("# TYPE ")?.split_once(' '));
    let parts = |(name, kind): (&str, &str)| match kind {
        "histogram" => ["_bucket", "_sum", "_count"].iter().map(|part| format!("{name}{part}")).collect(),
        _ => vec![name.to_owned()],
    };
    kinds.flat_map(parts).collect()
}

/// Whether a path with its query is part of the OpenAPI document.
fn is_served(document: &Value, address: &str) -> bool {
    let (path, query) = address.split_once('?').unwrap_or((address, ""));
    let segments = |path: &str| path.split('/').map(ToOwned::to_owned).collect::<Vec<_>>();
    let asked = segments(path);
    let fits = |known: &str| {
        let known = segments(known);
        let same = |(known, asked): (&String, &String)| known == asked || known.starts_with('{');
        known.len() == asked.len() && known.iter().zip(&asked).all(same)
    };
    let names: Vec<&str> = query.split('&').filter_map(|pair| Some(pair.split_once('=')?.0)).collect();
    let takes = |operation: &Value, name: &str| list(&operation["parameters"]).any(|one| one["name"] == name);
    let mut served = document["paths"].as_object().unwrap().iter().filter(|(known, _)| fits(known.as_str()));
    served.any(|(_, operations)| names.iter().all(|name| takes(&operations["get"], name)))
}

// The service and its robots share the threads with the test, which asks all the time.
#[tokio::test(flavor = "multi_thread")]
async fn alerts_and_runbooks_ask_for_metrics_and_addresses_that_there_are() {
    let folder = tempfile::tempdir().unwrap();
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.detection.cold_start_contacts = 60;
    let service = Service::start(ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: AccessOptions::default(),
        name: "s".to_owned(),
        fleets: vec![Name::new("f").unwrap()],
        database: DatabaseAddress::Sqlite(folder.path().join("v.sqlite3")),
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: vibrissa_supervisor::service::HistoryOptions::default(),
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        metrics_per_whisker: false,
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        broker: None,
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: "127.0.0.1:0".parse().unwrap(),
        params,
    })
    .await
    .unwrap();
    let fleet =
        Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &Broker::new("127.0.0.1", service.broker.port))
            .unwrap();
    let document: Value = serde_json::from_str(&try_get(service.http, "/openapi.json").await.unwrap().1).unwrap();
    // The metric of errors appears with the first measured error.
    let exposition = async || try_get(service.http, "/metrics").await.unwrap().1;
    until_true("a measured error", async || exposition().await.contains("vibrissa_compensation_error_worst_ratio{"))
        .await;
    let known = declared(&exposition().await);

    for rule in rules() {
        let name = rule["alert"].as_str().or(rule["record"].as_str()).unwrap();
        for metric in metrics_in(text(&rule["expr"])) {
            assert!(known.contains(metric), "{name}: {metric} is not exported: {known:?}");
        }
    }
    let mut addresses = 0;
    for path in files("docs/runbooks") {
        let page = read(&path);
        for metric in code(&page).flat_map(metrics_in) {
            let is_exported = known.contains(metric) || known.contains(&format!("{metric}_bucket"));
            assert!(is_exported, "{path}: {metric}");
        }
        let words = page.split(|c: char| c.is_whitespace() || "`\"()".contains(c));
        for address in words.filter(|word| word.starts_with("/v1/")) {
            let address = address.trim_end_matches(['.', ',', ';', ':']);
            assert!(is_served(&document, address), "{path}: {address}");
            addresses += 1;
        }
    }
    assert!(addresses > 20, "{addresses}");
    fleet.stop().await;
    service.stop().await;
}
