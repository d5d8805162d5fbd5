//! The connection that receives: everything that robots say goes into the inbox.

use std::time::Instant;

use rumqttc::{AsyncClient, Event, Packet, QoS, SubAck, SubscribeFilterInput, SubscribeReasonCode};
use tokio::sync::watch;
use tokio::task::yield_now;
use vibrissa_protocol::{Name, RobotTopic};

use super::inbox::{Inbox, Intake, inbox};
use super::link::{Backoff, Side};
use super::pace::{PAUSE, Pace};
use super::poll::{Failure, Poller};
use super::problem::{Cause, Problem};
use super::{Connection, stopped};
use crate::metrics::FleetMetrics;

/// Publications of ours without an acknowledgement: there are none here, and the client goes through a table of this size
/// with each write.
const IN_FLIGHT: u16 = 8;

/// The inbox, and what fills it with everything that robots say, until `stop`: in a thread that has nothing to do but this and
/// what comes of it, for it sleeps between two looks at the network ([`super::pace`]).
pub fn receive(
    connection: &Connection,
    metrics: FleetMetrics,
    mut stop: watch::Receiver<bool>,
) -> (Inbox, impl Future<Output = ()> + Send + 'static) {
    let (intake, inbox) = inbox(metrics.clone());
    let mut receiver =
        Receiver { connection: connection.clone(), metrics: metrics.clone(), intake, backoff: Backoff::new() };
    let receiving = async move {
        tokio::select! {
            () = receiver.run() => {}
            () = stopped(&mut stop) => {}
        }
        metrics.broker_connected.set(0);
    };
    (inbox, receiving)
}

struct Receiver {
    connection: Connection,
    metrics: FleetMetrics,
    intake: Intake,
    backoff: Backoff,
}

impl Receiver {
    /// Never ends by itself.
    async fn run(&mut self) {
        loop {
            let problem = self.listen().await;
            self.metrics.broker_connected.set(0);
            self.connection.link.broken(Side::Receiving, &problem);
            tokio::time::sleep(self.backoff.pause()).await;
        }
    }

    /// One connection, from the attempt to its end. The client is a new one each time: nothing that waited
    /// for the last connection goes to the next.
    async fn listen(&mut self) -> Problem {
        let (mut options, reached) = self.connection.options("in");
        options.set_outgoing_inflight_upper_limit(IN_FLIGHT);
        let (client, events) = AsyncClient::builder(options).capacity(64).build();
        let mut poller = Poller::new(events, &self.connection, reached);
        let mut pace = Pace::new(Instant::now());
        loop {
            let event = match poller.ready() {
                Some(event) => event,
                None => {
                    let messages = self.intake.hand_over();
                    if messages > 0 {
                        // It is worked on before the next look.
                        yield_now().await;
                    }
                    // A new subscription brings what is retained once more.
                    if self.intake.take_missed()
                        && let Err(problem) = client.try_subscribe_many(self.filters(RobotTopic::is_retained))
                    {
                        return self.problem(Cause::Lost(problem.to_string()));
                    }
                    if pace.pauses(Instant::now(), messages) {
                        // Not awaited: what comes meanwhile would wake the runtime, one message after the other.
                        std::thread::sleep(PAUSE);
                    }
                    match poller.next().await {
                        Ok(event) => event,
                        Err(Failure::Broken(problem)) => return problem,
                        Err(Failure::Finished) => return self.problem(Cause::Lost("it was ended".to_owned())),
                    }
                }
            };
            let asked = match event {
                Event::Incoming(Packet::ConnAck(_)) => client.try_subscribe_many(self.filters(|_| true)),
                Event::Incoming(Packet::SubAck(ack)) => {
                    if let Some(refused) = self.refused(&ack) {
                        return self.problem(Cause::Subscription(refused));
                    }
                    // Connected means: robots are heard.
                    self.backoff.reset();
                    if self.metrics.broker_connected.get() == 0 {
                        self.metrics.broker_connections.inc();
                    }
                    self.metrics.broker_connected.set(1);
                    self.connection.link.connected(Side::Receiving);
                    Ok(())
                }
                Event::Incoming(Packet::Publish(publish)) => {
                    self.intake.take(publish.topic, publish.payload);
                    Ok(())
                }
                Event::Incoming(_) | Event::Outgoing(_) | Event::Auth(_) => Ok(()),
            };
            if let Err(problem) = asked {
                return self.problem(Cause::Lost(problem.to_string()));
            }
        }
    }

    fn filters(&self, which: impl Fn(RobotTopic) -> bool) -> Vec<SubscribeFilterInput> {
        let asked = |kind| SubscribeFilterInput::new(filter(kind, &self.connection.fleet), QoS::AtLeastOnce);
        heard().filter(|&kind| which(kind)).map(asked).collect()
    }

    /// What the broker does not let us read, and why; none if it lets us read everything.
    fn refused(&self, ack: &SubAck) -> Option<String> {
        let is_refused = |code: &SubscribeReasonCode| !matches!(code, SubscribeReasonCode::Success(_));
        let (at, code) = ack.return_codes.iter().enumerate().find(|(_, code)| is_refused(code))?;
        // In the order in which they were asked for; the first to be asked for again come first there, too.
        let topic = heard().nth(at).map(|kind| filter(kind, &self.connection.fleet));
        Some(format!("{} ({code:?})", topic.as_deref().unwrap_or("the robots' topics")))
    }

    fn problem(&self, cause: Cause) -> Problem {
        Problem::new(&self.connection.broker, cause)
    }
}

/// What robots say.
fn heard() -> impl Iterator<Item = RobotTopic> {
    RobotTopic::ALL.into_iter().filter(|kind| kind.is_from_robot())
}

fn filter(kind: RobotTopic, fleet: &Name) -> String {
    kind.fleet_filter(fleet)
}
