//! Connects a robot to its broker, again and again, and carries its messages.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rumqttc::{
    AsyncClient, LastWill, MqttOptions, NetworkOptions, PublishOptions, QoS, SubscribeFilterInput, Transport,
};
use tokio::sync::{Notify, mpsc, watch};
use tokio::time::{Instant, sleep_until, timeout};
use vibrissa_host::task;
use vibrissa_protocol::{Name, PAYLOAD_MAX_BYTES, QualityOfService, RobotTopic, Topic};

use super::broker::{Broker, address};
use super::connection::{Attempt, Connection, REPORTS, Report, next_report, poll, qos};
use crate::clock::now;
use crate::contract::{Moment, Now, Outgoing};

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
/// Most problems that are remembered as told.
const TOLD_MAX: usize = 32;
const FAREWELL_TIMEOUT: Duration = Duration::from_secs(2);

/// A robot that this module connects. Its methods must not block.
pub trait Endpoint {
    /// Fleet of the robot.
    fn fleet(&self) -> Name;
    /// Name of the robot.
    fn robot(&self) -> Name;
    /// Last will for the next connection.
    fn will(&self, now: Now) -> Vec<u8>;
    /// The connection is established with its subscriptions.
    fn connected(&self, now: Now) -> Vec<Outgoing>;
    /// The connection is lost.
    fn disconnected(&self);
    /// Does the work that is due; also returns the moment of the next work.
    fn poll(&self, now: Now) -> (Vec<Outgoing>, Moment);
    /// A message has arrived on one of the robot's topics.
    fn receive(&self, topic: RobotTopic, payload: &[u8], now: Now) -> Vec<Outgoing>;
    /// A message has arrived on the fleet's `supervisor/request`.
    fn receive_request_to_all(&self, payload: &[u8], now: Now);
    /// Messages before a clean disconnect.
    fn farewell(&self, now: Now) -> Vec<Outgoing>;
    /// Delivery of the messages on a topic: that of the contract, except for a robot that shall break it on purpose.
    fn delivery(&self, topic: RobotTopic) -> Delivery {
        Delivery::of(topic)
    }
    /// Filter of a further subscription: none, except for a robot that shall break the contract on purpose.
    fn further_filter(&self) -> Option<String> {
        None
    }
    /// Whether the broker retains the last will: as the contract requires, except for a robot that shall break it on purpose.
    fn is_will_retained(&self) -> bool {
        true
    }
}

/// Delivery of messages.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Delivery {
    /// Quality of service.
    pub quality: QualityOfService,
    /// Whether the broker retains the last message.
    pub is_retained: bool,
}

impl Delivery {
    /// The contract's delivery on a topic.
    #[must_use]
    pub fn of(topic: RobotTopic) -> Self {
        Self { quality: topic.quality_of_service(), is_retained: topic.is_retained() }
    }
}

/// Signals to the task of a robot.
#[derive(Debug, Default)]
pub struct Signals {
    /// Cut the connection without a farewell; it is renewed after a moment.
    pub cut: Notify,
    /// [`Endpoint::poll`] has work that was not known before.
    pub wake: Notify,
}

/// Runs a robot's connection until `stopping` changes.
pub async fn run<E: Endpoint>(
    robot: E,
    broker: Broker,
    transport: Transport,
    signals: Arc<Signals>,
    mut stopping: watch::Receiver<bool>,
) {
    let mut session = Session::new(robot, broker, transport);
    loop {
        tokio::select! {
            _ = stopping.changed() => break,
            () = signals.cut.notified() => session.lose("cut on request"),
            () = signals.wake.notified() => session.wake_soon(),
            () = sleep_until(session.wake_at) => session.work().await,
            () = sleep_until(session.connect_at), if session.connection.is_none() => session.connect(),
            report = next_report(&mut session.connection) => session.take(report).await,
        }
    }
    session.farewell().await;
}

struct Session<E> {
    robot: E,
    broker: Broker,
    /// Number of failed connections. Each makes the next attempt go to the next node of the broker.
    failures: usize,
    transport: Transport,
    /// Problems that were logged since the last connection: each is logged once.
    logged: BTreeSet<String>,
    fleet: Name,
    name: Name,
    connection: Option<Connection>,
    connect_at: Instant,
    reconnect_pause: Duration,
    wake_at: Instant,
    /// Time of the last work.
    woken_at: Instant,
    /// Whether the broker retains messages, as far as it has said.
    retains: bool,
}

