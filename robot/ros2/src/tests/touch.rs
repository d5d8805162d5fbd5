//! Touch tests with a node that answers by script.

use std::collections::VecDeque;

use ros2_client::builtin_interfaces::Time;
use serde_json::json;

use super::{bridge, contact, say};
use crate::bridge::{Input, Output};
use crate::messages::{Contact, TouchTestGoal, TouchTestResult};
use crate::touch::{ActionServer, Progress, TouchTests};
use crate::units::Pressures;

/// A node; requests are numbered.
#[derive(Default)]
struct Scripted {
    is_found: bool,
    requests: u32,
    goals: Vec<TouchTestGoal>,
    cancelled: Vec<u32>,
    answers: VecDeque<(u32, bool)>,
    results: VecDeque<(u32, bool, TouchTestResult)>,
}

impl Scripted {
    fn number(&mut self) -> u32 {
        self.requests += 1;
        self.requests
    }
}

impl ActionServer for &mut Scripted {
    type Request = u32;
    type Goal = u32;

    fn is_found(&self) -> bool {
        self.is_found
    }

    fn send(&mut self, goal: TouchTestGoal) -> Result<(u32, u32), String> {
        self.goals.push(goal);
        let number = self.number();
        Ok((number, 100 + number))
    }

    fn ask_result(&mut self, _: u32) -> Result<u32, String> {
        Ok(self.number())
    }

    fn cancel(&mut self, goal: u32) {
        self.cancelled.push(goal);
    }

    fn answer(&mut self) -> Option<(u32, bool)> {
        if self.goals.is_empty() { None } else { self.answers.pop_front() }
    }

    fn result(&mut self) -> Option<(u32, bool, TouchTestResult)> {
        if self.goals.is_empty() { None } else { self.results.pop_front() }
    }
}

fn goal(test_id: &str) -> TouchTestGoal {
    TouchTestGoal {
        test_id: test_id.to_owned(),
        array: "left".to_owned(),
        whisker: 0,
        kind: 1,
        distances_m: vec![0.056],
        deflections_m: vec![0.0015],
        contacts: 2,
    }
}

fn result(contacts: Vec<Contact>, problem: &str) -> TouchTestResult {
    TouchTestResult { contacts, problem: problem.to_owned() }
}

/// The progress in inputs, by test.
fn progress(inputs: Vec<Input>) -> Vec<(String, Progress)> {
    let of = |input: Input| {
        let Input::Test(test_id, progress) = input else { panic!("{input:?}") };
        (test_id, progress)
    };
    inputs.into_iter().map(of).collect()
}

fn is_failed(got: &[(String, Progress)], id: &str, text: &str) -> bool {
    matches!(got, [(test_id, Progress::Failed(problem))] if test_id == id && problem.contains(text))
}

/// The tests `names`, begun at 0 s with a node that is found then. Their goals are sent from 1 s on.
fn begun<'a>(node: &'a mut Scripted, names: &[&str]) -> TouchTests<&'a mut Scripted> {
    let mut tests = TouchTests::new(node);
    names.iter().for_each(|name| tests.begin(0.0, goal(name)));
    assert!(tests.step(0.0).is_empty());
    assert!(tests.step(0.9).is_empty(), "the node may not have found this program");
    tests
}

#[test]
fn two_tests_run_beside_each_other() {
    let mut node = Scripted { is_found: true, ..Scripted::default() };
    // The requests have the numbers 1 and 2; the one for the result of the second goal has 3, that of the first one 4.
    node.answers = [(9, true), (2, true)].into();
    let mut tests = begun(&mut node, &["a", "b"]);
    assert_eq!(progress(tests.step(1.0)), [("b".to_owned(), Progress::Running)]);
    let mut node = Scripted { is_found: true, ..Scripted::default() };
    node.answers = [(1, true), (2, true)].into();
    node.results = [(4, true, result(vec![contact()], "")), (3, false, result(vec![], "the wall is gone"))].into();
    let mut tests = begun(&mut node, &["a", "b"]);
    let got = progress(tests.step(1.0));
    let of =
        |id: &str| got.iter().filter(|(test_id, _)| test_id == id).map(|(_, progress)| progress).collect::<Vec<_>>();
    assert!(
        matches!(of("a")[..], [Progress::Running, Progress::Failed(problem)] if problem.contains("the wall is gone"))
    );
    assert_eq!(of("b"), [&Progress::Running, &Progress::Done { contacts: vec![contact()], took_s: 1.0 }]);
    assert!(tests.step(2.0).is_empty());
}

