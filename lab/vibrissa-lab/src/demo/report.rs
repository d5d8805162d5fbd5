//! Output of the demo: events as they happen, then a table of estimates beside the simulation's true values, and a
//! verdict.

use std::fmt::Write as _;

use vibrissa_core::mechanics::{CONTACT_RATIOS, compensation_error};
use vibrissa_protocol::Name;
use vibrissa_simulator::Fleet;

use super::scenario::{INCIDENTS, Incident, MULTIPLIES, What};
use vibrissa_core::robot::effect::{AlarmKind, Condition};
use vibrissa_edge::guidance;
use vibrissa_edge::words::{Word, Words, named};
use vibrissa_store::Store;
use vibrissa_store::lists::alarms::{ALARMS, AlarmRow};
use vibrissa_store::lists::compensations::{COMPENSATIONS, CompensationSummary};
use vibrissa_store::lists::happenings::{TRIMS, Trim};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};

/// The paper's measured mean error of case 1 and self-compensation.
const PAPER_ERROR: f64 = 0.203_85;
/// Largest mean measured error of self-compensation on the robot that multiplies its readings.
const GAIN_ERROR_MAX: f64 = 0.06;
/// Maximum number of contacts until a trim must be detected.
const CONTACTS_MAX: i64 = 40;
/// Maximum error of an estimated length, mm.
const OFF_MAX_MM: f64 = 1.0;

/// Result of the demo.
pub(super) struct Outcome {
    /// Text of the report.
    pub(super) text: String,
    /// Whether all expected events happened.
    pub(super) passed: bool,
}

/// Events so far, one line each, oldest first.
pub(super) async fn story(store: &Store) -> anyhow::Result<Vec<String>> {
    let mut lines: Vec<(i64, String)> = Vec::new();
    for change in store.health_changes().await? {
        let becomes = match (&change.was, &change.becomes) {
            (_, Some(word)) => in_words(word),
            (Some(word), None) => format!("no longer {}", in_words(word)),
            (None, None) => continue,
        };
        lines.push((change.recorded_us, format!("{}/{}/{}: {becomes}", change.robot, change.array, change.whisker)));
    }
    for alarm in store.all::<AlarmRow>(&ALARMS, Vec::new()).await? {
        let place = [Some(alarm.robot), alarm.array, alarm.whisker.map(|whisker| whisker.to_string())];
        let hint = guidance::of_word(&alarm.kind).map_or("", |guidance| guidance.hint);
        let name: Vec<_> = place.into_iter().flatten().collect();
        lines.push((alarm.raised_at.0, format!("{}: alarm, {}. {hint}", name.join("/"), in_words(&alarm.kind))));
    }
    for state in store.setpoint_history().await? {
        let line = format!(
            "{}/{}/{}: setpoint {:.4} MPa ({}) {}",
            state.robot, state.array, state.whisker, state.pressure_mpa, state.reason, state.state
        );
        lines.push((state.recorded_us, line));
    }
    lines.sort_by_key(|(at_us, _)| *at_us);
    Ok(lines.into_iter().map(|(_, line)| line).collect())
}

/// The label of a condition, a fault or a kind of alarm.
fn in_words(word: &str) -> String {
    let label =
        named::<Condition>(word).and_then(Words::label).or_else(|| named::<AlarmKind>(word).and_then(Words::label));
    label.unwrap_or(word).to_owned()
}

/// Whether all incidents are detected.
pub(super) async fn is_all_found(store: &Store) -> anyhow::Result<bool> {
    let whiskers: Vec<Whisker> = store.all(&WHISKERS, Vec::new()).await?;
    Ok(INCIDENTS.iter().all(|incident| {
        reading(&whiskers, incident).is_some_and(|whisker| match incident.what {
            What::Trim { .. } | What::TooShort { .. } => whisker.condition == "TRIMMED",
            What::Erosion { .. } => whisker.condition == "ERODING",
        })
    }))
}

