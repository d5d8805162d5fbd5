//! Restarts with a store.

use super::*;
use crate::store::file::StoreFile;

/// Kept contacts messages of a boot, in an agent that was connected or not.
fn stored(is_connected: bool) -> Stored {
    let mut bench = Bench::new(|_| {});
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    if is_connected {
        bench.step(Input::Connected);
    }
    for _ in 0..3 {
        bench.touch(0);
        bench.run(0.2);
    }
    bench.stored()
}

fn births(messages: &[Message]) -> Vec<(String, &'static str)> {
    let one = |message: &Message| {
        if let Message::Connection(one) = message {
            Some((one.boot_id.to_string(), "birth"))
        } else if let Message::Factsheet(one) = message {
            Some((one.boot_id.to_string(), "factsheet"))
        } else {
            None
        }
    };
    messages.iter().filter_map(one).collect()
}

fn introduction(boot: &str) -> [(String, &'static str); 2] {
    [(boot.to_owned(), "birth"), (boot.to_owned(), "factsheet")]
}

#[test]
fn messages_of_an_earlier_boot_keep_their_numbers_until_they_are_receipted() {
    let mut bench = Bench::after(|_| {}, "b2", stored(true), START + 60 * S);
    bench.step(Input::Connected);
    let (messages, _) = bench.take();
    assert_eq!(births(&messages), [introduction("b1"), introduction("b2")].concat());
    let sent: Vec<(String, u64)> = messages
        .iter()
        .filter_map(|m| if let Message::Contacts(c) = m { Some((c.boot_id.to_string(), c.seq)) } else { None })
        .collect();
    assert_eq!(sent, [("b1".to_owned(), 0), ("b1".to_owned(), 1), ("b1".to_owned(), 2)]);
    bench.receipt("b1", 2);
    // The supervisor knows the boot now: it is not announced again.
    bench.step(Input::Disconnected);
    bench.step(Input::Connected);
    let (messages, _) = bench.take();
    assert_eq!(births(&messages), introduction("b2"));
    assert_eq!(bench.agent.messages_kept(), 1);
    bench.receipt("b1", 3);
    assert_eq!(bench.agent.messages_kept(), 0);
    let next = Bench::after(|_| {}, "b3", bench.stored(), START + 90 * S);
    assert_eq!(next.agent.messages_kept(), 0);
}

#[test]
fn a_supervisor_that_misses_an_earlier_boot_is_introduced_to_it_before_another_one() {
    const REQUEST: &[u8] = br#"{"boot_id":"s3","seq":0,"request":"FACTSHEET"}"#;
    let mut bench = Bench::after(|_| {}, "b2", stored(true), START + 60 * S);
    bench.step(Input::DriverStarted(0));
    bench.read(0, 0.1);
    // A supervisor that was not there hears only the retained messages, which are those of b2.
    bench.step(Input::Connected);
    bench.order(1, 0.12);
    bench.touch(0);
    bench.take();
    bench.step(Input::Message(RobotTopic::Request, REQUEST));
    assert_eq!((births(&bench.take().0).len(), bench.reconnects), (1, 0), "receipts may be on their way");
    bench.hold([0.12, 0.1], 6.0);
    bench.take();
    bench.step(Input::Message(RobotTopic::Request, REQUEST));
    let (messages, lines) = bench.take();
    assert_eq!((births(&messages).len(), bench.reconnects), (0, 1));
    assert!(lines.iter().any(|line| matches!(line, ToDriver::SetPressure { pressure_mpa: 0.1, whisker: 0, .. })));
    assert_eq!(bench.agent.boot_id().as_str(), "b2-1");
    bench.step(Input::Connected);
    let (messages, _) = bench.take();
    // b2 has an unreceipted message, too: the order is b1, b2, b2-1. Each will has the boot of its birth.
    assert_eq!(births(&messages), [introduction("b1"), introduction("b2"), introduction("b2-1")].concat());
    for boot in ["b1", "b2"] {
        bench.receipt(boot, 3);
    }
    assert_eq!(bench.agent.messages_kept(), 0);
    bench.hold([0.1, 0.1], 6.0);
    bench.step(Input::Message(RobotTopic::Request, REQUEST));
    assert_eq!(bench.reconnects, 1);
    assert_eq!(Bench::after(|_| {}, "b3", bench.stored(), START + 90 * S).agent.messages_kept(), 0);
}

#[test]
fn an_earlier_boot_is_introduced_only_before_the_present_one() {
    let mut bench = Bench::after(|_| {}, "b2", stored(true), START + 60 * S);
    bench.step(Input::Connected);
    assert_eq!(births(&bench.take().0), [introduction("b1"), introduction("b2")].concat());
    // Later it would make the present boot an old one, which never comes back.
    bench.step(Input::Disconnected);
    bench.step(Input::Connected);
    let random = 7;
    bench.step(Input::RequestToAll(
        br#"{"boot_id":"s3","seq":0,"epoch":1,"timestamp":"2026-11-21T08:00:00.000Z","request":"BIRTH"}"#,
        random,
    ));
    bench.run(2.0);
    assert_eq!(births(&bench.take().0), [introduction("b2"), introduction("b2")].concat());
}

#[test]
fn messages_that_were_never_sent_get_numbers_of_the_new_boot() {
    let mut bench = Bench::after(|_| {}, "b2", stored(false), START + 60 * S);
    bench.step(Input::Connected);
    bench.run(0.1);
    let contacts = bench.contacts();
    let numbers: Vec<(&str, u64)> = contacts.iter().map(|one| (one.boot_id.as_str(), one.seq)).collect();
    assert_eq!(numbers, [("b2", 0), ("b2", 1), ("b2", 2)]);
    assert_eq!(contacts[0].contacts[0].t_us, START, "the time of the contact stays");
}

#[test]
fn regress_a_message_of_another_version_that_cannot_be_read_is_counted() {
    let mut stored = stored(false);
    let message = stored.boots[0].messages.values_mut().next().unwrap();
    *message = crate::store::Payload::new(br#"{"later":true}"#).unwrap();
    let bench = Bench::after(|_| {}, "b2", stored, START + 60 * S);
    assert_eq!((bench.agent.messages_kept(), bench.agent.messages_dropped()), (2, 1));
}

#[test]
fn no_older_setpoint_is_applied_after_a_restart() {
    let mut bench = Bench::running();
    bench.order(7, 0.12);
    let old = bench.setpoint(7, 0.12);
    let mut bench = Bench::after(|_| {}, "b2", bench.stored(), START + S);
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted(0));
    assert_eq!(bench.pressures(0), [0.1], "the nominal pressure until an order comes");
    bench.take();
    bench.send(RobotTopic::Setpoint, &old);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::WrongBoot))]);
    // Even if somebody sent it for the new boot.
    let again = Setpoint { command_id: "another".to_owned(), ..bench.setpoint(7, 0.12) };
    bench.send(RobotTopic::Setpoint, &again);
    assert_eq!(bench.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::Stale))]);
    bench.order(8, 0.12);
    assert_eq!(bench.outcomes()[0], (SetpointOutcome::Received, None));
}

