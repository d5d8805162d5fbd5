//! A hostile robot: its identity, its sequence numbers and its messages.

use std::sync::Arc;
use std::time::Duration;

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rumqttc::QoS;
use serde_json::{Value, json};
use tokio::sync::Semaphore;
use tokio::time::sleep;
use vibrissa_core::mechanics::{Formulation, Model};
use vibrissa_core::units::{ContactRatio, Megapascal, Millimetre};
use vibrissa_protocol::{Name, QualityOfService, RobotTopic, Setpoint, Timestamp};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::extremes::{Context, Messages};

use super::behaviour::Behaviour;
use super::client::Client;
use super::tally::Tally;
use crate::scenario::FLEET;

/// Name of its array, which has two whiskers.
pub const ARRAY: &str = "left";
/// Name of the only whisker model that the supervisors have loaded.
pub const MODEL: &str = "nguyen-2021";
/// Time limit of waits for the supervisor.
const PATIENCE: Duration = Duration::from_secs(3);

/// A hostile robot.
pub struct Robot {
    pub(super) name: Name,
    pub(super) port: u16,
    pub(super) client: Client,
    pub(super) random: ChaCha8Rng,
    pub(super) messages: Arc<Messages>,
    pub(super) tally: Arc<Tally>,
    /// Permit to flood, held by one robot at a time.
    pub(super) flooding: Arc<Semaphore>,
    pub(super) boot_id: String,
    pub(super) behaviour: Behaviour,
    /// Whether current messages only prepare the behaviour and are not counted.
    is_preparing: bool,
    model: Model,
    seqs: [u64; RobotTopic::ALL.len()],
}

impl Robot {
    /// Connects through the link on this port.
    pub fn new(name: Name, port: u16, seed: u64, shared: &super::Shared) -> Self {
        Self {
            client: Client::start(port, &name, shared.tally.clone()),
            name,
            port,
            random: ChaCha8Rng::seed_from_u64(seed),
            messages: shared.messages.clone(),
            tally: shared.tally.clone(),
            flooding: shared.flooding.clone(),
            boot_id: "b".to_owned(),
            behaviour: Behaviour::Garbage,
            is_preparing: false,
            model: Model::nguyen_2021(Formulation::Published),
            seqs: [0; RobotTopic::ALL.len()],
        }
    }

    /// Its own topic of this kind.
    pub fn topic(&self, kind: RobotTopic) -> String {
        format!("whisker/v1/{FLEET}/{}/{kind}", self.name)
    }

    /// Takes the next sequence number of a topic.
    pub fn seq(&mut self, kind: RobotTopic) -> u64 {
        let next = &mut self.seqs[kind as usize];
        *next += 1;
        *next - 1
    }

    /// Publishes on any topic and counts the message for the current behaviour.
    pub fn say_on(&self, topic: &str, payload: impl Into<Vec<u8>>, quality: QoS, is_retained: bool) {
        if self.client.say(topic, payload.into(), quality, is_retained) && !self.is_preparing {
            self.tally.count(self.behaviour);
        }
    }

    /// Publishes on one of its own topics with the contract's quality of service.
    pub fn say(&self, kind: RobotTopic, payload: impl Into<Vec<u8>>) {
        let quality = match kind.quality_of_service() {
            QualityOfService::AtMostOnce => QoS::AtMostOnce,
            QualityOfService::AtLeastOnce => QoS::AtLeastOnce,
        };
        self.say_on(&self.topic(kind), payload, quality, kind.is_retained());
    }

    /// Sends a message with these fields and the next sequence number.
    pub fn tell(&mut self, kind: RobotTopic, fields: Value) {
        let seq = self.seq(kind);
        self.tell_as(kind, seq, fields);
    }

    /// Sends a message with these fields and any sequence number.
    pub fn tell_as(&mut self, kind: RobotTopic, seq: u64, mut fields: Value) {
        fields["boot_id"] = json!(self.boot_id);
        fields["seq"] = json!(seq);
        self.say(kind, fields.to_string());
    }

