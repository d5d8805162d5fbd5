//! A robot of a running fleet: shared by its connection, the state file and whoever disturbs it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Notify;
use vibrissa_protocol::{Name, RobotTopic, Topic};
use vibrissa_robot::contract::{Moment, Now};
use vibrissa_robot::mqtt::{self, Delivery, Signals};

use crate::clock::at_us;
use crate::scenario::Misbehaviour;
use crate::{Outgoing, Robot};

/// One robot of a running fleet, for access to its true state and for disturbances.
#[derive(Debug, Clone)]
pub struct RobotHandle {
    name: Name,
    robot: Arc<Mutex<Robot>>,
    pub(crate) signals: Arc<Signals>,
    /// Notified when something happens to any robot of the fleet.
    changed: Arc<Notify>,
}

impl RobotHandle {
    pub(crate) fn new(robot: Robot, changed: Arc<Notify>) -> Self {
        let (name, signals) = (robot.name().clone(), Arc::new(Signals::default()));
        Self { name, robot: Arc::new(Mutex::new(robot)), signals, changed }
    }

    /// Name of the robot.
    #[must_use]
    pub fn name(&self) -> &Name {
        &self.name
    }

    /// Calls `look` with the robot, which is locked meanwhile: keep it short.
    pub fn with<R>(&self, look: impl FnOnce(&mut Robot) -> R) -> R {
        look(&mut self.lock())
    }

    /// Cuts the connection without a farewell; the robot reconnects after a moment.
    pub fn cut(&self) {
        self.signals.cut.notify_one();
    }

    /// Even after a panic during an access, the robot's state is the best one available.
    fn lock(&self) -> MutexGuard<'_, Robot> {
        self.robot.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl mqtt::Endpoint for RobotHandle {
    fn fleet(&self) -> Name {
        self.with(|robot| robot.fleet().clone())
    }

    fn robot(&self) -> Name {
        self.name.clone()
    }

    fn will(&self, now: Now) -> Vec<u8> {
        self.with(|robot| robot.will(at_us(now)))
    }

    fn connected(&self, now: Now) -> Vec<Outgoing> {
        self.with(|robot| robot.connected(at_us(now)))
    }

    fn disconnected(&self) {
        self.with(Robot::disconnected);
    }

    fn poll(&self, now: Now) -> (Vec<Outgoing>, Moment) {
        let (outgoing, deadline_us, has_changed) =
            self.with(|robot| (robot.poll(at_us(now)), robot.next_deadline(), robot.take_change()));
        if has_changed {
            self.changed.notify_one();
        }
        (outgoing, now.at + deadline_us.saturating_sub(at_us(now)))
    }

    fn receive(&self, topic: RobotTopic, payload: &[u8], now: Now) -> Vec<Outgoing> {
        self.with(|robot| robot.receive(topic, payload, at_us(now)))
    }

    fn receive_request_to_all(&self, payload: &[u8], now: Now) {
        self.with(|robot| robot.receive_request_to_all(payload, at_us(now)));
    }

    fn farewell(&self, now: Now) -> Vec<Outgoing> {
        self.with(|robot| robot.farewell(at_us(now)))
    }

    fn delivery(&self, topic: RobotTopic) -> Delivery {
        self.with(|robot| robot.delivery(topic))
    }

    fn further_filter(&self) -> Option<String> {
        let is_asked = |robot: &mut Robot| robot.misbehaviour() == Some(Misbehaviour::ListensElsewhere);
        let topic = Topic::SupervisorState { fleet: mqtt::Endpoint::fleet(self) };
        self.with(is_asked).then(|| topic.to_string())
    }

    fn is_will_retained(&self) -> bool {
        self.with(|robot| robot.misbehaviour() != Some(Misbehaviour::WillNotRetained))
    }
}
