//! docs/driver-interface.md: its transcript, its driver in Python, and its driver in C.

use std::fs;
use std::path::Path;
use std::process::Command;

use serde_json::Value;
use vibrissa_protocol::{BootId, RobotTopic};
use vibrissa_robot::contract::Now;
use vibrissa_robot::store::Stored;
use vibrissa_robot::{Agent, Config, Input, Output};
use vibrissa_tests::wait::until_true;

use crate::stage::Stage;

const DOCUMENT: &str = include_str!("../../../docs/driver-interface.md");

/// The first block of code in a language.
fn block(language: &str) -> &'static str {
    let begin = format!("```{language}\n");
    DOCUMENT.split_once(&begin).unwrap().1.split_once("```").unwrap().0
}

const NOW_US: u64 = 1_795_248_000_000_000;

/// What the supervisor sends at a line of the transcript that begins with `#`.
fn message(comment: &str) -> Option<(RobotTopic, String)> {
    let expires_us = NOW_US + 30_000_000;
    let head = r#""boot_id":"s","seq":0"#;
    let order = |version: u64| {
        format!(
            r#""epoch":1,"version":{version},"robot_boot_id":"b","array":"left","whisker":0,"expires_us":{expires_us},
                   "issued":"2026-11-21T08:00:00.000Z""#
        )
    };
    match comment {
        "The supervisor sends a setpoint of 0.12 MPa." => Some((
            RobotTopic::Setpoint,
            format!(
                r#"{{{head},{},"command_id":"c","pressure_mpa":0.12,"slew_mpa_per_s":0.02,"reason":"OPERATOR","gain":[]}}"#,
                order(1)
            ),
        )),
        "The supervisor requests a touch test." => Some((
            RobotTopic::Request,
            format!(
                r#"{{{head},"request":"TOUCH_TEST","touch_test":{{{},"test_id":"t1","kind":"WALL","distances_mm":[56.0,63.0],
                "deflections_mm":[1.5],"contacts":2,"reason":"OPERATOR"}}}}"#,
                order(2)
            ),
        )),
        "The supervisor has found a cut." => Some((
            RobotTopic::Estimate,
            format!(
                r#"{{{head},"epoch":1,"version":1,"timestamp":"2026-11-21T08:00:00.000Z","whiskers":[{{"array":"left",
                "whisker":0,"length_mm":60.2,"length_low_mm":59.9,"length_high_mm":60.5,"condition":"TRIMMED",
                "pressure_mpa":0.12,"gain":[[0.45,0.861],[1.0,1.0]],
                "response":[[20.0,0.01,0.0004],[60.2,0.005,0.0002]]}}]}}"#
            ),
        )),
        "The driver starts."
        | "The chamber reaches its pressure. After half a second the setpoint counts as applied."
        | "A line is wrong."
        | "The driver asks where a touch was." => None,
        other => panic!("the test does not know what happens at: {other}"),
    }
}

#[test]
fn the_transcript_is_what_the_agent_says() {
    let configuration = r#"
        fleet = "f"
        robot = "r"
        touch_tests = ["WALL"]
        broker.url = "mqtt://h"
        driver.command = ["d"]
        # Repeated lines would hide the others.
        driver.repeat_s = 60.0
        [[arrays]]
        array = "left"
        type = "TYPE_2"
        whiskers = [{ whisker = 0, length_mm = 70.0, pressure_mpa = 0.1, pressure_max_mpa = 0.2 }]
        "#;
    let config = Config::from_toml_str(configuration, Path::new("")).unwrap();
    let (mut agent, _) = Agent::new(&config, BootId::new("b").unwrap(), Stored::default(), Now::of_us(NOW_US));
    let mut now_us = NOW_US;
    let mut played = Vec::new();
    let mut step = |input: Input<'_>, played: &mut Vec<String>| {
        now_us += 300_000;
        for output in agent.step(Now::of_us(now_us), input) {
            if let Output::Tell(_, line) = output {
                played.push(format!("> {}", String::from_utf8(line.line()).unwrap().trim_end()));
            }
        }
    };
    step(Input::Connected, &mut played);
    for line in block("text").lines() {
        if let Some(comment) = line.strip_prefix("# ") {
            played.push(line.to_owned());
            if comment == "The driver starts." {
                step(Input::DriverStarted(0), &mut played);
            }
            if let Some((topic, payload)) = message(comment) {
                step(Input::Message(topic, payload.as_bytes()), &mut played);
            }
        } else if let Some(said) = line.strip_prefix("< ") {
            played.push(line.to_owned());
            step(Input::Line(0, Some(said.as_bytes())), &mut played);
        }
    }
    assert_eq!(played.join("\n"), block("text").trim_end());
    assert_eq!((agent.counts().lines_refused, agent.counts().contacts), (1, 3));
}

#[tokio::test]
async fn the_driver_in_python_works_with_a_supervisor() {
    let stage = Stage::start(|folder| {
        let path = folder.join("driver.py");
        fs::write(&path, block("python")).unwrap();
        format!("command = [\"python3\", {path:?}]")
    })
    .await;
    until_true("contacts of both whiskers", async || {
        stage.number("SELECT count(DISTINCT whisker_id) FROM contacts").await == 2
    })
    .await;
    stage.set_by_hand(1, 0.12).await;
    until_true("an applied setpoint", async || {
        stage.number("SELECT count(*) FROM setpoints WHERE state = 'APPLIED'").await == 1
    })
    .await;
    let whisker: Value = stage.whisker(1).await.unwrap();
    assert!(whisker.to_string().contains("0.12"), "{whisker}");
    // Its contacts are such that the supervisor uses them.
    until_true("a whisker that is known", async || {
        stage.whisker(0).await.is_some_and(|whisker| whisker["condition"] == "HEALTHY")
    })
    .await;
}

#[test]
fn the_driver_in_c_understands_what_the_agent_writes() {
    let folder = tempfile::tempdir().unwrap();
    let source = folder.path().join("driver.c");
    let main = r#"
        static int lines_left = 2;
        double read_mpa(int whisker) { return 0.1 + whisker / 100.0; }
        void set_mpa(int whisker, double mpa, double slew) { printf("set %d %.3f %.3f\n", whisker, mpa, slew); }
        int read_line(char *line, int size) { return lines_left-- > 0 && fgets(line, size, stdin) != NULL; }
        int main(void) { loop(); return 0; }
        "#;
    fs::write(&source, format!("{}{main}", block("c"))).unwrap();
    let program = folder.path().join("driver");
    let Ok(compiled) = Command::new("cc").args(["-Wall", "-Werror", "-o"]).arg(&program).arg(&source).output() else {
        println!("skipped: no C compiler");
        return;
    };
    assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
    let lines: Vec<&str> = block("text").lines().filter_map(|line| line.strip_prefix("> ")).take(2).collect();
    let input = folder.path().join("input");
    fs::write(&input, format!("{}\n", lines.join("\n"))).unwrap();
    let output = Command::new(program).stdin(fs::File::open(input).unwrap()).output().unwrap();
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        "set 0 0.100 0.020\n{\"type\":\"pressure\",\"whisker\":0,\"pressure_mpa\":0.100000}\n\
         {\"type\":\"pressure\",\"whisker\":1,\"pressure_mpa\":0.110000}\n\
         {\"type\":\"pressure\",\"whisker\":2,\"pressure_mpa\":0.120000}\n"
    );
}
