//! Limits of the shipped broker configuration, tested against one robot with its own password.

use std::io::{ErrorKind, Read, Write};
use std::net::TcpStream;

use vibrissa_tests::mosquitto::Mosquitto;
use vibrissa_tests::wait::{PATIENCE, until_true};

use crate::access::{client, shipped};
use crate::client::{Client, Who};
use crate::link::PASSWORD;
use crate::raw;

const CONFIGURATION: &str = include_str!("../../../deploy/mosquitto/mosquitto.conf");
const MIB: u64 = 1024 * 1024;

/// The shipped configuration with a smaller limit, which a test can reach.
fn with_limit(setting: &str, shipped: u64, smaller: u64) -> String {
    let line = format!("{setting} {shipped}\n");
    assert!(CONFIGURATION.contains(&line), "the shipped limit: {line}");
    CONFIGURATION.replace(&line, &format!("{setting} {smaller}\n"))
}

/// Peak memory of the broker.
fn memory_bytes(broker: &Mosquitto) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{}/status", broker.pid())).unwrap();
    let line = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

async fn is_let_in(port: u16, user: &str) -> bool {
    Client::connect(port, &Who { id: "c", user: Some((user, PASSWORD)), ..Who::default() }).await.is_some()
}

#[tokio::test]
async fn regress_a_robot_cannot_end_anybody_elses_session() {
    let broker = shipped(CONFIGURATION).start();
    let mut supervisor = client(&broker, "the-supervisors-id", "vibrissa").await;
    let mut other = client(&broker, "lab.two", "lab/two").await;
    for id in ["the-supervisors-id", "lab.two", "lab/two", "vibrissa"] {
        let mut robot = client(&broker, id, "lab/one").await;
        assert!(robot.publish("whisker/v1/lab/one/status", false).await, "{id}");
    }
    assert!(supervisor.publish("whisker/v1/lab/supervisor/state", false).await);
    assert!(other.publish("whisker/v1/lab/two/status", false).await);
}

#[tokio::test]
async fn regress_a_robot_has_one_session_whatever_ids_it_sends() {
    let broker = shipped(CONFIGURATION).start();
    let mut sessions = Vec::new();
    for number in 0..30 {
        sessions.push(client(&broker, &format!("session-{number}"), "lab/one").await);
    }
    let mut last = sessions.pop().unwrap();
    for session in &mut sessions {
        session.ended().await;
    }
    assert!(last.publish("whisker/v1/lab/one/status", false).await);
}

