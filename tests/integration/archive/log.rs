//! The archive from Kafka: two shards, repeated records, supervisors that are killed, and a log that loses records.

use std::sync::Arc;

use sqlx::ConnectOptions;
use sqlx::postgres::PgConnectOptions;
use vibrissa_edge::shard::robot_hash;
use vibrissa_protocol::{ArrayType, RobotTopic, encode};
use vibrissa_tests::kafka::{Bridge, BridgeOptions, Kafka, record_of};
use vibrissa_tests::oracle::ledger::Verdict;
use vibrissa_tests::oracle::recorded;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_within;

use crate::reading::Archive;
use crate::stage::{FLEET, LONG, Stage, Supervisor};

const TOPIC: &str = "vibrissa.messages";
const SHARDS: u32 = 2;

/// Positions of all shards together.
#[derive(Debug)]
struct Positions {
    /// Number of shards that write a file now.
    planned: i64,
    files: i64,
    /// Records that the supervisors have handled, and that are not archived.
    behind: i64,
}

async fn positions(database: &PgConnectOptions) -> Option<Positions> {
    const SQL: &str = "SELECT count(planned_to) AS planned, coalesce(sum(files), 0)::bigint AS files, \
         coalesce(sum(log_next - next_offset), 1)::bigint AS behind FROM leases LEFT JOIN log_archives USING (fleet, shard)";
    let mut connection = database.connect().await.ok()?;
    let (planned, files, behind) = sqlx::query_as(SQL).fetch_one(&mut connection).await.ok()?;
    Some(Positions { planned, files, behind })
}

async fn until_position(database: &PgConnectOptions, what: &str, holds: impl Fn(&Positions) -> bool) -> Positions {
    until_within(LONG, what, async || positions(database).await.filter(|at| holds(at))).await
}

struct Rig {
    // Dropped before the broker and Kafka, which it uses.
    bridge: Option<Bridge>,
    kafka: Arc<Kafka>,
    server: Postgres,
    folder: tempfile::TempDir,
    stage: Stage,
}

impl Rig {
    /// Starts all but the supervisors; `None`, with a line on standard error, if Kafka is not installed.
    async fn start(contacts_keep: &str) -> Option<Self> {
        let kafka = Arc::new(Kafka::start(1).await?);
        kafka.create_topic(TOPIC, SHARDS).await;
        let server = Postgres::start_with_supervisor().await;
        let folder = tempfile::tempdir().unwrap();
        let (archive, url) = (format!("file://{}", folder.path().display()), kafka.url());
        let shards = SHARDS.to_string();
        let further = ["--ingest", "kafka", "--kafka-url", &url, "--fleet-shards", &shards, "--contacts-keep"];
        let archive = [contacts_keep, "--archive-source", "kafka", "--archive-url", &archive];
        let stage = Stage::start(Some(Postgres::supervisor_url(server.port())), &[&further[..], &archive[..]].concat());
        Some(Self { kafka, server, folder, stage, bridge: None })
    }

    /// The same with a bridge for all robots.
    async fn start_with_bridge(contacts_keep: &str) -> Option<Self> {
        let mut rig = Self::start(contacts_keep).await?;
        let options = BridgeOptions {
            mqtt: rig.stage.broker.port(),
            topic: TOPIC,
            partitions: SHARDS,
            fleet: FLEET,
            robots: (0..4).map(|robot| format!("r{robot}")).collect(),
            repeats: true,
        };
        rig.bridge = Some(Bridge::start(&rig.kafka, options).await);
        Some(rig)
    }

