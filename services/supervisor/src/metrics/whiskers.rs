//! Metrics of single robots and whiskers: four series for each whisker, so they are exported only if the
//! configuration enables them. They show the last values that the fleets' owners have sampled, and vanish with the
//! robot.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use prometheus::core::{Collector, Desc};
use prometheus::proto::MetricFamily;
use prometheus::{GaugeVec, IntCounterVec, Opts, Result};

use vibrissa_protocol::Name;

use super::kinds::Word;

const ROBOT: [&str; 2] = ["fleet", "robot"];
const ROBOT_AND_REFUSAL: [&str; 4] = ["fleet", "robot", "topic", "reason"];
const WHISKER: [&str; 4] = ["fleet", "robot", "array", "whisker"];
const WHISKER_AND_HEALTH: [&str; 5] = ["fleet", "robot", "array", "whisker", "health"];

/// Exported values of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSample {
    /// Name of the robot.
    pub robot: String,
    /// Time of its last message, s since 1970 UTC; `None` before the first.
    pub heard_s: Option<f64>,
    /// Counts of its refusals, by topic and reason.
    pub refused: Vec<(Word, Word, u64)>,
    /// Whiskers on the robot.
    pub whiskers: Vec<WhiskerSample>,
}

/// Exported values of a whisker.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiskerSample {
    /// Name of its array.
    pub array: String,
    /// Number of the whisker in its array.
    pub whisker: u16,
    /// Estimated length, m.
    pub length_m: f64,
    /// Pressure as last measured, Pa; `None` before the first measurement.
    pub pressure_pa: Option<f64>,
    /// Pressure that the robot holds or moves to, Pa.
    pub setpoint_pa: f64,
    /// Fault, or condition if it has no fault.
    pub health: Word,
}

/// Metrics of single robots and whiskers.
#[derive(Debug, Clone)]
pub struct WhiskerMetrics {
    seen: Arc<Mutex<BTreeMap<Name, Vec<RobotSample>>>>,
    descriptions: Vec<Desc>,
}

/// The series of one scrape.
struct Series {
    heard: GaugeVec,
    refused: IntCounterVec,
    length: GaugeVec,
    pressure: GaugeVec,
    setpoint: GaugeVec,
    health: GaugeVec,
}

impl Series {
    fn declare() -> Result<Self> {
        let gauges = |name: &str, help: &str, labels: &[&str]| GaugeVec::new(Opts::new(name, help), labels);
        Ok(Self {
            heard: gauges(
                "vibrissa_robot_heard_timestamp_seconds",
                "Time of the last message of the robot, since 1970 UTC.",
                &ROBOT,
            )?,
            refused: IntCounterVec::new(
                Opts::new(
                    "vibrissa_robot_refused_total",
                    "Messages of the robot, or contacts and other entries of them, that were refused.",
                ),
                &ROBOT_AND_REFUSAL,
            )?,
            length: gauges("vibrissa_whisker_length_meters", "Estimated length of a whisker.", &WHISKER)?,
            pressure: gauges("vibrissa_whisker_pressure_pascals", "Chamber pressure as last measured.", &WHISKER)?,
            setpoint: gauges(
                "vibrissa_whisker_setpoint_pascals",
                "Pressure that the robot holds or moves to.",
                &WHISKER,
            )?,
            health: gauges(
                "vibrissa_whisker_health",
                "1 for the fault, or for the condition if there is no fault.",
                &WHISKER_AND_HEALTH,
            )?,
        })
    }

    fn each(&self) -> [&dyn Collector; 6] {
        [&self.heard, &self.refused, &self.length, &self.pressure, &self.setpoint, &self.health]
    }

    fn show(&self, fleet: &str, sample: &RobotSample) {
        if let Some(heard_s) = sample.heard_s {
            self.heard.with_label_values(&[fleet, &sample.robot]).set(heard_s);
        }
        for &(topic, reason, count) in &sample.refused {
            self.refused.with_label_values(&[fleet, &sample.robot, topic, reason]).inc_by(count);
        }
        for one in &sample.whiskers {
            let number = one.whisker.to_string();
            let place = [fleet, &sample.robot, &one.array, &number];
            self.length.with_label_values(&place).set(one.length_m);
            self.setpoint.with_label_values(&place).set(one.setpoint_pa);
            if let Some(pressure_pa) = one.pressure_pa {
                self.pressure.with_label_values(&place).set(pressure_pa);
            }
            self.health.with_label_values(&[place[0], place[1], place[2], place[3], one.health]).set(1.0);
        }
    }
}

impl WhiskerMetrics {
    pub(super) fn declare() -> Result<Self> {
        let descriptions =
            Series::declare()?.each().into_iter().flat_map(|one| one.desc().into_iter().cloned()).collect();
        Ok(Self { seen: Arc::default(), descriptions })
    }

    /// Replaces the exported robots of a fleet; pass none if it is supervised elsewhere.
    pub fn show(&self, fleet: &Name, robots: Vec<RobotSample>) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if robots.is_empty() {
            seen.remove(fleet);
        } else {
            seen.insert(fleet.clone(), robots);
        }
    }
}

impl Collector for WhiskerMetrics {
    fn desc(&self) -> Vec<&Desc> {
        self.descriptions.iter().collect()
    }

    fn collect(&self) -> Vec<MetricFamily> {
        // The names were valid when the descriptions were created.
        let Ok(series) = Series::declare() else { return Vec::new() };
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        for (fleet, robots) in seen.iter() {
            for robot in robots {
                series.show(fleet.as_str(), robot);
            }
        }
        series.each().into_iter().flat_map(|one| one.collect()).collect()
    }
}
