//! Restarts with a store.

use super::*;

/// Kept contacts messages of a boot, in an agent that was connected or not.
fn stored(is_connected: bool) -> Stored {
    let mut bench = Bench::new(|_| {});
    bench.step(Input::DriverStarted);
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

fn told(boot: &str) -> [(String, &'static str); 2] {
    [(boot.to_owned(), "birth"), (boot.to_owned(), "factsheet")]
}

#[test]
fn messages_of_an_earlier_boot_keep_their_numbers_until_they_are_receipted() {
    let mut bench = Bench::after(|_| {}, "b2", stored(true), START + 60 * S);
    bench.step(Input::Connected);
    let (messages, _) = bench.take();
    assert_eq!(births(&messages), [told("b1"), told("b2")].concat());
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
    assert_eq!(births(&messages), told("b2"));
    assert_eq!(bench.agent.messages_kept(), 1);
    bench.receipt("b1", 3);
    assert_eq!(bench.agent.messages_kept(), 0);
    let next = Bench::after(|_| {}, "b3", bench.stored(), START + 90 * S);
    assert_eq!(next.agent.messages_kept(), 0);
}

#[test]
fn a_supervisor_that_misses_the_factsheet_of_an_earlier_boot_gets_it() {
    let mut bench = Bench::after(|_| {}, "b2", stored(true), START + 60 * S);
    bench.step(Input::Connected);
    bench.take();
    bench.step(Input::Message(RobotTopic::Request, br#"{"boot_id":"s3","seq":0,"request":"FACTSHEET"}"#));
    let (messages, _) = bench.take();
    assert_eq!(births(&messages), [told("b1"), told("b2")].concat());
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
fn no_older_setpoint_is_applied_after_a_restart() {
    let mut bench = Bench::running();
    bench.order(7, 0.12);
    let old = bench.setpoint(7, 0.12);
    let mut bench = Bench::after(|_| {}, "b2", bench.stored(), START + S);
    bench.step(Input::Connected);
    bench.step(Input::DriverStarted);
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
        bench.step(Input::DriverStarted);
        bench.read(0, 0.1);
        bench.step(Input::Connected);
        bench.touch(0);
        bench.run(0.2);
        assert_eq!(bench.agent.earlier.len(), 3.min(boot as usize - 1));
        assert!(bench.agent.messages_dropped() <= 3);
        kept = bench.stored();
    }
}
