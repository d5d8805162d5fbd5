//! Arguments of ROS, with cases of rcl's own tests and of what launch files write.

use clap::Parser;

use crate::lifecycle::Activity;
use crate::link::AgentAddress;
use crate::options::{Arguments, Options};
use crate::params::{Override, overrides};
use crate::remap::{Names, Rule};
use crate::ros_args::{RosArguments, split};
use crate::units::Pressures;

fn words(line: &str) -> Vec<String> {
    line.split_whitespace().map(str::to_owned).collect()
}

fn options(line: &str) -> Result<Options, String> {
    let (own, ros) = split(words(line));
    let own = std::iter::once("vibrissa-ros2".to_owned()).chain(own);
    let arguments = Arguments::try_parse_from(own).map_err(|problem| problem.to_string())?;
    Options::new(arguments, &ros, |_| String::new())
}

fn names(namespace: &str, rules: &[&str]) -> Names {
    let rules = rules.iter().map(|rule| Rule::parse(rule).expect("a rule")).collect();
    Names::new(namespace, "vibrissa", rules).expect("names")
}

#[test]
fn words_of_ros_stand_between_ros_args_and_two_hyphens() {
    let cases = [
        ("", "", ""),
        ("--localhost", "--localhost", ""),
        ("--ros-args", "", ""),
        ("--ros-args --", "", ""),
        ("--ros-args -r a:=b", "", "-r a:=b"),
        ("--localhost --ros-args -r a:=b -- --robot x", "--localhost --robot x", "-r a:=b"),
        ("--ros-args -r a:=b -- x --ros-args -p c:=1", "x", "-r a:=b -p c:=1"),
        ("--ros-args --ros-args -r a:=b", "", "-r a:=b"),
    ];
    for (line, own, ros) in cases {
        assert_eq!(split(words(line)), (words(own), words(ros)), "{line}");
    }
}

#[test]
fn unknown_and_unfinished_words_are_refused() {
    let cases = [
        ("-r", "-r needs from:=to"),
        ("--remap", "needs from:=to"),
        ("-p", "needs name:=value"),
        ("--params-file", "needs a file"),
        ("--log-level", "needs a level"),
        ("--log-level loud", "give one of UNSET, DEBUG"),
        ("--log-config-file x", "no configuration"),
        ("--enclave /x", "SROS 2"),
        ("--unknown", "--unknown is unknown"),
        ("a:=b", "a:=b is unknown"),
    ];
    for (line, expected) in cases {
        let problem = RosArguments::read(&words(line)).expect_err(line);
        assert!(problem.contains(expected), "{line}: {problem}");
    }
    for line in ["--enable-rosout-logs --disable-stdout-logs --disable-external-lib-logs", ""] {
        assert_eq!(RosArguments::read(&words(line)), Ok(RosArguments::default()), "{line}");
    }
}

#[test]
fn rules_are_read_as_rcl_reads_them() {
    let valid = [
        "__node:=node_name",
        "node_name:__node:=node_name",
        "__name:=a",
        "__ns:=/foo",
        "__ns:=/",
        "old_node:__ns:=/ns",
        "foo:=bar",
        "~/foo:=~/bar",
        "/foo/bar:=bar",
        "foo:=/bar",
        "/foo123:=/bar123",
        "node:/foo123:=/bar123",
        "rostopic:///foo/bar:=baz",
        "rosservice://foo/bar:=baz",
        "node:rostopic://foo/bar:=baz",
        "foo:={node}/bar",
        "~:=foo",
    ];
    for rule in valid {
        assert!(Rule::parse(rule).is_ok(), "{rule}: {:?}", Rule::parse(rule));
    }
    let invalid = [
        "",
        ":=",
        "foo:=",
        ":=bar",
        "foo=bar",
        "foo:bar",
        "__ns:=",
        "__ns:=foo",
        "__ns:=/foo/",
        "__node:=",
        "__node:=/foo/bar",
        "__node:=1a",
        "nodename:1__ns:=/a",
        "1node:foo:=bar",
        "f{oo:=bar",
        "foo:=b-ar",
        "foo:=bar//x",
        "/foo__bar:=a",
        "foo/:=bar",
        "**:=bar",
        "foo:=~bar",
    ];
    for rule in invalid {
        assert!(Rule::parse(rule).is_err(), "{rule}");
    }
}