#[tokio::test]
async fn robots_and_supervisors_are_let_in_on_their_own_listeners_only() {
    let broker = shipped(CONFIGURATION).start();
    let (robots, supervisors) = (broker.port(), broker.supervisor_port());
    assert!(is_let_in(robots, "lab/one").await && is_let_in(supervisors, "vibrissa").await);
    assert!(!is_let_in(supervisors, "lab/one").await && !is_let_in(robots, "vibrissa").await);
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_message_of_256_mb_ends_the_connection_before_it_is_in_memory() {
    let broker = shipped(CONFIGURATION).start();
    let mut other = client(&broker, "lab.two", "lab/two").await;
    let before = memory_bytes(&broker);
    let mut robot = raw::connect(broker.port(), "r", "lab/one", PASSWORD);
    // The largest length that MQTT can announce.
    robot.write_all(&raw::header(0x32, 268_435_455)).unwrap();
    robot.write_all(&[raw::text("whisker/v1/lab/one/contacts"), vec![0, 1]].concat()).unwrap();
    let chunk = vec![b'x'; 1 << 20];
    let taken = (0..255).take_while(|_| robot.write_all(&chunk).is_ok()).count();
    assert!(taken < 64, "the broker accepted {taken} MiB");
    let grown = memory_bytes(&broker) - before;
    assert!(grown < 4 * MIB, "the broker grew by {grown} bytes");
    assert!(other.publish("whisker/v1/lab/two/status", false).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_message_above_the_contracts_size_is_refused_and_the_largest_is_not() {
    let broker = shipped(CONFIGURATION).start();
    // The robot stays connected: closing a connection with unread acknowledgements would discard what the broker has not read.
    let (supervisor, _robot) = tokio::task::block_in_place(|| {
        let mut supervisor = raw::connect(broker.supervisor_port(), "s", "vibrissa", PASSWORD);
        raw::subscribe(&mut supervisor, "whisker/v1/+/+/contacts");
        let mut robot = raw::connect(broker.port(), "r", "lab/one", PASSWORD);
        for (id, size) in [(1, 262_145), (2, 262_144)] {
            robot.write_all(&raw::publish("whisker/v1/lab/one/contacts", id, &vec![b'x'; size])).unwrap();
        }
        (supervisor, robot)
    });
    let mut start = [0; 4];
    tokio::task::block_in_place(|| (&supervisor).read_exact(&mut start)).unwrap();
    // Its first message is the second one that was sent.
    let announced = start[1..].iter().rev().fold(0, |sum, byte| sum * 128 + usize::from(byte & 0x7f));
    assert_eq!(announced, 262_144 + 2 + 2 + "whisker/v1/lab/one/contacts".len());
}

/// Number of connections that the broker has not closed.
fn standing(streams: &mut Vec<TcpStream>) -> usize {
    streams.retain_mut(|stream| match stream.read(&mut [0]) {
        Ok(0) => false,
        Ok(_) => true,
        Err(problem) => problem.kind() == ErrorKind::WouldBlock,
    });
    streams.len()
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_connections_of_robots_are_limited_and_do_not_keep_a_supervisor_out() {
    let broker = shipped(&with_limit("max_connections", 10_000, 20)).start();
    let mut supervisor = client(&broker, "s", "vibrissa").await;
    let mut silent: Vec<TcpStream> = (0..100)
        .map(|_| {
            let stream = TcpStream::connect(("127.0.0.1", broker.port())).unwrap();
            stream.set_nonblocking(true).unwrap();
            stream
        })
        .collect();
    until_true("the broker has closed the connections beyond the limit", async || standing(&mut silent) <= 21).await;
    assert!(supervisor.publish("whisker/v1/lab/supervisor/state", false).await);
    assert!(is_let_in(broker.supervisor_port(), "vibrissa").await);
    drop(silent);
    until_true("a robot can connect", async || is_let_in(broker.port(), "lab/one").await).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_flood_to_a_supervisor_that_reads_nothing_is_limited() {
    const LIMIT: u64 = 32 * MIB;
    let broker = shipped(&with_limit("memory_limit", 1_073_741_824, LIMIT)).start();
    tokio::task::block_in_place(|| {
        let mut frozen = raw::connect(broker.supervisor_port(), "s", "vibrissa", PASSWORD);
        raw::subscribe(&mut frozen, "whisker/v1/+/+/contacts");
        let mut robot = raw::connect(broker.port(), "r", "lab/one", PASSWORD);
        let mut acknowledged = robot.try_clone().unwrap();
        // The robot reads its acknowledgements, so only the supervisor is blocked.
        std::thread::spawn(move || while acknowledged.read(&mut [0; 4096]).is_ok_and(|bytes| bytes > 0) {});
        let payload = vec![b'x'; 262_144];
        for id in 1..=400 {
            // Beyond the limit the broker may close this connection.
            if robot.write_all(&raw::publish("whisker/v1/lab/one/contacts", id, &payload)).is_err() {
                break;
            }
        }
    });
    let mut other = None;
    until_true("the broker accepts another robot", async || {
        let who = Who { id: "lab.two", user: Some(("lab/two", PASSWORD)), ..Who::default() };
        other = Client::connect(broker.port(), &who).await;
        other.is_some()
    })
    .await;
    assert!(tokio::time::timeout(PATIENCE, other.unwrap().publish("whisker/v1/lab/two/status", false)).await.unwrap());
    let peak = memory_bytes(&broker);
    assert!(peak < 2 * LIMIT, "the broker's peak memory is {peak} bytes");
}

#[tokio::test]
async fn regress_a_message_that_the_broker_would_have_to_keep_for_its_sender_is_refused() {
    let broker = shipped(CONFIGURATION).start();
    let ended = tokio::task::spawn_blocking({
        let port = broker.port();
        move || {
            let mut robot = raw::connect(port, "r", "lab/one", PASSWORD);
            let body = [raw::text("whisker/v1/lab/one/contacts"), vec![0, 1, b'x']].concat();
            robot.write_all(&[raw::header(0x34, body.len()), body].concat()).unwrap();
            // The broker closes the connection instead of acknowledging the message.
            robot.read(&mut [0; 4]).is_ok_and(|bytes| bytes == 0)
        }
    });
    assert!(ended.await.unwrap());
}
