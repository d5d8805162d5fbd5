//! Tests of the journal: the layout of its entries, and reading rows that are joined, cut off, or newer.

use vibrissa_core::robot::Numbers;
use vibrissa_core::robot::event::ContactPlace;
use vibrissa_protocol::{self as protocol, BootId, Name};

use crate::engine::robot::retention::ContactRetention;

use super::*;

/// Bytes of each version, as written by the program of that version. If this fails because the bytes have changed:
/// raise the version, keep a reader for the old one, and add a file for the new one.
#[test]
fn golden_entries_of_versions_1_and_2_are_read_and_become_version_3() {
    let of_version_1 = include_bytes!("../../../../../../tests/data/formats/journal-1.bin");
    let of_version_2 = include_bytes!("../../../../../../tests/data/formats/journal-2.bin");
    // The entries of the others, and one with a contact at each kind of place.
    let of_version_3 = include_bytes!("../../../../../../tests/data/formats/journal-3.bin");
    let entries: Vec<Entry> = read(of_version_1).map(Result::unwrap).collect();
    let contacts = entries.iter().filter(|entry| matches!(entry.event, JournalEvent::Contacts { .. })).count();
    let statuses = entries.iter().filter(|entry| matches!(entry.event, JournalEvent::Status { .. })).count();
    assert!(contacts > 0 && statuses > 0, "{contacts} and {statuses}");
    assert!(read(of_version_2).map(Result::unwrap).eq(entries.iter().cloned()));
    let of_3: Vec<Entry> = read(of_version_3).map(Result::unwrap).collect();
    assert!(of_3.starts_with(&entries) && of_3.len() == entries.len() + 1);
    let mut journal = Journal::default();
    of_3.iter().for_each(|entry| journal.write(entry));
    assert!(journal.take().0 == of_version_3, "the bytes have changed");
}

/// Version 4: two rows of a supervisor that was killed while it read a topic. Version 5: made from the layout.
#[test]
fn golden_references_of_version_4_get_the_partition_of_their_row_and_those_of_version_5_name_it() {
    let of_version_3 = include_bytes!("../../../../../../tests/data/formats/journal-3.bin");
    let of_version_4 = include_bytes!("../../../../../../tests/data/formats/journal-4.bin");
    let of_version_5 = include_bytes!("../../../../../../tests/data/formats/journal-5.bin");
    let of_3: Vec<Entry> = read(of_version_3).map(Result::unwrap).collect();
    let part = Part { number: 0, of: 2 };
    let log = |now, partition, from, to| {
        let event = JournalEvent::Log { range: LogRange { partition, from, to }, part, except: Vec::new() };
        Entry { robot_id: NO_ROBOT, now: Micros(now), event }
    };
    let ticks = |now| Entry { robot_id: NO_ROBOT, now: Micros(now), event: JournalEvent::TickAll { part } };
    for partition in [0, 3] {
        let expected = [
            log(1_795_910_864_281_257, partition, 100, 150),
            ticks(1_795_910_864_318_994),
            log(1_795_910_873_424_965, partition, 150, 300),
            ticks(1_795_910_873_444_274),
        ];
        let of_4: Vec<Entry> = stored::read_of(of_version_4, partition).map(Result::unwrap).collect();
        assert_eq!(of_4, expected);
        // Ordinary entries after a reference have no version of their own.
        let mixed = [of_version_4, &of_version_3[8..]].concat();
        assert!(stored::read_of(&mixed, partition).map(Result::unwrap).eq(expected.iter().chain(&of_3).cloned()));
    }

    let (now, part) = (1_795_248_000_000_000, Part { number: 1, of: 2 });
    let tick = |now| Entry { robot_id: 7, now: Micros(now), event: JournalEvent::Tick };
    let mut journal = Journal::default();
    of_3.iter().for_each(|entry| journal.write(entry));
    let range = LogRange { partition: 4, from: 7, to: 519 };
    journal.log(Micros(now), range, part, vec![3, 5]);
    let before = journal.bytes();
    journal.write(&tick(now));
    journal.tick_all(before, Micros(now + 1_000_000), part);
    journal.write(&tick(now + 2_000_000));
    assert!(journal.take().0 == of_version_5, "the bytes have changed");
    let event = JournalEvent::Log { range, part, except: vec![3, 5] };
    let expected = [
        Entry { robot_id: NO_ROBOT, now: Micros(now), event },
        Entry { robot_id: NO_ROBOT, now: Micros(now + 1_000_000), event: JournalEvent::TickAll { part } },
        tick(now + 2_000_000),
    ];
    // The partition of the row says nothing about references that name theirs.
    let of_5 = stored::read_of(of_version_5, 2).map(Result::unwrap);
    assert!(of_5.eq(of_3.iter().chain(&expected).cloned()));
}