#[test]
fn names_are_expanded_and_replaced() {
    let of = |rules: &[&str], name: &str| names("/crawler", rules).topic(name).expect("a name");
    assert_eq!(of(&[], "contacts"), "/crawler/contacts");
    assert_eq!(of(&[], "/diagnostics"), "/diagnostics");
    assert_eq!(of(&["contacts:=touches"], "contacts"), "/crawler/touches");
    assert_eq!(of(&["contacts:=/touches"], "contacts"), "/touches");
    assert_eq!(of(&["contacts:=~/touches"], "contacts"), "/crawler/vibrissa/touches");
    assert_eq!(of(&["/crawler/contacts:=a"], "contacts"), "/crawler/a");
    assert_eq!(of(&["/diagnostics:=health"], "/diagnostics"), "/crawler/health");
    assert_eq!(of(&["left/whisker_3/pressure:=/sensors/p3"], "left/whisker_3/pressure"), "/sensors/p3");
    assert_eq!(of(&["contacts:={node}{ns}/x"], "contacts"), "/crawler/vibrissa/crawler/x");
    // The first rule that fits counts, and its result is not replaced again.
    assert_eq!(of(&["contacts:=a", "contacts:=b", "a:=c"], "contacts"), "/crawler/a");
    // Rules for another node, and for services, do not count.
    assert_eq!(of(&["other:contacts:=a", "rosservice://contacts:=b"], "contacts"), "/crawler/contacts");
    assert_eq!(of(&["vibrissa:contacts:=a"], "contacts"), "/crawler/a");
    let named = names("/crawler", &["rosservice://touch_test:=/arm/touch", "rostopic://touch_test:=x"]);
    assert_eq!(named.service("touch_test"), Ok("/arm/touch".to_owned()));
    // Relative names are below the namespace of the rule, and private ones below the new name.
    let moved = names("/crawler", &["__node:=bridge", "__ns:=/hall/b", "contacts:=~/a"]);
    assert_eq!((moved.namespace(), moved.node(), moved.full()), ("/hall/b", "bridge", "/hall/b/bridge".to_owned()));
    assert_eq!(moved.topic("contacts"), Ok("/hall/b/bridge/a".to_owned()));
    let root = names("/", &[]);
    assert_eq!((root.topic("contacts"), root.full()), (Ok("/contacts".to_owned()), "/vibrissa".to_owned()));
    assert!(Names::new("crawler", "vibrissa", Vec::new()).is_err());
}

#[test]
fn parameters_replace_options() {
    let told = options("--pressures gauge --robot a --ros-args -p pressures:=absolute -p atmosphere_pa:=90000")
        .expect("options");
    assert_eq!((told.settings.pressures, told.settings.robot.as_str()), (Pressures::Absolute(90_000.0), "a"));
    let told = options("--ros-args -p pressures:=gauge -p robot:=7 -p agent:=unix:/run/a.sock -r __ns:=/crawler");
    let told = told.expect("options");
    assert_eq!((told.settings.pressures, told.settings.robot.as_str()), (Pressures::Gauge, "7"));
    assert_eq!((told.agent, told.scope.names.namespace()), (AgentAddress::Unix("/run/a.sock".into()), "/crawler"));
    // The last value counts, and another node's does not.
    let told = options("--ros-args -p pressures:=gauge -p robot:=a -p robot:=b -p other:robot:=c -p vibrissa:robot:=d");
    assert_eq!(told.expect("options").settings.robot, "d");
    let told = options("--ros-args -p pressures:=gauge -p speed:=3 -p use_sim_time:=true").expect("options");
    assert_eq!(told.warnings.len(), 2, "{:?}", told.warnings);
    let told = options("--ros-args -p pressures:=gauge -p use_sim_time:=false -p lifecycle:=true").expect("options");
    assert_eq!((told.warnings.len(), told.settings.activity), (0, Activity::Idle));
    let wrong = [
        ("", "--pressures"),
        ("--ros-args -p pressures:=gauge -p lifecycle:=perhaps", "must be true or false"),
        ("--ros-args -p pressures:=maybe", "the parameter pressures is maybe"),
        ("--ros-args -p pressures:=gauge -p atmosphere_pa:=1", "30000 to 120000"),
        ("--ros-args -p pressures:=gauge -p agent:=somewhere", "neither unix:PATH nor tcp:IP:PORT"),
        ("--ros-args -p pressures:=gauge -p agent:=tcp:host:5", "neither unix:PATH nor tcp:IP:PORT"),
        ("--ros-args -p pressures", "no `:=`"),
        ("--ros-args -p :=1", "needs a name and a value"),
        ("--ros-args -p robot:=[", "has no value"),
        ("--ros-args --params-file /nowhere.yaml", "--params-file /nowhere.yaml"),
        ("--pressures gauge --agent-token-file /nowhere", "cannot read /nowhere"),
        ("--pressures gauge --mapping /nowhere.yaml", "the mapping /nowhere.yaml: "),
        ("--pressures gauge --ros-args -p mapping:=/nowhere.yaml", "the mapping /nowhere.yaml: "),
    ];
    for (line, expected) in wrong {
        let problem = options(line).expect_err(line);
        assert!(problem.contains(expected), "{line}: {problem}");
    }
}