fn reading<'a>(whiskers: &'a [Whisker], incident: &Incident) -> Option<&'a Whisker> {
    whiskers.iter().find(|one| {
        one.robot == incident.robot && one.array == incident.array && one.whisker == i64::from(incident.whisker)
    })
}

/// Compares the database with the incidents and true values of the simulation.
pub(super) async fn report(store: &Store, fleet: &Fleet, settled: bool) -> anyhow::Result<Outcome> {
    let whiskers: Vec<Whisker> = store.all(&WHISKERS, Vec::new()).await?;
    let mut trims: Vec<Trim> = store.all(&TRIMS, Vec::new()).await?;
    trims.reverse();
    let compensations: Vec<CompensationSummary> = store.all(&COMPENSATIONS, Vec::new()).await?;
    let mut report = Report { text: String::new(), problems: Vec::new() };
    report.header();
    for incident in &INCIDENTS {
        let Some(whisker) = reading(&whiskers, incident) else {
            report.problem(incident, "the whisker is not in the database");
            continue;
        };
        let of_it: Vec<&Trim> = trims.iter().filter(|trim| is_of(trim, incident)).collect();
        let compensation = compensations.iter().find(|one| {
            one.robot == incident.robot && one.array == incident.array && one.target_whisker == whisker.whisker
        });
        let truth = Truth::of(fleet, incident, compensation)?;
        let contacts = match of_it.first() {
            Some(trim) => Some(contacts_to_detect(store, incident, trim, truth.changed_us).await?),
            None => None,
        };
        report.row(incident, whisker, contacts, compensation, &truth);
        report.check(incident, whisker, &of_it, contacts, compensation, &truth);
    }
    for trim in trims.iter().filter(|trim| !INCIDENTS.iter().any(|incident| is_of(trim, incident))) {
        report.problems.push(format!("false trim: {}/{}/{}", trim.robot, trim.array, trim.whisker));
    }
    report.mean_error(&compensations);
    report.setpoints(&store.setpoint_states().await?);
    report.contacts(store, fleet, settled).await?;
    Ok(report.verdict())
}

/// Whether a compensation serves a whisker that erodes. Its setpoints follow the length, so its measured error belongs to
/// no single length.
fn is_of_eroding(one: &CompensationSummary) -> bool {
    INCIDENTS.iter().any(|incident| {
        let place = (incident.robot, incident.array, i64::from(incident.whisker));
        matches!(incident.what, What::Erosion { .. })
            && place == (one.robot.as_str(), one.array.as_str(), one.target_whisker)
    })
}

fn is_of(trim: &Trim, incident: &Incident) -> bool {
    trim.robot == incident.robot
        && trim.array == incident.array
        && trim.whisker == i64::from(incident.whisker)
        && !matches!(incident.what, What::Erosion { .. })
}

async fn contacts_to_detect(store: &Store, incident: &Incident, trim: &Trim, changed_us: u64) -> anyhow::Result<i64> {
    let whisker = (incident.robot, incident.array, i64::from(incident.whisker));
    Ok(store.contacts_between(whisker, changed_us as i64, trim.detected_at.0).await?)
}

/// True values of the simulation.
struct Truth {
    length_mm: f64,
    changed_us: u64,
    /// Error of the reading by Eq. 35 with the true sensitivities.
    error: Option<f64>,
}

