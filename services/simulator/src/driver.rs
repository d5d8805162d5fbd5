//! One robot's connection: a thin driver around [`crate::Robot`].
//!
//! One task only polls the MQTT event loop; another one works with the robot. Each connection is used once: after
//! it breaks, a new client makes a clean start, subscribes again and publishes the robot's birth again.

use std::pin::pin;
use std::time::Duration;

use rumqttc::{
    AsyncClient, ConnectReturnCode, ConnectionError, Event, EventLoop, LastWill, MqttOptions, NetworkOptions, Packet,
    PublishOptions, QoS, SubscribeFilterInput, Transport,
};
use tokio::sync::{mpsc, watch};
use tokio::task::JoinHandle;
use tokio::time::{Instant, sleep_until, timeout};
use vibrissa_protocol::{Name, PAYLOAD_MAX_BYTES, QualityOfService, RobotTopic, Topic};

use crate::fleet::{Broker, RobotHandle, address, now_us};
use crate::robot::Outgoing;
use crate::scenario::Misbehaviour;
use crate::silence::{Measure, Silence};

/// Shortest pause between two polls of the robot, so that small work is done together.
const WAKE_PAUSE: Duration = Duration::from_millis(20);
const RECONNECT_START: Duration = Duration::from_millis(250);
const RECONNECT_MAX: Duration = Duration::from_secs(10);
/// Time limit for the connection to one of several nodes.
const NODE_TIMEOUT: Duration = Duration::from_secs(3);
const KEEP_ALIVE_S: u16 = 10;
/// Capacity of the queue of requests to the polling task.
const REQUESTS: usize = 256;
/// Largest number of unacknowledged QoS 1 messages.
const IN_FLIGHT: u16 = 32;
/// A broker that accepts no message for this long counts as lost.
const PUBLISH_TIMEOUT: Duration = Duration::from_secs(15);
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

/// Report of the polling task.
enum Report {
    /// The broker has accepted the connection; `retains` is whether it retains messages.
    Connected { retains: bool },
    /// The broker has refused the connection, because it retains no messages and the will asked for it.
    RetainRefused,
    /// The broker has confirmed the subscriptions.
    Subscribed,
    /// A message to the robot has arrived.
    Received(RobotTopic, Vec<u8>),
    /// A message to all robots of the fleet has arrived, on `supervisor/request`.
    ReceivedByAll(Vec<u8>),
    /// The connection has ended, for this reason.
    Gone(String),
}

/// A connection, from the attempt to its end. If dropped, it is cut without a farewell.
struct Connection {
    client: AsyncClient,
    reports: mpsc::UnboundedReceiver<Report>,
    poller: JoinHandle<()>,
}

impl Drop for Connection {
    fn drop(&mut self) {
        self.poller.abort();
    }
}

/// Runs a robot until `stopping` changes.
pub(crate) async fn run(robot: RobotHandle, broker: Broker, transport: Transport, mut stopping: watch::Receiver<bool>) {
    let mut driver = Driver::new(robot, broker, transport);
    loop {
        tokio::select! {
            _ = stopping.changed() => break,
            () = driver.robot.cut.notified() => driver.lose("cut on request"),
            () = sleep_until(driver.wake_at) => driver.work().await,
            () = sleep_until(driver.connect_at), if driver.connection.is_none() => driver.connect(),
            report = next_report(&mut driver.connection) => driver.take(report).await,
        }
    }
    driver.farewell().await;
}

/// The next report of a connection; pending forever without a connection.
async fn next_report(connection: &mut Option<Connection>) -> Report {
    match connection {
        Some(connection) => connection.reports.recv().await.unwrap_or(Report::Gone("polling ended".to_owned())),
        None => std::future::pending().await,
    }
}

