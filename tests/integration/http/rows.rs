//! Test data: two fleets with two robots of three whiskers each, and all kinds of events.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use vibrissa_core::mechanics::{CONTACT_RATIOS, Formulation};
use vibrissa_core::robot::event::{ArrayKind, ArraySheet, Factsheet, Link, Task, TouchTests, WhiskerSheet};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};
use vibrissa_protocol::Name;
use vibrissa_store::Resolution;
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, ContactRow, DecisionRow, EndedRow, ErrorBinRow, ErrorRow, HealthRow,
    Interval, LayoutRow, Record, RefinementRow, RobotAlarmRow, RobotRow, RollupRow, SetpointRow, SetpointStateRow,
    TouchTestProgressRow, TouchTestRow, TrimRow, WhiskerRow,
};
use vibrissa_store::black_boxes::NewBlackBox;
use vibrissa_store::{Batch, Lease, Store, Supervisor, Writer};

/// Time of the first row, microseconds since 1970 UTC.
pub(crate) const START_US: i64 = 1_795_248_000_000_000;
/// The compensation cases of the paper.
pub(crate) const CASES: [&str; 3] = ["SELF_COMPENSATION", "SHORTER_FOR_LONGER", "LONGER_FOR_SHORTER"];
/// Number of contacts of whisker 0 of the first robot.
pub(crate) const CONTACTS: i64 = 3000;
/// Number of minute aggregates per whisker.
pub(crate) const MINUTES: i64 = 130;
/// Number of hour aggregates per whisker.
pub(crate) const HOURS: i64 = 7;
/// Number of decisions per robot.
const DECISIONS: u32 = 7;

/// A compensation error that was written.
#[derive(Debug)]
pub(crate) struct WrittenError {
    pub(crate) fleet: String,
    pub(crate) robot: String,
    pub(crate) target: usize,
    pub(crate) case: &'static str,
    pub(crate) row: ErrorRow,
}

/// Rows that were written.
#[derive(Debug, Default)]
pub(crate) struct Written {
    pub(crate) contacts: Vec<ContactRow>,
    /// Errors in the order in which they were written.
    pub(crate) errors: Vec<WrittenError>,
}

/// Writes all rows.
pub(crate) async fn write(store: &Store) -> Written {
    let mut random = ChaCha8Rng::seed_from_u64(2021);
    let mut written = Written::default();
    let supervisor = Supervisor {
        id: "a".into(),
        name: "supervisor a".to_owned(),
        fleets: ["f", "g"].map(|fleet| Name::new(fleet).unwrap()).to_vec(),
        time_to_live: std::time::Duration::from_secs(600),
    };
    let mut writer = store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    for fleet in &supervisor.fleets {
        let lease = writer.acquire(&supervisor, fleet).await.unwrap().unwrap();
        for name in ["r1", "r2"] {
            robot(&mut writer, &lease, name, &mut random, &mut written).await;
        }
    }
    written
}

/// Writes two further robots into a fleet.
pub(crate) async fn robots(writer: &mut Writer, lease: &Lease) {
    let (mut random, mut written) = (ChaCha8Rng::seed_from_u64(7), Written::default());
    for name in ["r1", "r2"] {
        robot(writer, lease, name, &mut random, &mut written).await;
    }
}

fn known(epoch: u64) -> Robot {
    let whisker = |number: u16| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length: Millimetre::new(70.0).unwrap(),
        pressure: Megapascal::new(0.1).unwrap(),
        pressure_max: Megapascal::new(0.2).unwrap(),
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: (0..3).filter(|other| *other != number).collect(),
    };
    let whiskers = (0..3).map(whisker).collect();
    let array = ArraySheet { name: "left".to_owned(), kind: ArrayKind::Type1, task: Task::Ratio, whiskers };
    let factsheet = Factsheet {
        arrays: vec![array],
        touch_tests: TouchTests::default(),
        applies_gain: false,
        air_control: Default::default(),
    };
    let params = Params::nguyen_2021(Formulation::Published);
    let mut robot = Robot::new(epoch, Numbers::default());
    let mut effects = Vec::new();
    let now = Micros::from_s(1.0);
    robot.step(&params, now, &Event::Connection { boot_id: "b1", link: Link::Online }, &mut effects);
    robot.step(&params, now, &Event::Factsheet { boot_id: "b1", factsheet: &factsheet }, &mut effects);
    robot
}

/// A box with one message.
fn black_box(robot_id: i64, whisker_id: i64) -> NewBlackBox {
    let mut body = GzEncoder::new(Vec::new(), Compression::default());
    body.write_all(b"{\"received_us\":1,\"topic\":\"whisker/v1/f/r1/contacts\",\"payload\":{}}\n").unwrap();
    NewBlackBox {
        robot_id,
        whisker_id,
        cause: "TRIM",
        event_us: START_US,
        began_us: START_US - 60_000_000,
        ends_us: START_US + 60_000_000,
        last_us: START_US + 59_000_000,
        state: "COMPLETE",
        messages: 1,
        left_out: 0,
        has_state: false,
        bytes: 67,
        body: body.finish().unwrap(),
    }
}

