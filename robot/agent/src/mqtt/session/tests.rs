//! A session with a broker of the test, which acknowledges all and keeps the topics.

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};
use tokio::net::{TcpListener, TcpStream};

use super::*;

/// Kinds of packets of MQTT 5 (2.1.2), as the first byte shows them.
const CONNECT: u8 = 1;
const PUBLISH: u8 = 3;
const SUBSCRIBE: u8 = 8;
const PING: u8 = 12;

/// The first byte of a packet, and what follows its length; none at the end of the connection.
async fn packet(stream: &mut (impl AsyncRead + Unpin)) -> Option<(u8, Vec<u8>)> {
    let first = stream.read_u8().await.ok()?;
    let (mut length, mut shift) = (0, 0);
    loop {
        let byte = stream.read_u8().await.ok()?;
        length |= usize::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            break;
        }
    }
    let mut rest = vec![0; length];
    stream.read_exact(&mut rest).await.ok()?;
    Some((first, rest))
}

/// Answers a client until it leaves; the topics that it has published to.
async fn serve(mut stream: TcpStream) -> Vec<String> {
    let mut topics = Vec::new();
    while let Some((first, rest)) = packet(&mut stream).await {
        let answer = match first >> 4 {
            CONNECT => vec![0x20, 3, 0, 0, 0],
            SUBSCRIBE => {
                let (mut at, mut filters) = (3 + usize::from(rest[2]), 0);
                while at < rest.len() {
                    at += 3 + usize::from(u16::from_be_bytes([rest[at], rest[at + 1]]));
                    filters += 1;
                }
                let mut answer = vec![0x90, 3 + filters, rest[0], rest[1], 0];
                answer.resize(5 + usize::from(filters), 1);
                answer
            }
            PUBLISH => {
                let end = 2 + usize::from(u16::from_be_bytes([rest[0], rest[1]]));
                topics.push(String::from_utf8(rest[2..end].to_vec()).unwrap());
                let has_number = first & 0x06 != 0;
                if has_number { vec![0x40, 2, rest[end], rest[end + 1]] } else { vec![] }
            }
            PING => vec![0xd0, 0],
            _ => vec![],
        };
        stream.write_all(&answer).await.unwrap();
    }
    topics
}

/// A robot with contacts that wait at its end.
struct Leaving;

impl Endpoint for Leaving {
    fn fleet(&self) -> Name {
        Name::new("hall").unwrap()
    }
    fn robot(&self) -> Name {
        Name::new("crawler").unwrap()
    }
    fn will(&self, _: Now) -> Vec<u8> {
        b"{}".to_vec()
    }
    fn connected(&self, _: Now) -> Vec<Outgoing> {
        vec![]
    }
    fn disconnected(&self) {}
    fn poll(&self, _: Now) -> (Vec<Outgoing>, Moment) {
        (vec![], Moment::NEVER)
    }
    fn receive(&self, _: RobotTopic, _: &[u8], _: Now) -> Vec<Outgoing> {
        vec![]
    }
    fn receive_request_to_all(&self, _: &[u8], _: Now) {}
    fn farewell(&self, _: Now) -> Vec<Outgoing> {
        [RobotTopic::Contacts, RobotTopic::Connection]
            .map(|topic| Outgoing::Publish { topic, payload: b"{}".to_vec() })
            .into()
    }
}

#[tokio::test]
async fn regress_what_waits_at_the_end_goes_to_its_own_topic() {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let broker = Broker {
        host: "127.0.0.1".to_owned(),
        port: listener.local_addr().unwrap().port(),
        others: vec![],
        credentials: None,
        password_file: None,
        tls: None,
        client: None,
    };
    let serving = task::spawn(async move { serve(listener.accept().await.unwrap().0).await });
    let mut session = Session::new(Leaving, broker, Transport::Tcp);
    session.connect();
    loop {
        let report = next_report(&mut session.connection).await;
        let is_subscribed = matches!(report, Report::Subscribed { .. });
        session.take(report).await;
        assert!(session.connection.is_some());
        if is_subscribed {
            break;
        }
    }
    session.leave().await;
    let topics = [RobotTopic::Contacts, RobotTopic::Connection].map(|kind| session.topic(kind));
    assert_eq!(serving.await.unwrap(), topics);
}
