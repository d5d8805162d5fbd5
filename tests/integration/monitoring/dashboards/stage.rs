//! A supervisor with a simulated fleet, its database, a Prometheus that scrapes it, and Grafana's database role.

use std::net::SocketAddr;
use std::path::PathBuf;
use std::process::Command;

use sqlx::postgres::PgConnection;
use sqlx::{ConnectOptions, Row};
use tempfile::TempDir;
use vibrissa_lab::demo::scenario;
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::{Broker, Fleet};
use vibrissa_tests::mosquitto::free_port;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::prometheus::Prometheus;
use vibrissa_tests::wait::{until, until_true};
use vibrissa_tests::web::try_get;

use super::expand::Chosen;

const SEED: u64 = 2021;
const PASSWORD: &str = "it's a \\ password";

/// All running programs, stopped on drop.
pub(super) struct Stage {
    pub(super) prometheus: Prometheus,
    pub(super) http: SocketAddr,
    pub(super) began_us: i64,
    fleet: Fleet,
    _program: Process,
    server: Postgres,
    _folder: TempDir,
}

impl Stage {
    /// Starts all programs and cuts whiskers until every metric has a value.
    pub(super) async fn new() -> Self {
        let (server, folder) = (Postgres::start().await, tempfile::tempdir().unwrap());
        let [mqtt, http] = [free_port(), free_port()];
        let program = Process::start(launch(&folder, &Postgres::url(server.port()), mqtt, http));
        let http = SocketAddr::from(([127, 0, 0, 1], http));
        until("the supervisor's readiness", async || {
            try_get(http, "/readyz").await.ok().filter(|(status, _)| *status == 200)
        })
        .await;
        let configuration = format!(
            "global: {{scrape_interval: 1s}}\nscrape_configs:\n- job_name: vibrissa\n  static_configs: [{{targets: ['{http}']}}]\n"
        );
        let prometheus = Prometheus::start(&configuration).await;
        // The time range of dashboards begins when the first series exist.
        until_true("the first scrape", async || value(&prometheus, "sum(vibrissa_trims_total)").await == Some(0.0))
            .await;
        let fleet = Fleet::start(&scenario::scenario(SEED).unwrap(), &Broker::new("127.0.0.1", mqtt)).unwrap();
        let began_us = now_us() as i64 - 2_000_000;
        let stage = Self { prometheus, http, began_us, fleet, _program: program, server, _folder: folder };
        stage.make_role(&folder_of_deployment());
        stage.wait().await;
        stage
    }

    /// Waits until Prometheus has scraped the last metric of a compensation.
    async fn wait(&self) {
        for (what, expression) in [
            ("trims that were found", "sum(vibrissa_trims_total) >= 2"),
            ("alarms", "sum(vibrissa_alarms_standing) > 0"),
            ("measured errors", "sum(vibrissa_compensation_error_ratio_count) > 0"),
            ("a look at a setpoint", "sum(increase(vibrissa_refinements_total[4s])) > 0"),
            // Dashboards query whole seconds, so the value must be older than one second.
            ("an error with a gain", "vibrissa_compensation_error_with_gain_mean_ratio offset 2s"),
        ] {
            until_true(what, async || {
                // Requests, which are metrics as well.
                let _ = try_get(self.http, "/v1/compensations").await;
                value(&self.prometheus, expression).await.is_some()
            })
            .await;
        }
    }

    /// Creates the role with the shipped script; twice, as after an update.
    fn make_role(&self, folder: &std::path::Path) {
        let password = self._folder.path().join("password");
        std::fs::write(&password, format!("{PASSWORD}\n")).unwrap();
        for _ in 0..2 {
            let ended = Command::new("psql")
                .args(["-X", "-q", "-f"])
                .arg(folder.join("postgres/grafana.sql"))
                .arg(Postgres::url(self.server.port()))
                .env("GRAFANA_PASSWORD_FILE", &password)
                .output()
                .expect("psql must be installed for this test");
            let said = String::from_utf8_lossy(&ended.stderr);
            assert!(ended.status.success() && said.is_empty(), "{said}");
        }
    }

    /// A connection with Grafana's role.
    pub(super) async fn grafana(&self) -> PgConnection {
        self.server.connect().username("grafana").password(PASSWORD).connect().await.unwrap()
    }

    /// A connection with the role of the database's owner.
    pub(super) async fn owner(&self) -> PgConnection {
        self.server.connect().connect().await.unwrap()
    }

    /// Stops the contacts of the fleet.
    pub(super) fn rest(&self) {
        self.fleet.rest();
    }

    /// Possible choices of the dashboards' variables: each whisker, one after the other.
    pub(super) async fn choices(&self) -> Vec<Chosen> {
        let query = "SELECT r.fleet, r.robot, a.\"array\", w.whisker::text FROM whiskers w JOIN arrays a USING (array_id) \
                     JOIN robots r ON r.robot_id = w.robot_id ORDER BY 1, 2, 3, 4";
        let rows = sqlx::query(query).fetch_all(&mut self.owner().await).await.unwrap();
        let to_us = now_us() as i64;
        let chosen = |row| {
            let part = |index: usize| vec![Row::get::<String, _>(row, index)];
            let all = || vec![".+".to_owned()];
            let variables = [("fleet", part(0)), ("robot", part(1)), ("array", part(2)), ("whisker", part(3))];
            let variables = variables.into_iter().chain([("job", all()), ("instance", all())]).collect();
            Chosen { variables, from_us: self.began_us, to_us }
        };
        rows.iter().map(chosen).collect()
    }
}

fn launch(folder: &TempDir, database: &str, mqtt: u16, http: u16) -> Launch {
    let (mqtt, http) = (mqtt.to_string(), format!("127.0.0.1:{http}"));
    let arguments = [
        ["--name", "hall-1"],
        ["--fleets", scenario::FLEET],
        ["--database-url", database],
        ["--mqtt-port", &mqtt],
        ["--http-listen", &http],
    ];
    let arguments = arguments.concat();
    Launch {
        program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
        arguments: [&["run"], arguments.as_slice()].concat().into_iter().map(ToOwned::to_owned).collect(),
        environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
        log: folder.path().join("log"),
    }
}

fn folder_of_deployment() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).parent().unwrap().join("deploy")
}

/// The first value of an expression at this moment.
async fn value(prometheus: &Prometheus, expression: &str) -> Option<f64> {
    let data = prometheus.ask("query", &[("query", expression)]).await.unwrap();
    data["result"][0]["value"][1].as_str()?.parse().ok()
}
