//! Contacts and pressures come from ROS, setpoints and reports go to it, and bad messages are counted.

use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixListener;

use serde_json::{Value, json};

use crate::stage::{NAMESPACE, Stage, Talking};

const ATMOSPHERE_PA: f64 = 101_325.0;
const HELLO: &str = r#"{"type":"hello","version":1,"whiskers":[{"array":"left-front","whisker":0,"pressure_mpa":0.1,"pressure_max_mpa":0.2},{"array":"left-front","whisker":1,"pressure_mpa":0.1,"pressure_max_mpa":0.2}]}"#;

fn is(line: &Value, kind: &str, whisker: u16) -> bool {
    line["type"] == kind && line["array"] == "left-front" && line["whisker"] == whisker
}

fn set_pressure(bridge: &mut Talking, pressure_mpa: f64) {
    let line = json!({"type": "set_pressure", "array": "left-front", "whisker": 0, "pressure_mpa": pressure_mpa,
        "slew_mpa_per_s": 0.05});
    bridge.say(&line.to_string());
}

/// Value of a key in the status of a component.
fn reported<'a>(line: &'a Value, component: &str, key: &str) -> Option<&'a str> {
    line["report"][component][3][key].as_str()
}

#[test]
fn contacts_pressures_setpoints_and_reports_cross_the_bridge() {
    let Some(stage) = Stage::make(0) else { return };
    let mut bridge = stage.bridge(&["--pressures", "absolute"]);
    let hello =
        json!({"type": "hello", "version": 1, "name": "vibrissa-ros2", "software_version": env!("CARGO_PKG_VERSION")});
    bridge.hear("hello", |line| (*line == hello).then_some(()));
    bridge.say(HELLO);
    let peer = stage.peer(&[]);
    let contact = bridge.hear("contact", |line| is(line, "contact", 0).then(|| line.clone()));
    assert_eq!((&contact["deflection_mm"], &contact["strain"]), (&json!(2.0), &json!(0.0123)));
    assert_eq!((&contact["distance_mm"], &contact["distance_sd_mm"]), (&json!(50.0), &json!(0.5)));
    let reading =
        bridge.hear("pressure", |line| is(line, "pressure", 0).then(|| line["pressure_mpa"].as_f64().unwrap()));
    assert!((reading - 0.05).abs() < 1e-9, "{reading}");
    // Stamps of this machine's clock count.
    assert!(contact["t_us"].as_u64().is_some_and(|t_us| t_us > 1_600_000_000_000_000), "{contact}");
    let strain = bridge.hear("strain", |line| is(line, "strain", 0).then(|| line.clone()));
    assert_eq!((&strain["strain"], &strain["every_us"]), (&json!([0.001, 0.002, 0.003]), &json!(1000)));
    assert_eq!(strain["deflection_mm"], json!(2.0));
    bridge.hear("the state of the gauge", |line| (is(line, "fault", 0) && line["gauge"] == "OK").then_some(()));
    // The other whisker is silent, which must not pass as good health.
    bridge.hear("fault of the silent whisker", |line| is(line, "fault", 1).then_some(()));

    set_pressure(&mut bridge, 0.08);
    let mut setpoints: Vec<f64> = Vec::new();
    peer.hear("setpoint", |line| {
        setpoints.extend(line["setpoint_pa"].as_f64().map(|pa| (pa - ATMOSPHERE_PA) * 1e-6));
        assert!(line["frame_id"].is_null() || line["frame_id"] == "left-front/0", "{line}");
        setpoints.last().is_some_and(|last| (last - 0.08).abs() < 1e-6).then_some(())
    });
    // 0.03 MPa at 0.05 MPa/s: not in one step, and never beyond.
    assert!(setpoints.len() > 3 && setpoints.is_sorted(), "{setpoints:?}");
    assert!((0.05 - 1e-6..0.06).contains(&setpoints[0]), "{setpoints:?}");
    bridge.hear("the new pressure", |line| {
        let pressure = is(line, "pressure", 0).then(|| line["pressure_mpa"].as_f64().unwrap())?;
        ((pressure - 0.08).abs() < 1e-6).then_some(())
    });

    let estimate = json!({"type": "estimate", "array": "left-front", "whisker": 0, "length_mm": 54.2,
        "length_low_mm": 53.1, "length_high_mm": 55.3, "condition": "TRIMMED", "gain": [[0.5, 1.25]]});
    bridge.say(&estimate.to_string());
    let published = peer.hear("the estimate", |line| line["estimate"].as_array().cloned());
    assert!((published[0].as_f64().unwrap() - 0.0542).abs() < 1e-9, "{published:?}");
    assert_eq!(published[1..], [json!("TRIMMED"), json!([0.5]), json!([1.25])]);
    let report = peer.hear("a report of the cut", |line| {
        (line["report"]["vibrissa: left-front/0"][1] == "trimmed").then(|| line.clone())
    });
    assert_eq!(report["report"]["vibrissa: left-front/0"][0], 1);
    assert_eq!(report["report"]["vibrissa: left-front/0"][2], "crawler");
    assert_eq!(reported(&report, "vibrissa: left-front/0", "length_mm"), Some("54.2000"));
    assert_eq!(reported(&report, "vibrissa: left-front/0", "setpoint_mpa"), Some("0.0800"));
    assert_eq!(report["report"]["vibrissa: left-front/1"][0], 3, "{report}");

    drop(peer);
    bridge.hear("fault of a robot that is gone", |line| is(line, "fault", 0).then_some(()));
    bridge.hang_up();
    assert!(bridge.child.wait().unwrap().success());
}

