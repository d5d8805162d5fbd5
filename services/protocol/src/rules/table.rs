//! The rules as a document for the people who build robots.

use std::fmt::Write;

use super::{Rule, Scope, Visible};

const HEAD: &str = "\
# What the contract asks of a robot

Each rule of the MQTT contract that a robot must keep, under the name by which `vibrissa check-robot` tells it. This table is written
from `services/protocol/src/rules.rs`; `VIBRISSA_WRITE_DOCS=1 cargo test --workspace --lib rules` writes it anew.

*Every robot* must keep most of them. Those *with receipts* are for robots that keep contacts until a receipt covers them, and show it by
sending contacts with quality of service 0. Rules marked *restart* are only tested while somebody takes the robot's power away and
gives it back (`--restart`).

The contract gives no times for what follows, so that the check is patient: 5 s for an answer to a request or the first one to a setpoint, 30 s
for a setpoint's final state, 60 s until a contacts message comes again, 1 s in which what a receipt covers may still be under way. A pressure
is near its setpoint within 0.005 MPa, and may be as far ahead of its ramp.

| rule | topic | asked of | tested | what is asked |
| --- | --- | --- | --- | --- |
";

const TAIL_HEAD: &str = "
## Not tested

From outside these cannot be seen; they hold all the same.

| rule | why it is not tested |
| --- | --- |
";

/// The document `docs/contract-rules.md`.
#[must_use]
pub fn markdown() -> String {
    let mut text = HEAD.to_owned();
    let mut untested = TAIL_HEAD.to_owned();
    for &rule in Rule::ALL {
        let scope = match rule.scope() {
            Scope::Every => "every robot",
            Scope::Receipts => "with receipts",
        };
        let tested = match rule.visible() {
            Visible::Talking => "yes",
            Visible::Restarting => "restart",
            Visible::Not(why) => {
                let _ = writeln!(untested, "| `{rule}` | {why} |");
                "no"
            }
        };
        // Writing into a text cannot fail.
        let _ = writeln!(text, "| `{rule}` | `{}` | {scope} | {tested} | {} |", rule.topic(), rule.asked());
    }
    text + &untested
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn names_are_kebab_case_and_each_stands_for_one_rule() {
        let ids: BTreeSet<&str> = Rule::ALL.iter().map(|rule| rule.id()).collect();
        assert_eq!(ids.len(), Rule::ALL.len());
        for id in ids {
            assert!(id.split('-').all(|word| !word.is_empty() && word.bytes().all(|b| b.is_ascii_lowercase())), "{id}");
            assert_eq!(Rule::from_id(id).map(Rule::id), Some(id));
        }
    }

    #[test]
    fn the_document_says_what_the_rules_say() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/contract-rules.md");
        if std::env::var_os("VIBRISSA_WRITE_DOCS").is_some() {
            std::fs::write(path, markdown()).unwrap();
        }
        let written = std::fs::read_to_string(path).unwrap();
        assert!(written == markdown(), "docs/contract-rules.md is old: VIBRISSA_WRITE_DOCS=1 writes it anew");
    }
}
