//! Rows for tests: one robot with two whiskers.

use std::ops::Range;

use vibrissa_core::mechanics::Formulation;
use vibrissa_core::robot::event::{ArrayKind, ArraySheet, Factsheet, Link, Task, TouchTests, WhiskerSheet};
use vibrissa_core::robot::{Event, Numbers, Params, Robot};
use vibrissa_core::units::{Megapascal, Micros, Millimetre};
use vibrissa_store::batch::{ContactRow, Interval, LayoutRow, RobotRow, WhiskerRow};
use vibrissa_store::{Batch, Lease, Writer};

/// A robot with its ids in the database.
pub(crate) struct Numbered {
    pub(crate) robot: Robot,
    pub(crate) robot_id: i64,
    pub(crate) boot: i64,
    pub(crate) whisker_ids: Vec<i64>,
}

/// Some whiskers on one array.
pub(crate) fn known(epoch: u64, whiskers: u16) -> Robot {
    let whisker = |number| WhiskerSheet {
        number,
        x_mm: 25.0 * f64::from(number),
        y_mm: 0.0,
        model: "nguyen-2021".to_owned(),
        length: Millimetre::new(70.0).unwrap(),
        pressure: Megapascal::new(0.1).unwrap(),
        pressure_max: Megapascal::new(0.2).unwrap(),
        length_tolerance_mm: 0.5,
        strain_max: None,
        neighbours: (0..whiskers).filter(|other| number.abs_diff(*other) == 1).collect(),
    };
    let array = ArraySheet {
        name: "left".to_owned(),
        kind: ArrayKind::Type1,
        task: Task::Ratio,
        whiskers: (0..whiskers).map(whisker).collect(),
    };
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

/// Registers the robot with its layout and states.
pub(crate) async fn robot(writer: &mut Writer, lease: &Lease) -> Numbered {
    let numbered = numbered(writer, lease, "r").await;
    writer.commit(lease, &states(&numbered)).await.unwrap();
    numbered
}

/// Assigns ids to a robot in the database without any further rows.
pub(crate) async fn numbered(writer: &mut Writer, lease: &Lease, name: &str) -> Numbered {
    // A fixed epoch instead of the lease's, so that the bytes of the state are the same on any database.
    let robot = known(1, 2);
    let robot_id = writer.register(lease, (name, "b"), 1_000_000).await.unwrap().unwrap().robot_id;
    let boot = writer.boot(lease, robot_id, "b1", 1_000_000).await.unwrap();
    let whiskers = writer.whisker_ids(lease, robot_id, &robot).await.unwrap();
    let whisker_ids = whiskers.into_iter().map(|(whisker_id, _)| whisker_id).collect();
    Numbered { robot, robot_id, boot, whisker_ids }
}

/// The layout, and states in the core's encoding.
pub(crate) fn states(numbered: &Numbered) -> Batch {
    let whisker = |index: usize| WhiskerRow {
        whisker_id: numbered.whisker_ids[index],
        position: index as i64,
        length_mm: 69.5,
        length_sd_mm: 0.25,
        condition: "HEALTHY",
        fault: (index == 1).then_some("LEAK"),
        segmenter: (index == 0).then_some("NOISY"),
        pressure_mpa: (index == 0).then_some(0.1),
        setpoint_mpa: 0.1,
        contacts: 7,
        heard_us: (index == 0).then_some(1_795_248_000_123_456),
        leak_per_s: (index == 1).then_some(Interval { mean: 2e-3, low: 1e-3, high: 3e-3 }),
        erosion_mm_per_contact: (index == 0).then_some(Interval { mean: 0.005, low: 0.004, high: 0.006 }),
        contacts_left: if index == 0 { [Some(1000.0), Some(800.0), None] } else { [None; 3] },
        held: index == 1,
        state: numbered.robot.whisker_to_bytes(index).unwrap(),
        rollup: vec![7; index],
    };
    Batch {
        layouts: vec![LayoutRow { robot_id: numbered.robot_id, model: "crawler".to_owned(), gone: Vec::new() }],
        robots: vec![RobotRow {
            robot_id: numbered.robot_id,
            boot_id: Some("b1".to_owned()),
            connection: "ONLINE",
            held: true,
            updated_us: 1_795_248_000_000_000,
            journal_number: 0,
            software: r#"[{"kind":"AGENT","name":"vibrissa-robot","version":"0.2.0"}]"#.to_owned(),
            state: numbered.robot.to_bytes().unwrap(),
        }],
        whiskers: vec![whisker(0), whisker(1)],
        ..Batch::default()
    }
}

/// Contacts of whisker 0 in messages with these numbers; every other one has NULL in some columns.
pub(crate) fn contacts(numbered: &Numbered, seqs: Range<i64>) -> Batch {
    let contact = |seq: i64| ContactRow {
        whisker_id: numbered.whisker_ids[0],
        boot: numbered.boot,
        seq,
        position: 0,
        t_us: 1_795_248_000_000_000 + seq,
        received_us: 1_795_248_000_500_000 + seq,
        place: "RATIO",
        ratio: Some(0.1 + 0.2),
        distance_mm: None,
        deflection_mm: 2.4,
        strain: 1.0 / 3.0,
        pressure_mpa: 0.1002,
        temperature_c: 24.1,
        used: "USED",
        residual: (seq % 2 == 0).then_some(-0.012_345_678_901_234_5),
        length_mm: 69.5,
        length_sd_mm: 0.25,
    };
    Batch { contacts: seqs.map(contact).collect(), ..Batch::default() }
}
