//! Robots send messages at the limits of the contract to the real program. An honest robot must get each receipt within
//! ten seconds, and the database must contain only finite numbers.
//!
//! `FUZZ_SEED=7` sends other messages. `FUZZ_WITHOUT=factsheet,times` makes parts of them ordinary, to find the cause
//! of a failure.

use std::collections::VecDeque;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use nix::sys::signal::Signal;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use sqlx::{AssertSqlSafe, ConnectOptions, Connection, Row};
use tokio::task::JoinSet;
use tokio::time::{interval, timeout};
use vibrissa_protocol::{ArrayType, Message, RobotTopic, encode};
use vibrissa_simulator::clock::now_us;
use vibrissa_store::{DatabaseAddress, Store};
use vibrissa_tests::extremes::{Context, Messages, Without, not_finite, number};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::postgres::Postgres;
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::robot::{ARRAY, HandRobot, array};

/// Seed of all messages, unless the environment sets another one.
const SEED: u64 = 1;
/// Number of robots that send extreme messages, and of messages per robot.
const ROBOTS: usize = 8;
const MESSAGES: usize = 2_500;
/// Time between two messages of such a robot; together they send a thousand per second.
const PACE: Duration = Duration::from_millis(8);
/// Longest time from an honest robot's message to its receipt: on an idle machine 0.3 s, on a busy one up to 3 s.
const RECEIPT: Duration = Duration::from_secs(10);
/// Time without a receipt after which the honest robot sends a message again.
const AGAIN: Duration = Duration::from_millis(700);
/// Number of messages and log lines in the report of a failure.
const SHOWN: usize = 12;
/// Longest time from SIGTERM to the end of the program.
const END: Duration = Duration::from_secs(15);

/// The latest extreme messages of all robots.
type Newest = Arc<Mutex<VecDeque<String>>>;

fn launch(database: &str, broker_port: u16, http: SocketAddr, log: &Path) -> Launch {
    let arguments = ["run", "--name", "fuzzed", "--fleets", "f", "--detection-cold-start-contacts", "20"];
    let mut arguments: Vec<String> = arguments.map(str::to_owned).into();
    arguments.extend(["--http-listen".to_owned(), http.to_string(), "--database-url".to_owned(), database.to_owned()]);
    arguments.extend(["--mqtt-url".to_owned(), format!("mqtt://127.0.0.1:{broker_port}")]);
    Launch {
        program: env!("CARGO_BIN_EXE_vibrissa-under-test").into(),
        arguments,
        environment: vec![("RUST_LOG".to_owned(), "info".to_owned())],
        log: log.to_owned(),
    }
}

/// Sends extreme messages, and ordinary contacts with some extreme numbers.
async fn say_extremes(mut robot: HandRobot, seed: u64, newest: Newest, said: Arc<AtomicU64>) {
    let (messages, mut random) = (Messages::default(), ChaCha8Rng::seed_from_u64(seed));
    let without = Without::from_environment();
    let mut clock = interval(PACE);
    for at in 0..MESSAGES {
        clock.tick().await;
        if at % 500 == 0 {
            robot.restart();
            robot.birth().await;
        }
        let kind = match random.random_range(0..100) {
            0..70 => RobotTopic::Contacts,
            70..84 => RobotTopic::Status,
            84..94 => RobotTopic::SetpointState,
            94..98 => RobotTopic::Factsheet,
            _ => RobotTopic::Connection,
        };
        let is_ordinary = without.is_ordinary(kind);
        let kind = if is_ordinary { RobotTopic::Contacts } else { kind };
        let text = if is_ordinary || kind == RobotTopic::Contacts && random.random_bool(0.7) {
            let mut contacts = vec![robot.contact(0), robot.contact(1)];
            if !without.is_ordinary(kind) && random.random_bool(0.3) {
                let odd = &mut contacts[0];
                let mut draw = |field, otherwise| {
                    let is_odd = random.random_bool(0.6);
                    if is_odd { number(&mut random, messages.contact_range(field)) } else { otherwise }
                };
                odd.ratio = odd.ratio.map(|ratio| draw("ratio", ratio));
                odd.deflection_mm = draw("deflection_mm", odd.deflection_mm);
                odd.strain = draw("strain", odd.strain);
            }
            let message = robot.message(contacts);
            String::from_utf8(encode(&message)).unwrap()
        } else {
            let context = Context {
                boot_id: robot.boot_id.as_str().to_owned(),
                seq: robot.next_seq(kind),
                now_us: now_us(),
                arrays: vec![(ARRAY.to_owned(), 2)],
                models: vec!["nguyen-2021".to_owned()],
                commands: Vec::new(),
                pressures_mpa: vec![0.1],
                right_times: if without.times { 1.0 } else { 0.7 },
                odd_texts: match kind {
                    _ if without.texts => 0.0,
                    RobotTopic::Factsheet => 0.1,
                    _ => 0.01,
                },
                list_most: 6,
            };
            messages.draw(&mut random, kind, &context)
        };
        {
            let mut newest = newest.lock().unwrap();
            newest.push_back(format!("{} {text}", robot.topic(kind)));
            let count = newest.len();
            newest.drain(..count.saturating_sub(SHOWN));
        }
        robot.say(kind, text).await;
        said.fetch_add(1, Ordering::Relaxed);
    }
}

