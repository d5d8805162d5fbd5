//! Values of options: numbers below zero, closed words, log filters.

use crate::program::{err, out, vibrissa};

fn refused(arguments: &[&str], code: i32) -> String {
    let folder = tempfile::tempdir().unwrap();
    let ended = vibrissa(arguments, folder.path());
    assert_eq!(ended.status.code(), Some(code), "{arguments:?}: {}", err(&ended));
    err(&ended)
}

#[test]
fn a_number_below_zero_is_answered_with_the_range() {
    let solve = ["solve", "--target-mm", "70", "--length-mm", "65"];
    for (arguments, code, range) in [
        ([&solve[..], &["--pressure-mpa", "-0.01"]].concat(), 2, "must be from 0 to 0.2 MPa"),
        ([&solve[..], &["--before-mpa", "-1"]].concat(), 2, "must be from 0 to 0.2 MPa"),
        (vec!["setpoint", "f/r/left/0", "--pressure-mpa", "-0.01"], 2, "must be from 0 to 0.2 MPa"),
        (vec!["calibrate", "x.csv", "--gauge-factor", "-2.21"], 2, "must be above 0"),
        (vec!["calibrate", "x.csv", "--youngs-modulus-mpa", "-1"], 2, "must be above 0"),
        (vec!["evaluate", "health", "--cases", "-5"], 2, "-5 is not in 1..=100000"),
        (vec!["demo", "--mqtt-port", "-1"], 2, "-1 is not in 0..=65535"),
        (vec!["config", "--policy-predicted-error-max", "-0.01"], 1, "must be from "),
        (vec!["config", "--mqtt-port", "-1"], 1, "must be a whole number from 0 to 65535, not -1"),
    ] {
        let told = refused(&arguments, code);
        assert!(told.contains(range) && !told.contains("unexpected argument"), "{arguments:?}: {told}");
    }
}

#[test]
fn closed_words_are_taken_in_any_case_and_a_wrong_one_lists_the_allowed_ones() {
    let folder = tempfile::tempdir().unwrap();
    let solve =
        ["solve", "--target-mm", "70", "--length-mm", "65", "--formulation", "Consistent", "--objective", "MEAN"];
    out(&vibrissa(&solve, folder.path()));
    let settings = ["--policy-mode", "ADVISE", "--policy-longer-for-shorter", "Last-Resort", "--contacts-keep", "None"];
    out(&vibrissa(&[&["config"], &settings[..]].concat(), folder.path()));
    let reality = ["evaluate", "reality", "--contacts", "1", "--cuts", "1", "--place", "ratio", "--rows", "Ideal"];
    assert!(out(&vibrissa(&reality, folder.path())).contains("place of a contact: RATIO"));
    let token = ["token", "create", "--role", "viewer", "--all-fleets", "--database-url", "sqlite:v.sqlite3"];
    out(&vibrissa(&token, folder.path()));
    for (arguments, code, words) in [
        (vec!["whiskers", "--condition", "cut"], 2, "LEARNING, HEALTHY, SUSPECTED, TRIMMED"),
        (vec!["evaluate", "reality", "--place", "base"], 2, "RATIO, TIP, DISTANCE, DISTANCE_TESTS, UNKNOWN"),
        (vec!["evaluate", "reality", "--rows", "rain"], 2, "the rows are ideal, "),
        (vec!["token", "create", "--role", "boss", "--all-fleets"], 2, "VIEWER, OPERATOR, ENGINEER, ADMIN"),
        (vec!["config", "--policy-mode", "manual"], 1, "must be automatic or advise, not \"manual\""),
    ] {
        let told = refused(&arguments, code);
        assert!(told.contains(words), "{arguments:?}: {told}");
    }
    // A condition in lower case passes the parser: the error is that of the connection.
    let told = refused(&["whiskers", "--condition", "trimmed", "--url", "http://127.0.0.1:1"], 1);
    assert!(told.contains("http://127.0.0.1:1/v1/whiskers") && told.contains("condition=TRIMMED"), "{told}");
}

#[test]
fn an_invalid_log_filter_is_refused_by_every_command_that_logs() {
    let broker = ["--broker", "mqtt://127.0.0.1:1", "--fleet", "f"];
    for command in [vec!["config"], vec!["run"], vec!["record"], vec!["check-robot", "--robot", "r"]] {
        let more: &[&str] = if command.len() == 1 && command[0] != "record" { &[] } else { &broker };
        let told = refused(&[&command[..], more, &["--log", "blah=5"]].concat(), 1);
        assert!(told.contains("log (flag --log): is not a log filter: \"5\" in \"blah=5\" is not a level"), "{told}");
        assert!(told.contains("the levels are off, error, warn, info, debug, trace"), "{told}");
    }
}
