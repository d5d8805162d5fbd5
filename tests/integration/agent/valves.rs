//! A board that has only valves and pressure sensors, and the agent's regulator: `driver.regulate`.
//!
//! The board's own log has the true pressures and how long each valve had current.

use std::fs;
use std::net::SocketAddr;
use std::path::Path;
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rumqttc::{AsyncClient, Event, MqttOptions, Packet, PublishOptions, QoS};
use serde_json::Value;
use tempfile::TempDir;
use vibrissa_protocol::{BootId, Name, Setpoint, SetpointReason, Timestamp};
use vibrissa_simulator::clock::now_us;
use vibrissa_tests::mosquitto::{Mosquitto, free_port};
use vibrissa_tests::process::{Launch, Process};
use vibrissa_tests::proxy::Proxy;
use vibrissa_tests::wait::{until, until_true, until_within};

use crate::stage::{BOARD, Stage, agent, configuration, scenario};

/// Step of the board's sensor, in MPa.
const STEP_MPA: f64 = 5.0 / 1024.0 / 4.0;
/// Largest deviation in a hold that docs/regulator.md states.
const HOLD_MPA: f64 = 1.6 * STEP_MPA;
/// Readings from the receipt to a hold, 5 s: a first pulse with a valve that is not known yet may end up to two steps away, and a
/// hold waits 2 s between two pulses.
const SETTLING: usize = 250;
/// Readings of a hold, 3 s.
const HOLD: usize = 150;
/// Time limit of conditions that the regulator finds out from many readings.
const LONG: Duration = Duration::from_secs(60);

/// Words that start the board, with further options.
fn board(folder: &Path, options: &[&str]) -> Vec<String> {
    let (scenario, log) = (scenario(folder, 0.5), folder.join("board.log"));
    let paths = [scenario, log].map(|path| path.display().to_string());
    let words = ["board", "--valves", "--scenario", &paths[0], "--log-file", &paths[1]];
    words.iter().chain(options).map(|&word| word.to_owned()).collect()
}

/// The section of a driver that is the board as a child process.
fn as_child(folder: &Path, options: &[&str]) -> String {
    let words: Vec<String> = [BOARD.to_owned()].into_iter().chain(board(folder, options)).collect();
    format!("command = {words:?}\nregulate = true")
}

fn entries(folder: &Path) -> Vec<Value> {
    let text = fs::read_to_string(folder.join("board.log")).unwrap_or_default();
    text.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
}

/// True pressures of whisker 0 in entries, in their order.
fn pressures(entries: &[Value]) -> Vec<f64> {
    let of = |entry: &&Value| entry["log"] == "air" && entry["whisker"] == 0;
    entries.iter().filter(of).map(|entry| entry["pressure_mpa"].as_f64().unwrap()).collect()
}

/// Largest deviation of whisker 0 from a pressure in entries.
fn deviation(entries: &[Value], mpa: f64) -> f64 {
    pressures(entries).iter().map(|pressure_mpa| (pressure_mpa - mpa).abs()).fold(0.0, f64::max)
}

/// Fails if a valve had current for longer than the agent had stated, or for more than a second. Returns the number of pulses.
fn no_valve_was_open_for_too_long(entries: &[Value]) -> usize {
    let mut stated_us = [0; 2];
    let mut pulses = 0;
    for entry in entries {
        let whisker = entry["whisker"].as_u64().map(|number| number as usize);
        match (entry["log"].as_str(), whisker) {
            (Some("valve"), Some(whisker)) => {
                let for_ms = entry["for_ms"].as_f64().unwrap();
                assert!((0.0..=1000.0).contains(&for_ms), "{entry}");
                stated_us[whisker] = (for_ms * 1e3) as u64;
            }
            (Some("pulse"), Some(whisker)) => {
                pulses += 1;
                let lasted_us = entry["lasted_us"].as_u64().unwrap();
                // A pulse that another one ends is logged before that one. The board counts in steps of 0.1 ms.
                assert!(lasted_us <= stated_us[whisker] + 100, "{entry} after {} us", stated_us[whisker]);
            }
            _ => {}
        }
    }
    pulses
}

/// Last part of the topic, and the message, of all that was heard.
type Heard = Arc<Mutex<Vec<(String, Value)>>>;

/// A broker with an agent, and a supervisor by hand.
struct Rig {
    agent: Process,
    client: AsyncClient,
    heard: Heard,
    _broker: Mosquitto,
    folder: TempDir,
}