    /// Sends a message at the limits of the contract.
    pub fn tell_extreme(&mut self, kind: RobotTopic, right_times: f64, odd_texts: f64) {
        let context = Context {
            boot_id: self.boot_id.clone(),
            seq: self.seq(kind),
            now_us: now_us(),
            arrays: vec![(ARRAY.to_owned(), 2)],
            models: vec![MODEL.to_owned()],
            commands: self.client.heard().setpoints.iter().map(|setpoint| setpoint.command_id.clone()).collect(),
            pressures_mpa: vec![0.1],
            right_times,
            odd_texts,
            list_most: 12,
        };
        let text = self.messages.draw(&mut self.random, kind, &context);
        self.say(kind, text);
    }

    /// Begins a new boot.
    pub fn reboot(&mut self) {
        self.boot_id = format!("h{:016x}", self.random.random::<u64>());
        self.seqs = [0; RobotTopic::ALL.len()];
    }

    /// Sends its birth message.
    pub fn birth(&mut self) {
        self.tell(RobotTopic::Connection, json!({"timestamp": Timestamp(now_us()), "state": "ONLINE"}));
    }

    /// Its factsheet, as an honest robot would write it.
    pub fn factsheet(&self, model: &Value, length_mm: f64) -> Value {
        let whisker = |whisker: u16| {
            json!({"whisker": whisker, "x_mm": 25 * whisker, "y_mm": 0, "model": MODEL, "length_mm": length_mm,
                "pressure_mpa": 0.1, "pressure_max_mpa": 0.2, "neighbours": [1 - whisker]})
        };
        json!({"timestamp": Timestamp(now_us()), "model": model, "on_supervisor_loss": "HOLD", "arrays":
            [{"array": ARRAY, "type": "TYPE_1", "whiskers": [whisker(0), whisker(1)]}]})
    }

    /// Starts a new boot, and waits until the supervisor sends it a receipt.
    pub async fn stand_up(&mut self, length_mm: f64) {
        self.is_preparing = true;
        self.reboot();
        self.birth();
        let factsheet = self.factsheet(&json!("hostile"), length_mm);
        self.tell(RobotTopic::Factsheet, factsheet);
        let before = self.client.heard().receipts;
        let begun = tokio::time::Instant::now();
        while self.client.heard().receipts == before && begun.elapsed() < PATIENCE {
            self.touch(0, length_mm, 1);
            sleep(Duration::from_millis(250)).await;
        }
        self.is_preparing = false;
    }

    /// Sends contacts as a whisker of that length would measure them at 0.1 MPa.
    pub fn touch(&mut self, whisker: u16, length_mm: f64, contacts: usize) {
        let contacts: Vec<Value> = (0..contacts).map(|_| self.contact(whisker, length_mm, now_us())).collect();
        self.tell(RobotTopic::Contacts, json!({ "contacts": contacts }));
    }

    /// A contact as a whisker of that length would measure it at 0.1 MPa.
    pub fn contact(&mut self, whisker: u16, length_mm: f64, t_us: u64) -> Value {
        let (ratio, deflection_mm) = (self.random.random_range(0.7..1.0), self.random.random_range(0.5..4.0));
        let morphology = self.model.morphology(Megapascal::known(0.1));
        let (at, length) = (ContactRatio::known(ratio), Millimetre::known(length_mm));
        let per_mm = self.model.sensitivity_per_mm(at, length, &morphology).unwrap_or_default();
        let strain = per_mm * deflection_mm * (1.0 + self.random.random_range(-0.03..0.03));
        json!({"array": ARRAY, "whisker": whisker, "t_us": t_us, "ratio": ratio, "deflection_mm": deflection_mm,
            "strain": strain, "pressure_mpa": 0.1, "temperature_c": 24.0})
    }

    /// Lets the baseline of whisker 0 be learned and then cuts the whisker, so that the supervisor decides on
    /// setpoints.
    pub async fn be_cut(&mut self) {
        self.stand_up(70.0).await;
        self.is_preparing = true;
        for length_mm in [70.0, 70.0, 70.0, 60.0, 60.0, 60.0] {
            for whisker in [0, 1] {
                self.touch(whisker, if whisker == 0 { length_mm } else { 70.0 }, 20);
            }
            sleep(Duration::from_millis(200)).await;
        }
        self.is_preparing = false;
    }

    /// Setpoints received since the last call.
    pub fn setpoints(&self) -> Vec<Setpoint> {
        self.client.heard().setpoints.drain(..).collect()
    }
}