async fn robot(writer: &mut Writer, lease: &Lease, name: &str, random: &mut ChaCha8Rng, written: &mut Written) {
    let robot = known(lease.epoch());
    let robot_id = writer.register(lease, (name, "b"), 1_000_000).await.unwrap().unwrap().robot_id;
    let boot = writer.boot(lease, robot_id, "b1", START_US).await.unwrap();
    let whiskers = writer.whisker_ids(lease, robot_id, &robot).await.unwrap();
    let ids: Vec<i64> = whiskers.into_iter().map(|(whisker_id, _)| whisker_id).collect();
    let mut batch = Batch {
        layouts: vec![LayoutRow { robot_id, model: "crawler".to_owned(), gone: Vec::new() }],
        robots: vec![RobotRow {
            robot_id,
            boot_id: Some("b1".to_owned()),
            connection: if name == "r1" { "ONLINE" } else { "OFFLINE" },
            updated_us: START_US,
            journal_number: 0,
            held: false,
            software: r#"[{"kind":"AGENT","name":"vibrissa-robot","version":"0.2.0"}]"#.to_owned(),
            state: robot.to_bytes().unwrap(),
        }],
        whiskers: (0..3).map(|index| whisker(&robot, &ids, index)).collect(),
        rollups: rollups(&ids),
        records: happenings(robot_id, &ids).into_iter().chain(touch_tests(robot_id, &ids)).collect(),
        ..Batch::default()
    };
    for number in 0..DECISIONS {
        let decided = Decided::new(robot_id, number, &ids);
        batch.records.extend(decided.records());
        batch.records.extend((0..3).map(|_| Record::Error(Box::new(decided.error(random)))));
    }
    let is_first = written.contacts.is_empty();
    if is_first {
        batch.contacts = contacts(ids[0], boot, random);
    }
    // PostgreSQL ends a transaction that rests for half a second, which happens on a busy machine.
    let mut tries = 1;
    while let Err(problem) = writer.commit(lease, &batch).await {
        assert!(tries < 5, "{problem}");
        tries += 1;
    }
    if is_first {
        written.contacts = batch.contacts;
    }
    writer.write_black_box(lease, &black_box(robot_id, ids[0])).await.unwrap();
    for record in batch.records {
        if let Record::Error(row) = record {
            let Decided { target, case, .. } = Decided::new(robot_id, row.compensation_id as u32, &ids);
            let (fleet, robot) = (lease.fleet().to_string(), name.to_owned());
            written.errors.push(WrittenError { fleet, robot, target, case, row: *row });
        }
    }
}

/// Minute and hour aggregates of each whisker; some have an error but no contact.
pub(crate) fn rollups(ids: &[i64]) -> Vec<RollupRow> {
    let row = |(index, number, resolution): (usize, i64, Resolution)| {
        let felt = |value: f32| (number % 5 != 4).then_some(value);
        RollupRow {
            whisker_id: ids[index],
            resolution,
            start_us: START_US + number * resolution.us() as i64,
            contacts: if number % 5 == 4 { [0; 3] } else { [number as i32 + 1, index as i32, 2] },
            residual: [felt(0.125), felt(0.5).filter(|_| number > 0), felt(-0.25), felt(0.75)],
            sensitivity_per_mm: felt(0.004),
            ratio: felt(0.7),
            length_mm: felt(70.0 - number as f32 / 8.0),
            length_sd_mm: felt(0.25),
            length_mean_mm: felt(69.5),
            pressure_mpa: felt(0.1),
            temperature_c: felt(24.5),
            compensation_error: (number % 5 == 4).then_some(0.203_85),
        }
    };
    let numbers = |index: usize| {
        let minutes = (0..MINUTES).map(move |number| (index, number, Resolution::Minute));
        minutes.chain((0..HOURS).map(move |number| (index, number, Resolution::Hour)))
    };
    (0..ids.len()).flat_map(numbers).map(row).collect()
}