impl Rig {
    /// Starts all. `driver` writes the section of the driver, and `edit` changes the configuration.
    fn start(driver: impl FnOnce(&Path) -> String, edit: impl FnOnce(String) -> String) -> Self {
        let (folder, broker) = (tempfile::tempdir().unwrap(), Mosquitto::start());
        let mut options = MqttOptions::new("by-hand", ("127.0.0.1".to_owned(), broker.port()));
        options.set_max_packet_size(Some(1 << 20));
        let (client, mut events) = AsyncClient::builder(options).capacity(100).build();
        let heard = Heard::default();
        let (taking, subscribing) = (heard.clone(), client.clone());
        tokio::spawn(async move {
            subscribing.subscribe("whisker/v1/f/r/+", QoS::AtLeastOnce).await.unwrap();
            loop {
                let Ok(Event::Incoming(Packet::Publish(publish))) = events.poll().await else { continue };
                let topic = String::from_utf8(publish.topic.to_vec()).unwrap();
                let message = serde_json::from_slice(&publish.payload).unwrap();
                taking.lock().unwrap().push((topic.rsplit('/').next().unwrap().to_owned(), message));
            }
        });
        let configured = edit(configuration(broker.port(), &driver(folder.path())));
        let agent = agent(folder.path(), &configured);
        Self { agent, client, heard, _broker: broker, folder }
    }

    fn entries(&self) -> Vec<Value> {
        entries(self.folder.path())
    }

    fn heard(&self, topic: &str) -> Vec<Value> {
        let heard = self.heard.lock().unwrap();
        heard.iter().filter(|(of, _)| of == topic).map(|(_, message)| message.clone()).collect()
    }

    /// An order for whisker 0 of the newest boot.
    async fn order(&self, version: u64, pressure_mpa: f64) -> Setpoint {
        let boot =
            until("a boot", async || self.heard("connection").last().map(|birth| birth["boot_id"].clone())).await;
        Setpoint {
            boot_id: BootId::new("by-hand").unwrap(),
            seq: version,
            command_id: format!("command-{version}"),
            epoch: 5,
            version,
            robot_boot_id: BootId::new(boot.as_str().unwrap()).unwrap(),
            array: Name::new("left").unwrap(),
            whisker: 0,
            pressure_mpa,
            slew_mpa_per_s: 0.05,
            issued: Timestamp(now_us()),
            expires_us: now_us() + 30_000_000,
            reason: SetpointReason::SelfCompensation,
            gain: vec![],
            reading_gain: None,
        }
    }

    async fn send(&self, setpoint: &Setpoint) {
        let payload = serde_json::to_vec(setpoint).unwrap();
        self.client.publish("whisker/v1/f/r/setpoint", payload, PublishOptions::new(QoS::AtLeastOnce)).await.unwrap();
    }

    /// State and error of a command, once it is one of these.
    async fn answer(&self, command_id: &str, states: &[&str]) -> (String, Value) {
        until_within(LONG, &format!("{command_id} in one of {states:?}"), async || {
            let newest = self.heard("setpoint_state").into_iter().rfind(|state| state["command_id"] == command_id)?;
            let state = newest["state"].as_str()?.to_owned();
            states.contains(&state.as_str()).then(|| (state, newest["error"].clone()))
        })
        .await
    }

    /// Sends a setpoint until it is applied: an agent that has no driver yet rejects it.
    async fn apply(&self, mut version: u64, pressure_mpa: f64) {
        loop {
            let setpoint = self.order(version, pressure_mpa).await;
            self.send(&setpoint).await;
            let (state, error) = self.answer(&setpoint.command_id, &["APPLIED", "REJECTED", "FAILED"]).await;
            if state == "APPLIED" {
                return;
            }
            assert_eq!(error, "NOT_READY");
            version += 1;
        }
    }

    /// Waits for further readings of whisker 0.
    async fn readings(&self, more: usize) {
        let before = pressures(&self.entries()).len();
        until_within(LONG, "readings", async || (pressures(&self.entries()).len() >= before + more).then_some(()))
            .await;
    }

