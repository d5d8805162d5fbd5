//! Supervisors as processes on one PostgreSQL: they share fleets, hand over, take over, and wait for the database.

use std::path::Path;
use std::time::Duration;

use nix::sys::signal::Signal;
use sqlx::postgres::PgConnection;
use sqlx::{ConnectOptions, Row};
use tempfile::TempDir;
use vibrissa_protocol::{Message, Name};
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_store::DatabaseAddress;
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_supervisor::mqtt::BrokerAddress;
use vibrissa_supervisor::readiness::Standing;
use vibrissa_supervisor::service::{LEASE_TIME_TO_LIVE, Service, ServiceOptions};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::observer::{Heard, Observer};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::wait::{PATIENCE, until, until_true};
use vibrissa_tests::web::try_get;

/// A broker, a database server, and a folder for logs.
pub(crate) struct Stage {
    broker: Mosquitto,
    server: Postgres,
    folder: TempDir,
}

/// A supervisor process.
pub(crate) struct Replica {
    process: Process,
    http: u16,
}

impl Stage {
    pub(crate) async fn new() -> Self {
        let server = Postgres::start_with_supervisor().await;
        Self { broker: Mosquitto::start(), server, folder: tempfile::tempdir().unwrap() }
    }

    /// Starts a supervisor of these fleets.
    pub(crate) fn replica(&self, name: &str, fleets: &str, time_to_live_s: f64) -> Replica {
        let database = Postgres::supervisor_url(self.server.port());
        Replica::start(self.folder.path(), name, fleets, &database, self.broker.port(), time_to_live_s)
    }

    pub(crate) async fn link(&self) -> PgConnection {
        self.server.connect().connect().await.unwrap()
    }

    /// Current holder of each fleet, sorted by fleet.
    async fn holders(&self) -> Vec<(String, String)> {
        let mut link = self.link().await;
        let rows = sqlx::query(
            "SELECT fleet, holder FROM leases WHERE owner IS NOT NULL AND expires_us > clock_us() ORDER BY fleet",
        )
        .fetch_all(&mut link)
        .await
        .unwrap_or_default();
        rows.iter().map(|row| (row.get("fleet"), row.get("holder"))).collect()
    }

    pub(crate) async fn count_of(&self, holder: &str) -> usize {
        self.holders().await.iter().filter(|(_, one)| one == holder).count()
    }

    /// Number of contacts, and of their different names.
    pub(crate) async fn counted(&self) -> (i64, i64) {
        let sql = "SELECT count(*), count(DISTINCT (boot, seq, position)) FROM contacts";
        sqlx::query_as(sql).fetch_one(&mut self.link().await).await.unwrap()
    }

    fn fleet(&self, name: &str) -> Fleet {
        start_fleet(name, self.broker.port())
    }

    /// Waits for this number of further contacts in the database.
    pub(crate) async fn more_recorded(&self, more: i64) {
        let goal = self.counted().await.0 + more;
        until_true("more contacts recorded", async || self.counted().await.0 >= goal).await;
    }

    /// Stops the contacts, waits until everything is receipted, and checks that each contact is recorded once.
    async fn assert_each_contact_is_there_once(&self, fleet: &Fleet) {
        fleet.rest();
        until_true("every message receipted", async || fleet.is_receipted()).await;
        let made = fleet.contacts_made() as i64;
        assert_eq!(self.counted().await, (made, made));
    }
}

/// Two robots with 200 contacts per second.
pub(crate) fn start_fleet(name: &str, broker_port: u16) -> Fleet {
    let scenario = format!(
        r#"
fleet = "{name}"
seed = 7
[behaviour]
contacts_per_second = 50.0
contacts_per_message = 5
message_after_s = 0.2
[[robots]]
robot = "one"
arrays = [{{ array = "left", type = "TYPE_2", whiskers = [{{ whisker = 0 }}, {{ whisker = 1 }}] }}]
[[robots]]
robot = "two"
arrays = [{{ array = "left", type = "TYPE_2", whiskers = [{{ whisker = 0 }}, {{ whisker = 1 }}] }}]
"#
    );
    let scenario = Scenario::from_toml_str(&scenario).unwrap();
    Fleet::start(&scenario, &Broker::new("127.0.0.1", broker_port)).unwrap()
}

