//! The code of each behaviour. Each call lasts some seconds.

use std::time::Duration;

use rand::Rng;
use rand::seq::IndexedRandom;
use rumqttc::QoS;
use serde_json::{Value, json};
use tokio::time::sleep;
use vibrissa_protocol::{PAYLOAD_MAX_BYTES, RobotTopic, Timestamp};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::extremes::{FROM_ROBOTS, time_us};

use super::behaviour::Behaviour;
use super::client::connect_as;
use super::robot::{ARRAY, Robot};
use crate::scenario::FLEET;

/// Pause between two messages of a behaviour that does not flood.
const PAUSE: Duration = Duration::from_millis(25);
/// Bursts of a flood, one every 10 ms, and messages per burst.
const FLOOD: (u32, u32) = (200, 20);
/// Connections under each client id of the supervisor.
const TAKEOVERS: u32 = 10;
/// Seconds to wait for a setpoint.
const SETPOINT_PATIENCE_S: u32 = 3;
/// The largest `t_us` of the contract.
const TIME_MOST_US: u64 = vibrissa_protocol::INTEGER_LIMIT - 1;

/// Contact ratio, deflection in mm and strain of contacts that once made the state of a whisker of 69.3 mm non-finite.
/// They were inside the contract's ranges at that time.
const TRIPLES: [(f64, f64, f64); 3] = [(5e-324, 1e-9, -0.0117), (0.85, 1000.0, 5e-324), (0.45, 999.999, 1.0)];
const TRIPLES_LENGTH_MM: f64 = 69.3;

impl Robot {
    /// Performs one behaviour for some seconds.
    pub async fn behave(&mut self, behaviour: Behaviour) {
        self.behaviour = behaviour;
        match behaviour {
            Behaviour::OddFactsheets => self.odd_factsheets().await,
            Behaviour::ExtremeContacts => self.extreme_contacts().await,
            Behaviour::BadContacts => self.bad_contacts().await,
            Behaviour::WrongClocks => self.wrong_clocks().await,
            Behaviour::ManyBoots => self.many_boots().await,
            Behaviour::OthersTopics => self.others_topics().await,
            Behaviour::KnownNumbers => self.known_numbers().await,
            Behaviour::ForgedAnswers => self.forged_answers().await,
            Behaviour::Flood => self.flood().await,
            Behaviour::HugeMessages => self.huge_messages().await,
            Behaviour::Garbage => self.garbage().await,
            Behaviour::Takeover => self.take_over().await,
            Behaviour::Deaf => self.be_deaf().await,
            Behaviour::Lies => self.lie().await,
        }
    }

    async fn odd_factsheets(&mut self) {
        let models =
            ["a\u{0}b", "\u{0}", "\u{1b}[2J", "a\nb", "\u{7f}\u{85}", "\u{202e}x", "😀😀", "'; DROP TABLE robots; --"];
        for model in models {
            self.reboot();
            self.birth();
            let factsheet = self.factsheet(&json!(model), 70.0);
            self.tell(RobotTopic::Factsheet, factsheet);
            let mut unknown = self.factsheet(&json!("hostile"), 70.0);
            unknown["arrays"][0]["whiskers"][0]["model"] = json!(model);
            self.tell(RobotTopic::Factsheet, unknown);
            self.tell_extreme(RobotTopic::Factsheet, 1.0, 0.0);
            self.tell_extreme(RobotTopic::Factsheet, 0.0, 0.5);
            self.touch(0, 70.0, 2);
            sleep(4 * PAUSE).await;
        }
        // The broker retains the last factsheet for the next supervisor.
        let factsheet = self.factsheet(&json!("a\u{0}b"), 70.0);
        self.tell(RobotTopic::Factsheet, factsheet);
    }

    async fn extreme_contacts(&mut self) {
        self.stand_up(TRIPLES_LENGTH_MM).await;
        for round in 0..30 {
            for (ratio, deflection_mm, strain) in TRIPLES {
                let mut contact = self.contact(round % 2, TRIPLES_LENGTH_MM, now_us());
                contact["ratio"] = json!(ratio);
                contact["deflection_mm"] = json!(deflection_mm);
                contact["strain"] = json!(strain);
                self.tell(RobotTopic::Contacts, json!({ "contacts": [contact] }));
            }
            self.tell_extreme(RobotTopic::Contacts, 1.0, 0.0);
            self.touch(round % 2, TRIPLES_LENGTH_MM, 4);
            sleep(PAUSE).await;
        }
    }

