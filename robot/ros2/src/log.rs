//! Problems for the log, but no flood of them.

/// Problems that are logged at once.
const BURST: f64 = 20.0;
/// Problems a second that are logged in the long run.
const PER_S: f64 = 1.0;

/// Says which problems are logged.
#[derive(Debug)]
pub struct Limited {
    allowed: f64,
    at_s: f64,
    left_out: u64,
}

impl Default for Limited {
    fn default() -> Self {
        Self { allowed: BURST, at_s: 0.0, left_out: 0 }
    }
}

impl Limited {
    /// The line to log; `None` if there were too many.
    pub fn line(&mut self, now_s: f64, problem: &str) -> Option<String> {
        self.allowed = (self.allowed + PER_S * (now_s - self.at_s).max(0.0)).min(BURST);
        self.at_s = now_s;
        if self.allowed < 1.0 {
            self.left_out += 1;
            return None;
        }
        self.allowed -= 1.0;
        let left_out = std::mem::take(&mut self.left_out);
        Some(if left_out == 0 { problem.to_owned() } else { format!("{problem} ({left_out} problems left out)") })
    }
}
