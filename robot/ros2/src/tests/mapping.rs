//! Values of whiskers in topics that exist already.

use ros2_client::builtin_interfaces::Time;
use serde::de::DeserializeSeed;
use serde_json::{Value as Json, json};

use super::{command, report, say, setpoints_pa, tick};
use crate::bridge::{Bridge, Input, Output, Settings};
use crate::lifecycle::Activity;
use crate::mapping::{Definitions, Mapping, MessageSeed, Path, Value};
use crate::messages::{DiagnosticArray, Level};
use crate::units::Pressures;

/// Seconds since 1970 UTC.
const NOW_S: i32 = 1_795_248_000;
const NOW_US: u64 = 1_795_248_000_000_000;
/// The mapping of docs/ros2.md.
const DOCUMENT: &str = include_str!("../../../../docs/ros2.md");

/// The block of the document that begins with this line.
fn example() -> String {
    let begun = DOCUMENT.lines().skip_while(|line| *line != "# mapping.yaml");
    begun.take_while(|line| *line != "```").map(|line| format!("{line}\n")).collect()
}

fn parse(text: &str) -> Result<Mapping, String> {
    Mapping::parse(text, &Definitions::default())
}

fn bridge(mapping: &str, pressures: Pressures) -> Bridge {
    let mapping = Some(parse(mapping).expect("a mapping"));
    let mut bridge =
        Bridge::new(Settings { robot: "crawler".to_owned(), pressures, activity: Activity::Active, mapping });
    let whisker =
        |number: u16| json!({"array": "left", "whisker": number, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2});
    let hello = json!({"type": "hello", "version": 1, "whiskers": [whisker(0), whisker(1)]});
    assert!(matches!(&say(&mut bridge, 0.0, &hello)[..], [Output::Open(_)]));
    bridge
}

/// Lines of the bridge to an agent that starts anew.
fn said_again(bridge: &mut Bridge) -> Vec<Json> {
    let whiskers: Vec<Json> = (0..2)
        .map(|whisker| json!({"array": "left", "whisker": whisker, "pressure_mpa": 0.1, "pressure_max_mpa": 0.2}))
        .collect();
    lines(say(bridge, 2.0, &json!({"type": "hello", "version": 1, "whiskers": whiskers})))
}

/// A message of the mapped topic with this name, from its fields in their order.
fn message(bridge: &mut Bridge, now_s: f64, topic: &str, fields: &Json) -> Vec<Output> {
    let topics = &bridge.mapping().expect("a mapping").topics;
    let index = topics.iter().position(|one| one.topic == topic).expect("the topic");
    let message = MessageSeed(topics[index].layout.clone()).deserialize(fields).map_err(|problem| problem.to_string());
    bridge.step(now_s, Time::new(NOW_S, 0), Input::Mapped(index, message))
}

fn lines(outputs: Vec<Output>) -> Vec<Json> {
    let line = |output: Output| {
        let Output::Line(line) = output else { panic!("{output:?}") };
        serde_json::to_value(line).expect("JSON")
    };
    outputs.into_iter().map(line).collect()
}

fn summary(report: &DiagnosticArray, name: &str) -> (u8, String) {
    let status = report.status.iter().find(|one| one.name == name).expect("a status");
    (status.level, status.message.clone())
}

