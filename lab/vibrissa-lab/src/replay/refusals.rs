//! Counts of the messages that a replay refused, by robot and reason, for the report at its end.

use std::collections::BTreeMap;

use vibrissa_protocol::Name;

/// Limit of robots with counts of their own; those of further robots are counted together.
const ROBOTS_MAX: usize = 10_000;
/// Limit of robots in the report, which states only the number of further ones.
const ROBOTS_TOLD_MAX: usize = 20;

/// Counts by reason.
type Reasons = BTreeMap<&'static str, u64>;

/// Refused messages, and refused parts of messages.
#[derive(Debug, Default)]
pub struct Refusals {
    robots: BTreeMap<(Name, Name), Reasons>,
    /// Of topics that are no robot's, and of robots beyond the limit.
    others: Reasons,
}

impl Refusals {
    /// Counts a refusal; `robot` is the fleet and the name, if there is a robot.
    pub(super) fn count(&mut self, robot: Option<(&Name, &Name)>, reason: &'static str) {
        let key = robot.map(|(fleet, name)| (fleet.clone(), name.clone()));
        let of_robot = key.filter(|key| self.robots.len() < ROBOTS_MAX || self.robots.contains_key(key));
        let reasons = match of_robot {
            Some(key) => self.robots.entry(key).or_default(),
            None => &mut self.others,
        };
        *reasons.entry(reason).or_default() += 1;
    }

    /// One line for each robot, beginning with the one of which most was refused. Empty if nothing was.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut robots: Vec<(String, &Reasons)> =
            self.robots.iter().map(|((fleet, name), reasons)| (format!("{fleet}/{name}"), reasons)).collect();
        robots.sort_by_key(|(_, reasons)| std::cmp::Reverse(sum(reasons)));
        let untold = robots.len().saturating_sub(ROBOTS_TOLD_MAX);
        let mut lines: Vec<String> =
            robots.iter().take(ROBOTS_TOLD_MAX).map(|(robot, reasons)| line(robot, reasons)).collect();
        if untold > 0 {
            lines.push(format!("refused of {untold} more robots"));
        }
        if !self.others.is_empty() {
            lines.push(line("other topics", &self.others));
        }
        lines
    }
}

fn sum(reasons: &Reasons) -> u64 {
    reasons.values().sum()
}

fn line(whose: &str, reasons: &Reasons) -> String {
    let reason_counts: Vec<String> = reasons.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
    format!("refused of {whose}: {} ({})", sum(reasons), reason_counts.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_robot_with_the_most_refusals_comes_first_and_only_some_are_told() {
        let mut refusals = Refusals::default();
        assert_eq!(refusals.lines(), Vec::<String>::new());
        let fleet = Name::new("f").unwrap();
        for number in 0..25 {
            let robot = Name::robot(&format!("r{number:02}")).unwrap();
            for _ in 0..=number {
                refusals.count(Some((&fleet, &robot)), "unknown_boot");
            }
        }
        refusals.count(None, "unknown_topic");
        let lines = refusals.lines();
        assert_eq!(lines[0], "refused of f/r24: 25 (unknown_boot 25)");
        assert_eq!(lines[20..], ["refused of 5 more robots", "refused of other topics: 1 (unknown_topic 1)"]);
    }

    #[test]
    fn invented_robots_do_not_fill_the_memory() {
        let mut refusals = Refusals::default();
        let fleet = Name::new("f").unwrap();
        for number in 0..ROBOTS_MAX + 7 {
            let robot = Name::robot(&format!("r{number}")).unwrap();
            refusals.count(Some((&fleet, &robot)), "unknown_robot");
        }
        assert_eq!((refusals.robots.len(), sum(&refusals.others)), (ROBOTS_MAX, 7));
    }
}
