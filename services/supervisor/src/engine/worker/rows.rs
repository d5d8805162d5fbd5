//! Rows of decisions, setpoints, compensation errors and refinements.

use vibrissa_core::mechanics::CONTACT_RATIOS;
use vibrissa_core::robot::effect::{Command, CompensationError, Decision, ErrorBin, Refinement};
use vibrissa_core::units::Megapascal;
use vibrissa_edge::ids::{command_id, wide_id};
use vibrissa_edge::interval::Z95;
use vibrissa_edge::words::Word;
use vibrissa_protocol::Name;
use vibrissa_store::batch::{CandidateRow, DecisionRow, ErrorBinRow, ErrorRow, Interval, RefinementRow, SetpointRow};

/// Residual gain as pairs of contact ratio and factor.
pub(super) fn gain(command: &Command) -> Vec<(f64, f64)> {
    command.gain.map(|gain| CONTACT_RATIOS.into_iter().zip(gain).collect()).unwrap_or_default()
}

pub(super) fn decision_row(
    robot_id: i64,
    decided_us: i64,
    decision: &Decision,
    whisker_id: impl Fn(usize) -> i64,
) -> DecisionRow {
    let candidates = decision.candidates.iter().enumerate().map(|(at, one)| CandidateRow {
        whisker_id: whisker_id(one.whisker),
        case: one.case.word(),
        length_mm: one.length.length.mm(),
        length_sd_mm: one.length.sd_mm,
        pressure_before_mpa: one.pressure_before.mpa(),
        pressure_mpa: one.pressure.map(Megapascal::mpa),
        predicted_error: one.predicted_error,
        predicted_error_interval: one.predicted_error_interval,
        predicted_error_by_ratio: one
            .predicted_error_by_ratio
            .and_then(|by_ratio| serde_json::to_string(&by_ratio).ok()),
        gives_up_own_role: one.gives_up_own_role,
        chosen: decision.chosen == Some(at),
        refused: one.refused.map(Word::word),
    });
    DecisionRow {
        compensation_id: wide_id(robot_id, decision.compensation),
        robot_id,
        target_whisker_id: whisker_id(decision.target),
        target_length_mm: decision.target_length.mm(),
        target_pressure_mpa: decision.target_pressure.mpa(),
        decided_us,
        approval: if decision.proposed { "PROPOSED" } else { "AUTOMATIC" },
        candidates: candidates.collect(),
    }
}

/// A difference of a robot's clock from the supervisor's that makes its times useless for the retention of rows, µs.
const CLOCK_WRONG_US: i64 = 86_400_000_000;
/// A contact waits for its supervisor no longer than this, µs.
const WAITS_US: i64 = 30 * 86_400_000_000;

/// Time of a contact for the row of its response, which is removed by this time. `ahead_us` is how far the robot's clock is
/// ahead, if that is known.
pub(super) fn response_time(t_us: i64, ahead_us: Option<i64>, received_us: i64) -> i64 {
    let wrong_us = ahead_us.filter(|ahead_us| ahead_us.abs() > CLOCK_WRONG_US).unwrap_or_default();
    let at_us = t_us.saturating_sub(wrong_us);
    let possible = received_us.saturating_sub(WAITS_US)..=received_us.saturating_add(CLOCK_WRONG_US);
    if possible.contains(&at_us) { at_us } else { received_us }
}

pub(super) fn setpoint_row(
    robot_id: i64,
    fleet: &Name,
    robot: &Name,
    command: &Command,
    whisker_id: i64,
) -> SetpointRow {
    SetpointRow {
        command_id: command_id(fleet, robot, command.key),
        robot_id,
        whisker_id,
        compensation_id: command.compensation.map(|number| wide_id(robot_id, number)),
        epoch: command.key.epoch as i64,
        version: command.key.version as i64,
        robot_boot_id: command.robot_boot_id.clone(),
        pressure_mpa: command.pressure.mpa(),
        slew_mpa_per_s: command.slew_mpa_per_s,
        issued_us: command.issued.0 as i64,
        expires_us: command.expires.0 as i64,
        reason: command.reason.word(),
        gain: serde_json::to_string(&gain(command)).ok(),
    }
}

pub(super) fn error_row(robot_id: i64, recorded_us: i64, error: &CompensationError) -> ErrorRow {
    let bin_row = |bin: &ErrorBin| ErrorBinRow {
        ratio: bin.ratio,
        contacts: i64::from(bin.contacts),
        after_per_mm: bin.after_per_mm,
        before_per_mm: bin.before_per_mm,
        before_origin: bin.before_origin.word(),
        target_per_mm: bin.target_per_mm,
        target_origin: bin.target_origin.word(),
        error: interval(bin.error, bin.sd),
    };
    ErrorRow {
        compensation_id: wide_id(robot_id, error.compensation),
        recorded_us,
        contacts: i64::from(error.contacts),
        pressure_mpa: error.pressure.mpa(),
        error: interval(error.mean, error.sd),
        with_gain: error.with_gain.map(|(mean, sd)| interval(mean, sd)),
        air_error: error.air_alone.map(|(mean, sd)| interval(mean, sd)),
        bins: error.bins.iter().map(bin_row).collect(),
    }
}

pub(super) fn refinement_row(robot_id: i64, recorded_us: i64, refinement: &Refinement) -> RefinementRow {
    RefinementRow {
        compensation_id: wide_id(robot_id, refinement.compensation),
        recorded_us,
        contacts: i64::from(refinement.contacts),
        outcome: refinement.outcome.word(),
        pressure_from_mpa: refinement.pressure_from.mpa(),
        pressure_best_mpa: refinement.pressure_best.map(Megapascal::mpa),
        error: interval(refinement.error, refinement.error_sd),
        error_best: refinement.error_best.map(|(mean, sd)| interval(mean, sd)),
        error_with_gain: refinement.error_with_gain,
        error_with_own_gain: refinement.error_with_own_gain,
        gain_published: refinement.gain_published,
    }
}

fn interval(mean: f64, sd: f64) -> Interval {
    Interval { mean, low: (mean - Z95 * sd).max(0.0), high: mean + Z95 * sd }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The responses of a robot in 1970 were removed at once, and those of one in 2070 stayed as long as the compensation.
    #[test]
    fn regress_a_response_has_no_time_of_a_wrong_clock() {
        const NOW_US: i64 = 1_795_248_000_000_000;
        const HOUR_US: i64 = 3_600_000_000;
        for (t_us, ahead_us, at_us) in [
            (NOW_US - 2, Some(7), NOW_US - 2),
            (NOW_US + HOUR_US, Some(HOUR_US), NOW_US + HOUR_US),
            // After an outage of nine days.
            (NOW_US - 216 * HOUR_US, Some(-7), NOW_US - 216 * HOUR_US),
            (17, Some(17 - NOW_US), NOW_US),
            (17 - 216 * HOUR_US, Some(17 - NOW_US), NOW_US - 216 * HOUR_US),
            (NOW_US + 9_000 * HOUR_US, Some(9_000 * HOUR_US), NOW_US),
            (17, None, NOW_US),
            (NOW_US + 9_000 * HOUR_US, None, NOW_US),
            (i64::MAX, Some(i64::MIN + 1), NOW_US),
        ] {
            assert_eq!(response_time(t_us, ahead_us, NOW_US), at_us, "{t_us} {ahead_us:?}");
        }
    }
}