#[test]
fn what_was_written_is_read_and_a_row_that_is_cut_off_says_so() {
    let mut known = KnownRobot::new(
        (Name::new("f").unwrap(), Name::robot("r").unwrap()),
        7,
        Robot::new(1, Numbers::default()),
        ContactRetention::All,
    );
    known.boots.insert("b", 3);
    let contact = Contact {
        array: "nowhere",
        whisker: 5,
        robot_time: Micros(11),
        place: ContactPlace::Ratio { ratio: ContactRatio::known(0.7), sd: Some(0.02) },
        deflection: Millimetre::known(3.0),
        strain: Strain::known(0.001),
        pressure: Megapascal::known(0.1),
        is_test: false,
        angle_is_stated: false,
        saturated: false,
        temperature_c: Some(21.0),
    };
    let mut journal = Journal::default();
    let contacts = [contact; 2];
    let event = Event::Contacts { boot_id: "b", seq: 9, contacts: &contacts, missed: &[] };
    let sent = |temperature_c| protocol::Contact {
        array: Name::new("nowhere").unwrap(),
        whisker: 5,
        t_us: 11,
        ratio: Some(0.7),
        ratio_sd: Some(0.02),
        distance_mm: None,
        distance_sd_mm: None,
        tip: false,
        deflection_mm: 3.0,
        strain: 0.001,
        saturated: false,
        pressure_mpa: 0.1,
        temperature_c,
        angle_deg: None,
        angle_sd_deg: None,
        test_id: None,
    };
    let boot_id = BootId::new("b").unwrap();
    let message = protocol::Contacts { boot_id, seq: 9, contacts: vec![sent(21.0), sent(22.0)], missed: Vec::new() };
    journal.contacts(&known, Micros(100), &event, Some(&message));
    journal.tick(&known, Micros(200));
    journal.contacts(&known, Micros(300), &event, None);
    let (bytes, count) = journal.take();
    assert_eq!((count, journal.is_empty()), (2, true));
    let entries: Vec<Entry> = read(&bytes).map(Result::unwrap).collect();
    let kept = |temperatures: &[f64]| {
        temperatures.iter().map(|&one| JournalContact::of(&known.robot, &contact, one)).collect()
    };
    let contacts_of = |temperatures| JournalEvent::Contacts { boot: 3, seq: 9, contacts: kept(temperatures) };
    let entry = |now, event| Entry { robot_id: 7, now: Micros(now), event };
    assert_eq!(
        entries,
        [entry(100, contacts_of(&[21.0, 22.0])), entry(200, JournalEvent::Tick), entry(300, contacts_of(&[]))]
    );
    let JournalEvent::Contacts { contacts, .. } = &entries[0].event else { panic!("contacts") };
    let arrays = ["a".to_owned()];
    assert_eq!(contacts[0].contact(&arrays), Some(Contact { array: "", ..contact }), "an unknown array");
    // Concatenated rows have the same entries.
    let parts: Vec<u8> = by_robot(&bytes).into_iter().flat_map(|(_, entries)| entries).collect();
    let row = [&parts[..], &bytes].concat();
    assert!(read(&row).map(Result::unwrap).eq(entries.iter().chain(&entries).cloned()));
    let newer = [&(-VERSION_OF_LOG - 1).to_le_bytes()[..], &bytes[8..]].concat();
    let refused: Vec<_> = read(&newer).collect();
    assert!(matches!(&refused[..], [Err(problem)] if problem.to_string().contains("version 6")), "{refused:?}");
    let cut: Vec<_> = read(&bytes[..bytes.len() - 1]).collect();
    assert_eq!(cut.iter().filter(|entry| entry.is_ok()).count(), 2);
    assert_eq!(cut.iter().filter(|entry| entry.is_err()).count(), 1);
}