    async fn bad_contacts(&mut self) {
        self.stand_up(70.0).await;
        let wrong = [
            ("ratio", "1.2"),
            ("ratio", "-0"),
            ("ratio", "\"NaN\""),
            ("deflection_mm", "0"),
            ("deflection_mm", "1e308"),
            ("strain", "1e309"),
            ("strain", "-1.0000001"),
            ("strain", "null"),
            ("pressure_mpa", "NaN"),
            ("pressure_mpa", "-5e-324"),
            ("temperature_c", "[[[]]]"),
            ("temperature_c", "1e999"),
            ("whisker", "65536"),
            ("whisker", "-1"),
            ("array", "\"left\\u0000\""),
            ("t_us", "9007199254740992"),
            ("t_us", "-1"),
        ];
        for (field, value) in wrong {
            let mut contact = self.contact(0, 70.0, now_us());
            contact[field] = json!("HERE");
            let seq = self.seq(RobotTopic::Contacts);
            let message = json!({"boot_id": self.boot_id, "seq": seq, "contacts": [contact]}).to_string();
            self.say(RobotTopic::Contacts, message.replace("\"HERE\"", value));
            self.touch(0, 70.0, 2);
            sleep(PAUSE).await;
        }
    }

    async fn wrong_clocks(&mut self) {
        self.stand_up(70.0).await;
        for _ in 0..40 {
            let t_us = time_us(&mut self.random, now_us(), TIME_MOST_US);
            let contacts = [self.contact(0, 70.0, now_us()), self.contact(1, 70.0, t_us)];
            self.tell(RobotTopic::Contacts, json!({ "contacts": contacts }));
            let t_us = time_us(&mut self.random, now_us(), TIME_MOST_US);
            self.tell(RobotTopic::Status, json!({"t_us": t_us, "whiskers": []}));
            sleep(PAUSE).await;
        }
    }

    async fn many_boots(&mut self) {
        for boot in 0..100 {
            self.reboot();
            self.birth();
            if boot % 5 == 0 {
                let factsheet = self.factsheet(&json!("hostile"), 70.0);
                self.tell(RobotTopic::Factsheet, factsheet);
                self.touch(0, 70.0, 1);
            }
            sleep(Duration::from_millis(10)).await;
        }
    }

    /// The shipped access list forbids all of these topics.
    async fn others_topics(&mut self) {
        let supervised = ["setpoint", "receipt", "request"].map(|kind| format!("{}/{kind}", self.name));
        for number in 0..12_u64 {
            let made_up = format!("ghost{:08x}", self.random.random::<u32>());
            let honest = format!("r{:03}", self.random.random_range(0..50));
            for level in [made_up, honest] {
                for kind in FROM_ROBOTS {
                    let seq = if self.random.random() { number } else { 0 };
                    let text = json!({"boot_id": self.boot_id, "seq": seq, "timestamp": Timestamp(now_us()),
                        "state": "OFFLINE", "contacts": [], "t_us": now_us(), "whiskers": [], "arrays": [], "model": "x",
                        "on_supervisor_loss": "VENT", "command_id": "x"});
                    let topic = format!("whisker/v1/{FLEET}/{level}/{kind}");
                    self.say_on(&topic, text.to_string(), QoS::AtMostOnce, kind.is_retained());
                }
            }
            for topic in supervised.iter().map(String::as_str).chain(["supervisor/state"]) {
                let text = json!({"boot_id": "x", "seq": number, "state": "OFFLINE", "epoch": TIME_MOST_US,
                    "robot_boot_id": self.boot_id, "next": TIME_MOST_US, "held": [], "request": "STATUS"});
                let topic = format!("whisker/v1/{FLEET}/{topic}");
                self.say_on(&topic, text.to_string(), QoS::AtMostOnce, true);
            }
            sleep(2 * PAUSE).await;
        }
    }

    async fn known_numbers(&mut self) {
        self.stand_up(70.0).await;
        let old_boot = self.boot_id.clone();
        for round in 0..20 {
            let seq = self.seq(RobotTopic::Contacts);
            for _ in 0..4 {
                let contact = self.contact(round % 2, 70.0, now_us());
                self.tell_as(RobotTopic::Contacts, seq, json!({ "contacts": [contact] }));
            }
            self.tell_as(RobotTopic::Contacts, seq / 2, json!({ "contacts": [] }));
            sleep(PAUSE).await;
        }
        // The supervisor knows the numbers of the previous boot, too.
        self.stand_up(70.0).await;
        let boot = std::mem::replace(&mut self.boot_id, old_boot);
        for seq in 0..10 {
            let contact = self.contact(0, 70.0, now_us());
            self.tell_as(RobotTopic::Contacts, seq, json!({ "contacts": [contact] }));
        }
        self.boot_id = boot;
    }

    async fn forged_answers(&mut self) {
        self.stand_up(70.0).await;
        for _ in 0..40 {
            let known = self.client.heard().setpoints.back().map(|setpoint| setpoint.command_id.clone());
            let made_up =
                format!("{:08x}-0000-4000-8000-{:012x}", self.random.random::<u32>(), self.random.random::<u32>());
            for command_id in [Some(made_up), known].into_iter().flatten() {
                let answer = self.any_answer(&command_id, now_us());
                self.tell(RobotTopic::SetpointState, answer);
            }
            self.tell_extreme(RobotTopic::SetpointState, 0.5, 0.1);
            sleep(PAUSE).await;
        }
    }