fn whisker(robot: &Robot, ids: &[i64], index: usize) -> WhiskerRow {
    WhiskerRow {
        whisker_id: ids[index],
        position: index as i64,
        length_mm: [65.0, 69.5, 69.5][index],
        length_sd_mm: 0.25,
        condition: ["TRIMMED", "HEALTHY", "HEALTHY"][index],
        fault: (index == 1).then_some("LEAK"),
        segmenter: (index == 0).then_some("NOISY"),
        pressure_mpa: (index == 0).then_some(0.05),
        setpoint_mpa: 0.1,
        contacts: 7,
        heard_us: (index == 0).then_some(START_US),
        leak_per_s: (index == 1).then_some(Interval { mean: 2e-3, low: 1e-3, high: 3e-3 }),
        erosion_mm_per_contact: None,
        contacts_left: [None; 3],
        held: index == 1,
        state: robot.whisker_to_bytes(index).unwrap(),
        rollup: Vec::new(),
    }
}

/// Trims, changes and alarms, some of them at the same time.
fn happenings(robot_id: i64, ids: &[i64]) -> Vec<Record> {
    let mut records = Vec::new();
    for number in 0..9_u32 {
        let whisker_id = ids[number as usize % 3];
        let at_us = START_US + i64::from(number / 2) * 1_000_000;
        records.push(Record::Trim(TrimRow {
            trim_id: robot_id << 32 | i64::from(number),
            robot_id,
            whisker_id,
            detected_us: at_us,
            length_before_mm: 70.0,
            length_after_mm: 65.0 - f64::from(number % 4),
            length_after_sd_mm: 0.2,
            contacts_to_detect: 12 + i64::from(number % 3),
            pressure_mpa: (number % 2 == 0).then_some(0.05),
        }));
        let (kind, was, becomes) = if number % 2 == 0 {
            ("CONDITION", Some("HEALTHY"), Some("SUSPECTED"))
        } else {
            ("FAULT", None, Some("LEAK"))
        };
        records.push(Record::Health(HealthRow { whisker_id, recorded_us: at_us, kind, was, becomes }));
        records.push(Record::Alarm(AlarmRow {
            whisker_id,
            raised_us: at_us,
            kind: ["UNCOMPENSATED", "LEAK"][number as usize % 2],
        }));
    }
    records.push(Record::RobotAlarm(RobotAlarmRow { robot_id, raised_us: START_US + 5_000_000, kind: "ROBOT_SILENT" }));
    records.push(Record::AlarmCleared(AlarmClearedRow {
        whisker_id: ids[0],
        cleared_us: START_US + 60_000_000,
        kind: "UNCOMPENSATED",
    }));
    records
}

/// Touch tests of the robot's whiskers: one that is done, one that was rejected, one that runs, and a proposed one.
fn touch_tests(robot_id: i64, ids: &[i64]) -> Vec<Record> {
    let mut records = Vec::new();
    for (number, (reason, state)) in
        (0..).zip([("SUSPICION", "DONE"), ("OPERATOR", "REJECTED"), ("PAUSE", "RUNNING"), ("SCHEDULE", "PROPOSED")])
    {
        let test_id = format!("t-{robot_id}-{number}");
        let whisker_id = ids[number as usize % 3];
        let requested_us = START_US + number * 1_000_000;
        records.push(Record::TouchTest(Box::new(TouchTestRow {
            test_id: test_id.clone(),
            robot_id,
            whisker_id,
            kind: "TIP",
            reason,
            contacts: 10,
            state: if state == "PROPOSED" { "PROPOSED" } else { "PENDING" },
            requested_us,
        })));
        records.push(Record::TouchTestProgress(Box::new(TouchTestProgressRow {
            test_id,
            robot_id,
            updated_us: requested_us + 500_000,
            state: Some(state),
            error: (state == "REJECTED").then_some("NOT_READY"),
            ended_us: matches!(state, "DONE" | "REJECTED").then_some(requested_us + 500_000),
            touches: if state == "DONE" { 7 } else { 0 },
            missed: if state == "DONE" { 3 } else { 0 },
            length_mm: (state == "DONE").then_some(65.0),
            length_sd_mm: (state == "DONE").then_some(0.2),
        })));
    }
    records
}

/// A decision and its effects.
struct Decided<'a> {
    robot_id: i64,
    compensation_id: i64,
    number: u32,
    ids: &'a [i64],
    target: usize,
    case: &'static str,
}

impl<'a> Decided<'a> {
    fn new(robot_id: i64, number: u32, ids: &'a [i64]) -> Self {
        let (target, case) = (number as usize % 3, CASES[number as usize % 2]);
        Self { robot_id, compensation_id: robot_id << 32 | i64::from(number), number, ids, target, case }
    }

