//! The lifecycle of a managed node.

use ros2_client::builtin_interfaces::Time;
use serde_json::json;

use super::{bridge, command, read, report, say, setpoints_pa, tick};
use crate::bridge::{Bridge, Input, Output};
use crate::lifecycle::{Activity, Lifecycle, Transition};
use crate::units::Pressures;
use crate::words::ToAgent;

fn change(lifecycle: &mut Lifecycle, id: u8, label: &str) -> Option<Vec<(u8, String, String)>> {
    let parts = lifecycle.change(&Transition { id, label: label.to_owned() })?;
    let part =
        |one: crate::lifecycle::TransitionDescription| (one.transition.id, one.start_state.label, one.goal_state.label);
    Some(parts.map(part).to_vec())
}

#[test]
fn a_node_goes_through_the_states_of_ros() {
    let mut node = Lifecycle::default();
    let part = |id: u8, start: &str, goal: &str| (id, start.to_owned(), goal.to_owned());
    assert_eq!((node.state().id, node.activity()), (1, Activity::Idle));
    assert_eq!(change(&mut node, 3, ""), None, "only a configured node can be activated");
    let configured = [part(1, "unconfigured", "configuring"), part(10, "configuring", "inactive")];
    assert_eq!(change(&mut node, 1, ""), Some(configured.to_vec()));
    assert_eq!(node.activity(), Activity::Listening);
    // A label counts before the number.
    assert_eq!(change(&mut node, 2, "activate").map(|parts| parts[1].clone()), Some(part(30, "activating", "active")));
    assert_eq!((node.state().label.as_str(), node.activity()), ("active", Activity::Active));
    let available: Vec<u8> = node.available().iter().map(|one| one.transition.id).collect();
    assert_eq!(available, [4, 7]);
    assert!(
        change(&mut node, 4, "").is_some() && change(&mut node, 2, "").is_some() && change(&mut node, 1, "").is_some()
    );
    assert!(change(&mut node, 0, "shutdown").is_some_and(|parts| parts[0].0 == 6));
    assert_eq!((node.state().label.as_str(), node.available().len()), ("finalized", 0));
    assert_eq!((Lifecycle::states().len(), Lifecycle::graph().len()), (11, 14));
}

fn switch(bridge: &mut Bridge, activity: Activity) {
    assert!(bridge.step(0.0, Time::new(1, 0), Input::Activity(activity)).is_empty());
}

#[test]
fn an_inactive_node_listens_and_an_unconfigured_one_does_nothing() {
    let mut bridge = bridge(Pressures::Gauge);
    switch(&mut bridge, Activity::Idle);
    command(&mut bridge, 0.0, 0.1);
    assert!(read(&mut bridge, 0.1, 50_000.0).is_empty());
    let outputs = tick(&mut bridge, 3.1);
    assert!(outputs.iter().any(|one| matches!(one, Output::Line(ToAgent::Fault { .. }))), "{outputs:?}");
    assert_eq!(report(outputs).status[0].message, "the node is not active: no setpoints");

    switch(&mut bridge, Activity::Listening);
    command(&mut bridge, 3.2, 0.1);
    assert!(matches!(&read(&mut bridge, 3.2, 50_000.0)[..], [Output::Line(ToAgent::Pressure { .. })]));
    assert!(setpoints_pa(&tick(&mut bridge, 3.3)).is_empty());
    let order = json!({"type": "test", "test_id": "t1", "array": "left", "whisker": 0, "kind": "TIP",
        "distances_mm": [56.0], "deflections_mm": [1.5], "contacts": 1});
    let outputs = say(&mut bridge, 3.4, &order);
    assert!(matches!(&outputs[..], [Output::Log(_), Output::Line(ToAgent::TestState { state: "FAILED", .. })]));

    // The first setpoint is the measured pressure, also after a pause.
    for at_s in [3.5, 5.5] {
        switch(&mut bridge, Activity::Active);
        read(&mut bridge, at_s, 50_000.0);
        let first = setpoints_pa(&tick(&mut bridge, at_s));
        assert!(matches!(first[..], [pa] if (pa - 50_000.0).abs() < 0.01), "{first:?}");
        tick(&mut bridge, at_s + 0.5);
        switch(&mut bridge, Activity::Listening);
        assert!(setpoints_pa(&tick(&mut bridge, at_s + 1.0)).is_empty());
    }
}
