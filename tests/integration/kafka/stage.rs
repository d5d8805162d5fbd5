//! Supervisors as processes, a broker of MQTT, and brokers of Kafka.

use std::collections::BTreeSet;
use std::net::SocketAddr;

use serde_json::Value;
use sqlx::ConnectOptions;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use tempfile::TempDir;
use vibrissa_tests::kafka::{Kafka, Numbers, Reader};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::try_get;

/// Contacts until a whisker counts as learned.
pub(crate) const LEARNED: usize = 60;
pub(crate) const EVENTS: &str = "vibrissa.events";
pub(crate) const CONTACTS: &str = "vibrissa.contacts";
/// Partitions of each topic of events.
pub(crate) const PARTITIONS: u32 = 3;

/// A supervisor process of fleet `f`, with its database.
pub(crate) struct Program {
    pub(crate) process: Process,
    pub(crate) http: SocketAddr,
    folder: TempDir,
}

impl Program {
    /// Starts it with further arguments, and waits until it answers.
    pub(crate) async fn start(mqtt_port: u16, arguments: &[&str]) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
        Self::on(folder, mqtt_port, &[&["--database-url", &database], arguments].concat()).await
    }

    /// Starts it with the database that the arguments name.
    pub(crate) async fn of_database(mqtt_port: u16, arguments: &[&str]) -> Self {
        Self::on(tempfile::tempdir().unwrap(), mqtt_port, arguments).await
    }

    async fn on(folder: TempDir, mqtt_port: u16, arguments: &[&str]) -> Self {
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let (listen, mqtt) = (http.to_string(), format!("mqtt://127.0.0.1:{mqtt_port}"));
        let learned = LEARNED.to_string();
        let own = [
            "run",
            "--fleet",
            "f",
            "--http",
            &listen,
            "--mqtt-url",
            &mqtt,
            "--detection-cold-start-contacts",
            &learned,
        ];
        let process = Process::start(Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: own.iter().chain(arguments).map(|&argument| argument.to_owned()).collect(),
            environment: Vec::new(),
            log: folder.path().join("log"),
        });
        let program = Self { process, http, folder };
        program.answers().await;
        program
    }

    /// Waits until it answers.
    pub(crate) async fn answers(&self) {
        until_true("the program answers", async || try_get(self.http, "/livez").await.is_ok()).await;
    }

    /// Kills it without any cleanup, and starts it again.
    pub(crate) async fn kill_and_restart(&mut self) {
        self.process.kill();
        self.process.restart();
        self.answers().await;
    }

    /// A connection of the test to the database.
    pub(crate) async fn database(&self) -> SqliteConnection {
        SqliteConnectOptions::new().filename(self.folder.path().join("v.sqlite3")).connect().await.unwrap()
    }

    /// Its log so far.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(self.folder.path().join("log")).unwrap_or_default()
    }

    /// The value of a metric of fleet `f`, 0 if there is none.
    pub(crate) async fn metric(&self, name: &str) -> f64 {
        let Ok((_, text)) = try_get(self.http, "/metrics").await else { return 0.0 };
        let line = text.lines().find(|line| line.starts_with(name));
        line.and_then(|line| line.rsplit(' ').next()?.parse().ok()).unwrap_or_default()
    }

    /// Items of a list under `/v1/`.
    pub(crate) async fn list(&self, name: &str) -> Vec<Value> {
        let (_, body) = try_get(self.http, &format!("/v1/{name}")).await.unwrap();
        serde_json::from_str::<Value>(&body).unwrap()["items"].as_array().unwrap().clone()
    }

    /// Number of rows of contacts in the database.
    pub(crate) async fn stored_count(&self) -> usize {
        let count: i64 =
            sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(&mut self.database().await).await.unwrap();
        count as usize
    }

    /// The estimates in the checkpoints by whisker: number of contacts, length and its standard deviation.
    pub(crate) async fn estimates(&self) -> Vec<(i64, f64, f64)> {
        let sql = "SELECT contacts, length_mm, length_sd_mm FROM whiskers ORDER BY whisker_id";
        sqlx::query_as(sql).fetch_all(&mut self.database().await).await.unwrap()
    }

    /// Number of used contacts in the database by whisker.
    pub(crate) async fn used_contacts(&self) -> Vec<i64> {
        let sql =
            "SELECT count(*) FROM contacts WHERE used IN ('USED', 'LEARNING') GROUP BY whisker_id ORDER BY whisker_id";
        sqlx::query_scalar(sql).fetch_all(&mut self.database().await).await.unwrap()
    }

    /// The estimates after the last contact of each whisker: length and its standard deviation.
    pub(crate) async fn last_estimates(&self) -> Vec<(f64, f64)> {
        let sql = "SELECT length_mm, length_sd_mm FROM contacts c WHERE contact_id = (SELECT max(contact_id) FROM contacts o \
             WHERE o.whisker_id = c.whisker_id) ORDER BY whisker_id";
        sqlx::query_as(sql).fetch_all(&mut self.database().await).await.unwrap()
    }

    /// Kills it, and starts it again with a fault.
    pub(crate) async fn plant_fault(&mut self, fault: &str) {
        self.process.kill();
        self.process.set_environment(vec![("VIBRISSA_TEST_FAULT".to_owned(), fault.to_owned())]);
        self.process.restart();
        self.answers().await;
    }

    /// Starts it again without a fault.
    pub(crate) async fn remove_fault(&mut self) {
        self.process.set_environment(Vec::new());
        self.process.restart();
        self.answers().await;
    }

    /// The contacts in the database: number of the boot, sequence number and position.
    pub(crate) async fn stored_contacts(&self) -> BTreeSet<(String, i64, i64)> {
        let sql = "SELECT b.boot_id, c.seq, c.position FROM contacts c JOIN boots b ON b.boot = c.boot";
        sqlx::query_as(sql).fetch_all(&mut self.database().await).await.unwrap().into_iter().collect()
    }
}

