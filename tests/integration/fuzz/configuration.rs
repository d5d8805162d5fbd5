//! Arbitrary configuration files and environment variables.

use proptest::prelude::*;
use vibrissa::config::{Key, Sources, read, show};

use crate::mutation::{TOKENS, anything, bent_lines, mutations};
use crate::{Input, cases, in_time};

const GOOD: &str = "name = \"one\"\nfleets = [\"a\", \"b\"]\nlog = \"info,vibrissa=debug\"\n\
    database.url = \"postgres://u@h:5432/d?sslmode=require\"\nlease.time_to_live_s = 2.5\n\
    mqtt.url = \"mqtts://h:8883\"\nmqtt.username = \"u\"\nmqtt.password = \"p\"\nhttp.listen = \"[::1]:80\"\n\
    model.formulation = \"published\"\npolicy.objective = \"mean\"\npolicy.longer_for_shorter = \"never\"\n\
    policy.predicted_error_max = 0.5\ndetection.contacts_between_false_alarms = 1e6\n\
    detection.cold_start_contacts = 150\n";
const PLAIN: &str =
    "fleets = [\"a\"]\n[mqtt]\nport = 1884\n[database]\nurl = \"sqlite:a b\"\n[lease]\ntime_to_live_s = 3";

fn files() -> impl Strategy<Value = Input> {
    let good = prop::sample::select(&[GOOD, PLAIN][..]);
    let bent = (good, mutations()).prop_map(|(good, bends)| bent_lines(good, &bends));
    prop_oneof![4 => bent, 1 => anything()].prop_map(Input)
}

fn variables() -> impl Strategy<Value = Vec<(String, String)>> {
    let token = (0..TOKENS.len()).prop_map(|token| TOKENS[token].trim_matches('"').to_owned());
    let text = prop_oneof![3 => token, 2 => "\\PC{0,40}", 1 => "[a-z]{1,5}://[a-z:@%\\[\\]./?#=-]{0,30}",
        1 => (1..100_000_usize).prop_map(|length| "x,".repeat(length))];
    let name = prop_oneof![
        8 => prop::sample::select(Key::ALL).prop_map(|key| key.environment().to_owned()),
        1 => "VIBRISSA_[A-Z_]{0,30}",
    ];
    prop::collection::vec((name, text), 0..4)
}

/// An accepted configuration is printed as a file with the same meaning. A refusal consists of short lines, one per
/// problem.
fn holds(sources: &Sources) -> Result<(), TestCaseError> {
    match in_time(|| read(sources)).config {
        Ok(config) => {
            let shown = in_time(|| show::effective(sources, None));
            if shown.contains("***") {
                return Ok(());
            }
            let again = Sources { file: Some(("again.toml".into(), shown.clone())), ..Sources::default() };
            let again = read(&again).config.map_err(|problems| TestCaseError::fail(format!("{problems}\n{shown}")))?;
            prop_assert_eq!(format!("{again:?}"), format!("{config:?}"));
        }
        Err(problems) => {
            prop_assert!(!problems.0.is_empty());
            for problem in &problems.0 {
                let line = problem.to_string();
                prop_assert!(line.lines().count() == 1 && line.len() < 5000, "{} bytes: {line:.500}", line.len());
            }
        }
    }
    Ok(())
}

#[test]
fn what_is_bent_is_good_before() {
    for good in [GOOD, PLAIN] {
        let sources = Sources { file: Some(("v.toml".into(), good.to_owned())), ..Sources::default() };
        assert!(read(&sources).config.is_ok(), "{good}");
    }
}

proptest! {
    #![proptest_config(cases(4000))]

    #[test]
    fn a_file_is_taken_or_every_problem_is_told(input in files()) {
        let text = String::from_utf8_lossy(&input.0).into_owned();
        holds(&Sources { file: Some(("v.toml".into(), text)), ..Sources::default() })?;
    }

    #[test]
    fn variables_are_taken_or_every_problem_is_told(environment in variables()) {
        holds(&Sources { environment, ..Sources::default() })?;
    }
}