impl Replica {
    /// Starts a supervisor of these fleets with this database and broker.
    pub(crate) fn start(
        folder: &Path,
        name: &str,
        fleets: &str,
        database: &str,
        broker_port: u16,
        time_to_live_s: f64,
    ) -> Self {
        let http = free_port();
        let arguments = [
            "run",
            "--name",
            name,
            "--fleets",
            fleets,
            "--database-url",
            database,
            "--mqtt-url",
            &format!("mqtt://127.0.0.1:{broker_port}"),
            "--http-listen",
            &format!("127.0.0.1:{http}"),
            "--lease-time-to-live-s",
            &time_to_live_s.to_string(),
        ];
        let launch = Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.map(str::to_owned).into(),
            environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
            log: folder.join(name),
        };
        Self { process: Process::start(launch), http }
    }

    /// Kills the process, as a power failure would.
    pub(crate) fn kill(&mut self) {
        self.process.kill();
    }

    /// Body of the answer to a GET.
    pub(crate) async fn get(&self, path: &str) -> String {
        try_get(([127, 0, 0, 1], self.http).into(), path).await.unwrap().1
    }

    /// Status and text of `/readyz`. None without an answer.
    pub(crate) async fn ready(&self) -> Option<(u16, String)> {
        try_get(([127, 0, 0, 1], self.http).into(), "/readyz").await.ok()
    }

    /// Waits until `/readyz` has this status and a text that contains this part.
    pub(crate) async fn says(&self, status: u16, part: &str) -> String {
        until(&format!("{status} with {part}"), async || {
            self.ready().await.filter(|(code, text)| *code == status && text.contains(part)).map(|(_, text)| text)
        })
        .await
    }

    pub(crate) async fn terminate(&mut self) {
        self.process.signal(Signal::SIGTERM);
        let status = self.process.ended(PATIENCE).await.expect("the supervisor must end");
        assert!(status.success(), "{status}");
    }
}

/// A start can take long, and service managers stop programs that start.
#[tokio::test]
async fn regress_a_supervisor_that_is_told_to_stop_while_it_starts_ends_in_order() {
    let silent = tokio::net::TcpListener::bind("127.0.0.1:0").await.unwrap();
    let folder = tempfile::tempdir().unwrap();
    let database = Postgres::url(silent.local_addr().unwrap().port());
    let mut starting = Replica::start(folder.path(), "s", "f", &database, free_port(), 1.0);
    let _connected = silent.accept().await.unwrap();
    starting.terminate().await;
}

#[tokio::test]
async fn replicas_share_the_fleets_and_hand_them_over_at_once_when_they_are_told_to_stop() {
    const TIME_TO_LIVE_S: f64 = 8.0;
    let stage = Stage::new().await;
    let mut a = stage.replica("a", "f1,f2,f3,f4", TIME_TO_LIVE_S);
    until_true("a has all", async || stage.count_of("a").await == 4).await;
    let mut b = stage.replica("b", "f1,f2,f3,f4", TIME_TO_LIVE_S);
    until_true("two each", async || (stage.count_of("a").await, stage.count_of("b").await) == (2, 2)).await;
    // The database knows an owner before the owner has loaded its fleet.
    let body = b.says(200, "OWNED").await;
    assert!(body.contains("STANDBY") && body.contains("\"holder\":\"a\""), "{body}");
    a.terminate().await;
    // Otherwise its leases would last for their time to live.
    assert_eq!(stage.count_of("a").await, 0);
    until_true("b has all", async || stage.count_of("b").await == 4).await;
    b.says(200, "OWNED").await;
    b.terminate().await;
    assert!(stage.holders().await.is_empty());
}

#[tokio::test]
async fn a_killed_supervisor_is_replaced_and_nothing_is_lost_or_there_twice() {
    let stage = Stage::new().await;
    let mut a = stage.replica("a", "f", 2.0);
    until_true("a has it", async || stage.count_of("a").await == 1).await;
    let b = stage.replica("b", "f", 2.0);
    b.says(200, "STANDBY").await;
    let fleet = stage.fleet("f");
    stage.more_recorded(200).await;
    a.process.kill();
    until_true("b has it", async || stage.count_of("b").await == 1).await;
    stage.more_recorded(200).await;
    stage.assert_each_contact_is_there_once(&fleet).await;
    fleet.stop().await;
}