#[test]
fn the_example_of_the_document_gives_strain_motion_pressure_and_health() {
    let mut bridge = bridge(&example(), Pressures::Gauge);
    let stamp = json!([[NOW_S - 1, 500_000_000], "base"]);
    let joints = json!([stamp, ["wheel", "slide_0"], [9.0, 0.0021], [], []]);
    let moved = lines(message(&mut bridge, 1.0, "/joint_states", &joints));
    assert_eq!(moved[0]["type"], "motion");
    assert_eq!((&moved[0]["array"], &moved[0]["whisker"]), (&json!("left"), &json!(0)));
    assert_eq!(moved[0]["t_us"], json!(NOW_US - 500_000));
    assert!((moved[0]["deflection_mm"].as_f64().expect("a number") - 2.1).abs() < 1e-9, "{moved:?}");

    let gauges = json!([[[], 0], [12_300.0, -40.0]]);
    let strains = lines(message(&mut bridge, 1.1, "/gauges", &gauges));
    let strain = |line: &Json| line["strain"].as_f64().expect("a number");
    assert_eq!(strains.iter().map(|line| line["whisker"].as_u64()).collect::<Vec<_>>(), [Some(0), Some(1)]);
    assert!((strain(&strains[0]) - 0.0123).abs() < 1e-12 && (strain(&strains[1]) + 4e-5).abs() < 1e-12, "{strains:?}");
    assert_eq!(strains[0]["t_us"], json!(NOW_US), "a message without a stamp is of now");

    let chamber = json!([stamp, 80_000.0, 0.0]);
    let read = lines(message(&mut bridge, 1.2, "/chambers/p0", &chamber));
    assert_eq!((&read[0]["pressure_mpa"], &read[0]["t_us"]), (&json!(0.08), &json!(NOW_US - 500_000)));

    let diagnostics = |level: u8| json!([stamp, [[0, "fan", "", "", []], [level, "valve 1", "", "", []]]]);
    let fault = lines(message(&mut bridge, 1.3, "/diagnostics", &diagnostics(2)));
    assert_eq!(
        (&fault[0]["type"], &fault[0]["whisker"], &fault[0]["regulator"]),
        (&json!("fault"), &json!(1), &json!("FAULT"))
    );
    assert!(message(&mut bridge, 1.4, "/diagnostics", &diagnostics(2)).is_empty(), "unchanged");
    assert_eq!(lines(message(&mut bridge, 1.5, "/diagnostics", &diagnostics(1)))[0]["regulator"], "OK");
}

#[test]
fn regress_a_distance_of_a_silent_topic_goes_with_no_later_deflection() {
    let mapping = "whiskers:
  left/0:
    deflection: {topic: /way, type: std_msgs/msg/Float64, field: data}
    distance: {topic: /wall, type: std_msgs/msg/Float64, field: data}
    pressure: {constant: 0}
";
    let mut bridge = bridge(mapping, Pressures::Gauge);
    lines(message(&mut bridge, 1.0, "/wall", &json!([0.05])));
    let soon = lines(message(&mut bridge, 1.9, "/way", &json!([0.002])));
    assert_eq!((&soon[0]["deflection_mm"], &soon[0]["distance_mm"]), (&json!(2.0), &json!(50.0)));
    let late = lines(message(&mut bridge, 5.0, "/way", &json!([0.003])));
    assert_eq!(late[0]["deflection_mm"], json!(3.0));
    assert!(late[0].get("distance_mm").is_none(), "{late:?}");
    // It goes with the next deflection again, and makes no line of its own.
    assert!(message(&mut bridge, 6.0, "/wall", &json!([0.06])).is_empty());
    let again = lines(message(&mut bridge, 6.1, "/way", &json!([0.002])));
    assert_eq!(again[0]["distance_mm"], json!(60.0));
}

#[test]
fn contact_ratio_and_driving_are_mapped() {
    let text = "driving: {topic: /base, type: std_msgs/msg/Bool, field: data}
whiskers:
  left/0:
    ratio: {topic: /place, type: std_msgs/msg/Float64, field: data, scale: 0.01}
    deflection: {topic: /slide, type: std_msgs/msg/Float64, field: data}
    pressure: {constant: 100000}
";
    let mut bridge = bridge(text, Pressures::Gauge);
    let ratio = lines(message(&mut bridge, 1.0, "/place", &json!([80.0])));
    assert_eq!((&ratio[0]["type"], &ratio[0]["ratio"]), (&json!("motion"), &json!(0.8)));
    assert!(ratio[0].get("distance_mm").is_none(), "{ratio:?}");
    let moved = lines(message(&mut bridge, 1.1, "/slide", &json!([0.002])));
    assert_eq!((&moved[0]["deflection_mm"], &moved[0]["ratio"]), (&json!(2.0), &json!(0.8)));
    assert!(message(&mut bridge, 1.2, "/place", &json!([70.0])).is_empty(), "it goes with the deflection");
    let drives = |bridge: &mut Bridge, driving: bool| lines(message(bridge, 1.3, "/base", &json!([driving])));
    assert_eq!(drives(&mut bridge, true), [json!({"type": "driving", "driving": true})]);
    assert!(drives(&mut bridge, true).is_empty(), "unchanged");
    assert_eq!(drives(&mut bridge, false), [json!({"type": "driving", "driving": false})]);

    let list = "driving: {topic: /base, type: std_msgs/msg/Float64MultiArray, field: data}\nwhiskers:\n  left/0: {}\n";
    assert!(parse(list).is_err_and(|why| why.contains("line 3")), "the whisker has no value");
    let list = list.replace("{}", "{pressure: {constant: 1}}");
    assert!(parse(&list).is_err_and(|why| why.contains("driving.field")));
}

