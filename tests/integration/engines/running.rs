//! A supervisor and simulated robots on the nodes of a broker.

use std::path::PathBuf;

use serde_json::Value;
use tempfile::TempDir;
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::scenario::Change;
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::mqtt::{BrokerAddress, Credentials};
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::try_get;

use crate::engine::{ALL, PASSWORD};

/// Contacts until a whisker counts as learned.
pub(crate) const LEARNED: usize = 60;

/// Two robots; whiskers are cut by tests.
const SCENARIO: &str = r#"
fleet = "f"
seed = 11
[behaviour]
contacts_per_second = 60.0
contacts_per_message = 10
message_after_s = 0.2
[[robots]]
robot = "one"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
[[robots]]
robot = "two"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
"#;

fn url(ports: &[u16]) -> String {
    ports.iter().map(|port| format!("mqtt://127.0.0.1:{port}")).collect::<Vec<_>>().join(",")
}

/// A running supervisor of fleet `f`.
pub(crate) struct Running {
    pub(crate) service: Service,
    folder: TempDir,
}

impl Running {
    /// Starts it with the nodes in this order, and waits until it hears robots.
    pub(crate) async fn start(ports: &[u16]) -> Self {
        Self::on(tempfile::tempdir().unwrap(), ports).await
    }

    /// Starts it on the database in this folder.
    pub(crate) async fn on(folder: TempDir, ports: &[u16]) -> Self {
        let mut params = vibrissa_tests::robot::params();
        params.detection.cold_start_contacts = LEARNED as u32;
        params.command.resend_after = Micros::from_s(0.3);
        let credentials = Credentials { username: ALL.to_owned(), password: Secret::new(PASSWORD) };
        let broker: BrokerAddress = url(ports).parse().unwrap();
        let fleet = Name::new("f").unwrap();
        let service = Service::start(ServiceOptions {
            kafka: vibrissa_supervisor::service::KafkaOptions::default(),
            access: vibrissa_supervisor::http::access::AccessOptions::default(),
            webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
            traces: None,
            name: "s".to_owned(),
            fleets: vec![fleet],
            database: DatabaseAddress::Sqlite(database(&folder)),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            limits: vibrissa_supervisor::service::LimitOptions::default(),
            history: vibrissa_supervisor::service::HistoryOptions::default(),
            black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
            metrics_per_whisker: false,
            broker: Some(BrokerAddress { credentials: Some(credentials), ..broker }),
            mqtt_port: 0,
            mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
            http: "127.0.0.1:0".parse().unwrap(),
            params,
        })
        .await
        .unwrap();
        let running = Self { service, folder };
        running.connected().await;
        running
    }

    /// Waits until both connections are up.
    pub(crate) async fn connected(&self) {
        until_true("both connections", async || self.nodes().await.is_some_and(|[a, b]| a != 0 && b != 0)).await;
    }

    /// Ports of the nodes in use by `/readyz`: receiving and publishing, 0 for none.
    pub(crate) async fn nodes(&self) -> Option<[u16; 2]> {
        let (_, body) = try_get(self.service.http, "/readyz").await.unwrap();
        let ready: Value = serde_json::from_str(&body).unwrap();
        let nodes = ready["mqtt_nodes"].get("f")?;
        let port = |connection: &str| {
            let node = nodes[connection].as_str().unwrap_or_default();
            node.strip_prefix("127.0.0.1:").map_or(0, |port| port.parse().unwrap())
        };
        Some([port("receiving"), port("publishing")])
    }

    /// Items of a list under `/v1/`.
    pub(crate) async fn list(&self, name: &str) -> Vec<Value> {
        let (_, body) = try_get(self.service.http, &format!("/v1/{name}")).await.unwrap();
        let list: Value = serde_json::from_str(&body).unwrap();
        list["items"].as_array().unwrap().clone()
    }

    /// Waits until the robots' present boots are known.
    pub(crate) async fn knows(&self, fleet: &Fleet) {
        let begun = std::time::Instant::now();
        until_true("known boots", async || {
            let listed = self.list("robots").await;
            fleet.robots().iter().all(|robot| {
                let boot_id = robot.with(|robot| robot.boot_id().to_string());
                listed.iter().any(|one| one["robot"] == robot.name().as_str() && one["boot_id"] == boot_id)
            })
        })
        .await;
        eprintln!("robots known after {:?}", begun.elapsed());
    }

    /// Waits until the robot has applied a setpoint, beyond `before`. Returns the number of applied ones.
    pub(crate) async fn applied(&self, robot: &str, before: usize) -> usize {
        until("an applied setpoint", async || {
            let setpoints = self.list("setpoints").await;
            let applied = setpoints.iter().filter(|one| one["robot"] == robot && one["state"] == "APPLIED").count();
            (applied > before).then_some(applied)
        })
        .await
    }

    /// Stops it in an orderly way, and returns the folder with its database.
    pub(crate) async fn stop(self) -> TempDir {
        self.service.stop().await;
        self.folder
    }
}

fn database(folder: &TempDir) -> PathBuf {
    folder.path().join("vibrissa.sqlite3")
}

/// Robots `one` and `two`, with the nodes in this order.
pub(crate) fn robots(ports: &[u16]) -> Fleet {
    let credentials = Some((ALL.to_owned(), PASSWORD.to_owned()));
    let broker = Broker { credentials, ..Broker::from_url(&url(ports)).unwrap() };
    Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &broker).unwrap()
}

/// Waits until every robot has made `more` further contacts.
pub(crate) async fn touches(fleet: &Fleet, more: u64) {
    let goal = fleet.contacts_made() + more * fleet.robots().len() as u64;
    until_true("more contacts", async || fleet.contacts_made() >= goal).await;
}

/// Cuts whisker 0 of a robot to this length.
pub(crate) fn cut(fleet: &Fleet, robot: &str, length_mm: f64) {
    let robot = fleet.robot(&Name::robot(robot).unwrap()).unwrap();
    let array = Name::new("left").unwrap();
    robot.with(|robot| robot.happen_soon(Some(array), Some(0), Change::Trim { length_mm }, now_us())).unwrap();
}
