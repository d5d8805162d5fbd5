//! MQTT 3.1.1 by hand, for clients that violate it.

use std::io::{Read, Write};
use std::net::TcpStream;

use vibrissa_tests::wait::PATIENCE;

/// A packet: first byte, length and body.
fn packet(first: u8, body: &[u8]) -> Vec<u8> {
    let mut bytes = header(first, body.len());
    bytes.extend_from_slice(body);
    bytes
}

/// Start of a packet that announces this number of bytes.
pub(crate) fn header(first: u8, mut remaining: usize) -> Vec<u8> {
    let mut bytes = vec![first];
    loop {
        let low = u8::try_from(remaining % 128).unwrap();
        remaining /= 128;
        bytes.push(if remaining > 0 { low | 0x80 } else { low });
        if remaining == 0 {
            return bytes;
        }
    }
}

/// A text with its length in front.
pub(crate) fn text(text: &str) -> Vec<u8> {
    let mut bytes = u16::try_from(text.len()).unwrap().to_be_bytes().to_vec();
    bytes.extend_from_slice(text.as_bytes());
    bytes
}

/// Opens a connection that the broker accepts.
pub(crate) fn connect(port: u16, id: &str, user: &str, password: &str) -> TcpStream {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(PATIENCE)).unwrap();
    stream.set_write_timeout(Some(PATIENCE)).unwrap();
    // Protocol version 4; flags for user, password and clean session; keep-alive of 60 s.
    let body = [text("MQTT"), vec![4, 0b1100_0010, 0, 60], text(id), text(user), text(password)].concat();
    stream.write_all(&packet(0x10, &body)).unwrap();
    let mut answer = [0; 4];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(answer, [0x20, 2, 0, 0], "{user} is refused");
    stream
}

/// Subscribes at QoS 1 and reads the answer.
pub(crate) fn subscribe(stream: &mut TcpStream, filter: &str) {
    stream.write_all(&packet(0x82, &[vec![0, 1], text(filter), vec![1]].concat())).unwrap();
    let mut answer = [0; 5];
    stream.read_exact(&mut answer).unwrap();
    assert_eq!(answer, [0x90, 3, 0, 1, 1]);
}

/// A PUBLISH packet at QoS 1.
pub(crate) fn publish(topic: &str, id: u16, payload: &[u8]) -> Vec<u8> {
    packet(0x32, &[text(topic), id.to_be_bytes().to_vec(), payload.to_vec()].concat())
}
