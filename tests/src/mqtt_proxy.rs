//! A link between MQTT 5 clients and their broker on 127.0.0.1 that loses packets, as a faulty broker or network does.

use std::net::SocketAddr;
use std::sync::Arc;

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::{Mutex, watch};
use tokio::task::{JoinHandle, JoinSet};

/// Packet types, in the upper half of a packet's first byte.
const PUBLISH: u8 = 3;
const PUBACK: u8 = 4;
const SUBSCRIBE: u8 = 8;
const DISCONNECT: u8 = 14;

/// The traffic that the link loses.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub enum Loss {
    /// No traffic is lost.
    #[default]
    Nothing,
    /// Messages from the broker on topics that match one of these filters; `+` stands for any level.
    Topics(Vec<String>),
    /// Subscriptions with exactly one of these filters. The broker's answer still confirms them to the client.
    Subscriptions(Vec<String>),
    /// Everything that comes from the broker.
    FromBroker,
    /// Everything that comes from clients.
    FromClients,
}

/// A proxy on 127.0.0.1 that drops some of the MQTT traffic. When it is dropped itself, all its connections end.
#[derive(Debug)]
pub struct MqttProxy {
    port: u16,
    loss: watch::Sender<Loss>,
    ending: watch::Sender<u8>,
    listening: JoinHandle<()>,
}

impl MqttProxy {
    /// Listens on a free port of 127.0.0.1 and forwards to a broker on another port. At first no traffic is lost.
    ///
    /// # Panics
    /// There is no free port.
    pub async fn to(broker_port: u16) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", 0)).await.expect("a free port");
        let port = listener.local_addr().expect("a bound listener").port();
        let (loss, losing) = watch::channel(Loss::default());
        let (ending, ended) = watch::channel(0);
        let link = Link { broker: SocketAddr::from(([127, 0, 0, 1], broker_port)), loss: losing, ending: ended };
        Self { port, loss, ending, listening: tokio::spawn(listen(listener, link)) }
    }

    /// Port of the proxy on 127.0.0.1.
    #[must_use]
    pub fn port(&self) -> u16 {
        self.port
    }

    /// Loses this traffic from now on, on existing and new connections.
    pub fn lose(&self, loss: Loss) {
        self.loss.send_replace(loss);
    }

    /// Ends every existing connection as a broker would: with DISCONNECT and this reason code.
    pub fn end_for(&self, reason: u8) {
        self.ending.send_replace(reason);
    }
}

/// Shared state of the connections.
#[derive(Debug, Clone)]
struct Link {
    broker: SocketAddr,
    loss: watch::Receiver<Loss>,
    ending: watch::Receiver<u8>,
}

impl Drop for MqttProxy {
    fn drop(&mut self) {
        self.listening.abort();
    }
}

async fn listen(listener: TcpListener, link: Link) {
    let mut connections = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => {
                let Ok((client, _)) = accepted else { continue };
                connections.spawn(join(client, link.clone()));
            }
            Some(_) = connections.join_next() => {}
        }
    }
}

async fn join(client: TcpStream, mut link: Link) {
    // A new connection ignores earlier reasons.
    link.ending.mark_unchanged();
    let Ok(broker) = TcpStream::connect(link.broker).await else { return };
    let _ = (client.set_nodelay(true), broker.set_nodelay(true));
    let (from_client, to_client) = client.into_split();
    let (from_broker, to_broker) = broker.into_split();
    let to_broker = Arc::new(Mutex::new(to_broker));
    // The end of one direction also ends the other one.
    tokio::select! {
        () = upstream(from_client, &to_broker, link.loss.clone()) => {}
        () = downstream(from_broker, to_client, &to_broker, link) => {}
    }
}

async fn upstream(mut from: OwnedReadHalf, to: &Mutex<OwnedWriteHalf>, loss: watch::Receiver<Loss>) {
    while let Some(mut packet) = read(&mut from).await {
        let loss = loss.borrow().clone();
        match &loss {
            Loss::FromClients => continue,
            Loss::Subscriptions(lost) if packet.kind() == SUBSCRIBE => {
                for filter in lost {
                    packet.spoil(filter);
                }
            }
            Loss::Nothing | Loss::Topics(_) | Loss::Subscriptions(_) | Loss::FromBroker => {}
        }
        if to.lock().await.write_all(&packet.bytes).await.is_err() {
            return;
        }
    }
}

