//! State of a robot's whiskers and drivers for a person at the robot: `vibrissa-robot monitor`.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use vibrissa_protocol::{Gauge, Name, Regulator, Segmenter, WhiskerCondition};

use super::Agent;
use super::chamber::Chamber;
use super::doubt::{gauge_remedy, remedy};
use crate::contract::Now;
use crate::driver::ToDriver;

/// Time without a contact after which a person is asked to touch, in seconds.
const QUIET_S: f64 = 60.0;

/// The state of an agent.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Snapshot {
    /// Name of the fleet.
    pub fleet: Name,
    /// Name of the robot.
    pub robot: Name,
    /// Whether the broker is connected.
    pub connected: bool,
    /// Contacts messages without a receipt in memory, and dropped ones.
    pub messages: (usize, u64),
    /// State of each driver, in the order of the configuration.
    pub drivers: Vec<DriverView>,
    /// State of each whisker, in the order of the configuration.
    pub whiskers: Vec<WhiskerView>,
}

/// State of a driver.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DriverView {
    /// Subject of sentences about it.
    pub label: String,
    /// Whether it can be heard.
    pub is_there: bool,
    /// Lines since its start.
    pub lines: u64,
    /// Refused lines since the agent's start.
    pub refused: u64,
}

/// State of a whisker.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WhiskerView {
    /// Name of its array.
    pub array: Name,
    /// Number within its array.
    pub whisker: u16,
    /// Condition of the regulator.
    pub regulator: Regulator,
    /// Condition of the gauge.
    pub gauge: Gauge,
    /// State of the segmenter; `None` if no driver sends strain.
    pub segmenter: Option<Segmenter>,
    /// Condition as the supervisor estimates it.
    pub condition: Option<WhiskerCondition>,
    /// The newest reading, in MPa.
    pub pressure_mpa: Option<f64>,
    /// The setpoint, in MPa.
    pub setpoint_mpa: f64,
    /// Seconds since the last contact that was sent.
    pub contact_s: Option<f64>,
    /// Lines of its drivers that were refused.
    pub refused: u64,
    /// Contacts that could not be sent, by reason.
    pub unused: BTreeMap<String, u64>,
    /// Advice; `None` if nothing is to be done.
    pub advice: Option<String>,
}

impl Agent {
    /// The present state, for people.
    #[must_use]
    pub fn snapshot(&self, now: Now) -> Snapshot {
        let drivers = self.drivers.iter().map(|driver| DriverView {
            label: driver.label.clone(),
            is_there: driver.is_there,
            lines: driver.lines,
            refused: driver.refused,
        });
        Snapshot {
            fleet: self.fleet.clone(),
            robot: self.robot.clone(),
            connected: self.connected,
            messages: (self.messages_kept(), self.messages_dropped()),
            drivers: drivers.collect(),
            whiskers: (0..self.chambers.len()).map(|at| self.view(at, now)).collect(),
        }
    }

    fn view(&self, at: usize, now: Now) -> WhiskerView {
        let chamber = &self.chambers[at];
        let (regulator, gauge) = chamber.condition(now);
        let condition = match &chamber.estimate {
            Some(ToDriver::Estimate { condition, .. }) => Some(*condition),
            Some(_) | None => None,
        };
        let contact_s = chamber.contact_at.map(|contact_at| now.at.since(contact_at) as f64 / 1e6);
        WhiskerView {
            array: chamber.array.clone(),
            whisker: chamber.number,
            regulator,
            gauge,
            segmenter: chamber.segmenter(),
            condition,
            pressure_mpa: chamber.present_reading().map(|reading| reading.pressure_mpa),
            setpoint_mpa: chamber.target_mpa,
            contact_s,
            refused: self.drivers.iter().filter(|one| one.serves.contains(&at)).map(|one| one.refused).sum(),
            unused: chamber.unused.clone(),
            advice: self.advice(at, chamber, (regulator, gauge), contact_s),
        }
    }

    /// The most urgent thing to do.
    fn advice(
        &self,
        at: usize,
        chamber: &Chamber,
        (regulator, gauge): (Regulator, Gauge),
        contact_s: Option<f64>,
    ) -> Option<String> {
        if !self.is_served(at) {
            let names: Vec<&str> =
                self.drivers.iter().filter(|one| one.serves.contains(&at)).map(|one| &*one.label).collect();
            return Some(format!("start {}: the agent's log says why it is not there", names.join(" or ")));
        }
        if chamber.present_reading().is_none() {
            return Some("no driver sends its pressure: send `pressure` at least once a second".to_owned());
        }
        let advice = match regulator {
            Regulator::Leak => Some("look for the leak of the chamber"),
            Regulator::SupplyLow => Some("open the air supply"),
            Regulator::Fault => Some("check the valves and the pressure sensor"),
            Regulator::Ok | Regulator::Filling | Regulator::Venting => None,
        };
        if chamber.gauge_watch.is_reversed() {
            return Some(self.reversal(at));
        }
        if chamber.gauge_watch.is_clipped() {
            return Some(
                "amplify the gauge less, or touch more softly: the strain ends below the deflection".to_owned(),
            );
        }
        let advice = advice.or_else(|| gauge_remedy(gauge)).map(str::to_owned);
        let unused = || {
            let most = chamber.unused.iter().max_by_key(|(_, count)| **count)?;
            contact_s.is_none().then(|| format!("no contact could be sent: {}", most.0))
        };
        let doubt = || chamber.stream.as_ref().and_then(|stream| remedy(stream.condition())).map(str::to_owned);
        let quiet = || contact_s.is_none_or(|quiet_s| quiet_s > QUIET_S).then(|| "touch the whisker".to_owned());
        let broker = || (!self.connected).then(|| "the broker is not connected: see the agent's log".to_owned());
        let supervisor = || self.supervision.is_unanswered().then(|| self.unanswered());
        advice.or_else(broker).or_else(supervisor).or_else(doubt).or_else(unused).or_else(quiet)
    }
}
