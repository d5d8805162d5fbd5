//! Stored bytes of deferred transactions and of open minute and hour aggregates, by format version.
//!
//! A test fails if the bytes change. In that case raise the version, keep a decoder of the old one, and add a file for
//! the new one.

use vibrissa_core::units::Micros;
use vibrissa_store::Batch;
use vibrissa_store::batch::{
    ContactRow, ErrorBinRow, ErrorRow, EventRow, Interval, Record, RobotAlarmClearedRow, RobotAlarmRow,
    TouchTestProgressRow, TouchTestRow,
};
use vibrissa_store::rollouts::{Compared, RolloutChange, RolloutEvent, RolloutRow};
use vibrissa_supervisor::engine::rollup::Open;

#[test]
fn golden_batches_of_older_versions_are_read_and_become_version_7() {
    let of_version_1 = include_bytes!("../../data/formats/batch-1.bin");
    let of_version_2 = include_bytes!("../../data/formats/batch-2.bin");
    let of_version_3 = include_bytes!("../../data/formats/batch-3.bin");
    let of_version_4 = include_bytes!("../../data/formats/batch-4.bin");
    let of_version_5 = include_bytes!("../../data/formats/batch-5.bin");
    let of_version_6 = include_bytes!("../../data/formats/batch-6.bin");
    let mut batch = Batch::from_bytes(of_version_1).unwrap();
    assert!(!batch.records.is_empty() && !batch.whiskers.is_empty(), "{batch:?}");
    // The batch of version 1 has no contacts; one of version 1 with contacts is read in the store's own tests.
    batch.contacts = vec![contact("RATIO", Some(0.7), None), contact("UNKNOWN", None, None)];
    batch.contacts.push(contact("DISTANCE", Some(0.8), Some(52.5)));
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_2).unwrap()), format!("{batch:?}"));
    batch.records.extend(touch_test());
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_3).unwrap()), format!("{batch:?}"));
    let (robot_id, kind) = (1, "ROBOT_SILENT");
    batch.records.push(Record::RobotAlarm(RobotAlarmRow { robot_id, raised_us: 5, kind }));
    batch.records.push(Record::RobotAlarmCleared(RobotAlarmClearedRow { robot_id, cleared_us: 6, kind }));
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_4).unwrap()), format!("{batch:?}"));
    batch.records.push(Record::Rollout(Box::new(rollout())));
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_5).unwrap()), format!("{batch:?}"));
    let (robot, body) = ("r".to_owned(), r#"{"type":"TRIM"}"#.to_owned());
    batch.events.push(EventRow { robot_id, robot, is_contacts: false, body });
    batch.log_next = Some(9);
    assert_eq!(format!("{:?}", Batch::from_bytes(of_version_6).unwrap()), format!("{batch:?}"));
    batch.records.extend([None, Some(interval(0.6))].map(|air_error| Record::Error(Box::new(error(air_error)))));
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        std::fs::write("data/formats/batch-7.bin", batch.to_bytes().unwrap()).unwrap();
    }
    let of_version_7 = std::fs::read("data/formats/batch-7.bin").unwrap();
    assert!(batch.to_bytes().unwrap() == of_version_7, "the bytes have changed");
    assert_eq!(format!("{:?}", Batch::from_bytes(&of_version_7).unwrap()), format!("{batch:?}"));
}

fn interval(mean: f64) -> Interval {
    Interval { mean, low: mean - 0.01, high: mean + 0.01 }
}

/// A measured error with one bin.
fn error(air_error: Option<Interval>) -> ErrorRow {
    let bin = ErrorBinRow {
        ratio: 0.7,
        contacts: 9,
        after_per_mm: 0.004,
        before_per_mm: 0.003,
        before_origin: "MEASURED",
        target_per_mm: 0.0035,
        target_origin: "MODEL",
        error: interval(0.2),
    };
    ErrorRow {
        compensation_id: 3,
        recorded_us: 4,
        contacts: 9,
        pressure_mpa: 0.08,
        error: interval(0.02),
        with_gain: Some(interval(0.02)),
        air_error,
        bins: vec![bin],
    }
}

/// A roll-out after a comparison.
fn rollout() -> RolloutChange {
    let row = RolloutRow {
        rollout_id: 7,
        fleet: "f".to_owned(),
        kind: "POLICY".to_owned(),
        change: "{}".to_owned(),
        state: "RUNNING".to_owned(),
        stage: "FEW".to_owned(),
        place_max: 214_748_364,
        level: 0.05,
        robots: 20,
        looks: 1,
        compared: Compared {
            probability: Some(0.4),
            changed_robots: 5,
            unchanged_robots: 95,
            changed_error: Some(0.1),
            unchanged_error: None,
        },
        started_us: 8,
        stage_us: 9,
        updated_us: 10,
        started_by: "ann".to_owned(),
        reason: Some("a test".to_owned()),
    };
    let event = RolloutEvent { event: "LOOKED".to_owned(), actor: "supervisor".to_owned(), detail: "fine".to_owned() };
    RolloutChange { row, event: Some(event) }
}

/// A touch test, its progress, and the action that requested it.
fn touch_test() -> [Record; 3] {
    let test_id = "t1".to_owned();
    let test = TouchTestRow {
        test_id: test_id.clone(),
        robot_id: 1,
        whisker_id: 2,
        kind: "WALL",
        reason: "OPERATOR",
        contacts: 10,
        state: "PENDING",
        requested_us: 3,
    };
    let progress = TouchTestProgressRow {
        test_id: test_id.clone(),
        robot_id: 1,
        whisker_id: Some(2),
        updated_us: 4,
        state: Some("DONE"),
        error: None,
        ended_us: Some(4),
        touches: 6,
        missed: 4,
        length_mm: Some(65.0),
        length_sd_mm: Some(0.2),
    };
    [
        Record::TouchTest(Box::new(test)),
        Record::TouchTestProgress(Box::new(progress)),
        Record::TestOfAction { action_id: 5, robot_id: 1, test_id },
    ]
}

fn contact(place: &'static str, ratio: Option<f64>, distance_mm: Option<f64>) -> ContactRow {
    ContactRow {
        whisker_id: 1,
        boot: 2,
        seq: 3,
        position: 4,
        t_us: 5,
        received_us: 6,
        place,
        ratio,
        distance_mm,
        deflection_mm: 2.0,
        strain: 0.01,
        pressure_mpa: 0.1,
        temperature_c: 24.0,
        used: "USED",
        residual: Some(0.1),
        length_mm: 70.0,
        length_sd_mm: 0.2,
    }
}

#[test]
fn golden_a_minute_and_an_hour_of_version_1_are_read_and_written_as_they_were() {
    let bytes = include_bytes!("../../data/formats/rollup-1.bin");
    let open = Open::from_bytes(Some(bytes), Micros::default());
    assert!(open.due().is_some());
    assert_eq!(open.to_bytes().unwrap(), bytes);
}
