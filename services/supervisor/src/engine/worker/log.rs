//! Lines of the log about robots and whiskers, in the words of the console. Each names its subject in full, so that it can be
//! found over REST: see [`FullName`](vibrissa_edge::full_name::FullName).

use tokio::time::Instant;
use tracing::{info, warn};
use vibrissa_core::robot::effect::{CommandState, Decision, Effect, TestState};
use vibrissa_core::robot::event::{Link, Rejection};
use vibrissa_edge::ids::wide_id;
use vibrissa_edge::words::{Word, Words};

use crate::engine::robot::KnownRobot;

/// A boot and its connection.
pub(super) type Connection = (Option<String>, Link);

/// The newest boot of a robot, and its connection.
pub(super) fn connection_of(known: &KnownRobot) -> Connection {
    let (boot_id, link) = known.robot.connection_state();
    (boot_id.map(str::to_owned), link)
}

/// Logs a connection that was lost or found, with the duration of its last state.
pub(super) fn connection(known: &mut KnownRobot, (boot_before, before): &Connection) {
    let (boot_id, link) = known.robot.connection_state();
    let (is_other_boot, is_other_link) = (boot_id != boot_before.as_deref(), link != *before);
    if !is_other_boot && !is_other_link {
        return;
    }
    let lasted_s = known.linked.replace(Instant::now()).map(|since| since.elapsed().as_secs());
    let robot = known.full_name();
    match link {
        Link::Online if is_other_link => info!(%robot, boot_id, lasted_s, "robot connected, it was {}", before.word()),
        Link::Online => info!(%robot, boot_id, lasted_s, "robot started anew"),
        Link::Offline => info!(%robot, boot_id, lasted_s, "robot has said farewell"),
        Link::Broken => warn!(%robot, boot_id, lasted_s, "connection to the robot lost"),
    }
}

