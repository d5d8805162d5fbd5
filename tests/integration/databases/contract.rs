//! Rows are read back as they were written, with the same result on both databases.

use serde_json::{Value, json};
use vibrissa_edge::events::EventKind;
use vibrissa_store::actions::{Asked, NewAction};
use vibrissa_store::batch::{
    AlarmClearedRow, AlarmRow, CandidateRow, DecisionRow, EndedRow, ErrorBinRow, ErrorRow, HealthRow, Interval, Record,
    RefinementRow, ResponseRow, SetpointRow, SetpointStateRow, TouchTestProgressRow, TouchTestRow, TrimRow,
};
use vibrissa_store::events::Position;
use vibrissa_store::events::write::EventRow;
use vibrissa_store::list::{Filter, Value as FilterValue};
use vibrissa_store::lists::actions::{ACTIONS, ActionRow};
use vibrissa_store::lists::alarms::{ALARMS, AlarmRow as Alarm};
use vibrissa_store::lists::compensations::{
    CANDIDATES, COMPENSATIONS, Candidate, CompensationSummary, LOOKS, Look, RATIO_ERRORS, RatioError,
};
use vibrissa_store::lists::happenings::{TRIMS, Trim};
use vibrissa_store::lists::robots::{ROBOTS, RobotSummary};
use vibrissa_store::lists::touch_tests::{TOUCH_TESTS, TouchTest};
use vibrissa_store::lists::whiskers::{WHISKERS, Whisker};
use vibrissa_store::{Batch, Lease, Store, Writer};
use vibrissa_tests::actions::{asks, asks_of};

use crate::rows::{self, Numbered, contacts};
use crate::{Fresh, fleet, supervisor};

/// A touch test that goes on, and one that is rejected.
fn touch_tests(robot_id: i64, whisker_id: i64) -> Vec<Record> {
    let test = |number: usize, state| {
        Record::TouchTest(Box::new(TouchTestRow {
            test_id: format!("t{robot_id}-{number}"),
            robot_id,
            whisker_id,
            kind: "WALL",
            reason: "SUSPICION",
            contacts: 10,
            state,
            requested_us: 20,
        }))
    };
    let progress = |number: usize, state: Option<&'static str>, at_us: i64| TouchTestProgressRow {
        test_id: format!("t{robot_id}-{number}"),
        robot_id,
        updated_us: at_us,
        state,
        error: None,
        ended_us: None,
        touches: 0,
        missed: 0,
        length_mm: None,
        length_sd_mm: None,
    };
    let touched = |touches, missed, at_us| TouchTestProgressRow { touches, missed, ..progress(0, None, at_us) };
    let done = TouchTestProgressRow {
        ended_us: Some(25),
        length_mm: Some(65.0),
        length_sd_mm: Some(0.25),
        ..progress(0, Some("DONE"), 25)
    };
    let error = Some("NOT_READY");
    let rejected = TouchTestProgressRow { error, ended_us: Some(22), ..progress(1, Some("REJECTED"), 22) };
    let of_another_robot = TouchTestProgressRow { robot_id: robot_id + 1000, ..touched(100, 100, 99) };
    let rows = [
        progress(0, Some("ACCEPTED"), 21),
        progress(0, Some("RUNNING"), 22),
        touched(4, 1, 23),
        touched(3, 2, 24),
        of_another_robot,
        done,
        rejected,
    ];
    let rows = rows.into_iter().map(|row| Record::TouchTestProgress(Box::new(row)));
    [test(0, "PENDING"), test(1, "PENDING"), test(2, "PROPOSED")].into_iter().chain(rows).collect()
}

