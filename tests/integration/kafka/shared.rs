//! Supervisors that share a PostgreSQL database and the partitions of the log.

use std::collections::BTreeSet;
use std::time::Duration;

use nix::sys::signal::Signal;
use sqlx::ConnectOptions;
use sqlx::postgres::PgConnection;
use vibrissa_protocol::{ArrayType, Contacts};
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::bridge::{MESSAGES, partition, records};
use crate::stage::Program;

const PARTITIONS: u32 = 2;

/// Robots of which each partition has some.
const ROBOTS: [&str; 4] = ["r0", "r1", "r2", "r3"];

async fn stored(database: &mut PgConnection) -> BTreeSet<(String, i64, i64)> {
    let sql = "SELECT b.boot_id, c.seq, c.position FROM contacts c JOIN boots b ON b.boot = c.boot";
    let rows: Vec<(String, i64, i64)> = sqlx::query_as(sql).fetch_all(&mut *database).await.unwrap();
    let count = rows.len();
    let all: BTreeSet<_> = rows.into_iter().collect();
    assert_eq!(all.len(), count, "each once");
    all
}

fn contacts(robot: &mut HandRobot, messages: usize) -> Vec<Contacts> {
    (0..messages)
        .map(|number| {
            let contacts = (0..20).map(|_| robot.contact((number % 3) as u16)).collect();
            robot.message(contacts)
        })
        .collect()
}

struct Rig {
    server: Postgres,
    kafka: Kafka,
    broker: Mosquitto,
    robots: Vec<HandRobot>,
}

impl Rig {
    async fn start(partitions: u32) -> Option<Self> {
        let kafka = Kafka::start(1).await?;
        kafka.create_topic(MESSAGES, partitions).await;
        let (server, broker) = (Postgres::start_with_supervisor().await, Mosquitto::start());
        Some(Self { server, kafka, broker, robots: Vec::new() })
    }

    async fn supervisor(&self, name: &str, more: &[&str]) -> Program {
        let database = Postgres::supervisor_url(self.server.port());
        let url = self.kafka.url();
        let own = ["--name", name, "--database-url", &database, "--ingest", "kafka", "--kafka-url", &url];
        Program::of_database(self.broker.port(), &[&own, more].concat()).await
    }

    /// Connects the robots, and waits until all are known.
    async fn robots(&mut self, program: &Program) {
        for name in ROBOTS {
            let mut robot =
                HandRobot::connect(self.broker.port(), name, array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await;
            robot.birth().await;
            self.robots.push(robot);
        }
        until_true("known robots", async || program.list("whiskers").await.len() == 3 * ROBOTS.len()).await;
    }

    /// Writes contacts of all robots into the log; returns their names.
    async fn write(&mut self, messages: usize, partitions: u32) -> BTreeSet<(String, i64, i64)> {
        let mut all = BTreeSet::new();
        for (name, robot) in ROBOTS.iter().zip(&mut self.robots) {
            let sent = contacts(robot, messages);
            for message in &sent {
                let name = |position| (message.boot_id.as_str().to_owned(), message.seq as i64, position);
                all.extend((0..message.contacts.len() as i64).map(name));
            }
            for some in sent.chunks(200) {
                self.kafka.write(MESSAGES, partition(name, partitions), records(name, some)).await;
            }
        }
        all
    }

    async fn database(&self) -> PgConnection {
        self.server.connect().connect().await.unwrap()
    }
}

#[tokio::test]
async fn chaos_partitions_of_a_killed_supervisor_go_on_at_the_stored_positions() {
    let Some(mut rig) = Rig::start(PARTITIONS).await else { return };
    let mut first = rig.supervisor("a", &[]).await;
    let mut second = rig.supervisor("b", &[]).await;
    rig.robots(&first).await;
    let mut expected = BTreeSet::new();
    let mut database = rig.database().await;
    for round in 0..4 {
        expected.extend(rig.write(30, PARTITIONS).await);
        let victim = if round % 2 == 0 { &mut first } else { &mut second };
        victim.process.kill();
        expected.extend(rig.write(30, PARTITIONS).await);
        until_true("all contacts at the other supervisor", async || stored(&mut database).await == expected).await;
        victim.process.restart();
        victim.answers().await;
    }
    let used: Vec<(i64, i64)> = sqlx::query_as(
        "SELECT w.whisker_id, count(*) FROM whiskers w JOIN contacts c USING (whisker_id) \
         WHERE c.used IN ('USED', 'LEARNING') GROUP BY 1 ORDER BY 1",
    )
    .fetch_all(&mut database)
    .await
    .unwrap();
    assert_eq!(used.len(), 3 * ROBOTS.len());
    drop((first, second));
}

#[tokio::test]
async fn a_contact_costs_at_most_10_bytes_of_wal_if_none_is_kept() {
    let Some(mut rig) = Rig::start(1).await else { return };
    let mut program = rig.supervisor("a", &["--contacts-keep", "none"]).await;
    rig.robots(&program).await;
    let mut database = rig.database().await;
    let lsn = async |database: &mut PgConnection| -> i64 {
        let sql = "SELECT (pg_current_wal_lsn() - '0/0'::pg_lsn)::bigint";
        sqlx::query_scalar(sql).fetch_one(database).await.unwrap()
    };
    let position = async |database: &mut PgConnection| -> i64 {
        let next: Option<i64> = sqlx::query_scalar("SELECT log_next FROM leases").fetch_one(database).await.unwrap();
        next.unwrap_or_default()
    };
    // The first checkpoints after a start, and the pages' first changes.
    rig.write(50, 1).await;
    until_true("the first records", async || position(&mut database).await >= 200).await;
    sqlx::query("CHECKPOINT").execute(&mut database).await.unwrap();
    let before = lsn(&mut database).await;
    let contacts = rig.write(4000, 1).await.len();
    until_true("all records", async || position(&mut database).await >= 200 + 16_000).await;
    // The orderly end writes the checkpoints that have waited.
    program.process.signal(Signal::SIGTERM);
    let ended = program.process.ended(Duration::from_secs(20)).await;
    assert!(ended.is_some_and(|status| status.success()));
    let bytes = lsn(&mut database).await - before;
    let each = bytes as f64 / contacts as f64;
    eprintln!("{bytes} bytes of WAL for {contacts} contacts: {each:.2} each");
    assert!(each <= 10.0, "{each:.2} bytes of WAL for each contact");
}
