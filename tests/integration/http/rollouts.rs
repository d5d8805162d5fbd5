//! Staged roll-outs: their rows, the errors that they compare, and their answers, on both databases.

use std::collections::BTreeMap;

use serde_json::{Value, json};
use vibrissa_core::rollout::place;
use vibrissa_protocol::Name;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::batch::Record;
use vibrissa_store::rollouts::{Compared, RolloutChange, RolloutEvent, RolloutRow};
use vibrissa_store::{Batch, Lease, Supervisor, Writer};
use vibrissa_tests::actions::policy_body;
use vibrissa_tests::web::send;

use crate::rows;
use crate::served::Served;

fn row(rollout_id: i64) -> RolloutRow {
    RolloutRow {
        rollout_id,
        fleet: "k".to_owned(),
        kind: "POLICY".to_owned(),
        change: r#"{"mode":"ADVISE"}"#.to_owned(),
        state: "RUNNING".to_owned(),
        stage: "FEW".to_owned(),
        place_max: i64::from(u32::MAX / 20),
        level: 0.05,
        robots: 20,
        looks: 0,
        compared: Compared::default(),
        started_us: rows::START_US,
        stage_us: rows::START_US,
        updated_us: rows::START_US,
        started_by: "ann".to_owned(),
        reason: None,
    }
}

fn event(event: &str, detail: &str) -> Option<RolloutEvent> {
    Some(RolloutEvent { event: event.to_owned(), actor: "supervisor".to_owned(), detail: detail.to_owned() })
}

/// The mean error of each robot, from the list of compensations.
async fn means(served: &Served) -> BTreeMap<String, f64> {
    let mut errors: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for one in served.all("/v1/compensations?fleet=k&limit=1000").await {
        let error = if one["compensator_whisker"].is_null() { Some(1.0) } else { one["measured_error"].as_f64() };
        errors.entry(one["robot"].as_str().unwrap().to_owned()).or_default().extend(error);
    }
    errors.retain(|_, values| !values.is_empty());
    errors.into_iter().map(|(robot, values)| (robot, values.iter().sum::<f64>() / values.len() as f64)).collect()
}

/// The owner of the fleet k, which has two robots.
async fn owner(served: &Served) -> (Writer, Lease) {
    let fleet = Name::new("k").unwrap();
    let supervisor = Supervisor {
        id: "k".into(),
        name: "supervisor k".to_owned(),
        fleets: vec![fleet.clone()],
        time_to_live: std::time::Duration::from_secs(600),
    };
    let mut writer = served.store.writer();
    writer.sign_in(&supervisor, &[]).await.unwrap();
    let lease = writer.acquire(&supervisor, &fleet).await.unwrap().unwrap();
    rows::robots(&mut writer, &lease).await;
    (writer, lease)
}

async fn write(
    (writer, lease): &mut (Writer, Lease),
    row: RolloutRow,
    event: Option<RolloutEvent>,
) -> Option<RolloutRow> {
    let records = vec![Record::Rollout(Box::new(RolloutChange { row, event }))];
    writer.commit(lease, &Batch { records, ..Batch::default() }).await.unwrap();
    writer.open_rollout(lease).await.unwrap()
}

async fn a_roll_out_is_written_read_compared_and_listed(served: &Served) {
    let mut owner = owner(served).await;
    let body = json!({ "policy": policy_body(&vibrissa_core::policy::PolicyParams::default()), "reason": "try it" });
    // Nothing owns the fleet here, so the action expires or stays pending; its row is what the roll-out refers to.
    let begun = send(served.http, "POST", "/v1/fleets/k/rollouts", &[], Some(&body)).await.unwrap();
    assert_eq!(begun.status, 202, "{}", begun.body);
    let begun = begun.json();
    assert_eq!((&begun["kind"], &begun["parameters"]["level"]), (&json!("ROLLOUT_START"), &json!(0.05)));
    assert_eq!(begun["parameters"]["change"]["expected_version"], 0);
    let id = begun["action_id"].as_i64().unwrap();

    let mut write = async |row, event| write(&mut owner, row, event).await;
    assert_eq!(write(row(id), event("STARTED", "try it")).await, Some(row(id)));
    let compared = Compared {
        probability: Some(0.25),
        changed_robots: 5,
        unchanged_robots: 90,
        changed_error: Some(0.125),
        unchanged_error: Some(0.5),
    };
    let later =
        RolloutRow { stage: "QUARTER".to_owned(), looks: 2, compared, updated_us: rows::START_US + 7, ..row(id) };
    assert_eq!(write(later.clone(), event("ADVANCED", "no difference")).await, Some(later.clone()));
    assert_eq!(write(later.clone(), None).await, Some(later.clone()), "numbers without an event");
    let detail = served.json(&format!("/v1/rollouts/{id}")).await;
    let events: Vec<&Value> = detail["events"].as_array().unwrap().iter().map(|one| &one["event"]).collect();
    assert_eq!(events, [&json!("ADVANCED"), &json!("STARTED")]);
    let rollout = &detail["rollout"];
    assert_eq!((&rollout["stage"], &rollout["change"]["mode"]), (&json!("QUARTER"), &json!("ADVISE")));
    assert_eq!((&rollout["probability"], &rollout["changed_error"]), (&json!(0.25), &json!(0.125)));
    assert_eq!(served.items("/v1/rollouts?fleet=k&state=RUNNING").await, std::slice::from_ref(rollout));
    assert_eq!(
        write(RolloutRow { state: "ROLLED_BACK".to_owned(), ..later }, event("ROLLED_BACK", "worse")).await,
        None
    );
    assert_eq!(served.items("/v1/rollouts?state=RUNNING").await, Vec::<Value>::new());

    let (mut read, lease) = (served.store.writer(), owner.1);
    let errors = read.errors_since(&lease, 0).await.unwrap();
    let expected = means(served).await;
    assert!(expected.len() == 2 && errors.len() == 2, "{expected:?} {errors:?}");
    for one in &errors {
        assert!((one.error - expected[&one.robot]).abs() < 1e-12, "{one:?} {expected:?}");
    }
    assert_eq!(read.errors_since(&lease, i64::MAX).await.unwrap(), []);
}