#[test]
fn a_robot_says_by_a_topic_that_it_is_in_a_task() {
    let text = "task: {topic: /busy, type: std_msgs/msg/Bool, field: data}
driving: {topic: /busy, type: std_msgs/msg/Bool, field: data}
whiskers:
  left/0:
    pressure: {constant: 100000}
";
    let mut bridge = bridge(text, Pressures::Gauge);
    let both = |busy: bool| [json!({"type": "driving", "driving": busy}), json!({"type": "task", "task": busy})];
    let mut says = |busy: bool| lines(message(&mut bridge, 1.0, "/busy", &json!([busy])));
    assert_eq!(says(true), both(true));
    assert!(says(true).is_empty(), "unchanged");
    assert_eq!(says(false), both(false));
    assert_eq!(says(true), both(true));
    // Before, a robot whose topic is published on a change only took setpoints in the middle of a task.
    assert_eq!(said_again(&mut bridge), both(true), "a new agent knows it, too");

    let list = "task: {topic: /busy, type: std_msgs/msg/Float64MultiArray, field: data}
whiskers:
  left/0: {pressure: {constant: 1}}
";
    assert!(parse(list).is_err_and(|why| why.contains("task.field")));
}

#[test]
fn a_mapped_setpoint_has_the_unit_of_its_field_and_others_get_none() {
    let text = "whiskers:
  left/0:
    pressure: {topic: /p, type: std_msgs/msg/Float64, field: data, scale: 100000}
    setpoint: {topic: /valve, type: std_msgs/msg/Float32, field: data, scale: 100000}
  left/1:
    pressure: {constant: 50000}
";
    let mut bridge = bridge(text, Pressures::Gauge);
    let order =
        json!({"type": "set_pressure", "array": "left", "whisker": 1, "pressure_mpa": 0.12, "slew_mpa_per_s": 1.0});
    command(&mut bridge, 1.0, 0.1);
    say(&mut bridge, 1.0, &order);
    let read_mpa = lines(message(&mut bridge, 1.0, "/p", &json!([1.0])))[0]["pressure_mpa"].as_f64();
    assert!(read_mpa.is_some_and(|mpa| (mpa - 0.1).abs() < 1e-9), "{read_mpa:?}");
    let outputs = tick(&mut bridge, 1.1);
    // In bar.
    assert!(matches!(setpoints_pa(&outputs)[..], [bar] if (bar - 1.0).abs() < 1e-9), "{outputs:?}");
    let is_of_1 = |output: &Output| matches!(output, Output::Setpoint(1, _));
    assert!(!outputs.iter().any(is_of_1), "{outputs:?}");
    // The constant reading, and the order that nobody can carry out.
    let constant = outputs.iter().filter_map(|output| {
        let Output::Line(line) = output else { return None };
        serde_json::to_value(line).ok()
    });
    let constant: Vec<Json> = constant.filter(|line| line["whisker"] == 1).collect();
    let read_mpa: Vec<_> = constant.iter().filter_map(|line| line["pressure_mpa"].as_f64()).collect();
    assert!(matches!(read_mpa[..], [mpa] if (mpa - 0.05).abs() < 1e-9), "{constant:?}");
    let (level, message) = summary(&report(outputs), "vibrissa: left/1");
    assert_eq!(level, Level::Warn as u8);
    assert_eq!(message, "the agent orders 0.1200 MPa, and the mapping has no setpoint for it");
}

