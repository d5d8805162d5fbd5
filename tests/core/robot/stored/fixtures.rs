//! Stored robots of each version, as the program of that version wrote and described them. Files of the newest version
//! hold robots with every optional part of the format.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use vibrissa_core::robot::{RestoreError, Robot};

use super::life::{Life, Store};
use super::{BOOTS, parts_of, rare};

/// A file of stored robots, `tests/data/formats/robots-HEAD-WHISKERS.bin`: for each robot the number of its whiskers,
/// its head, and its whiskers, each part after its length. A `.txt` has the description by the program that wrote them.
struct Fixture {
    /// Version of the heads.
    head: u8,
    /// Version of the whiskers.
    whiskers: u8,
    /// FNV-1a hash of the robots as the newest version stores them.
    becomes: u64,
}

/// The newest first.
const FIXTURES: &[Fixture] = &[
    Fixture { head: 12, whiskers: 19, becomes: 0xb0f0_9aca_15a6_7046 },
    Fixture { head: 12, whiskers: 18, becomes: 0x28a3_3dc9_dac5_501c },
    Fixture { head: 12, whiskers: 17, becomes: 0xa7d2_e2e1_e4d5_c932 },
    Fixture { head: 12, whiskers: 16, becomes: 0x200a_47c3_5099_e2ac },
    Fixture { head: 11, whiskers: 15, becomes: 0x5ec3_7298_114f_f253 },
    Fixture { head: 10, whiskers: 14, becomes: 0xfae5_59f4_f182_c7d5 },
    Fixture { head: 10, whiskers: 13, becomes: 0x8ac4_dd26_9522_379a },
    Fixture { head: 10, whiskers: 12, becomes: 0x6bb0_33f7_dc34_a997 },
    Fixture { head: 9, whiskers: 11, becomes: 0xcf3c_200c_574b_b3c5 },
    Fixture { head: 8, whiskers: 10, becomes: 0x124a_9888_6100_f22d },
    Fixture { head: 8, whiskers: 9, becomes: 0x347e_4a25_0b02_f4ed },
    Fixture { head: 7, whiskers: 8, becomes: 0x1e42_5bdb_01ce_e1c8 },
    Fixture { head: 6, whiskers: 7, becomes: 0xeb28_f2d6_7374_b4ad },
    Fixture { head: 5, whiskers: 6, becomes: 0xb7d9_499c_4693_fd40 },
    Fixture { head: 5, whiskers: 5, becomes: 0x6999_e90c_fbca_8426 },
];

impl Fixture {
    fn path(&self, extension: &str) -> PathBuf {
        let Self { head, whiskers, .. } = self;
        let formats = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/formats");
        formats.join(format!("robots-{head}-{whiskers}.{extension}"))
    }

    fn stores(&self) -> Vec<Store> {
        let mut parts = parts_of(&std::fs::read(self.path("bin")).unwrap()).into_iter();
        let mut stores = Vec::new();
        while let Some(count) = parts.next() {
            let head = parts.next().unwrap();
            stores.push(Store { head, whiskers: parts.by_ref().take(usize::from(count[0])).collect() });
        }
        stores
    }

    /// Writes robots, and their description.
    fn write(&self, stores: &[Store]) {
        let mut bytes = Vec::new();
        for Store { head, whiskers } in stores {
            for part in [&[whiskers.len() as u8][..], head].into_iter().chain(whiskers.iter().map(Vec::as_slice)) {
                bytes.extend((part.len() as u32).to_le_bytes());
                bytes.extend(part);
            }
        }
        std::fs::write(self.path("bin"), bytes).unwrap();
        let text: String = stores.iter().map(|store| described(&restored(store))).collect();
        std::fs::write(self.path("txt"), text).unwrap();
    }
}

