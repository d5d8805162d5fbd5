//! One connection to the broker, from the attempt to its end.

use std::pin::pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rumqttc::{
    AsyncClient, ConnectReturnCode, ConnectionError, Event, EventLoop, Packet, QoS, SubAck, SubscribeReasonCode,
};
use tokio::sync::mpsc;
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep_until};
use vibrissa_protocol::{QualityOfService, RobotTopic, Topic};

use super::broker::Broker;
use super::problem::{Progress, problem};
use super::silence::{Measure, Silence};

/// Most reports that wait for the robot.
pub(super) const REPORTS: usize = 256 + RESERVED;
/// Places for reports other than messages: of these a connection has few.
const RESERVED: usize = 8;

/// Report of the polling task.
pub(super) enum Report {
    /// The broker has accepted the connection; `retains` is whether it retains messages.
    Connected { retains: bool },
    /// The broker has refused the connection, because it retains no messages and the will asked for it.
    RetainRefused,
    /// The broker has answered the subscriptions; `refused` has the positions of those that it refuses.
    Subscribed { refused: Vec<usize> },
    /// A message to the robot has arrived.
    Received(RobotTopic, Vec<u8>),
    /// A message to all robots of the fleet has arrived, on `supervisor/request`.
    ReceivedByAll(Vec<u8>),
    /// The connection has ended, for this reason.
    Gone(String),
}

/// An attempt to connect, which explains its failure.
pub(super) struct Attempt {
    pub(super) broker: Broker,
    /// Host of the node.
    pub(super) host: String,
    /// Whether TCP has been connected.
    pub(super) is_reached: Arc<AtomicBool>,
}

impl Attempt {
    fn problem(&self, error: &ConnectionError, is_accepted: bool) -> String {
        let progress = match (is_accepted, self.is_reached.load(Ordering::Relaxed)) {
            (true, _) => Progress::Accepted,
            (false, true) => Progress::Reached,
            (false, false) => Progress::Nothing,
        };
        problem(&self.broker, &self.host, error, progress)
    }
}

/// A connection, from the attempt to its end. If dropped, it is cut without a farewell.
pub(super) struct Connection {
    pub(super) client: AsyncClient,
    pub(super) reports: mpsc::Receiver<Report>,
    pub(super) poller: JoinHandle<()>,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.poller.abort();
    }
}

/// The next report of a connection; pending forever without a connection.
pub(super) async fn next_report(connection: &mut Option<Connection>) -> Report {
    match connection {
        Some(connection) => connection.reports.recv().await.unwrap_or(Report::Gone("polling ended".to_owned())),
        None => std::future::pending().await,
    }
}

pub(super) fn qos(quality: QualityOfService) -> QoS {
    match quality {
        QualityOfService::AtMostOnce => QoS::AtMostOnce,
        QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
    }
}

/// Polls the connection until it ends. `question` is a topic of the robot's subscriptions: subscribing again, which changes
/// nothing, shows whether a silent broker still answers.
pub(super) async fn poll(
    mut event_loop: EventLoop,
    question: (AsyncClient, String),
    attempt: Attempt,
    reports: mpsc::Sender<Report>,
) {
    let mut silence = Silence::new(Instant::now());
    let (mut is_subscribed, mut is_accepted) = (false, false);
    loop {
        let report = match next_event(&mut event_loop, &mut silence, &question).await {
            None => Some(Report::Gone("it has stopped answering".to_owned())),
            Some(Ok(Event::Incoming(packet))) => {
                silence.heard(Instant::now());
                report_of(packet).filter(|report| !(is_subscribed && matches!(report, Report::Subscribed { .. })))
            }
            Some(Ok(Event::Outgoing(_) | Event::Auth(_))) => None,
            Some(Err(ConnectionError::ConnectionRefused(ConnectReturnCode::RetainNotSupported))) => {
                Some(Report::RetainRefused)
            }
            Some(Err(error)) => Some(Report::Gone(attempt.problem(&error, is_accepted))),
        };
        let Some(report) = report else { continue };
        is_subscribed |= matches!(report, Report::Subscribed { .. });
        is_accepted |= matches!(report, Report::Connected { .. });
        let ends = matches!(report, Report::Gone(_) | Report::RetainRefused);
        // Polling never waits for the robot. A message without a place is lost; its sender sends it again.
        if matches!(report, Report::Received(..) | Report::ReceivedByAll(_)) && reports.capacity() <= RESERVED {
            tracing::warn!("messages arrive faster than the robot handles them: one is left out");
            continue;
        }
        // Without a receiver, the session has dropped the connection.
        if reports.try_send(report).is_err() || ends {
            return;
        }
    }
}

/// The next event of a connection; `None` once the broker has been silent for too long.
async fn next_event(
    event_loop: &mut EventLoop,
    silence: &mut Silence,
    (client, topic): &(AsyncClient, String),
) -> Option<Result<Event, ConnectionError>> {
    // Not cancelled by the question, because it may have read a part of a packet.
    let mut event = pin!(event_loop.poll());
    loop {
        tokio::select! {
            event = &mut event => return Some(event),
            () = sleep_until(silence.due()) => match silence.measure() {
                // A full queue of requests has no place, and is no answer either.
                Measure::Ask => drop(client.try_subscribe(topic.clone(), qos(RobotTopic::Receipt.quality_of_service()))),
                Measure::GiveUp => return None,
            }
        }
    }
}

/// The part of a packet that matters to the robot.
#[expect(clippy::wildcard_enum_match_arm, reason = "the other packets of the library do not matter to a robot")]
fn report_of(packet: Packet) -> Option<Report> {
    match packet {
        Packet::ConnAck(ack) => {
            let retain_available = ack.properties.and_then(|properties| properties.retain_available);
            Some(Report::Connected { retains: retain_available != Some(0) })
        }
        Packet::SubAck(ack) => Some(Report::Subscribed { refused: refused(&ack) }),
        Packet::Publish(publish) => match Topic::parse(std::str::from_utf8(&publish.topic).ok()?) {
            Ok(Topic::Robot { kind, .. }) => Some(Report::Received(kind, publish.payload.to_vec())),
            Ok(Topic::SupervisorRequest { .. }) => Some(Report::ReceivedByAll(publish.payload.to_vec())),
            Ok(Topic::SupervisorState { .. }) | Err(_) => None,
        },
        _ => None,
    }
}

/// Positions of the subscriptions that the broker refuses.
fn refused(ack: &SubAck) -> Vec<usize> {
    let is_refused = |code: &SubscribeReasonCode| !matches!(code, SubscribeReasonCode::Success(_));
    ack.return_codes.iter().enumerate().filter(|(_, code)| is_refused(code)).map(|(position, _)| position).collect()
}
