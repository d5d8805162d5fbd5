//! The history of a run: what was struck, published and committed, in its order. With one seed it is the same byte for byte.

use std::collections::VecDeque;
use std::fmt::Write as _;
use std::time::Duration;

/// Most lines that are kept.
const LINES: usize = 400;

/// A history, as a hash of its lines and the newest of them.
#[derive(Debug, Default)]
pub struct History {
    hash: u64,
    count: u64,
    lines: VecDeque<String>,
}

impl History {
    /// Adds a line: when, who, to whom, and what.
    pub fn add(&mut self, at: Duration, from: &str, to: &str, what: &str) {
        let mut line = String::new();
        let _ = write!(line, "{:11.6} {from:>14} -> {to:<14} {what}", at.as_secs_f64());
        // FNV-1a.
        self.hash = line.bytes().fold(self.hash ^ 0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        });
        self.count += 1;
        if self.lines.len() == LINES {
            self.lines.pop_front();
        }
        self.lines.push_back(line);
    }

    /// Hash of all lines.
    #[must_use]
    pub const fn hash(&self) -> u64 {
        self.hash
    }

    /// Number of all lines.
    #[must_use]
    pub const fn count(&self) -> u64 {
        self.count
    }

    /// The newest lines.
    pub fn lines(&self) -> impl Iterator<Item = &str> {
        self.lines.iter().map(String::as_str)
    }
}
