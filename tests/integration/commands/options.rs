//! Values of options: numbers below zero, closed words, log filters; the help of commands; exit codes.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::process::{Command, Stdio};

use crate::program::{PROGRAM, err, out, vibrissa};

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
        ([&solve[..], &["--pressure-mpa", "-1e-3"]].concat(), 2, "must be from 0 to 0.2 MPa"),
        (vec!["calibrate", "x.csv", "--gauge-factor", "-2.21"], 2, "must be above 0"),
        (vec!["calibrate", "x.csv", "--youngs-modulus-mpa", "-1"], 2, "must be above 0"),
        (vec!["evaluate", "health", "--cases", "-5"], 2, "-5 is not in 1..=100000"),
        (vec!["demo", "--mqtt-port", "-1"], 2, "-1 is not in 0..=65535"),
        (vec!["config", "--policy-predicted-error-max", "-0.01"], 1, "must be from "),
        (vec!["config", "--mqtt-port", "-1"], 1, "must be a whole number from 0 to 65535, not -1"),
    ] {
        let message = refused(&arguments, code);
        assert!(message.contains(range) && !message.contains("unexpected argument"), "{arguments:?}: {message}");
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
        (
            vec!["evaluate", "reality", "--place", "base"],
            2,
            "RATIO, RATIO_TESTS, TIP, DISTANCE, DISTANCE_TESTS, UNKNOWN",
        ),
        (vec!["evaluate", "reality", "--rows", "rain"], 2, "the rows are ideal, "),
        (vec!["token", "create", "--role", "boss", "--all-fleets"], 2, "VIEWER, OPERATOR, ENGINEER, ADMIN"),
        (vec!["config", "--policy-mode", "manual"], 1, "must be automatic or advise, not \"manual\""),
    ] {
        let message = refused(&arguments, code);
        assert!(message.contains(words), "{arguments:?}: {message}");
    }
    // A condition in lower case passes the parser: the error is that of the connection.
    let message = refused(&["whiskers", "--condition", "trimmed", "--url", "http://127.0.0.1:1"], 1);
    assert!(message.contains("http://127.0.0.1:1/v1/whiskers") && message.contains("condition=TRIMMED"), "{message}");
}

#[test]
fn fleets_are_names_and_patterns() {
    let folder = tempfile::tempdir().unwrap();
    let database = ["--database-url", "sqlite:v.sqlite3"];
    let create = ["token", "create", "--role", "viewer", "--fleet", "lab", "--fleet", "hall-*"];
    out(&vibrissa(&[&create[..], &database].concat(), folder.path()));
    let all = ["token", "create", "--role", "viewer", "--fleet", "lab", "--fleet", "*", "--name", "all"];
    out(&vibrissa(&[&all[..], &database].concat(), folder.path()));
    let list = out(&vibrissa(&[&["token", "list", "--json"][..], &database].concat(), folder.path()));
    let list: serde_json::Value = serde_json::from_str(&list).unwrap();
    for token in list.as_array().unwrap() {
        let is_all = token["name"] == "all";
        let fleets = if is_all { serde_json::Value::Null } else { serde_json::json!(["hall-*", "lab"]) };
        assert_eq!(token["fleets"], fleets);
    }
    for arguments in [
        vec!["token", "create", "--role", "viewer", "--fleet", "hall-?"],
        vec!["bulk", "hold-robots", "--fleet", "hall-*,"],
        vec!["whiskers", "--fleet", "a b"],
        vec!["export", "contacts", "--csv", "c.csv", "--fleet", "hall.*"],
    ] {
        let message = refused(&arguments, 2);
        assert!(message.contains("neither the name of a fleet nor a pattern"), "{arguments:?}: {message}");
    }
    let message = refused(&["whiskers", "--fleet", "hall-*,lab", "--url", "http://127.0.0.1:1"], 1);
    assert!(message.contains("http://127.0.0.1:1/v1/whiskers") && message.contains("fleet=hall-*%2Clab"), "{message}");
}

