//! Lets incidents happen to the robots of the demo.

use std::sync::{Arc, OnceLock};
use std::time::Duration;

use serde_json::json;
use vibrissa_protocol::Name;
use vibrissa_simulator::scenario::{BadScenario, Change};
use vibrissa_simulator::{Robot, RobotHandle, clock::now_us};
use vibrissa_store::{Store, StoreError};
use vibrissa_supervisor::action_notifier::ActionNotifier;
use vibrissa_supervisor::http::asking::{Asker, number_of};
use vibrissa_supervisor::http::problem::Problem;

use super::incident::{Incident, WhiskerName};
use crate::demo::scenario::FLEET;

/// Least length that the simulation permits, mm.
const LENGTH_MIN_MM: f64 = 40.0;
/// Wear by each contact, mm.
const EROSION_MM_PER_CONTACT: f64 = 0.01;
/// Length that wears off in all, mm.
const EROSION_MM: f64 = 6.0;
/// Leak of a chamber, MPa/s.
const LEAK_MPA_PER_S: f64 = 0.005;
/// Temperature at which whiskers have their nominal sensitivity, °C.
const NOMINAL_C: f64 = 24.0;
/// Growth of the sensitivity per kelvin.
const SENSITIVITY_PER_K: f64 = 0.005;
/// Lowest and highest temperature, °C.
const TEMPERATURE_C: (f64, f64) = (0.0, 60.0);
/// Time in which contacts of a removed whisker reach the supervisor, before its replacement is reported.
const REMOVAL: Duration = Duration::from_millis(500);
/// Time to wait for the supervisor's answer to that report.
const PATIENCE: Duration = Duration::from_secs(5);

/// Why an incident does not happen.
#[derive(Debug, thiserror::Error)]
pub(in crate::demo) enum Refusal {
    /// The robots still play the scripted scenario.
    #[error("the scripted part is running: try again after its report, in less than a minute")]
    NotYet,
    /// There is no such whisker.
    #[error("there is no whisker {0}; there are {1}")]
    UnknownWhisker(WhiskerName, String),
    /// A number is outside its range.
    #[error("{detail}")]
    OutOfRange {
        /// Name of the number in the request.
        field: &'static str,
        /// Description with the permitted range.
        detail: String,
    },
    /// The simulation refuses it.
    #[error(transparent)]
    Simulation(#[from] BadScenario),
    /// The database cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The supervisor has not accepted the report of a replacement.
    #[error("the whisker is new, but its report was not accepted: {0}")]
    Report(String),
}

/// Access to the robots; refuses everything until it is opened.
#[derive(Debug, Clone, Default)]
pub(in crate::demo) struct Incidents(Arc<OnceLock<Opened>>);

#[derive(Debug)]
struct Opened {
    robots: Vec<RobotHandle>,
    store: Store,
    action_notifier: ActionNotifier,
}

impl Incidents {
    /// Accepts incidents from now on.
    pub(in crate::demo) fn open(&self, robots: &[RobotHandle], store: &Store, action_notifier: &ActionNotifier) {
        let (robots, store, action_notifier) = (robots.to_vec(), store.clone(), action_notifier.clone());
        self.0.get_or_init(|| Opened { robots, store, action_notifier });
    }

    /// Lets an incident happen, and tells in one sentence what happened.
    ///
    /// # Errors
    /// The scripted part is running, the whisker is unknown, a number is out of range, or the report of a replacement
    /// is not accepted.
    pub(super) async fn cause(&self, at: &WhiskerName, incident: Incident, asker: Asker) -> Result<String, Refusal> {
        let opened = self.0.get().ok_or(Refusal::NotYet)?;
        let text = opened.change(at, incident)?;
        if incident == Incident::Replace {
            tokio::time::sleep(REMOVAL).await;
            opened.report_replaced(at, asker).await?;
        }
        Ok(text)
    }
}

impl Opened {
    /// Changes the true state of the whisker.
    fn change(&self, at: &WhiskerName, incident: Incident) -> Result<String, Refusal> {
        let unknown = || Refusal::UnknownWhisker(at.clone(), self.whiskers());
        let robot = self.robots.iter().find(|robot| *robot.name() == at.robot).ok_or_else(unknown)?;
        let facts = |robot: &mut Robot| {
            let plant = robot.whisker(&at.array, at.whisker)?.plant();
            Some((plant.length_mm(), plant.temperature_c()))
        };
        // The lock is free again before `unknown` locks all robots.
        let (length_mm, temperature_c) = robot.with(facts).ok_or_else(unknown)?;
        robot.with(|robot| {
            let whisker = Some(at.whisker);
            let (whisker, change, text) = match incident {
                Incident::Cut { by_mm } => {
                    let length_mm = cut(at, length_mm, by_mm)?;
                    let text = format!("{at} is cut by {by_mm} mm to {length_mm:.1} mm");
                    (whisker, Change::Trim { length_mm }, text)
                }
                Incident::Erode => {
                    let until_length_mm = (length_mm - EROSION_MM).max(LENGTH_MIN_MM);
                    let text = format!(
                        "{at} loses {EROSION_MM_PER_CONTACT} mm with each contact, down to {until_length_mm:.1} mm"
                    );
                    (whisker, Change::Erode { rate_mm_per_contact: EROSION_MM_PER_CONTACT, until_length_mm }, text)
                }
                Incident::Leak => {
                    let text = format!("the chamber of {at} leaks, {LEAK_MPA_PER_S} MPa per second");
                    (whisker, Change::Leak { rate_mpa_per_s: LEAK_MPA_PER_S }, text)
                }
                Incident::Heat { by_k } => {
                    let temperature_c = heated(temperature_c, by_k)?;
                    let sensitivity_factor = 1.0 + SENSITIVITY_PER_K * (temperature_c - NOMINAL_C);
                    let text = format!(
                        "the whiskers of {}/{} have {temperature_c:.1} \u{b0}C: each feels {:.1} % more than at \
                         {NOMINAL_C} \u{b0}C, so no cut must be called",
                        at.robot,
                        at.array,
                        100.0 * (sensitivity_factor - 1.0)
                    );
                    (None, Change::Temperature { sensitivity_factor, temperature_c }, text)
                }
                Incident::Replace => (whisker, Change::Replace, format!("{at} is new, and reported as replaced")),
            };
            robot.happen_soon(Some(at.array.clone()), whisker, change, now_us())?;
            Ok(text)
        })
    }