/// All events of both topics, each once.
pub(crate) struct Events {
    readers: [(Reader, Numbers); 2],
    pub(crate) all: Vec<Value>,
}

impl Events {
    pub(crate) async fn of(kafka: &Kafka) -> Self {
        let reader = async |topic| (kafka.reader(topic, PARTITIONS).await, Numbers::default());
        Self { readers: [reader(EVENTS).await, reader(CONTACTS).await], all: Vec::new() }
    }

    /// Reads on; events that were read before are left out.
    pub(crate) async fn read(&mut self) {
        for (reader, numbers) in &mut self.readers {
            for (_, record) in reader.read().await {
                let event: Value = serde_json::from_slice(&record.record.value.unwrap()).unwrap();
                let key = String::from_utf8(record.record.key.unwrap()).unwrap();
                assert_eq!(key, format!("f/{}", event["data"]["robot"].as_str().unwrap()));
                if numbers.is_new(&event) {
                    self.all.push(event);
                }
            }
        }
    }

    /// Further events come from another database, whose numbers begin anew.
    pub(crate) fn of_another_database(&mut self) {
        for (_, numbers) in &mut self.readers {
            *numbers = Numbers::default();
        }
    }

    /// Number of events that were written again.
    pub(crate) fn repeated(&self) -> usize {
        self.readers.iter().map(|(_, numbers)| numbers.repeated).sum()
    }

    /// The events of a type.
    pub(crate) fn of_type<'a>(&'a self, kind: &'a str) -> impl Iterator<Item = &'a Value> {
        self.all.iter().filter(move |event| event["type"] == kind)
    }

    /// The contacts: boot, sequence number and position. Panics if one came twice.
    pub(crate) fn contacts(&self) -> BTreeSet<(String, i64, i64)> {
        let mut contacts = BTreeSet::new();
        for part in self.of_type("CONTACTS").map(|event| &event["data"]["contacts"]) {
            for contact in part["contacts"].as_array().unwrap() {
                let boot_id = part["boot_id"].as_str().unwrap().to_owned();
                let name = (boot_id, part["seq"].as_i64().unwrap(), contact["position"].as_i64().unwrap());
                assert!(contacts.insert(name.clone()), "{name:?} came twice");
            }
        }
        contacts
    }
}
