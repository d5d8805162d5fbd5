//! Invented robots and invented boots.

use std::sync::Arc;
use std::time::Duration;

use sqlx::ConnectOptions;
use tokio::task::JoinSet;
use vibrissa_protocol::{ArrayType, BootId, Connection, ConnectionState, Message, RobotTopic, Timestamp, encode};
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::observer::Observer;
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::with_limits::{DatabaseKind, Supervised};

const BIRTHS: usize = 3000;
const SENDERS: usize = 30;

async fn be_born(broker: Arc<Observer>, sender: usize) {
    for number in (sender..BIRTHS).step_by(SENDERS) {
        let boot_id = BootId::new("b").unwrap();
        let birth = Connection { boot_id, seq: 0, timestamp: Timestamp(0), state: ConnectionState::Online };
        broker.publish(&format!("whisker/v1/f/made-up-{number}/connection"), encode(&birth), false).await;
    }
}

async fn births_alone_make_no_robots(kind: DatabaseKind) {
    let supervised = Supervised::start(kind, &[]).await;
    let mut robot = HandRobot::born(supervised.port(), "honest", array(ArrayType::Type2, &[70.0])).await;
    let broker = Arc::new(Observer::subscribed(supervised.port(), "crowd", &["whisker/v1/f/nobody/receipt"]).await);
    let mut senders = JoinSet::new();
    for sender in 0..SENDERS {
        senders.spawn(be_born(broker.clone(), sender));
    }
    senders.join_all().await;
    let births = "vibrissa_messages_received_total{fleet=\"f\",topic=\"connection\"}";
    until_true("all births have come", async || supervised.metric(births).await >= (BIRTHS + 1) as f64).await;
    robot.touch(0, 20).await;
    robot.receipted().await;
    assert_eq!(supervised.robots().await, ["honest"]);
    // A robot that sends a factsheet is accepted even during the crowd.
    HandRobot::born(supervised.port(), "late", array(ArrayType::Type2, &[70.0])).await;
    assert_eq!(supervised.robots().await, ["honest", "late"]);
}