async fn downstream(
    mut from: OwnedReadHalf,
    mut to: OwnedWriteHalf,
    to_broker: &Mutex<OwnedWriteHalf>,
    mut link: Link,
) {
    loop {
        let packet = tokio::select! {
            packet = read(&mut from) => packet,
            Ok(()) = link.ending.changed() => {
                let reason = *link.ending.borrow();
                // A DISCONNECT without properties.
                let _ = to.write_all(&[DISCONNECT << 4, 2, reason, 0]).await;
                return;
            }
        };
        let Some(packet) = packet else { return };
        let loss = link.loss.borrow().clone();
        let is_lost = match &loss {
            Loss::FromBroker => true,
            Loss::Topics(lost) if packet.kind() == PUBLISH => {
                let is_lost = lost.iter().any(|filter| matches(filter, packet.topic()));
                // The proxy acknowledges the message, or the broker would wait and hold back everything else.
                if let Some([high, low]) = packet.packet_id().filter(|_| is_lost)
                    && to_broker.lock().await.write_all(&[PUBACK << 4, 2, high, low]).await.is_err()
                {
                    return;
                }
                is_lost
            }
            Loss::Nothing | Loss::Topics(_) | Loss::Subscriptions(_) | Loss::FromClients => false,
        };
        if !is_lost && to.write_all(&packet.bytes).await.is_err() {
            return;
        }
    }
}

fn matches(filter: &str, topic: &[u8]) -> bool {
    let mut levels = topic.split(|&byte| byte == b'/');
    filter.split('/').all(|wanted| levels.next().is_some_and(|level| wanted == "+" || level == wanted.as_bytes()))
        && levels.next().is_none()
}

/// A complete MQTT packet.
struct Packet {
    bytes: Vec<u8>,
    /// Offset of the packet's body, after the length.
    body: usize,
}

impl Packet {
    fn kind(&self) -> u8 {
        self.bytes[0] >> 4
    }

    /// Topic of a PUBLISH packet.
    fn topic(&self) -> &[u8] {
        let body = &self.bytes[self.body..];
        let length = usize::from(u16::from_be_bytes([body[0], body[1]]));
        &body[2..2 + length]
    }

    /// Packet id of a PUBLISH packet with QoS 1.
    fn packet_id(&self) -> Option<[u8; 2]> {
        let at = self.body + 2 + self.topic().len();
        (self.bytes[0] & 0b0110 != 0).then(|| [self.bytes[at], self.bytes[at + 1]])
    }

    /// Replaces a filter by one of the same length that matches nothing.
    fn spoil(&mut self, filter: &str) {
        let length = u16::try_from(filter.len()).expect("a filter").to_be_bytes();
        let wanted = [&length, filter.as_bytes()].concat();
        let found = self.bytes.windows(wanted.len()).position(|window| window == wanted);
        if let Some(at) = found {
            self.bytes[at + 2] = b'X';
        }
    }
}

/// Reads the next packet. None at the end of the connection.
async fn read(from: &mut OwnedReadHalf) -> Option<Packet> {
    let mut bytes = vec![from.read_u8().await.ok()?];
    let mut length = 0_usize;
    for place in 0..4 {
        let byte = from.read_u8().await.ok()?;
        bytes.push(byte);
        length |= usize::from(byte & 0x7f) << (7 * place);
        if byte & 0x80 == 0 {
            break;
        }
    }
    let body = bytes.len();
    bytes.resize(body + length, 0);
    from.read_exact(&mut bytes[body..]).await.ok()?;
    Some(Packet { bytes, body })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use vibrissa_protocol::RobotTopic;

    use super::*;
    use crate::mosquitto::Mosquitto;
    use crate::observer::{Heard, Observer};

    const FILTERS: [&str; 2] = ["whisker/v1/f/+/request", "whisker/v1/f/+/receipt"];

    /// Sends one message on each topic. Returns whether each came through.
    async fn passed(observer: &mut Observer, sender: &Observer) -> Vec<bool> {
        let request = br#"{"boot_id":"b","seq":0,"robot_boot_id":"r","request":"STATUS"}"#;
        let receipt = br#"{"boot_id":"b","seq":0,"robot_boot_id":"r","next":0,"held":[]}"#;
        let mut heard = Vec::new();
        for (topic, payload) in [(RobotTopic::Request, &request[..]), (RobotTopic::Receipt, &receipt[..])] {
            sender.publish(&format!("whisker/v1/f/r/{topic}"), payload.to_vec(), false).await;
            let came: Option<Heard> = observer.next(Duration::from_millis(500)).await;
            heard.push(came.is_some());
        }
        heard
    }

    #[tokio::test]
    async fn a_topic_or_a_subscription_is_lost_and_nothing_else() {
        let broker = Mosquitto::start();
        let proxy = MqttProxy::to(broker.port()).await;
        let sender = Observer::subscribed(broker.port(), "sender", &[]).await;
        let mut observer = Observer::subscribed(proxy.port(), "observer", &FILTERS).await;
        assert_eq!(passed(&mut observer, &sender).await, [true, true]);
        proxy.lose(Loss::Topics(vec![FILTERS[0].to_owned()]));
        assert_eq!(passed(&mut observer, &sender).await, [false, true]);
        proxy.lose(Loss::FromBroker);
        assert_eq!(passed(&mut observer, &sender).await, [false, false]);
        proxy.lose(Loss::Subscriptions(vec![FILTERS[1].to_owned()]));
        let mut other = Observer::subscribed(proxy.port(), "other", &FILTERS).await;
        assert_eq!(passed(&mut other, &sender).await, [true, false]);
    }
}
