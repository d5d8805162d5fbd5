//! Publication of facts for the maintenance of the whiskers.

use std::time::Duration;

use tokio::time::Instant;
use vibrissa_edge::clock::wall_clock;
use vibrissa_protocol::{self as protocol, PAYLOAD_MAX_BYTES, Timestamp, encode};

use super::Worker;
use super::stepper::Stepper;
use crate::engine::robot::KnownRobot;
use crate::outbox::{Publication, ToRobot};

/// A robot counts as at least this many whiskers against the limit of whiskers at a time.
const WHISKERS_MIN: usize = 8;
/// Largest size of a whisker in a message, bytes of JSON.
const WHISKER_BYTES_MAX: usize = 512;

impl Worker {
    /// Adds the facts that are due to the open batch; they are published after the commit. Stops after `most` whiskers, and
    /// continues there the next time. A robot that is not connected has facts, too.
    pub(super) fn publish_maintenance(&mut self, now: Instant, every: Duration, most: usize) {
        let count = self.robots.len();
        let first = std::mem::take(&mut self.maintenance_resumes_at);
        let mut left = most;
        for index in (first..count).chain(0..first.min(count)) {
            let Some((_, known)) = self.robots.get_index_mut(index) else { continue };
            if known.rests || known.is_excluded || !known.maintenance.is_due(now, every) {
                continue;
            }
            if left == 0 {
                self.maintenance_resumes_at = index;
                return;
            }
            left = left.saturating_sub(known.robot.whisker_count().max(WHISKERS_MIN));
            self.stepper.publish_maintenance_of(known, now, self.epoch);
        }
    }
}

impl Stepper {
    fn publish_maintenance_of(&mut self, known: &mut KnownRobot, now: Instant, epoch: u64) {
        let Some(whiskers) = known.maintenance.next(now, &known.robot, &known.whisker_ids) else { return };
        let mut facts = protocol::Maintenance {
            boot_id: self.boot_id.clone(),
            seq: known.seqs.next_maintenance(),
            epoch,
            timestamp: Timestamp(wall_clock().0),
            whiskers,
        };
        shorten(&mut facts, PAYLOAD_MAX_BYTES);
        self.batch.publish(Publication::new(known.name.clone(), ToRobot::Maintenance(facts)));
    }
}

/// Shortens a message to at most `most` bytes of JSON: the whiskers with the least wear are left out.
fn shorten(facts: &mut protocol::Maintenance, most: usize) {
    while facts.whiskers.len() * WHISKER_BYTES_MAX > most {
        let bytes = encode(facts).len();
        if bytes <= most {
            return;
        }
        let kept = (facts.whiskers.len() * most / bytes).min(facts.whiskers.len() - 1);
        let wear_mm = |one: &protocol::WhiskerMaintenance| one.wear_mm.unwrap_or(0.0);
        facts.whiskers.sort_by(|one, other| wear_mm(other).total_cmp(&wear_mm(one)));
        facts.whiskers.truncate(kept);
    }
}

#[cfg(test)]
mod tests {
    use vibrissa_protocol::{BootId, Message, Name, Topic, WhiskerCondition, WhiskerMaintenance, decode};

    use super::*;

    #[test]
    fn too_long_a_message_leaves_out_the_whiskers_with_the_least_wear() {
        let whisker = |number: u16| WhiskerMaintenance {
            array: Name::new(&"a".repeat(64)).unwrap(),
            whisker: number,
            condition: WhiskerCondition::SensitivityLoss,
            factory_length_mm: 123.456_789_012_345,
            wear_mm: (number % 2 == 1).then(|| f64::from(number) / 10.0),
            wear_low_mm: Some(999.9),
            wear_high_mm: Some(999.9),
            last_calibration: Some(Timestamp(1_795_248_000_000_000)),
            contacts_left: Some(9.9e8),
            contacts_left_low: Some(9.9e8),
            contacts_left_high: Some(9.9e8),
        };
        let boot_id = BootId::new("s").unwrap();
        let whiskers = (0..1000).map(whisker).collect();
        let mut facts = protocol::Maintenance { boot_id, seq: 0, epoch: 7, timestamp: Timestamp(0), whiskers };
        assert!(encode(&facts).len() <= facts.whiskers.len() * WHISKER_BYTES_MAX, "the limit per whisker is too low");
        shorten(&mut facts, PAYLOAD_MAX_BYTES);
        let payload = encode(&facts);
        assert!((PAYLOAD_MAX_BYTES * 9 / 10..=PAYLOAD_MAX_BYTES).contains(&payload.len()), "{}", payload.len());
        let Message::Maintenance(read) =
            decode(&Topic::parse("whisker/v1/f/r/maintenance").unwrap(), &payload).unwrap()
        else {
            panic!("something else")
        };
        assert_eq!(read, facts);
        assert_eq!((read.whiskers[0].whisker, read.whiskers[1].whisker), (999, 997));
        assert!(read.whiskers.len() < 1000 && (0..500).all(|at| read.whiskers[at].wear_mm.is_some()));
    }
}
