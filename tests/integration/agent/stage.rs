//! A broker, a supervisor, a proxy between broker and agent, and an agent, each as a process.

use std::fs;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection};
use sqlx::{AssertSqlSafe, Connection};
use tempfile::TempDir;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::wait::until_true;
use vibrissa_tests::web::{send, try_get};

/// Program of the agent: that of this build, or another one, such as one for another processor with its emulator.
pub(crate) fn agent_program() -> PathBuf {
    std::env::var_os("ROBOT_PROGRAM_UNDER_TEST")
        .map_or_else(|| env!("CARGO_BIN_EXE_robot-under-test").into(), PathBuf::from)
}

/// Program of the simulated board.
pub(crate) const BOARD: &str = env!("CARGO_BIN_EXE_simulator-under-test");

/// Writes a scenario for the board: one array with two whiskers, which are touched so often.
pub(crate) fn scenario(folder: &Path, contacts_per_second: f64) -> PathBuf {
    let path = folder.join("scenario.toml");
    let text = format!(
        "fleet = \"f\"\nseed = 1\n[behaviour]\ncontacts_per_second = {contacts_per_second:?}\n[[robots]]\nrobot = \"r\"\n\
         [[robots.arrays]]\narray = \"left\"\ntype = \"TYPE_1\"\nwhiskers = [{{ whisker = 0 }}, {{ whisker = 1 }}]\n"
    );
    fs::write(&path, text).unwrap();
    path
}

/// The configuration of an agent of robot `r`; `driver` is the content of its section.
pub(crate) fn configuration(port: u16, driver: &str) -> String {
    placed(port, driver, "RATIO")
}

/// The same, with the place of contacts.
fn placed(port: u16, driver: &str, place: &str) -> String {
    let whisker = "length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2";
    format!(
        "fleet = \"f\"\nrobot = \"r\"\ntouch_tests = [\"WALL\"]\n[broker]\nurl = \"mqtt://127.0.0.1:{port}\"\n\
         [outbox]\nfile = \"outbox\"\n[supervisor]\nstatus_every_s = 1.0\n[driver]\nsilent_s = 1.5\n{driver}\n\
         [[arrays]]\narray = \"left\"\ntype = \"TYPE_1\"\n\
         whiskers = [{{ whisker = 0, {whisker}, place = {place:?} }}, {{ whisker = 1, {whisker}, place = {place:?} }}]\n"
    )
}

/// An agent with this configuration in a folder.
pub(crate) fn agent(folder: &Path, configuration: &str) -> Process {
    let path = folder.join("agent.toml");
    fs::write(&path, configuration).unwrap();
    Process::start(Launch {
        program: agent_program(),
        arguments: vec!["--config".to_owned(), path.display().to_string()],
        environment: vec![],
        log: folder.join("agent.log"),
    })
}

/// The section of a driver that is the board as a child process, which sends samples of strain; touches are at the tip.
pub(crate) fn sampling_board(folder: &Path, contacts_per_second: f64) -> String {
    let (path, log) = (scenario(folder, contacts_per_second), folder.join("board.log"));
    let text = fs::read_to_string(&path).unwrap().replace("[behaviour]", "[behaviour]\nplaces = \"TIP\"");
    fs::write(&path, text).unwrap();
    format!("command = [{BOARD:?}, \"board\", \"--strain\", \"--scenario\", {path:?}, \"--log-file\", {log:?}]")
}

/// The section of a driver that is the board as a child process, with its log `board.log`.
pub(crate) fn board_as_child(folder: &Path, contacts_per_second: f64) -> String {
    let (scenario, log) = (scenario(folder, contacts_per_second), folder.join("board.log"));
    format!("command = [{BOARD:?}, \"board\", \"--scenario\", {scenario:?}, \"--log-file\", {log:?}]")
}

/// All processes of one test.
pub(crate) struct Stage {
    pub(crate) agent: Process,
    pub(crate) supervisor: Process,
    pub(crate) proxy: Proxy,
    http: SocketAddr,
    _broker: Mosquitto,
    pub(crate) folder: TempDir,
}

impl Stage {
    /// Starts all, with a driver whose section `driver` writes for the folder of the stage.
    pub(crate) async fn start(driver: impl FnOnce(&Path) -> String) -> Self {
        Self::start_placed(driver, "RATIO").await
    }

    /// The same, with the place of contacts.
    pub(crate) async fn start_placed(driver: impl FnOnce(&Path) -> String, place: &str) -> Self {
        let (folder, broker) = (tempfile::tempdir().unwrap(), Mosquitto::start());
        let proxy = Proxy::to(broker.port()).await;
        let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
        let database = format!("sqlite:{}", folder.path().join("v.sqlite3").display());
        let (listen, url) = (http.to_string(), format!("mqtt://127.0.0.1:{}", broker.port()));
        let arguments =
            ["run", "--fleet", "f", "--http-listen", &listen, "--mqtt-url", &url, "--database-url", &database];
        let supervisor = Process::start(Launch {
            program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
            arguments: arguments.iter().map(|&argument| argument.to_owned()).collect(),
            environment: vec![("RUST_LOG".to_owned(), "warn".to_owned())],
            log: folder.path().join("supervisor.log"),
        });
        let agent = agent(folder.path(), &placed(proxy.port(), &driver(folder.path()), place));
        let stage = Self { agent, supervisor, proxy, http, _broker: broker, folder };
        stage.is_ready().await;
        stage
    }

