//! Runs the service in this process with a private database and broker.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::Value;
use tempfile::TempDir;
use vibrissa_core::robot::Params;
use vibrissa_core::units::Micros;
use vibrissa_protocol::Name;
use vibrissa_store::DatabaseAddress;
use vibrissa_store::secret::Secret;
use vibrissa_supervisor::engine::Limits;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, LimitOptions, Service, ServiceOptions};
use vibrissa_supervisor::trace::TraceOptions;
use vibrissa_tests::wait::until_true;

use crate::database::Database;
use crate::web::{self, Metrics};

/// Contacts until a whisker counts as learned; few, so that tests are fast.
pub(crate) const LEARNED: usize = 60;

/// A running service. Its database can outlive it.
pub(crate) struct Running {
    pub(crate) service: Service,
    pub(crate) database: Database,
    folder: TempDir,
}

/// Parameters with short times.
pub(crate) fn quick() -> Params {
    let mut params = vibrissa_tests::robot::params();
    params.detection.cold_start_contacts = LEARNED as u32;
    params.command.resend_after = Micros::from_s(0.3);
    params
}

impl Running {
    /// Starts a service with its embedded broker on a free port.
    pub(crate) async fn start() -> Self {
        Self::with(quick(), None).await
    }

    /// Starts a service with these parameters and, instead of the embedded broker, the one on this port of 127.0.0.1.
    pub(crate) async fn with(params: Params, broker: Option<u16>) -> Self {
        Self::on(tempfile::tempdir().unwrap(), params, broker).await
    }

    /// Starts a service that requires this token or one from the database.
    pub(crate) async fn closed(token: &str) -> Self {
        let access = AccessOptions { token: Some(Secret::new(token)), oidc: None };
        Self::let_in(tempfile::tempdir().unwrap(), quick(), None, (access, None), None).await
    }

    /// Starts a service on the database in this folder.
    pub(crate) async fn on(folder: TempDir, params: Params, broker: Option<u16>) -> Self {
        Self::let_in(folder, params, broker, (AccessOptions::default(), None), None).await
    }

    /// Starts a service that exports traces.
    pub(crate) async fn traced(broker: Option<u16>, traces: TraceOptions) -> Self {
        Self::traced_on(tempfile::tempdir().unwrap(), broker, traces).await
    }

    async fn traced_on(folder: TempDir, broker: Option<u16>, traces: TraceOptions) -> Self {
        Self::let_in(folder, quick(), broker, (AccessOptions::default(), Some(traces)), None).await
    }

    /// Starts a service that publishes facts for the maintenance of whiskers.
    pub(crate) async fn maintained(every: Duration, broker: u16) -> Self {
        Self::maintained_on(tempfile::tempdir().unwrap(), every, broker).await
    }

    /// Stops the service in an orderly way and starts another such one with the same database.
    pub(crate) async fn maintained_again(self, every: Duration, broker: u16) -> Self {
        Self::maintained_on(self.stop().await, every, broker).await
    }

    async fn maintained_on(folder: TempDir, every: Duration, broker: u16) -> Self {
        Self::let_in(folder, quick(), Some(broker), (AccessOptions::default(), None), Some(every)).await
    }

    async fn let_in(
        folder: TempDir,
        params: Params,
        broker: Option<u16>,
        (access, traces): (AccessOptions, Option<TraceOptions>),
        maintenance_every: Option<Duration>,
    ) -> Self {
        let path = database_in(&folder);
        let fleet = Name::new("f").unwrap();
        let service = Service::start(ServiceOptions {
            kafka: vibrissa_supervisor::service::KafkaOptions::default(),
            access,
            webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
            traces,
            name: "s".to_owned(),
            fleets: vec![fleet.clone()],
            database: DatabaseAddress::Sqlite(path.clone()),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            limits: LimitOptions {
                limits: Limits { maintenance_every, ..Limits::default() },
                ..LimitOptions::default()
            },
            history: vibrissa_supervisor::service::HistoryOptions::default(),
            black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
            metrics_per_whisker: false,
            broker: broker.map(|port| BrokerAddress::new("127.0.0.1", port)),
            mqtt_port: 0,
            mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
            http: "127.0.0.1:0".parse().unwrap(),
            params,
        })
        .await
        .unwrap();
        let connected = service.metrics.of_fleet(&fleet).broker_connected;
        until_true("the connection to the broker", async || connected.get() == 1).await;
        Self { service, database: Database::open(&path).await, folder }
    }

    /// Stops the service in an orderly way and starts another one with the same database.
    pub(crate) async fn again(self, params: Params, broker: Option<u16>) -> Self {
        Self::on(self.stop().await, params, broker).await
    }

    /// The same, with export of traces.
    pub(crate) async fn traced_again(self, broker: Option<u16>, traces: TraceOptions) -> Self {
        Self::traced_on(self.stop().await, broker, traces).await
    }

    /// Stops the service in an orderly way and returns the folder with its database.
    pub(crate) async fn stop(self) -> TempDir {
        self.service.stop().await;
        self.folder
    }

    /// Folder of the database.
    pub(crate) fn folder(&self) -> &TempDir {
        &self.folder
    }

    /// Port of the broker.
    pub(crate) fn port(&self) -> u16 {
        self.service.broker.port
    }

    pub(crate) async fn metrics(&self) -> Metrics {
        Metrics::read(self.service.http).await
    }

    /// Value of a metric, by name and labels.
    pub(crate) async fn metric(&self, name: &str) -> f64 {
        self.metrics().await.get(name)
    }

    /// Items of a list under `/v1/`.
    pub(crate) async fn list(&self, name: &str) -> Vec<Value> {
        list(self.service.http, name).await
    }
}

/// Items of a list under `/v1/`.
pub(crate) async fn list(http: std::net::SocketAddr, name: &str) -> Vec<Value> {
    web::json(http, &format!("/v1/{name}")).await["items"].as_array().unwrap().clone()
}

/// Path of the database in a folder.
pub(crate) fn database_in(folder: &TempDir) -> PathBuf {
    folder.path().join("vibrissa.sqlite3")
}