impl Truth {
    fn of(fleet: &Fleet, incident: &Incident, compensation: Option<&CompensationSummary>) -> anyhow::Result<Self> {
        let (robot, array) = (Name::robot(incident.robot)?, Name::new(incident.array)?);
        let handle = fleet.robot(&robot).ok_or_else(|| anyhow::anyhow!("no robot {robot}"))?;
        handle.with(|robot| {
            let missing = || anyhow::anyhow!("no whisker {}/{}", incident.array, incident.whisker);
            let target = robot.whisker(&array, incident.whisker).ok_or_else(missing)?;
            let changed_us = target.changes().first().map_or(u64::MAX, |change| change.t_us);
            let error = compensation.and_then(|compensation| {
                let number = u16::try_from(compensation.compensator_whisker?).ok()?;
                let compensator = robot.whisker(&array, number)?;
                let before_mpa = compensation.pressure_before_mpa?;
                let errors = CONTACT_RATIOS.map(|ratio| {
                    let after = compensator.reading_gain() * compensator.sensitivity_per_mm(ratio).ok()?;
                    let before = compensator.plant().sensitivity_per_mm(ratio, before_mpa).ok()?;
                    compensation_error(after, before, target.plant().whole_sensitivity_per_mm(ratio).ok()?)
                });
                let known: Vec<f64> = errors.into_iter().flatten().collect();
                (!known.is_empty()).then(|| known.iter().sum::<f64>() / known.len() as f64)
            });
            Ok(Self { length_mm: target.plant().length_mm(), changed_us, error })
        })
    }
}

struct Report {
    text: String,
    problems: Vec<String>,
}

impl Report {
    fn header(&mut self) {
        let _ = writeln!(
            self.text,
            "{:<20} {:<9} {:>8} {:>15} {:>9}  {:<19} {:>2} {:>16} {:>17} {:>16} {:>7} {:>10}",
            "whisker",
            "found",
            "true mm",
            "estimated mm",
            "contacts",
            "case",
            "by",
            "pressure MPa",
            "predicted",
            "measured",
            "true",
            "air alone"
        );
    }

    fn row(
        &mut self,
        incident: &Incident,
        whisker: &Whisker,
        contacts: Option<i64>,
        compensation: Option<&CompensationSummary>,
        truth: &Truth,
    ) {
        let served = compensation.filter(|one| one.compensator_whisker.is_some());
        let case = match (compensation, served) {
            (_, Some(one)) => one.compensation_case.clone().unwrap_or_default(),
            (Some(_), None) => "NOT COMPENSATED".to_owned(),
            (None, None) => "-".to_owned(),
        };
        let or_dash = |text: Option<String>| text.unwrap_or_else(|| "-".to_owned());
        let percent = |value: f64| format!("{:.1} %", 100.0 * value);
        let pressure =
            served.and_then(|one| Some(format!("{:.4} > {:.4}", one.pressure_before_mpa?, one.held_pressure_mpa?)));
        let predicted = served.and_then(|one| {
            let (low, high) = (one.predicted_error_low?, one.predicted_error_high?);
            Some(format!("{:.1} ({:.0}..{:.0}) %", 100.0 * one.predicted_error?, 100.0 * low, 100.0 * high))
        });
        let measured = served.and_then(|one| {
            let half = (one.measured_error_high? - one.measured_error_low?) / 2.0;
            Some(format!("{:.1} +- {:.1} %", 100.0 * one.measured_error?, 100.0 * half))
        });
        let _ = writeln!(
            self.text,
            "{:<20} {:<9} {:>8.2} {:>15} {:>9}  {:<19} {:>2} {:>16} {:>17} {:>16} {:>7} {:>10}",
            format!("{}/{}/{}", incident.robot, incident.array, incident.whisker),
            whisker.condition,
            truth.length_mm,
            format!("{:.2} +- {:.2}", whisker.length_mm, whisker.length_high_mm - whisker.length_mm),
            or_dash(contacts.map(|contacts| contacts.to_string())),
            case,
            or_dash(served.and_then(|one| one.compensator_whisker).map(|by| by.to_string())),
            or_dash(pressure),
            or_dash(predicted),
            or_dash(measured),
            or_dash(truth.error.map(percent)),
            or_dash(served.and_then(|one| one.measured_air_error).map(percent)),
        );
    }