#[tokio::test]
async fn a_supervisor_that_was_frozen_for_too_long_commits_nothing_and_stands_by() {
    let stage = Stage::new().await;
    let mut a = stage.replica("a", "f", 2.5);
    until_true("a has it", async || stage.count_of("a").await == 1).await;
    let b = stage.replica("b", "f", 2.5);
    b.says(200, "STANDBY").await;
    let fleet = stage.fleet("f");
    stage.more_recorded(200).await;
    a.process.signal(Signal::SIGSTOP);
    until_true("b has it", async || stage.count_of("b").await == 1).await;
    stage.more_recorded(200).await;
    a.process.signal(Signal::SIGCONT);
    a.says(200, "\"holder\":\"b\"").await;
    stage.more_recorded(200).await;
    stage.assert_each_contact_is_there_once(&fleet).await;
    let epochs: i64 =
        sqlx::query_scalar("SELECT count(*) FROM epochs").fetch_one(&mut stage.link().await).await.unwrap();
    assert_eq!(epochs, 2, "the fleet must stay with b");
    a.terminate().await;
    fleet.stop().await;
}

/// The former owner may have estimates ready when it is frozen.
#[tokio::test]
async fn an_estimate_of_a_former_owner_never_follows_one_of_the_next() {
    let stage = Stage::new().await;
    let mut observer = Observer::subscribed(stage.broker.port(), "observer", &["whisker/v1/f/one/estimate"]).await;
    let order = |heard: Heard| {
        let Message::Estimate(estimate) = heard.message else { return None };
        Some((estimate.epoch, estimate.version))
    };
    let mut a = stage.replica("a", "f", 2.5);
    until_true("a has it", async || stage.count_of("a").await == 1).await;
    let b = stage.replica("b", "f", 2.5);
    b.says(200, "STANDBY").await;
    let fleet = stage.fleet("f");
    let mut orders = vec![observer.expect("an estimate of a", order).await];
    a.process.signal(Signal::SIGSTOP);
    until_true("b has it", async || stage.count_of("b").await == 1).await;
    while orders.last().is_some_and(|last| last.0 == orders[0].0) {
        orders.push(observer.expect("an estimate of b", order).await);
    }
    a.process.signal(Signal::SIGCONT);
    a.says(200, "\"holder\":\"b\"").await;
    stage.more_recorded(200).await;
    fleet.rest();
    while let Some(heard) = observer.next(Duration::from_secs(2)).await {
        orders.extend(order(heard));
    }
    assert!(orders.is_sorted_by(|before, after| before < after), "{orders:?}");
    a.terminate().await;
    fleet.stop().await;
}

#[tokio::test]
async fn a_database_that_is_away_costs_nothing_and_readiness_says_so() {
    let mut stage = Stage::new().await;
    let a = stage.replica("a", "f", 2.0);
    a.says(200, "OWNED").await;
    let fleet = stage.fleet("f");
    stage.more_recorded(200).await;
    stage.server.kill();
    a.says(503, "database error: cannot").await;
    // Robots go on, and a robot that is new asks for a number meanwhile.
    let late = stage.fleet("f");
    late.stop().await;
    stage.server.restart().await;
    a.says(200, "OWNED").await;
    stage.more_recorded(200).await;
    stage.assert_each_contact_is_there_once(&fleet).await;
    fleet.stop().await;
}

/// After an outage one supervisor owns the fleet, and the other one is ready, too.
#[tokio::test]
async fn regress_all_supervisors_are_ready_again_after_an_outage() {
    let mut stage = Stage::new().await;
    let a = stage.replica("a", "f", 2.5);
    a.says(200, "OWNED").await;
    let b = stage.replica("b", "f", 2.5);
    b.says(200, "STANDBY").await;
    let fleet = stage.fleet("f");
    stage.more_recorded(100).await;
    stage.server.kill();
    a.says(503, "nothing is recorded").await;
    stage.server.restart().await;
    stage.more_recorded(100).await;
    a.says(200, "").await;
    b.says(200, "").await;
    stage.assert_each_contact_is_there_once(&fleet).await;
    fleet.stop().await;
}

#[tokio::test]
async fn a_supervisor_starts_without_its_server_and_goes_to_work_when_it_comes() {
    let mut stage = Stage::new().await;
    stage.server.kill();
    let a = stage.replica("a", "f", 2.0);
    a.says(503, "database").await;
    stage.server.restart().await;
    a.says(200, "OWNED").await;
}

