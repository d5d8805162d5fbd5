//! The rarer rows of batches, by chance.

use rand::Rng;
use rand::seq::IndexedRandom;
use rand_chacha::ChaCha8Rng;
use vibrissa_core::policy::PolicyParams;
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, DecisionRow, EndedRow, ErrorRow, HealthRow, Interval, PolicyChanged,
    PolicyRow, QuarantineRow, Record, RefinementRow, RobotAlarmClearedRow, RobotAlarmRow, SetpointRow,
    SetpointStateRow, TouchTestProgressRow, TouchTestRow, TrimRow,
};
use vibrissa_store::calibrations::ActivationRow;
use vibrissa_store::rollouts::{Compared, RolloutChange, RolloutEvent, RolloutRow};

use super::subject::{NOBODY, Subject};

const KINDS: [&str; 2] = ["LEAK", "UNCOMPENSATED"];

/// A compensation of a robot; it may not exist.
pub(super) fn compensation(subject: &Subject, at: usize, random: &mut ChaCha8Rng) -> i64 {
    let robot = &subject.robots[at];
    robot.robot_id << 32 | random.random_range(0..=robot.drawn)
}

/// A record of a robot, of the fleet, or of nobody.
pub(super) fn draw(subject: &mut Subject, random: &mut ChaCha8Rng) -> Option<Record> {
    let at = subject.any_robot(random)?;
    if random.random_bool(0.3) {
        return Some(of_fleet(subject, at, random));
    }
    let now_us = subject.tick();
    let robot_id = subject.robots[at].robot_id;
    let whiskers = &subject.robots[at].whiskers;
    let whisker_id = whiskers.choose(random).copied().filter(|_| random.random_bool(0.97)).unwrap_or(NOBODY);
    let compensation_id = compensation(subject, at, random);
    let kind = *KINDS.choose(random)?;
    let next = |subject: &mut Subject, random: &mut ChaCha8Rng| {
        subject.robots[at].drawn += i64::from(random.random_bool(0.9));
        subject.robots[at].drawn
    };
    Some(match random.random_range(0..18) {
        0 => {
            let (was, becomes) = (Some("HEALTHY"), None);
            Record::Health(HealthRow { whisker_id, recorded_us: now_us, kind: "FAULT", was, becomes })
        }
        1 => trim(robot_id << 32 | next(subject, random), robot_id, whisker_id, now_us),
        2 | 3 => {
            let compensation_id = robot_id << 32 | next(subject, random);
            decision(compensation_id, robot_id, whisker_id, now_us, random.random_bool(0.7))
        }
        4 | 5 => {
            let version = next(subject, random);
            let compensation_id = random.random_bool(0.5).then_some(compensation_id);
            let pressure_mpa = if random.random_bool(0.95) { 0.048 } else { 0.3 };
            setpoint((robot_id, whisker_id), compensation_id, version, pressure_mpa, now_us)
        }
        6 => Record::SetpointState(SetpointStateRow {
            command_id: format!("c{robot_id}-{}", random.random_range(0..=subject.robots[at].drawn)),
            robot_id: if random.random_bool(0.5) { robot_id } else { 0 },
            recorded_us: now_us,
            state: "APPLIED",
            error: None,
            pressure_mpa: Some(0.05),
        }),
        7 => error(compensation_id, now_us, f64::from(random.random_range(0..8)) / 16.0),
        8 => refinement(compensation_id, now_us),
        9 => Record::Alarm(AlarmRow { whisker_id, raised_us: now_us, kind }),
        10 => Record::AlarmCleared(AlarmClearedRow { whisker_id, cleared_us: now_us, kind }),
        11 => Record::RobotAlarm(RobotAlarmRow { robot_id, raised_us: now_us, kind: "ROBOT_SILENT" }),
        12 => Record::RobotAlarmCleared(RobotAlarmClearedRow { robot_id, cleared_us: now_us, kind: "ROBOT_SILENT" }),
        13 => {
            let whisker = random.random_range(0..3);
            Record::Gone { robot_id, array: "left".to_owned(), whisker, cleared_us: now_us }
        }
        14 => Record::AlarmsForgotten { robot_id, cleared_us: now_us },
        15 => touch_test(robot_id, whisker_id, next(subject, random), now_us),
        16 => progress(robot_id, random.random_range(0..=subject.robots[at].drawn), now_us),
        _ => Record::Ended(EndedRow { compensation_id, ended_us: now_us, end_reason: "REASSIGNED" }),
    })
}

fn of_fleet(subject: &mut Subject, at: usize, random: &mut ChaCha8Rng) -> Record {
    let (now_us, fleet, action_id) = (subject.tick(), subject.fleet().to_string(), subject.any_action(random));
    match random.random_range(0..8) {
        0..3 => {
            let state = *["DONE", "REFUSED", "EXPIRED"].choose(random).unwrap();
            let problem = (state == "REFUSED").then(|| "HELD: released first".to_owned());
            Record::Answer { action_id, robot_id: 0, state, problem, done_us: now_us }
        }
        3 => {
            subject.policy += i64::from(random.random_bool(0.8));
            let (version, changed_by, reason) = (subject.policy, "ann".to_owned(), None);
            let changed = PolicyChanged { fleet, version, changed_us: now_us, changed_by, reason, action_id };
            let policy = PolicyParams { change_margin: 0.125 * version as f64, ..PolicyParams::default() };
            Record::Policy(Box::new(PolicyRow::new(&policy, changed)))
        }
        4 => Record::Quarantined(Box::new(QuarantineRow {
            robot: "r0".to_owned(),
            topic: "factsheet",
            boot_id: None,
            seq: None,
            received_us: now_us,
            quarantined_us: now_us,
            cause: "DATA",
            code: "22021".to_owned(),
            payload: vec![0, 255],
        })),
        5 => {
            let known = subject.calibrations.get(random.random_range(0..=subject.calibrations.len()));
            let (calibration_id, model) = (known.copied().unwrap_or(NOBODY), format!("m{}", random.random_range(0..3)));
            let activated_by = "ann".to_owned();
            let row = ActivationRow { fleet, model, calibration_id, activated_us: now_us, activated_by };
            Record::Activation(Box::new(row))
        }
        6 => {
            let test_id = "t".to_owned();
            Record::TestOfAction { action_id, robot_id: subject.robots[at].robot_id, test_id }
        }
        _ => rollout(action_id, fleet, now_us, random),
    }
}