#[test]
fn a_topic_that_never_comes_is_named_once_in_the_log_and_in_each_report() {
    let text = "whiskers: {left/0: {strain: {topic: /gauges, type: std_msgs/msg/Float64, field: data}}}";
    let mut bridge = bridge(text, Pressures::Gauge);
    let wanted = "no message for 10 s from /gauges (std_msgs/msg/Float64): is it published, with this type?";
    let logs = |outputs: &[Output]| outputs.iter().filter(|one| **one == Output::Log(wanted.to_owned())).count();
    assert_eq!(logs(&tick(&mut bridge, 9.9)), 0);
    let outputs = tick(&mut bridge, 10.0);
    assert_eq!(logs(&outputs), 1);
    assert_eq!(logs(&tick(&mut bridge, 10.1)), 0);
    let late = report(tick(&mut bridge, 11.1));
    assert_eq!(summary(&late, "vibrissa: bridge"), (Level::Warn as u8, wanted.replace("10 s", "11 s")));
    message(&mut bridge, 11.2, "/gauges", &json!([0.001]));
    assert_eq!(summary(&report(tick(&mut bridge, 12.2)), "vibrissa: bridge").0, Level::Ok as u8);
    // An unconfigured node does not listen.
    bridge.step(12.3, Time::new(NOW_S, 0), Input::Activity(Activity::Idle));
    assert!(!tick(&mut bridge, 40.0).iter().any(|one| matches!(one, Output::Log(_))));
    bridge.step(40.1, Time::new(NOW_S, 0), Input::Activity(Activity::Active));
    assert!(!tick(&mut bridge, 49.9).iter().any(|one| matches!(one, Output::Log(_))));
}

/// Each message of another node was a fault of the mapping, and a sign of life of the node that had gone.
#[test]
fn regress_a_topic_that_others_publish_too_is_no_sign_of_life_of_a_value() {
    let mut bridge = bridge(&example(), Pressures::Gauge);
    let stamp = json!([[NOW_S, 0], ""]);
    let of = |name: &str| json!([stamp, [[0, name, "", "", []]]]);
    assert_eq!(lines(message(&mut bridge, 0.0, "/diagnostics", &of("valve 1")))[0]["regulator"], "OK");
    let joints = |name: &str| json!([stamp, [name], [9.0], [], []]);
    assert_eq!(message(&mut bridge, 0.0, "/joint_states", &joints("slide_0")).len(), 1);
    let mut logs = Vec::new();
    for second in 1..=12 {
        let now_s = f64::from(second);
        for topic in ["/gauges", "/chambers/p0"] {
            let fields = if topic == "/gauges" { json!([[[], 0], [1.0, 1.0]]) } else { json!([stamp, 0.0, 0.0]) };
            message(&mut bridge, now_s, topic, &fields);
        }
        message(&mut bridge, now_s, "/wall", &json!([stamp, [0.1, 0.0, 0.0]]));
        assert_eq!(message(&mut bridge, now_s, "/diagnostics", &of("battery")), [], "no fault of the mapping");
        assert_eq!(message(&mut bridge, now_s, "/joint_states", &joints("wheel")), []);
        let log = |output| if let Output::Log(text) = output { Some((second, text)) } else { None };
        logs.extend(tick(&mut bridge, now_s).into_iter().filter_map(log));
    }
    let gone = |path: &str, topic: &str| {
        let text = "does its publisher run, and is the name right?";
        (10, format!("no {path} for 10 s in the messages of {topic}: {text}"))
    };
    logs.sort();
    let expected = [gone("position[slide_0]", "/joint_states"), gone("status[valve 1].level", "/diagnostics")];
    assert_eq!(logs, expected);
    assert_eq!(summary(&report(tick(&mut bridge, 13.0)), "vibrissa: bridge").0, Level::Warn as u8);
    assert!(message(&mut bridge, 13.1, "/diagnostics", &of("valve 1")).is_empty());
    assert_eq!(message(&mut bridge, 13.1, "/joint_states", &joints("slide_0")).len(), 1);
    assert_eq!(summary(&report(tick(&mut bridge, 14.2)), "vibrissa: bridge").0, Level::Ok as u8);
}

#[test]
fn a_list_of_samples_has_their_times_and_the_second_gauge() {
    let text = "whiskers:
  left/0:
    strain: {topic: /g, type: std_msgs/msg/Float64MultiArray, field: data, every_us: 1000, scale: 0.5}
";
    let mut bridge = bridge(text, Pressures::Gauge);
    let line = &lines(message(&mut bridge, 0.0, "/g", &json!([[[], 0], [0.002, 0.004, 0.006]])))[0];
    assert_eq!((&line["strain"], &line["every_us"]), (&json!([0.001, 0.002, 0.003]), &json!(1000)));
    assert_eq!(line["t_us"], json!(NOW_US - 2000), "the last sample is of now");
    let both = "whiskers:
  left/0:
    strain: {topic: /w, type: geometry_msgs/msg/WrenchStamped, field: wrench.force.x}
    strain_2: {topic: /w, type: geometry_msgs/msg/WrenchStamped, field: wrench.force.y, scale: -1}
";
    let mut bridge = self::bridge(both, Pressures::Gauge);
    let wrench = json!([[[0, 0], ""], [[0.001, 0.002, 0.0], [0.0, 0.0, 0.0]]]);
    let line = &lines(message(&mut bridge, 0.0, "/w", &wrench))[0];
    assert_eq!((&line["strain"], &line["strain_2"]), (&json!(0.001), &json!(-0.002)));
}

