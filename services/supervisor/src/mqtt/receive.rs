//! The receiving connection: puts all messages of robots into the inbox.

use std::convert::Infallible;
use std::sync::{MutexGuard, PoisonError};

use rumqttc::{AsyncClient, ClientError, Event, Packet, PublishOptions, PublishProperties};
use tokio::sync::watch;
use tokio::task::yield_now;
use tokio::time::Instant;
use vibrissa_host::task;
use vibrissa_protocol::{RobotTopic, plain};

use super::births::{BirthRequests, Pace};
use super::coalescing::{PAUSE, PollCoalescing};
use super::hearing::{Hearing, Tick};
use super::link::Side;
use super::nodes::Attempts;
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem, STOPPED};
use super::proofs::is_failure;
use super::subscriptions::{self, Subscriptions, inputs};
use super::{Connection, limits};
use crate::births::BirthCause;
use crate::ending::stopped;
use crate::inbox::{Inbox, Intake, inbox};
use crate::metrics::{FleetMetrics, RECEIVING};

/// Limit of this connection's publications without an acknowledgement: one probe per topic, and a request for births. The client scans a table of
/// this size at each write.
const IN_FLIGHT: u16 = 8;
/// MQTT message expiry of a probe and of a request for births, s. Robots that connect later announce themselves.
const EXPIRY_S: u32 = 15;

/// Returns the inbox, and the future that fills it until `stop`. Alone with its engine in a thread, it sleeps between two
/// reads ([`super::coalescing`]).
pub fn receive(
    connection: &Connection,
    metrics: FleetMetrics,
    mut stop: watch::Receiver<bool>,
) -> (Inbox, impl Future<Output = ()> + Send + 'static) {
    let (intake, inbox) = inbox(metrics.clone());
    let connection = Attempts::first(connection);
    let subscriptions = Subscriptions::new(connection.fleet.clone());
    let subscriptions = if connection.hears_contacts { subscriptions } else { subscriptions.without_contacts() };
    let attempts = Attempts::new();
    let mut receiver = Receiver { connection, metrics: metrics.clone(), intake, attempts, subscriptions };
    let receiving = async move {
        tokio::select! {
            () = receiver.run() => {}
            () = stopped(&mut stop) => {}
        }
        metrics.broker_connected.set(0);
        metrics.mqtt_node.forget(RECEIVING);
    };
    (inbox, receiving)
}

struct Receiver {
    connection: Connection,
    metrics: FleetMetrics,
    intake: Intake,
    attempts: Attempts,
    subscriptions: Subscriptions,
}

impl Receiver {
    /// Connects again and again; never ends.
    async fn run(&mut self) {
        loop {
            let problem = self.listen().await;
            self.set_hears(false);
            self.metrics.mqtt_node.forget(RECEIVING);
            self.metrics.mqtt_node_failures.count(&problem.node().to_string());
            if problem.is_takeover() {
                self.metrics.mqtt_session_takeovers.inc();
            }
            self.connection.link.broken(Side::Receiving, &problem);
            self.connection = self.attempts.next(&self.connection, &problem).await;
        }
    }

    /// One connection, from the attempt to its end. Each has a new client, so that messages queued for the last
    /// connection are not sent on the next.
    async fn listen(&mut self) -> Problem {
        match self.hear().await {
            Ok(never) => match never {},
            Err(problem) => problem,
        }
    }

