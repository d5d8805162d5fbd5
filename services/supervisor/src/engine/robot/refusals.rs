//! Counts of one robot's refusals, for people; no decision depends on them.

use std::collections::BTreeMap;
use std::fmt::Display;

use vibrissa_core::units::Micros;
use vibrissa_protocol::RobotTopic;
use vibrissa_store::refusals::RefusalRow;

/// Characters of a refusal's text that are kept.
const PROBLEM_CHARS_MAX: usize = 400;

/// Counts by topic and reason: both are closed lists, so their number is limited.
#[derive(Debug, Default)]
pub(crate) struct Refusals(BTreeMap<(RobotTopic, &'static str), Count>);

#[derive(Debug, Default)]
struct Count {
    total: u64,
    /// Refusals that the database does not count yet.
    unwritten: i64,
    /// Time of the newest refusal.
    newest: Micros,
    /// Text of the first refusal since the last write.
    problem: String,
}

impl Refusals {
    /// Counts a refused message, or a refused entry of a message.
    pub(crate) fn count(&mut self, (topic, reason): (RobotTopic, &'static str), problem: &dyn Display, now: Micros) {
        let count = self.0.entry((topic, reason)).or_default();
        // A row has one text: that of the first refusal since the last write is enough as an example.
        if count.unwritten == 0 {
            let words = problem.to_string();
            count.problem = words.chars().filter(|one| !one.is_control()).take(PROBLEM_CHARS_MAX).collect();
        }
        count.total += 1;
        count.unwritten += 1;
        count.newest = now;
    }

    /// Rows of the counts since they were last written.
    pub(crate) fn rows(&self, robot_id: i64) -> impl Iterator<Item = RefusalRow> {
        self.0.iter().filter(|(_, count)| count.unwritten > 0).map(move |(&(topic, reason), count)| RefusalRow {
            robot_id,
            topic: topic.as_str(),
            reason,
            refused: count.unwritten,
            refused_us: count.newest.0 as i64,
            problem: count.problem.clone(),
        })
    }

    /// Whether there are counts that the database does not have.
    pub(crate) fn are_due(&self) -> bool {
        self.0.values().any(|count| count.unwritten > 0)
    }

    /// Notes that a row of this robot is written. Refusals since the row was made stay due.
    pub(crate) fn written(&mut self, row: &RefusalRow) {
        let of_row =
            self.0.iter_mut().filter(|((topic, reason), _)| topic.as_str() == row.topic && *reason == row.reason);
        for (_, count) in of_row {
            count.unwritten = (count.unwritten - row.refused).max(0);
        }
    }

    /// All counts since this supervisor knows the robot, by topic and reason.
    pub(crate) fn totals(&self) -> impl Iterator<Item = (&'static str, &'static str, u64)> {
        self.0.iter().map(|(&(topic, reason), count)| (topic.as_str(), reason, count.total))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn refusals_are_written_once_and_have_bounded_words() {
        let mut refusals = Refusals::default();
        let contacts = (RobotTopic::Contacts, "malformed");
        refusals.count(contacts, &"a\u{0}\u{1b}b".repeat(1000), Micros(1));
        refusals.count(contacts, &"another", Micros(2));
        refusals.count((RobotTopic::Status, "malformed"), &"x", Micros(3));
        let rows: Vec<RefusalRow> = refusals.rows(7).collect();
        let fields = |row: &RefusalRow| (row.robot_id, row.topic, row.refused, row.refused_us, row.problem.len());
        assert_eq!(rows.iter().map(fields).collect::<Vec<_>>(), [(7, "contacts", 2, 2, 400), (7, "status", 1, 3, 1)]);
        refusals.count(contacts, &"between", Micros(4));
        rows.iter().for_each(|row| refusals.written(row));
        assert_eq!(refusals.rows(7).map(|row| row.refused).collect::<Vec<_>>(), [1], "what came meanwhile is due");
        refusals.rows(7).collect::<Vec<_>>().iter().for_each(|row| refusals.written(row));
        assert!(!refusals.are_due());
        refusals.count(contacts, &"later", Micros(4));
        assert_eq!(refusals.rows(7).map(|row| (row.refused, row.problem)).collect::<Vec<_>>(), [(1, "later".into())]);
        assert_eq!(refusals.totals().collect::<Vec<_>>(), [("contacts", "malformed", 4), ("status", "malformed", 1)]);
    }
}