struct Driver {
    robot: RobotHandle,
    broker: Broker,
    /// Number of failed connections. Each makes the next attempt go to the next node of the broker.
    failures: usize,
    transport: Transport,
    fleet: Name,
    connection: Option<Connection>,
    connect_at: Instant,
    reconnect_pause: Duration,
    wake_at: Instant,
    fault: Option<Misbehaviour>,
    /// Whether the broker retains messages, as far as it has said.
    retains: bool,
}

impl Driver {
    fn new(robot: RobotHandle, broker: Broker, transport: Transport) -> Self {
        let now = Instant::now();
        let (fleet, fault) = robot.with(|robot| (robot.fleet().clone(), robot.misbehaviour()));
        Self {
            robot,
            broker,
            failures: 0,
            transport,
            fleet,
            connection: None,
            connect_at: now,
            reconnect_pause: RECONNECT_START,
            wake_at: now,
            fault,
            retains: true,
        }
    }

    fn topic(&self, kind: RobotTopic) -> String {
        kind.of(&self.fleet, self.robot.name()).to_string()
    }

    /// Polls the robot and plans the next time.
    async fn work(&mut self) {
        let (outgoing, deadline_us, has_changed) =
            self.robot.with(|robot| (robot.poll(now_us()), robot.next_deadline(), robot.take_change()));
        if has_changed {
            self.robot.changed.notify_one();
        }
        self.send(outgoing).await;
        // From the clock rather than by adding pauses, so that a delay is caught up.
        let ahead = Duration::from_micros(deadline_us.saturating_sub(now_us()));
        self.wake_at = Instant::now() + ahead.clamp(WAKE_PAUSE, Duration::from_secs(1));
    }

    fn connect(&mut self) {
        let will = self.robot.with(|robot| robot.will(now_us()));
        let is_will_retained = self.retains && self.fault != Some(Misbehaviour::WillNotRetained);
        let topic = self.topic(RobotTopic::Connection);
        // The client id is the robot's topic prefix in the contract: a second robot of that name takes over the
        // session.
        let id = format!("{}.{}", self.fleet, self.robot.name());
        let nodes = self.broker.nodes();
        let (host, port) = nodes[self.failures % nodes.len()].clone();
        let mut options = MqttOptions::new(id, (host.clone(), port));
        if nodes.len() > 1 {
            options.set_connect_timeout(NODE_TIMEOUT);
        }
        options
            .set_keep_alive(KEEP_ALIVE_S)
            .set_clean_start(true)
            // The library allocates its tables for this number in advance: 16 MB per connection for its default of
            // 65535.
            .set_outgoing_inflight_upper_limit(IN_FLIGHT)
            .set_max_packet_size(u32::try_from(PAYLOAD_MAX_BYTES + 1024).ok())
            .set_last_will(LastWill::new(topic, will, QoS::AtLeastOnce, is_will_retained, None));
        if let Some((user, password)) = self.broker.credentials_of(&self.fleet, self.robot.name()) {
            options.set_credentials(user, password.into_bytes());
        }
        options.set_transport(self.transport.clone());
        // The library's own address lacks the brackets around IPv6.
        let address = address(&host, port);
        options.set_socket_connector(move |_, network| rumqttc::default_socket_connect(address.clone(), network));
        let mut network = NetworkOptions::new();
        network.set_tcp_nodelay(true);
        options.set_network_options(network);
        let (client, event_loop) = AsyncClient::builder(options).capacity(REQUESTS).build();
        // Unbounded, so that polling never waits for the robot; only a few receipts arrive per second.
        let (sender, reports) = mpsc::unbounded_channel();
        let question = (client.clone(), self.topic(RobotTopic::Receipt));
        let poller = tokio::spawn(poll(event_loop, question, sender));
        self.connection = Some(Connection { client, reports, poller });
    }