    async fn hear(&mut self) -> Result<Infallible, Problem> {
        let (mut options, reached) = self.connection.options("in");
        options.set_outgoing_inflight_upper_limit(IN_FLIGHT);
        let (client, events) = AsyncClient::builder(options).capacity(64).build();
        let mut poller = Poller::new(events, &self.connection, reached);
        let mut coalescing = PollCoalescing::new(Instant::now());
        let mut hearing = Hearing::new(&self.connection.fleet, self.subscriptions.kinds(), Instant::now());
        let (mut is_subscribed, mut retained) = (false, Pace::default());
        loop {
            let event = match poller.ready() {
                Some(event) => event,
                None => {
                    let messages = self.intake.hand_over();
                    if messages > 0 {
                        // Let the engine process the messages before the next read.
                        yield_now().await;
                    }
                    if is_subscribed {
                        self.request_births(&client)?;
                    }
                    if let Some(cause) = self.intake.take_wanted() {
                        self.births().pace.want(cause);
                        retained.want(cause);
                    }
                    let now = Instant::now();
                    if retained.take_due(now).is_some() {
                        // A new subscription makes the broker send its retained messages again: for robots that do not
                        // know the request.
                        let again = self.subscriptions.retained();
                        self.subscribe(&client, again)?;
                    }
                    if !self.connection.occupancy.is_shared() && coalescing.pauses(now, messages) {
                        // Blocks the thread, because in an asynchronous sleep each arriving message would wake the
                        // runtime.
                        task::block_for(PAUSE);
                    }
                    let judge = |hearing: &mut Hearing| {
                        judge(&client, hearing, &self.connection, |topics| {
                            for topic in topics {
                                self.metrics.mqtt_probe_failures.count([topic.as_str()]);
                            }
                        })
                    };
                    // With messages arriving all the time, the wait below never becomes idle.
                    if now >= hearing.due() {
                        judge(&mut hearing)?;
                    }
                    match poller.next_while(&mut hearing, judge).await? {
                        Ok(event) => event,
                        Err(Failure::Broken(problem)) => return Err(problem),
                        Err(Failure::Finished) => return Err(self.problem(Cause::Lost(STOPPED.to_owned()))),
                    }
                }
            };
            match event {
                Event::Incoming(Packet::ConnAck(ack)) => {
                    if let Some(what) = limits::unusable(&ack) {
                        return Err(self.problem(Cause::Lacks(what)));
                    }
                    self.connection.link.limited(&self.connection.broker.node(), limits::low(&ack));
                    let all = self.subscriptions.begin();
                    self.subscribe(&client, all)?;
                    hearing.asked(Instant::now());
                }
                Event::Incoming(Packet::SubAck(ack)) => {
                    if let Err(refused) = self.subscriptions.acknowledged(&ack.return_codes) {
                        return Err(self.problem(Cause::Subscription(refused)));
                    }
                    if self.subscriptions.are_complete() {
                        if !std::mem::replace(&mut is_subscribed, true) {
                            self.births().pace.want(BirthCause::Connected);
                        }
                        hearing.subscribed(Instant::now());
                    }
                }
                Event::Incoming(Packet::PubAck(ack)) if is_failure(&ack) => {
                    hearing.refused();
                    self.set_hears(false);
                    let (fleet, why) =
                        (self.connection.fleet.clone(), plain::reason_code(&format!("{:?}", ack.reason)));
                    let problem = self.problem(Cause::ProbeRefused { fleet, why });
                    self.connection.link.broken(Side::Receiving, &problem);
                }
                Event::Incoming(Packet::PubAck(_)) => hearing.acknowledged(),
                Event::Incoming(Packet::Publish(publish)) => {
                    let was_proven = hearing.is_proven();
                    if !hearing.take(&publish.topic, &publish.payload) {
                        self.intake.take(publish.topic, publish.payload);
                    }
                    if !was_proven && hearing.is_proven() {
                        self.proven(&hearing);
                    }
                }
                Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => {}
            }
        }
    }

    fn births(&self) -> MutexGuard<'_, BirthRequests> {
        self.connection.births.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn subscribe(&self, client: &AsyncClient, packet: subscriptions::Packet) -> Result<(), Problem> {
        client.try_subscribe_many(inputs(packet)).map_err(|error| self.lost(&error))
    }

    /// Publishes a request for births, if one is due.
    fn request_births(&mut self, client: &AsyncClient) -> Result<(), Problem> {
        let Some(cause) = self.births().pace.take_due(Instant::now()) else { return Ok(()) };
        let (topic, payload) = self.births().message(&self.connection);
        client.try_publish(topic, payload, expiring()).map_err(|error| self.lost(&error))?;
        self.metrics.birth_requests.count([cause.word()]);
        Ok(())
    }

    /// Sets whether robots are heard. Returns whether they were before.
    fn set_hears(&self, hears: bool) -> bool {
        self.metrics.broker_connected.set(hears.into());
        self.metrics.promises.heard(hears);
        self.intake.set_hears(hears)
    }

    /// Records that every subscription is proven: robots are heard.
    fn proven(&mut self, hearing: &Hearing) {
        if let Some(round_trip) = hearing.round_trip() {
            self.metrics.mqtt_probe_round_trip_seconds.set(round_trip.as_secs_f64());
        }
        self.attempts.reset();
        if !self.set_hears(true) {
            self.metrics.broker_connections.inc();
        }
        let node = self.connection.broker.node();
        self.metrics.mqtt_node.set(RECEIVING, &node.to_string());
        if self.connection.link.connected(Side::Receiving, &node) {
            self.metrics.mqtt_connections_closed.inc();
        }
    }

    fn lost(&self, error: &ClientError) -> Problem {
        Problem::of_client(&self.connection.broker, error)
    }

    fn problem(&self, cause: Cause) -> Problem {
        Problem::new(&self.connection.broker, cause)
    }
}

/// Publishes probes when they are due, and judges the missing ones.
///
/// # Errors
/// Probes are overdue; `deaf` gets their topics.
pub(super) fn judge(
    client: &AsyncClient,
    hearing: &mut Hearing,
    connection: &Connection,
    deaf: impl FnOnce(&[RobotTopic]),
) -> Result<(), Problem> {
    let problem = |cause| Problem::new(&connection.broker, cause);
    match hearing.tick(Instant::now()) {
        Tick::Wait => Ok(()),
        Tick::Probe => hearing.probes().try_for_each(|(topic, payload)| {
            let sent = client.try_publish(topic, payload.to_vec(), expiring());
            sent.map_err(|error| Problem::of_client(&connection.broker, &error))
        }),
        Tick::Unsubscribed => Err(problem(Cause::Silent)),
        Tick::Deaf { topics, is_silent } => {
            deaf(&topics);
            Err(problem(Cause::Unheard { fleet: connection.fleet.clone(), topics, is_silent }))
        }
    }
}

/// QoS 1, so that the broker acknowledges or rejects the message.
fn expiring() -> PublishOptions {
    let expiry = PublishProperties { message_expiry_interval: Some(EXPIRY_S), ..PublishProperties::default() };
    PublishOptions::at_least_once().properties(expiry)
}