#[test]
fn a_touch_test_is_an_action_of_the_robots_node() {
    let Some(stage) = Stage::make(4) else { return };
    let mut bridge = stage.bridge(&["--pressures", "absolute"]);
    bridge.say(HELLO);
    let peer = stage.peer(&[]);
    bridge.hear("a reading of the node", |line| is(line, "pressure", 0).then_some(()));
    let order = json!({"type": "test", "test_id": "t1", "array": "left-front", "whisker": 0, "kind": "WALL",
        "distances_mm": [50.0, 56.0], "deflections_mm": [2.0], "contacts": 2});
    bridge.say(&order.to_string());
    let goal = peer.hear("the goal", |line| line["goal"].as_array().cloned());
    assert_eq!(goal, [json!("t1"), json!(1), json!([0.05, 0.056]), json!(2)]);
    let state = |line: &Value| (line["test_id"] == "t1").then(|| line["state"].as_str().map(str::to_owned)).flatten();
    assert_eq!(bridge.hear("its begin", state), "RUNNING");
    let of_test = |line: &Value| (line["test_id"] == "t1" && line["type"] == "contact").then(|| line.clone());
    let (touch, missed) = (bridge.hear("a touch", of_test), bridge.hear("a missed touch", of_test));
    assert_eq!((&touch["strain"], &touch["touched"]), (&json!(0.0102), &Value::Null));
    assert_eq!((&touch["saturated"], &missed["saturated"]), (&json!(true), &Value::Null));
    assert_eq!(missed["touched"], json!(false));
    assert_eq!(bridge.hear("its end", state), "DONE");
}

#[test]
fn a_launch_file_starts_it_beside_an_agent_that_listens() {
    let Some(stage) = Stage::make(5) else { return };
    let folder = tempfile::tempdir().unwrap();
    let (socket, file) = (folder.path().join("driver.sock"), folder.path().join("launch_params"));
    let agent = UnixListener::bind(&socket).unwrap();
    let parameters = format!(
        "/**:\n  ros__parameters:\n    pressures: absolute\n    robot: crawler\n    agent: unix:{}\n",
        socket.display()
    );
    std::fs::write(&file, parameters).unwrap();
    let namespace = format!("__ns:={NAMESPACE}");
    let rules = ["-r", "__node:=vibrissa", "-r", &namespace, "-r", "contacts:=touches", "-r", "touches:=contacts"];
    let _bridge = stage.launched(&[&rules[..], &["--params-file", &file.display().to_string()]].concat());
    // The second connection is that of an agent that has started again.
    for pressure_mpa in [0.06, 0.07] {
        let (mut stream, _) = agent.accept().unwrap();
        let mut lines = BufReader::new(stream.try_clone().unwrap()).lines().map_while(Result::ok);
        let mut hear = |kind: &str| {
            let is_heard = |line: &String| serde_json::from_str::<Value>(line).unwrap()["type"] == kind;
            lines.find(is_heard).unwrap_or_else(|| panic!("no {kind}"))
        };
        assert!(hear("hello").contains("vibrissa-ros2"));
        writeln!(stream, "{HELLO}").unwrap();
        let peer = stage.peer(&[]);
        hear("pressure");
        let line = json!({"type": "set_pressure", "array": "left-front", "whisker": 0, "pressure_mpa": pressure_mpa,
            "slew_mpa_per_s": 0.05});
        writeln!(stream, "{line}").unwrap();
        peer.hear("the setpoint", |line| {
            let mpa = (line["setpoint_pa"].as_f64()? - ATMOSPHERE_PA) * 1e-6;
            ((mpa - pressure_mpa).abs() < 1e-6).then_some(())
        });
        // The topic of contacts has another name now.
        peer.hear("a report", |line| {
            let contacts = reported(line, "vibrissa: bridge", "contacts")?;
            assert_eq!(contacts, "0", "{line}");
            Some(())
        });
    }
    let peer = stage.peer(&["parameters"]);
    let parameters = peer.hear("parameters", |line| line["parameters"].as_array().cloned());
    assert_eq!(parameters, [json!("absolute"), json!(ATMOSPHERE_PA), json!("crawler")]);
}

