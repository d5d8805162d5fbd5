//! Supervisors with a robot, and direct access to their database.

use std::path::PathBuf;
use std::time::Duration;

use serde_json::{Value, json};
use sqlx::postgres::PgConnection;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, ConnectOptions};
use tempfile::TempDir;
use vibrissa_protocol::{ArrayType, Name};
use vibrissa_store::DatabaseAddress;
use vibrissa_supervisor::http::access::AccessOptions;
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_supervisor::webhooks::{Pace, WebhookOptions};
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{Answer, send};

use crate::receiver::Receiver;

/// Contacts until a whisker counts as learned.
pub(crate) const LEARNED: u32 = 60;

/// Pauses that a test can wait for.
pub(crate) const FAST: Pace = Pace {
    first: Duration::from_millis(20),
    longest: Duration::from_millis(100),
    attempts_max: 3,
    age_max: Duration::from_secs(86_400),
};

/// A database with a broker.
pub(crate) struct Stage {
    pub(crate) address: DatabaseAddress,
    pub(crate) broker: Mosquitto,
    server: Option<Postgres>,
    pub(crate) folder: TempDir,
}

/// A connection of the test.
pub(crate) enum Raw {
    Sqlite(SqliteConnection),
    Postgres(PgConnection),
}

impl Raw {
    /// Executes a statement; returns the number of changed rows.
    pub(crate) async fn run(&mut self, sql: &str) -> u64 {
        let sql = AssertSqlSafe(sql.to_owned());
        match self {
            Self::Sqlite(link) => sqlx::query(sql).execute(link).await.unwrap().rows_affected(),
            Self::Postgres(link) => sqlx::query(sql).execute(link).await.unwrap().rows_affected(),
        }
    }

    /// A whole number.
    pub(crate) async fn number(&mut self, sql: &str) -> i64 {
        let sql = AssertSqlSafe(sql.to_owned());
        match self {
            Self::Sqlite(link) => sqlx::query_scalar(sql).fetch_one(link).await.unwrap(),
            Self::Postgres(link) => sqlx::query_scalar(sql).fetch_one(link).await.unwrap(),
        }
    }

    /// Writes the event of a trim of the robot's first whisker, as a supervisor would.
    pub(crate) async fn trim(&mut self, trim_id: i64) {
        let recorded_us = vibrissa_edge::clock::wall_clock().0;
        let data = json!({ "trim": { "trim_id": trim_id, "length_before_mm": 70, "length_after_mm": 65,
            "length_after_sd_mm": 0.25, "contacts_to_detect": 5 } });
        let sql = format!(
            "INSERT INTO events (recorded_us, version, kind, audience, fleet, robot_id, whisker_id, data) \
             SELECT {recorded_us}, 2, 'TRIM', 'PEOPLE', 'f', robot_id, whisker_id, '{data}' \
             FROM whiskers ORDER BY whisker_id LIMIT 1"
        );
        assert_eq!(self.run(&sql).await, 1);
    }
}

impl Stage {
    pub(crate) async fn sqlite() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let address = DatabaseAddress::Sqlite(folder.path().join("v.sqlite3"));
        Self { address, broker: Mosquitto::start(), server: None, folder }
    }

    /// A PostgreSQL with the shipped role.
    pub(crate) async fn postgres() -> Self {
        let server = Postgres::start_with_supervisor().await;
        let address = Postgres::supervisor_url(server.port()).parse().unwrap();
        Self { address, broker: Mosquitto::start(), server: Some(server), folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn file(&self) -> PathBuf {
        self.folder.path().join("v.sqlite3")
    }

    pub(crate) async fn raw(&self) -> Raw {
        match &self.server {
            None => Raw::Sqlite(SqliteConnectOptions::new().filename(self.file()).connect().await.unwrap()),
            Some(server) => Raw::Postgres(server.connect().connect().await.unwrap()),
        }
    }

    pub(crate) async fn supervisor(&self, name: &str, pace: Pace) -> Service {
        self.with(name, pace, &["127.0.0.1"]).await
    }

    /// Starts a supervisor of fleet `f` whose webhooks may reach these hosts.
    pub(crate) async fn with(&self, name: &str, pace: Pace, hosts: &[&str]) -> Service {
        let allowed_hosts = hosts.iter().map(|&host| host.to_owned()).collect();
        self.delivering(name, WebhookOptions { allowed_hosts, pace, mail: None }).await
    }

    /// Starts a supervisor of fleet `f` with these webhooks.
    pub(crate) async fn delivering(&self, name: &str, webhooks: WebhookOptions) -> Service {
        let fleet = Name::new("f").unwrap();
        let mut params = vibrissa_tests::robot::params();
        params.detection.cold_start_contacts = LEARNED;
        let service = Service::start(ServiceOptions {
            kafka: vibrissa_supervisor::service::KafkaOptions::default(),
            access: AccessOptions::default(),
            name: name.to_owned(),
            fleets: vec![fleet.clone()],
            database: self.address.clone(),
            is_new_installation: true,
            lease_time_to_live: LEASE_TIME_TO_LIVE,
            limits: vibrissa_supervisor::service::LimitOptions::default(),
            history: vibrissa_supervisor::service::HistoryOptions::default(),
            metrics_per_whisker: false,
            broker: Some(BrokerAddress::new("127.0.0.1", self.broker.port())),
            mqtt_port: 0,
            mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
            http: ([127, 0, 0, 1], 0).into(),
            webhooks,
            black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
            traces: None,
            params,
        });
        service.await.unwrap()
    }

    /// Robot `r` with an array of whiskers that are whole.
    pub(crate) async fn robot(&self) -> HandRobot {
        HandRobot::born(self.broker.port(), "r", array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await
    }
}

/// Sends a request to a supervisor.
pub(crate) async fn call(service: &Service, method: &str, path: &str, body: Option<Value>) -> Answer {
    send(service.http, method, path, &[], body.as_ref()).await.unwrap()
}

/// Creates a webhook; returns its number and its secret.
pub(crate) async fn hook(service: &Service, receiver: &Receiver, more: Value) -> (i64, String) {
    let mut body = json!({ "name": "tickets", "url": receiver.url() });
    body.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
    let answer = call(service, "POST", "/v1/webhooks", Some(body)).await;
    assert_eq!(answer.status, 201, "{}", answer.body);
    let created = answer.json();
    (created["webhook"]["webhook_id"].as_i64().unwrap(), created["secret"].as_str().unwrap().to_owned())
}

/// The webhook as the API shows it.
pub(crate) async fn shown(service: &Service, webhook_id: i64) -> Value {
    let answer = call(service, "GET", &format!("/v1/webhooks/{webhook_id}"), None).await;
    assert_eq!(answer.status, 200, "{}", answer.body);
    answer.json()
}

/// Waits until the receiver has taken so many events.
pub(crate) async fn taken(receiver: &Receiver, many: usize) -> Vec<i64> {
    until_true(&format!("{many} events"), async || receiver.taken().len() >= many).await;
    receiver.taken()
}
