//! The journal, and deliberate violations of the contract.

use super::*;
use crate::journal::JournalEntry;
use crate::scenario::Misbehaviour;

fn bench(misbehaviour: Option<Misbehaviour>) -> Bench {
    Bench::connected(|scenario| {
        scenario.behaviour.journal = true;
        scenario.behaviour.misbehaviour = misbehaviour;
    })
}

fn applied(journal: &[JournalEntry]) -> Vec<u64> {
    let version = |entry: &JournalEntry| match entry {
        JournalEntry::Applied(one) => Some(one.setpoint.version),
        JournalEntry::Felt(_) | JournalEntry::Heard(_) => None,
    };
    journal.iter().filter_map(version).collect()
}

#[test]
fn a_journal_has_every_contact_that_was_made() {
    let mut bench = bench(None);
    bench.run(10.0);
    bench.robot.rest();
    bench.run(1.0);
    let journal = bench.robot.take_journal();
    let felt = journal.iter().map(|entry| match entry {
        JournalEntry::Felt(message) => message.contacts.len() as u64,
        JournalEntry::Heard(_) | JournalEntry::Applied(_) => 0,
    });
    assert_eq!(felt.sum::<u64>(), bench.robot.contacts_made());
    assert!(bench.robot.take_journal().is_empty(), "taken is taken");
}

#[test]
fn nothing_is_written_unless_it_is_asked_for() {
    let mut bench = Bench::connected(|_| {});
    bench.run(10.0);
    assert!(bench.robot.take_journal().is_empty());
}

#[test]
fn a_setpoint_again_is_heard_twice_and_applied_once_unless_the_robot_takes_any() {
    for (misbehaviour, times) in [(None, 1), (Some(Misbehaviour::TakesAnySetpoint), 2)] {
        let mut bench = bench(misbehaviour);
        let setpoint = bench.setpoint(1, 0.048);
        bench.send(RobotTopic::Setpoint, &encode(&setpoint));
        let journal = bench.robot.take_journal();
        assert_eq!(applied(&journal), vec![1; times]);
        let heard = journal.iter().filter(|entry| matches!(entry, JournalEntry::Heard(_))).count();
        assert_eq!(heard, 2);
    }
}

#[test]
fn a_robot_that_sends_once_keeps_nothing() {
    let mut bench = bench(Some(Misbehaviour::SendsOnce));
    bench.run(10.0);
    assert_eq!(bench.robot.messages_kept(), 0);
    assert!(!bench.contacts().is_empty());
}
