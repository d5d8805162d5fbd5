//! The history of a run: what was struck, published and committed, in its order. With one seed it is the same byte for byte.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::time::Duration;

/// One step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// Time since the start.
    pub at: Duration,
    /// Who acts.
    pub from: String,
    /// On whom.
    pub to: String,
    /// What.
    pub what: String,
}

/// A history, as a hash of its steps and the newest of them.
#[derive(Debug)]
pub struct History {
    /// Most steps that are kept.
    most: usize,
    hash: u64,
    count: u64,
    steps: VecDeque<Step>,
}

impl History {
    /// An empty history that keeps the newest steps, and of all others the hash.
    #[must_use]
    pub const fn keeping(most: usize) -> Self {
        Self { most, hash: 0, count: 0, steps: VecDeque::new() }
    }

    /// Adds a step.
    pub fn add(&mut self, step: Step) {
        let Step { at, from, to, what } = &step;
        let (nanos, hash) = (at.as_nanos().to_le_bytes(), self.hash ^ 0xcbf2_9ce4_8422_2325);
        // FNV-1a.
        let bytes = nanos.into_iter().chain([from, to, what].into_iter().flat_map(|text| text.bytes()));
        self.hash = bytes.fold(hash, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3));
        self.count += 1;
        if self.steps.len() >= self.most {
            self.steps.pop_front();
        }
        self.steps.push_back(step);
    }

    /// Hash of all steps.
    #[must_use]
    pub const fn hash(&self) -> u64 {
        self.hash
    }

    /// Number of all steps.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The newest steps.
    pub fn steps(&self) -> impl Iterator<Item = &Step> {
        self.steps.iter()
    }
}

/// Width of a column, in characters.
const WIDTH: usize = 18;
/// Most characters of a label.
const LABEL: usize = 120;

/// A sequence diagram of steps in text: a column for each participant, and an arrow for each step.
#[must_use]
pub fn diagram(steps: &[Step]) -> String {
    let mut names: Vec<&str> = Vec::new();
    for name in steps.iter().flat_map(|step| [step.from.as_str(), step.to.as_str()]) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let mut text = format!("{:>11}", "time, s");
    for name in &names {
        let _ = write!(text, " {name:^WIDTH$}");
    }
    text.push('\n');
    for step in steps {
        let column = |of: &str| names.iter().position(|name| *name == of).unwrap_or_default();
        let (from, to) = (column(&step.from), column(&step.to));
        let middle = |column: usize| 12 + column * (WIDTH + 1) + WIDTH / 2;
        let mut line: Vec<char> = vec![' '; 12 + names.len() * (WIDTH + 1)];
        for column in 0..names.len() {
            line[middle(column)] = '|';
        }
        let (left, right) = (middle(from.min(to)), middle(from.max(to)));
        line[left..=right].fill('-');
        line[middle(from)] = '+';
        line[middle(to)] = match from.cmp(&to) {
            std::cmp::Ordering::Less => '>',
            std::cmp::Ordering::Greater => '<',
            std::cmp::Ordering::Equal => '*',
        };
        let line: String = line.into_iter().skip(12).collect();
        let what: String = step.what.chars().take(LABEL).collect();
        let _ = writeln!(text, "{:11.6} {line} {what}", step.at.as_secs_f64());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step(from: &str, to: &str, what: &str) -> Step {
        Step { at: Duration::from_millis(1_500), from: from.to_owned(), to: to.to_owned(), what: what.to_owned() }
    }

    #[test]
    fn a_hash_depends_on_each_step_and_their_order() {
        let hash = |steps: &[Step]| {
            let mut history = History::keeping(1);
            steps.iter().cloned().for_each(|step| history.add(step));
            history.hash()
        };
        let (one, two) = (step("a", "b", "x"), step("b", "a", "y"));
        let all = [hash(&[one.clone(), two.clone()]), hash(&[two.clone(), one.clone()]), hash(&[one]), hash(&[two])];
        assert!((0..4).all(|at| (at + 1..4).all(|other| all[at] != all[other])));
    }

    #[test]
    fn a_diagram_has_a_column_for_each_participant_and_arrows_in_both_directions() {
        let text = diagram(&[step("a", "b", "asks"), step("b", "a", "answers"), step("b", "b", "waits")]);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 4);
        let is = |line: usize, arrow: &str, label: &str| lines[line].contains(arrow) && lines[line].ends_with(label);
        assert!(is(1, "+------------------>", " asks"), "{text}");
        assert!(is(2, "<------------------+", " answers"), "{text}");
        assert!(is(3, "|                  *", " waits"), "{text}");
    }
}