impl<E: Endpoint> Session<E> {
    fn new(robot: E, broker: Broker, transport: Transport) -> Self {
        let now = Instant::now();
        let (fleet, name) = (robot.fleet(), robot.robot());
        Self {
            robot,
            broker,
            failures: 0,
            transport,
            logged: BTreeSet::new(),
            fleet,
            name,
            connection: None,
            connect_at: now,
            reconnect_pause: RECONNECT_START,
            wake_at: now,
            woken_at: now,
            retains: true,
        }
    }

    fn topic(&self, kind: RobotTopic) -> String {
        kind.of(&self.fleet, &self.name).to_string()
    }

    /// Name of the robot in the whole installation, such as `hall/crawler-83`.
    fn full_name(&self) -> String {
        format!("{}/{}", self.fleet, self.name)
    }

    /// Polls the robot and plans the next time.
    async fn work(&mut self) {
        self.woken_at = Instant::now();
        let (outgoing, deadline) = self.robot.poll(now());
        self.send(outgoing).await;
        // From the clock rather than by adding pauses, so that a delay is caught up.
        let ahead = Duration::from_micros(deadline.since(now().at));
        self.wake_at = Instant::now() + ahead.clamp(WAKE_PAUSE, Duration::from_secs(1));
    }

    /// Lets the robot work soon, but not more often than at [`WAKE_PAUSE`].
    fn wake_soon(&mut self) {
        self.wake_at = self.wake_at.min(self.woken_at + WAKE_PAUSE);
    }

    /// Host and port of the node that is in turn.
    fn node(&self) -> (String, u16) {
        let nodes = self.broker.nodes();
        nodes[self.failures % nodes.len()].clone()
    }

    /// Reads the files of the broker's configuration again, which somebody may have corrected.
    fn read_again(&mut self) {
        match self.broker.read_again() {
            Ok(transport) => self.transport = transport.unwrap_or_else(|| self.transport.clone()),
            Err(problem) => self.tell(format!("{problem}; the content before is used")),
        }
    }

    fn connect(&mut self) {
        if self.failures > 0 {
            self.read_again();
        }
        let will = self.robot.will(now());
        let is_will_retained = self.retains && self.robot.is_will_retained();
        let topic = self.topic(RobotTopic::Connection);
        // The client id is the robot's topic prefix in the contract: a second robot of that name takes over the
        // session.
        let id = format!("{}.{}", self.fleet, self.name);
        let (host, port) = self.node();
        let mut options = MqttOptions::new(id, (host.clone(), port));
        if !self.broker.others.is_empty() {
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
        let credentials = self.broker.credentials_of(&self.fleet, &self.name);
        if let Some((user, password)) = credentials.clone() {
            options.set_credentials(user, password.into_bytes());
        }
        options.set_transport(self.transport.clone());
        // The library's own address lacks the brackets around IPv6.
        let address = address(&host, port);
        let is_reached = Arc::new(AtomicBool::new(false));
        let broker = Broker { credentials, ..self.broker.clone() };
        let attempt = Attempt { broker, host: host.clone(), is_reached: is_reached.clone() };
        options.set_socket_connector(move |_, network| {
            let (address, is_reached) = (address.clone(), is_reached.clone());
            async move {
                let stream = rumqttc::default_socket_connect(address, network).await?;
                is_reached.store(true, Ordering::Relaxed);
                Ok(stream)
            }
        });
        let mut network = NetworkOptions::new();
        network.set_tcp_nodelay(true);
        options.set_network_options(network);
        let (client, event_loop) = AsyncClient::builder(options).capacity(REQUESTS).build();
        let (sender, reports) = mpsc::channel(REPORTS);
        let question = (client.clone(), self.topic(RobotTopic::Receipt));
        let poller = task::spawn(poll(event_loop, question, attempt, sender));
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
            Report::Subscribed { refused } => {
                self.reconnect_pause = RECONNECT_START;
                self.logged.clear();
                self.tell_refused(&refused);
                let outgoing = self.robot.connected(now());
                self.send(outgoing).await;
                tracing::debug!(robot = self.full_name(), "connected");
            }
            Report::Received(topic, payload) => {
                let outgoing = self.robot.receive(topic, &payload, now());
                self.send(outgoing).await;
                // A receipt may have made the next window due immediately.
                self.wake_at = self.wake_at.min(Instant::now() + WAKE_PAUSE);
            }
            Report::ReceivedByAll(payload) => {
                self.robot.receive_request_to_all(&payload, now());
                self.wake_at = self.wake_at.min(Instant::now() + WAKE_PAUSE);
            }
            Report::Gone(reason) => self.lose(&reason),
        }
    }