/// Describes a robot by parts of its state that all versions have.
fn described(robot: &Robot) -> String {
    let mut text = format!(
        "{:?}, held: {}, {:?}\n",
        robot.connection_state(),
        robot.is_held(),
        robot.arrays().collect::<Vec<_>>()
    );
    for sequence in BOOTS.iter().filter_map(|boot| robot.sequence(boot)) {
        let (boot, next, held, given_up) = (sequence.boot_id(), sequence.next(), sequence.held(), sequence.given_up());
        text += &format!("sequence {boot}: next {next}, held {held:?}, given up {given_up}\n");
    }
    for one in robot.compensations() {
        let (case, error, gain) = (one.case(), one.predicted_error(), one.gain());
        text +=
            &format!("compensation {}: {} by {}, {case:?}, error {error}, ", one.id(), one.target(), one.compensator());
        text += &format!("gain {gain:?}, settled: {}, proposed: {}\n", one.is_settled(), one.is_proposed());
    }
    for one in robot.commands_under_way() {
        let (key, boot, whisker, pressure) = (one.key, &one.robot_boot_id, one.whisker, one.pressure);
        text += &format!("setpoint {key:?} of {boot}: whisker {whisker}, {pressure:?}, ");
        text += &format!("issued {:?}, expires {:?}, {:?}, ", one.issued, one.expires, one.reason);
        text += &format!("compensation {:?}, gain {:?}\n", one.compensation, one.gain);
    }
    for one in (0..robot.whisker_count()).filter_map(|index| robot.whisker(index)) {
        // The error of the factory length is of the factsheet.
        let (number, whole, length) = (one.sheet.number, one.sheet.length, one.relative_length);
        text += &format!("whisker {}/{number} of {whole:?}, {} contacts, ", one.array, one.contacts);
        text += &format!("{:?}, sd {} mm, {:?}, noise {}, ", length.length, length.sd_mm, one.offset, one.noise_scale);
        text += &format!("{:?}, fault {:?}, leak {:?}, ", one.condition, one.fault, one.leak_per_s);
        text += &format!("pressure {:?}, setpoint {:?}, heard {:?}, ", one.pressure, one.setpoint, one.heard);
        text += &format!("held: {}, alarms {:?}, ", one.held, one.standing.kinds().collect::<Vec<_>>());
        text += &format!("touch test {:?}\n", one.touch_test);
    }
    text
}

/// First version of whiskers whose stated length is corrected for the slope of the offset, and whose offset is the present one.
const CORRECTED_SINCE: u8 = 17;

/// A line of a description with length and offset as the model alone has them: a line of an earlier program has these, and
/// one of the present program (`is_corrected`) is turned back by the equations of `LengthFilter::length` and `Offset::shortened`.
fn by_the_model(line: &str, is_corrected: bool) -> String {
    let parted = || {
        let (before, rest) = line.split_once(" contacts, Millimetre(")?;
        let whole_mm: f64 = before.split_once("of Millimetre(")?.1.split_once(')')?.0.parse().ok()?;
        let (length_mm, rest) = rest.split_once("), sd ")?;
        let (level, rest) = rest.split_once("Offset { level: ")?.1.split_once(", slope: ")?;
        let (slope, after) = rest.split_once(" }, noise")?;
        let [length_mm, level, slope]: [f64; 3] = [length_mm, level, slope].map(|number| number.parse().unwrap());
        let (mut whole, mut log_length) = ((level, slope), (length_mm / whole_mm).ln());
        if is_corrected {
            let share_left = length_mm / whole_mm;
            let whole_slope = slope / share_left;
            whole = (level - whole_slope * 0.725 * (share_left - 1.0), whole_slope);
            log_length *= 1.0 - 0.33 * whole_slope;
        }
        Some(format!(
            "{before} contacts, log length {log_length:.9}, offset {:.9} {:.9}, noise{after}",
            whole.0, whole.1
        ))
    };
    parted().unwrap_or_else(|| line.to_owned())
}

/// A line of a description without the standard deviation of the length, which states more doubts in later programs.
fn without_sd(line: &str) -> String {
    let parted = line.split_once("), sd ").and_then(|(before, rest)| Some((before, rest.split_once(" mm, ")?.1)));
    parted.map_or_else(|| line.to_owned(), |(before, after)| format!("{before}) {after}"))
}

fn restored(store: &Store) -> Robot {
    Robot::restore(&store.head, &store.whiskers).unwrap()
}

fn parts_in<'a>(stores: impl IntoIterator<Item = &'a Store>) -> BTreeMap<String, bool> {
    let mut parts = BTreeMap::new();
    for store in stores {
        for (name, has) in restored(store).stored_parts() {
            *parts.entry(name).or_default() |= has;
        }
    }
    parts
}

/// The fewest of these robots that together have as many parts as all of them, about.
fn chosen(stores: impl Iterator<Item = Store>) -> Vec<Store> {
    let mut stores: Vec<(Store, Vec<String>)> = stores
        .map(|store| {
            let parts = restored(&store).stored_parts();
            let has = parts.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect();
            (store, has)
        })
        .collect();
    let mut chosen = Vec::new();
    loop {
        let most = stores.iter().enumerate().max_by_key(|(_, (_, has))| has.len());
        let Some((at, (_, has))) = most.filter(|(_, (_, has))| !has.is_empty()) else { return chosen };
        let has = has.clone();
        stores.iter_mut().for_each(|(_, others)| others.retain(|name| !has.contains(name)));
        chosen.push(stores.swap_remove(at).0);
    }
}