#[test]
fn an_invalid_log_filter_is_refused_by_every_command_that_logs() {
    let broker = ["--broker", "mqtt://127.0.0.1:1", "--fleet", "f"];
    for command in [vec!["config"], vec!["run"], vec!["record"], vec!["check-robot", "--robot", "r"]] {
        let more: &[&str] = if command.len() == 1 && command[0] != "record" { &[] } else { &broker };
        let message = refused(&[&command[..], more, &["--log", "blah=5"]].concat(), 1);
        assert!(
            message.contains("log (flag --log): is not a log filter: \"5\" in \"blah=5\" is not a level"),
            "{message}"
        );
        assert!(message.contains("the levels are off, error, warn, info, debug, trace"), "{message}");
    }
}

#[test]
fn the_help_of_a_command_shows_the_options_that_it_uses() {
    let folder = tempfile::tempdir().unwrap();
    let help = |command: &str| out(&vibrissa(&[command, "--help"], folder.path()));
    let client = ["--fleets", "--log", "--mqtt-url", "--mqtt-username", "--mqtt-ca-file", "--mqtt-client-key-file"];
    for (command, used, unused) in [
        ("record", &client[..], &["--http-listen", "--database-url", "--policy-mode", "--mqtt-port"][..]),
        ("check-robot", &client[..], &["--http-listen", "--database-url", "--policy-mode", "--contacts-keep"]),
        (
            "replay",
            &["--fleets", "--calibrations", "--policy-mode", "--detection-cold-start-contacts", "--model-formulation"],
            &["--http-listen", "--database-url", "--mqtt-url", "--mqtt-ca-file", "--log"],
        ),
        ("run", &["--http-listen", "--database-url", "--policy-mode", "--mqtt-port"], &[]),
    ] {
        let text = help(command);
        let names: Vec<&str> = text.split_whitespace().map(|word| word.trim_end_matches(',')).collect();
        for option in used {
            assert!(names.contains(option), "{command} lacks {option}:\n{text}");
        }
        for option in unused {
            assert!(!names.contains(option), "{command} shows {option}:\n{text}");
        }
    }
    let text = help("record");
    let headings: Vec<&str> = text.lines().filter(|line| line.ends_with(':') && !line.starts_with(' ')).collect();
    assert_eq!(headings, ["Options:", "General settings:", "MQTT broker:"]);
    assert!(help("run").contains("\nPolicy of compensations:\n"));
}

#[test]
fn a_configuration_file_for_the_supervisor_serves_the_other_commands_too() {
    let folder = tempfile::tempdir().unwrap();
    let text = "fleets = [\"lab\"]\n[http]\nlisten = \"127.0.0.1:0\"\n[policy]\nmode = \"advise\"\n\
                [database]\nurl = \"sqlite:lab.sqlite3\"\n[mqtt]\nurl = \"mqtt://127.0.0.1:1\"\n";
    std::fs::write(folder.path().join("v.toml"), text).unwrap();
    std::fs::write(folder.path().join("empty.jsonl"), "").unwrap();
    out(&vibrissa(&["replay", "empty.jsonl", "--config", "v.toml"], folder.path()));
    let ended = vibrissa(&["record", "--config", "v.toml", "--for", "100ms"], folder.path());
    assert!(err(&ended).contains("fleet lab: tried ") && err(&ended).contains("127.0.0.1:1"), "{}", err(&ended));
}

/// A command that logs a warning.
const LOGGING: [&str; 7] = ["record", "--broker", "mqtt://127.0.0.1:1", "--fleet", "f", "--for", "500ms"];
/// The start of each colour code.
const ESCAPE: char = '\u{1b}';

#[test]
fn a_log_in_a_file_has_no_colours() {
    let folder = tempfile::tempdir().unwrap();
    let log = err(&vibrissa(&LOGGING, folder.path()));
    assert!(log.contains("WARN") && log.contains("127.0.0.1:1"), "the command must log something: {log}");
    assert!(!log.contains(ESCAPE), "{log:?}");
}