/// Sums the machine's delays, in microseconds, of a thread that sleeps and writes to the disk: the program waits for
/// the same processors and the same disk.
fn watch_lag(folder: &Path) -> Arc<AtomicU64> {
    const STEP: Duration = Duration::from_millis(20);
    let lag_us = Arc::new(AtomicU64::new(0));
    let (weak, path) = (Arc::downgrade(&lag_us), folder.join("lag"));
    std::thread::spawn(move || {
        let file = std::fs::File::create(path).expect("a folder of ours");
        while let Some(lag_us) = weak.upgrade() {
            let begun = Instant::now();
            std::thread::sleep(STEP);
            // Like a database, which waits for the disk at each commit.
            file.set_len(begun.elapsed().as_micros() as u64 % 8192)
                .and_then(|()| file.sync_all())
                .expect("a file of ours");
            lag_us.fetch_add(begun.elapsed().saturating_sub(2 * STEP).as_micros() as u64, Ordering::Relaxed);
        }
    });
    lag_us
}

/// Sends a contacts message until its receipt arrives. Returns the time without the machine's own delay.
async fn receipted(robot: &mut HandRobot, lag_us: &AtomicU64) -> Option<Duration> {
    let (begun, lag_before) = (Instant::now(), lag_us.load(Ordering::Relaxed));
    let taken = || {
        let lag = Duration::from_micros(lag_us.load(Ordering::Relaxed) - lag_before);
        begun.elapsed().saturating_sub(lag)
    };
    let contacts = vec![robot.contact(0), robot.contact(1)];
    let message = robot.message(contacts);
    while taken() < RECEIPT {
        robot.say(RobotTopic::Contacts, encode(&message)).await;
        let sent = Instant::now();
        while let Some(heard) = robot.mqtt.next(AGAIN.saturating_sub(sent.elapsed())).await {
            if let Message::Receipt(receipt) = &heard.message
                && receipt.robot_boot_id == message.boot_id
                && receipt.covers(message.seq)
            {
                return Some(taken());
            }
        }
    }
    None
}