/// FNV-1a hash of robots as the newest version stores them.
fn hash(stores: &[Store]) -> u64 {
    let mark = |hash: u64, byte: &u8| (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
    stores.iter().fold(0xcbf2_9ce4_8422_2325, |hash, store| {
        let robot = restored(store);
        let newest = Store::all_of(&robot);
        assert_eq!(restored(&newest), robot);
        newest.head.iter().chain(newest.whiskers.iter().flatten()).fold(hash, mark)
    })
}

/// A part that is new needs a fixture: `VIBRISSA_WRITE_DOCS` writes the file of the newest version, unless there is one.
#[test]
fn every_optional_part_of_the_format_is_in_a_fixture_of_the_newest_version() {
    let newest = &FIXTURES[0];
    if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() && !newest.path("bin").exists() {
        let lives = (0..24).flat_map(|seed| Life::new(seed, 2500).stored.into_iter().skip(3).step_by(5));
        newest.write(&chosen(rare::stores().into_iter().chain(lives)));
    }
    let stores = newest.stores();
    for store in &stores {
        assert_eq!(Store::all_of(&restored(store)).first_difference(store), None, "the bytes are of this version");
    }
    let missing: Vec<_> = parts_in(&stores).into_iter().filter(|(_, has)| !has).map(|(name, _)| name).collect();
    assert!(missing.is_empty(), "no stored robot has these parts: {missing:#?}");
}

#[test]
fn golden_robots_are_read_as_the_program_of_their_version_described_them() {
    for fixture in FIXTURES {
        let (mut text, versions) = (String::new(), (fixture.head, fixture.whiskers));
        for store in fixture.stores() {
            assert_eq!(store.head[..2], [fixture.head, 0], "{versions:?}");
            // From version 6 on: 512 more than the version, as a varint. Before, nine flags.
            let marked = [fixture.whiskers | 0x80, 4];
            let is_marked = |bytes: &Vec<u8>| bytes[..2] == marked;
            assert!(store.whiskers.iter().all(|one| is_marked(one) == (fixture.whiskers > 5)), "{versions:?}");
            text += &described(&restored(&store));
        }
        let described = std::fs::read_to_string(fixture.path("txt")).unwrap();
        let is_before = fixture.whiskers < CORRECTED_SINCE;
        let compared =
            |line: &str, is_corrected| if is_before { by_the_model(line, is_corrected) } else { without_sd(line) };
        let (now, then): (Vec<_>, Vec<_>) = (
            text.lines().map(|line| compared(line, true)).collect(),
            described.lines().map(|line| compared(line, false)).collect(),
        );
        let differs = now.iter().zip(&then).find(|(now, then)| now != then);
        assert_eq!((differs, now.len()), (None, then.len()), "{versions:?}");
    }
}

/// Parts of the state that [`described`] leaves out.
#[test]
fn regress_robots_of_older_versions_become_the_same_robots_of_the_newest_version() {
    let became: Vec<u64> = FIXTURES.iter().map(|fixture| hash(&fixture.stores())).collect();
    let is_as_before = became.iter().zip(FIXTURES).all(|(became, fixture)| *became == fixture.becomes);
    assert!(is_as_before, "only a new version changes these numbers, all of them: {became:#x?}");
}

/// Version 8 changed the test for leaks. Whiskers of version 7 with the former one were taken for damaged ones.
#[test]
fn regress_whiskers_of_version_7_are_read_with_their_test_for_leaks() {
    let of_version_7 = FIXTURES.iter().find(|fixture| fixture.whiskers == 7).unwrap();
    let parts = parts_in(&of_version_7.stores());
    assert!(parts["leak: test"] && parts["leak: is_leaking"], "{parts:?}");
}

#[test]
fn regress_bytes_of_a_later_version_are_told_from_damaged_ones() {
    let Store { head, whiskers } = FIXTURES[0].stores().swap_remove(0);
    let of_whisker = |by: u8| {
        let mut later = whiskers.clone();
        later[0][0] += by;
        Robot::restore(&head, &later).err()
    };
    assert_eq!([of_whisker(1), of_whisker(100)], [Some(RestoreError::Newer); 2]);
    assert_eq!(of_whisker(101), Some(RestoreError::Whisker(0)), "no program had so many versions");
    let of_head = |version: u8| Robot::restore(&[&[version, 0], &head[2..]].concat(), &[]).err();
    assert_eq!([of_head(13), of_head(112)], [Some(RestoreError::Newer); 2]);
    assert_eq!([of_head(0), of_head(113)], [Some(RestoreError::Head); 2]);
}