    fn check(
        &mut self,
        incident: &Incident,
        whisker: &Whisker,
        trims: &[&Trim],
        contacts: Option<i64>,
        compensation: Option<&CompensationSummary>,
        truth: &Truth,
    ) {
        let off_mm = (whisker.length_mm - truth.length_mm).abs();
        if off_mm > OFF_MAX_MM {
            self.problem(incident, &format!("the estimated length is {off_mm:.2} mm off"));
        }
        if let What::Erosion { .. } = incident.what {
            if whisker.condition != "ERODING" {
                self.problem(incident, &format!("should be detected as ERODING, is {}", whisker.condition));
            }
            return;
        }
        if trims.len() != 1 {
            self.problem(incident, &format!("should be detected as trimmed once, was detected {} times", trims.len()));
        }
        if contacts.is_some_and(|contacts| contacts > CONTACTS_MAX) {
            self.problem(incident, &format!("detected only after {} contacts", contacts.unwrap_or_default()));
        }
        let by = compensation.and_then(|one| one.compensator_whisker);
        match incident.what {
            What::Trim { case, by: expected, .. } => {
                let said = compensation.and_then(|one| one.compensation_case.as_deref());
                let served = by.is_some_and(|by| expected.iter().any(|&one| i64::from(one) == by));
                if said != Some(case.word()) || !served {
                    let should = format!("should be {} by one of {expected:?}", case.word());
                    self.problem(incident, &format!("{should}, is {said:?} by {by:?}"));
                }
                if compensation.is_none_or(|one| one.measured_error.is_none()) {
                    self.problem(incident, "the compensation error was not measured");
                }
            }
            What::TooShort { .. } if compensation.is_none() || by.is_some() => {
                self.problem(incident, "should have no compensator");
            }
            What::TooShort { .. } | What::Erosion { .. } => {}
        }
    }

    fn problem(&mut self, incident: &Incident, problem: &str) {
        self.problems.push(format!("{}/{}/{}: {problem}", incident.robot, incident.array, incident.whisker));
    }

    fn mean_error(&mut self, compensations: &[CompensationSummary]) {
        let _ = writeln!(self.text, "\nMean measured error of self-compensation after cuts:");
        let ways = [(false, "by air alone", PAPER_ERROR), (true, "with a gain", GAIN_ERROR_MAX)];
        for (multiplies, way, most) in ways {
            let own: Vec<f64> = compensations
                .iter()
                .filter(|one| one.compensation_case.as_deref() == Some("SELF_COMPENSATION") && !is_of_eroding(one))
                .filter(|one| (one.robot == MULTIPLIES) == multiplies)
                .filter_map(|one| one.measured_error)
                .collect();
            let mean = own.iter().sum::<f64>() / own.len().max(1) as f64;
            let paper = format!(" (the paper measured {:.3} %)", 100.0 * PAPER_ERROR);
            let _ = writeln!(self.text, "  {way:<12} {:>6.2} %{}", 100.0 * mean, if multiplies { "" } else { &paper });
            if own.is_empty() || mean >= most {
                self.problems.push(format!("the mean error of self-compensation {way} is {:.2} %", 100.0 * mean));
            }
        }
    }

    fn setpoints(&mut self, states: &[(String, i64)]) {
        let list: Vec<String> = states.iter().map(|(state, count)| format!("{count} {state}")).collect();
        let _ = writeln!(self.text, "Setpoints: {}", list.join(", "));
        if states.is_empty() || states.iter().any(|(state, _)| state != "APPLIED") {
            self.problems.push(format!("not every setpoint was applied: {}", list.join(", ")));
        }
    }

    async fn contacts(&mut self, store: &Store, fleet: &Fleet, settled: bool) -> anyhow::Result<()> {
        let made = fleet.contacts_made();
        let recorded = store.contact_count().await?;
        let _ = writeln!(self.text, "Contacts: {made} made, {recorded} recorded");
        if !settled || recorded as u64 != made {
            self.problems.push(format!("{made} contacts were made, {recorded} recorded"));
        }
        Ok(())
    }

    fn verdict(mut self) -> Outcome {
        let passed = self.problems.is_empty();
        let _ = match passed {
            true => writeln!(self.text, "All expected events happened."),
            false => writeln!(self.text, "\nNOT as expected:\n  {}", self.problems.join("\n  ")),
        };
        Outcome { text: self.text, passed }
    }
}
