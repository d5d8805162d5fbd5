//! A small client for MQTT 3.1.1, the version that many robots still use. It has QoS 1, and neither properties nor reasons.

use std::collections::BTreeMap;
use std::io;
use std::sync::atomic::{AtomicU16, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::net::tcp::OwnedReadHalf;
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;
use tokio::time::timeout;

use crate::wait::PATIENCE;

/// A received message.
#[derive(Debug, Clone)]
pub struct OldMessage {
    /// Topic of the message.
    pub topic: String,
    /// Payload of the message.
    pub payload: Vec<u8>,
    /// Quality of service of the delivery.
    pub qos: u8,
    /// Whether the broker had retained the message.
    pub retained: bool,
}

/// Waiting requests by packet id; each gets the last byte of its answer.
type Waiting = Arc<Mutex<BTreeMap<u16, oneshot::Sender<u8>>>>;

/// A connected client; its connection breaks on drop.
#[derive(Debug)]
pub struct OldClient {
    out: mpsc::UnboundedSender<Vec<u8>>,
    waiting: Waiting,
    last_id: AtomicU16,
    tasks: [JoinHandle<()>; 2],
}

impl OldClient {
    /// Connects with a clean session to a broker on 127.0.0.1, and returns the client and its messages.
    ///
    /// # Errors
    /// The broker refuses the connection, or does not answer in time.
    pub async fn connect(
        port: u16,
        id: &str,
        credentials: Option<(&str, &str)>,
    ) -> io::Result<(Self, mpsc::UnboundedReceiver<OldMessage>)> {
        let stream = TcpStream::connect(("127.0.0.1", port)).await?;
        stream.set_nodelay(true)?;
        let (mut reader, mut writer) = stream.into_split();
        let flags = if credentials.is_some() { 0b1100_0010 } else { 0b10 };
        // Protocol level 4 is MQTT 3.1.1. The keep-alive of 120 s is longer than any test.
        let mut body = [text("MQTT"), vec![4, flags, 0, 120], text(id)].concat();
        if let Some((user, password)) = credentials {
            body.extend([text(user), text(password)].concat());
        }
        writer.write_all(&packet(0x10, &body)).await?;
        let answer = timeout(PATIENCE, read_packet(&mut reader)).await??;
        if answer.0 != 0x20 || answer.1.get(1) != Some(&0) {
            return Err(io::Error::new(io::ErrorKind::ConnectionRefused, format!("CONNACK {answer:?}")));
        }
        let (out, mut outgoing) = mpsc::unbounded_channel::<Vec<u8>>();
        let (sender, messages) = mpsc::unbounded_channel();
        let waiting = Waiting::default();
        let writing = tokio::spawn(async move {
            while let Some(bytes) = outgoing.recv().await {
                if writer.write_all(&bytes).await.is_err() {
                    return;
                }
            }
        });
        let reading = tokio::spawn(read(reader, out.clone(), waiting.clone(), sender));
        Ok((Self { out, waiting, last_id: AtomicU16::new(0), tasks: [writing, reading] }, messages))
    }

    /// Subscribes at QoS 1; false if the broker refuses.
    ///
    /// # Errors
    /// The broker does not answer in time.
    pub async fn subscribe(&self, filter: &str) -> io::Result<bool> {
        let rest = [text(filter), vec![1]].concat();
        Ok(self.request(0x82, &[], &rest).await? <= 2)
    }

    /// Publishes at QoS 1 and waits for the acknowledgement.
    ///
    /// # Errors
    /// The broker does not acknowledge it in time.
    pub async fn publish(&self, topic: &str, payload: &[u8], is_retained: bool) -> io::Result<()> {
        self.request(0x32 | u8::from(is_retained), &text(topic), payload).await.map(drop)
    }

    /// Sends a packet with a new id between `before` and `after`, and waits for the last byte of its answer.
    async fn request(&self, first: u8, before: &[u8], after: &[u8]) -> io::Result<u8> {
        let id = self.last_id.fetch_add(1, Ordering::Relaxed) + 1;
        let (sender, answered) = oneshot::channel();
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner).insert(id, sender);
        let body = [before, &id.to_be_bytes(), after].concat();
        self.out.send(packet(first, &body)).map_err(io::Error::other)?;
        timeout(PATIENCE, answered).await?.map_err(io::Error::other)
    }
}

impl Drop for OldClient {
    fn drop(&mut self) {
        self.tasks.iter().for_each(JoinHandle::abort);
    }
}

/// Takes the broker's packets until the connection ends.
async fn read(
    mut reader: OwnedReadHalf,
    out: mpsc::UnboundedSender<Vec<u8>>,
    waiting: Waiting,
    sender: mpsc::UnboundedSender<OldMessage>,
) {
    while let Ok((first, body)) = read_packet(&mut reader).await {
        match first >> 4 {
            3 => {
                let Some((message, id)) = message(first, &body) else { return };
                if let Some(id) = id {
                    let _ = out.send(packet(0x40, &id));
                }
                if sender.send(message).is_err() {
                    return;
                }
            }
            // PUBACK and SUBACK.
            4 | 9 => {
                let Some((id, last)) = body.first_chunk().zip(body.last()) else { return };
                let mut waiting = waiting.lock().unwrap_or_else(PoisonError::into_inner);
                if let Some(sender) = waiting.remove(&u16::from_be_bytes(*id)) {
                    let _ = sender.send(*last);
                }
            }
            _ => {}
        }
    }
    // Nobody waits for answers that cannot come.
    waiting.lock().unwrap_or_else(PoisonError::into_inner).clear();
}

/// A PUBLISH packet, and its id if it wants an acknowledgement.
fn message(first: u8, body: &[u8]) -> Option<(OldMessage, Option<[u8; 2]>)> {
    let (length, rest) = body.split_first_chunk()?;
    let (topic, mut rest) = rest.split_at_checked(usize::from(u16::from_be_bytes(*length)))?;
    let qos = first >> 1 & 3;
    let mut id = None;
    if qos > 0 {
        let (own, payload) = rest.split_first_chunk()?;
        (id, rest) = (Some(*own), payload);
    }
    let topic = String::from_utf8(topic.to_vec()).ok()?;
    Some((OldMessage { topic, payload: rest.to_vec(), qos, retained: first & 1 == 1 }, id))
}

async fn read_packet(reader: &mut OwnedReadHalf) -> io::Result<(u8, Vec<u8>)> {
    let first = reader.read_u8().await?;
    let mut length = 0;
    for shift in [0, 7, 14, 21] {
        let byte = reader.read_u8().await?;
        length |= usize::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            break;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).await?;
    Ok((first, body))
}

fn packet(first: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![first];
    let mut left = body.len();
    loop {
        let low = (left % 128) as u8;
        left /= 128;
        bytes.push(if left > 0 { low | 0x80 } else { low });
        if left == 0 {
            break;
        }
    }
    bytes.extend_from_slice(body);
    bytes
}

/// A text with its length in front.
fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u16).to_be_bytes(), text.as_bytes()].concat()
}
