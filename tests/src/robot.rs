//! A robot controlled by the test: it sends only what the test tells it to send, and answers nothing on its own.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Serialize;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::robot::Params;
use vibrissa_core::units::{ContactRatio, Megapascal, Micros, Millimetre};
use vibrissa_protocol::{
    ArrayFacts, ArrayType, BootId, Connection, ConnectionState, Contact, Contacts, Factsheet, Gauge, Message,
    MissedTouch, Name, OnSupervisorLoss, Receipt, Regulator, RobotTopic, Segmenter, Setpoint, SetpointError,
    SetpointOutcome, SetpointState, Software, Status, TestState, Timestamp, TouchTest, TouchTestError, TouchTestKind,
    TouchTestOutcome, WhiskerFacts, WhiskerStatus, encode,
};
use vibrissa_simulator::clock::now_us;

use crate::observer::{Heard, Observer};
use crate::wait::{self, PATIENCE};

/// Name of its only array.
pub const ARRAY: &str = "left";
/// Number of contacts per message.
const CONTACTS_PER_MESSAGE: usize = 20;
/// Time between two contacts by the robot's clock, microseconds.
const CONTACT_US: u64 = 1_000;

/// A robot of fleet `f`.
pub struct HandRobot {
    /// Its connection, which can also publish anything else.
    pub mqtt: Observer,
    /// Name of its fleet.
    fleet: &'static str,
    /// Its current boot id.
    pub boot_id: BootId,
    /// Its clock, in microseconds since 1970 UTC.
    pub clock_us: u64,
    /// Factsheet of its array.
    pub array: ArrayFacts,
    /// Touch tests that its factsheet names; none at first.
    pub touch_tests: Vec<TouchTestKind>,
    /// Whether the factsheet states that the robot multiplies its readings.
    pub applies_gain: bool,
    /// Programs that its factsheet names; none at first.
    pub software: Vec<Software>,
    /// State of its segmenters in each status; none at first.
    pub segmenter: Option<Segmenter>,
    name: Name,
    model: Model,
    state: Vec<State>,
    seqs: BTreeMap<RobotTopic, u64>,
    heard: VecDeque<Heard>,
    noise: ChaCha8Rng,
    contacts: u64,
}

/// True state of a whisker.
struct State {
    length_mm: f64,
    pressure_mpa: f64,
}

/// Time without a receipt after which contacts are sent again. With few messages the supervisor sends receipts twice a
/// second.
const SEND_AGAIN: Duration = Duration::from_millis(600);

/// Parameters under which a robot that stays silent raises no alarm: on a slow machine that alarm would be among those
/// that a test counts.
#[must_use]
pub fn params() -> Params {
    let mut params = Params::nguyen_2021(Formulation::Published);
    params.health.stale_after = Micros(86_400_000_000);
    params
}

/// An array of whiskers at 0.1 MPa in which each whisker is a neighbour of the next.
#[must_use]
pub fn array(array_type: ArrayType, lengths_mm: &[f64]) -> ArrayFacts {
    let count = lengths_mm.len() as u16;
    let beside = |whisker: u16| [whisker.checked_sub(1), Some(whisker + 1).filter(|&right| right < count)];
    let whiskers = lengths_mm.iter().zip(0..).map(|(&length_mm, whisker)| WhiskerFacts {
        whisker,
        x_mm: 25.0 * f64::from(whisker),
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length_mm,
        pressure_mpa: 0.1,
        pressure_max_mpa: 0.2,
        neighbours: beside(whisker).into_iter().flatten().collect(),
        place: None,
        length_tolerance_mm: None,
        strain_max: None,
    });
    ArrayFacts { array: Name::new(ARRAY).expect("a name"), array_type, task: None, whiskers: whiskers.collect() }
}

impl HandRobot {
    /// Connects to a broker and publishes its birth; returns when the supervisor has accepted its first message.
    pub async fn born(port: u16, name: &str, array: ArrayFacts) -> Self {
        Self::born_in("f", port, name, array).await
    }

    /// The same in another fleet.
    pub async fn born_in(fleet: &'static str, port: u16, name: &str, array: ArrayFacts) -> Self {
        let mut robot = Self::connect_in(fleet, port, name, array).await;
        robot.birth().await;
        robot.settle().await;
        robot
    }

    /// Connects to a broker without publishing anything.
    ///
    /// # Panics
    /// No broker answers in time.
    pub async fn connect(port: u16, name: &str, array: ArrayFacts) -> Self {
        Self::connect_in("f", port, name, array).await
    }

