//! An owner that cannot receive its fleet's messages gives the fleet up to a supervisor that can. Secrets are read
//! again without a restart.

use std::path::{Path, PathBuf};

use sqlx::ConnectOptions;
use tempfile::TempDir;
use vibrissa_protocol::ArrayType;
use vibrissa_tests::certificates::write;
use vibrissa_tests::mosquitto::{Builder, Mosquitto};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::listener::Supervised;

const GOOD: &str = "correct-horse-battery-staple";

/// A broker with the user `vibrissa`, a database server, and a folder.
struct Stage {
    broker: Mosquitto,
    server: Postgres,
    folder: TempDir,
}

impl Stage {
    async fn new(broker: Builder) -> Self {
        Self { broker: broker.start(), server: Postgres::start().await, folder: tempfile::tempdir().unwrap() }
    }

    /// Starts a broker that requires a password from `vibrissa`; the robots of [`HandRobot`] connect anonymously.
    async fn with_passwords() -> Self {
        Self::new(Mosquitto::builder().user("vibrissa", GOOD).line("allow_anonymous true")).await
    }

    fn password(&self, name: &str, password: &str) -> PathBuf {
        write(self.folder.path(), name, password)
    }

    fn supervisor(&self, name: &str, password_file: &Path) -> Supervised {
        let url = format!("mqtt://127.0.0.1:{}", self.broker.port());
        let database = Postgres::url(self.server.port());
        let password_file = password_file.display().to_string();
        let arguments = [
            ["--fleet", "f"],
            ["--mqtt-url", &url],
            ["--mqtt-username", "vibrissa"],
            ["--mqtt-password-file", &password_file],
            ["--mqtt-deaf-release-after-s", "2"],
            ["--database-url", &database],
        ];
        Supervised::start(self.folder.path(), name, &arguments.concat())
    }

    async fn number(&self, sql: &'static str) -> i64 {
        let mut link = self.server.connect().connect().await.unwrap();
        sqlx::query_scalar(sql).fetch_one(&mut link).await.unwrap()
    }

    /// Number of times that the fleet was acquired.
    async fn epochs(&self) -> i64 {
        self.number("SELECT count(*) FROM epochs").await
    }

    /// Number of supervisors that report this fleet as not heard.
    async fn deaf(&self) -> i64 {
        self.number("SELECT count(*) FROM supervisors WHERE deaf = 'f' AND alive_us > clock_us()").await
    }

    fn refused(&self) -> usize {
        self.broker.logged("not authorised")
    }
}

fn words<const N: usize>(words: [&str; N]) -> [String; N] {
    words.map(str::to_owned)
}

#[tokio::test]
async fn regress_an_owner_with_a_wrong_password_gives_way_and_takes_the_fleet_again_once_it_hears() {
    let stage = Stage::with_passwords().await;
    let (file_a, file_b) = (stage.password("a.password", "wrong"), stage.password("b.password", GOOD));
    let mut a = stage.supervisor("a", &file_a);
    a.says(false, &words(["OWNED", "mqtt.password_file"])).await;
    until_true("a says that it is deaf", async || stage.deaf().await == 1).await;
    assert_eq!(stage.epochs().await, 1, "without another supervisor it must keep the fleet");
    let mut b = stage.supervisor("b", &file_b);
    b.says(true, &words(["OWNED"])).await;
    a.says(false, &words(["\"holder\":\"b\"", "released, because its robots were not heard", "mqtt.password_file"]))
        .await;
    let mut robot = HandRobot::born(stage.broker.port(), "r", array(ArrayType::Type1, &[70.0, 65.0])).await;
    robot.touch(0, 5).await;
    robot.receipted().await;
    // Supervisor `a` keeps trying, but does not acquire the fleet while it cannot receive messages.
    let refused = stage.refused();
    until_true("three trials", async || stage.refused() >= refused + 3).await;
    assert_eq!((stage.epochs().await, stage.deaf().await), (2, 1));
    b.says(true, &words(["OWNED"])).await;
    // Not even without any other supervisor.
    b.terminate().await;
    let refused = stage.refused();
    until_true("three trials", async || stage.refused() >= refused + 3).await;
    assert_eq!(stage.epochs().await, 2);
    // The correct password is read without a restart.
    stage.password("a.password", GOOD);
    a.says(true, &words(["OWNED"])).await;
    assert_eq!((stage.epochs().await, stage.deaf().await), (3, 0));
    robot.touch(0, 5).await;
    robot.receipted().await;
    a.terminate().await;
}