#[test]
fn a_file_of_parameters_is_read_as_rcl_reads_it() {
    let text = "# by hand\n/**:\n  ros__parameters:\n    pressures: gauge  # Pa\n    'robot': \"a b\"\n    \
        nested: {depth: 3}\n/crawler:\n  vibrissa:\n    ros__parameters:\n      atmosphere_pa: 1.0e5\n";
    let read = overrides(text).expect("parameters");
    let of = |name: &str| read.iter().find(|one| one.name == name).map(|one| (one.node.as_str(), one.value.clone()));
    assert_eq!(of("pressures"), Some(("/**", "gauge".into())));
    assert_eq!(of("robot"), Some(("/**", "a b".into())));
    assert_eq!(of("nested.depth"), Some(("/**", 3.into())));
    assert_eq!(of("atmosphere_pa"), Some(("/crawler/vibrissa", 1.0e5.into())));
    for wrong in ["", "3", "a: 1", "ros__parameters:\n  a: 1", "a:\n  ros__parameters: 3", "a: [1", "a: &x {b: *x}"] {
        assert!(overrides(wrong).is_err(), "{wrong}");
    }
    assert_eq!(overrides("/**:\n  ros__parameters: {}\n"), Ok(Vec::<Override>::new()));
}

#[test]
fn parameters_of_a_file_count_for_the_nodes_that_it_names() {
    let folder = std::env::temp_dir().join(format!("vibrissa-ros2-params-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    let cases = [
        ("/**", true),
        ("/crawler/vibrissa", true),
        ("crawler/vibrissa", true),
        ("/*/vibrissa", true),
        ("/**/vibrissa", true),
        ("/crawler/*", true),
        ("/crawler/**", true),
        ("/*", false),
        ("/vibrissa", false),
        ("vibrissa", false),
        ("/other/vibrissa", false),
        ("/crawler/vibrissa/x", false),
    ];
    for (node, counts) in cases {
        // As launch_ros writes the parameters of Node(...).
        let file = folder.join("launch_params");
        std::fs::write(&file, format!("{node}:\n  ros__parameters:\n    robot: launched\n")).expect("a file");
        let file = file.display();
        let line = format!("--ros-args -r __node:=vibrissa -r __ns:=/crawler -p pressures:=gauge --params-file {file}");
        assert_eq!(options(&line).expect("options").settings.robot == "launched", counts, "{node}");
    }
    std::fs::remove_dir_all(&folder).expect("removed");
}

#[test]
fn levels_silence_warnings() {
    let logs = |line: &str| RosArguments::read(&words(line)).expect("words").logs_warnings("crawler.vibrissa");
    assert!(logs("") && logs("--log-level warn") && logs("--log-level DEBUG"));
    assert!(!logs("--log-level error") && !logs("--log-level FATAL"));
    assert!(logs("--log-level other:=error") && !logs("--log-level crawler.vibrissa:=error"));
    assert!(logs("--log-level error --log-level crawler.vibrissa:=info"));
}