    async fn connect_in(fleet: &'static str, port: u16, name: &str, array: ArrayFacts) -> Self {
        let filters = filters(fleet, name);
        let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
        Self::on(Observer::subscribed_as(port, name, None, &filters).await, fleet, name, array)
    }

    /// The same with a user and a password.
    ///
    /// # Panics
    /// No broker answers in time.
    pub async fn connect_as(port: u16, name: &str, user: Option<(&str, &str)>, array: ArrayFacts) -> Self {
        let filters = filters("f", name);
        let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
        Self::on(Observer::subscribed_as(port, name, user, &filters).await, "f", name, array)
    }

    /// Connects by MQTT 3.1.1.
    ///
    /// # Panics
    /// No broker answers in time.
    pub async fn connect_311(port: u16, name: &str, user: Option<(&str, &str)>, array: ArrayFacts) -> Self {
        let filters = filters("f", name);
        let filters: Vec<&str> = filters.iter().map(String::as_str).collect();
        Self::on(Observer::subscribed_311(port, name, user, &filters).await, "f", name, array)
    }

    fn on(mqtt: Observer, fleet: &'static str, name: &str, array: ArrayFacts) -> Self {
        let state = |facts: &WhiskerFacts| State { length_mm: facts.length_mm, pressure_mpa: facts.pressure_mpa };
        Self {
            mqtt,
            boot_id: boot_id(name, 1),
            clock_us: now_us(),
            state: array.whiskers.iter().map(state).collect(),
            array,
            touch_tests: Vec::new(),
            applies_gain: false,
            software: Vec::new(),
            segmenter: None,
            fleet,
            name: Name::robot(name).expect("a robot's name"),
            model: Model::nguyen_2021(Formulation::Published),
            seqs: BTreeMap::new(),
            heard: VecDeque::new(),
            noise: ChaCha8Rng::seed_from_u64(2021),
            contacts: 0,
        }
    }

    /// Its topic of this kind.
    #[must_use]
    pub fn topic(&self, kind: RobotTopic) -> String {
        format!("whisker/v1/{}/{}/{kind}", self.fleet, self.name)
    }

    /// Takes the sequence number of its next message on a topic.
    pub fn next_seq(&mut self, kind: RobotTopic) -> u64 {
        let next = self.seqs.entry(kind).or_default();
        *next += 1;
        *next - 1
    }

    /// Publishes any payload on one of its topics.
    pub async fn say(&self, kind: RobotTopic, payload: impl Into<Vec<u8>>) {
        self.mqtt.publish(&self.topic(kind), payload.into(), kind.is_retained()).await;
    }

    async fn tell(&self, kind: RobotTopic, message: &impl Serialize) {
        self.say(kind, encode(message)).await;
    }

    /// Publishes its connection state ONLINE, its factsheet and a status.
    pub async fn birth(&mut self) {
        self.connection(ConnectionState::Online).await;
        let factsheet = self.factsheet();
        self.tell(RobotTopic::Factsheet, &factsheet).await;
        self.status().await;
    }

    /// Publishes a connection state.
    pub async fn connection(&mut self, state: ConnectionState) {
        let seq = self.next_seq(RobotTopic::Connection);
        let message = Connection { boot_id: self.boot_id.clone(), seq, timestamp: Timestamp(self.clock_us), state };
        self.tell(RobotTopic::Connection, &message).await;
    }

    /// Its next factsheet.
    #[must_use]
    pub fn factsheet(&mut self) -> Factsheet {
        Factsheet {
            boot_id: self.boot_id.clone(),
            seq: self.next_seq(RobotTopic::Factsheet),
            timestamp: Timestamp(self.clock_us),
            model: "by-hand".to_owned(),
            on_supervisor_loss: OnSupervisorLoss::Hold,
            arrays: vec![self.array.clone()],
            touch_tests: self.touch_tests.clone(),
            applies_gain: self.applies_gain,
            air_control: None,
            software: self.software.clone(),
        }
    }

    /// Publishes a status in which each chamber has its target pressure.
    pub async fn status(&mut self) {
        let whiskers = self.array.whiskers.iter().zip(&self.state).map(|(facts, state)| WhiskerStatus {
            array: self.array.array.clone(),
            whisker: facts.whisker,
            pressure_mpa: state.pressure_mpa,
            setpoint_mpa: state.pressure_mpa,
            regulator: Regulator::Ok,
            gauge: Gauge::Ok,
            segmenter: self.segmenter,
        });
        let whiskers = whiskers.collect();
        let seq = self.next_seq(RobotTopic::Status);
        let status =
            Status { boot_id: self.boot_id.clone(), seq, t_us: self.clock_us, whiskers, contacts_dropped: None };
        self.tell(RobotTopic::Status, &status).await;
    }