#[test]
fn a_test_without_a_node_fails_and_so_does_one_that_is_not_finished() {
    let mut node = Scripted::default();
    let mut tests = TouchTests::new(&mut node);
    tests.begin(0.0, goal("a"));
    assert!(tests.step(4.9).is_empty());
    assert!(is_failed(&progress(tests.step(5.0)), "a", "no node serves"));
    assert!(node.goals.is_empty(), "a goal that is sent to nobody might be done later");

    let mut node = Scripted { is_found: true, ..Scripted::default() };
    let mut tests = begun(&mut node, &["a"]);
    assert!(tests.step(3.0).is_empty());
    assert!(is_failed(&progress(tests.step(8.0)), "a", "does not answer"));
    assert_eq!((node.goals.len(), &node.cancelled[..]), (1, &[101][..]));

    let mut node = Scripted { is_found: true, answers: [(1, false)].into(), ..Scripted::default() };
    let mut tests = begun(&mut node, &["a"]);
    assert!(is_failed(&progress(tests.step(1.0)), "a", "rejected"));

    let mut node = Scripted { is_found: true, answers: [(1, true)].into(), ..Scripted::default() };
    let mut tests = begun(&mut node, &["a"]);
    assert_eq!(tests.step(1.0).len(), 1);
    // 30 s and 5 s for each touch: the agent gives no more.
    assert!(tests.step(39.9).is_empty());
    assert!(is_failed(&progress(tests.step(40.0)), "a", "not finished it in time"));
    assert_eq!(node.cancelled, [101]);
}

#[test]
fn an_order_becomes_a_goal_and_its_progress_lines() {
    let mut bridge = bridge(Pressures::Gauge);
    let order = json!({"type": "test", "test_id": "t1", "array": "left", "whisker": 0, "kind": "TIP",
        "distances_mm": [56.0, 63.0], "deflections_mm": [1.5], "contacts": 2});
    let outputs = say(&mut bridge, 0.0, &order);
    let [Output::Test(sent)] = &outputs[..] else { panic!("{outputs:?}") };
    assert_eq!((sent.test_id.as_str(), sent.kind, sent.contacts), ("t1", 2, 2));
    assert!((sent.distances_m[1] - 0.063).abs() < 1e-12 && (sent.deflections_m[0] - 0.0015).abs() < 1e-12, "{sent:?}");
    let mut unknown = order.clone();
    unknown["kind"] = json!("SWEEP");
    assert!(matches!(&say(&mut bridge, 0.0, &unknown)[..], [Output::Log(_)]));

    let mut lines = |progress: Progress| {
        let outputs = bridge.step(0.0, Time::new(100, 0), Input::Test("t1".to_owned(), progress));
        let line = |output: &Output| {
            let Output::Line(line) = output else { return None };
            Some(serde_json::to_value(line).expect("JSON"))
        };
        outputs.iter().filter_map(line).collect::<Vec<_>>()
    };
    let state = |state: &str| json!({"type": "test_state", "test_id": "t1", "state": state});
    assert_eq!(lines(Progress::Running), [state("RUNNING")]);
    assert_eq!(lines(Progress::Failed("a reason".to_owned())), [state("FAILED")]);
    // The contacts come before the end; the stamp of the first one is as old as the test.
    let mut old = contact();
    old.header.stamp = Time::new(70, 0);
    let missed = Contact { missed: true, ..contact() };
    let bad = Contact { whisker: 7, ..contact() };
    let done = lines(Progress::Done { contacts: vec![old, missed, bad], took_s: 25.0 });
    assert_eq!(done.len(), 3, "{done:?}");
    assert_eq!((&done[0]["test_id"], &done[0]["t_us"]), (&json!("t1"), &json!(70_000_000)));
    assert_eq!(done[1]["touched"], json!(false));
    assert_eq!(done[2], state("DONE"));
}