    async fn take(&mut self, report: Report) {
        match report {
            Report::Connected { retains } => {
                self.retains = retains;
                self.subscribe().await;
            }
            Report::RetainRefused => {
                self.retains = false;
                self.lose("the broker retains no messages");
            }
            Report::Subscribed => {
                self.reconnect_pause = RECONNECT_START;
                let outgoing = self.robot.with(|robot| robot.connected(now_us()));
                self.send(outgoing).await;
                tracing::debug!(robot = %self.robot.name(), "connected");
            }
            Report::Received(topic, payload) => {
                let outgoing = self.robot.with(|robot| robot.receive(topic, &payload, now_us()));
                self.send(outgoing).await;
                // A receipt may have made the next window due immediately.
                self.wake_at = self.wake_at.min(Instant::now() + WAKE_PAUSE);
            }
            Report::ReceivedByAll(payload) => {
                self.robot.with(|robot| robot.receive_request_to_all(&payload, now_us()));
                self.wake_at = self.wake_at.min(Instant::now() + WAKE_PAUSE);
            }
            Report::Gone(reason) => self.lose(&reason),
        }
    }

    fn publish_options(&self, kind: RobotTopic) -> PublishOptions {
        publish_options(kind, self.fault, self.retains)
    }

    async fn subscribe(&mut self) {
        let filters = [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request, RobotTopic::Estimate]
            .map(|kind| SubscribeFilterInput::new(self.topic(kind), qos(kind)));
        // A broker with an older access list may refuse the last one; the robot works without it.
        let to_all = Topic::SupervisorRequest { fleet: self.fleet.clone() }.to_string();
        let filters = filters.into_iter().chain([SubscribeFilterInput::new(to_all, QoS::AtLeastOnce)]);
        if let Some(connection) = &self.connection
            && let Err(error) = connection.client.subscribe_many(filters).await
        {
            self.lose(&error.to_string());
        }
    }

    /// Publishes in order. Messages that cannot be published are lost; contacts among them are sent again later.
    async fn send(&mut self, outgoing: Vec<Outgoing>) {
        for item in outgoing {
            let Some(connection) = &self.connection else {
                return;
            };
            let sent = match item {
                Outgoing::Restart => {
                    self.lose("the robot restarts");
                    self.connect_at = Instant::now();
                    return;
                }
                Outgoing::Publish { topic, payload } => {
                    let publish = connection.client.publish(self.topic(topic), payload, self.publish_options(topic));
                    timeout(PUBLISH_TIMEOUT, publish).await
                }
            };
            match sent {
                Ok(Ok(())) => {}
                Ok(Err(error)) => return self.lose(&error.to_string()),
                Err(_) => return self.lose("the broker accepts no messages"),
            }
        }
    }

    /// Ends the connection; the next attempt follows at the next node at once, and after the last node after a growing
    /// pause.
    fn lose(&mut self, reason: &str) {
        if self.connection.take().is_none() {
            return;
        }
        self.robot.with(crate::Robot::disconnected);
        self.failures += 1;
        let nodes = self.broker.others.len() + 1;
        if !self.failures.is_multiple_of(nodes) {
            tracing::warn!(robot = %self.robot.name(), reason, "connection lost, trying the next node");
            self.connect_at = Instant::now();
            return;
        }
        tracing::warn!(robot = %self.robot.name(), reason, pause = ?self.reconnect_pause, "connection lost");
        self.connect_at = Instant::now() + self.reconnect_pause;
        self.reconnect_pause = (self.reconnect_pause * 2).min(RECONNECT_MAX);
    }

