//! The whole service with a fleet of simulated robots.

use std::path::{Path, PathBuf};

use sqlx::sqlite::{SqliteConnectOptions, SqlitePoolOptions};
use tempfile::TempDir;
use vibrissa_protocol::Name;
use vibrissa_simulator::{Authorities, Broker, Fleet, Scenario};
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::wait::until_true;

use crate::link::PASSWORD;

const SCENARIO: &str = r#"
fleet = "lab"
seed = 1
[behaviour]
contacts_per_second = 50.0
message_after_s = 0.2
[[robots]]
robot = "one"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
[[robots]]
robot = "two"
arrays = [{ array = "left", type = "TYPE_2", whiskers = [{ whisker = 0 }, { whisker = 1 }] }]
"#;

/// A service for fleet `lab`.
pub(crate) struct Running {
    pub(crate) service: Service,
    folder: TempDir,
}

impl Running {
    /// Starts the service and waits until it is connected.
    pub(crate) async fn start(broker: BrokerAddress) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let service = Service::start(ServiceOptions {
            kafka: vibrissa_supervisor::service::KafkaOptions::default(),
            access: vibrissa_supervisor::http::access::AccessOptions::default(),
            name: "s".to_owned(),
            fleets: vec![Name::new("lab").unwrap()],
            database: DatabaseAddress::Sqlite(database(&folder)),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            limits: vibrissa_supervisor::service::LimitOptions::default(),
            history: vibrissa_supervisor::service::HistoryOptions::default(),
            black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
            metrics_per_whisker: false,
            broker: Some(broker),
            mqtt_port: 0,
            mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
            http: "127.0.0.1:0".parse().unwrap(),
            webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
            traces: None,
            params: vibrissa_tests::robot::params(),
        })
        .await
        .unwrap();
        let running = Self { service, folder };
        until_true("the connection to the broker", async || running.is_connected()).await;
        running
    }

    /// Whether the service is connected to the broker.
    pub(crate) fn is_connected(&self) -> bool {
        self.service.metrics.of_fleet(&Name::new("lab").unwrap()).broker_connected.get() == 1
    }

    /// Number of contacts in the database.
    pub(crate) async fn contacts(&self) -> i64 {
        let options = SqliteConnectOptions::new().filename(database(&self.folder)).read_only(true);
        let pool = SqlitePoolOptions::new().max_connections(1).connect_with(options).await.unwrap();
        let count = sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(&pool).await.unwrap();
        pool.close().await;
        count
    }
}

fn database(folder: &TempDir) -> PathBuf {
    folder.path().join("vibrissa.sqlite3")
}

/// Robots `one` and `two`, each with a user of its own and [`PASSWORD`].
pub(crate) fn fleet(port: u16, ca_file: Option<&Path>) -> Fleet {
    let broker = Broker {
        credentials: Some(("{fleet}/{robot}".to_owned(), PASSWORD.to_owned())),
        tls: ca_file.map(|path| Authorities::File(path.to_owned())),
        ..Broker::new("localhost", port)
    };
    Fleet::start(&Scenario::from_toml_str(SCENARIO).unwrap(), &broker).unwrap()
}

/// Waits until robots have made `more` further contacts, stops them, and waits until every contact is in the database.
pub(crate) async fn everything_is_recorded(fleet: &Fleet, running: &Running, more: u64) {
    let goal = fleet.contacts_made() + more;
    until_true("more contacts", async || fleet.contacts_made() >= goal).await;
    fleet.rest();
    until_true("every contact recorded", async || {
        running.contacts().await == i64::try_from(fleet.contacts_made()).unwrap()
    })
    .await;
}
