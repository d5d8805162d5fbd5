//! Simulated robots in simulated time, with the true time, as clients of the model broker.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use bytes::Bytes;
use rand::{Rng as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use rumqttc::{LastWill, Packet, QoS};
use tokio::sync::Notify;
use tokio::time::{Instant, sleep, sleep_until, timeout};
use vibrissa_host::task;
use vibrissa_protocol::{QualityOfService, RobotTopic, Topic};
use vibrissa_robot::contract::Outgoing;
use vibrissa_robot::mqtt::Delivery;
use vibrissa_simulator::{JournalEntry, Robot};

use crate::broker::{Client, ClientOptions, ModelBroker};

/// Topics that a robot subscribes to, beside the request to all robots of its fleet.
const SUBSCRIBED: [RobotTopic; 4] =
    [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request, RobotTopic::Estimate];
/// Pause before a further attempt to connect.
const RECONNECT: std::ops::Range<u64> = 200..2_000;
/// Time limit of an attempt to connect.
const CONNECT_PATIENCE: Duration = Duration::from_secs(3);

/// A robot, shared by its task and the world.
#[derive(Debug, Clone)]
pub struct SimulatedRobot(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    robot: Mutex<Robot>,
    /// The start of the world, and the true time then, µs since 1970 UTC.
    began: (Instant, i64),
    /// Whether its connection is to be cut.
    cut: Notify,
    is_off: AtomicBool,
}

impl SimulatedRobot {
    /// Starts the robot's task. `began` is the start of the world and the true time then.
    #[must_use]
    pub fn start(robot: Robot, broker: &ModelBroker, began: (Instant, i64), seed: u64) -> Self {
        let inner = Inner { robot: Mutex::new(robot), began, cut: Notify::new(), is_off: AtomicBool::new(false) };
        let robot = Self(Arc::new(inner));
        task::spawn(run(robot.clone(), broker.clone(), ChaCha8Rng::seed_from_u64(seed)));
        robot
    }

    /// Gives `look` the robot.
    pub fn with<T>(&self, look: impl FnOnce(&mut Robot) -> T) -> T {
        look(&mut self.robot())
    }

    /// What it has felt, heard and applied since the last call.
    #[must_use]
    pub fn take_journal(&self) -> Vec<JournalEntry> {
        self.robot().take_journal()
    }

    /// Breaks its connection without a farewell. It connects again after a pause.
    pub fn cut(&self) {
        self.0.cut.notify_one();
    }

    /// Keeps it from connecting, or lets it connect again.
    pub fn set_off(&self, is_off: bool) {
        self.0.is_off.store(is_off, Ordering::Relaxed);
        if is_off {
            self.cut();
        }
    }

    /// Its client id.
    #[must_use]
    pub fn client_id(&self) -> String {
        let robot = self.robot();
        format!("{}-{}", robot.fleet(), robot.name())
    }

    /// Whether it has no contacts without a receipt. Only meaningful for a robot at rest.
    #[must_use]
    pub fn is_receipted(&self) -> bool {
        let robot = self.robot();
        robot.messages_kept() == 0 && robot.next_deadline() > robot.start_us()
    }

    /// Its time, µs since 1970 UTC.
    fn now_us(&self) -> u64 {
        let (began, at_us) = self.0.began;
        let since_us = i64::try_from(began.elapsed().as_micros()).unwrap_or(i64::MAX);
        let now_us = at_us + since_us;
        u64::try_from(now_us).unwrap_or_default()
    }

    /// When its next work is due.
    fn due(&self) -> Instant {
        let (at_us, now_us) = (self.robot().next_deadline(), self.now_us());
        Instant::now() + Duration::from_micros(at_us.saturating_sub(now_us).clamp(1, 3_600_000_000))
    }

    fn robot(&self) -> MutexGuard<'_, Robot> {
        self.0.robot.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn will(&self) -> LastWill {
        let robot = self.robot();
        let topic = RobotTopic::Connection.of(robot.fleet(), robot.name()).to_string();
        let delivery = Delivery::of(RobotTopic::Connection);
        let payload = robot.will(self.now_us());
        LastWill {
            topic: topic.into(),
            message: payload.into(),
            qos: qos(delivery.quality),
            retain: delivery.is_retained,
            properties: None,
        }
    }

    fn subscriptions(&self) -> Vec<String> {
        let robot = self.robot();
        let own = SUBSCRIBED.iter().map(|topic| topic.of(robot.fleet(), robot.name()).to_string());
        own.chain([Topic::SupervisorRequest { fleet: robot.fleet().clone() }.to_string()]).collect()
    }

    fn receive(&self, topic: &[u8], payload: &Bytes) -> Vec<Outgoing> {
        let now_us = self.now_us();
        let mut robot = self.robot();
        let level = topic.rsplit(|byte| *byte == b'/').next().unwrap_or_default();
        let of_robot = topic.windows(robot.name().as_str().len() + 2).any(|part| {
            part.first() == Some(&b'/')
                && part.last() == Some(&b'/')
                && &part[1..part.len() - 1] == robot.name().as_str().as_bytes()
        });
        match RobotTopic::ALL.into_iter().find(|kind| kind.as_str().as_bytes() == level).filter(|_| of_robot) {
            Some(kind) => robot.receive(kind, payload, now_us),
            None => {
                robot.receive_request_to_all(payload, now_us);
                Vec::new()
            }
        }
    }
}

fn qos(quality: QualityOfService) -> QoS {
    match quality {
        QualityOfService::AtMostOnce => QoS::AtMostOnce,
        QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
    }
}

/// Connects again and again, for ever.
async fn run(robot: SimulatedRobot, broker: ModelBroker, mut random: ChaCha8Rng) {
    loop {
        if !robot.0.is_off.load(Ordering::Relaxed) {
            connect(&robot, &broker).await;
            robot.robot().disconnected();
        }
        let pause = Instant::now() + Duration::from_millis(random.random_range(RECONNECT));
        // Contacts are made and stored without a connection, too.
        while Instant::now() < pause {
            let due = robot.due().min(pause);
            sleep_until(due).await;
            robot.robot().poll(robot.now_us());
        }
    }
}

/// One connection, from its beginning to its end.
async fn connect(robot: &SimulatedRobot, broker: &ModelBroker) {
    let options = ClientOptions { will: Some(robot.will()), ..ClientOptions::new(robot.client_id()) };
    let Ok(Ok(mut client)) = timeout(CONNECT_PATIENCE, Client::connect(broker, options)).await else {
        return sleep(Duration::from_millis(1)).await;
    };
    let subscriptions = robot.subscriptions();
    client.subscribe(subscriptions.iter().map(String::as_str));
    loop {
        let outgoing = tokio::select! {
            biased;
            () = robot.0.cut.notified() => return,
            packet = client.recv() => match packet {
                None => return,
                Some(Packet::SubAck(_)) => robot.robot().connected(robot.now_us()),
                Some(Packet::Publish(publish)) => robot.receive(&publish.topic, &publish.payload),
                Some(_) => Vec::new(),
            },
            () = sleep_until(robot.due()) => robot.robot().poll(robot.now_us()),
        };
        for one in outgoing {
            match one {
                Outgoing::Restart => return,
                Outgoing::Publish { topic, payload } => {
                    let (name, delivery) = {
                        let robot = robot.robot();
                        (topic.of(robot.fleet(), robot.name()).to_string(), Delivery::of(topic))
                    };
                    client.publish(&name, payload, qos(delivery.quality), delivery.is_retained);
                }
            }
        }
    }
}