    /// Begins a new boot with every chamber at its nominal pressure, without publishing it; see [`HandRobot::birth`].
    pub fn restart(&mut self) {
        self.boot_id = boot_id(self.name.as_str(), self.clock_us);
        self.seqs.clear();
        for (state, facts) in self.state.iter_mut().zip(&self.array.whiskers) {
            state.pressure_mpa = facts.pressure_mpa;
        }
    }

    /// Cuts a whisker to this length.
    pub fn cut(&mut self, whisker: u16, length_mm: f64) {
        self.state[usize::from(whisker)].length_mm = length_mm;
    }

    /// The next contact of a whisker.
    pub fn contact(&mut self, whisker: u16) -> Contact {
        let State { length_mm, pressure_mpa } = self.state[usize::from(whisker)];
        // Covers all contact ratios and deflections in an order that repeats only after many contacts.
        let spread = |step: f64| (self.contacts as f64 * step).fract();
        let (ratio, deflection_mm) = (0.5 + 0.5 * spread(0.618_034), 0.5 + 4.0 * spread(0.754_878));
        self.contacts += 1;
        self.clock_us += CONTACT_US;
        let morphology = self.model.morphology(Megapascal::known(pressure_mpa));
        let per_mm = self
            .model
            .sensitivity_per_mm(ContactRatio::known(ratio), Millimetre::known(length_mm), &morphology)
            .expect("beyond the chamber");
        let error: f64 = StandardNormal.sample(&mut self.noise);
        Contact {
            array: self.array.array.clone(),
            whisker,
            t_us: self.clock_us,
            ratio: Some(ratio),
            ratio_sd: None,
            distance_mm: None,
            distance_sd_mm: None,
            tip: false,
            deflection_mm,
            strain: per_mm * deflection_mm * (1.0 + 0.02 * error),
            saturated: false,
            pressure_mpa,
            temperature_c: 24.0,
            angle_deg: None,
            angle_sd_deg: None,
            test_id: None,
        }
    }

    /// A contacts message with the next sequence number.
    pub fn message(&mut self, contacts: Vec<Contact>) -> Contacts {
        Contacts {
            boot_id: self.boot_id.clone(),
            seq: self.next_seq(RobotTopic::Contacts),
            contacts,
            missed: Vec::new(),
        }
    }

    /// Sends a contacts message and returns it.
    pub async fn send(&mut self, contacts: Vec<Contact>) -> Contacts {
        let message = self.message(contacts);
        self.tell(RobotTopic::Contacts, &message).await;
        message
    }

    /// Sends this number of contacts of a whisker.
    pub async fn touch(&mut self, whisker: u16, contacts: usize) {
        let contacts: Vec<Contact> = (0..contacts).map(|_| self.contact(whisker)).collect();
        for some in contacts.chunks(CONTACTS_PER_MESSAGE) {
            self.send(some.to_vec()).await;
        }
    }

    /// The next message from the supervisor for which `choose` returns a value; other messages remain for later
    /// calls.
    ///
    /// # Panics
    /// No such message arrives in time.
    pub async fn hear<T>(&mut self, what: &str, mut choose: impl FnMut(&Heard) -> Option<T>) -> T {
        if let Some((at, found)) = self.heard.iter().enumerate().find_map(|(at, one)| Some((at, choose(one)?))) {
            self.heard.remove(at);
            return found;
        }
        loop {
            let heard = self.mqtt.next(PATIENCE).await.unwrap_or_else(|| panic!("{} did not hear: {what}", self.name));
            match choose(&heard) {
                Some(found) => return found,
                None => self.heard.push_back(heard),
            }
        }
    }

    /// The next setpoint, with the message that carried it.
    pub async fn setpoint(&mut self) -> (Setpoint, Heard) {
        let heard =
            self.hear("a setpoint", |heard| matches!(heard.message, Message::Setpoint(_)).then(|| heard.clone()));
        let heard = heard.await;
        let Message::Setpoint(setpoint) = &heard.message else { unreachable!("chosen so") };
        (setpoint.clone(), heard)
    }

    /// Received setpoints that [`HandRobot::setpoint`] has not returned yet.
    #[must_use]
    pub fn setpoints_left(&self) -> Vec<&Setpoint> {
        let mut left = Vec::new();
        for heard in &self.heard {
            if let Message::Setpoint(setpoint) = &heard.message {
                left.push(setpoint);
            }
        }
        left
    }