#[test]
fn of_many_boots_as_many_are_kept_as_a_supervisor_remembers() {
    let mut kept = stored(true);
    for boot in 2..8 {
        let mut bench = Bench::after(|_| {}, &format!("b{boot}"), kept, START + boot * 60 * S);
        bench.step(Input::DriverStarted(0));
        bench.read(0, 0.1);
        bench.step(Input::Connected);
        bench.touch(0);
        bench.run(0.2);
        assert_eq!(bench.agent.earlier.len(), 2.min(boot as usize - 1));
        assert!(bench.agent.messages_dropped() <= 3);
        kept = bench.stored();
    }
}

/// The records of an agent that was killed, in a file, and what its last moments were.
fn file_of(bench: &Bench, path: &Path) -> Vec<u8> {
    let _ = std::fs::remove_file(path);
    let (mut file, ..) = StoreFile::open(path, 1 << 20).unwrap();
    file.replace([]).unwrap();
    file.append(&bench.records).unwrap();
    std::fs::read(path).unwrap()
}

#[test]
fn after_a_power_cut_at_any_byte_all_before_it_is_sent_and_no_setpoint_is_applied_again() {
    let mut bench = Bench::running();
    bench.order(7, 0.12);
    let applied = bench.setpoint(7, 0.12);
    for _ in 0..3 {
        bench.touch(0);
        bench.run(0.2);
    }
    bench.receipt("b1", 1);
    bench.touch(0);
    bench.run(0.2);
    bench.order(9, 0.11);
    let folder = std::env::temp_dir().join(format!("vibrissa-robot-cut-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let path = folder.join("outbox");
    let whole = file_of(&bench, &path);
    let feeds: Vec<usize> = (0..whole.len()).filter(|&at| whole[at] == b'\n').collect();
    for length in 0..=whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        let (_file, stored, damage) = StoreFile::open(&path, 1 << 20).unwrap();
        assert_eq!(damage.lines, 0, "at {length}");
        // A record is whole without its line feed. The first line is the head.
        let records = feeds.iter().filter(|&&feed| feed <= length).count().saturating_sub(1);
        let mut expected = Stored::default();
        for record in &bench.records[..records] {
            expected.take(record.clone());
        }
        assert_eq!(stored, expected, "at {length}");
        let kept: Vec<u64> = expected.boots.iter().flat_map(|boot| boot.messages.keys().copied()).collect();
        let newest = expected.seen.get(&(left(), 0)).map(|&(_, version)| version);

        let mut next = Bench::after(|_| {}, "b2", stored, START + 60 * S);
        next.step(Input::Connected);
        next.step(Input::DriverStarted(0));
        next.read(0, 0.1);
        let sent: Vec<u64> = next
            .take()
            .0
            .into_iter()
            .filter_map(|m| if let Message::Contacts(c) = m { Some(c.seq) } else { None })
            .collect();
        assert_eq!(sent, kept, "at {length}");
        // The orders of before come again, as they were and with the new boot.
        next.send(RobotTopic::Setpoint, &applied);
        assert_eq!(next.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::WrongBoot))], "at {length}");
        if let Some(newest) = newest {
            let again = Setpoint { command_id: "again".to_owned(), ..next.setpoint(newest, 0.12) };
            next.send(RobotTopic::Setpoint, &again);
            assert_eq!(next.outcomes(), [(SetpointOutcome::Rejected, Some(SetpointError::Stale))], "at {length}");
        }
        assert!(next.pressures(0).iter().all(|&mpa| mpa == 0.1), "at {length}");
    }
    std::fs::remove_dir_all(&folder).unwrap();
}

