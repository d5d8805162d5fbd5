//! The rules as a document for robot engineers.

use std::fmt::Write;

use super::{Rule, Scope, Visible};

const HEAD: &str = "\
# Rules of the contract for robots

Rules of the MQTT contract for robots, each with the name that `vibrissa-lab check-robot` reports. This table is generated
from `services/protocol/src/rules.rs`; `VIBRISSA_WRITE_DOCS=1 cargo test --workspace --lib rules` writes it again.

Most rules apply to *every robot*. Those *with receipts* apply to robots that store contacts until a receipt covers them;
such robots send contacts with quality of service 0. Rules marked *restart* are only tested while somebody switches the
robot off and on again (`--restart`). Rules marked *assisted* are only tested if somebody, or a script, helps at the robot
(`--assisted`, `--assistant`; see [commands.md](commands.md#check-a-robot)). The rule marked *relay* is only tested if the
robot's packets pass the check: on the check's own broker, or with `--relay`.

The contract defines no times for the following, so the check is patient: 5 s for an answer to a request and for the
first answer to a setpoint, 30 s for the final state of a setpoint, 60 s until a contacts message is sent again, and 1 s
in which a message may still arrive although a receipt covers it. It waits 7 s for the answer to a request for births. A
pressure counts as reached within 0.005 MPa of its setpoint, and may be as far ahead of its ramp.

No message shows the `reading_gain` that a robot uses, so no rule of this table tests it. Test at the robot that the factor
changes with the report APPLIED (see `setpoint` in [asyncapi.yaml](asyncapi.yaml)).

| rule | topic | applies to | tested | requirement |
| --- | --- | --- | --- | --- |
";

/// The document `docs/contract-rules.md`.
#[must_use]
pub fn markdown() -> String {
    let mut text = HEAD.to_owned();
    for &rule in Rule::ALL {
        let scope = match rule.scope() {
            Scope::Every => "every robot",
            Scope::Receipts => "with receipts",
        };
        let tested = match rule.visible() {
            Visible::Talking => "yes",
            Visible::Restarting => "restart",
            Visible::Assisted => "assisted",
            Visible::Relayed => "relay",
        };
        // Writing to a `String` cannot fail.
        let _ = writeln!(text, "| `{rule}` | `{}` | {scope} | {tested} | {} |", rule.topic(), rule.asked());
    }
    text
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
        assert!(written == markdown(), "docs/contract-rules.md is out of date: VIBRISSA_WRITE_DOCS=1 writes it again");
    }
}