    fn publish_options(&self, kind: RobotTopic) -> PublishOptions {
        publish_options(self.robot.delivery(kind), self.retains)
    }

    /// Topics that the robot subscribes to, in the order of the request.
    fn subscriptions(&self) -> Vec<(String, QualityOfService)> {
        let own = |kind: RobotTopic| (self.topic(kind), kind.quality_of_service());
        let to_all = Topic::SupervisorRequest { fleet: self.fleet.clone() }.to_string();
        let further = self.robot.further_filter().map(|filter| (filter, QualityOfService::AtLeastOnce));
        [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request, RobotTopic::Estimate]
            .map(own)
            .into_iter()
            .chain([(to_all, QualityOfService::AtLeastOnce)])
            .chain(further)
            .collect()
    }

    async fn subscribe(&mut self) {
        let filters =
            self.subscriptions().into_iter().map(|(topic, quality)| SubscribeFilterInput::new(topic, qos(quality)));
        if let Some(connection) = &self.connection
            && let Err(error) = connection.client.subscribe_many(filters).await
        {
            self.lose(&error.to_string());
        }
    }

    /// Logs the topics that the broker refuses. The robot goes on without them: contacts and statuses still arrive.
    fn tell_refused(&self, refused: &[usize]) {
        let topics = self.subscriptions();
        for (topic, _) in refused.iter().filter_map(|&position| topics.get(position)) {
            tracing::warn!(
                robot = self.full_name(),
                topic,
                "the broker refuses this subscription, and the robot does not get its messages: let the robot read the topic \
                 in the broker's access list, and start the agent again"
            );
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
        self.robot.disconnected();
        let (host, port) = self.node();
        self.tell(format!("MQTT broker {}: {reason}", address(&host, port)));
        self.failures += 1;
        if !self.failures.is_multiple_of(self.broker.others.len() + 1) {
            self.connect_at = Instant::now();
            return;
        }
        self.connect_at = Instant::now() + self.reconnect_pause;
        self.reconnect_pause = (self.reconnect_pause * 2).min(RECONNECT_MAX);
    }

    /// Logs a problem, unless it was logged since the last connection: attempts go on for as long as it lasts.
    fn tell(&mut self, problem: String) {
        if self.logged.contains(&problem) {
            return tracing::debug!(robot = self.full_name(), "{problem}");
        }
        tracing::warn!(robot = self.full_name(), "{problem}; trying again until it succeeds");
        if self.logged.len() < TOLD_MAX {
            self.logged.insert(problem);
        }
    }

    /// Publishes the farewell and disconnects cleanly, if that succeeds in time.
    async fn farewell(mut self) {
        if timeout(FAREWELL_TIMEOUT, self.leave()).await.is_err() {
            tracing::warn!(robot = self.full_name(), "farewell timed out");
        }
    }

    async fn leave(&mut self) {
        let outgoing = self.robot.farewell(now());
        let Some(mut connection) = self.connection.take() else {
            return;
        };
        for item in outgoing {
            let Outgoing::Publish { topic, payload } = item else {
                continue;
            };
            let options = self.publish_options(topic);
            let publish = connection.client.publish_tracked(self.topic(topic), payload, options);
            // A disconnect may overtake queued messages, so wait for the broker's acknowledgement of the farewell.
            if let Ok(notice) = publish.await
                && let Err(error) = notice.wait_async().await
            {
                tracing::warn!(robot = self.full_name(), %error, "farewell not acknowledged");
            }
        }
        if connection.client.disconnect().await.is_ok() {
            // The polling task ends once the disconnect has been sent.
            let _ = (&mut connection.poller).await;
        }
    }
}

/// Without the retain flag if the broker retains no messages: it would end the connection (MQTT 5, 3.2.2.3.5).
fn publish_options(delivery: Delivery, retains: bool) -> PublishOptions {
    PublishOptions::new(qos(delivery.quality)).retain(delivery.is_retained && retains)
}

#[cfg(test)]
mod tests;