    /// Stops the contacts, waits until all are archived, and compares the files with the robots' record.
    async fn end(self) -> (Verdict, Archive, Postgres) {
        self.stage.robots.rest();
        let undelivered = async || (self.stage.robots.undelivered() == 0).then_some(());
        until_within(LONG, "receipts of all messages", undelivered).await;
        let is_done = |at: &Positions| at.planned == 0 && at.behind <= 0;
        until_position(&self.server.connect(), "the last record in a file", is_done).await;
        let mut truth = self.stage.robots.stop().await;
        let archive = Archive::read(self.folder.path());
        archive.compare(&mut truth.ledger);
        (truth.ledger.verdict(), archive, self.server)
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn supervisors_are_killed_while_they_archive_the_log_and_each_contact_is_in_one_file() {
    let Some(rig) = Rig::start_with_bridge("none").await else { return };
    let database = rig.server.connect();

    // The first one dies when its first file is written, and the position not yet advanced.
    let mut first = rig.stage.supervisor("first", Some("death_after_upload"));
    until_within(LONG, "the death of the first supervisor", async || first.process.ended_already()).await;
    let mut second = rig.stage.supervisor("second", None);
    let before = until_position(&database, "a file of the second one", |at| at.files > 0).await.files;

    // It is killed with kill -9 whenever a file is planned.
    for turn in 0..4 {
        until_position(&database, "a plan", |at| at.planned > 0).await;
        second.process.kill();
        second.process.restart();
        until_position(&database, "a file after a kill", |at| at.files > before + turn).await;
    }
    let log = second.log();
    let (verdict, archive, server) = rig.end().await;
    println!("{verdict:?} in {} files", archive.files);
    assert_eq!((verdict.missing, verdict.duplicate, verdict.wrong), (0, 0, 0), "{verdict:?}\n{log}");
    assert!(verdict.felt > 300, "{verdict:?}");
    let mut connection = server.connect().connect().await.unwrap();
    assert_eq!(recorded::count(&mut connection, &[]).await.unwrap(), 0, "the database keeps no contact");
    let (files, contacts): (i64, i64) =
        sqlx::query_as("SELECT sum(files)::bigint, sum(contacts)::bigint FROM log_archives")
            .fetch_one(&mut connection)
            .await
            .unwrap();
    assert_eq!((files, contacts), (archive.files as i64, archive.contacts() as i64));
}

#[tokio::test(flavor = "multi_thread")]
async fn an_archive_waits_for_kafka_and_nothing_else_does() {
    let Some(rig) = Rig::start_with_bridge("all").await else { return };
    let database = rig.server.connect();
    let supervisor = rig.stage.supervisor("one", None);
    let before = until_position(&database, "files of both shards", |at| at.files > 2).await.files;
    rig.kafka.freeze(0, true);
    until_within(LONG, "failed attempts", async || {
        supervisor.metric("vibrissa_archive_errors_total").await.filter(|&errors| errors > 0.0)
    })
    .await;
    rig.kafka.freeze(0, false);
    until_position(&database, "files after the outage", |at| at.files > before + 2).await;
    let (verdict, ..) = rig.end().await;
    assert_eq!((verdict.missing, verdict.duplicate, verdict.wrong), (0, 0, 0), "{verdict:?}\n{}", supervisor.log());
}

/// Waits until the archive has written further files after a loss, then ends. The archive may lack contacts, but has none
/// twice; the database has all of them.
async fn only_the_archive_lacks_contacts(rig: Rig, supervisor: Supervisor) {
    let database = rig.server.connect();
    let before = positions(&database).await.unwrap().files;
    until_position(&database, "files after the loss", |at| at.files > before + 2).await;
    let log = supervisor.log();
    let (verdict, _, server) = rig.end().await;
    println!("{verdict:?}");
    assert_eq!((verdict.duplicate, verdict.wrong), (0, 0), "{verdict:?}\n{log}");
    assert!(verdict.missing < verdict.felt / 2, "{verdict:?}\n{log}");
    let mut connection = server.connect().connect().await.unwrap();
    assert_eq!(recorded::count(&mut connection, &[]).await.unwrap() as u64, verdict.felt, "the database has all");
}

#[tokio::test(flavor = "multi_thread")]
async fn records_that_the_log_deletes_too_early_are_told_and_the_archive_goes_on() {
    let Some(rig) = Rig::start_with_bridge("all").await else { return };
    let supervisor = rig.stage.supervisor("one", None);
    until_position(&rig.server.connect(), "files of both shards", |at| at.files > 2).await;
    const TOLD: &str = "deleted records before they were archived";
    // A file is written once a second, so some of the records wait most of the time.
    until_within(LONG, "a gap in the archive", async || {
        rig.kafka.delete_records(TOPIC, 0).await;
        supervisor.log().contains(TOLD).then_some(())
    })
    .await;
    only_the_archive_lacks_contacts(rig, supervisor).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_topic_that_is_created_anew_is_told_and_archived_from_its_first_record() {
    let Some(rig) = Rig::start_with_bridge("all").await else { return };
    let supervisor = rig.stage.supervisor("one", None);
    until_position(&rig.server.connect(), "files of both shards", |at| at.files > 20).await;
    rig.kafka.create_topic_anew(TOPIC, SHARDS).await;
    const TOLD: &str = "the topic was created anew: archiving from its first record";
    until_within(LONG, "a line about the topic", async || supervisor.log().contains(TOLD).then_some(())).await;
    only_the_archive_lacks_contacts(rig, supervisor).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_new_topic_with_the_same_offsets_overwrites_no_file() {
    let Some(rig) = Rig::start("all").await else { return };
    let database = rig.server.connect();
    let _supervisor = rig.stage.supervisor("one", None);
    let mut robot = HandRobot::connect(rig.stage.broker.port(), "hand", array(ArrayType::Type2, &[70.0])).await;
    let partition = robot_hash(FLEET, "hand") % SHARDS;
    for files in 1..=3 {
        if files == 3 {
            rig.kafka.create_topic_anew(TOPIC, SHARDS).await;
        }
        let contact = robot.contact(0);
        let message = encode(&robot.message(vec![contact]));
        rig.kafka.write(TOPIC, partition, vec![record_of(FLEET, "hand", RobotTopic::Contacts, message)]).await;
        until_position(&database, "a file with one contact", |at| at.files == files).await;
    }
    let archive = Archive::read(rig.folder.path());
    assert_eq!((archive.files, archive.contacts()), (3, 3), "the third has the offsets of the first");
}