    fn any_answer(&mut self, command_id: &str, t_us: u64) -> Value {
        let states = ["RECEIVED", "APPLYING", "APPLIED", "REJECTED", "FAILED", "SUPERSEDED"];
        let errors = ["STALE", "EXPIRED", "OUT_OF_RANGE", "UNKNOWN_WHISKER", "WRONG_BOOT", "NOT_READY", "LEAK"];
        let (state, error) = (states.choose(&mut self.random), errors.choose(&mut self.random));
        let pressure_mpa = [0.0, 1.0, 0.1, 5e-324].choose(&mut self.random).copied();
        json!({"command_id": command_id, "state": state, "error": error, "t_us": t_us, "pressure_mpa": pressure_mpa})
    }

    async fn flood(&mut self) {
        let flooding = self.flooding.clone();
        let Ok(_only) = flooding.acquire().await else { return };
        self.stand_up(70.0).await;
        let (bursts, messages) = FLOOD;
        let mut clock = tokio::time::interval(Duration::from_millis(10));
        for burst in 0..bursts {
            clock.tick().await;
            (0..messages).for_each(|_| self.touch((burst % 2) as u16, 70.0, 1));
        }
    }

    async fn huge_messages(&mut self) {
        self.stand_up(70.0).await;
        let contact = self.contact(0, 70.0, now_us());
        let many = vec![contact; 1001];
        self.tell(RobotTopic::Contacts, json!({ "contacts": many }));
        for bytes in [PAYLOAD_MAX_BYTES - 200, PAYLOAD_MAX_BYTES + 1, 1 << 20, 8 << 20] {
            for kind in [RobotTopic::Contacts, RobotTopic::Factsheet] {
                let padding = "x".repeat(bytes);
                self.tell(kind, json!({"contacts": [], "padding": padding}));
                sleep(4 * PAUSE).await;
            }
        }
    }

    async fn garbage(&mut self) {
        self.stand_up(70.0).await;
        for _ in 0..12 {
            let length = self.random.random_range(0..2000);
            let noise: Vec<u8> = (0..length).map(|_| self.random.random()).collect();
            let whole = self.factsheet(&json!("hostile"), 70.0).to_string();
            let half = whole.as_bytes()[..self.random.random_range(0..whole.len())].to_vec();
            let wrong = [
                noise,
                half,
                b"{\"boot_id\":\"b\",\"seq\":0,\"seq\":1}".to_vec(),
                b"\xff\xfe{\"boot_id\":\"\xc0\x80\"}".to_vec(),
                "[".repeat(100_000).into_bytes(),
                Vec::new(),
            ];
            for payload in wrong {
                let kind = FROM_ROBOTS.choose(&mut self.random).copied().unwrap_or(RobotTopic::Contacts);
                self.say(kind, payload);
            }
            sleep(2 * PAUSE).await;
        }
    }

    /// Connects under client ids made from the supervisor's boot id, which every receipt contains.
    async fn take_over(&mut self) {
        self.stand_up(70.0).await;
        let Some(supervisor) = self.client.heard().supervisor.clone() else { return };
        for _ in 0..TAKEOVERS {
            for id in ["in", "out"].map(|role| format!("vibrissa-{FLEET}-{supervisor}-{role}")) {
                if connect_as(self.port, &self.name, id, Duration::from_secs(1)).await {
                    self.tally.count(self.behaviour);
                }
            }
            sleep(2 * PAUSE).await;
        }
    }

    async fn be_deaf(&mut self) {
        self.be_cut().await;
        for _ in 0..SETPOINT_PATIENCE_S {
            self.status("OK", 0.1);
            sleep(Duration::from_secs(1)).await;
        }
    }

    async fn lie(&mut self) {
        self.setpoints();
        self.be_cut().await;
        for _ in 0..2 * SETPOINT_PATIENCE_S {
            for setpoint in self.setpoints() {
                for _ in 0..3 {
                    let t_us = time_us(&mut self.random, now_us(), TIME_MOST_US);
                    let answer = self.any_answer(&setpoint.command_id, t_us);
                    self.tell(RobotTopic::SetpointState, answer);
                }
            }
            let regulator = ["OK", "FILLING", "VENTING", "SUPPLY_LOW", "LEAK", "FAULT"].choose(&mut self.random);
            let setpoint_mpa = self.random.random_range(0.0..1.0);
            self.status(regulator.copied().unwrap_or("OK"), setpoint_mpa);
            let length_mm = self.random.random_range(55.0..75.0);
            self.touch(0, length_mm, 4);
            sleep(Duration::from_millis(500)).await;
        }
    }

    fn status(&mut self, regulator: &str, setpoint_mpa: f64) {
        let whisker = |whisker: u16| {
            json!({"array": ARRAY, "whisker": whisker, "pressure_mpa": 0.1, "setpoint_mpa": setpoint_mpa,
                "regulator": regulator, "gauge": "OK"})
        };
        self.tell(RobotTopic::Status, json!({"t_us": now_us(), "whiskers": [whisker(0), whisker(1)]}));
    }
}