    /// Waits until the supervisor is ready.
    pub(crate) async fn is_ready(&self) {
        until_true("a supervisor that is ready", async || {
            try_get(self.http, "/readyz").await.is_ok_and(|(status, _)| status == 200)
        })
        .await;
    }

    /// A whisker as the supervisor's API shows it.
    pub(crate) async fn whisker(&self, number: u16) -> Option<Value> {
        let path = format!("/v1/fleets/f/robots/r/arrays/left/whiskers/{number}");
        let (status, body) = try_get(self.http, &path).await.ok()?;
        if status == 200 { serde_json::from_str(&body).ok() } else { None }
    }

    /// Sets the pressure of a whisker as an operator, once the supervisor regards the robot as online.
    pub(crate) async fn set_by_hand(&self, number: u16, pressure_mpa: f64) {
        let path = format!("/v1/fleets/f/robots/r/arrays/left/whiskers/{number}/setpoint");
        let body = json!({ "pressure_mpa": pressure_mpa, "reason": "a test" });
        until_true("a robot that can be set", async || {
            let answer = send(self.http, "POST", &path, &[], Some(&body)).await.unwrap();
            assert!([2, 4].contains(&(answer.status / 100)), "{}", answer.body);
            answer.status / 100 == 2
        })
        .await;
    }

    async fn database(&self) -> SqliteConnection {
        let options = SqliteConnectOptions::new().filename(self.folder.path().join("v.sqlite3")).read_only(true);
        SqliteConnection::connect_with(&options).await.unwrap()
    }

    /// Result of a query for one number.
    pub(crate) async fn number(&self, sql: &'static str) -> i64 {
        sqlx::query_scalar(sql).fetch_one(&mut self.database().await).await.unwrap()
    }

    /// Whisker and time of each recorded contact, in the order of their times.
    pub(crate) async fn recorded(&self) -> Vec<(i64, i64)> {
        let sql = "SELECT w.whisker, c.t_us FROM contacts c JOIN whiskers w USING (whisker_id) ORDER BY 2, 1";
        sqlx::query_as(sql).fetch_all(&mut self.database().await).await.unwrap()
    }

    /// Boot, number, position and time of the contacts of these times.
    pub(crate) async fn rows_of(&self, times_us: &[i64]) -> String {
        let times: Vec<String> = times_us.iter().map(i64::to_string).collect();
        let sql = format!(
            "SELECT b.boot_id || ' ' || seq || '.' || position || ' ' || t_us FROM contacts c JOIN boots b USING (boot) \
             WHERE t_us IN ({}) ORDER BY t_us, seq",
            times.join(", ")
        );
        let rows: Vec<String> =
            sqlx::query_scalar(AssertSqlSafe(sql)).fetch_all(&mut self.database().await).await.unwrap();
        rows.join("; ")
    }

    /// Lines of the board's log.
    pub(crate) fn board_log(&self) -> Vec<Value> {
        let text = fs::read_to_string(self.folder.path().join("board.log")).unwrap_or_default();
        // The board may be writing its last line.
        text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }

    /// Whisker and time of each contact that the board has made.
    pub(crate) fn felt(&self) -> Vec<(i64, i64)> {
        let log = self.board_log();
        let contacts = log.iter().filter(|line| line["log"] == "contact");
        contacts.map(|line| (line["whisker"].as_i64().unwrap(), line["t_us"].as_i64().unwrap())).collect()
    }

    /// Process id of the newest board.
    pub(crate) fn board_pid(&self) -> Option<i32> {
        let started = self.board_log().into_iter().rev().find(|line| line["log"] == "started")?;
        i32::try_from(started["pid"].as_i64()?).ok()
    }

    /// Log of the agent.
    pub(crate) fn agent_log(&self) -> String {
        fs::read_to_string(self.folder.path().join("agent.log")).unwrap_or_default()
    }
}

impl Drop for Stage {
    /// A failed test shows what the programs have logged.
    fn drop(&mut self) {
        if std::thread::panicking() {
            for file in ["agent.log", "supervisor.log", "outbox"] {
                let text = fs::read_to_string(self.folder.path().join(file)).unwrap_or_default();
                let lines: Vec<&str> = text.lines().collect();
                let last = &lines[lines.len().saturating_sub(60)..];
                println!("{file}:");
                last.iter().for_each(|line| println!("{}", line.chars().take(240).collect::<String>()));
            }
        }
    }
}
