//! Why an agent in a thread of another program has ended.

use std::panic::{AssertUnwindSafe, catch_unwind};

/// Runs an agent, and tells why it has ended: by itself, with an error, or by a panic.
pub fn reason(run: impl FnOnce() -> Result<(), String>) -> String {
    // Nothing of what it has changed is used again.
    match catch_unwind(AssertUnwindSafe(run)) {
        Ok(Ok(())) => "the agent was stopped".to_owned(),
        Ok(Err(problem)) => problem,
        Err(_) => "the agent has panicked".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A panic was told to nobody: the program waited for an agent that was gone.
    #[test]
    fn regress_a_panic_of_the_agent_is_a_reason() {
        assert_eq!(reason(|| panic!("a mistake")), "the agent has panicked");
        assert_eq!(reason(|| Err("no outbox".to_owned())), "no outbox");
        assert_eq!(reason(|| Ok(())), "the agent was stopped");
    }
}