#[test]
fn messages_without_the_value_are_refused_and_stop_nothing() {
    let mut bridge = bridge(&example(), Pressures::Gauge);
    let problem = |outputs: Vec<Output>| match outputs.into_iter().next() {
        Some(Output::Log(problem)) => problem,
        other => panic!("{other:?}"),
    };
    let lacking = json!([[[0, 0], ""], ["wheel", "slide_0"], [9.0], [], []]);
    assert_eq!(
        problem(message(&mut bridge, 0.0, "/joint_states", &lacking)),
        "/joint_states: position[slide_0]: slide_0 is element 1, and the list has 1"
    );
    let short = json!([[[], 0], []]);
    assert_eq!(problem(message(&mut bridge, 0.0, "/gauges", &short)), "/gauges: data[0]: the list has 0 elements");
    let unreadable = problem(message(&mut bridge, 0.0, "/gauges", &json!([])));
    assert!(unreadable.ends_with("is its type std_msgs/msg/Float32MultiArray?"), "{unreadable}");
    let one = json!([[[], 0], [100.0]]);
    let outputs = message(&mut bridge, 0.1, "/gauges", &one);
    assert!(matches!(&outputs[..], [Output::Line(_), Output::Log(_)]), "the other whisker goes on: {outputs:?}");
}

#[test]
fn a_wrong_mapping_is_refused_with_its_line_its_key_and_what_is_allowed() {
    let source = |source: &str| format!("whiskers:\n  left/0:\n    strain: {source}\n");
    let float = "topic: /a, type: std_msgs/msg/Float64, field: data";
    let cases = [
        (source("{topic: /a, field: data}"), "line 3: whiskers.left/0.strain: `type` is missing"),
        (
            source("{topic: /a, type: std_msgs/Flot64, field: data}"),
            "line 3: whiskers.left/0.strain.type: the type std_msgs/msg/Flot64 is unknown. Built in are std_msgs/Header",
        ),
        (source("{topic: /a, type: my_msgs/msg/Gauge, field: x}"), "AMENT_PREFIX_PATH"),
        (
            source("{topic: /a, type: Float64, field: data}"),
            "Float64 is no type: write it as sensor_msgs/msg/JointState",
        ),
        (
            source("{topic: /a, type: sensor_msgs/msg/JointState, field: positon}"),
            "line 3: whiskers.left/0.strain.field: sensor_msgs/JointState has no field positon; it has header, name, position, velocity, effort",
        ),
        (
            source("{topic: /a, type: sensor_msgs/msg/JointState, field: position}"),
            "leads to a list: name one element, such as data[0], or give `every_us`",
        ),
        (
            source("{topic: /a, type: geometry_msgs/msg/WrenchStamped, field: wrench.force}"),
            "is geometry_msgs/Vector3 and no number; it has x, y, z",
        ),
        (source("{topic: /a, type: std_msgs/msg/Float64, field: 'data[0]'}"), "data of std_msgs/Float64 is no list"),
        (
            source("{topic: /a, type: std_msgs/msg/Float64MultiArray, field: 'data[a]'}"),
            "has no names: use a number in [a]",
        ),
        (source("{topic: /a, type: std_msgs/msg/Float64, field: 'data['}"), "the field data[ is no place"),
        (
            source(&format!("{{{float}, scale: 0}}")),
            "line 3: whiskers.left/0.strain.scale: is 0, but must be a finite number other than 0",
        ),
        (source(&format!("{{{float}, every_us: 10}}")), "every_us is 10, but must be 500 to 100000"),
        (source(&format!("{{{float}, gain: 2}}")), "unknown field"),
        ("whiskers:\n  left/0:\n    strian: {}\n".to_owned(), "strian"),
        (
            "whiskers:\n  left:\n    pressure: {constant: 0}\n".to_owned(),
            "whiskers.left: write array and number, as left/0",
        ),
        ("whiskers:\n  left/0: {}\n".to_owned(), "whiskers.left/0: has no value; allowed are strain, strain_2"),
        ("whiskers: {}\n".to_owned(), "whiskers: names no whisker"),
        ("whiskers:\n  left/0:\n    deflection: {constant: 0}\n".to_owned(), "`constant` is only for pressure"),
        (
            format!("whiskers:\n  left/0:\n    setpoint: {{{}}}\n", float.replace("Float64", "Int32")),
            "a setpoint is data of std_msgs/msg/Float64",
        ),
        (
            format!("whiskers:\n  left/0:\n    strain_2: {{{float}}}\n"),
            "line 3: whiskers.left/0.strain_2: needs strain, too",
        ),
        (
            format!("whiskers:\n  left/0: {{setpoint: &s {{{float}}}}}\n  left/1: {{setpoint: *s}}\n"),
            "has the setpoints of left/0 already",
        ),
        (
            format!("whiskers:\n  left/0: {{strain: {{{float}}}, deflection: {{{}}}}}\n", float.replace("64", "32")),
            "the topic /a has two types",
        ),
    ];
    for (text, expected) in cases {
        let problem = parse(&text).expect_err(&text);
        assert!(problem.contains(expected), "{text}{problem}");
        assert!(!problem.contains('\n'), "{problem}");
    }
}