    /// Publishes the farewell and disconnects cleanly, if that succeeds in time.
    async fn farewell(mut self) {
        let outgoing = self.robot.with(|robot| robot.farewell(now_us()));
        let Some(mut connection) = self.connection.take() else {
            return;
        };
        let topic = self.topic(RobotTopic::Connection);
        let (fault, retains) = (self.fault, self.retains);
        let options = |kind| publish_options(kind, fault, retains);
        let end = async {
            for item in outgoing {
                let Outgoing::Publish { topic: kind, payload } = item else {
                    continue;
                };
                let publish = connection.client.publish_tracked(topic.clone(), payload, options(kind));
                // A disconnect may overtake queued messages, so wait for the broker's acknowledgement of the
                // farewell.
                if let Ok(notice) = publish.await
                    && let Err(error) = notice.wait_async().await
                {
                    tracing::warn!(robot = %self.robot.name(), %error, "farewell not acknowledged");
                }
            }
            if connection.client.disconnect().await.is_ok() {
                // The polling task ends once the disconnect has been sent.
                let _ = (&mut connection.poller).await;
            }
        };
        if timeout(FAREWELL_TIMEOUT, end).await.is_err() {
            tracing::warn!(robot = %self.robot.name(), "farewell timed out");
        }
    }
}

fn qos(kind: RobotTopic) -> QoS {
    match kind.quality_of_service() {
        QualityOfService::AtMostOnce => QoS::AtMostOnce,
        QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
    }
}

/// Without the retain flag if the broker retains no messages: it would end the connection (MQTT 5, 3.2.2.3.5).
fn publish_options(kind: RobotTopic, fault: Option<Misbehaviour>, retains: bool) -> PublishOptions {
    let (quality, is_retained) = match (fault, kind) {
        (Some(Misbehaviour::BirthNotRetained), RobotTopic::Connection)
        | (Some(Misbehaviour::FactsheetNotRetained), RobotTopic::Factsheet) => (qos(kind), false),
        (Some(Misbehaviour::StatusRetained), RobotTopic::Status) => (qos(kind), true),
        (Some(Misbehaviour::AnswersAtMostOnce), RobotTopic::SetpointState) => (QoS::AtMostOnce, false),
        (Some(_) | None, _) => (qos(kind), kind.is_retained()),
    };
    PublishOptions::new(quality).retain(is_retained && retains)
}

/// Polls the connection until it ends. `question` is a topic of the robot's subscriptions: subscribing again, which changes
/// nothing, shows whether a silent broker still answers.
async fn poll(mut event_loop: EventLoop, question: (AsyncClient, String), reports: mpsc::UnboundedSender<Report>) {
    let mut silence = Silence::new(Instant::now());
    let mut is_subscribed = false;
    loop {
        let report = match next_event(&mut event_loop, &mut silence, &question).await {
            None => Some(Report::Gone("the broker has stopped answering".to_owned())),
            Some(Ok(Event::Incoming(packet))) => {
                silence.heard(Instant::now());
                report_of(packet).filter(|report| !(is_subscribed && matches!(report, Report::Subscribed)))
            }
            Some(Ok(Event::Outgoing(_) | Event::Auth(_))) => None,
            Some(Err(ConnectionError::ConnectionRefused(ConnectReturnCode::RetainNotSupported))) => {
                Some(Report::RetainRefused)
            }
            Some(Err(error)) => Some(Report::Gone(error.to_string())),
        };
        let Some(report) = report else { continue };
        is_subscribed |= matches!(report, Report::Subscribed);
        let ends = matches!(report, Report::Gone(_) | Report::RetainRefused);
        // Without a receiver, the driver has dropped the connection.
        if reports.send(report).is_err() || ends {
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
                Measure::Ask => drop(client.try_subscribe(topic.clone(), qos(RobotTopic::Receipt))),
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
        Packet::SubAck(_) => Some(Report::Subscribed),
        Packet::Publish(publish) => match Topic::parse(std::str::from_utf8(&publish.topic).ok()?) {
            Ok(Topic::Robot { kind, .. }) => Some(Report::Received(kind, publish.payload.to_vec())),
            Ok(Topic::SupervisorRequest { .. }) => Some(Report::ReceivedByAll(publish.payload.to_vec())),
            Ok(Topic::SupervisorState { .. }) | Err(_) => None,
        },
        _ => None,
    }
}
