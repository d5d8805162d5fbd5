//! Reports for `/diagnostics`: a status for each whisker, and one for the bridge.

use crate::lifecycle::Activity;
use crate::messages::{DiagnosticStatus, KeyValue, Level};
use crate::whisker::Whisker;

/// Longest text of a problem in a report, in characters.
const PROBLEM_MAX: usize = 200;

/// Counts of passed, shed and refused messages since the start.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(crate) contacts: u64,
    pub(crate) pressures: u64,
    pub(crate) strains: u64,
    pub(crate) tests: u64,
    /// Messages of mapped topics.
    pub(crate) mapped: u64,
    /// Messages without a stamp, and with one that cannot be a time of this clock: the time of receipt counted.
    pub(crate) unstamped: u64,
    pub(crate) misstamped: u64,
    /// Messages that came too fast.
    pub(crate) shed: u64,
    refused: u64,
    last_problem: String,
}

impl Counts {
    pub(crate) fn refuse(&mut self, problem: &str) {
        self.refused += 1;
        self.last_problem = problem.chars().take(PROBLEM_MAX).collect();
    }
}

fn pair(key: &str, value: impl ToString) -> KeyValue {
    KeyValue { key: key.to_owned(), value: value.to_string() }
}

fn number(key: &str, value: Option<f64>) -> Option<KeyValue> {
    value.map(|value| pair(key, format!("{value:.4}")))
}

fn of_whisker(robot: &str, now_s: f64, whisker: &Whisker) -> DiagnosticStatus {
    let pressure_mpa = whisker.pressure_mpa(now_s);
    let condition = whisker.estimate.as_ref().map(|estimate| estimate.condition.as_str());
    let (level, message) = match (pressure_mpa, whisker.unmet_mpa(now_s), condition) {
        (None, ..) => (Level::Stale, "no pressure readings".to_owned()),
        (Some(_), Some(mpa), _) => {
            (Level::Warn, format!("the agent orders {mpa:.4} MPa, and the mapping has no setpoint for it"))
        }
        (Some(_), None, None) => (Level::Ok, "no estimate yet".to_owned()),
        (Some(_), None, Some(condition @ ("HEALTHY" | "LEARNING"))) => (Level::Ok, condition.to_lowercase()),
        (Some(_), None, Some(condition)) => (Level::Warn, condition.to_lowercase().replace('_', " ")),
    };
    let estimate = whisker.estimate.as_ref();
    let numbers = [
        number("pressure_mpa", pressure_mpa),
        number("setpoint_mpa", whisker.setpoint_mpa()),
        number("reading_gain", whisker.reading_gain),
        number("length_mm", estimate.map(|estimate| estimate.length_mm)),
        number("length_low_mm", estimate.map(|estimate| estimate.length_low_mm)),
        number("length_high_mm", estimate.map(|estimate| estimate.length_high_mm)),
    ];
    let values = numbers.into_iter().flatten().chain(condition.map(|condition| pair("condition", condition))).collect();
    let name = format!("vibrissa: {}", whisker.name());
    DiagnosticStatus { level: level as u8, name, message, hardware_id: robot.to_owned(), values }
}

/// The statuses of all whiskers and of the bridge.
pub(crate) fn report(
    robot: &str,
    now_s: f64,
    whiskers: &[Whisker],
    (counts, activity, silent): (&Counts, Activity, Vec<String>),
) -> Vec<DiagnosticStatus> {
    let (level, message) = match (whiskers.is_empty(), counts.refused + counts.shed, counts.misstamped) {
        _ if activity != Activity::Active => (Level::Warn, "the node is not active: no setpoints".to_owned()),
        (true, ..) => (Level::Error, "the agent has not named its whiskers".to_owned()),
        _ if !silent.is_empty() => (Level::Warn, silent.join("; ")),
        (false, 0, 0) => (Level::Ok, "all messages passed on".to_owned()),
        (false, 0, wrong) => (Level::Warn, format!("{wrong} messages with an implausible stamp since the start")),
        (false, lost, _) => (Level::Warn, format!("{lost} messages refused or shed since the start")),
    };
    let values = vec![
        pair("contacts", counts.contacts),
        pair("pressures", counts.pressures),
        pair("strains", counts.strains),
        pair("touch_tests", counts.tests),
        pair("mapped", counts.mapped),
        pair("stamps_unset", counts.unstamped),
        pair("stamps_implausible", counts.misstamped),
        pair("refused", counts.refused),
        pair("shed", counts.shed),
        pair("last_problem", &counts.last_problem),
    ];
    let name = "vibrissa: bridge".to_owned();
    let bridge = DiagnosticStatus { level: level as u8, name, message, hardware_id: robot.to_owned(), values };
    std::iter::once(bridge).chain(whiskers.iter().map(|whisker| of_whisker(robot, now_s, whisker))).collect()
}