/// Error message of the program when it cannot run.
fn refusal(folder: &Path, arguments: &[&str], environment: &[(&str, &str)]) -> String {
    let ended = std::process::Command::new(env!("CARGO_BIN_EXE_vibrissa-under-test"))
        .args(["run", "--mqtt-port", "0", "--http-listen", "127.0.0.1:0"])
        .args(arguments)
        .env("RUST_LOG", "off")
        .envs(environment.iter().copied())
        .current_dir(folder)
        .output()
        .unwrap();
    assert_eq!(ended.status.code(), Some(1));
    String::from_utf8(ended.stderr).unwrap()
}

#[tokio::test]
async fn a_second_supervisor_of_one_file_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let http = free_port();
    let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
    let listen = format!("127.0.0.1:{http}");
    let arguments =
        ["run", "--name", "press hall", "--database-url", &database, "--mqtt-port", "0", "--http-listen", &listen];
    let launch = Launch {
        program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
        arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
        environment: Vec::new(),
        log: folder.path().join("log"),
    };
    let mut first = Replica { process: Process::start(launch), http };
    first.says(200, "OWNED").await;
    let said = refusal(folder.path(), &["--database-url", &database], &[]);
    for part in ["supervisor \"press hall\" (process ", "v.sqlite3", "postgres://"] {
        assert!(said.contains(part), "{part} in {said}");
    }
    first.terminate().await;
}

#[tokio::test]
async fn a_server_that_refuses_is_named_without_the_password() {
    let server = Postgres::start().await;
    let folder = tempfile::tempdir().unwrap();
    let url = format!("postgres://vibrissa:S3cret@127.0.0.1:{}/nowhere", server.port());
    let said = refusal(folder.path(), &[], &[("VIBRISSA_DATABASE_URL", &url)]);
    assert!(said.contains("nowhere") && said.contains("does not exist"), "{said}");
    assert!(!said.contains("S3cret"), "{said}");
}

#[tokio::test]
async fn one_supervisor_with_a_file_has_several_fleets() {
    let broker = Mosquitto::start();
    let folder = tempfile::tempdir().unwrap();
    let address: DatabaseAddress = format!("sqlite:{}", folder.path().join("v.sqlite3").display()).parse().unwrap();
    let fleets = ["f1", "f2"].map(|fleet| Name::new(fleet).unwrap());
    let service = Service::start(ServiceOptions {
        kafka: vibrissa_supervisor::service::KafkaOptions::default(),
        access: vibrissa_supervisor::http::access::AccessOptions::default(),
        name: "s".to_owned(),
        fleets: fleets.to_vec(),
        database: address,
        is_new_installation: true,
        lease_time_to_live: LEASE_TIME_TO_LIVE,
        limits: vibrissa_supervisor::service::LimitOptions::default(),
        history: vibrissa_supervisor::service::HistoryOptions::default(),
        black_boxes: vibrissa_supervisor::service::BlackBoxOptions::default(),
        metrics_per_whisker: false,
        broker: Some(BrokerAddress::new("127.0.0.1", broker.port())),
        mqtt_port: 0,
        mqtt_access: vibrissa_supervisor::broker::MqttAccess::Open,
        http: ([127, 0, 0, 1], 0).into(),
        webhooks: vibrissa_supervisor::webhooks::WebhookOptions::default(),
        traces: None,
        params: vibrissa_tests::robot::params(),
    })
    .await
    .unwrap();
    let robots = fleets.each_ref().map(|fleet| start_fleet(fleet.as_str(), broker.port()));
    until_true("contacts of both", async || {
        let whiskers = service.store.all::<Whisker>(&WHISKERS, Vec::new()).await.unwrap();
        let touched = |fleet: &Name| whiskers.iter().any(|one| one.fleet == fleet.as_str() && one.contacts > 20);
        fleets.iter().all(touched)
    })
    .await;
    let standings = service.readiness.fleets();
    assert!(fleets.iter().all(|fleet| matches!(standings[&fleet.clone()], Standing::Owned { .. })), "{standings:?}");
    for fleet in robots {
        fleet.stop().await;
    }
    service.stop().await;
}