/// Logs what people want to know of an effect: findings, decisions, setpoints with their answers, alarms. The whiskers that
/// it names are those after the step.
pub(super) fn effect(known: &KnownRobot, effect: &Effect) {
    let name_of = |index: usize| known.full_name_of(index);
    match effect {
        Effect::Trim(trim) => info!(
            whisker = %name_of(trim.whisker), contacts = trim.contacts_to_detect, "trim found: {:.1} mm are left of {:.1} mm",
            trim.length_after.length.mm(), trim.length_before.mm()
        ),
        Effect::Decided(decision) => decided(known, decision),
        Effect::Ended { compensation, reason, .. } => info!(
            robot = %known.full_name(), compensation_id = wide_id(known.robot_id, *compensation),
            "compensation ended: {}", label_of(*reason)
        ),
        Effect::Approved { compensation } => info!(
            robot = %known.full_name(), compensation_id = wide_id(known.robot_id, *compensation),
            "an operator approves the compensation"
        ),
        Effect::Command(command) => info!(
            whisker = %name_of(command.whisker), version = command.key.version, "setpoint sent: {:.4} MPa, {}",
            command.pressure.mpa(), label_of(command.reason)
        ),
        Effect::CommandState { command, whisker, state, rejection, pressure, .. } => {
            let subject = whisker.map_or(known.full_name(), name_of);
            let (version, error) = (command.version, rejection.map(Word::word));
            match state {
                CommandState::Applied => info!(
                    whisker = %subject, version, pressure_mpa = pressure.map(|pressure| pressure.mpa()), "setpoint applied"
                ),
                CommandState::Rejected if *rejection == Some(Rejection::InTask) => {
                    info!(whisker = %subject, version, "setpoint waits: the robot is in a task");
                }
                CommandState::Rejected | CommandState::Failed | CommandState::Expired => {
                    warn!(whisker = %subject, version, error, "setpoint {}", label_of(*state));
                }
                CommandState::Superseded | CommandState::Abandoned => {
                    info!(whisker = %subject, version, "setpoint {}", label_of(*state));
                }
                CommandState::Pending | CommandState::Received | CommandState::Applying => {}
            }
        }
        Effect::Refined(refinement) => {
            let compensation_id = wide_id(known.robot_id, refinement.compensation);
            let subject = known.target_of(refinement.compensation).map_or(known.full_name(), name_of);
            info!(
                whisker = %subject, compensation_id, "setpoint reviewed, {}; error {:.1} %",
                label_of(refinement.outcome), 100.0 * refinement.error
            );
        }
        Effect::Alarm { whisker, kind } => {
            warn!(whisker = %name_of(*whisker), alarm = kind.word(), "alarm raised: {}", label_of(*kind));
        }
        Effect::AlarmCleared { whisker, kind } => {
            info!(whisker = %name_of(*whisker), alarm = kind.word(), "alarm cleared: {}", label_of(*kind));
        }
        Effect::RobotAlarm { kind } => {
            warn!(robot = %known.full_name(), alarm = kind.word(), "alarm raised: {}", label_of(*kind));
        }
        Effect::RobotAlarmCleared { kind } => {
            info!(robot = %known.full_name(), alarm = kind.word(), "alarm cleared: {}", label_of(*kind));
        }
        Effect::Gone { array, number, alarms } => info!(
            whisker = %known.full_name().whisker(array, *number), alarms = alarms.len(),
            "the factsheet names this whisker no more, its alarms are cleared"
        ),
        Effect::Test(test) => info!(
            whisker = %name_of(test.whisker), kind = test.kind.word(), "touch test requested: {}", label_of(test.reason)
        ),
        Effect::TestProposed(test) => info!(
            whisker = %name_of(test.whisker), kind = test.kind.word(), "touch test proposed: {}", label_of(test.reason)
        ),
        Effect::TestState { whisker, state, rejection, .. } => {
            let subject = whisker.map_or(known.full_name(), name_of);
            let error = rejection.map(Word::word);
            match state {
                TestState::Pending | TestState::Accepted | TestState::Running | TestState::Proposed => {}
                TestState::Done | TestState::Withdrawn | TestState::Refused | TestState::Abandoned => {
                    info!(whisker = %subject, "touch test {}", label_of(*state));
                }
                TestState::Rejected | TestState::Failed | TestState::Expired => {
                    warn!(whisker = %subject, error, "touch test {}", label_of(*state));
                }
            }
        }
        // Frequent, or shown by a later effect.
        Effect::Contact(_)
        | Effect::UnknownWhisker { .. }
        | Effect::MissedTouch { .. }
        | Effect::BadTime { .. }
        | Effect::Condition { .. }
        | Effect::Fault { .. }
        | Effect::Resend(_)
        | Effect::Response(_)
        | Effect::Error(_)
        | Effect::AskForFactsheet => {}
    }
}

fn decided(known: &KnownRobot, decision: &Decision) {
    let (target, compensation_id) =
        (known.full_name_of(decision.target), wide_id(known.robot_id, decision.compensation));
    let Some(chosen) = decision.chosen.and_then(|at| decision.candidates.get(at)) else {
        return warn!(whisker = %target, candidates = decision.candidates.len(), "trimmed, not compensated: no candidate can serve");
    };
    let (by, case) = (known.full_name_of(chosen.whisker), label_of(chosen.case));
    let pressure_mpa = chosen.pressure.map(|pressure| (1e4 * pressure.mpa()).round() / 1e4);
    let error_percent = chosen.predicted_error.map(|error| (1000.0 * error).round() / 10.0);
    let what = if decision.proposed { "compensation proposed, an operator decides" } else { "compensation begins" };
    info!(whisker = %target, %by, compensation_id, pressure_mpa, error_percent, "{what}: {case}");
}

/// A value in the plain words of the console.
fn label_of<T: Words + Copy>(value: T) -> &'static str {
    value.label().unwrap_or_else(|| value.word())
}