    fn records(&self) -> Vec<Record> {
        let Self { robot_id, compensation_id, number, ids, target, case } = *self;
        let compensator = if case == CASES[0] { target } else { (target + 1) % 3 };
        let decided_us = START_US + i64::from(number / 2) * 60_000_000;
        let candidate = |chosen: bool| CandidateRow {
            whisker_id: ids[if chosen { compensator } else { (compensator + 1) % 3 }],
            case,
            length_mm: 65.0,
            length_sd_mm: 0.3,
            pressure_before_mpa: 0.1,
            pressure_mpa: chosen.then_some(0.048),
            predicted_error: chosen.then_some(0.2),
            predicted_error_interval: chosen.then_some((0.125, 0.375)),
            predicted_error_by_ratio: chosen.then(|| serde_json::to_string(&CONTACT_RATIOS).unwrap()),
            gives_up_own_role: !chosen,
            chosen,
            refused: (!chosen).then_some("COSTS_MORE"),
        };
        let command_id = format!("c-{compensation_id}");
        let look = RefinementRow {
            compensation_id,
            recorded_us: decided_us,
            contacts: 200,
            outcome: "HELD_DITHER",
            pressure_from_mpa: 0.048,
            pressure_best_mpa: None,
            error: Interval { mean: 0.2, low: 0.1, high: 0.3 },
            error_best: None,
            error_with_gain: 0.05,
            error_with_own_gain: 0.02,
            gain_published: false,
        };
        let mut records = vec![
            Record::Decision(Box::new(DecisionRow {
                compensation_id,
                robot_id,
                target_whisker_id: ids[target],
                target_length_mm: 70.0,
                target_pressure_mpa: 0.1,
                decided_us,
                approval: "AUTOMATIC",
                candidates: vec![candidate(true), candidate(false)],
            })),
            Record::Setpoint(Box::new(SetpointRow {
                command_id: command_id.clone(),
                robot_id,
                whisker_id: ids[compensator],
                compensation_id: Some(compensation_id),
                epoch: 1,
                version: i64::from(number),
                robot_boot_id: "b1".to_owned(),
                pressure_mpa: 0.048,
                slew_mpa_per_s: 0.02,
                issued_us: decided_us,
                expires_us: decided_us + 30_000_000,
                reason: case,
                gain: None,
            })),
            Record::SetpointState(SetpointStateRow {
                command_id,
                robot_id: 0,
                recorded_us: decided_us + 1,
                state: "APPLIED",
                error: None,
                pressure_mpa: Some(0.0481),
            }),
            Record::Refinement(Box::new(look)),
        ];
        if number > 0 {
            records.push(Record::Ended(EndedRow {
                compensation_id,
                ended_us: decided_us + 2,
                end_reason: "REASSIGNED",
            }));
        }
        records
    }

    fn error(&self, random: &mut ChaCha8Rng) -> ErrorRow {
        let mut interval = || {
            let mean = random.random_range(0.05..0.4);
            Interval { mean, low: mean - random.random_range(0.0..0.05), high: mean + random.random_range(0.0..0.05) }
        };
        let bin = |ratio: f64, error| ErrorBinRow {
            ratio,
            contacts: 9,
            after_per_mm: 0.004,
            before_per_mm: 0.003,
            before_origin: "MEASURED",
            target_per_mm: 0.0035,
            target_origin: "MODEL",
            error,
        };
        let mut bins = vec![bin(0.5, interval()), bin(0.9, interval())];
        bins.truncate(if self.number.is_multiple_of(3) { 1 } else { 2 });
        let (error, gain, air) = (interval(), interval(), interval());
        ErrorRow {
            compensation_id: self.compensation_id,
            recorded_us: START_US + i64::from(random.random_range(0..20_u32)) * 90_000_000,
            contacts: 18,
            pressure_mpa: 0.048,
            error,
            with_gain: random.random_bool(0.5).then_some(gain),
            air_error: random.random_bool(0.5).then_some(air),
            bins,
        }
    }
}

/// Contacts at irregular times: some at the same moment, one without deflection, and with a pause.
fn contacts(whisker_id: i64, boot: i64, random: &mut ChaCha8Rng) -> Vec<ContactRow> {
    let mut t_us = START_US;
    let contact = |seq: i64| {
        t_us += if seq == CONTACTS / 2 { 600_000_000 } else { i64::from(random.random_range(0..40_u32)) * 10_000 };
        ContactRow {
            whisker_id,
            boot,
            seq,
            position: 0,
            t_us,
            received_us: t_us + 1000,
            place: "RATIO",
            ratio: Some(random.random_range(0.45..1.0)),
            distance_mm: None,
            deflection_mm: if seq == 17 { 0.0 } else { random.random_range(1.0..4.0) },
            strain: random.random_range(0.001..0.02),
            pressure_mpa: 0.1 + random.random_range(-0.002..0.002),
            temperature_c: 24.1,
            used: if seq % 7 == 3 { "TOO_WEAK" } else { "USED" },
            residual: random.random_bool(0.8).then(|| random.random_range(-0.1..0.1)),
            length_mm: 70.0 - 0.001 * seq as f64,
            length_sd_mm: 0.25,
        }
    };
    (0..CONTACTS).map(contact).collect()
}