/// Runs the whole test on a database.
async fn fuzz(database: &str) {
    let _turn = crate::turn().await;
    let seed = std::env::var("FUZZ_SEED").ok().map_or(SEED, |text| text.parse().expect("a number"));
    let folder = tempfile::tempdir().unwrap();
    let log = folder.path().join("log");
    let broker = tokio::task::block_in_place(Mosquitto::start);
    let http = SocketAddr::from(([127, 0, 0, 1], free_port()));
    let mut program = Process::start(launch(database, broker.port(), http, &log));
    let facts = || array(ArrayType::Type1, &[69.3, 65.0]);
    let mut honest = HandRobot::born(broker.port(), "honest", facts()).await;

    let (newest, said) = (Newest::default(), Arc::new(AtomicU64::new(0)));
    let mut hostile = JoinSet::new();
    for at in 0..ROBOTS {
        let robot = HandRobot::connect(broker.port(), &format!("h{at}"), facts()).await;
        hostile.spawn(say_extremes(robot, seed << 8 | at as u64, newest.clone(), said.clone()));
    }
    let lag_us = watch_lag(folder.path());
    let mut slowest = Duration::ZERO;
    let mut receipts = 0;
    while !hostile.is_empty() || receipts == 0 {
        match receipted(&mut honest, &lag_us).await {
            Some(took) => slowest = slowest.max(took),
            None => {
                let newest: Vec<String> = newest.lock().unwrap().iter().cloned().collect();
                let log = std::fs::read_to_string(&log).unwrap_or_default();
                // Alarms are the expected result of extreme messages.
                let end = log.lines().rev().filter(|line| !line.contains("alarm")).take(SHOWN);
                let end: String = end.map(|line| format!("  {line}\n")).collect();
                panic!(
                    "seed {seed}: an honest robot is not receipted within {RECEIPT:?}, after {} extreme messages, \
                     {receipts} receipts. The newest messages:\n  {}\nThe program, the newest first:\n{end}",
                    said.load(Ordering::Relaxed),
                    newest.join("\n  ")
                );
            }
        }
        receipts += 1;
        while let Some(ended) = timeout(Duration::from_millis(50), hostile.join_next()).await.ok().flatten() {
            ended.expect("the connections of hostile robots must persist");
        }
    }
    let said = said.load(Ordering::Relaxed);
    println!("{said} extreme messages, {receipts} receipts for an honest robot, the slowest after {slowest:?}");
    assert_eq!(said, (ROBOTS * MESSAGES) as u64);

    program.signal(Signal::SIGTERM);
    let status = program.ended(END).await.expect("the program must end after SIGTERM");
    assert!(status.success(), "{status}");
    let address: DatabaseAddress = database.parse().unwrap();
    let store = Store::open(&address, "test").await.unwrap();
    let mut stored = 0;
    for robot in (0..ROBOTS).map(|at| format!("h{at}")).chain(["honest".to_owned()]) {
        let Some(state) = store.robot_state("f", &robot).await.unwrap() else { continue };
        let state = state.robot().unwrap_or_else(|problem| panic!("seed {seed}: {robot}: {problem}"));
        assert_eq!(not_finite(&state), None, "seed {seed}: the stored state of {robot}");
        stored += 1;
    }
    assert!(stored > 1, "only {stored} robots are stored");
    let log = std::fs::read_to_string(&log).unwrap_or_default();
    let panic = log.lines().skip_while(|line| !line.contains("panicked at")).take(2).collect::<Vec<_>>();
    assert!(panic.is_empty(), "seed {seed}: the program panicked: {panic:?}");
}

async fn assert_finite_in_postgres(server: &Postgres) {
    let mut connection = server.connect().connect().await.unwrap();
    let columns = "SELECT table_name::text, column_name::text FROM information_schema.columns \
        WHERE table_schema = 'public' AND data_type IN ('double precision', 'real')";
    let columns = sqlx::query(columns).fetch_all(&mut connection).await.unwrap();
    assert!(columns.len() > 20, "{} columns", columns.len());
    for row in columns {
        let (table, column): (String, String) = (row.get(0), row.get(1));
        let sql = format!("SELECT count(*) FROM \"{table}\" WHERE \"{column}\" IN ('NaN', 'Infinity', '-Infinity')");
        let count: i64 = sqlx::query_scalar(AssertSqlSafe(sql)).fetch_one(&mut connection).await.unwrap();
        assert_eq!(count, 0, "{table}.{column}");
    }
    connection.close().await.unwrap();
}

async fn assert_finite_in_sqlite(file: &Path) {
    let options = sqlx::sqlite::SqliteConnectOptions::new().filename(file).read_only(true);
    let mut connection = options.connect().await.unwrap();
    let columns = "SELECT m.name, c.name FROM sqlite_master m JOIN pragma_table_info(m.name) c \
        WHERE m.type = 'table' AND upper(c.type) = 'REAL'";
    let columns = sqlx::query(columns).fetch_all(&mut connection).await.unwrap();
    assert!(columns.len() > 20, "{} columns", columns.len());
    for row in columns {
        let (table, column): (String, String) = (row.get(0), row.get(1));
        // SQLite stores NaN as NULL, and columns that require a number refuse NULL.
        let sql = format!("SELECT count(*) FROM \"{table}\" WHERE abs(\"{column}\") > 1.7976931348623157e308");
        let count: i64 = sqlx::query_scalar(AssertSqlSafe(sql)).fetch_one(&mut connection).await.unwrap();
        assert_eq!(count, 0, "{table}.{column}");
    }
    connection.close().await.unwrap();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn property_an_honest_robot_is_receipted_in_time_beside_extreme_messages_on_sqlite() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("v.sqlite3");
    fuzz(&format!("sqlite:{}", file.display())).await;
    assert_finite_in_sqlite(&file).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn property_an_honest_robot_is_receipted_in_time_beside_extreme_messages_on_postgres() {
    let server = Postgres::start().await;
    fuzz(&Postgres::url(server.port())).await;
    assert_finite_in_postgres(&server).await;
}