    /// Names of all whiskers, by array: `crawler-2/nose/0 to 2`.
    fn whiskers(&self) -> String {
        let of_robot = |robot: &RobotHandle| {
            let name = robot.name().clone();
            robot.with(|robot| {
                let mut arrays: Vec<(Name, u16)> = Vec::new();
                for whisker in robot.whiskers() {
                    match arrays.last_mut() {
                        Some((array, last)) if array == whisker.array() => *last = whisker.number(),
                        Some(_) | None => arrays.push((whisker.array().clone(), whisker.number())),
                    }
                }
                let entry_of = |(array, last): (Name, u16)| {
                    if last == 0 { format!("{name}/{array}/0") } else { format!("{name}/{array}/0 to {last}") }
                };
                arrays.into_iter().map(entry_of).collect::<Vec<_>>()
            })
        };
        self.robots.iter().flat_map(of_robot).collect::<Vec<_>>().join(", ")
    }

    /// Reports the whisker as replaced, as the person who has installed it does.
    async fn report_replaced(&self, at: &WhiskerName, asker: Asker) -> Result<(), Refusal> {
        let fleet = Name::new(FLEET).map_err(|bad| Refusal::Report(bad.to_string()))?;
        let mut action = asker.action("REPLACED", &json!({}), Some("replaced in the demo".to_owned()));
        action.fleet = Some(fleet.to_string());
        action.robot = Some(at.robot.to_string());
        action.array = Some(at.array.to_string());
        action.whisker = Some(at.whisker.into());
        let refusal = |problem: Problem| Refusal::Report(problem.detail);
        let action_id = number_of(self.store.ask(&action).await?).map_err(refusal)?;
        self.action_notifier.notify(&fleet);
        let answer = self.action_notifier.answer(&self.store, action_id, PATIENCE).await?;
        match answer {
            Some(answer) if answer.state == "DONE" => Ok(()),
            Some(answer) => Err(Refusal::Report(answer.problem.unwrap_or(answer.state))),
            None => Err(Refusal::Report("the action is missing".to_owned())),
        }
    }
}

/// Length after a cut.
fn cut(at: &WhiskerName, length_mm: f64, by_mm: f64) -> Result<f64, Refusal> {
    let most_mm = ((length_mm - LENGTH_MIN_MM) * 10.0).floor() / 10.0;
    if by_mm > 0.0 && by_mm <= most_mm {
        return Ok(length_mm - by_mm);
    }
    let detail = if most_mm > 0.0 {
        format!("{at} is {length_mm:.1} mm long: cut more than 0 and at most {most_mm:.1} mm, not {by_mm}")
    } else {
        format!("{at} is {length_mm:.1} mm long, too short for another cut: replace it")
    };
    Err(Refusal::OutOfRange { field: "by_mm", detail })
}

/// Temperature after a change.
fn heated(temperature_c: f64, by_k: f64) -> Result<f64, Refusal> {
    let (low_c, high_c) = TEMPERATURE_C;
    let heated_c = temperature_c + by_k;
    if (low_c..=high_c).contains(&heated_c) {
        return Ok(heated_c);
    }
    let detail = format!(
        "the whiskers have {temperature_c:.1} \u{b0}C and may have {low_c} to {high_c} \u{b0}C: change by {:.1} to {:.1} K, \
         not {by_k}",
        low_c - temperature_c,
        high_c - temperature_c
    );
    Err(Refusal::OutOfRange { field: "by_k", detail })
}
