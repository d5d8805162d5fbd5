//! A broker with several addresses: nodes that refuse, do not answer, or die.

use std::time::Duration;

use tokio::net::{TcpListener, TcpSocket, TcpStream};
use vibrissa_protocol::Name;
use vibrissa_supervisor::mqtt::{self, BrokerAddress, Connection, TestClient};
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::wait::until_true;

use crate::link::Link;

/// An address that answers no attempt to connect, like a host behind a broken link.
struct BlackHole {
    listener: TcpListener,
    /// They fill the queue of the listener, which accepts none: the system drops further attempts.
    _queued: Vec<TcpStream>,
}

impl BlackHole {
    async fn open() -> Self {
        let socket = TcpSocket::new_v4().unwrap();
        socket.bind("127.0.0.1:0".parse().unwrap()).unwrap();
        let listener = socket.listen(1).unwrap();
        let address = listener.local_addr().unwrap();
        let mut queued = Vec::new();
        while let Ok(Ok(stream)) = tokio::time::timeout(Duration::from_millis(300), TcpStream::connect(address)).await {
            queued.push(stream);
        }
        Self { listener, _queued: queued }
    }

    fn port(&self) -> u16 {
        self.listener.local_addr().unwrap().port()
    }
}

fn broker(ports: &[u16]) -> BrokerAddress {
    let urls: Vec<String> = ports.iter().map(|port| format!("mqtt://127.0.0.1:{port}")).collect();
    urls.join(",").parse().unwrap()
}

/// Waits until both connections are at this port.
async fn at(link: &Link, port: u16) {
    let node = Some(format!("127.0.0.1:{port}"));
    until_true(&format!("the node {port}"), async || {
        let nodes = link.nodes();
        nodes.receiving == node && nodes.publishing == node
    })
    .await;
}

#[tokio::test]
async fn nodes_that_refuse_or_do_not_answer_cost_their_limit_once() {
    let (hole, refused) = (BlackHole::open().await, free_port());
    let (mut first, mut second) = (Mosquitto::start(), Mosquitto::start());
    let link = Link::start(broker(&[refused, hole.port(), first.port(), second.port()]));
    at(&link, first.port()).await;
    let tries = || link.metrics.mqtt_node_failures.of(&format!("127.0.0.1:{}", hole.port()));
    let once = tries();
    assert!(once > 0);
    assert_eq!(link.problem(), None);

    first.kill();
    at(&link, second.port()).await;
    first.restart();
    second.kill();
    at(&link, first.port()).await;
    assert_eq!(tries(), once, "the silent node is tried last");
    link.stop().await;
}

#[tokio::test]
async fn a_node_that_accepts_connections_and_is_frozen_is_left() {
    let (first, second) = (Mosquitto::start(), Mosquitto::start());
    let frozen = first.freeze();
    let link = Link::start(broker(&[first.port(), second.port()]));
    at(&link, second.port()).await;
    drop(frozen);
    link.stop().await;
}

#[tokio::test]
async fn an_outage_of_all_nodes_names_each_and_is_not_tried_without_a_pause() {
    let (one, two) = (free_port(), free_port());
    let link = Link::start(broker(&[one, two]));
    until_true("both problems", async || {
        [one, two].iter().all(|port| link.problems().iter().any(|problem| problem.contains(&port.to_string())))
    })
    .await;
    let failures = || {
        let of = |port| link.metrics.mqtt_node_failures.of(&format!("127.0.0.1:{port}"));
        of(one) + of(two)
    };
    let before = failures();
    tokio::time::sleep(Duration::from_secs(2)).await;
    let more = failures() - before;
    // Two connections, two nodes, and pauses of at least 125, 250, 500 and 1000 ms.
    assert!((2..=24).contains(&more), "{more}");
    link.stop().await;
}

#[tokio::test]
async fn a_test_of_a_robot_uses_the_first_node_that_answers() {
    let (hole, node) = (BlackHole::open().await, Mosquitto::start());
    let address = broker(&[free_port(), hole.port(), node.port()]);
    let (prepared, fleet) = (mqtt::prepare(&address).unwrap(), Name::new("f").unwrap());
    let connection = Connection::new(address, prepared, fleet, vibrissa_protocol::BootId::new("c1").unwrap());
    let client = TestClient::open(&connection, &["whisker/v1/f/r/contacts".to_owned()]).await.unwrap();
    client.close().await;
    let mut nowhere = connection;
    nowhere.broker = broker(&[free_port(), free_port()]);
    let refusal = TestClient::open(&nowhere, &[]).await.unwrap_err().to_string();
    assert_eq!(refusal.matches("nothing listens there").count(), 2, "{refusal}");
}
