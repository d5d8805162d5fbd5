//! Measures the floor of every answer: round trips of a message to a subscriber that sends it back, one at a time,
//! through the same broker.

use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use vibrissa_simulator::load::packet::{self, Inbound, Incoming, Manner};

use crate::null::ECHO_FLEET;

/// As many bytes as a message with one contact has.
const PAYLOAD: [u8; 190] = [b'x'; 190];
const PATIENCE: Duration = Duration::from_secs(5);

/// Durations of the round trips, ascending, in microseconds.
///
/// # Errors
/// The broker or the responder does not answer.
pub fn round_trips(port: u16, count: usize) -> io::Result<Vec<u64>> {
    let mut line = Line { stream: TcpStream::connect(("127.0.0.1", port))?, inbound: Inbound::default() };
    line.stream.set_nodelay(true)?;
    line.stream.set_read_timeout(Some(PATIENCE))?;
    let mut out = Vec::new();
    packet::connect(&mut out, "ping");
    line.exchange(&mut out, |packet| matches!(packet, Incoming::ConnAck(0)))?;
    packet::subscribe(&mut out, &[format!("whisker/v1/{ECHO_FLEET}/+/setpoint")]);
    line.exchange(&mut out, |packet| matches!(packet, Incoming::SubAck))?;
    let topic = format!("whisker/v1/{ECHO_FLEET}/r/contacts");
    let mut times_us = Vec::with_capacity(count);
    for at in 0..count {
        let id = Some((at % 1000 + 1) as u16);
        packet::publish(&mut out, topic.as_bytes(), Manner { id, retain: false }, &PAYLOAD);
        let sent = Instant::now();
        line.exchange(&mut out, |packet| matches!(packet, Incoming::Publish { .. }))?;
        times_us.push(sent.elapsed().as_micros() as u64);
    }
    times_us.sort_unstable();
    Ok(times_us)
}

struct Line {
    stream: TcpStream,
    inbound: Inbound,
}

impl Line {
    /// Sends `out` and waits for an answer. Acknowledgements of the answer stay in `out` for the next call.
    fn exchange(&mut self, out: &mut Vec<u8>, is_answer: impl Fn(&Incoming<'_>) -> bool) -> io::Result<()> {
        self.stream.write_all(out)?;
        out.clear();
        loop {
            while let Some(packet) = self.inbound.next_packet()? {
                if let Incoming::Publish { id: Some(id), .. } = packet {
                    packet::acknowledge(out, id);
                }
                if is_answer(&packet) {
                    return Ok(());
                }
            }
            let count = self.stream.read(self.inbound.space())?;
            if count == 0 {
                return Err(io::ErrorKind::UnexpectedEof.into());
            }
            self.inbound.filled(count);
        }
    }
}