    /// Waits until the newest status has this condition of whisker 0.
    async fn condition(&self, condition: &str) -> Value {
        until_within(LONG, condition, async || {
            let newest = self.heard("status").pop()?;
            (newest["whiskers"][0]["regulator"] == condition).then_some(newest)
        })
        .await
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn an_order_of_the_supervisor_reaches_a_chamber_by_pulses_of_its_valves() {
    let stage = Stage::start(|folder| as_child(folder, &[])).await;
    let log = || entries(stage.folder.path());
    for (mpa, applied) in [(0.14, 1), (0.06, 2)] {
        stage.set_by_hand(0, mpa).await;
        until_within(LONG, "a receipt of the applied setpoint", async || {
            let sql = "SELECT count(*) FROM setpoints WHERE state = 'APPLIED'";
            (stage.number(sql).await == applied).then_some(())
        })
        .await;
        let readings = async |more: usize| {
            let from = log().len();
            until_within(LONG, "readings", async || (pressures(&log()[from..]).len() >= more).then_some(())).await;
            deviation(&log()[from..], mpa)
        };
        let settling_mpa = readings(SETTLING).await;
        let away_mpa = readings(HOLD).await;
        println!(
            "{mpa} MPa: {:.2} steps away at most, {:.2} before the hold",
            away_mpa / STEP_MPA,
            settling_mpa / STEP_MPA
        );
        assert!(away_mpa <= HOLD_MPA, "{} steps from {mpa} MPa", away_mpa / STEP_MPA);
    }
    assert!(no_valve_was_open_for_too_long(&log()) > 4);
    assert!(stage.number("SELECT count(*) FROM contacts").await > 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_setpoint_that_is_expired_stale_or_for_another_boot_moves_no_valve() {
    let rig = Rig::start(|folder| as_child(folder, &[]), |text| text);
    rig.apply(10, 0.12).await;
    rig.readings(SETTLING).await;
    let from = rig.entries().len();
    let mut refused = Vec::new();
    for (version, error) in [(100, "EXPIRED"), (5, "STALE"), (101, "WRONG_BOOT"), (102, "OUT_OF_RANGE")] {
        let mut setpoint = rig.order(version, 0.02).await;
        match error {
            "EXPIRED" => setpoint.expires_us = now_us() - 1,
            "WRONG_BOOT" => setpoint.robot_boot_id = BootId::new("another").unwrap(),
            "OUT_OF_RANGE" => setpoint.pressure_mpa = 0.201,
            _ => {}
        }
        rig.send(&setpoint).await;
        let answer = rig.answer(&setpoint.command_id, &["REJECTED"]).await;
        assert_eq!(answer.1, error);
        refused.push(setpoint);
    }
    // A refused one that arrives again is answered again.
    let answers = rig.heard("setpoint_state").len();
    rig.send(&refused[0]).await;
    until_true("another answer", async || rig.heard("setpoint_state").len() == answers + 1).await;
    rig.readings(HOLD).await;
    let entries = rig.entries();
    let away_mpa = deviation(&entries[from..], 0.12);
    assert!(away_mpa <= HOLD_MPA, "{} steps", away_mpa / STEP_MPA);
    assert!(!entries.iter().any(|entry| entry["log"] == "set_pressure" && entry["pressure_mpa"] == 0.02));
}

#[tokio::test(flavor = "multi_thread")]
async fn no_valve_stays_open_when_link_or_agent_is_killed_within_a_pulse() {
    let port = free_port();
    let link = Proxy::to(port).await;
    let mut rig = Rig::start(
        |_| format!("tcp = \"{}\"\nregulate = true", SocketAddr::from(([127, 0, 0, 1], link.port()))),
        |text| text,
    );
    let listen = format!("127.0.0.1:{port}");
    let _board = Process::start(Launch {
        program: BOARD.into(),
        arguments: board(rig.folder.path(), &["--listen", &listen, "--watchdog-s", "6"]),
        environment: vec![],
        log: rig.folder.path().join("board-errors.log"),
    });
    rig.apply(1, 0.03).await;
    for (version, kills_agent) in [(100, false), (200, true)] {
        // As fast as the valves can: the pulses are long.
        let mut setpoint = rig.order(version, if kills_agent { 0.19 } else { 0.15 }).await;
        setpoint.slew_mpa_per_s = 1.0;
        let from = rig.entries().len();
        rig.send(&setpoint).await;
        until_true("an open valve", async || {
            let begun = &rig.entries()[from..];
            let last = begun.iter().rfind(|entry| entry["whisker"] == 0 && entry["log"] != "air");
            last.is_some_and(|entry| entry["log"] == "valve" && entry["for_ms"].as_f64().unwrap() > 30.0)
        })
        .await;
        if kills_agent {
            rig.agent.kill();
            let from = rig.entries().len();
            rig.readings(60).await;
            let entries = rig.entries();
            // Lines that were on their way may still arrive; then the air stands still.
            let after = pressures(&entries[from..]).split_off(55);
            assert!(after.iter().all(|mpa| (mpa - after[0]).abs() < 1e-9), "{after:?}");
            // The board hears nothing, and its watchdog vents.
            until_within(LONG, "an empty chamber", async || {
                pressures(&rig.entries()).last().is_some_and(|&mpa| mpa < STEP_MPA).then_some(())
            })
            .await;
            assert!(rig.entries().iter().any(|entry| entry["log"] == "watchdog"));
            rig.agent.restart();
            until_true("another birth", async || {
                rig.heard("connection").last().is_some_and(|birth| birth["boot_id"] != setpoint.robot_boot_id.as_str())
            })
            .await;
            // The order was for the boot before: after a restart the pressure is the nominal one.
            rig.send(&setpoint).await;
            assert_eq!(rig.answer(&setpoint.command_id, &["REJECTED"]).await.1, "WRONG_BOOT");
            until_within(LONG, "the nominal pressure", async || {
                let newest = *pressures(&rig.entries()).last()?;
                ((newest - 0.1).abs() <= HOLD_MPA).then_some(())
            })
            .await;
        } else {
            link.cut();
            // The agent finds the board again, and goes on.
            assert_eq!(rig.answer(&setpoint.command_id, &["APPLIED", "FAILED"]).await.0, "APPLIED");
        }
    }
    println!("{} pulses", no_valve_was_open_for_too_long(&rig.entries()));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_leak_is_in_the_status_and_its_chamber_is_held() {
    let rig = Rig::start(|folder| as_child(folder, &["--leak-mpa-per-s", "0.001"]), |text| text);
    rig.apply(1, 0.11).await;
    let status = rig.condition("LEAK").await;
    assert_eq!(status["whiskers"][1]["regulator"], "OK");
    let from = rig.entries().len();
    rig.readings(250).await;
    let away_mpa = deviation(&rig.entries()[from..], 0.11);
    assert!(away_mpa <= 2.5 * STEP_MPA, "{} steps", away_mpa / STEP_MPA);
    no_valve_was_open_for_too_long(&rig.entries());
}

#[tokio::test(flavor = "multi_thread")]
async fn an_empty_supply_is_in_the_status_and_is_the_reason_of_a_failed_setpoint() {
    let rig = Rig::start(|folder| as_child(folder, &["--supply-mpa", "0.05"]), |text| text);
    until_true("a driver", async || !pressures(&rig.entries()).is_empty()).await;
    let mut version = 1;
    let answer = loop {
        let setpoint = rig.order(version, 0.15).await;
        rig.send(&setpoint).await;
        let answer = rig.answer(&setpoint.command_id, &["APPLIED", "REJECTED", "FAILED"]).await;
        if answer.1 != "NOT_READY" {
            break answer;
        }
        version += 1;
    };
    assert_eq!(answer, ("FAILED".to_owned(), "SUPPLY_LOW".into()));
    rig.condition("SUPPLY_LOW").await;
    // Nothing is lost from a tight chamber meanwhile.
    assert!(pressures(&rig.entries()).iter().all(|&mpa| mpa > 0.1 - 3.0 * STEP_MPA));
}

#[tokio::test(flavor = "multi_thread")]
async fn a_robot_that_vents_without_a_supervisor_does_so_by_its_valves() {
    let vents = |text: String| {
        text.replace("robot = \"r\"", "robot = \"r\"\non_supervisor_loss = \"VENT\"")
            .replace("[supervisor]", "[supervisor]\nlost_after_s = 3.0")
    };
    let rig = Rig::start(|folder| as_child(folder, &[]), vents);
    rig.apply(1, 0.12).await;
    // Nothing more is heard of the supervisor.
    until_within(LONG, "an empty chamber", async || {
        pressures(&rig.entries()).last().is_some_and(|&mpa| mpa < STEP_MPA).then_some(())
    })
    .await;
    let from = rig.entries().len();
    rig.readings(150).await;
    assert!(deviation(&rig.entries()[from..], 0.0) < HOLD_MPA);
    // It fills again with the next order.
    rig.apply(100, 0.05).await;
    no_valve_was_open_for_too_long(&rig.entries());
}