#[test]
fn a_mapping_of_a_whisker_that_the_robot_lacks_ends_the_program() {
    let mapping = Some(parse("whiskers: {right/7: {pressure: {constant: 0}}}").expect("a mapping"));
    let settings = Settings { robot: String::new(), pressures: Pressures::Gauge, activity: Activity::Active, mapping };
    let hello =
        json!({"type": "hello", "version": 1, "whiskers": [{"array": "left", "whisker": 0, "pressure_max_mpa": 0.2}]});
    let outputs = say(&mut Bridge::new(settings), 0.0, &hello);
    let wanted = "the mapping names right/7, but agent.toml has left/0";
    assert_eq!(outputs, [Output::Stop(wanted.to_owned())]);
}

#[test]
fn a_definition_of_an_installed_ros_is_read_with_its_constants_lists_and_packages() {
    let folder = std::env::temp_dir().join(format!("vibrissa-ros2-definitions-{}", std::process::id()));
    let messages = folder.join("share/my_msgs/msg");
    std::fs::create_dir_all(&messages).expect("a folder");
    let gauge =
        "# A gauge.\nuint8 OK=0\nuint8 BAD = 1\nfloat32 gain 2.5  # a default\nstring<=8 name\nfloat64[3] raw\n";
    std::fs::write(messages.join("Gauge.msg"), gauge).expect("a file");
    std::fs::write(messages.join("Gauges.msg"), "Header header\nGauge[<=6] gauges\nmy_msgs/Gauge spare\nLoop loop\n")
        .expect("a file");
    std::fs::write(messages.join("Loop.msg"), "Loop loop\n").expect("a file");
    let definitions = Definitions::new(&format!("/nowhere:{}", folder.display()));
    let problem = definitions.layout("my_msgs/msg/Gauges").expect_err("a loop");
    assert!(problem.contains("more than 16 messages within each other"), "{problem}");
    std::fs::write(messages.join("Loop.msg"), "\n").expect("a file");
    let layout = definitions.layout("my_msgs/msg/Gauges").expect("a layout");
    let fields = json!([
        [[1, 2], "f"],
        [[2.0, "a", [1.0, 2.0, 3.0]], [2.0, "b", [4.0, 5.0, 6.0]]],
        [2.0, "c", [7.0, 8.0, 9.0]],
        [0]
    ]);
    let message: Value = MessageSeed(layout.clone()).deserialize(&fields).expect("a message");
    let number = |place: &str| Path::find(place, &layout).expect("a place").numbers(&message);
    assert_eq!(number("gauges[b].raw[2]"), Ok(Some(vec![6.0])));
    assert_eq!(number("gauges[0].raw"), Ok(Some(vec![1.0, 2.0, 3.0])));
    assert_eq!(number("spare.raw[0]"), Ok(Some(vec![7.0])));
    assert!(Path::find("spare.raw[3]", &layout).is_err_and(|problem| problem.contains("has 3 elements")));
    assert!(number("spare.name").is_err_and(|problem| problem == "spare.name: c is no number"));
    std::fs::remove_dir_all(&folder).expect("removal");
}
