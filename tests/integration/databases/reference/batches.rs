//! Batches with rows of many kinds.

use rand::Rng;
use rand_chacha::ChaCha8Rng;
use vibrissa_edge::events::EventKind;
use vibrissa_store::batch::{
    ContactRow, EventRow, JournalRow, LayoutRow, ResponseRow, RobotRow, RollupRow, WhiskerRow,
};
use vibrissa_store::{Batch, LogPositions, Resolution};

use super::records;
use super::subject::Subject;

/// Contacts that PostgreSQL writes by `COPY`.
const COPIED: i64 = 2100;

/// Rows by chance. Some of them break a rule of their table.
pub(super) fn draw(subject: &mut Subject, random: &mut ChaCha8Rng) -> Batch {
    let mut batch = Batch::default();
    for _ in 0..random.random_range(0..4) {
        batch.records.extend(records::draw(subject, random));
    }
    if let Some(at) = subject.any_robot(random) {
        rows_of(subject, at, &mut batch, random);
    }
    if random.random_bool(0.3) {
        batch.events.push(EventRow::new(EventKind::Policy, subject.tick()));
    }
    if random.random_bool(0.4) && !subject.robots.is_empty() {
        subject.journal += i64::from(random.random_bool(0.9));
        let places = 0..random.random_range(1..5);
        let entries = places.map(|_| random.random_range(0..subject.robots.len()) as u8).collect();
        batch.journal = Some(JournalRow { number: subject.journal, entries });
    }
    // A transaction does not delete its own row of the journal.
    batch.journal_done = random.random_bool(0.15).then(|| subject.journal - random.random_range(1..4));
    if random.random_bool(0.3) {
        // A topic that was created anew makes a position lower.
        let next = (0..3).filter(|_| random.random_bool(0.5)).collect::<Vec<u32>>();
        let next = next.into_iter().map(|partition| (partition, random.random_range(0..1_000_000))).collect();
        let topic = if random.random_bool(0.8) { "one" } else { "two" };
        batch.log = LogPositions { topic: topic.into(), next };
    }
    batch
}

fn rows_of(subject: &mut Subject, at: usize, batch: &mut Batch, random: &mut ChaCha8Rng) {
    let Some(&whisker_id) = subject.robots[at].whiskers.first() else { return };
    let count = if random.random_bool(0.02) { COPIED } else { random.random_range(0..4) };
    // Only SQLite checks the boots of contacts.
    if let Some(boot) = subject.boots.first().copied() {
        batch.contacts = (0..count).map(|seq| contact(whisker_id, boot, seq, subject.tick())).collect();
    }
    if random.random_bool(0.3) {
        let state = layout(subject, at, &[]);
        (batch.robots, batch.whiskers) = (state.robots, state.whiskers);
        if random.random_bool(0.3) {
            batch.layouts = state.layouts;
        }
    }
    if random.random_bool(0.2) {
        let resolution = if random.random_bool(0.5) { Resolution::Minute } else { Resolution::Hour };
        // Existing aggregates are left as they are.
        batch.rollups.push(rollup(whisker_id, resolution, random.random_range(0..10)));
    }
    let compensation_id = records::compensation(subject, at, random);
    if random.random_bool(0.1) {
        batch.responses.push(response(compensation_id, subject.tick()));
    }
    if random.random_bool(0.3) {
        let event = EventRow { word: Some("LEAK"), ..EventRow::new(EventKind::AlarmRaised, subject.tick()) };
        batch.events.push(EventRow { whisker_id: Some(whisker_id), ..event.of_robot(subject.robots[at].robot_id) });
    }
}

/// The layout and the states of a robot.
pub(super) fn layout(subject: &mut Subject, at: usize, gone: &[i64]) -> Batch {
    let updated_us = subject.tick();
    let robot = &subject.robots[at];
    let row = |(position, whisker_id): (usize, &i64)| WhiskerRow {
        whisker_id: *whisker_id,
        position: position as i64,
        length_mm: 69.5,
        length_sd_mm: 0.25,
        condition: "HEALTHY",
        fault: None,
        segmenter: (position == 0).then_some("LOST"),
        pressure_mpa: Some(0.1),
        setpoint_mpa: 0.1,
        contacts: 7,
        heard_us: None,
        leak_per_s: None,
        erosion_mm_per_contact: None,
        contacts_left: [None; 3],
        held: (updated_us / 1_000_000 + position as i64) % 7 == 0,
        state: (updated_us + position as i64).to_be_bytes().to_vec(),
        rollup: updated_us.to_be_bytes().to_vec(),
    };
    let whiskers = robot.whiskers.iter().take(robot.core.whisker_count()).enumerate().map(row).collect();
    let gone = gone.iter().map(|whisker_id| (*whisker_id, vec![8])).collect();
    Batch {
        layouts: vec![LayoutRow { robot_id: robot.robot_id, model: "crawler".to_owned(), gone }],
        robots: vec![RobotRow {
            robot_id: robot.robot_id,
            boot_id: Some("b1".to_owned()),
            connection: "ONLINE",
            held: updated_us / 1_000_000 % 5 == 0,
            updated_us,
            journal_number: subject.journal,
            software: r#"[{"kind":"AGENT","name":"vibrissa-robot","version":"0.2.0"}]"#.to_owned(),
            state: updated_us.to_be_bytes().to_vec(),
        }],
        whiskers,
        ..Batch::default()
    }
}

fn contact(whisker_id: i64, boot: i64, seq: i64, received_us: i64) -> ContactRow {
    ContactRow {
        whisker_id,
        boot,
        seq,
        position: 0,
        t_us: received_us,
        received_us,
        place: "RATIO",
        ratio: Some(0.3),
        distance_mm: None,
        deflection_mm: 2.4,
        strain: 0.01,
        pressure_mpa: 0.1,
        temperature_c: 24.1,
        used: "USED",
        residual: None,
        length_mm: 69.5,
        length_sd_mm: 0.25,
    }
}

fn rollup(whisker_id: i64, resolution: Resolution, number: i64) -> RollupRow {
    RollupRow {
        whisker_id,
        resolution,
        start_us: 1_795_248_000_000_000 + number * 3_600_000_000,
        contacts: [3, 0, 0],
        residual: [None; 4],
        sensitivity_per_mm: None,
        ratio: None,
        length_mm: None,
        length_sd_mm: None,
        length_mean_mm: None,
        pressure_mpa: None,
        temperature_c: None,
        compensation_error: None,
    }
}

fn response(compensation_id: i64, t_us: i64) -> ResponseRow {
    ResponseRow {
        compensation_id,
        t_us,
        ratio: 0.85,
        deflection_mm: 2.0,
        after_strain: 0.009,
        before_strain: 0.008,
        before_origin: "MEASURED",
        target_strain: 0.0085,
        target_origin: "MODEL",
    }
}
