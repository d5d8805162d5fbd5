//! Clients that harm the broker, in raw packets of MQTT 5.

use std::time::Duration;

use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::time::timeout;
use vibrissa_host::task;
use vibrissa_store::secret::Secret;

use super::*;

const PATIENCE: Duration = Duration::from_secs(60);

fn text(text: &[u8]) -> Vec<u8> {
    [&u16::try_from(text.len()).unwrap().to_be_bytes(), text].concat()
}

fn packet(first: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = vec![first];
    let mut length = body.len();
    while length >= 128 {
        bytes.push((length % 128) as u8 | 0x80);
        length /= 128;
    }
    bytes.push(length as u8);
    [bytes, body.to_vec()].concat()
}

fn publish(first: u8, topic: &str, properties: &[u8], payload_bytes: usize) -> Vec<u8> {
    let properties = [&[u8::try_from(properties.len()).unwrap()], properties].concat();
    packet(first, &[text(topic.as_bytes()), properties, vec![b'x'; payload_bytes]].concat())
}

/// A connected client, and the reason code of the answer.
async fn connected(broker: &Broker, name: &str, credentials: Option<(&str, &str)>) -> (TcpStream, u8) {
    let flags = if credentials.is_some() { 0b1100_0010 } else { 0b10 };
    let mut body = [&text(b"MQTT")[..], &[5, flags, 0, 0, 0], &text(name.as_bytes())].concat();
    for part in credentials.iter().flat_map(|(user, password)| [user, password]) {
        body.extend(text(part.as_bytes()));
    }
    let mut stream = TcpStream::connect(broker.address()).await.unwrap();
    stream.write_all(&packet(0x10, &body)).await.unwrap();
    let mut answer = [0; 4];
    timeout(PATIENCE, stream.read_exact(&mut answer)).await.unwrap().unwrap();
    assert_eq!(answer[0], 0x20, "CONNACK");
    let mut rest = vec![0; usize::from(answer[1]) - 2];
    stream.read_exact(&mut rest).await.unwrap();
    (stream, answer[3])
}

async fn subscribe(stream: &mut TcpStream, filter: &str) {
    let body = [&[0, 1, 0][..], &text(filter.as_bytes()), &[0]].concat();
    stream.write_all(&packet(0x82, &body)).await.unwrap();
    let mut answer = [0; 6];
    timeout(PATIENCE, stream.read_exact(&mut answer)).await.unwrap().unwrap();
    assert_eq!((answer[0], answer[5]), (0x90, 0), "SUBACK");
}

