//! A robot that publishes its sensors as standard messages, and has never heard of whiskers.

use serde_json::{Value, json};

use crate::stage::Stage;

const HELLO: &str = r#"{"type":"hello","version":1,"whiskers":[{"array":"left","whisker":0,"pressure_mpa":0.08,"pressure_max_mpa":0.2},{"array":"left","whisker":1,"pressure_mpa":0.05,"pressure_max_mpa":0.2}]}"#;

const MAPPING: &str = r#"
whiskers:
  left/0:
    strain: {topic: /gauges, type: std_msgs/msg/Float32MultiArray, field: "data[1]", scale: 0.01}
    deflection: {topic: /joint_states, type: sensor_msgs/msg/JointState, field: "position[slide_0]"}
    pressure: {topic: /chamber, type: std_msgs/msg/Float64, field: data, scale: 100000}
    regulator: {topic: /valves, type: diagnostic_msgs/msg/DiagnosticArray, field: "status[valve].values[level].value"}
    setpoint: {topic: /valve_command, type: std_msgs/msg/Float64, field: data, scale: 100000}
  left/1:
    strain: {topic: /wrench, type: geometry_msgs/msg/WrenchStamped, field: wrench.torque.y, scale: 0.001, offset: -0.004}
    pressure: {constant: 50000}
    distance: {topic: /nowhere, type: geometry_msgs/msg/PointStamped, field: point.x}
"#;

fn number(line: &Value, kind: &str, whisker: u16, field: &str) -> Option<f64> {
    (line["type"] == kind && line["whisker"] == whisker).then(|| line[field].as_f64()).flatten()
}

#[test]
fn values_of_standard_messages_reach_the_agent_and_its_setpoint_a_mapped_topic() {
    let Some(stage) = Stage::make(7) else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mapping.yaml");
    std::fs::write(&file, MAPPING).unwrap();
    let mut bridge = stage.bridge(&["--pressures", "gauge", "--mapping", &file.display().to_string()]);
    bridge.say(HELLO);
    let robot = stage.peer(&["sensors"]);
    let near = |value: f64, expected: f64| (value - expected).abs() < 1e-9;
    for (kind, whisker, field, expected) in [
        ("strain", 0, "strain", 0.0025),
        ("motion", 0, "deflection_mm", 2.1),
        ("pressure", 0, "pressure_mpa", 0.08),
        ("strain", 1, "strain", 0.001),
        ("pressure", 1, "pressure_mpa", 0.05),
    ] {
        let value = bridge.hear(kind, |line| number(line, kind, whisker, field));
        assert!(near(value, expected), "{kind} {whisker}: {value}");
    }
    let stamped = bridge.hear("a stamped motion", |line| (line["type"] == "motion").then(|| line["t_us"].as_u64()));
    assert!(stamped.is_some_and(|t_us| t_us > 1_600_000_000_000_000), "{stamped:?}");
    // Level 2, in a text.
    bridge.hear("the fault of the valve", |line| {
        (line["type"] == "pressure" && line["whisker"] == 0 && line["regulator"] == "FAULT").then_some(())
    });
    let order =
        json!({"type": "set_pressure", "array": "left", "whisker": 0, "pressure_mpa": 0.1, "slew_mpa_per_s": 1.0});
    let of_passive =
        json!({"type": "set_pressure", "array": "left", "whisker": 1, "pressure_mpa": 0.06, "slew_mpa_per_s": 1.0});
    bridge.say(&order.to_string());
    let mut bars: Vec<f64> = Vec::new();
    robot.hear("setpoints up to 1 bar", |line| {
        bars.extend(line["setpoint"].as_f64());
        bars.last().is_some_and(|bar| near(*bar, 1.0)).then_some(())
    });
    assert!(bars.is_sorted() && bars[0] >= 0.8 - 1e-9, "{bars:?}");
    // The order that nothing can set is named, and the topic that never comes.
    let report = stage.peer(&[]);
    report.hear("a report", |line| line["report"]["vibrissa: left/1"][1].as_str().map(str::to_owned));
    bridge.say(&of_passive.to_string());
    report.hear("the order without a setpoint", |line| {
        let message = line["report"]["vibrissa: left/1"][1].as_str()?;
        (message == "the agent orders 0.0600 MPa, and the mapping has no setpoint for it").then_some(())
    });
    report.hear("the silent topic", |line| {
        let message = line["report"]["vibrissa: bridge"][1].as_str()?;
        message.contains("s from /nowhere (geometry_msgs/msg/PointStamped): is it published").then_some(())
    });
}

#[test]
fn a_wrong_mapping_ends_the_program_with_line_and_key() {
    let Some(stage) = Stage::make(7) else { return };
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("mapping.yaml");
    std::fs::write(&file, MAPPING.replace("position[slide_0]", "positon[slide_0]")).unwrap();
    let mut bridge = stage.bridge(&["--pressures", "gauge", "--mapping", &file.display().to_string()]);
    assert!(!bridge.child.wait().unwrap().success());
    let wanted =
        "line 5: whiskers.left/0.deflection.field: sensor_msgs/JointState has no field positon; it has header, name,";
    let said: Vec<String> = bridge.errors.iter().collect();
    assert!(said.iter().any(|line| line.contains(wanted)), "{said:?}");
}