#[tokio::test]
async fn regress_births_alone_make_no_robots_on_sqlite() {
    births_alone_make_no_robots(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_births_alone_make_no_robots_on_postgres() {
    births_alone_make_no_robots(DatabaseKind::Postgres).await;
}

const BOOTS: usize = 200;

async fn a_robot_of_many_boots_keeps_the_last_good_one(kind: DatabaseKind) {
    let supervised = Supervised::start(kind, &[]).await;
    let mut robot = HandRobot::born(supervised.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    let mut other = HandRobot::born(supervised.port(), "other", array(ArrayType::Type2, &[70.0])).await;
    for number in 0..BOOTS {
        robot.restart();
        robot.boot_id = BootId::new(&format!("boot-{number}")).unwrap();
        robot.birth().await;
    }
    until_true("all boots have come", async || supervised.refused("too_many_boots").await >= (BOOTS - 12) as f64).await;
    let boots = supervised.texts("SELECT b.boot_id FROM boots b JOIN robots USING (robot_id) WHERE robot = 'r'").await;
    assert!(boots.len() <= 12, "{boots:?}");
    other.touch(0, 20).await;
    other.receipted().await;
    let in_force = "SELECT boot_id FROM robots WHERE robot = 'r' AND boot_id LIKE 'boot-%'";
    until_true("the state of the last good boot", async || supervised.texts(in_force).await.len() == 1).await;
    let last_good = supervised.texts(in_force).await.remove(0);
    robot.restart();
    robot.boot_id = BootId::new(&last_good).unwrap();
    robot.settle().await;
    robot.touch(0, 20).await;
    robot.receipted().await;
}

#[tokio::test]
async fn regress_a_robot_of_many_boots_keeps_the_last_good_one_on_sqlite() {
    a_robot_of_many_boots_keeps_the_last_good_one(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_a_robot_of_many_boots_keeps_the_last_good_one_on_postgres() {
    a_robot_of_many_boots_keeps_the_last_good_one(DatabaseKind::Postgres).await;
}

async fn factsheets_of_made_up_boots_and_layouts_are_bounded(kind: DatabaseKind) {
    let supervised = Supervised::start(kind, &[]).await;
    let mut robot = HandRobot::born(supervised.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    for number in 0..50 {
        let mut factsheet = robot.factsheet();
        factsheet.boot_id = BootId::new(&format!("never-announced-{number}")).unwrap();
        robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
        let mut factsheet = robot.factsheet();
        factsheet.arrays[0].array = format!("array-{number}").parse().unwrap();
        robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
    }
    until_true("all have come", async || supervised.refused("too_many_layouts").await >= 38.0).await;
    let boots = supervised.texts("SELECT boot_id FROM boots").await;
    let arrays = supervised.texts("SELECT \"array\" FROM arrays").await;
    assert!(boots.len() == 1 && arrays.len() <= 11, "{boots:?} {arrays:?}");
}

#[tokio::test]
async fn regress_factsheets_of_made_up_boots_and_layouts_are_bounded_on_sqlite() {
    factsheets_of_made_up_boots_and_layouts_are_bounded(DatabaseKind::Sqlite).await;
}

#[tokio::test]
async fn regress_factsheets_of_made_up_boots_and_layouts_are_bounded_on_postgres() {
    factsheets_of_made_up_boots_and_layouts_are_bounded(DatabaseKind::Postgres).await;
}

#[tokio::test]
async fn a_boot_that_was_one_too_many_is_taken_later() {
    let supervised = Supervised::start(DatabaseKind::Sqlite, &[]).await;
    let mut robot = HandRobot::born(supervised.port(), "r", array(ArrayType::Type2, &[70.0])).await;
    for number in 0..12 {
        robot.restart();
        robot.boot_id = BootId::new(&format!("boot-{number}")).unwrap();
        robot.birth().await;
    }
    until_true("a boot is refused", async || supervised.refused("too_many_boots").await >= 1.0).await;
    // Within a minute one more boot is allowed, which is the last one; then the supervisor requests its factsheet.
    let asked = async {
        loop {
            let heard = robot.mqtt.next(Duration::from_secs(90)).await.expect("a request for the factsheet");
            if matches!(heard.message, Message::Request(_)) {
                return;
            }
        }
    };
    tokio::time::timeout(Duration::from_secs(90), asked).await.unwrap();
    let factsheet = robot.factsheet();
    robot.say(RobotTopic::Factsheet, encode(&factsheet)).await;
    robot.settle().await;
}

#[tokio::test]
async fn new_robots_wait_for_room_and_no_more_are_taken_than_there_is_room_for() {
    let limits = ["--limits-new-robots-per-minute=20", "--limits-robots-per-fleet=22"];
    let supervised = Supervised::start(DatabaseKind::Sqlite, &limits).await;
    let mut robots = Vec::new();
    for number in 0..21 {
        let name = format!("r{number:02}");
        let mut robot = HandRobot::connect(supervised.port(), &name, array(ArrayType::Type2, &[70.0])).await;
        robot.birth().await;
        robots.push(robot);
    }
    until_true("one more than a minute's", async || supervised.refused("too_many_new_robots").await >= 1.0).await;
    // The supervisor requests the factsheet again without a new message of the robot, and accepts it once the limit
    // allows.
    let last = robots.last_mut().unwrap();
    until_true("the last one is known", async || {
        if let Some(heard) = last.mqtt.next(Duration::from_secs(5)).await
            && matches!(heard.message, Message::Request(_))
        {
            let factsheet = last.factsheet();
            last.say(RobotTopic::Factsheet, encode(&factsheet)).await;
        }
        supervised.robots().await.len() == 21
    })
    .await;
    for number in 21..24 {
        let name = format!("r{number:02}");
        let mut robot = HandRobot::connect(supervised.port(), &name, array(ArrayType::Type2, &[70.0])).await;
        until_true("it is taken or refused", async || {
            robot.birth().await;
            supervised.robots().await.len() == 22
                && (number == 21 || supervised.refused("too_many_robots").await >= 1.0)
        })
        .await;
    }
    assert_eq!(supervised.robots().await.len(), 22);
    for robot in &mut robots {
        robot.settle().await;
    }
}

#[tokio::test]
async fn a_decommissioned_robot_leaves_its_place_to_a_new_one() {
    let supervised = Supervised::start(DatabaseKind::Sqlite, &["--limits-robots-per-fleet=1"]).await;
    let whiskers = || array(ArrayType::Type2, &[70.0]);
    let mut old = HandRobot::born(supervised.port(), "old", whiskers()).await;
    old.touch(0, 1).await;
    old.receipted().await;
    let mut new = HandRobot::connect(supervised.port(), "new", whiskers()).await;
    until_true("the new one is refused", async || {
        new.birth().await;
        supervised.refused("too_many_robots").await >= 1.0
    })
    .await;
    let decommission = async || supervised.command(&["decommission", "f/old", "--reason", "scrapped"]).await;
    let (is_done, said) = decommission().await;
    assert!(!is_done && said.contains("switch it off first"), "{said}");
    old.connection(ConnectionState::Offline).await;
    until_true("decommissioned", async || decommission().await.0).await;
    until_true("the new one is taken", async || {
        new.birth().await;
        let robots = supervised.ask("GET", "/v1/robots", &[], None).await.json()["items"].clone();
        robots.as_array().unwrap().iter().map(|row| row["robot"].as_str().unwrap()).eq(["new"])
    })
    .await;
    let (is_done, said) = decommission().await;
    assert!(!is_done && said.contains("old"), "{said}");
}

async fn robots_that_were_only_announced_are_forgotten(address: &DatabaseAddress, server: Option<&Postgres>) {
    let store = Store::open(address, "test").await.unwrap();
    store.prepare().await.unwrap();
    let day_us = 86_400_000_000_i64;
    let sql = [
        "INSERT INTO robots (robot_id, fleet, robot, updated_us) VALUES \
         (1, 'f', 'old-birth', 5), (2, 'f', 'new-birth', 80000000000), (3, 'f', 'with-a-boot', 5), (4, 'f', 'held', 5), \
         (5, 'f', 'with-a-model', 5)",
        "INSERT INTO boots (boot, robot_id, boot_id, first_seen_us) VALUES (1, 3, 'b', 5)",
        "UPDATE robots SET held = TRUE WHERE robot_id = 4",
        "UPDATE robots SET model = 'm' WHERE robot_id = 5",
    ];
    let left = "SELECT robot FROM robots ORDER BY robot_id";
    let (before, after) = match (server, address) {
        (Some(server), _) => {
            let mut link = server.connect().connect().await.unwrap();
            for statement in sql {
                let overriding = statement.replace(") VALUES", ") OVERRIDING SYSTEM VALUE VALUES");
                sqlx::query(sqlx::AssertSqlSafe(overriding)).execute(&mut link).await.unwrap();
            }
            let before: Vec<String> = sqlx::query_scalar(left).fetch_all(&mut link).await.unwrap();
            assert!(!store.forget_announced(day_us + 6, &mut |_| {}).await.unwrap());
            (before, sqlx::query_scalar(left).fetch_all(&mut link).await.unwrap())
        }
        (None, DatabaseAddress::Sqlite(path)) => {
            let mut link = sqlx::sqlite::SqliteConnectOptions::new().filename(path).connect().await.unwrap();
            for statement in sql {
                sqlx::query(statement).execute(&mut link).await.unwrap();
            }
            let before: Vec<String> = sqlx::query_scalar(left).fetch_all(&mut link).await.unwrap();
            assert!(!store.forget_announced(day_us + 6, &mut |_| {}).await.unwrap());
            let after: Vec<String> = sqlx::query_scalar(left).fetch_all(&mut link).await.unwrap();
            (before, after)
        }
        (None, DatabaseAddress::Postgres(_)) => unreachable!("it has a server"),
    };
    assert_eq!(before.len(), 5);
    assert_eq!(after, ["new-birth", "with-a-boot", "held", "with-a-model"]);
}

#[tokio::test]
async fn robots_that_were_only_announced_are_forgotten_on_sqlite() {
    let folder = tempfile::tempdir().unwrap();
    let address = DatabaseAddress::Sqlite(folder.path().join("v.sqlite3"));
    robots_that_were_only_announced_are_forgotten(&address, None).await;
}

#[tokio::test]
async fn robots_that_were_only_announced_are_forgotten_on_postgres() {
    let server = Postgres::start().await;
    let address = Postgres::url(server.port()).parse().unwrap();
    robots_that_were_only_announced_are_forgotten(&address, Some(&server)).await;
}