#[tokio::test]
async fn a_roll_out_is_written_read_compared_and_listed_on_sqlite() {
    a_roll_out_is_written_read_compared_and_listed(&Served::sqlite().await).await;
}

#[tokio::test]
async fn a_roll_out_is_written_read_compared_and_listed_on_postgres() {
    a_roll_out_is_written_read_compared_and_listed(&Served::postgres().await).await;
}

#[tokio::test]
async fn a_roll_out_that_is_not_valid_is_refused() {
    let served = Served::sqlite().await;
    let policy = policy_body(&vibrissa_core::policy::PolicyParams::default());
    for (body, status, field) in [
        (json!({}), 422, "policy"),
        (json!({ "policy": policy, "calibration_id": 1 }), 422, "policy"),
        (json!({ "policy": policy, "level": 0.5 }), 422, "level"),
        (json!({ "policy": policy, "robots": 3 }), 422, "robots"),
    ] {
        let answer = send(served.http, "POST", "/v1/fleets/f/rollouts", &[], Some(&body)).await.unwrap();
        let problem = answer.json();
        assert_eq!((answer.status, &problem["errors"][0]["field"]), (status, &json!(field)), "{problem}");
    }
    let calibration = json!({ "calibration_id": 7 });
    let answer = send(served.http, "POST", "/v1/fleets/f/rollouts", &[], Some(&calibration)).await.unwrap();
    assert_eq!(answer.status, 404);
    assert_eq!(send(served.http, "POST", "/v1/rollouts/7/pause", &[], None).await.unwrap().status, 404);
}

/// Strain of a whisker by the model, 1/mm, at each contact ratio.
async fn modelled(served: &Served, robot: &str) -> Vec<Value> {
    let model = served.json(&format!("/v1/fleets/k/robots/{robot}/arrays/left/whiskers/0/model")).await;
    model["by_ratio"].as_array().unwrap().iter().map(|one| one["model_per_mm"].clone()).collect()
}

#[tokio::test]
async fn regress_a_robot_is_told_by_the_calibration_that_a_roll_out_gave_it() {
    let served = Served::sqlite().await;
    let mut owner = owner(&served).await;
    let before = (modelled(&served, "r1").await, modelled(&served, "r2").await);
    assert_eq!(before.0, before.1);
    let action = NewAction {
        fleet: Some("k".to_owned()),
        robot: None,
        array: None,
        whisker: None,
        compensation_id: None,
        alarm_id: None,
        kind: "ROLLOUT_START".to_owned(),
        parameters: "{}".to_owned(),
        reason: None,
        actor: "ann".to_owned(),
        role: "ENGINEER".to_owned(),
        request_id: "r".to_owned(),
        idempotency_key: None,
        asked_us: rows::START_US,
        expires_us: rows::START_US,
    };
    let Asked::New(rollout_id) = served.store.ask(&action).await.unwrap() else { panic!("a new action") };
    let [first, second] = ["r1", "r2"].map(|robot| place(rollout_id as u64, robot));
    let (changed, unchanged) = if first < second { ("r1", "r2") } else { ("r2", "r1") };
    let calibration = json!({ "name": "nguyen-2021", "c": 0.9, "a": 1.6234, "b_per_mpa": 9.3977,
                              "youngs_modulus_mpa": 1.1134, "elongation_gain_mm": 8.6766 });
    let running = RolloutRow {
        kind: "CALIBRATION".to_owned(),
        change: json!({ "calibration_id": 1, "calibration": calibration }).to_string(),
        place_max: i64::from(first.min(second)),
        ..row(rollout_id)
    };
    write(&mut owner, running.clone(), event("STARTED", "")).await;
    assert_ne!(modelled(&served, changed).await, before.0);
    assert_eq!(modelled(&served, unchanged).await, before.0);
    write(&mut owner, RolloutRow { state: "ROLLED_BACK".to_owned(), ..running }, event("ROLLED_BACK", "worse")).await;
    assert_eq!(modelled(&served, changed).await, before.0);
}