    /// The next request for a touch test.
    pub async fn touch_test(&mut self) -> TouchTest {
        self.hear("a request for a touch test", |heard| {
            let Message::Request(request) = &heard.message else { return None };
            request.touch_test.clone()
        })
        .await
    }

    /// Sends touches of a touch test at a distance from the base in mm, and touches that did not come at another one.
    /// Returns the message.
    pub async fn touch_on_request(
        &mut self,
        test: &TouchTest,
        touches: (usize, f64),
        missed: (usize, f64),
    ) -> Contacts {
        let contacts = (0..touches.0).map(|_| {
            let contact = self.contact(test.whisker);
            Contact { ratio: None, distance_mm: Some(touches.1), test_id: Some(test.test_id.clone()), ..contact }
        });
        let contacts: Vec<Contact> = contacts.collect();
        let missed_touch = MissedTouch {
            array: self.array.array.clone(),
            whisker: test.whisker,
            t_us: self.clock_us,
            distance_mm: missed.1,
            distance_sd_mm: None,
            test_id: Some(test.test_id.clone()),
        };
        let message = Contacts { missed: vec![missed_touch; missed.0], ..self.message(contacts) };
        self.tell(RobotTopic::Contacts, &message).await;
        message
    }

    /// Reports progress or result of a touch test.
    pub async fn answer_test(&mut self, test: &TouchTest, state: TouchTestOutcome, error: Option<TouchTestError>) {
        let message = TestState {
            boot_id: self.boot_id.clone(),
            seq: self.next_seq(RobotTopic::TestState),
            test_id: test.test_id.clone(),
            state,
            t_us: self.clock_us,
            error,
        };
        self.tell(RobotTopic::TestState, &message).await;
    }

    /// Waits until every contacts message of this boot is receipted.
    pub async fn receipted(&mut self) -> Receipt {
        let next = self.seqs.get(&RobotTopic::Contacts).copied().unwrap_or_default();
        let boot_id = self.boot_id.clone();
        self.hear(&format!("a receipt up to {next}"), |heard| {
            let Message::Receipt(receipt) = &heard.message else { return None };
            (receipt.robot_boot_id == boot_id && receipt.next >= next).then(|| receipt.clone())
        })
        .await
    }

    /// Waits until the supervisor accepts this robot's contacts. Contacts that arrive before the factsheet are not
    /// receipted and must be sent again.
    pub async fn settle(&mut self) {
        let message = self.message(Vec::new());
        self.deliver(vec![message]).await;
    }

    /// Sends contacts messages, and sends those again that are not receipted, as robots do, until all are.
    pub async fn deliver(&mut self, mut messages: Vec<Contacts>) {
        wait::until("receipts for all messages", async || {
            for message in &messages {
                self.tell(RobotTopic::Contacts, message).await;
            }
            while let Some(heard) = self.mqtt.next(SEND_AGAIN).await {
                if let Message::Receipt(receipt) = &heard.message {
                    messages.retain(|one| receipt.robot_boot_id != one.boot_id || !receipt.covers(one.seq));
                    if messages.is_empty() {
                        return Some(());
                    }
                }
                self.heard.push_back(heard);
            }
            None
        })
        .await;
    }

    /// Answers a setpoint; APPLIED also sets the pressure of the chamber.
    pub async fn answer(&mut self, setpoint: &Setpoint, state: SetpointOutcome, error: Option<SetpointError>) {
        let whisker = &mut self.state[usize::from(setpoint.whisker)];
        if state == SetpointOutcome::Applied {
            whisker.pressure_mpa = setpoint.pressure_mpa;
        }
        let pressure_mpa = Some(whisker.pressure_mpa);
        let message = SetpointState {
            boot_id: self.boot_id.clone(),
            seq: self.next_seq(RobotTopic::SetpointState),
            command_id: setpoint.command_id.clone(),
            state,
            t_us: self.clock_us,
            pressure_mpa,
            error,
        };
        self.tell(RobotTopic::SetpointState, &message).await;
    }
}

fn boot_id(robot: &str, mark: u64) -> BootId {
    BootId::new(&format!("{robot}-{mark}")).expect("a boot id")
}

/// Topics to which a robot subscribes.
fn filters(fleet: &str, name: &str) -> [String; 4] {
    [RobotTopic::Receipt, RobotTopic::Setpoint, RobotTopic::Request, RobotTopic::Estimate]
        .map(|kind| format!("whisker/v1/{fleet}/{name}/{kind}"))
}
