//! The stored bytes of robots and whiskers, by version, as the programs of those versions wrote them.
//!
//! A test here fails if the bytes change. Then raise the version, keep a reader of the old one, and add a file for the
//! new one.

use vibrissa_core::robot::{RestoreError, Robot};

const ROBOT_5: &[u8] = include_bytes!("../../data/formats/robot-5.bin");
const ROBOT_6: &[u8] = include_bytes!("../../data/formats/robot-6.bin");
const ROBOT_7: &[u8] = include_bytes!("../../data/formats/robot-7.bin");
const ROBOT_8: &[u8] = include_bytes!("../../data/formats/robot-8.bin");
const ROBOT_9: &[u8] = include_bytes!("../../data/formats/robot-9.bin");
const ROBOT_10: &[u8] = include_bytes!("../../data/formats/robot-10.bin");
const ROBOT_11: &[u8] = include_bytes!("../../data/formats/robot-11.bin");
const ROBOT_12: &[u8] = include_bytes!("../../data/formats/robot-12.bin");
const WHISKERS_5: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-5-0.bin"),
    include_bytes!("../../data/formats/whisker-5-1.bin"),
    include_bytes!("../../data/formats/whisker-5-2.bin"),
];
const WHISKERS_7: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-7-0.bin"),
    include_bytes!("../../data/formats/whisker-7-1.bin"),
    include_bytes!("../../data/formats/whisker-7-2.bin"),
];
const WHISKERS_8: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-8-0.bin"),
    include_bytes!("../../data/formats/whisker-8-1.bin"),
    include_bytes!("../../data/formats/whisker-8-2.bin"),
];
const WHISKERS_9: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-9-0.bin"),
    include_bytes!("../../data/formats/whisker-9-1.bin"),
    include_bytes!("../../data/formats/whisker-9-2.bin"),
];
const WHISKERS_10: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-10-0.bin"),
    include_bytes!("../../data/formats/whisker-10-1.bin"),
    include_bytes!("../../data/formats/whisker-10-2.bin"),
];
const WHISKERS_11: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-11-0.bin"),
    include_bytes!("../../data/formats/whisker-11-1.bin"),
    include_bytes!("../../data/formats/whisker-11-2.bin"),
];
const WHISKERS_12: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-12-0.bin"),
    include_bytes!("../../data/formats/whisker-12-1.bin"),
    include_bytes!("../../data/formats/whisker-12-2.bin"),
];
const WHISKERS_13: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-13-0.bin"),
    include_bytes!("../../data/formats/whisker-13-1.bin"),
    include_bytes!("../../data/formats/whisker-13-2.bin"),
];
const WHISKERS_14: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-14-0.bin"),
    include_bytes!("../../data/formats/whisker-14-1.bin"),
    include_bytes!("../../data/formats/whisker-14-2.bin"),
];
const WHISKERS_15: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-15-0.bin"),
    include_bytes!("../../data/formats/whisker-15-1.bin"),
    include_bytes!("../../data/formats/whisker-15-2.bin"),
];
const WHISKERS_16: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-16-0.bin"),
    include_bytes!("../../data/formats/whisker-16-1.bin"),
    include_bytes!("../../data/formats/whisker-16-2.bin"),
];
const WHISKERS_17: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-17-0.bin"),
    include_bytes!("../../data/formats/whisker-17-1.bin"),
    include_bytes!("../../data/formats/whisker-17-2.bin"),
];
const WHISKERS_18: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-18-0.bin"),
    include_bytes!("../../data/formats/whisker-18-1.bin"),
    include_bytes!("../../data/formats/whisker-18-2.bin"),
];
const WHISKERS_19: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-19-0.bin"),
    include_bytes!("../../data/formats/whisker-19-1.bin"),
    include_bytes!("../../data/formats/whisker-19-2.bin"),
];
const WHISKERS_6: [&[u8]; 3] = [
    include_bytes!("../../data/formats/whisker-6-0.bin"),
    include_bytes!("../../data/formats/whisker-6-1.bin"),
    include_bytes!("../../data/formats/whisker-6-2.bin"),
];

fn restored(whiskers: [&[u8]; 3]) -> Result<Robot, RestoreError> {
    Robot::restore(ROBOT_5, &whiskers.map(<[u8]>::to_vec))
}

#[test]
fn golden_whiskers_of_older_versions_are_read_and_become_version_19() {
    let robot = restored(WHISKERS_5).unwrap();
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        for index in 0..WHISKERS_19.len() {
            let bytes = robot.whisker_to_bytes(index).unwrap();
            std::fs::write(format!("../data/formats/whisker-19-{index}.bin"), bytes).unwrap();
        }
    }
    for older in [
        WHISKERS_6,
        WHISKERS_7,
        WHISKERS_8,
        WHISKERS_9,
        WHISKERS_10,
        WHISKERS_11,
        WHISKERS_12,
        WHISKERS_13,
        WHISKERS_14,
        WHISKERS_15,
        WHISKERS_16,
        WHISKERS_17,
        WHISKERS_18,
        WHISKERS_19,
    ] {
        assert_eq!(robot, restored(older).unwrap());
    }
    assert_eq!(robot.to_bytes().unwrap(), ROBOT_12);
    for (index, bytes) in WHISKERS_19.into_iter().enumerate() {
        assert_eq!(robot.whisker_to_bytes(index).unwrap(), bytes, "whisker {index}");
    }
    // A trimmed whisker in the middle of its compensation.
    assert_eq!(robot.compensations().len(), 1);
    assert!(robot.whisker(1).unwrap().contacts > 500);
}

#[test]
fn golden_robots_of_older_versions_become_version_12() {
    let robot = restored(WHISKERS_6).unwrap();
    let bytes = robot.to_bytes().unwrap();
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
        std::fs::write("../data/formats/robot-12.bin", &bytes).unwrap();
    }
    assert_eq!((ROBOT_5[0], bytes[0]), (5, 12));
    assert_eq!(bytes, ROBOT_12);
    for head in [ROBOT_6, ROBOT_7, ROBOT_8, ROBOT_9, ROBOT_10, ROBOT_11, ROBOT_12] {
        assert_eq!(Robot::restore(head, &WHISKERS_6.map(<[u8]>::to_vec)).unwrap(), robot);
    }
}

#[test]
fn regress_bytes_of_a_later_version_are_told_from_damaged_ones() {
    let of_whisker = |by: u8| {
        let mut later = WHISKERS_19[0].to_vec();
        later[0] += by;
        restored([&later, WHISKERS_19[1], WHISKERS_19[2]]).err()
    };
    assert_eq!([of_whisker(1), of_whisker(100)], [Some(RestoreError::Newer); 2]);
    assert_eq!(of_whisker(101), Some(RestoreError::Whisker(0)), "no program had so many versions");
    let of_head = |version: u8| Robot::restore(&[&[version, 0], &ROBOT_9[2..]].concat(), &[]).err();
    assert_eq!([of_head(13), of_head(112)], [Some(RestoreError::Newer); 2]);
    assert_eq!([of_head(0), of_head(113)], [Some(RestoreError::Head); 2]);
}