fn rollout(rollout_id: i64, fleet: String, now_us: i64, random: &mut ChaCha8Rng) -> Record {
    let [kind, change, stage, started_by] = ["POLICY", "{}", "FEW", "ann"].map(str::to_owned);
    let state = (*["RUNNING", "PAUSED", "ROLLED_BACK", "COMPLETED"].choose(random).unwrap()).to_owned();
    let compared = Compared { probability: Some(0.5), changed_error: Some(0.25), ..Compared::default() };
    let row = RolloutRow {
        rollout_id,
        fleet,
        kind,
        change,
        state,
        stage,
        place_max: random.random_range(0..9),
        level: f64::from(random.random_range(1..4)) / 16.0,
        robots: random.random_range(1..9),
        looks: random.random_range(0..9),
        compared,
        started_us: now_us,
        stage_us: now_us,
        updated_us: now_us,
        started_by,
        reason: random.random_bool(0.5).then(|| "why".to_owned()),
    };
    let [event, actor, detail] = ["LOOKED", "supervisor", ""].map(str::to_owned);
    let event = random.random_bool(0.5).then_some(RolloutEvent { event, actor, detail });
    Record::Rollout(Box::new(RolloutChange { row, event }))
}

fn trim(trim_id: i64, robot_id: i64, whisker_id: i64, detected_us: i64) -> Record {
    let (length_before_mm, length_after_mm, length_after_sd_mm) = (70.0, 65.1, 0.2);
    let (contacts_to_detect, pressure_mpa) = (12, None);
    Record::Trim(TrimRow {
        trim_id,
        robot_id,
        whisker_id,
        detected_us,
        length_before_mm,
        length_after_mm,
        length_after_sd_mm,
        contacts_to_detect,
        pressure_mpa,
    })
}

fn decision(compensation_id: i64, robot_id: i64, target: i64, decided_us: i64, chosen: bool) -> Record {
    let candidate = CandidateRow {
        whisker_id: target,
        case: "SELF_COMPENSATION",
        length_mm: 65.0,
        length_sd_mm: 0.3,
        pressure_before_mpa: 0.1,
        pressure_mpa: Some(0.048),
        predicted_error: None,
        predicted_error_interval: None,
        predicted_error_by_ratio: None,
        gives_up_own_role: false,
        chosen,
        refused: None,
    };
    Record::Decision(Box::new(DecisionRow {
        compensation_id,
        robot_id,
        target_whisker_id: target,
        target_length_mm: 70.0,
        target_pressure_mpa: 0.1,
        decided_us,
        approval: "AUTOMATIC",
        candidates: vec![candidate],
    }))
}

fn setpoint(
    (robot_id, whisker_id): (i64, i64),
    compensation_id: Option<i64>,
    version: i64,
    pressure_mpa: f64,
    issued_us: i64,
) -> Record {
    Record::Setpoint(Box::new(SetpointRow {
        command_id: format!("c{robot_id}-{version}"),
        robot_id,
        whisker_id,
        compensation_id,
        epoch: 1,
        version,
        robot_boot_id: "b1".to_owned(),
        pressure_mpa,
        slew_mpa_per_s: 0.02,
        issued_us,
        expires_us: issued_us + 1,
        reason: "SELF_COMPENSATION",
        gain: None,
    }))
}

fn interval(mean: f64) -> Interval {
    Interval { mean, low: mean - 0.01, high: mean + 0.01 }
}

fn error(compensation_id: i64, recorded_us: i64, mean: f64) -> Record {
    Record::Error(Box::new(ErrorRow {
        compensation_id,
        recorded_us,
        contacts: 18,
        pressure_mpa: 0.048,
        error: interval(mean),
        with_gain: None,
        air_error: None,
        bins: Vec::new(),
    }))
}

fn refinement(compensation_id: i64, recorded_us: i64) -> Record {
    Record::Refinement(Box::new(RefinementRow {
        compensation_id,
        recorded_us,
        contacts: 200,
        outcome: "REFINED",
        pressure_from_mpa: 0.048,
        pressure_best_mpa: None,
        error: interval(0.2),
        error_best: None,
        error_with_gain: 0.05,
        error_with_own_gain: 0.02,
        gain_published: false,
    }))
}

fn touch_test(robot_id: i64, whisker_id: i64, number: i64, requested_us: i64) -> Record {
    let (kind, reason, state) = ("WALL", "SUSPICION", "PENDING");
    let test_id = format!("t{robot_id}-{number}");
    let row = TouchTestRow { test_id, robot_id, whisker_id, kind, reason, contacts: 10, state, requested_us };
    Record::TouchTest(Box::new(row))
}

fn progress(robot_id: i64, number: i64, updated_us: i64) -> Record {
    Record::TouchTestProgress(Box::new(TouchTestProgressRow {
        test_id: format!("t{robot_id}-{number}"),
        robot_id,
        updated_us,
        state: Some("RUNNING"),
        error: None,
        ended_us: None,
        touches: 1,
        missed: 0,
        length_mm: None,
        length_sd_mm: None,
    }))
}