/// Events of a robot, of a whisker, and of the fleet.
pub(crate) fn events(numbered: &Numbered) -> Vec<EventRow> {
    let whisker_id = Some(numbered.whisker_ids[0]);
    let trim = EventRow { data: r#"{"trim":{"trim_id":7}}"#.to_owned(), ..EventRow::new(EventKind::Trim, 11) };
    let alarm = EventRow { word: Some("LEAK"), ..EventRow::new(EventKind::AlarmRaised, 12) };
    vec![
        EventRow { whisker_id, ..trim.of_robot(numbered.robot_id) },
        EventRow { whisker_id, ..alarm.of_robot(numbered.robot_id) },
        EventRow::new(EventKind::Policy, 13),
    ]
}

/// A record of every kind.
pub(crate) fn records(numbered: &Numbered) -> Vec<Record> {
    let (robot_id, whisker_id) = (numbered.robot_id, numbered.whisker_ids[0]);
    let command_id = format!("c{robot_id}");
    let compensation_id = robot_id << 32;
    let candidate = |index: usize, chosen, refused| CandidateRow {
        whisker_id: numbered.whisker_ids[index],
        case: if index == 0 { "SELF_COMPENSATION" } else { "SHORTER_FOR_LONGER" },
        length_mm: 65.0,
        length_sd_mm: 0.3,
        pressure_before_mpa: 0.1,
        pressure_mpa: (index == 0).then_some(0.048),
        predicted_error: (index == 0).then_some(0.203_85),
        predicted_error_interval: (index == 0).then_some((0.125, 0.375)),
        predicted_error_by_ratio: (index == 0).then(|| "[0.1,0.2]".to_owned()),
        gives_up_own_role: index == 1,
        chosen,
        refused,
    };
    let interval = |mean| Interval { mean, low: mean - 0.01, high: mean + 0.01 };
    let bin = |ratio| ErrorBinRow {
        ratio,
        contacts: 9,
        after_per_mm: 0.004,
        before_per_mm: 0.003,
        before_origin: "MEASURED",
        target_per_mm: 0.0035,
        target_origin: "MODEL",
        error: interval(0.2),
    };
    let health = |kind, was, becomes| Record::Health(HealthRow { whisker_id, recorded_us: 5, kind, was, becomes });
    let setpoint_state = |state, error, pressure_mpa| {
        Record::SetpointState(SetpointStateRow {
            command_id: command_id.clone(),
            robot_id: 0,
            recorded_us: 9,
            state,
            error,
            pressure_mpa,
        })
    };
    let decision = DecisionRow {
        compensation_id,
        robot_id,
        target_whisker_id: whisker_id,
        target_length_mm: 70.0,
        target_pressure_mpa: 0.1,
        decided_us: 7,
        approval: "AUTOMATIC",
        candidates: vec![candidate(0, true, None), candidate(1, false, Some("COSTS_MORE"))],
    };
    let setpoint = SetpointRow {
        command_id: command_id.clone(),
        robot_id,
        whisker_id,
        compensation_id: Some(compensation_id),
        epoch: 1,
        version: 1,
        robot_boot_id: "b1".to_owned(),
        pressure_mpa: 0.048,
        slew_mpa_per_s: 0.02,
        issued_us: 8,
        expires_us: 38_000_000,
        reason: "SELF_COMPENSATION",
        gain: Some("[[0.45,0.861]]".to_owned()),
    };
    let error = |recorded_us, mean, ratios: &[f64]| {
        Record::Error(Box::new(ErrorRow {
            compensation_id,
            recorded_us,
            contacts: 18,
            pressure_mpa: 0.048,
            error: interval(mean),
            with_gain: (recorded_us > 12).then_some(interval(0.02)),
            air_error: (recorded_us > 12).then_some(interval(0.6)),
            bins: ratios.iter().map(|&ratio| bin(ratio)).collect(),
        }))
    };
    let look = |contacts, outcome, best| {
        Record::Refinement(Box::new(RefinementRow {
            compensation_id,
            recorded_us: 14,
            contacts,
            outcome,
            pressure_from_mpa: 0.048,
            pressure_best_mpa: best,
            error: interval(0.2),
            error_best: best.map(|_| interval(0.15)),
            error_with_gain: 0.05,
            error_with_own_gain: 0.02,
            gain_published: best.is_some(),
        }))
    };
    let mut records = vec![
        health("CONDITION", Some("HEALTHY"), Some("SUSPECTED")),
        health("FAULT", None, Some("LEAK")),
        Record::Trim(TrimRow {
            trim_id: robot_id << 32 | 4,
            robot_id,
            whisker_id,
            detected_us: 6,
            length_before_mm: 70.0,
            length_after_mm: 65.1,
            length_after_sd_mm: 0.2,
            contacts_to_detect: 12,
            pressure_mpa: Some(0.05),
        }),
        Record::Decision(Box::new(decision)),
        Record::Setpoint(Box::new(setpoint)),
        setpoint_state("RECEIVED", None, None),
        setpoint_state("APPLIED", None, Some(0.0481)),
        error(12, 0.25, &[0.5]),
        error(13, 0.2, &[0.5, 0.9]),
        look(200, "REFINED", Some(0.041)),
        look(400, "HELD_UNPREDICTABLE", None),
        Record::Alarm(AlarmRow { whisker_id, raised_us: 14, kind: "UNCOMPENSATED" }),
        Record::Alarm(AlarmRow { whisker_id, raised_us: 14, kind: "PROPOSED" }),
        Record::AlarmCleared(AlarmClearedRow { whisker_id, cleared_us: 15, kind: "PROPOSED" }),
        Record::Approved { compensation_id },
        Record::Ended(EndedRow { compensation_id, ended_us: 15, end_reason: "REASSIGNED" }),
    ];
    records.extend(touch_tests(robot_id, whisker_id));
    records
}

/// A response of the compensator to a contact.
pub(crate) fn response(numbered: &Numbered) -> ResponseRow {
    ResponseRow {
        compensation_id: numbered.robot_id << 32,
        t_us: 11,
        ratio: 0.85,
        deflection_mm: 2.0,
        after_strain: 0.009,
        before_strain: 0.008,
        before_origin: "MEASURED",
        target_strain: 0.0085,
        target_origin: "MODEL",
    }
}

/// A request that is repeated with the same key, or used for another action; and an action that requested a test.
async fn mail(store: &Store, writer: &mut Writer, lease: &Lease) {
    let keyed = NewAction { idempotency_key: Some("k".to_owned()), ..asks_of("HOLD", "{}", Some(1)) };
    assert_eq!(store.ask(&keyed).await.unwrap(), Asked::New(1));
    // Without a key, equal actions are different ones.
    assert!(matches!(store.ask(&asks("POLICY", "{}")).await.unwrap(), Asked::New(_)));
    assert!(matches!(store.ask(&asks("POLICY", "{}")).await.unwrap(), Asked::New(_)));
    let known = store.action(1).await.unwrap().unwrap();
    assert_eq!(store.ask(&keyed).await.unwrap(), Asked::Again(known.clone()));
    let other = NewAction { whisker: Some(0), ..keyed };
    assert_eq!(store.ask(&other).await.unwrap(), Asked::Different(known));
    let records = vec![Record::TestOfAction { action_id: 1, robot_id: 1, test_id: "t1-0".to_owned() }];
    writer.commit(lease, &Batch { records, ..Batch::default() }).await.unwrap();
}

/// Everything that can be read, as JSON; `together` is the number of records per transaction.
pub(crate) async fn written_and_read(database: &Fresh, together: usize) -> Value {
    let (a, mut writer) = (supervisor("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let numbered = rows::robot(&mut writer, &lease).await;
    let mut records = records(&numbered).into_iter();
    let mut batch = contacts(&numbered, 0..2500);
    batch.events = events(&numbered);
    loop {
        batch.records = records.by_ref().take(together).collect();
        if records.len() == 0 {
            break;
        }
        writer.commit(&lease, &batch).await.unwrap();
        batch = Batch::default();
    }
    batch.responses = vec![response(&numbered)];
    writer.commit(&lease, &batch).await.unwrap();
    let store = &database.store;
    mail(store, &mut writer, &lease).await;
    let of_it = || Filter::Is("compensation_id", FilterValue::Whole(numbered.robot_id << 32));
    let tests_of_actions: Vec<Option<String>> =
        store.all::<ActionRow>(&ACTIONS, Vec::new()).await.unwrap().into_iter().map(|row| row.test_id).collect();
    let lengths = store.lengths("r", "left", 0, 500).await.unwrap();
    let events = store.events_after(Position::default()).await.unwrap();
    let events = events.into_iter().filter_map(|(_, event)| event);
    let events: Vec<_> = events.map(|one| json!([one.kind, one.word, one.robot, one.whisker, one.data])).collect();
    json!({
        "whiskers": store.all::<Whisker>(&WHISKERS, Vec::new()).await.unwrap(),
        "software": store.all::<RobotSummary>(&ROBOTS, Vec::new()).await.unwrap()[0].software,
        "compensations": store.all::<CompensationSummary>(&COMPENSATIONS, Vec::new()).await.unwrap(),
        "candidates": store.all::<Candidate>(&CANDIDATES, vec![of_it()]).await.unwrap(),
        "touch_tests": store.all::<TouchTest>(&TOUCH_TESTS, Vec::new()).await.unwrap(),
        "trims": store.all::<Trim>(&TRIMS, Vec::new()).await.unwrap(),
        "alarms": store.all::<Alarm>(&ALARMS, Vec::new()).await.unwrap(),
        "bins": store.all::<RatioError>(&RATIO_ERRORS, vec![of_it()]).await.unwrap(),
        "looks": store.all::<Look>(&LOOKS, vec![of_it()]).await.unwrap(),
        "lengths": lengths.iter().map(|one| json!([one.t_us, one.length_mm, one.pressure_mpa])).collect::<Vec<_>>(),
        "contacts": store.contact_count().await.unwrap(),
        "between": store.contacts_between(("r", "left", 0), 1_795_248_000_000_010, 1_795_248_000_500_019).await.unwrap(),
        "setpoint_states": store.setpoint_states().await.unwrap(),
        "measured": store.measured_contacts().await.unwrap(),
        "events": events,
        "health": store.health_changes().await.unwrap(),
        "setpoints": store.setpoint_history().await.unwrap(),
        "tests_of_actions": tests_of_actions,
    })
}

#[tokio::test]
async fn both_databases_give_back_the_same() {
    let lite = written_and_read(&Fresh::sqlite().await, usize::MAX).await;
    assert_eq!(lite["contacts"], 2500);
    assert_eq!(lite["between"], 10);
    assert_eq!(lite["whiskers"][1]["fault"], "LEAK");
    assert_eq!([&lite["whiskers"][0]["segmenter"], &lite["whiskers"][1]["segmenter"]], [&json!("NOISY"), &Value::Null]);
    assert_eq!(lite["software"], json!([{ "kind": "AGENT", "name": "vibrissa-robot", "version": "0.2.0" }]));
    assert_eq!(lite["whiskers"][1]["leak_low_per_s"], 1e-3);
    assert_eq!(lite["whiskers"][0]["erosion_high_mm_per_contact"], 0.006);
    assert_eq!(lite["whiskers"][0]["contacts_left"], 1000.0);
    assert_eq!(lite["whiskers"][0]["contacts_left_high"], Value::Null);
    assert_eq!(lite["compensations"][0]["measured_error"], 0.2, "the latest error must be shown");
    assert_eq!(lite["candidates"][1]["refused"], "COSTS_MORE");
    let decided = &lite["compensations"][0];
    assert_eq!((&decided["predicted_error_low"], &decided["predicted_error_high"]), (&json!(0.125), &json!(0.375)));
    assert_eq!(lite["candidates"][0]["predicted_error_high"], 0.375);
    assert_eq!(lite["candidates"][1]["predicted_error_high"], Value::Null);
    assert_eq!(decided["measured_error_with_gain"], 0.02);
    assert_eq!(decided["measured_air_error"], 0.6);
    assert_eq!(decided["held_pressure_mpa"], 0.048);
    assert_eq!((&decided["look_count"], &decided["last_look"]), (&json!(2), &json!("HELD_UNPREDICTABLE")));
    let looks = lite["looks"].as_array().unwrap();
    assert_eq!((&looks[0]["pressure_best_mpa"], &looks[1]["error_best"]), (&json!(0.041), &Value::Null));
    assert_eq!((&looks[0]["gain_published"], &looks[1]["gain_published"]), (&json!(true), &json!(false)));
    assert_eq!(lite["candidates"][0]["predicted_error_by_ratio"], json!([0.1, 0.2]));
    assert_eq!(lite["bins"].as_array().unwrap().len(), 2);
    assert_eq!(lite["setpoints"].as_array().unwrap().len(), 3);
    let named = lite["tests_of_actions"].as_array().unwrap().iter().filter(|one| !one.is_null());
    assert_eq!(named.collect::<Vec<_>>(), ["t1-0"]);
    let tests = lite["touch_tests"].as_array().unwrap();
    let test = |state: &str| tests.iter().find(|test| test["state"] == state).unwrap_or_else(|| panic!("{tests:#?}"));
    let done = test("DONE");
    assert_eq!((&done["touches"], &done["missed"], &done["contacts"]), (&json!(7), &json!(3), &json!(10)));
    assert_eq!((&done["length_mm"], &done["error"]), (&json!(65.0), &Value::Null));
    let half = (done["length_high_mm"].as_f64().unwrap() - done["length_low_mm"].as_f64().unwrap()) / 2.0;
    assert!((half - 1.96 * 0.25).abs() < 1e-4, "{half}");
    assert_eq!(test("REJECTED")["error"], "NOT_READY");
    assert_eq!((&test("PROPOSED")["ended_at"], &test("PROPOSED")["length_mm"]), (&Value::Null, &Value::Null));
    for list in ["trims", "lengths", "health", "events"] {
        assert!(!lite[list].as_array().unwrap().is_empty(), "{list}");
    }
    // One record at a time is written by PostgreSQL's single statement for all kinds. All records together refer to
    // rows of the same transaction.
    for together in [usize::MAX, 1, 5] {
        assert_eq!(lite, written_and_read(&Fresh::postgres().await, together).await, "{together} records at a time");
    }
}

/// PostgreSQL returns `ratio` and `strain` of a contact with the same bits, and `residual` as an equal number or NULL.
#[tokio::test]
async fn contacts_are_the_same_to_the_last_bit() {
    use sqlx::{ConnectOptions, Row};
    let database = Fresh::postgres().await;
    let (a, mut writer) = (supervisor("a"), database.store.writer());
    writer.sign_in(&a, &[]).await.unwrap();
    let lease = writer.acquire(&a, &fleet()).await.unwrap().unwrap();
    let numbered = rows::robot(&mut writer, &lease).await;
    let batch = contacts(&numbered, 0..2);
    writer.commit(&lease, &batch).await.unwrap();
    let mut link = database.server.as_ref().unwrap().connect().connect().await.unwrap();
    let rows = sqlx::query("SELECT ratio, strain, residual, temperature_c FROM contacts ORDER BY seq")
        .fetch_all(&mut link)
        .await
        .unwrap();
    assert_eq!(rows.len(), 2);
    for (row, sent) in rows.iter().zip(&batch.contacts) {
        assert_eq!(row.get::<f64, _>("ratio").to_bits(), sent.ratio.unwrap().to_bits());
        assert_eq!(row.get::<f64, _>("strain").to_bits(), sent.strain.to_bits());
        assert_eq!(row.get::<Option<f64>, _>("residual"), sent.residual);
    }
}

/// If states were stored outside their rows (TOAST), repeated updates would grow a table that is not vacuumed in time.
#[tokio::test]
async fn regress_states_that_are_written_again_and_again_take_no_more_room() {
    let database = Fresh::postgres().await;
    let mut writer = database.store.writer();
    let own = supervisor("a");
    writer.sign_in(&own, &[]).await.unwrap();
    let lease = writer.acquire(&own, &fleet()).await.unwrap().unwrap();
    let robot = rows::robot(&mut writer, &lease).await;
    let server = database.server.as_ref().unwrap();
    let mut link = sqlx::ConnectOptions::connect(&server.connect()).await.unwrap();
    sqlx::query("ALTER TABLE whiskers SET (autovacuum_enabled = false, toast.autovacuum_enabled = false)")
        .execute(&mut link)
        .await
        .unwrap();
    for _ in 0..200 {
        let mut states = rows::states(&robot);
        // PostgreSQL moves values out of rows above 2 KB; long-serving compensators come close to that.
        states.whiskers.iter_mut().for_each(|whisker| whisker.state.resize(3000, 7));
        states.layouts.clear();
        writer.commit(&lease, &states).await.unwrap();
    }
    let bytes: i64 =
        sqlx::query_scalar("SELECT pg_total_relation_size('whiskers')").fetch_one(&mut link).await.unwrap();
    assert!(bytes < 300_000, "{bytes} bytes for two whiskers");
}
