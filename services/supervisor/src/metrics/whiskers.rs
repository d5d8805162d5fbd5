//! Single robots and whiskers: three series and a health for each whisker, so only where somebody wants them and
//! Prometheus can take them. They show what the fleets' owners have seen last, and vanish with the robot.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use prometheus::core::{Collector, Desc};
use prometheus::proto::MetricFamily;
use prometheus::{GaugeVec, Opts, Result};

use super::kinds::Word;

const ROBOT: [&str; 2] = ["fleet", "robot"];
const WHISKER: [&str; 4] = ["fleet", "robot", "array", "whisker"];
const WHISKER_AND_HEALTH: [&str; 5] = ["fleet", "robot", "array", "whisker", "health"];

/// A robot as it is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotSample {
    /// Its name.
    pub robot: String,
    /// When it was heard of last, since 1970 UTC; none if never.
    pub heard_s: Option<f64>,
    /// Its whiskers.
    pub whiskers: Vec<WhiskerSample>,
}

/// A whisker as it is shown.
#[derive(Debug, Clone, PartialEq)]
pub struct WhiskerSample {
    /// Its array's name.
    pub array: String,
    /// Its number there.
    pub whisker: u16,
    /// Length.
    pub length_m: f64,
    /// Pressure as last measured.
    pub pressure_pa: Option<f64>,
    /// Pressure that the robot holds or moves to.
    pub setpoint_pa: f64,
    /// Fault, or else condition.
    pub health: Word,
}

/// Single robots and whiskers.
#[derive(Debug, Clone)]
pub struct WhiskerMetrics {
    seen: Arc<Mutex<BTreeMap<String, Vec<RobotSample>>>>,
    descriptions: Vec<Desc>,
}

/// One scrape's worth of series.
struct Series {
    heard: GaugeVec,
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
                "When the robot was heard of last, since 1970 UTC.",
                &ROBOT,
            )?,
            length: gauges("vibrissa_whisker_length_meters", "Estimated length of a whisker.", &WHISKER)?,
            pressure: gauges("vibrissa_whisker_pressure_pascals", "Chamber pressure as last measured.", &WHISKER)?,
            setpoint: gauges("vibrissa_whisker_setpoint_pascals", "Pressure that is held or moved to.", &WHISKER)?,
            health: gauges("vibrissa_whisker_health", "1 for the fault or else condition.", &WHISKER_AND_HEALTH)?,
        })
    }

    fn each(&self) -> [&GaugeVec; 5] {
        [&self.heard, &self.length, &self.pressure, &self.setpoint, &self.health]
    }

    fn show(&self, fleet: &str, sample: &RobotSample) {
        if let Some(heard_s) = sample.heard_s {
            self.heard.with_label_values(&[fleet, &sample.robot]).set(heard_s);
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

    /// Shows these robots of a fleet, and no others; none where the fleet is supervised elsewhere.
    pub fn show(&self, fleet: &str, robots: Vec<RobotSample>) {
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if robots.is_empty() {
            seen.remove(fleet);
        } else {
            seen.insert(fleet.to_owned(), robots);
        }
    }
}

impl Collector for WhiskerMetrics {
    fn desc(&self) -> Vec<&Desc> {
        self.descriptions.iter().collect()
    }

    fn collect(&self) -> Vec<MetricFamily> {
        // The names were found good when they were declared.
        let Ok(series) = Series::declare() else { return Vec::new() };
        let seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        for (fleet, robots) in seen.iter() {
            for robot in robots {
                series.show(fleet, robot);
            }
        }
        series.each().into_iter().flat_map(Collector::collect).collect()
    }
}