/// Reads until the broker closes the connection; the number of bytes.
async fn read_to_end(stream: &mut TcpStream) -> usize {
    let mut buffer = vec![0; 1 << 20];
    let mut bytes = 0;
    while let Ok(length @ 1..) = timeout(PATIENCE, stream.read(&mut buffer)).await.expect("the broker must close it") {
        bytes += length;
    }
    bytes
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_client_that_does_not_read_is_disconnected() {
    let broker = Broker::start(0).await.unwrap();
    let (mut deaf, _) = connected(&broker, "deaf", None).await;
    subscribe(&mut deaf, "t/#").await;
    let (mut sound, _) = connected(&broker, "sound", None).await;
    subscribe(&mut sound, "t/#").await;
    let (mut sender, _) = connected(&broker, "sender", None).await;
    let message = publish(0x30, "t/1", &[], 1 << 20);
    let mut received = vec![0; message.len()];
    for _ in 0..60 {
        sender.write_all(&message).await.unwrap();
        timeout(PATIENCE, sound.read_exact(&mut received)).await.unwrap().unwrap();
    }
    let bytes = read_to_end(&mut deaf).await;
    assert!(bytes < 40 << 20, "{bytes} bytes waited for it");
    sender.write_all(&message).await.unwrap();
    timeout(PATIENCE, sound.read_exact(&mut received)).await.unwrap().unwrap();
    broker.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_retained_messages_beyond_the_limit_are_not_kept() {
    let broker = Broker::start(0).await.unwrap();
    let (mut sender, _) = connected(&broker, "sender", None).await;
    for number in 0..80 {
        sender.write_all(&publish(0x31, &format!("r/{number}"), &[], 1 << 20)).await.unwrap();
    }
    // The answer says that all are taken.
    sender.write_all(&[0xc0, 0]).await.unwrap();
    let mut answer = [0; 2];
    timeout(PATIENCE, sender.read_exact(&mut answer)).await.unwrap().unwrap();
    let (mut reader, _) = connected(&broker, "reader", None).await;
    subscribe(&mut reader, "r/1").await;
    let mut first = [0];
    timeout(PATIENCE, reader.read_exact(&mut first)).await.unwrap().unwrap();
    assert_eq!(first[0] & 0xf1, 0x31, "it is retained");
    let (mut reader, _) = connected(&broker, "late", None).await;
    subscribe(&mut reader, "r/79").await;
    reader.write_all(&[0xc0, 0]).await.unwrap();
    timeout(PATIENCE, reader.read_exact(&mut first)).await.unwrap().unwrap();
    assert_eq!(first[0], 0xd0, "nothing is retained there: the answer to the ping comes first");
    broker.stop().await;
}

/// A message of 1 MiB with an identifier.
fn large(first: u8, id: u16) -> Vec<u8> {
    packet(first, &[&text(b"t/1")[..], &id.to_be_bytes(), &[0], &vec![b'x'; 1 << 20]].concat())
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_messages_that_are_never_released_are_bounded() {
    let broker = Broker::start(0).await.unwrap();
    let (mut client, _) = connected(&broker, "unreleased", None).await;
    let mut sent = 0;
    for id in 1..=200 {
        if client.write_all(&large(0x34, id)).await.is_err() {
            break;
        }
        sent += 1;
    }
    assert!(sent < 60, "{sent} MiB");
    read_to_end(&mut client).await;
    // Each of those that are released makes room.
    let (mut client, _) = connected(&broker, "released", None).await;
    for id in 1..=40 {
        client.write_all(&large(0x34, id)).await.unwrap();
        client.write_all(&packet(0x62, &id.to_be_bytes())).await.unwrap();
        let mut answers = [0; 8];
        timeout(PATIENCE, client.read_exact(&mut answers)).await.unwrap().unwrap();
        assert_eq!((answers[0], answers[4]), (0x50, 0x70), "PUBREC and PUBCOMP");
    }
    broker.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_a_subscriber_that_reads_and_never_acknowledges_is_disconnected() {
    let broker = Broker::start(0).await.unwrap();
    let (mut silent, _) = connected(&broker, "silent", None).await;
    silent.write_all(&packet(0x82, &[&[0, 1, 0][..], &text(b"t/#"), &[1]].concat())).await.unwrap();
    let reading = task::spawn(async move { read_to_end(&mut silent).await });
    let (mut sender, _) = connected(&broker, "sender", None).await;
    for id in 1..=40 {
        sender.write_all(&large(0x32, id)).await.unwrap();
        let mut answer = [0; 4];
        timeout(PATIENCE, sender.read_exact(&mut answer)).await.unwrap().unwrap();
        assert_eq!(answer[0], 0x40, "PUBACK");
    }
    let bytes = timeout(PATIENCE, reading).await.unwrap().unwrap();
    assert!(bytes < 20 << 20, "{bytes} bytes are kept for it");
    broker.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn regress_subscriptions_are_bounded_in_bytes() {
    let broker = Broker::start(0).await.unwrap();
    let (mut client, _) = connected(&broker, "filters", None).await;
    let mut sent = 0;
    for number in 0..2000 {
        let filter = format!("{number}/{}", "x".repeat(60_000));
        let body = [&[0, 1, 0][..], &text(filter.as_bytes()), &[0]].concat();
        if client.write_all(&packet(0x82, &body)).await.is_err() {
            break;
        }
        sent += 1;
    }
    assert!(sent < 500, "{sent} subscriptions");
    broker.stop().await;
}

#[tokio::test]
async fn regress_topic_aliases_are_refused() {
    let broker = Broker::start(0).await.unwrap();
    let (mut client, _) = connected(&broker, "aliases", None).await;
    client.write_all(&publish(0x30, "t/1", &[0x23, 0, 1], 1)).await.unwrap();
    read_to_end(&mut client).await;
    broker.stop().await;
}

#[tokio::test]
async fn regress_a_broker_with_a_password_admits_nobody_else() {
    let credentials = Credentials { username: "robots".to_owned(), password: Secret::new("right") };
    let broker = Broker::guarded(0, Some(&credentials)).await.unwrap();
    for wrong in [None, Some(("robots", "wrong")), Some(("robot", "sright")), Some(("", "")), Some(("robots", ""))] {
        assert_eq!(connected(&broker, "c", wrong).await.1, 0x86, "{wrong:?}");
    }
    let (mut client, code) = connected(&broker, "c", Some(("robots", "right"))).await;
    assert_eq!(code, 0);
    subscribe(&mut client, "#").await;
    broker.stop().await;
}

#[test]
fn regress_what_http_refuses_is_not_possible_by_mqtt() {
    let credentials = Credentials { username: "robots".to_owned(), password: Secret::new("right") };
    let guarded = MqttAccess::AsHttp(Some(credentials.clone()));
    assert_eq!(guarded.credentials(false).unwrap(), Some(&credentials));
    assert_eq!(guarded.credentials(true).unwrap(), Some(&credentials));
    assert_eq!(MqttAccess::AsHttp(None).credentials(true).unwrap(), None);
    let refused = MqttAccess::AsHttp(None).credentials(false).unwrap_err().to_string();
    assert!(refused.contains("mqtt.password_file") && refused.contains("mqtt.url"), "{refused}");
}
