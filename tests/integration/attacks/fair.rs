//! One robot floods the supervisor while others send at their usual rate.
//!
//! `cargo test --profile dist -p vibrissa-tests --test attacks fair -- --nocapture --test-threads=1` prints the delays.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use tokio::task::JoinSet;
use vibrissa_protocol::{ArrayType, Message};
use vibrissa_simulator::load::{LoadPlan, Quality, run};
use vibrissa_tests::robot::{HandRobot, array};
use vibrissa_tests::wait::until_true;

use crate::with_limits::{DatabaseKind, Supervised};

/// Number of robots beside the flooding one.
const ROBOTS: usize = 40;
/// Number of contacts in each of their messages.
const CONTACTS: usize = 5;
/// Time between two messages of a robot.
const EVERY: Duration = Duration::from_millis(100);
/// Number of contacts in each message of the flood.
const FLOOD_CONTACTS: usize = 100;
/// Length of each measurement, without and with the flood.
const MEASURED: Duration = Duration::from_secs(8);
/// Length of the flood before the measurement with it.
const FILLING: Duration = Duration::from_secs(4);
/// A robot without a receipt for this time counts as cut off.
const GIVE_UP: Duration = Duration::from_secs(30);
/// Longest wait for a receipt, as a multiple of the longest one without the flood: 7 were measured on a busy machine.
const SLOWER_MAX: u32 = 30;
/// A shorter wait without the flood counts as this one.
const USUAL_MIN: Duration = Duration::from_millis(100);

/// Sends messages for a while. Returns the robot and the delays of its receipts.
pub(crate) async fn work(mut robot: HandRobot, lasts: Duration) -> (HandRobot, Vec<Duration>) {
    let begun = Instant::now();
    let (mut next, mut waiting, mut times) = (begun, BTreeMap::new(), Vec::new());
    loop {
        let is_sending = begun.elapsed() < lasts;
        if is_sending && next <= Instant::now() {
            let sent = Instant::now();
            let contacts = (0..CONTACTS).map(|_| robot.contact(0)).collect();
            waiting.insert(robot.send(contacts).await.seq, sent);
            next += EVERY;
        } else if !is_sending && waiting.is_empty() {
            return (robot, times);
        }
        let pause = if is_sending { next.saturating_duration_since(Instant::now()) } else { GIVE_UP };
        let Some(heard) = robot.mqtt.next(pause).await else {
            assert!(is_sending, "no receipt for {GIVE_UP:?}");
            continue;
        };
        let Message::Receipt(receipt) = heard.message else { continue };
        waiting.retain(|&seq, sent| {
            let is_covered = receipt.robot_boot_id == robot.boot_id && receipt.covers(seq);
            times.extend(is_covered.then(|| sent.elapsed()));
            !is_covered
        });
    }
}

/// Lets all robots send at the same time. Returns the delays, ascending.
async fn measure(robots: &mut Vec<HandRobot>) -> Vec<Duration> {
    let mut tasks = JoinSet::new();
    for robot in robots.drain(..) {
        tasks.spawn(work(robot, MEASURED));
    }
    let mut all = Vec::new();
    while let Some(done) = tasks.join_next().await {
        let (robot, times) = done.unwrap();
        robots.push(robot);
        all.extend(times);
    }
    all.sort_unstable();
    all
}

pub(crate) fn quantile(ascending: &[Duration], q: f64) -> Duration {
    ascending[((ascending.len() - 1) as f64 * q) as usize]
}

fn flood(port: u16) -> LoadPlan {
    LoadPlan {
        mqtt_url: format!("mqtt://127.0.0.1:{port}"),
        fleet: "f".parse().unwrap(),
        robots: 1,
        whiskers: 10,
        array_whiskers: 10,
        messages: 10_000_000,
        contacts: FLOOD_CONTACTS,
        qos: Quality::AtLeastOnce,
        rate: None,
        connections: 1,
        window: 1000,
        unreceipted: Some(10_000_000),
        no_receipts: false,
        cbor: false,
        no_retained: false,
        learn: 0,
        trim_every: None,
        status_every_s: 10.0,
        patience_s: 60.0,
    }
}

async fn others_are_receipted_while_one_robot_floods(kind: DatabaseKind) {
    let _turn = crate::turn().await;
    let supervised = Supervised::start(kind, &[]).await;
    let mut robots = Vec::new();
    for number in 0..ROBOTS {
        let name = format!("honest-{number}");
        robots.push(HandRobot::born(supervised.port(), &name, array(ArrayType::Type2, &[70.0])).await);
    }
    let without = measure(&mut robots).await;

    let plan = flood(supervised.port());
    let (stop, stopped) = tokio::sync::oneshot::channel::<()>();
    let flooding = std::thread::spawn(move || {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
        runtime.block_on(async {
            tokio::select! {
                ended = run(plan, || {}) => panic!("the flood has ended: {:?}", ended.err()),
                _ = stopped => {}
            }
        });
    });
    let came = "vibrissa_messages_received_total{fleet=\"f\",topic=\"contacts\"}";
    let before = supervised.metric(came).await;
    until_true("the flood has begun", async || supervised.metric(came).await > before + 1_000.0).await;
    tokio::time::sleep(FILLING).await;
    let (begun, contacts) =
        (Instant::now(), supervised.metric("vibrissa_received_to_commit_seconds_count{fleet=\"f\"}").await);
    let with = measure(&mut robots).await;
    let messages = supervised.metric("vibrissa_received_to_commit_seconds_count{fleet=\"f\"}").await - contacts;
    let shed = supervised.metric("vibrissa_messages_shed_over_share_total{fleet=\"f\"}").await;
    // Panics if the flood has ended early.
    stop.send(()).unwrap();
    flooding.join().unwrap();

    let [p50, p99] = [0.5, 0.99].map(|q| (quantile(&without, q), quantile(&with, q)));
    let ratio = |(without, with): (Duration, Duration)| with.as_secs_f64() / without.as_secs_f64();
    eprintln!(
        "{kind:?}: {} and {} messages; p50 {:.0?} to {:.0?} ({:.2}), p99 {:.0?} to {:.0?} ({:.2}), longest {:.0?} to {:.0?}; \
         {:.0} messages/s of all committed meanwhile, {shed} of the flood shed",
        without.len(),
        with.len(),
        p50.0,
        p50.1,
        ratio(p50),
        p99.0,
        p99.1,
        ratio(p99),
        without.last().unwrap(),
        with.last().unwrap(),
        messages / begun.elapsed().as_secs_f64(),
    );
    let (usual, longest) = (*without.last().unwrap(), *with.last().unwrap());
    assert!(longest <= SLOWER_MAX * usual.max(USUAL_MIN), "an honest robot waited for {longest:?}, else for {usual:?}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn regress_others_are_receipted_while_one_robot_floods_on_sqlite() {
    others_are_receipted_while_one_robot_floods(DatabaseKind::Sqlite).await;
}
