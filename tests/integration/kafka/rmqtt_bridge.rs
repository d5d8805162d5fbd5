//! RMQTT's own bridge writes the records: simulated robots, RMQTT, Kafka, PostgreSQL and a supervisor.

use sqlx::ConnectOptions;
use sqlx::postgres::PgConnection;
use vibrissa_protocol::Name;
use vibrissa_simulator::clock::now_us;
use vibrissa_simulator::scenario::Change;
use vibrissa_simulator::{Broker, Fleet, Scenario};
use vibrissa_tests::kafka::Kafka;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::rmqtt::Rmqtt;
use vibrissa_tests::wait::until_true;

use crate::bridge::{MESSAGES, partition};
use crate::stage::{LEARNED, Program};

/// Robots of which each of two partitions has some.
const ROBOTS: [&str; 4] = ["r0", "r1", "r2", "r3"];

/// Everybody may connect, publish and subscribe.
const RULES: &str = r#"["allow", "all"]"#;

/// The settings that docs/kafka.md recommends. With one partition two entries take the messages of all robots; with more,
/// each robot has two entries of its own, because the bridge has no keys.
fn settings(kafka: &Kafka, partitions: u32) -> String {
    let entry = |robot: &str, partition: u32| {
        let one = |kind: &str| {
            format!(
                "[[bridges.entries]]\nlocal.topic_filter = \"whisker/v1/f/{robot}/{kind}\"\n\
                 remote.topic = \"{MESSAGES}\"\nremote.partition = {partition}\n"
            )
        };
        one("contacts") + &one("status")
    };
    let entries = match partitions {
        1 => entry("+", 0),
        _ => ROBOTS.map(|robot| entry(robot, partition(robot, partitions))).concat(),
    };
    let servers = kafka.addresses().join(",");
    format!("[[bridges]]\nenable = true\nname = \"vibrissa\"\nservers = \"{servers}\"\n{entries}")
}

struct Rig {
    kafka: Kafka,
    rmqtt: Rmqtt,
    server: Postgres,
    program: Program,
    fleet: Fleet,
}

impl Rig {
    /// Starts all parts; `None`, with a line on standard error, if RMQTT or Kafka is not installed.
    async fn start(partitions: u32) -> Option<Self> {
        let kafka = Kafka::start(1).await?;
        kafka.create_topic(MESSAGES, partitions).await;
        let rmqtt = Rmqtt::start_with_bridge(RULES, &settings(&kafka, partitions))?;
        let server = Postgres::start_with_supervisor().await;
        let mqtt = rmqtt.ports()[0];
        let (database, url) = (Postgres::supervisor_url(server.port()), kafka.url());
        let own = ["--database-url", &database, "--ingest", "kafka", "--kafka-url", &url];
        let program = Program::of_database(mqtt, &own).await;
        let broker = Broker::from_url(&format!("mqtt://127.0.0.1:{mqtt}")).unwrap();
        let fleet = Fleet::start(&scenario(), &broker).unwrap();
        Some(Self { kafka, rmqtt, server, program, fleet })
    }

    async fn database(&self) -> PgConnection {
        self.server.connect().connect().await.unwrap()
    }

    /// Waits until all robots together have made so many further contacts.
    async fn touches(&self, more: u64) {
        let goal = self.fleet.contacts_made() + more;
        until_true("more contacts", async || self.fleet.contacts_made() >= goal).await;
    }

    /// Waits until the database has at least so many contacts.
    async fn recorded(&self, count: i64) {
        let mut database = self.database().await;
        until_true("recorded contacts", async || self::count(&mut database).await >= count).await;
    }

    /// Cuts whisker 0 of a robot, and waits until it has applied a setpoint.
    async fn is_compensated(&self, robot: &str) {
        let name = Name::robot(robot).unwrap();
        let trim = Change::Trim { length_mm: 65.0 };
        let robot_handle = self.fleet.robot(&name).unwrap();
        robot_handle.with(|one| one.happen_soon(Some(Name::new("left").unwrap()), Some(0), trim, now_us())).unwrap();
        until_true("an applied setpoint", async || {
            self.program.list("setpoints").await.iter().any(|one| one["robot"] == robot && one["state"] == "APPLIED")
        })
        .await;
    }

    /// Stops the contacts, waits until each has a receipt, and compares the database with the robots.
    async fn every_contact_is_recorded_once(&self) {
        self.fleet.rest();
        until_true("every message receipted", async || self.fleet.is_receipted()).await;
        let mut database = self.database().await;
        let sql = "SELECT count(*), count(DISTINCT (boot, seq, position)) FROM contacts";
        let (rows, names): (i64, i64) = sqlx::query_as(sql).fetch_one(&mut database).await.unwrap();
        assert_eq!((rows, names), (self.fleet.contacts_made() as i64, rows));
    }
}

async fn count(database: &mut PgConnection) -> i64 {
    sqlx::query_scalar("SELECT count(*) FROM contacts").fetch_one(database).await.unwrap()
}

fn scenario() -> Scenario {
    let robot = |name: &&str| {
        format!(
            "[[robots]]\nrobot = \"{name}\"\n\
             arrays = [{{ array = \"left\", type = \"TYPE_2\", whiskers = [{{ whisker = 0 }}, {{ whisker = 1 }}] }}]\n"
        )
    };
    let head = "fleet = \"f\"\nseed = 11\n[behaviour]\ncontacts_per_second = 60.0\ncontacts_per_message = 10\n\
                message_after_s = 0.2\n";
    Scenario::from_toml_str(&(head.to_owned() + &ROBOTS.iter().map(robot).collect::<String>())).unwrap()
}

/// Contacts of all robots until every whisker has learned.
const BEFORE: u64 = (ROBOTS.len() * 4 * LEARNED) as u64;

#[tokio::test]
async fn a_fleet_is_compensated_through_the_bridge_of_rmqtt() {
    let Some(rig) = Rig::start(1).await else { return };
    rig.touches(BEFORE).await;
    rig.is_compensated("r0").await;
    rig.every_contact_is_recorded_once().await;
    rig.fleet.stop().await;
}

#[tokio::test]
async fn the_bridge_of_rmqtt_fills_two_partitions() {
    let Some(rig) = Rig::start(2).await else { return };
    let places = ROBOTS.map(|robot| partition(robot, 2));
    assert!(places.contains(&0) && places.contains(&1), "{places:?}");
    rig.touches(BEFORE).await;
    rig.is_compensated("r0").await;
    rig.every_contact_is_recorded_once().await;
    rig.fleet.stop().await;
}

#[tokio::test]
async fn chaos_a_killed_bridge_or_kafka_loses_no_contact_and_records_none_twice() {
    let Some(mut rig) = Rig::start(1).await else { return };
    let mut recorded = 0;
    for _ in 0..2 {
        rig.recorded(recorded + 100).await;
        rig.rmqtt.kill(0);
        rig.touches(100).await;
        rig.rmqtt.restart(0);
        recorded = count(&mut rig.database().await).await;
        rig.recorded(recorded + 100).await;
        rig.kafka.kill(0);
        rig.touches(100).await;
        rig.kafka.restart(0).await;
        recorded = count(&mut rig.database().await).await;
    }
    rig.every_contact_is_recorded_once().await;
    rig.fleet.stop().await;
}
