//! Supervisors that share a PostgreSQL database, and a topic of the log.

use std::collections::{BTreeMap, BTreeSet};
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

const PARTITIONS: u32 = 5;
/// Robots of which each partition has some.
const ROBOTS: [&str; 10] = ["r0", "r1", "r2", "r3", "r4", "r5", "r6", "r7", "r8", "r9"];

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
    names: &'static [&'static str],
    robots: Vec<HandRobot>,
}

impl Rig {
    async fn start(partitions: u32, names: &'static [&'static str]) -> Option<Self> {
        let kafka = Kafka::start(1).await?;
        kafka.create_topic(MESSAGES, partitions).await;
        let (server, broker) = (Postgres::start_with_supervisor().await, Mosquitto::start());
        Some(Self { server, kafka, broker, names, robots: Vec::new() })
    }

    async fn supervisor(&self, name: &str, more: &[&str]) -> Program {
        let database = Postgres::supervisor_url(self.server.port());
        let url = self.kafka.url();
        let own = ["--name", name, "--database-url", &database, "--ingest", "kafka", "--kafka-url", &url];
        Program::of_database(self.broker.port(), &[&own, more].concat()).await
    }

    /// Connects the robots, and waits until all are known.
    async fn robots(&mut self, program: &Program) {
        for name in self.names {
            let mut robot =
                HandRobot::connect(self.broker.port(), name, array(ArrayType::Type1, &[70.0, 68.0, 65.0])).await;
            robot.birth().await;
            self.robots.push(robot);
        }
        until_true("known robots", async || program.list("whiskers").await.len() == 3 * self.names.len()).await;
    }

    /// Writes contacts of all robots into the log; returns their names.
    async fn write(&mut self, messages: usize, partitions: u32) -> BTreeSet<(String, i64, i64)> {
        let mut all = BTreeSet::new();
        for (name, robot) in self.names.iter().zip(&mut self.robots) {
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

/// Asserts that the positions are those of the contacts in the same snapshot: each record has 20 contacts, and each
/// commit moves both.
async fn positions_are_of_the_contacts(database: &mut PgConnection) {
    let sql = "SELECT r.robot, NULL, count(*) FROM contacts c JOIN whiskers USING (whisker_id) JOIN robots r USING (robot_id) \
         GROUP BY 1 UNION ALL SELECT NULL, log_partition, next FROM log_positions";
    let rows: Vec<(Option<String>, Option<i64>, i64)> = sqlx::query_as(sql).fetch_all(database).await.unwrap();
    let (mut recorded, mut positions) = (BTreeMap::new(), BTreeMap::new());
    for (robot, of_partition, count) in rows {
        if let Some(robot) = robot {
            *recorded.entry(i64::from(partition(&robot, PARTITIONS))).or_insert(0) += count;
        }
        positions.extend(of_partition.map(|of_partition| (of_partition, 20 * count)));
    }
    assert_eq!(positions, recorded);
}

/// Each whisker: number of contacts and length in its state, and the same by its rows.
async fn states_and_rows(database: &mut PgConnection) -> Vec<((i64, f64), (i64, f64))> {
    let sql = "SELECT w.contacts, w.length_mm, (SELECT count(*) FROM contacts c WHERE c.whisker_id = w.whisker_id \
         AND c.used IN ('USED', 'LEARNING')), (SELECT c.length_mm FROM contacts c WHERE c.whisker_id = w.whisker_id \
         ORDER BY seq DESC, position DESC LIMIT 1) FROM whiskers w";
    let rows: Vec<(i64, f64, i64, f64)> = sqlx::query_as(sql).fetch_all(database).await.unwrap();
    rows.into_iter().map(|(contacts, mm, rows, rows_mm)| ((contacts, mm), (rows, rows_mm))).collect()
}

/// The owner of the fleet: 0 for `a`, 1 for `b`.
async fn owner(database: &mut PgConnection) -> usize {
    let holder: String = sqlx::query_scalar("SELECT holder FROM leases").fetch_one(database).await.unwrap();
    ["a", "b"].iter().position(|name| *name == holder).unwrap()
}

#[tokio::test]
async fn chaos_a_killed_owner_of_five_partitions_is_followed_at_all_positions() {
    let Some(mut rig) = Rig::start(PARTITIONS, &ROBOTS).await else { return };
    let used: BTreeSet<u32> = ROBOTS.iter().map(|robot| partition(robot, PARTITIONS)).collect();
    assert_eq!(used.len(), PARTITIONS as usize, "each partition has a robot");
    let mut supervisors = [rig.supervisor("a", &[]).await, rig.supervisor("b", &[]).await];
    rig.robots(&supervisors[0]).await;
    let mut expected = BTreeSet::new();
    let mut database = rig.database().await;
    for _ in 0..4 {
        expected.extend(rig.write(30, PARTITIONS).await);
        let victim = owner(&mut database).await;
        positions_are_of_the_contacts(&mut database).await;
        supervisors[victim].process.kill();
        positions_are_of_the_contacts(&mut database).await;
        expected.extend(rig.write(30, PARTITIONS).await);
        until_true("all contacts at the other supervisor", async || {
            positions_are_of_the_contacts(&mut database).await;
            stored(&mut database).await == expected
        })
        .await;
        supervisors[victim].process.restart();
        supervisors[victim].answers().await;
    }
    // The orderly end writes the states that the last owner has replayed and stepped.
    let last = owner(&mut database).await;
    supervisors[1 - last].process.kill();
    supervisors[last].process.signal(Signal::SIGTERM);
    let ended = supervisors[last].process.ended(Duration::from_secs(20)).await;
    assert!(ended.is_some_and(|status| status.success()));
    let whiskers = states_and_rows(&mut database).await;
    assert_eq!(whiskers.len(), 3 * ROBOTS.len());
    for (state, rows) in whiskers {
        assert_eq!(state, rows, "the state is that after the last contact, to the last bit");
    }
}

#[tokio::test]
async fn a_contact_costs_at_most_10_bytes_of_wal_if_none_is_kept() {
    let Some(mut rig) = Rig::start(1, &ROBOTS[..4]).await else { return };
    let mut program = rig.supervisor("a", &["--contacts-keep", "none"]).await;
    rig.robots(&program).await;
    let mut database = rig.database().await;
    let lsn = async |database: &mut PgConnection| -> i64 {
        let sql = "SELECT (pg_current_wal_lsn() - '0/0'::pg_lsn)::bigint";
        sqlx::query_scalar(sql).fetch_one(database).await.unwrap()
    };
    let position = async |database: &mut PgConnection| -> i64 {
        let sql = "SELECT next FROM log_positions";
        let next: Option<i64> = sqlx::query_scalar(sql).fetch_optional(database).await.unwrap();
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