#[test]
fn regress_hours_without_a_supervisor_go_to_the_disk_and_come_back_in_order() {
    let mut bench = Bench::new(|config| {
        config.limits.outbox_bytes = 65_536;
        config.outbox_file = Some("outbox".into());
    });
    bench.step(Input::DriverStarted(0));
    for number in 0..3_000 {
        if number % 10 == 0 {
            bench.read(0, 0.1);
        }
        let deflection_mm = 1.0 + f64::from(number) / 1e4;
        bench.line(&format!(
            r#"{{"type":"contact","whisker":0,"deflection_mm":{deflection_mm},"strain":0.01,"ratio":0.8}}"#
        ));
        bench.run(0.1);
        assert!(bench.agent.outbox.bytes() <= 65_536);
    }
    assert!(bench.disk.len() > 2_000 && bench.agent.messages_dropped() == 0, "{}", bench.disk.len());
    bench.step(Input::Connected);
    let mut felt = BTreeMap::new();
    for _ in 0..3_000 {
        for message in bench.contacts() {
            let next = message.seq + 1;
            felt.insert(message.seq, message.contacts.iter().map(|one| one.deflection_mm).collect::<Vec<f64>>());
            bench.receipt("b1", next);
        }
        bench.run(0.05);
        bench.read(0, 0.1);
        if felt.len() >= 3_000 {
            break;
        }
    }
    let felt: Vec<f64> = felt.into_values().flatten().collect();
    assert_eq!(felt.len(), 3_000);
    assert!(felt.windows(2).all(|pair| pair[0] < pair[1]), "later contacts do not overtake earlier ones");
    // What came back is stored with its position, so that no restart takes it back again.
    assert_eq!(bench.stored().spooled, Some((1, bench.taken)));
    assert!(bench.disk.is_empty());
    bench.touch(0);
    bench.run(0.2);
    assert_eq!(bench.contacts().len(), 1, "memory is used again");
}

#[test]
fn regress_what_comes_back_from_the_disk_keeps_the_bounds_of_the_outbox() {
    for (messages, bytes, per_message) in [(100, 1 << 20, 1), (10_000, 65_536, 100)] {
        let mut bench = Bench::new(|config| {
            (config.limits.outbox_messages, config.limits.outbox_bytes) = (messages, bytes);
            (config.limits.contacts_per_message, config.limits.contacts_per_s) = (per_message, 1e4);
            config.outbox_file = Some("outbox".into());
        });
        bench.step(Input::DriverStarted(0));
        for _ in 0..300 {
            bench.read(0, 0.1);
            (0..per_message).for_each(|_| bench.touch(0));
            bench.run(0.2);
        }
        assert!(bench.disk.len() > 100, "{}", bench.disk.len());
        bench.step(Input::Connected);
        for _ in 0..300 {
            let next = bench.contacts().iter().map(|message| message.seq + 1).max();
            next.into_iter().for_each(|next| bench.receipt("b1", next));
            assert!(bench.agent.outbox.len() <= messages && bench.agent.outbox.bytes() <= bytes);
            bench.run(0.2);
            bench.read(0, 0.1);
        }
        assert_eq!((bench.disk.len(), bench.agent.messages_kept(), bench.agent.messages_dropped()), (0, 0, 0));
    }
}