#[test]
fn a_managed_node_moves_no_air_before_it_is_activated() {
    let Some(stage) = Stage::make(6) else { return };
    let mut bridge = stage.bridge(&["--pressures", "absolute", "--lifecycle"]);
    bridge.say(HELLO);
    let peer = stage.peer(&[]);
    // Its readings are not passed on, so the agent hears that they are missing.
    bridge.hear("the fault", |line| {
        assert!(line["type"] != "pressure" && line["type"] != "contact", "{line}");
        is(line, "fault", 0).then_some(())
    });
    let manager = stage.peer(&["lifecycle"]);
    let event = |start: &str, goal: &str| {
        let wanted = json!([start, goal]);
        manager.hear(goal, |line| (line["event"] == wanted).then_some(()));
    };
    event("configuring", "inactive");
    event("inactive", "activating");
    manager.hear("the state", |line| (line["state"] == "active").then_some(()));
    set_pressure(&mut bridge, 0.06);
    peer.hear("setpoint", |line| line["setpoint_pa"].as_f64());
}

#[test]
fn bad_messages_are_counted_and_stop_nothing() {
    let Some(stage) = Stage::make(1) else { return };
    let mut bridge = stage.bridge(&["--pressures", "absolute"]);
    bridge.say("nonsense");
    bridge.say(&format!("{{\"type\":\"{}\"}}", "x".repeat(70_000)));
    bridge.say(HELLO);
    let short = stage.peer(&["short"]);
    let peer = stage.peer(&[]);
    let refused = |line: &Value| reported(line, "vibrissa: bridge", "refused")?.parse::<u64>().ok();
    let is_named = |line: &Value, text: &str| {
        reported(line, "vibrissa: bridge", "last_problem").is_some_and(|problem| problem.contains(text)).then_some(())
    };
    // The two lines, and then contacts that end too early or have no strain.
    peer.hear("refusals", |line| (refused(line)? >= 5).then_some(()));
    peer.hear("an unreadable contact in a report", |line| is_named(line, "an unreadable contact"));
    drop(short);
    peer.hear("a contact without strain in a report", |line| is_named(line, "strain is NaN"));
    let logged: Vec<String> = bridge.errors.try_iter().collect();
    assert!(logged.iter().any(|line| line.contains("unreadable line")), "{logged:?}");
    assert!(logged.iter().any(|line| line.contains("more than 65536 bytes")), "{logged:?}");
    // Good messages still pass.
    bridge.hear("contact", |line| is(line, "contact", 0).then_some(()));
    set_pressure(&mut bridge, 0.06);
    peer.hear("setpoint", |line| line["setpoint_pa"].as_f64());
}

#[test]
fn the_meaning_of_pressures_must_be_chosen() {
    let Some(stage) = Stage::make(2) else { return };
    let mut bridge = stage.bridge(&[]);
    assert!(!bridge.child.wait().unwrap().success());
    assert!(bridge.errors.iter().any(|line| line.contains("--pressures")));
}