#[tokio::test]
async fn regress_an_owner_whose_password_is_corrected_is_heard_without_a_restart() {
    let stage = Stage::with_passwords().await;
    let file = stage.password("a.password", "wrong");
    let mut a = stage.supervisor("a", &file);
    a.says(false, &words(["OWNED", "mqtt.password_file"])).await;
    stage.password("a.password", GOOD);
    a.says(true, &words(["OWNED"])).await;
    assert_eq!(stage.epochs().await, 1);
    a.terminate().await;
}

#[tokio::test]
async fn a_fleet_that_nobody_hears_stays_where_it_is() {
    let mut stage = Stage::with_passwords().await;
    let file = stage.password("password", GOOD);
    let mut a = stage.supervisor("a", &file);
    a.says(true, &words(["OWNED"])).await;
    let mut b = stage.supervisor("b", &file);
    b.says(true, &words(["STANDBY"])).await;
    stage.broker.kill();
    until_true("the owner says that it is deaf", async || stage.deaf().await == 1).await;
    // The other one tries, in vain.
    until_true("a trial", async || b.logged("testing whether the fleet can be heard") >= 1).await;
    assert_eq!(stage.epochs().await, 1);
    stage.broker.restart();
    a.says(true, &[]).await;
    // The supervisor that is connected first owns the fleet now.
    until_true("no supervisor reports the fleet as not heard", async || stage.deaf().await == 0).await;
    a.terminate().await;
    b.terminate().await;
}

/// PostgreSQL requires a password, which changes while the supervisor runs.
#[tokio::test]
async fn regress_a_new_password_of_the_database_is_read_without_a_restart() {
    let (server, folder) = (Postgres::start().await, tempfile::tempdir().unwrap());
    let mut link = server.connect().connect().await.unwrap();
    let access: String = sqlx::query_scalar("SHOW hba_file").fetch_one(&mut link).await.unwrap();
    let before = std::fs::read_to_string(&access).unwrap();
    std::fs::write(&access, format!("host all lodger 127.0.0.1/32 scram-sha-256\n{before}")).unwrap();
    for sql in
        ["CREATE ROLE lodger LOGIN PASSWORD 'first'", "CREATE DATABASE lodging OWNER lodger", "SELECT pg_reload_conf()"]
    {
        sqlx::query(sql).execute(&mut link).await.unwrap();
    }
    let file = write(folder.path(), "password", "first");
    let database = format!("postgres://lodger@127.0.0.1:{}/lodging", server.port());
    let file_name = file.display().to_string();
    let arguments = ["--mqtt-port", "0", "--database-url", &database, "--database-password-file", &file_name];
    let mut supervisor = Supervised::start(folder.path(), "s", &arguments);
    supervisor.says(true, &words(["OWNED"])).await;
    sqlx::query("ALTER ROLE lodger PASSWORD 'second'").execute(&mut link).await.unwrap();
    sqlx::query("SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE usename = 'lodger'")
        .execute(&mut link)
        .await
        .unwrap();
    supervisor.says(false, &words(["password authentication failed"])).await;
    // After more attempts the outage is still logged only once.
    let errors = supervisor.metric("vibrissa_database_errors_total", "").await;
    until_true("more attempts", async || supervisor.metric("vibrissa_database_errors_total", "").await >= errors + 4.0)
        .await;
    write(folder.path(), "password", "second");
    supervisor.says(true, &words(["OWNED"])).await;
    assert_eq!(supervisor.logged("cannot renew the leases"), 1);
    assert_eq!(supervisor.logged("leases renewed again"), 1);
    assert!(!supervisor.log().contains('\x1b'), "colours in a file");
    supervisor.terminate().await;
}