#[test]
fn a_log_on_a_terminal_has_colours_unless_they_are_not_wanted() {
    let logged = |no_color: &str| {
        // The command `script` gives the program a terminal.
        let mut command = Command::new("script");
        command.args(["-qec", &format!("{PROGRAM} {}", LOGGING.join(" ")), "/dev/null"]);
        command.env("NO_COLOR", no_color).env_remove("RUST_LOG").stdin(Stdio::null());
        String::from_utf8(command.output().unwrap().stdout).unwrap()
    };
    let (with, without) = (logged(""), logged("1"));
    assert!(with.contains("WARN") && with.contains(ESCAPE), "{with:?}");
    assert!(without.contains("WARN") && !without.contains(ESCAPE), "{without:?}");
}

/// Bash itself completes with the script.
#[test]
fn a_shell_completes_commands_and_words() {
    let folder = tempfile::tempdir().unwrap();
    let script = folder.path().join("completions.bash");
    std::fs::write(&script, out(&vibrissa(&["completions", "bash"], folder.path()))).unwrap();
    let completed = |words: &[&str]| {
        let (last, before) = (words.len() - 1, words[words.len() - 2]);
        let ask = format!(
            "source '{}'; COMP_WORDS=({}); COMP_CWORD={last}; _vibrissa-lab vibrissa-lab '{}' '{before}'; echo \"${{COMPREPLY[@]}}\"",
            script.display(),
            words.iter().map(|word| format!("'{word}' ")).collect::<String>(),
            words[last],
        );
        out(&Command::new("bash").args(["-c", &ask]).output().unwrap())
    };
    assert_eq!(completed(&["vibrissa-lab", "ca"]).trim(), "calibrate");
    assert!(completed(&["vibrissa-lab", "whiskers", "--condition", ""]).contains("TRIMMED"));
    assert!(completed(&["vibrissa-lab", "solve", "--before"]).contains("--before-mpa"));
}

/// A list of no whiskers, for each request, until the program ends.
#[test]
fn a_watched_list_is_printed_again() {
    let server = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", server.local_addr().unwrap());
    std::thread::spawn(move || {
        let body = r#"{"items":[],"next_cursor":null}"#;
        let answer = format!(
            "HTTP/1.1 200 OK\r\nContent-Type: application/json\r\nContent-Length: {}\r\nConnection: close\r\n\r\n{body}",
            body.len()
        );
        for mut client in server.incoming().map_while(Result::ok) {
            let mut lines = BufReader::new(client.try_clone().unwrap()).lines().map_while(Result::ok);
            let _ = lines.find(String::is_empty);
            let _ = client.write_all(answer.as_bytes());
        }
    });
    let mut watching = Command::new(PROGRAM)
        .args(["whiskers", "--watch", "1", "--url", &url])
        .env_remove("VIBRISSA_TOKEN")
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let lines = BufReader::new(watching.stdout.take().unwrap()).lines().map_while(Result::ok);
    let heads = lines.filter(|line| line.starts_with("WHISKER ")).take(3).count();
    watching.kill().unwrap();
    watching.wait().unwrap();
    assert_eq!(heads, 3);
}

/// Each made an empty database in the caller's folder, and said that all went well.
#[test]
fn regress_a_database_that_is_missing_is_named_and_not_made() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().canonicalize().unwrap();
    let named = |text: &str| text.contains(&format!("database {}", place.join("vibrissa.sqlite3").display()));
    for arguments in [vec!["token", "list"], vec!["token", "revoke", "x"], vec!["export", "contacts", "--csv", "c.csv"]]
    {
        let output = vibrissa(&arguments, &place);
        let said = err(&output);
        assert!(output.status.code() == Some(1) && named(&said) && said.contains("--database-url"), "{said}");
        assert_eq!(std::fs::read_dir(&place).unwrap().count(), 0, "{arguments:?}");
    }
    // The first token may be older than the first start of the supervisor.
    for is_new in [true, false] {
        let output = vibrissa(&["token", "create", "--role", "viewer", "--all-fleets"], &place);
        let said = err(&output);
        out(&output);
        assert!(said.contains("sqlite:vibrissa.sqlite3. It is shown only once"), "{said}");
        assert_eq!(named(&said) && said.contains("is new"), is_new, "{said}");
    }
}
